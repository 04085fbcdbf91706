"""How large an arm is, and the length that stands for one metre where it is much larger or smaller than that."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.chain import Chain
from robust_ik.pose_ik.span import at_zero, find_span

SMALLEST, LARGEST = 0.2, 10.0
"""Arms from one to the other, m, are measured in metres. Chosen: papers state thresholds for arms of about a metre."""
ROUNDING = 1e-6
"""Of both, relative: an arm that is just as large in a file must not fall outside by rounding."""
NOTHING = 1e-4
"""Links that are shorter than this share of all offsets, that of the base among them, are rounded ones of a wrist."""


def find_size(chain: Chain, lower: Array, upper: Array) -> float:
    """What the links from the first axis to the frame span, m; 0 where no joint moves the frame's point.

    Joints that slide stay where they are nearest zero. Their travel counts only as far as it makes the size of a chain
    of short links nearer to a metre: a gantry is as large as its travel, an arm on a rail no larger than the arm.

    Args:
        chain: What moves the frame.
        lower: Of the robot's n joints, (n,).
        upper: The same.
    """
    if not len(chain):
        return 0.0
    low, high = lower[chain.column], upper[chain.column]
    at = np.where(chain.sliding, np.clip(0.0, low, high) * chain.factor + chain.shift, 0.0)
    offsets = float(offsets_of(chain).sum() + np.abs(at).sum())
    links = _links(chain, at, offsets) if offsets > 0 else 0.0
    moving = chain.sliding & (chain.factor != 0)  # a mimic joint of multiplier 0 stays, whatever its range
    travel = float(np.sum(np.abs(chain.factor[moving]) * (high - low)[moving]))
    return float(min(max(links, 1.0), links + travel))


def is_usual(chain: Chain) -> bool:
    """Whether bounds alone tell that a chain without joints that slide is of usual size; False where they do not.

    The links from the first axis on span at least the distance of the tip to any axis, and at most all offsets.
    """
    if not len(chain) or chain.sliding.any():
        return False
    axes, origins, tip = at_zero(chain, np.zeros(len(chain)))
    farthest = np.linalg.norm(np.cross(tip[:3, 3] - origins, axes), axis=1).max()
    return bool(farthest >= SMALLEST and offsets_of(chain)[1:].sum() <= LARGEST)


def offsets_of(chain: Chain) -> Array:
    """Lengths from the base to the first joint's origin, from one to the next, and to the frame, (c + 1,)."""
    return np.append(np.linalg.norm(chain.origins, axis=1), np.linalg.norm(chain.tip[:3, 3]))


def _links(chain: Chain, slid: Array, offsets: float) -> float:
    """The span with slides held, found in units of all offsets together; 0 where it is but a trace of these."""
    tip, still = chain.tip.copy(), np.zeros(chain.n)
    tip[:3, 3] /= offsets
    held = replace(chain, origins=chain.origins / offsets, factor=np.zeros(len(chain)), shift=slid / offsets, tip=tip)
    share = find_span(held, still, still, oriented=False).distance
    return offsets * share if share > NOTHING else 0.0


def unit_of(size: float) -> float:
    """The length that stands for one metre with an arm of a size, m.

    It is 1 m from 0.2 to 10 m, and for an arm without a size. Else it is the power of two that is nearest to the size,
    so that nothing is rounded, and an arm does the same whatever its lengths are told in.
    """
    if size == 0.0 or SMALLEST * (1 - ROUNDING) <= size <= LARGEST * (1 + ROUNDING):
        return 1.0
    return math.ldexp(1.0, round(math.log2(size)))
