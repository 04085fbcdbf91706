"""LiveSession: a robot that is moved by commands, one after another, and what there is to say of where it is."""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from typing import Any

import numpy as np

from robust_ik.branches import AllSolutions
from robust_ik.checks import Array
from robust_ik.display.live.family_member import family_member
from robust_ik.display.live.live_commands import LiveCommand
from robust_ik.display.live.live_state import LiveState
from robust_ik.display.live.self_motion_steps import SelfMotionSteps, parts
from robust_ik.errors import InputError
from robust_ik.inverses import CLASSES, JParse, RobustInverse, SingularValueFilter
from robust_ik.kinematics.rotation_vectors import rotations
from robust_ik.robot.robot import Robot
from robust_ik.singularities.atlas import SingularityAtlas

FILTERS = {each.__name__: each for each in CLASSES if issubclass(each, SingularValueFilter)}
"""The inverses that can be chosen: those that have a gain for each singular value."""
MOST_SHOWN = 16
"""Most solutions of a pose that are shown. Source: a general arm of six joints has at most 16 (Lee and Liang 1988)."""


@dataclass(frozen=True)
class Nearby:
    """The nearest singular configuration.

    Attributes:
        words: Its family.
        index: The number of the family in the atlas, from 0.
        distance: Of the joint values, rad; slides in the arm's unit of length.
        q: The configuration, without regard to limits, (nq,).
        lost: The motion that is lost there, in words; empty if nothing is known.
    """

    words: str
    index: int
    distance: float
    q: Array
    lost: str


class LiveSession:
    """What a page moves: a robot, an inverse, and a pose of the tool that is kept or followed.

    It belongs to one thread at a time.

    Attributes:
        robot: A robot with a tip.
        q: Where it is, (nq,).
        inverse: The inverse that is told of.
        atlas: Its singular configurations, once they are known.
        solutions: All solutions of the present pose, if they were asked for.
        said: What the last command came to, in a sentence; empty if there is nothing to say.
    """

    def __init__(self, robot: Robot, q: Array) -> None:
        if robot.tip is None:
            raise InputError(f"{robot.name} has no tip: say which frame is moved, robust_ik.load(..., tip=...)")
        self.robot, self.q = robot, q
        self.inverse: RobustInverse = JParse()
        self.atlas: SingularityAtlas | None = None
        self.solutions: AllSolutions | None = None
        self.said = ""
        self._steps = SelfMotionSteps(robot)
        self._kept = robot.pose(q)

    @property
    def state(self) -> LiveState:
        """What there is to say of where it is."""
        return LiveState.of(self.robot, self.q, self.inverse)

    def do(self, command: LiveCommand) -> None:
        """Carries out a command; what was refused is said in `said`, and changes nothing."""
        self.said = ""
        try:
            getattr(self, f"_{command.do}")(**command.values)
        except InputError as error:
            self.said = str(error)

    def nearby(self) -> Nearby | None:
        """The nearest singular configuration, if families are known."""
        if self.atlas is None or not self.atlas.strata:
            return None
        near = self.atlas.distance(self.q)
        place = next(place for place, each in enumerate(self.atlas.strata) if each is near.stratum)
        q, lost = self.robot.configuration(near.values), near.stratum.lost
        return Nearby(near.stratum.words, place, near.distance, q, "" if lost is None else str(lost))

    # ------------------------------------------------------------------------------------------ what commands do
    def _look(self) -> None:
        """Does nothing: what there is to say has changed."""

    def _joint(self, index: int, value: float) -> None:
        values = self.robot.joint_values(self.q)
        if index >= len(values):
            raise InputError(f"{self.robot.name} has {len(values)} joints, got number {index + 1}")
        values = np.array(values)
        values[index] = np.clip(value, self.robot.lower[index], self.robot.upper[index])
        self._go(self.robot.configuration(values))

    def _configuration(self, values: list[float]) -> None:
        if len(values) != self.robot.n:
            raise InputError(f"{self.robot.name} has {self.robot.n} joints, got {len(values)} values")
        inside = np.clip(values, self.robot.lower, self.robot.upper)
        if not np.array_equal(inside, values):
            self.said = "Values beyond joint limits were set to the limits."
        self._go(self.robot.configuration(inside))

    def _rest(self) -> None:
        self._go(self.robot.rest)

    def _position(self, values: list[float]) -> None:
        T = self._kept.copy()
        T[:3, 3] = _three(values)
        self._reach(T)

    def _rotation(self, values: list[float]) -> None:
        T = self._kept.copy()
        T[:3, :3] = rotations(_three(values))
        self._reach(T)

    def _self_motion(self, index: int, by: float) -> None:
        for step in parts(by):
            self.q = self._steps.step(self.q, self._kept, index, step)

    def _family(self, index: int) -> None:
        if self.atlas is None:
            raise InputError("families are not known yet: the search goes on")
        self._go(family_member(self.atlas, index, self.robot, self.q))

    def _solutions(self) -> None:
        self.solutions = self.robot.all_solutions(self._kept, self.q)

    def _solution(self, index: int) -> None:
        if self.solutions is None or index >= len(self.solutions.q):
            raise InputError(f"there is no solution {index + 1}: ask for all solutions of this pose first")
        self.q = self.solutions.q[index]
        self._steps.forget()

    def _inverse(self, name: str, parameters: dict[str, float]) -> None:
        kind = FILTERS.get(name)
        if kind is None:
            raise InputError(f"an inverse is one of {', '.join(FILTERS)}")
        known = inspect.signature(kind).parameters
        if unknown := [each for each in parameters if each not in known]:
            raise InputError(f"{name} takes {', '.join(known) or 'nothing'}; got {', '.join(unknown)}")
        self.inverse = kind(**parameters)

    # ------------------------------------------------------------------------------------------ moves
    def _go(self, q: Array) -> None:
        """Moves the arm, and with it the pose that is kept."""
        self.q, self._kept, self.solutions = q, self.robot.pose(q), None
        self._steps.forget()

    def _reach(self, T: Array) -> None:
        """Moves the tool to a pose, or as close to it as the search comes; the pose is followed from now on."""
        found = self.robot.solve_pose(T, self.q)
        self.q, self._kept, self.solutions = found.q, T, None
        self._steps.forget()
        if not found.solved:
            away, turned = found.error
            self.said = f"{found.status.value} It is {1e3 * away:.3g} mm and {np.degrees(turned):.3g}° away."

    @property
    def kept(self) -> Array:
        """The pose that the tool keeps or follows, (4, 4)."""
        return self._kept


def _three(values: list[float]) -> Array:
    if len(values) != 3:
        raise InputError(f"three values are needed, got {len(values)}")
    return np.array(values)


def inverses() -> list[dict[str, Any]]:
    """The inverses that can be chosen, with the numbers that they take and their defaults."""
    return [{"name": name, "parameters": _numbers(kind)} for name, kind in FILTERS.items()]


def _numbers(kind: type[RobustInverse]) -> dict[str, float]:
    defaults = {name: each.default for name, each in inspect.signature(kind).parameters.items()}
    return {name: value for name, value in defaults.items() if isinstance(value, float)}
