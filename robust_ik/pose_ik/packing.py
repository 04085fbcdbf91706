"""Packs a chain, its limits, the wanted rows and a table of starts into one vector for kernels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, readonly
from robust_ik.errors import InputError
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.pose_ik.span import find_span


def pack(chain: Chain, lower: Array, upper: Array, rows: tuple[str, ...]) -> Array:
    """The vector that kernels read, see `kernels.pose.pose_layout`.

    Raises:
        InputError: No joint moves the frame, too many do, or limits are reversed.
    """
    moving = np.unique(chain.column)
    _check(chain, moving, lower, upper)
    column = np.searchsorted(moving, chain.column)
    k = len(moving)
    own = replace(chain, n=k, nq=k, column=column, place=column, circling=np.zeros(len(chain), dtype=bool)).packed
    head, joints = np.zeros(lay.HEAD), np.zeros((k, lay.STRIDE))
    angular = [row for row in ROWS[3:] if row in rows]
    head[lay.COUNT], head[lay.LENGTH] = k, chain.nq
    head[lay.TURN] = (lay.NONE, lay.SINGLE, lay.SWING, lay.FULL)[len(angular)]
    head[lay.FREE] = next((i for i, row in enumerate(ROWS[3:]) if row not in angular), 0)
    head[lay.ROWS : lay.ROWS + 6] = [row in rows for row in ROWS]
    head[lay.SYMMETRIC], head[lay.SEEDS] = len(angular) == 3 and _symmetric(chain), lay.MOST_SEEDS
    span = find_span(chain, lower, upper, oriented=len(angular) == 3)
    head[lay.BOUND] = span.distance
    head[lay.CENTRE : lay.CENTRE + 3], head[lay.CARRIED : lay.CARRIED + 3] = span.centre, span.carried
    head[lay.CHAIN], head[lay.TABLE] = lay.HEAD + k * lay.STRIDE, lay.HEAD + k * lay.STRIDE + len(own)
    for row, joint in zip(joints, moving):
        row[:] = _joint(chain, joint, float(lower[joint]), float(upper[joint]))
    table = np.zeros((lay.FEATURES + k + 3) * lay.ENTRIES)
    problem = np.concatenate([head, joints.ravel(), own, table])
    from robust_ik.kernels.pose import fill_table

    fill_table(problem)
    return readonly(problem)


def _check(chain: Chain, moving: NDArray[np.int_], lower: Array, upper: Array) -> None:
    if not 0 < len(moving) <= lay.MOST or len(chain) > lay.MOST_CHAIN:
        raise InputError(
            f"solve_pose takes frames that 1 to {lay.MOST} independent joints move, by at most {lay.MOST_CHAIN} joints "
            f"in all; this one is moved by {len(moving)} and {len(chain)}"
        )
    reversed_ = np.flatnonzero(~(lower <= upper))
    if len(reversed_):
        j = int(reversed_[0])
        raise InputError(f"lower limits must be at most the upper ones, got {lower[j]:g} and {upper[j]:g} of joint {j}")


def _symmetric(chain: Chain) -> bool:
    """Whether the first joint alone turns the whole arm, and the last one alone turns the tool."""
    alone = [(chain.column == chain.column[i]).sum() == 1 for i in (0, -1)]
    return len(chain) > 1 and all(alone) and not chain.sliding[[0, -1]].any()


def _joint(chain: Chain, joint: int, lower: float, upper: float) -> list[float]:
    own = chain.column == joint
    at = int(np.argmax(own))
    periodic = not chain.sliding[own].any() and bool((np.abs(chain.factor[own]) == 1).all())
    half = 1.0 if chain.sliding[own].all() else math.pi
    low = lower if math.isfinite(lower) else upper - 2 * half if math.isfinite(upper) else -half
    high = upper if math.isfinite(upper) else lower + 2 * half if math.isfinite(lower) else half
    return [lower, upper, float(chain.place[at]), float(chain.circling[at]), float(periodic), low, high, 0.0]
