"""The facts of a robot that an atlas keeps, so that it can be read without the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.certificates.certify import plain_arm
from robust_ik.certificates.proof import Arm, float_jacobian
from robust_ik.certificates.prover import UnsupportedError, arm_of_moves, exact_arm
from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.description.catalog import catalog
from robust_ik.description.dh import DHTable, read_dh
from robust_ik.errors import InputError, LoadError
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.singularities.conditions.built_in_losses import built_in
from robust_ik.singularities.conditions.condition_words import symbols
from robust_ik.singularities.geometry.line_arm import LineArm
from robust_ik.singularities.geometry.screw_chain import ScrewChain, largest_rank
from robust_ik.singularities.geometry.sliding_arm import SlidingArm
from robust_ik.singularities.geometry.straightening import nearby, straightened

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

SAME = 1e-9
"""Jacobians that differ by less belong to the same arm, in its units of length and rad."""


@dataclass(frozen=True, eq=False)
class RobotFacts:
    """Names, limits and geometry of the chain that an atlas is of.

    Attributes:
        name: Name of the robot.
        tip: The frame that is moved.
        asked: Task rows that were asked for.
        continuous: Which joints have (cos, sin) in q, (n,).
        lower: Lower limits, (n,), rad or m; −∞ for none.
        upper: Upper limits.
        symbols: Lengths of the DH table by name, m; empty without a table.
        chain: The geometry that was analysed, and the task rows.
        given: The geometry of the model; the same object if nothing was straightened.
        changes: Each change by straightening, in words.
        snapped: Whether the straightened geometry was asked for.
        tool: The tool's axes in the last joint's axis frame, (3, 3).
        exact: The chain in rational numbers, for proofs; None if that is not possible.
        inexact: Why it is not.
        length_scale: Length by which linear rows are divided where σ is told, m.
        near: The chain without small tilts and offsets; None if it has none.
        near_changes: Each of these, in words.
        floating: The six joints that a floating joint in front of the tip is taken as; empty without one.
    """

    name: str
    tip: str
    asked: tuple[str, ...]
    continuous: tuple[bool, ...]
    lower: Array
    upper: Array
    symbols: Mapping[str, float]
    chain: ScrewChain
    given: ScrewChain
    changes: tuple[str, ...]
    snapped: bool
    tool: Array
    exact: Arm | None = None
    inexact: str = ""
    length_scale: float = 1.0
    near: ScrewChain | None = None
    near_changes: tuple[str, ...] = ()
    floating: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "lower", readonly(self.lower))
        object.__setattr__(self, "upper", readonly(self.upper))
        object.__setattr__(self, "tool", readonly(self.tool))
        object.__setattr__(self, "symbols", MappingProxyType(dict(self.symbols)))

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"symbols": dict(self.symbols)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.__post_init__()

    @classmethod
    def of(
        cls,
        robot: Robot,
        rows: Sequence[str] | None,
        length_scale: float | None,
        table: DHTable | None,
        snap: bool,
    ) -> RobotFacts:
        """The facts of a robot, with straightened geometry, in all the rows that are asked for."""
        told = robot.length_scale if length_scale is None else checked_parameter("length_scale", length_scale, above=0)
        given = ScrewChain.of(robot, rows=rows, length_scale=robot.length_scale)
        chain, changes, lines = straightened(robot, given)
        chain = replace(chain, rank=largest_rank(chain))
        given = replace(given, rank=chain.rank) if changes else chain
        kinds = [robot.description.joint[name].kind for name in robot.joint_names]
        exact, inexact = _exact(robot, chain, lines)
        near, near_changes = nearby(robot, given, chain)
        return cls(
            name=robot.name,
            tip=str(robot.tip),
            asked=given.rows,
            continuous=tuple(kind == "continuous" for kind in kinds),
            lower=robot.lower,
            upper=robot.upper,
            symbols=symbols(_table(robot) if table is None else table),
            chain=chain,
            given=given,
            changes=changes,
            snapped=snap,
            tool=chain.last_axes(np.zeros(chain.n)).T @ robot.pose(robot.neutral)[:3, :3],
            exact=exact,
            inexact=inexact,
            length_scale=told,
            near=near,
            near_changes=near_changes,
            floating=robot.description.floating(str(robot.tip)),
        )

    @cached_property
    def units(self) -> Array:
        """The units in which joint values are searched: 1 rad, and for slides the arm's unit of length, m, (n,)."""
        return readonly(np.where(self.chain.slides, self.chain.length_scale, 1.0))

    def measured_in(self, units: Array) -> RobotFacts:
        """The same facts with joint values in other units; one robot at any size has the same ones in `units`.

        Args:
            units: The new unit of each value, in the present one, (n,).
        """
        if (units == 1).all():
            return self
        chain = self.chain.measured_in(units)
        return replace(
            self,
            chain=chain,
            given=chain if self.given is self.chain else self.given.measured_in(units),
            near=None if self.near is None else self.near.measured_in(units),
            lower=self.lower / units,
            upper=self.upper / units,
            exact=None if self.exact is None else _sized(self.exact, 1 / float(units[np.array(self.chain.slides)][0])),
        )

    @property
    def nearly(self) -> RobotFacts | None:
        """The facts of the same robot without small tilts and offsets; None if it has none."""
        if self.near is None:
            return None
        return replace(self, chain=self.near, changes=self.near_changes, exact=None, near=None, near_changes=())

    def values(self, q: ArrayLike) -> Array:
        """Joint values (n,) from q (nq,), or from joint values themselves."""
        q = as_array(q, "q", (None,))
        n, pairs = self.chain.n, sum(self.continuous)
        if q.shape == (n,):
            return q
        if q.shape != (n + pairs,):
            raise InputError(f"q must have shape ({n},){f' or ({n + pairs},)' if pairs else ''}, got {q.shape}")
        values, place = np.empty(n), 0
        for joint, turns in enumerate(self.continuous):
            values[joint] = np.arctan2(q[place + 1], q[place]) if turns else q[place]
            place += 2 if turns else 1
        return values

    @property
    def reduced(self) -> str:
        """What the arm can never do in the rows that were asked for; empty if it can move in all of them somewhere.

        Atlases of version 3 left out rows that the arm could not all move.
        """
        if self.asked == self.chain.rows:
            return built_in(self.name, self.chain)
        return (
            f"{self.name} is singular everywhere in the rows {' '.join(self.asked)}, which its {self.chain.n} joints "
            f"cannot all move: analysed in {' '.join(self.chain.rows)}"
        )


def _exact(robot: Robot, chain: ScrewChain, lines: LineArm | SlidingArm | None) -> tuple[Arm | None, str]:
    """The chain in rational numbers, or the reason why that is not possible."""
    try:
        if lines is None:
            arm = plain_arm(exact_arm(robot.with_rows(chain.rows)))
        else:
            told, slides = (robot.name, chain.joint_names, chain.rows), np.flatnonzero(chain.sliding).tolist()
            arm = plain_arm(arm_of_moves(*told, lines.moves, robot.length_scale, frozenset(slides)))
    except UnsupportedError as error:
        return None, str(error)
    away = jacobians_apart(chain, arm)
    if away > SAME:
        return None, f"its angles are not rational enough: the exact arm is off by {away:.1g}"
    if arm.rank != chain.full_rank:
        return None, f"in rational numbers its rank is {arm.rank} nearly everywhere, by its numbers {chain.full_rank}"
    return arm, ""


def _sized(arm: Arm, factor: float) -> Arm:
    """An exact arm with its lengths times a factor; its slides move as far in them."""
    links = tuple(
        (*rotation, tuple(str(Fraction(text) * Fraction(factor)) for text in offset)) for *rotation, offset in arm.links
    )
    return replace(arm, links=links)


def jacobians_apart(chain: ScrewChain, arm: Arm) -> float:
    """The largest difference of the Jacobians of a chain and an exact arm with as many joints, in the chain's rows."""
    values = chain.random(np.random.default_rng(0), 4)
    factors = np.array([1 / chain.length_scale if row in ROWS[:3] else 1.0 for row in chain.rows])[:, None]
    ours = chain.jacobian(values)
    return max(float(np.abs(mine - factors * float_jacobian(arm, each)).max()) for mine, each in zip(ours, values))


def _table(robot: Robot) -> DHTable | None:
    """The DH table of a robot of the catalogue, if it comes from one; on a base that moves, the arm's."""
    entry = catalog().get(robot.name)
    if entry is None or entry.path.suffix != ".toml":
        return None
    try:
        table = read_dh(entry.path)
    except LoadError:
        return None
    own = tuple(name for name in robot.joint_names if not robot.description.joint[name].part_of)
    return table if table.joint_names == own else None
