"""Stratum: one row of the atlas. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.condition_words import Symbols, condition, equation
from robust_ik.singularities.conditions.trig_relations import Relation
from robust_ik.singularities.families.leaf import Leaf, Pin
from robust_ik.singularities.families.leaf_merging import Values, values_of
from robust_ik.singularities.lost_motion.along_a_stratum import Lost

ROUNDING = 1e-8
"""Lengths below this, in the arm's unit, are zero: polished points are as exact where strata cross."""
SAMPLES = 64
"""Most samples of a row."""


@dataclass(frozen=True)
class Condition:
    """An angle that has one of some values.

    Attributes:
        angle: Of one joint, or a sum of several.
        values: Rad or m, ascending.
        words: The condition as text.
    """

    angle: Angle
    values: Values
    words: str

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True, eq=False)
class Stratum:
    """A family of configurations at which the arm loses `corank` directions of motion.

    Attributes:
        corank: How many directions are lost; of fewer joints than rows, how many motions of the joints move nothing.
        conditions: Angles that have one of a few values each; all combinations belong to it.
        relations: Equations between coupled joints; their angles count joints from 1.
        equations: The relations in words.
        free: Joints that may have any value, indices from 0.
        curve: Joints that are coupled without a short relation: only the samples describe them.
        components: How many connected pieces the family has, angles taken modulo 2π.
        counted: Whether `components` is exact; else it is an estimate from samples.
        dimension: Dimension of the family: n minus the number of independent conditions.
        samples: Configurations on it as joint values, rad or m, (S, n).
        residual: Largest σ_{r−k+1}/σ₁ at random members, r = min(m, n); it shows that the family is singular.
        off: Largest σ_{r−k+1} of the model as given, at these members and the samples, in the units of the Jacobian; 0
            up to rounding unless the model's numbers are rounded.
        floor: Largest σ_{r−k+1} that remains after descent from the members: 0 if the model as given has such
            configurations too, nearby.
        within_limits: Whether some of it lies within the joint limits.
        margin: The least distance of a joint to one of its limits, for the member that is farthest inside the limits,
            rad, or for slides in the arm's unit of length; negative if the limits exclude the family; infinite without
            limits.
        inside: The combinations of values at which some of it lies within the limits.
        lost: The motion that is lost.
    """

    corank: int
    conditions: tuple[Condition, ...]
    relations: tuple[Relation, ...]
    equations: tuple[str, ...]
    free: tuple[int, ...]
    curve: tuple[int, ...]
    components: int
    counted: bool
    dimension: int
    samples: Array
    residual: float
    off: float = 0.0
    floor: float = 0.0
    within_limits: bool = True
    margin: float = np.inf
    inside: tuple[Values, ...] = ()
    lost: Lost | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "samples", readonly(self.samples))

    def __str__(self) -> str:
        return self.words

    @property
    def words(self) -> str:
        """All conditions as text: "q2 ∈ {0, π} and q3 = ±π/2"."""
        parts = [*(each.words for each in self.conditions), *self.equations]
        if self.curve:
            names = ", ".join(f"q{joint + 1}" for joint in self.curve)
            parts.append(f"{names} coupled: no short relation, see the curve")
        return " and ".join(parts) if parts else "everywhere"

    @property
    def leaves(self) -> tuple[Leaf, ...]:
        """Its leaves, one for each combination of values; those with a curve share samples."""
        found = []
        for values in _combinations([each.values for each in self.conditions]):
            pins = tuple(Pin(each.angle, value) for each, value in zip(self.conditions, values))
            leaf = Leaf(self.corank, self.dimension, pins, self.relations, self.free, self.curve, self.samples)
            own = leaf.holds(self.samples)
            found.append(replace(leaf, samples=self.samples[own]) if own.any() else leaf)
        return tuple(found)

    def measured_in(self, units: Array, known: Symbols) -> Stratum:
        """The same row of joint values in other units, with words for it; a margin and a way out stay as they are.

        Args:
            units: The new unit of each value, in the present one, (n,).
            known: Lengths with names.
        """
        if (units == 1).all():
            return self
        sizes = [float(units[each.angle.joints[0]]) for each in self.conditions]
        conditions = []
        for each, size in zip(self.conditions, sizes):
            values = tuple(value / size for value in each.values)
            conditions.append(Condition(each.angle, values, condition(each.angle, values, known)))
        relations = tuple(each.measured_in(units) for each in self.relations)
        inside = tuple(tuple(value / size for value, size in zip(each, sizes)) for each in self.inside)
        return replace(
            self,
            conditions=tuple(conditions),
            relations=relations,
            equations=tuple(equation(each, known) for each in relations),
            samples=self.samples / units,
            inside=inside,
        )

    @property
    def fitted(self) -> float:
        """Largest residual of its fitted relations, 0 without any."""
        return max((relation.residual for relation in self.relations), default=0.0)


def _combinations(values: Sequence[Values]) -> list[Values]:
    found: list[Values] = [()]
    for each in values:
        found = [(*before, value) for before in found for value in each]
    return found


def _tidied(pin: Pin) -> float:
    """The value of a pin; of a slide zero, if it is no more than rounding."""
    return 0.0 if not pin.angle.circular and abs(pin.value) < ROUNDING else pin.value


def stratum(leaves: Sequence[Leaf], known: Symbols, components: tuple[int, bool], residual: float) -> Stratum:
    """The row made of leaves: the same angles, values in all combinations."""
    first = leaves[0]
    exact = [{values_of(leaf)[i]: _tidied(leaf.pins[i]) for leaf in leaves} for i in range(len(first.pins))]
    order = sorted(range(len(exact)), key=lambda i: (len(first.pins[i].angle.joints), first.pins[i].angle.joints))
    conditions = []
    for i in order:
        values = tuple(sorted(exact[i].values()))
        conditions.append(Condition(first.pins[i].angle, values, condition(first.pins[i].angle, values, known)))
    share = max(SAMPLES // len(leaves), 4)
    return Stratum(
        corank=first.corank,
        conditions=tuple(conditions),
        relations=first.relations,
        equations=tuple(equation(relation, known) for relation in first.relations),
        free=first.free,
        curve=first.curve,
        components=components[0],
        counted=components[1],
        dimension=first.dimension,
        samples=np.concatenate([leaf.pinned(leaf.samples[-share:]) for leaf in leaves]),
        residual=residual,
    )
