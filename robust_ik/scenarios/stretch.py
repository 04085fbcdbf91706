"""Reach for a point out of reach, and come back: the motion of the demo, for any arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import TipError
from robust_ik.inverses import RobustInverse
from robust_ik.linalg import RANK_TOLERANCE, lost_directions, singular_values, svd
from robust_ik.paths import OutAndBack
from robust_ik.reach import Reach, find_reach
from robust_ik.robot import Robot
from robust_ik.rows import always_deficient, movable_rows
from robust_ik.simulation import simulate
from robust_ik.tasks import Follow
from robust_ik.trajectory import Trajectory

BEYOND = 1.1
PULL = 0.3
LEAST_REACH = 1e-9
_SAMPLES = 400
_ROW_SAMPLES = 20
_WELL_CONDITIONED = 0.02
_HALF_STRETCHED = 0.8


@dataclass(frozen=True, eq=False)
class Stretch:
    """A motion to run with any inverse.

    Attributes:
        robot: The robot, with the task rows that it can fulfil.
        q0: Configuration to start from, (nq,).
        path: Where the target is.
        reach: The arm's reach, which the path exceeds.
        max_linear: Cap on the position error, m, so that a far target asks for no more than a steady pull.
        gain: Proportional gain, 1/s.
        max_angular: Cap on the rotation error, rad.
        dt: Time step, s.
    """

    robot: Robot
    q0: Array
    path: OutAndBack
    reach: Reach
    max_linear: float
    gain: float = 5.0
    max_angular: float = 0.5
    dt: float = 0.01

    def run(self, inverse: RobustInverse, progress: Callable[[int, int], None] | None = None) -> Trajectory:
        """The run with one inverse, from start to rest, without limits: they would hide what the inverse does."""
        motion = Follow(self.path, gain=self.gain, max_linear=self.max_linear, max_angular=self.max_angular)
        return simulate(
            self.robot, inverse, motion, self.q0,
            duration=self.path.duration, dt=self.dt, limits=(), progress=progress,
        )  # fmt: skip


def stretch(robot: Robot, *, travel: float = 5.0, pause: float = 1.0, settle: float = 6.0) -> Stretch:
    """A straight line from a good configuration, away from the shoulder to 1.1 times the reach, and back.

    Where the arm cannot move in all its task rows, those that it can are used: positions first.

    Args:
        robot: The robot; it must have a tip.
        travel: Seconds for one way.
        pause: Seconds at the far end. An exactly straight arm leaves its singularity the later the longer it stayed.
        settle: Seconds at the start again.
    """
    if robot.tip is None:
        raise TipError(f"{robot.name} was loaded whole, without a tip: load it with tip=")
    rng = np.random.default_rng(0)
    robot = robot.with_rows(feasible_rows(robot, rng))
    reach = find_reach(robot, rng)
    if reach.distance < LEAST_REACH:
        raise TipError(f"the joints of {robot.name} leave the tip {robot.tip!r} where it is: choose another tip")
    q0 = _start(robot, reach, rng)
    start = robot.pose(q0)
    goal = reach.center + BEYOND * reach.distance * _outwards(robot, q0, start[:3, 3] - reach.center)
    path = OutAndBack(start, goal, travel=travel, pause=pause, settle=settle)
    return Stretch(robot, q0, path, reach, max_linear=PULL * reach.distance)


def _outwards(robot: Robot, q: Array, away: Array) -> Array:
    """The unit direction of `away`, less what joints that slide could follow without end: limits are not enforced."""
    slides = [robot.description.joint[name].kind == "prismatic" for name in robot.joint_names]
    across = lost_directions(robot.jacobian(q, rows=("x", "y", "z"))[:, slides]) if any(slides) else np.eye(3)
    for direction in (across @ (across.T @ away), *across.T, away, np.array([1.0, 0.0, 0.0])):
        if (length := float(np.linalg.norm(direction))) > 1e-3 * float(np.linalg.norm(away)):
            return np.asarray(direction / length)
    return np.array([1.0, 0.0, 0.0])


def feasible_rows(robot: Robot, rng: np.random.Generator) -> tuple[str, ...]:
    """The robot's task rows if its Jacobian has full rank somewhere, else those of them in which it has."""
    samples = robot.random(rng, _ROW_SAMPLES)

    def deficient(rows: tuple[str, ...]) -> bool:
        return always_deficient(singular_values(robot.jacobian(samples, rows=rows)), len(rows), robot.n)

    return movable_rows(robot.rows, deficient)


def _start(robot: Robot, reach: Reach, rng: np.random.Generator) -> Array:
    """The robot's rest if it is well-conditioned and not stretched, else the best of many half-stretched samples."""
    rested = float(_conditioning(robot, robot.rest)) > _WELL_CONDITIONED
    if rested and np.any(robot.joint_values(robot.rest)) and _stretched(robot, reach, robot.rest) < _HALF_STRETCHED:
        return robot.rest
    samples = robot.random(rng, _SAMPLES)
    too_far = np.maximum(0, np.abs(_stretched(robot, reach, samples) - 0.6) - 0.15)
    return np.asarray(samples[int(np.argmax(_conditioning(robot, samples) - 10.0 * too_far))])


def _stretched(robot: Robot, reach: Reach, q: Array) -> Array:
    """Distance of the tip from the shoulder as a share of the reach."""
    return np.asarray(np.linalg.norm(robot.pose(q)[..., :3, 3] - reach.center, axis=-1) / reach.distance)


def _conditioning(robot: Robot, q: Array) -> Array:
    s = svd(robot.jacobian(q)).s
    return np.asarray(s[..., -1] / np.maximum(s[..., 0], RANK_TOLERANCE))
