"""A configuration of a family that the arm can be shown in."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.robot.robot import Robot
from robust_ik.singularities.atlas import SingularityAtlas
from robust_ik.singularities.trace import stroll

EDGE = 1e-9
"""How far a joint may be beyond its limit by rounding, rad or m."""


def family_member(atlas: SingularityAtlas, index: int, robot: Robot, q: Array) -> Array:
    """A member of a family within the joint limits: the nearest to q if that is within, else some other, (nq,).

    Args:
        atlas: The atlas of the robot.
        index: Which of its strata, from 0.
        robot: The robot.
        q: Configuration, (nq,).

    Raises:
        InputError: There is no such family, or none of it that was found lies within the limits.
    """
    if not 0 <= index < len(atlas.strata):
        raise InputError(f"there are {len(atlas.strata)} families, got number {index + 1}")
    stratum = atlas.strata[index]
    near = next(each for each in atlas.distances(q) if each.stratum is stratum)
    if is_inside(robot, near.values):
        return robot.configuration(near.values)
    found = stroll(atlas.robot, stratum, atlas.curves(stratum), robot.joint_values(q), 2).values[0]
    if not is_inside(robot, found):
        raise InputError(f"no member of {stratum.words} was found within the joint limits")
    return robot.configuration(found)


def is_inside(robot: Robot, values: Array) -> bool:
    """Whether joint values (n,) are within the limits."""
    return bool(np.all((values >= robot.lower - EDGE) & (values <= robot.upper + EDGE)))
