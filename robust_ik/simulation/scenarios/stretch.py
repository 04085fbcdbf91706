"""The motion of the demo, for any arm: it reaches for a point out of reach and comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits import JointLimits
from robust_ik.control.tasks import Follow, FrameTask, OutAndBack
from robust_ik.description.urdf import lock_slides
from robust_ik.errors import TipError
from robust_ik.inverses import RobustInverse
from robust_ik.kinematics.svd import RANK_TOLERANCE, singular_values, svd
from robust_ik.kinematics.twist_rows import always_deficient, movable_rows
from robust_ik.robot.reach import ArmReach, find_reach
from robust_ik.robot.robot import Robot
from robust_ik.simulation.simulator import simulate
from robust_ik.simulation.trajectory import Trajectory

BEYOND = 1.1
"""Distance of the target, in reaches. Chosen: out of reach even if the reach that was found is too short."""
PULL = 0.3
"""Cap on the position error, in reaches. Chosen: a larger one pulls harder at the arm while it is stretched."""
LEAST_REACH = 1e-9
"""Reach, m, up to which a tip counts as not moving: it is rounding."""
_SAMPLES = 400
"""Configurations from which a start is chosen. Chosen: more find a better one, but take longer."""
_ROW_SAMPLES = 20
"""Configurations that show whether the tip can move in the rows.

Full rank anywhere means full rank nearly everywhere.
"""
_WELL_CONDITIONED = 0.02
"""Least σ over the largest one at a good start. Chosen: twice what the demo's page calls singular."""
_HALF_STRETCHED = 0.8
"""Largest fraction of the reach at a good start. Chosen: the way out must be long enough to be seen."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A motion to run with any inverse.

    Position and speed limits are not kept, since they would hide what an inverse does. Sliding joints are locked, so
    that none follows the target for a kilometre; if no other joint moves the tip's position, they move within their
    limits. The reach is that of the joints that move.

    Attributes:
        robot: The robot, with the task rows in which it can move, the joints that move and the limits that are kept.
        q0: Start configuration, (nq,).
        path: The path of the target.
        reach: The arm's reach within those limits, which the path exceeds.
        max_linear: Cap on the position error, m, so that a far target asks for a constant speed.
        gain: Proportional gain, 1/s.
        max_angular: Cap on the rotation error, rad.
        dt: Time step, s.
        locked: Sliding joints that are locked.
        task: The class of the task that keeps the tip on the path: `FrameTask`, or `Reach`, which goes round.
    """

    robot: Robot
    q0: Array
    path: OutAndBack
    reach: ArmReach
    max_linear: float
    gain: float = 5.0
    max_angular: float = 0.5
    dt: float = 0.01
    locked: tuple[str, ...] = ()
    task: type[FrameTask] = FrameTask

    def run(self, inverse: RobustInverse, progress: Callable[[int, int], None] | None = None) -> Trajectory:
        """The run with one inverse, from start to rest."""
        motion = Follow(
            self.path, gain=self.gain, max_linear=self.max_linear, max_angular=self.max_angular, task=self.task
        )
        return simulate(
            self.robot, inverse, motion, self.q0,
            duration=self.path.duration, dt=self.dt, limits=self.limits, calm=False, progress=progress,
        )  # fmt: skip

    @property
    def limits(self) -> tuple[JointLimits, ...]:
        """The limits that runs keep: those of sliding joints."""
        return (JointLimits.of(self.robot, velocity=np.inf),) if _slides(self.robot).any() else ()


def stretch(robot: Robot, *, travel: float = 5.0, pause: float = 1.0, settle: float = 6.0) -> Stretch:
    """A straight line from a good configuration, away from the shoulder to 1.1 times the reach, and back.

    If the arm cannot move in all its task rows, those in which it can are used, positions first.

    Args:
        robot: The robot; it must have a tip.
        travel: Time for one way, s.
        pause: Pause at the far end, s. The longer an exactly straight arm stays, the later it leaves its singularity.
        settle: Pause at the start after the return, s.
    """
    if robot.tip is None:
        raise TipError(f"{robot.name} was loaded whole, without a tip: load it with tip=")
    rng = np.random.default_rng(0)
    robot, locked = _with_slides_locked(robot, rng)
    robot = robot.with_rows(feasible_rows(robot, rng))
    free = _without_turning_limits(robot)
    reach = find_reach(free, rng)
    if reach.distance < LEAST_REACH:
        raise TipError(f"the joints of {robot.name} leave the tip {robot.tip!r} where it is: choose another tip")
    q0 = _start(robot, reach, rng)
    start = robot.pose(q0)
    goal = reach.center + BEYOND * reach.distance * _outwards(start[:3, 3] - reach.center)
    path = OutAndBack(start, goal, travel=travel, pause=pause, settle=settle)
    return Stretch(free, q0, path, reach, max_linear=PULL * reach.distance, locked=locked)


def _slides(robot: Robot) -> NDArray[np.bool_]:
    return np.array([robot.description.joint[name].kind == "prismatic" for name in robot.joint_names])


def _with_slides_locked(robot: Robot, rng: np.random.Generator) -> tuple[Robot, tuple[str, ...]]:
    """The robot with its sliding joints locked, and their names; unchanged if the tip's position needs them.

    A slide that turning joints follow, as with a lead screw, is not locked.
    """
    description = robot.description
    turning = {
        description.driver[each.name].source for each in description.joints if each.kind in ("revolute", "continuous")
    }
    slides = tuple(name for name, slide in zip(robot.joint_names, _slides(robot)) if slide and name not in turning)
    if not slides or len(slides) == robot.n:
        return robot, ()
    locked = _with_locked(robot, slides)
    positions = set(feasible_rows(locked, rng)) & {"x", "y", "z"}
    return (locked, slides) if len(positions) > 1 else (robot, ())


def _with_locked(robot: Robot, locked: tuple[str, ...]) -> Robot:
    """The robot with these joints fixed at their rest values; the others keep their limits and their rest."""
    values = dict(zip(robot.joint_names, robot.joint_values(robot.rest)))
    description = lock_slides(robot.description, {name: float(values[name]) for name in locked})
    rest_of_it = Robot.from_description(description, robot.tip, rows=robot.rows)
    old = [robot.joint_names.index(name) for name in rest_of_it.joint_names]
    rest = rest_of_it.configuration(robot.joint_values(robot.rest)[old])
    lower, upper, speed = (each[old] for each in (robot.lower, robot.upper, robot.velocity_limit))
    return replace(rest_of_it, name=robot.name, lower=lower, upper=upper, velocity_limit=speed, rest=rest)


def _without_turning_limits(robot: Robot) -> Robot:
    """The robot without the limits that the run ignores; slides keep theirs."""
    slides = _slides(robot)
    return replace(robot, lower=np.where(slides, robot.lower, -np.inf), upper=np.where(slides, robot.upper, np.inf))


def _outwards(away: Array) -> Array:
    """The unit vector along `away`, or x if `away` is zero."""
    length = float(np.linalg.norm(away))
    return away / length if length > LEAST_REACH else np.array([1.0, 0.0, 0.0])


def feasible_rows(robot: Robot, rng: np.random.Generator) -> tuple[str, ...]:
    """The robot's task rows if its Jacobian has full rank in them somewhere, else fewer rows in which it has."""
    samples = robot.random(rng, _ROW_SAMPLES)

    def deficient(rows: tuple[str, ...]) -> bool:
        return always_deficient(singular_values(robot.jacobian(samples, rows=rows)), len(rows), robot.n)

    return movable_rows(robot.rows, deficient)


def _start(robot: Robot, reach: ArmReach, rng: np.random.Generator) -> Array:
    """The robot's rest if it is well conditioned and not stretched, else the best of many half-stretched samples."""
    rested = float(_conditioning(robot, robot.rest)) > _WELL_CONDITIONED
    if rested and np.any(robot.joint_values(robot.rest)) and _stretched(robot, reach, robot.rest) < _HALF_STRETCHED:
        return robot.rest
    samples = robot.random(rng, _SAMPLES)
    too_far = np.maximum(0, np.abs(_stretched(robot, reach, samples) - 0.6) - 0.15)
    return np.asarray(samples[int(np.argmax(_conditioning(robot, samples) - 10.0 * too_far))])


def _stretched(robot: Robot, reach: ArmReach, q: Array) -> Array:
    """Distance of the tip from the shoulder as a fraction of the reach."""
    return np.asarray(np.linalg.norm(robot.pose(q)[..., :3, 3] - reach.center, axis=-1) / reach.distance)


def _conditioning(robot: Robot, q: Array) -> Array:
    s = svd(robot.jacobian(q)).s
    return np.asarray(s[..., -1] / np.maximum(s[..., 0], RANK_TOLERANCE))
