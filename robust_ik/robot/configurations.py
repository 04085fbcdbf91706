"""What a robot's joints can be at: configurations, their values, and the way from one to another."""

from __future__ import annotations

import reprlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_array, check_leading_axes
from robust_ik.errors import InputError
from robust_ik.robot.joint_map import JointMap


class Configurations:
    """A part of `Robot`: what only its joints and limits are needed for."""

    name: str
    lower: Array
    upper: Array
    _joints: JointMap

    @property
    def n(self) -> int:
        """Number of independent joints, the length of q̇."""
        return len(self._joints.names)

    @property
    def nq(self) -> int:
        """Length of q: n, and one more for every continuous joint, which is stored as (cos, sin)."""
        return self._joints.nq

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The independent joints, in the order of q̇."""
        return self._joints.names

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """Which of the independent joints slide, (n,)."""
        return self._joints.prismatic

    @property
    def neutral(self) -> Array:
        """The configuration of all joints at zero, (nq,); it may lie outside the limits."""
        return self._joints.configuration(np.zeros(self.n))

    def configuration(self, values: ArrayLike) -> Array:
        """Joint values (..., n) in rad or m → q (..., nq)."""
        return self._joints.configuration(as_array(values, "values", (self.n,)))

    def joint_values(self, q: ArrayLike) -> Array:
        """Configurations q (..., nq) → joint values (..., n) in rad or m; continuous joints in (−π, π]."""
        return self._joints.values(self._checked(q))

    def random(self, rng: np.random.Generator, size: int | tuple[int, ...] = ()) -> Array:
        """Uniform random configurations inside the limits, (*size, nq).

        Where limits are not stated: a full turn for a revolute joint, 2 m for a prismatic one.
        """
        shape = size if isinstance(size, tuple) else (size,)
        if not all(
            type(length) is not bool and isinstance(length, (int, np.integer)) and length >= 0 for length in shape
        ):
            raise InputError(f"size must be a count or a tuple of counts, got {size!r}")
        if not isinstance(rng, np.random.Generator):
            raise InputError(f"rng must be a numpy Generator, got {reprlib.repr(rng)}")
        lower, upper = self._span()
        return self._joints.configuration(rng.uniform(lower, upper, (*shape, self.n)))

    def _span(self) -> tuple[Array, Array]:
        """Finite limits: where one end is not stated, a full turn or 2 m from the other; ±π or ±1 m where none is."""
        half = np.where(self._joints.prismatic, 1.0, np.pi)
        low, high = np.isfinite(self.lower), np.isfinite(self.upper)
        lower = np.where(low, self.lower, np.where(high, self.upper - 2 * half, -half))
        upper = np.where(high, self.upper, np.where(low, self.lower + 2 * half, half))
        return lower, upper

    def integrate(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """Q ⊕ dq on the manifold: (..., nq) and (..., n) → (..., nq), leading axes broadcast."""
        q, dq = self._checked(q), as_array(dq, "dq", (self.n,))
        check_leading_axes("q", q.shape[:-1], "dq", dq.shape[:-1])
        return self._joints.integrate(q, dq)

    def difference(self, q_from: ArrayLike, q_to: ArrayLike) -> Array:
        """The dq with q_from ⊕ dq = q_to, (..., n); the short way round for continuous joints."""
        q_from, q_to = self._checked(q_from), self._checked(q_to)
        check_leading_axes("q_from", q_from.shape[:-1], "q_to", q_to.shape[:-1])
        return self._joints.difference(q_from, q_to)

    def _checked(self, q: ArrayLike) -> Array:
        try:
            q = as_array(q, "q", (self.nq,))
        except InputError as error:
            hint = " (continuous joints take cos and sin; see Robot.configuration)" if self.nq != self.n else ""
            raise InputError(f"{error}; {self.name} has joints {', '.join(self.joint_names)}{hint}") from None
        self._joints.check(q)
        return q
