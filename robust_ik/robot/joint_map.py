"""From the n independent joints to Pinocchio's configuration vector: continuous joints, mimic joints."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, readonly
from robust_ik.description.joint_tree import Description
from robust_ik.errors import InputError

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
    """

    names: tuple[str, ...]
    continuous: Mask
    prismatic: Mask
    mixing: Array
    offsets: Array

    @classmethod
    def of(cls, description: Description, model_names: list[str]) -> Self:
        """The map for a model whose joints are `model_names`, which hold the source of every mimic joint."""
        joints = [description.joint[name] for name in model_names]
        names = [joint.name for joint in joints if joint.mimic is None]
        mixing, offsets = np.zeros((len(joints), len(names))), np.zeros(len(joints))
        for row, joint in enumerate(joints):
            driver = description.driver[joint.name]
            mixing[row, names.index(driver.source)] = driver.multiplier
            offsets[row] = driver.offset
        kinds = [description.joint[name].kind for name in names]
        return cls(
            names=tuple(names),
            continuous=readonly([kind == "continuous" for kind in kinds], bool),
            prismatic=readonly([kind == "prismatic" for kind in kinds], bool),
            mixing=readonly(mixing),
            offsets=readonly(offsets),
        )

    def __post_init__(self) -> None:
        for name in ("continuous", "prismatic", "mixing", "offsets"):
            getattr(self, name).setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, so that copies are read-only too.
        return type(self), tuple(getattr(self, each.name) for each in fields(self))

    @property
    def nq(self) -> int:
        """Length of q of the independent joints."""
        return len(self.names) + int(self.continuous.sum())

    def configuration(self, values: Array) -> Array:
        """Joint values (..., n) → q (..., nq)."""
        return _to_q(values, self.continuous)

    def values(self, q: Array) -> Array:
        """Q (..., nq) → joint values (..., n), angles of continuous joints in (−π, π]."""
        if not self.continuous.any():
            return q.copy()
        values = q[..., self.first]
        turning = self.first[self.continuous]
        values[..., self.continuous] = np.arctan2(q[..., turning + 1], q[..., turning])
        return values

    @property
    def first(self) -> NDArray[np.int_]:
        """Where each joint's entry of q stands, the cosine for a continuous one, (n,)."""
        before: NDArray[np.int_] = np.cumsum(self.continuous) - self.continuous
        return np.asarray(np.arange(len(self.names)) + before)

    def limits(self, description: Description, model_names: list[str]) -> tuple[Array, Array, Array]:
        """Lower, upper and speed limits of the independent joints, (n,) each, those of their followers included.

        A follower's position limits that leave its source no room, as where the sign of a mimic was forgotten (the
        PR2's grippers), are passed over.
        """
        joints = [description.joint[name] for name in model_names]
        lower, upper = np.full(len(self.names), -np.inf), np.full(len(self.names), np.inf)
        speed = np.full(len(self.names), np.inf)
        for row, joint in sorted(enumerate(joints), key=lambda pair: pair[1].mimic is not None):
            index = self.names.index(description.driver[joint.name].source)
            factor, offset = self.mixing[row, index], self.offsets[row]
            if factor == 0:
                continue
            ends = sorted([(joint.lower - offset) / factor, (joint.upper - offset) / factor])
            low, high = max(lower[index], ends[0]), min(upper[index], ends[1])
            if low < high or joint.mimic is None:
                lower[index], upper[index] = low, high
            speed[index] = min(speed[index], joint.velocity / abs(factor))
        return lower, upper, speed

    def check(self, q: Array) -> None:
        """Refuses a q whose (cos, sin) pairs are not on the unit circle."""
        if not self.continuous.any():
            return
        first = self.first[self.continuous]
        radius = np.hypot(q[..., first], q[..., first + 1])
        if (np.abs(radius - 1) > UNIT_CIRCLE_TOLERANCE).any():
            names = [name for name, turns in zip(self.names, self.continuous) if turns]
            raise InputError(
                f"q holds (cos, sin) of the continuous joints {', '.join(names)}, which must have length 1, got a "
                f"length of {radius.flat[np.argmax(np.abs(radius - 1))]:.4g}; Robot.configuration makes q from angles"
            )

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
