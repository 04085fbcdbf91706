"""The constants of a screw chain, read off a robot at zero. NumPy only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.errors import TipError

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

Mask = NDArray[np.bool_]


def constants(robot: Robot) -> tuple[Array, Mask, Array]:
    """What moves a robot's tip, as functions of the values of its independent joints.

    Args:
        robot: Any robot with a tip.

    Returns:
        Each joint's axis frame (z is the axis) in the one before with all values at zero, and the tip's in the last
        one, (c + 1, 4, 4); whether the joints slide, (c,); and their motions by the independent joints, (c, n).

    Raises:
        TipError: The robot was loaded whole, without a tip.
    """
    if robot.tip is None:
        raise TipError(f"{robot.name} was loaded whole, without a tip: singularities are those of a chain to a tip")
    chain = robot.chain()
    frames, mixing = np.zeros((len(chain) + 1, 4, 4)), np.zeros((len(chain), robot.n))
    frames[:-1, :3, :3], frames[:-1, :3, 3], frames[:, 3, 3], frames[-1] = (
        chain.rotations,
        chain.origins,
        1.0,
        chain.tip,
    )
    mixing[np.arange(len(chain)), chain.column] = chain.factor
    for slides, shift, after in zip(chain.sliding, chain.shift, frames[1:]):
        # A mimic joint that is not at zero where its source is.
        moved = np.eye(4)
        if slides:
            moved[2, 3] = shift
        else:
            moved[:2, :2] = [[np.cos(shift), -np.sin(shift)], [np.sin(shift), np.cos(shift)]]
        after[:] = moved @ after
    return frames, chain.sliding, mixing


def axes_at_zero(rotations: Array, offsets: Array) -> tuple[Array, Array]:
    """The joints' axes with all of them at zero and a point on each, world, (c, 3) each.

    Args:
        rotations: From each joint's axis frame to the next one's, (c, 3, 3).
        offsets: Origins of the axis frames in the one before, (c, 3).
    """
    rotation, point = np.eye(3), np.zeros(3)
    axes, points = [], []
    for turned, offset in zip(rotations, offsets):
        point, rotation = point + rotation @ offset, rotation @ turned
        axes.append(rotation[:, 2])
        points.append(point)
    return np.array(axes), np.array(points)


def ranges(robot: Robot, sliding: Mask, mixing: Array) -> tuple[Array, Array, Array]:
    """Where to search, and the period of each joint. Limits count for joints that slide only.

    Args:
        robot: The robot.
        sliding: Which of the c joints that move the tip slide.
        mixing: Their motions by the independent joints, (c, n).

    Returns:
        Lower and upper ends, a full turn, or the limits, 2 m where none are stated; and after how much each value
        comes back to the same pose, infinite where it does not, (n,) each.
    """
    used = mixing != 0
    slides = (used & sliding[:, None]).any(axis=0)
    least = np.min(np.where(used, np.abs(mixing), 1.0), axis=0, initial=1.0)
    whole = (np.round(mixing) == mixing).all(axis=0)
    low = np.where(np.isfinite(robot.lower), robot.lower, np.where(np.isfinite(robot.upper), robot.upper - 2, -1.0))
    high = np.where(np.isfinite(robot.upper), robot.upper, low + 2)
    period = np.where(whole & ~slides, 2 * np.pi, np.inf)
    return np.where(slides, low, -np.pi / least), np.where(slides, high, np.pi / least), period
