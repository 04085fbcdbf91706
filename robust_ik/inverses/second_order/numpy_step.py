"""A step of the second-order inverse in NumPy: the reference of the compiled one, and for sizes that have none."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.inverses.second_order.turning import Turn, unserved
from robust_ik.inverses.second_order.weak_motion import quartic, weak_motion
from robust_ik.inverses.second_order.weak_rows import weak_rows
from robust_ik.kinematics.svd import SMALLEST_SIGMA


@dataclass(frozen=True, eq=False)
class Remembered:
    """What a run remembers of its steps.

    Attributes:
        last: The last velocities, (n,).
        turn: What is remembered of a turn.
    """

    last: Array
    turn: Turn = field(default_factory=Turn)


def numpy_step(parameters: Array, J: Array, xdot: Array, H: Array, before: Remembered) -> Remembered:
    """What is remembered after a step, whose velocities are the last ones.

    Args:
        parameters: See `second_order_layout`: γ, speed, acceleration, horizon, speed of turns, time step.
        J: (m, n).
        xdot: ẋ, (m,).
        H: ∂J/∂q, (m, n, n).
        before: What is remembered before.

    Raises:
        InputError: Velocities are too large to be numbers.
    """
    gamma, speed, acceleration, horizon, turn_speed, dt = parameters.tolist()
    if np.abs(J).max() < SMALLEST_SIGMA:
        return Remembered(np.zeros(J.shape[1]), before.turn)
    with np.errstate(over="ignore", invalid="ignore"):
        rows = weak_rows(J, xdot, H, gamma)
    if not np.isfinite(rows.kept).all():
        raise InputError(TOO_FAST)
    if rows.sigma.size == 0 or rows.speed == 0:
        return Remembered(rows.kept, before.turn.after(xdot, 0.0, 0.0, dt))
    f = quartic(rows, speed, acceleration, horizon, dt)
    z = weak_motion(f, rows, before.last, speed)
    turn = before.turn.after(xdot, unserved(rows, f, z), f.curvature, dt)
    z, turn = turn.added(rows, f, z, turn_speed, dt)
    return Remembered(np.asarray(rows.kept + rows.kernel @ z), turn)


TOO_FAST = "the joint velocities are too large to be numbers"
