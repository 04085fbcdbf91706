"""Prepares families of singular configurations for display: a walk through each, the lost motion, and a way out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.scene.smooth_motion import follow_subspace, full_basis
from robust_ik.errors import InputError
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.singularities.atlas import SingularityAtlas
from robust_ik.singularities.conditions import SAME, RobotFacts
from robust_ik.singularities.families import Stratum
from robust_ik.singularities.geometry import ScrewChain
from robust_ik.singularities.lost_motion import LostMotion, SelfMotionWay, lost_directions, lost_motion, self_motion_way
from robust_ik.singularities.trace import Curve, stroll, trace, within_limits

WALK, SWAY = 12.0, 8.0
"""Durations of a round trip through a family, and of one out of it to both sides, s."""
REACHES = (0.8, 0.5, 0.3)
"""Lengths of the way out, rad, and for slides in the arm's unit of length."""
FRAMES_PER_SECOND = 10
"""Few frames are enough, since joints move slowly: the viewer interpolates."""


@dataclass(frozen=True, eq=False)
class ShownMotion:
    """A motion of the robot, with the motion that is lost.

    Attributes:
        values: Joint values, rad or m, (F, n).
        duration: Seconds.
        tip: Tip positions, (F, 3), m.
        marked: Positions of the marks of lost motion: at the tip, or where the tip was singular, (F, 3), m.
        twists: Lost twists there, world axes, orthonormal columns, (F, 6, k).
    """

    values: Array
    duration: float
    tip: Array
    marked: Array
    twists: Array

    @property
    def times(self) -> Array:
        """Seconds from the start, (F,)."""
        return np.linspace(0.0, self.duration, len(self.values))


@dataclass(frozen=True, eq=False)
class Family:
    """A stratum, prepared for display.

    Attributes:
        stratum: The stratum.
        curves: Curves of its coupled joints.
        walk: A round trip through it: every configuration is singular.
        inside: Whether the walk stays within the joint limits.
        lost: The motion that is lost at the start of the walk.
        way: The way out from there.
        sway: The same way, to both sides and back, with the motion lost at its start.
    """

    stratum: Stratum
    curves: tuple[Curve, ...]
    walk: ShownMotion
    inside: bool
    lost: LostMotion
    way: SelfMotionWay
    sway: ShownMotion

    @classmethod
    def of(cls, atlas: SingularityAtlas, stratum: Stratum, robot: Robot) -> Family:
        """A stratum of a robot's atlas, prepared for display; slides move in the arm's unit of length."""
        facts, curves, units = atlas.robot, trace(atlas, stratum), atlas.robot.units
        even, row = facts.measured_in(units), stratum.measured_in(units, facts.symbols)
        along = [replace(curve, values=curve.values / units) for curve in curves]
        rest = robot.joint_values(robot.rest) / units
        trip = stroll(even, row, along, rest, round(WALK * FRAMES_PER_SECOND) + 1)
        values = trip.values * units
        lost = _lost_at(robot, facts.chain, values[0], stratum.corank)
        way = _way_inside(robot, facts, values[0], stratum.corank)
        tip = robot.pose(robot.configuration(values))[:, :3, 3]
        twists = _lost_twists(robot, facts.chain, stratum.corank, values, lost.twists)
        walk = ShownMotion(values, WALK, tip, tip, twists)
        return cls(stratum, curves, walk, trip.inside, lost, way, _sway(robot, way, walk))


def families(atlas: SingularityAtlas, robot: Robot) -> tuple[Family, ...]:
    """All strata of an atlas, prepared for display.

    Raises:
        InputError: The atlas is of another robot.
    """
    facts = atlas.robot
    if (facts.chain.joint_names, facts.tip) != (robot.joint_names, robot.tip) or not _same_arm(facts, robot):
        raise InputError(
            f"the atlas is of {facts.name} with tip {facts.tip} and joints {', '.join(facts.chain.joint_names)}, "
            f"not of {robot!r}"
        )
    return tuple(Family.of(atlas, stratum, robot) for stratum in atlas.strata)


def _same_arm(facts: RobotFacts, robot: Robot) -> bool:
    """Whether a robot with the same joints has the geometry of the atlas."""
    given = replace(facts.given, length_scale=1.0)
    values = given.random(np.random.default_rng(0), 4)
    theirs = robot.jacobian(robot.configuration(values), rows=given.rows)
    return bool(np.abs(given.jacobian(values) - theirs).max() < SAME)


def _lost_at(robot: Robot, chain: ScrewChain, values: Array, corank: int, units: Array | float = 1.0) -> LostMotion:
    """The motion lost at joint values (n,), which are in these units; in metres for any length scale of the search."""
    chain = replace(chain, length_scale=1.0)
    rows = tuple(ROWS.index(row) for row in chain.rows)
    T_world_tool = robot.pose(robot.configuration(values * units))
    return lost_motion(chain.jacobian(values), chain.hessian(values), T_world_tool, corank, rows, chain.full_rank)


def _lost_twists(robot: Robot, chain: ScrewChain, corank: int, values: Array, first: Array) -> Array:
    """The directions of the weakest singular values as columns that change continuously, (F, 6, k)."""
    rows, count = chain.rows, first.shape[1]
    places = [ROWS.index(row) for row in rows]
    q = robot.configuration(values)
    J = robot.jacobian(q, rows=rows)
    if chain.full_rank == len(rows):
        spaces = full_basis(J)[0][..., len(rows) - count :]
    else:
        found = [lost_directions(*each, corank, chain.full_rank) for each in zip(J, robot.hessian(q, rows=rows))]
        spaces = np.stack([each if each.shape[1] == count else first[places] for each in found])
    twists = np.zeros((len(values), 6, count))
    twists[:, places] = follow_subspace(spaces, first[places])
    return twists


def _way_inside(robot: Robot, facts: RobotFacts, values: Array, corank: int) -> SelfMotionWay:
    """The way out, as far as it stays within the joint limits, but long enough to be seen."""
    units = facts.units
    even = facts.measured_in(units)
    lost = _lost_at(robot, even.chain, values / units, corank, units)
    for reach in REACHES:
        way = self_motion_way(even.chain, values / units, lost, reach)
        if within_limits(even, way.values):
            break
    return replace(way, motion=way.motion * units, values=way.values * units)


def _sway(robot: Robot, way: SelfMotionWay, walk: ShownMotion) -> ShownMotion:
    """A motion out to one side, back, out to the other side, and back."""
    share = np.sin(np.linspace(0.0, 2 * np.pi, round(SWAY * FRAMES_PER_SECOND) + 1))
    half = (len(way.values) - 1) / 2
    values = np.stack(
        [np.interp(half * (1 + share), np.arange(len(way.values)), column) for column in way.values.T], axis=1
    )
    tip = robot.pose(robot.configuration(values))[:, :3, 3]
    marked, twists = (np.repeat(each[:1], len(values), axis=0) for each in (walk.tip, walk.twists))
    return ShownMotion(values, SWAY, tip, marked, twists)
