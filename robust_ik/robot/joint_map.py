"""Maps the n independent joints to Pinocchio's configuration vector: continuous joints, mimic joints."""

from __future__ import annotations

import math
import reprlib
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Self, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_array, readonly
from robust_ik.description.joint_tree import Description
from robust_ik.errors import InputError

Mask = NDArray[np.bool_]

UNIT_CIRCLE_TOLERANCE = 1e-6
"""Largest difference of a (cos, sin) from length 1.

Chosen: integration and files of seven digits pass, mistakes do not.
"""
FLOAT = np.dtype(float)


@dataclass(frozen=True, eq=False)
class JointMap:
    """Maps between joint values, q of the independent joints, and Pinocchio's q of all joints.

    A continuous joint has one value, an angle, and two entries of q, its cosine and sine. A mimic joint has a value
    multiplier · source + offset and no entry in q.

    Attributes:
        names: Independent joints, in Pinocchio's order.
        continuous: Which of them are continuous, (n,).
        prismatic: Which of them slide, (n,).
        mixing: Values of all joints = mixing @ values + offsets, (N, n).
        offsets: (N,).
        circling: Which of all joints are continuous, (N,).
    """

    names: tuple[str, ...]
    continuous: Mask
    prismatic: Mask
    mixing: Array
    offsets: Array
    circling: Mask

    @classmethod
    def of(cls, description: Description, model_names: list[str]) -> Self:
        """The map for a model with the joints `model_names`, among them the source of every mimic joint."""
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
            circling=readonly([joint.kind == "continuous" for joint in joints], bool),
        )

    def __post_init__(self) -> None:
        for name in ("continuous", "prismatic", "mixing", "offsets", "circling"):
            getattr(self, name).setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, since copies must be read-only too.
        return type(self), tuple(getattr(self, each.name) for each in fields(self))

    @cached_property
    def nq(self) -> int:
        """Length of q of the independent joints."""
        return len(self.names) + int(self.continuous.sum())

    @cached_property
    def independent(self) -> bool:
        """Whether no joint follows another, so that q is Pinocchio's q."""
        return len(self.offsets) == len(self.names)

    def all_joints(self, q: Array) -> Array:
        """Pinocchio's q of all joints, from q (nq,)."""
        return q if self.independent else _to_q(self.mixing @ self.values(q) + self.offsets, self.circling)

    def configuration(self, values: Array) -> Array:
        """Joint values (..., n) → q (..., nq)."""
        return _to_q(values, self.continuous)

    def values(self, q: Array) -> Array:
        """Joint values (..., n) of q (..., nq), angles of continuous joints in (−π, π]."""
        if not self.continuous.any():
            return q.copy()
        values = q[..., self.first]
        turning = self.first[self.continuous]
        values[..., self.continuous] = np.arctan2(q[..., turning + 1], q[..., turning])
        return values

    @cached_property
    def first(self) -> NDArray[np.int_]:
        """Index in q of each joint, of its cosine for a continuous one, (n,)."""
        before: NDArray[np.int_] = np.cumsum(self.continuous) - self.continuous
        return np.asarray(np.arange(len(self.names)) + before)

    def limits(self, description: Description, model_names: list[str]) -> tuple[Array, Array, Array]:
        """Lower, upper and speed limits of the independent joints, (n,) each, so that mimic joints keep theirs too.

        Position limits of a mimic joint that leave its source no room are ignored: in some files its sign is wrong
        (the PR2's grippers).
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

    def checked(self, q: ArrayLike, robot: str) -> Array:
        """Q as an array (..., nq) of finite numbers, checked.

        Args:
            q: What was given.
            robot: The robot's name, for the message.

        Raises:
            InputError: It is not such an array, or its (cos, sin) pairs are not on the unit circle.
        """
        array = q if self._is_plain(q) else self._as_array(q, robot)
        if len(self._turning):
            self._check_circles(array)
        return array

    def _is_plain(self, q: ArrayLike) -> TypeGuard[Array]:
        """Whether q is one vector of the right length with a finite sum: a quick test before the full checks."""
        return type(q) is np.ndarray and q.dtype is FLOAT and q.shape == (self.nq,) and math.isfinite(sum(q.tolist()))

    def _as_array(self, q: ArrayLike, robot: str) -> Array:
        try:
            return as_array(q, "q", (self.nq,))
        except InputError as error:
            hint = " (continuous joints take cos and sin; see Robot.configuration)" if len(self._turning) else ""
            raise InputError(f"{error}; {robot} has joints {', '.join(self.names)}{hint}") from None

    @cached_property
    def _turning(self) -> list[int]:
        """Indices of cosines in q."""
        return [int(place) for place in self.first[self.continuous]]

    def _check_circles(self, q: Array) -> None:
        if q.ndim == 1:
            radius = np.array([math.hypot(q.item(place), q.item(place + 1)) for place in self._turning])
        else:
            radius = np.hypot(q[..., self._turning], q[..., [place + 1 for place in self._turning]])
        if not (abs(radius - 1) <= UNIT_CIRCLE_TOLERANCE).all():
            names = [name for name, turns in zip(self.names, self.continuous) if turns]
            raise InputError(
                f"q holds (cos, sin) of the continuous joints {', '.join(names)}, which must have length 1, got a "
                f"length of {radius.flat[np.argmax(np.abs(radius - 1))]:.4g}; Robot.configuration makes q from angles"
            )

    def random(
        self, rng: np.random.Generator, size: int | tuple[int, ...], lower: Array, upper: Array, unit: float = 1.0
    ) -> Array:
        """Uniform random configurations between limits (n,), (*size, nq); see `Robot.random`."""
        shape = size if isinstance(size, tuple) else (size,)
        if not all(
            type(length) is not bool and isinstance(length, (int, np.integer)) and length >= 0 for length in shape
        ):
            raise InputError(f"size must be a count or a tuple of counts, got {size!r}")
        if not isinstance(rng, np.random.Generator):
            raise InputError(f"rng must be a numpy Generator, got {reprlib.repr(rng)}")
        return self.configuration(rng.uniform(*self.finite_limits(lower, upper, unit), (*shape, len(self.names))))

    def finite_limits(self, lower: Array, upper: Array, unit: float = 1.0) -> tuple[Array, Array]:
        """Limits (n,) with missing ones filled in.

        A missing limit is a full turn or two units from the other one; if both are missing they are ±π or ± a unit, m.
        """
        half = np.where(self.prismatic, unit, np.pi)
        low, high = np.isfinite(lower), np.isfinite(upper)
        return (
            np.where(low, lower, np.where(high, upper - 2 * half, -half)),
            np.where(high, upper, np.where(low, lower + 2 * half, half)),
        )

    def integrate(self, q: Array, dq: Array) -> Array:
        """Q ⊕ dq: angles of continuous joints are rotated, so that (cos, sin) keeps length 1."""
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
