"""Size of an arm, and its unit of length: 1 m unless the arm is much larger or smaller than that."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.chain import Chain
from robust_ik.pose_ik.span import at_zero, find_span

SMALLEST, LARGEST = 0.2, 10.0
"""Arms from SMALLEST to LARGEST, m, are measured in metres. Chosen: papers state thresholds for arms of about 1 m."""
ROUNDING = 1e-6
"""Relative tolerance of both bounds: an arm that is just as large in a file must not fall outside by rounding."""
NOTHING = 1e-4
"""Links shorter than this fraction of all offsets, including the base's, are rounding errors of a wrist."""


def find_size(chain: Chain, lower: Array, upper: Array) -> float:
    """The distance that the links from the first axis to the frame span, m; 0 if no joint moves the frame's point.

    Sliding joints stay as close to zero as their limits allow. Their travel counts only as far as it brings the size of
    a chain of short links closer to a metre: a gantry is as large as its travel, an arm on a rail no larger than the
    arm.

    Args:
        chain: The joints that move the frame.
        lower: Limits of the robot's n joints, (n,).
        upper: The same.
    """
    if not len(chain):
        return 0.0
    low, high = lower[chain.column], upper[chain.column]
    at = np.where(chain.sliding, np.clip(0.0, low, high) * chain.factor + chain.shift, 0.0)
    offsets = float(offsets_of(chain).sum() + np.abs(at).sum())
    links = _links(chain, at, offsets) if offsets > 0 else 0.0
    moving = chain.sliding & (chain.factor != 0)  # a mimic joint of multiplier 0 does not move, whatever its range
    travel = float(np.sum(np.abs(chain.factor[moving]) * (high - low)[moving]))
    return float(min(max(links, 1.0), links + travel))


def is_usual(chain: Chain) -> bool:
    """Whether simple bounds show that a chain without sliding joints is of usual size; False if they leave it open.

    The links from the first axis on span at least the distance of the tip to any axis, and at most all offsets.
    """
    if not len(chain) or chain.sliding.any():
        return False
    axes, origins, tip = at_zero(chain, np.zeros(len(chain)))
    farthest = np.linalg.norm(np.cross(tip[:3, 3] - origins, axes), axis=1).max()
    return bool(farthest >= SMALLEST and offsets_of(chain)[1:].sum() <= LARGEST)


def offsets_of(chain: Chain) -> Array:
    """Lengths from the base to the first joint's origin, from each origin to the next, and to the frame, (c + 1,)."""
    return np.append(np.linalg.norm(chain.origins, axis=1), np.linalg.norm(chain.tip[:3, 3]))


def _links(chain: Chain, slid: Array, offsets: float) -> float:
    """The span with sliding joints held, computed in units of all offsets together; 0 if negligible in them."""
    tip, still = chain.tip.copy(), np.zeros(chain.n)
    tip[:3, 3] /= offsets
    held = replace(chain, origins=chain.origins / offsets, factor=np.zeros(len(chain)), shift=slid / offsets, tip=tip)
    share = find_span(held, still, still, oriented=False).distance
    return offsets * share if share > NOTHING else 0.0


def unit_of(size: float) -> float:
    """The length that stands for one metre, m, for an arm of this size, m.

    It is 1 m for sizes from 0.2 to 10 m and for an arm without a size. Else it is the power of two closest to the size.
    So nothing is rounded, and an arm behaves alike in any unit of length.
    """
    if size == 0.0 or SMALLEST * (1 - ROUNDING) <= size <= LARGEST * (1 + ROUNDING):
        return 1.0
    return math.ldexp(1.0, round(math.log2(size)))
