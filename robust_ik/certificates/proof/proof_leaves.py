"""The leaves of a proof: where joints are fixed, relations, dimensions, and how certain their list is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from robust_ik.certificates.proof.case_tree import RATIONAL, Coefficients, ExactPin, Node
from robust_ik.certificates.proof.joint_relations import JointRelation, relation, shown, shown_length
from robust_ik.certificates.proof.proof import Proof
from robust_ik.certificates.proof.proof_arm import Arm
from robust_ik.certificates.proof.real_roots import real_roots
from robust_ik.checks import Array
from robust_ik.checks.public_arguments import checked

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class LeafPlace:
    """A leaf at one real place of its field: a set of singular configurations.

    Attributes:
        names: Names of all joints.
        angles: Joint index → angle at which it is fixed, rad in (−π, π].
        relations: Relations between the other joints.
        dimension: Free joints minus relations: the dimension at generic points, if there are real ones; None if there
            are too many relations for this count.
        lengths: Index of a sliding joint → length at which it is fixed, m.
    """

    names: tuple[str, ...]
    angles: dict[int, float]
    relations: tuple[JointRelation, ...]
    dimension: int | None
    lengths: dict[int, float] = field(default_factory=dict)

    def residual(self, values: Array) -> Array:
        """Deviation of joint values from the conditions, (..., n) rad or m → (...): 0 on the leaf, about 1 far away.

        It is the largest of |sin| of half a pinned joint's error, a sliding joint's error in metres, and the magnitude
        of a relation's left side.
        """
        q = np.asarray(values, dtype=float)
        parts = (deviation(q) for deviation in self._deviations)
        return np.asarray(np.max(np.stack([np.zeros(q.shape[:-1]), *parts]), axis=0))

    def holds(self, values: Array, tolerance: float) -> Mask:
        """Which joint values (N, n) deviate by no more than a tolerance, (N,): what is far off is told soon."""
        q = np.asarray(values, dtype=float)
        left = np.arange(len(q))
        for deviation in self._deviations:
            left = left[deviation(q[left]) <= tolerance]
        result = np.zeros(len(q), dtype=bool)
        result[left] = True
        return result

    @cached_property
    def _deviations(self) -> tuple[Callable[[Array], Array], ...]:
        """The deviation from each condition, (..., n) → (...)."""
        pins = [partial(_off_angle, joint, angle) for joint, angle in self.angles.items()]
        pins += [partial(_off_length, joint, length) for joint, length in self.lengths.items()]
        return (*pins, *(partial(_off_relation, each) for each in self.relations))

    def __str__(self) -> str:
        pins = {joint: shown(math.degrees(angle)) for joint, angle in self.angles.items()}
        pins |= {joint: shown_length(length) for joint, length in self.lengths.items()}
        parts = [f"{self.names[joint]} = {pins[joint]}" for joint in sorted(pins)]
        return " and ".join(parts + [str(each) for each in self.relations]) or "everywhere"


@dataclass(frozen=True, eq=False)
class ProofLeaf:
    """A leaf of a proof.

    Attributes:
        arm: The arm.
        node: The node of the proof, with its conditions.
        implicit: Whether it only repeats the equations.
    """

    arm: Arm
    node: Node
    implicit: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all joints."""
        return self.arm.joints

    @cached_property
    def places(self) -> tuple[LeafPlace, ...]:
        """The leaf at each real root of its field's polynomial; one place if all pins are rational."""
        roots = [Fraction(0)] if self.node.state.field == RATIONAL else real_roots(self.node.state.field)
        return tuple(self._place(float(theta)) for theta in roots)

    @property
    def is_real(self) -> bool | None:
        """True if it is shown to have real points of its dimension; for a single relation a change of sign shows it.

        None if that was not shown.
        """
        place = self.places[0]
        if not place.relations:
            return True
        if len(place.relations) > 1:
            return None
        rng = np.random.default_rng(0)
        values = rng.uniform(-np.pi, np.pi, (1000, len(self.names)))
        values[:, list(self.arm.sliding)] = rng.standard_cauchy((1000, len(self.arm.sliding)))  # of any magnitude
        signs = place.relations[0].value(values)
        return True if signs.min() < -1e-6 and signs.max() > 1e-6 else None

    def __str__(self) -> str:
        return " or ".join(map(str, self.places))

    def _place(self, theta: float) -> LeafPlace:
        state = self.node.state
        sliding = self.arm.sliding
        angles = {pin.joint: _angle(pin, theta) for pin in state.pins if pin.joint not in sliding}
        lengths = {pin.joint: _value(pin.y, theta) for pin in state.pins if pin.joint in sliding}
        indices = [index for index, _ in self.node.relations]
        if self.node.kind == "implicit":
            indices = list(range(len(state.generators)))
        found = (relation(state.generators[index], state, theta, self.arm) for index in indices)
        dimension = None if self.node.kind == "implicit" else len(self.names) - len(state.pins) - len(indices)
        return LeafPlace(self.names, angles, tuple(found), dimension, lengths)


@checked
def leaves(proof: Proof) -> tuple[ProofLeaf, ...]:
    """The leaves of a proof; none without an arm."""
    if proof.arm is None:
        return ()
    return tuple(ProofLeaf(proof.arm, node, proof.is_implicit(node)) for node in proof.leaves)


def _off_angle(joint: int, angle: float, values: Array) -> Array:
    return np.asarray(np.abs(np.sin((values[..., joint] - angle) / 2)))


def _off_length(joint: int, length: float, values: Array) -> Array:
    return np.asarray(np.abs(values[..., joint] - length))


def _off_relation(relation: JointRelation, values: Array) -> Array:
    return np.asarray(np.abs(relation.value(values)))


def _angle(pin: ExactPin, theta: float) -> float:
    angle = 2 * math.atan2(_value(pin.y, theta), _value(pin.x, theta))
    return angle - 2 * math.pi if angle > math.pi else angle


def _value(coefficients: Coefficients, theta: float) -> float:
    return float(sum(float(Fraction(a)) * theta**i for i, a in enumerate(coefficients)))
