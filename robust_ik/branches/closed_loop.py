"""ClosedLoop: joints whose motors shall multiply to a displacement, or take a point where it does. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import ONE, conjugate, joint_motor, product
from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd

ON_CURVE = 1e-11
"""Largest entry of the error of a point that counts as on the curve."""
MOST_STEPS, EXACT = 40, 4e-15
"""Most Newton steps towards a solution, and the error at which they end. Chosen: a fourfold root leaves .75 a step."""
SMALLEST, STEEP, LONGEST = 1e-9, 20.0, 0.5
"""Singular values up to SMALLEST, or STEEP times the error, of the largest one give no motion; the longest step."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """Joints in a row whose motors shall multiply to g, or take a point to where g takes it.

    Attributes:
        axes: (k, 8).
        slides: (k,).
        g: (8,).
        point: (3,); if `rotates` is False, its position alone is wanted.
        rotates: Whether the rotation is wanted, too.
        wanted: Which coordinates of the point are, (3,), if the rotation is not.
        lower: Limits of the first joints, those of the arm.
        upper: The same.
    """

    axes: Array
    slides: NDArray[np.bool_]
    g: Array
    point: Array
    rotates: bool
    wanted: NDArray[np.bool_]
    lower: Array
    upper: Array

    def state(self, values: Array) -> tuple[Array, Array]:
        """The twist to g, (6,), or what is wanted of the point's way, up to (3,); and the Jacobian."""
        from robust_ik.kernels.branches import state_of_loop

        axes, slides, g, p = self.given
        J, twist = np.empty((6, len(axes))), np.empty(6)
        state_of_loop.compiled(axes, slides, np.ascontiguousarray(values), g, p, 6 if self.rotates else 3, J, twist)
        if self.rotates:
            return twist, J
        return twist[:3][self.wanted], J[:3][self.wanted]

    @cached_property
    def given(self) -> tuple[Array, Array, Array, Array]:
        """What kernels are given: axes, which slide, g, the point with what is wanted of it."""
        p = np.concatenate([self.point, self.wanted])
        return np.ascontiguousarray(self.axes), self.slides.astype(float), np.ascontiguousarray(self.g), p

    def difference(self, a: Array, b: Array) -> Array:
        """A − b, turns modulo 2π, (..., k) or of the first joints alone."""
        d = a - b
        return np.where(self.slides[: d.shape[-1]], d, d - 2 * np.pi * np.round(d / (2 * np.pi)))

    def corrected(self, values: Array, rank: int) -> Array | None:
        """The values on the curve next to these, by Newton steps of a rank; None if there are none."""
        for _ in range(8):
            error, J = self.state(values)
            if np.abs(error).max() < ON_CURVE:
                return values
            found = svd(J)
            if not found.s[rank - 1] > 0:
                return None
            values = values + found.Vt[:rank].T @ (found.U[:, :rank].T @ error / found.s[:rank])
        return None

    def settled(self, values: Array) -> tuple[Array, float]:
        """The best values that Newton's method finds near these, and their error; at multiple roots it goes on slowly.

        Motions that are nearly lost are left out as in `kernels.branches.settling`.
        """
        best, least = values, np.inf
        for _ in range(MOST_STEPS):
            error, J = self.state(values)
            size = float(np.abs(error).max())
            if size < least:
                best, least = values, size
            if not EXACT < size < np.inf:
                break
            found = svd(J)
            kept = found.s > max(SMALLEST, STEEP * size) * found.s[0]
            step = found.Vt.T[:, kept] @ (found.U[:, kept].T @ error / found.s[kept])
            values = values + step * min(1.0, LONGEST / max(float(np.abs(step).max()), LONGEST))
        return best, least

    @cached_property
    def free(self) -> ClosedLoop:
        """The same loop without limits."""
        none = np.full(len(self.lower), np.inf)
        return replace(self, lower=-none, upper=none)

    def closed(self, values: Array) -> Array:
        """Values of all joints, (k,), where those of the arm reach g: a turn that floats, and slides behind it."""
        own, M = len(values), ONE
        for axis, slides, value in zip(self.axes, self.slides, values):
            M = product(M, joint_motor(axis, float(value), bool(slides)))
        rest, made = product(conjugate(M), self.g), [*values]
        for axis in self.axes[own:][~self.slides[own:]]:
            made.append(2 * np.arctan2(rest[1:4] @ axis[1:4], rest[0]))
            rest = product(conjugate(joint_motor(axis, made[-1], slides=False)), rest)
        for axis in self.axes[own:][self.slides[own:]]:
            made.append(2 * rest[5:] @ axis[5:] / rest[0])
        return np.array(made)
