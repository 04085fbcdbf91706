"""From the n independent joints to Pinocchio's configuration vector: continuous joints, mimic joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.description import Description
from robust_ik.errors import InputError
from robust_ik.linalg import Array, readonly

Mask = NDArray[np.bool_]

UNIT_CIRCLE_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class JointMap:
    """How joint values, q of the independent joints and Pinocchio's q of all joints belong together.

    A continuous joint has one value, an angle, and two entries of q, its cosine and sine. A mimic joint has a value
    multiplier · source + offset and no entry in q.

    Attributes:
        names: Independent joints, in Pinocchio's order.
        continuous: Which of them turn without end, (n,).
        prismatic: Which of them slide, (n,).
        mixing: Values of all joints = mixing @ values + offsets, (N, n).
        offsets: (N,).
        all_continuous: Which of all joints turn without end, (N,).
    """

    names: tuple[str, ...]
    continuous: Mask
    prismatic: Mask
    mixing: Array
    offsets: Array
    all_continuous: Mask

    @classmethod
    def of(cls, description: Description, model_names: list[str]) -> Self:
        """The map for a model whose joints are `model_names`, which hold the source of every mimic joint."""
        joints = [description.joint[name] for name in model_names]
        names = [joint.name for joint in joints if joint.mimic is None]
        mixing, offsets = np.zeros((len(joints), len(names))), np.zeros(len(joints))
        for row, joint in enumerate(joints):
            factor = 1.0
            while joint.mimic is not None:
                offsets[row] += factor * joint.mimic.offset
                factor *= joint.mimic.multiplier
                joint = description.joint[joint.mimic.source]
            mixing[row, names.index(joint.name)] = factor
        kinds = [description.joint[name].kind for name in names]
        return cls(
            names=tuple(names),
            continuous=readonly([kind == "continuous" for kind in kinds], bool),
            prismatic=readonly([kind == "prismatic" for kind in kinds], bool),
            mixing=readonly(mixing),
            offsets=readonly(offsets),
            all_continuous=readonly([joint.kind == "continuous" for joint in joints], bool),
        )

    @property
    def nq(self) -> int:
        """Length of q of the independent joints."""
        return len(self.names) + int(self.continuous.sum())

    @property
    def _plain(self) -> bool:
        """No mimic joint: q is Pinocchio's q."""
        return len(self.mixing) == len(self.names)

    def configuration(self, values: Array) -> Array:
        """Joint values (..., n) → q (..., nq)."""
        return _to_q(values, self.continuous)

    def values(self, q: Array) -> Array:
        """Q (..., nq) → joint values (..., n), angles of continuous joints in (−π, π]."""
        if not self.continuous.any():
            return q.copy()
        first = np.arange(len(self.names)) + np.concatenate([[0], np.cumsum(self.continuous)[:-1]])
        values = q[..., first]
        turning = first[self.continuous]
        values[..., self.continuous] = np.arctan2(q[..., turning + 1], q[..., turning])
        return values

    def check(self, q: Array) -> None:
        """Refuses a q whose (cos, sin) pairs are not on the unit circle."""
        if not self.continuous.any():
            return
        first = np.flatnonzero(self.continuous) + np.arange(int(self.continuous.sum()))
        radius = np.hypot(q[..., first], q[..., first + 1])
        if (np.abs(radius - 1) > UNIT_CIRCLE_TOLERANCE).any():
            names = [name for name, turns in zip(self.names, self.continuous) if turns]
            raise InputError(
                f"q holds (cos, sin) of the continuous joints {', '.join(names)}, which must have length 1, got "
                f"lengths {np.round(radius, 4).tolist()}; Robot.configuration makes q from angles"
            )

    def expand(self, q: Array) -> Array:
        """Q (..., nq) → Pinocchio's q of all joints."""
        if self._plain:
            return q
        return _to_q(self.values(q) @ self.mixing.T + self.offsets, self.all_continuous)

    def reduce(self, J: Array, axis: int = -1) -> Array:
        """Derivatives by all joints → derivatives by the independent joints, along `axis`."""
        if self._plain:
            return J
        return np.moveaxis(np.moveaxis(J, axis, -1) @ self.mixing, -1, axis)

    def integrate(self, q: Array, dq: Array) -> Array:
        """Q ⊕ dq: angles of continuous joints are turned, so that (cos, sin) keeps length 1."""
        if not self.continuous.any():
            return q + dq
        return self.configuration(self.values(q) + dq)

    def difference(self, q_from: Array, q_to: Array) -> Array:
        """The dq with q_from ⊕ dq = q_to."""
        dq = self.values(q_to) - self.values(q_from)
        turned = dq[..., self.continuous]
        dq[..., self.continuous] = np.arctan2(np.sin(turned), np.cos(turned))
        return dq


def _to_q(values: Array, continuous: Mask) -> Array:
    if not continuous.any():
        return np.array(values, dtype=float)
    columns: list[Array] = []
    for index, turns in enumerate(continuous):
        value = values[..., index]
        columns += [np.cos(value), np.sin(value)] if turns else [value]
    return np.stack(columns, axis=-1)
