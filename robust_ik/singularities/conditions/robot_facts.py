"""The facts of a robot that an atlas keeps, so that it can be read without the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.certificates.certify import plain_arm
from robust_ik.certificates.proof import Arm, float_jacobian
from robust_ik.certificates.prover import UnsupportedError, exact_arm
from robust_ik.checks import Array, as_array, readonly
from robust_ik.description.catalog import catalog
from robust_ik.description.dh import DHTable, read_dh
from robust_ik.errors import InputError, LoadError
from robust_ik.singularities.conditions.condition_words import symbols
from robust_ik.singularities.geometry.screw_chain import ScrewChain, reachable_rows
from robust_ik.singularities.geometry.straightening import straightened

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

SAME = 1e-9
"""Jacobians that differ by less belong to the same arm, m and rad."""

SHORTEST, LONGEST = 1e-3, 1e3
"""Limits of length scales, m: beyond them linear and angular rows differ so much that zero cannot be recognised."""


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
        """The facts of a robot, with straightened geometry, in the rows in which it can move."""
        asked = ScrewChain.of(robot, rows=rows, length_scale=1.0 if length_scale is None else length_scale)
        if not SHORTEST <= asked.length_scale <= LONGEST:
            raise InputError(f"length_scale must be from {SHORTEST} to {LONGEST:g} m, got {length_scale!r}")
        given = reachable_rows(asked)
        chain, changes = straightened(robot, given)
        kinds = [robot.description.joint[name].kind for name in robot.joint_names]
        exact, inexact = _exact(robot, chain)
        return cls(
            name=robot.name,
            tip=str(robot.tip),
            asked=asked.rows,
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
        )

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
        """Why not all rows that were asked for were analysed; empty if all were."""
        if self.asked == self.chain.rows:
            return ""
        return (
            f"{self.name} is singular everywhere in the rows {' '.join(self.asked)}, which its {self.chain.n} joints "
            f"cannot all move: analysed in {' '.join(self.chain.rows)}"
        )


def _exact(robot: Robot, chain: ScrewChain) -> tuple[Arm | None, str]:
    """The chain in rational numbers, or the reason why that is not possible."""
    try:
        arm = plain_arm(exact_arm(robot.with_rows(chain.rows)))
    except UnsupportedError as error:
        return None, str(error)
    away = jacobians_apart(chain, arm)
    if away > SAME:
        return None, f"its angles are not rational enough: the exact arm is off by {away:.1g}"
    return arm, ""


def jacobians_apart(chain: ScrewChain, arm: Arm) -> float:
    """The largest difference of the Jacobians of a chain and an exact arm with as many joints and rows, m and rad."""
    values = chain.random(np.random.default_rng(0), 4)
    ours = replace(chain, length_scale=1.0).jacobian(values)
    return max(float(np.abs(mine - float_jacobian(arm, each)).max()) for mine, each in zip(ours, values))


def _table(robot: Robot) -> DHTable | None:
    """The DH table of a robot of the catalogue, if it comes from one."""
    entry = catalog().get(robot.name)
    if entry is None or entry.path.suffix != ".toml":
        return None
    try:
        table = read_dh(entry.path)
    except LoadError:
        return None
    return table if table.joint_names == robot.joint_names else None
