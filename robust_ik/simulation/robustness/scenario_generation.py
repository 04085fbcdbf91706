"""Makes the scenarios of the benchmark for a robot from the families of its atlas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.inverses import Exit
from robust_ik.robot.robot import Robot
from robust_ik.simulation.robustness import benchmark_motions
from robust_ik.simulation.robustness.benchmark_scenario import RobustnessScenario
from robust_ik.simulation.robustness.singular_points import (
    SingularFamily,
    SingularPoint,
    length_scale,
    singular_points,
)

GAIN, DT = 4.0, 0.01
"""Feedback, 1/s, and the usual time step, s."""
CAP, START_CAP, CORANK_CAP = 4.0, 0.6, 1.0
"""Longest commands, rad/s in scaled rows: of targets that move, of a start on a singularity, and of one of corank 2."""
FASTEST, ALIKE, PROMPT = 3.14, 2.0, 10.0
"""Joint speed limits: at most the first, rad/s; the second where a robot has none; and accelerations, limits per s."""
DISTANCES, NEAR = (0.0, 3e-2), 1e-2
"""How far from the singular pose a path passes, scaled; NEAR where one is enough, as at folds."""
PUSH = 0.08
"""How far from an exactly singular start the target is, scaled."""
BESIDE = 1e-12
"""How far beside the exact start perturbed ones are, rad: such a start is one that a computer could have rounded to."""
PERTURBED = 1
"""Perturbed starts beside the exact one."""
NOISE = 1e-4
"""Standard deviation of measured joint values, rad."""
FINE, COARSE, BRIEF = 0.001, 0.02, 0.8
"""Time steps other than DT, s, and how long a start with the fine one lasts, s."""
STAY = 2.5
"""How long a target stands still, s."""
OFFSETS = (0.15, 0.4)
"""How far a line passes beside the first axis, as a share of the distance at its start."""
FOLDS, TURNS, BOTH, HIGHER, TARGETS = 1, 2, 1, 1, 1
"""Singular points of each sort and of each higher corank, and random targets for each of those."""
DRIVEN = ("cross", "start", "line")
"""Kinds that are run behind a drive too."""
HIGHEST, LOOKED_AT = 3, 60
"""The highest corank that is tested, and how many configurations of corank 1 are sorted at most."""
NAMES = {
    Exit.FOLD: "fold", Exit.BOTH_WAYS: "both ways", Exit.TURN_FIRST: "turn first", Exit.END_OF_REACH: "end of reach",
    Exit.STRUCTURAL: "structural", Exit.FREE: "free",
}  # fmt: skip


@checked
def robustness_scenarios(
    robot: Robot, families: Iterable[SingularFamily], *, seed: int = 0
) -> tuple[RobustnessScenario, ...]:
    """The scenarios of a robot: around its singular configurations, as commanded and behind a drive.

    Args:
        robot: An arm with a tip. Its position limits are left out of account.
        families: An atlas of it, as `find_singularities` gives it, or some of its rows.
        seed: Of the choice of singular configurations, targets and noise.

    Raises:
        InputError: The families have no configuration of use.
    """
    made = _Maker(robot, tuple(families), seed)
    found = list(made.all())
    if not found:
        raise InputError(f"{robot.name}: its families have no singular configuration that is alone, nothing to test on")
    driven = [
        replace(each, name=f"{each.name}, drive", drive=True, shown=False) for each in found if each.kind in DRIVEN
    ]
    return (*found, *driven)


def speed_limits(robot: Robot) -> Array:
    """Joint speeds that the benchmark allows, (n,): the robot's own, up to FASTEST."""
    own = np.where(np.isfinite(robot.velocity_limit) & (robot.velocity_limit > 0), robot.velocity_limit, ALIKE)
    return np.minimum(own, FASTEST)


@dataclass(frozen=True, eq=False)
class _NamedPoint:
    """A singular point with the number by which its scenarios are told apart."""

    point: SingularPoint
    label: str


class _Maker:
    """Makes all scenarios of one robot."""

    def __init__(self, robot: Robot, families: tuple[SingularFamily, ...], seed: int) -> None:
        self.robot, self.seed = robot, seed
        self.rng = np.random.default_rng(seed)
        self.length = length_scale(robot, np.random.default_rng(0))
        self.speed = speed_limits(robot)
        self.wanted = {Exit.FOLD: FOLDS, Exit.TURN_FIRST: TURNS, Exit.BOTH_WAYS: BOTH}
        self.simple = self._sorted(islice(singular_points(robot, families, 1, self.length, self.rng), LOOKED_AT))
        self.higher = {
            corank: list(islice(singular_points(robot, families, corank, self.length, self.rng), HIGHER))
            for corank in range(2, HIGHEST + 1)
        }

    def _sorted(self, points: Iterable[SingularPoint]) -> dict[Exit, list[_NamedPoint]]:
        found: dict[Exit, list[_NamedPoint]] = {kind: [] for kind in self.wanted}
        for point in points:
            places = found.get(point.exit, [])
            if len(places) < self.wanted.get(point.exit, 0):
                places.append(_NamedPoint(point, f"{NAMES[point.exit]} {len(places) + 1}"))
            if all(len(found[kind]) == count for kind, count in self.wanted.items()):
                break
        return found

    def all(self) -> Iterator[RobustnessScenario]:
        """Each scenario once, without a drive."""
        places = [each for group in self.simple.values() for each in group]
        for number, place in enumerate(places):
            for distance in DISTANCES if place.point.exit is Exit.TURN_FIRST else (NEAR,):
                yield self.cross(place, distance, shown=number == 0)
        for number, place in enumerate(places):
            for side in (1.0, -1.0):
                for beside in range(1 + PERTURBED if side > 0 else 1):
                    yield self.start(place, side, beside, shown=number == 0)
        for number, place in enumerate(self.simple[Exit.FOLD]):
            yield self.beyond(place, shown=number == 0)
        for corank, points in self.higher.items():
            for point in points:
                for number in range(TARGETS):
                    yield self.corank(point, corank, number)
        if places:
            yield from self.lines()
        firsts = [group[0] for group in self.simple.values() if group]
        yield from self.varied(firsts)

    def varied(self, places: list[_NamedPoint]) -> Iterator[RobustnessScenario]:
        """Motions at the first point of each sort again: with noise, at other speeds, with other time steps."""
        for number, place in enumerate(places):
            noisy = [self.cross(place, NEAR), self.start(place, 1.0, 0)]
            noisy += [self.beyond(place)] if place.point.exit is Exit.FOLD else []
            for each in noisy:
                yield replace(
                    each, name=f"{each.name}, noise", kind="noise", noise=NOISE, seed=self.seed, shown=not number
                )
            for seconds in (1.0, 4.0) if number == 0 else ():
                moved = self.cross(place, NEAR, seconds=seconds)
                yield replace(moved, name=f"{moved.name} in {seconds:g} s", kind="speed", shown=True)
            fine = [self.start(place, 1.0, 0, seconds=BRIEF, dt=FINE)] if number == 0 else []
            for each in (*fine, self.cross(place, NEAR, dt=COARSE), self.start(place, 1.0, 0, dt=COARSE)):
                yield replace(each, name=f"{each.name}, {1e3 * each.dt:g} ms", kind="sampling", shown=not number)

    def cross(
        self, place: _NamedPoint, distance: float, *, seconds: float = 2.0, dt: float = DT, shown: bool = False
    ) -> RobustnessScenario:
        """Poses of the arm across the family, passing the singular one at a distance along what is lost."""
        point = place.point
        aside = np.random.default_rng(self.seed).normal(size=self.robot.n)
        way = point.across + 0.4 * aside / np.linalg.norm(aside)
        targets = benchmark_motions.crossing(
            self.robot, point.values, way / np.linalg.norm(way), distance * self.metres(point.lost[:, 0]), seconds, dt
        )
        start = point.values - 0.5 * way / np.linalg.norm(way)
        name = f"cross {place.label}, δ = {distance:g}"
        return self.scenario(name, "cross", point, start, targets, dt, cap=CAP, shown=shown)

    def start(
        self,
        place: _NamedPoint,
        side: float,
        beside: int,
        *,
        seconds: float = STAY,
        dt: float = DT,
        shown: bool = False,
    ) -> RobustnessScenario:
        """Exactly on the singular configuration, or as far beside as rounding; the target is a step along the lost."""
        point = place.point
        rng = np.random.default_rng((self.seed, beside))
        values = point.values + (BESIDE * rng.normal(size=self.robot.n) if beside else 0.0)
        pose = self.robot.pose(self.robot.configuration(point.values))
        target = benchmark_motions.moved(pose, side * PUSH * self.metres(point.lost[:, 0]))
        outward = point.exit is Exit.FOLD and side < 0
        exit_ = Exit.END_OF_REACH if outward else point.exit
        near = self.robot.configuration(point.values)
        leavable = not outward and self.robot.solve_pose(target, near, effort="thorough").solved
        name = f"start {place.label}, {'back' if side < 0 else 'forth'}{f', beside {beside}' if beside else ''}"
        return self.scenario(
            name, "start", point, values, benchmark_motions.still(target, seconds, dt), dt, cap=START_CAP, exit_=exit_,
            leavable=leavable, shown=shown and not beside,
        )  # fmt: skip

    def beyond(self, place: _NamedPoint, *, shown: bool = False) -> RobustnessScenario:
        """A line from within reach to 0.15 beyond the edge, and back."""
        point = place.point
        start = point.values + 0.5 * point.kernel[:, 0]
        edge = self.robot.pose(self.robot.configuration(point.values))
        far = benchmark_motions.moved(edge, -0.15 * self.metres(point.lost[:, 0]))
        targets = benchmark_motions.there_and_back(self.robot.pose(self.robot.configuration(start)), far, 3.0, DT)
        return self.scenario(f"beyond {place.label}", "beyond", point, start, targets, DT, cap=CAP, shown=shown)

    def corank(self, point: SingularPoint, corank: int, number: int) -> RobustnessScenario:
        """Exactly on a singular configuration of higher corank, the target is the pose of a configuration nearby."""
        rng = np.random.default_rng((self.seed, corank, number))
        near = point.values + 0.6 * rng.uniform(-1, 1, self.robot.n)
        target = self.robot.pose(self.robot.configuration(near))
        return self.scenario(
            f"corank {corank}, target {number + 1}", "corank", point, point.values,
            benchmark_motions.still(target, STAY, DT), DT,
            cap=CORANK_CAP, leavable=True, shown=not number,
        )  # fmt: skip

    def lines(self) -> Iterator[RobustnessScenario]:
        """Lines past the first axis, there and back, from a configuration that is far from singular."""
        point = next(group[0].point for group in self.simple.values() if group)
        start = benchmark_motions.regular_start(self.robot, self.length, np.random.default_rng(self.seed))
        for number, offset in enumerate(OFFSETS):
            targets = benchmark_motions.past_the_first_axis(self.robot, start, offset, 4.0, DT)
            made = self.scenario(
                f"line past axis 1 at {offset:g}", "line", point, start, targets, DT, cap=CAP, shown=not number
            )
            yield replace(made, exit="", place="", lost=np.zeros((len(self.robot.rows), 0)))

    def metres(self, scaled: Array) -> Array:
        """A motion in scaled rows as a twist, (6,)."""
        return benchmark_motions.as_twist(scaled, self.robot.rows, self.length)

    def scenario(
        self, name: str, kind: str, point: SingularPoint, start: Array, targets: Array, dt: float, *, cap: float,
        exit_: Exit | None = None, leavable: bool = False, shown: bool = False,
    ) -> RobustnessScenario:  # fmt: skip
        """A scenario at a singular point, with what all of this robot share."""
        same: dict[str, Any] = {
            "robot": self.robot.name, "rows": self.robot.rows, "length": self.length, "gain": GAIN,
            "speed": self.speed, "acceleration": PROMPT * self.speed,
        }  # fmt: skip
        return RobustnessScenario(
            name=name, kind=kind, exit=NAMES[exit_ or point.exit], place=point.place, start=start, targets=targets,
            lost=point.lost, dt=dt, cap=cap, leavable=leavable, shown=shown, **same,
        )  # fmt: skip
