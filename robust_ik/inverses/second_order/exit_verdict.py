"""Whether a command can be followed out of a configuration where it is lost: by the curvature, by a turn, or not.

Along kernel motions z the lost rows move by τ/2 K[z, z]; C = Σ cᵢKᵢ is the part along the command c. If C has a
positive eigenvalue, its eigenvector makes progress to second order, to either side; if C has none, the command leads
out of reach; if there is no curvature at all, a self-motion may turn what is lost, or nothing helps. Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from robust_ik.checks import Array
from robust_ik.inverses.second_order.weak_rows import WeakRows, upright
from robust_ik.kernels.second_order.second_order_layout import LEAST_TURN

BENT = 1e-3
"""|κ| relative to σ₁, 1/rad, up to which there is no curvature worth a name. A motion of 1 rad would move the tool by
half of it.
"""


class Exit(Enum):
    """How a command can be followed; the values are sentences."""

    FREE = "nothing that is asked for is lost here"
    FOLD = "the command leads back into reach: the joint motion, to either side, follows it"
    BOTH_WAYS = "the command and its opposite can both be followed, each by a joint motion of its own"
    TURN_FIRST = "the tool cannot move this way yet: turn the arm along a self-motion first"
    END_OF_REACH = "the command leads out of reach: joints nearby follow it hardly or not at all"
    STRUCTURAL = "neither curvature nor half a turn along a self-motion brings this motion back"


@dataclass(frozen=True, eq=False)
class ExitVerdict:
    """The verdict on a command.

    Attributes:
        exit: What it is.
        motion: The joint motion that leads out, or that turns first, of length 1, (n,); zero if there is none.
        curvature: The largest eigenvalue of C for a command of length 1, relative to σ₁, 1/rad.
        opposite: The smallest one.
        turning: How fast the lost command turns along the self-motion, 1/rad.
    """

    exit: Exit
    motion: Array
    curvature: float
    opposite: float
    turning: float


def exit_verdict(rows: WeakRows) -> ExitVerdict:
    """The verdict on the command of weak rows, as if their σ were 0."""
    size = float(np.linalg.norm(rows.command))
    nothing = np.zeros(rows.kernel.shape[0])
    if size == 0:
        return ExitVerdict(Exit.FREE, nothing, 0.0, 0.0, 0.0)
    values, vectors = np.linalg.eigh(rows.pull / size)
    curvature, opposite = float(values[-1]), float(values[0])
    rates, ways = np.zeros(1), np.zeros((1, rows.kernel.shape[1]))
    if rows.turning.size:
        _, rates, ways = np.linalg.svd(rows.turning)
    if curvature > BENT:
        kind = Exit.BOTH_WAYS if opposite < -BENT else Exit.FOLD
        motion = rows.kernel @ vectors[:, -1]
    elif opposite < -BENT:
        kind, motion = Exit.END_OF_REACH, nothing
    elif rates[0] > LEAST_TURN:
        kind, motion = Exit.TURN_FIRST, rows.kernel @ ways[0]
    else:
        kind, motion = Exit.STRUCTURAL, nothing
    return ExitVerdict(kind, motion * upright(motion), curvature, opposite, float(rates[0]))
