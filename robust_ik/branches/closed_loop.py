"""ClosedLoop: joints whose motors shall multiply to a displacement, or take a point where it does. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import ONE, conjugate, joint_motor, moved, product
from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd

ON_CURVE = 1e-11
"""Largest entry of the error of a point that counts as on the curve."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """Joints in a row whose motors shall multiply to g, or take a point to where g takes it.

    Attributes:
        axes: (k, 8).
        slides: (k,).
        g: (8,).
        point: (3,); if `rotates` is False, its position alone is wanted.
        rotates: Whether the rotation is wanted, too.
        lower: Limits of the first joints, those of the arm.
        upper: The same.
    """

    axes: Array
    slides: NDArray[np.bool_]
    g: Array
    point: Array
    rotates: bool
    lower: Array
    upper: Array

    def state(self, values: Array) -> tuple[Array, Array]:
        """The twist to g, (6,) or (3,), and the Jacobian, (6, k) or (3, k)."""
        M, columns = ONE, []
        for axis, slides, value in zip(self.axes, self.slides, values):
            columns.append(moved(M, axis))
            M = product(M, joint_motor(axis, float(value), bool(slides)))
        J = np.stack(columns, axis=-1)
        if self.rotates:
            error = product(self.g, conjugate(M))
            w = np.copysign(max(abs(error[0]), 0.1), error[0])
            return 2 * error[[1, 2, 3, 5, 6, 7]] / w, J[[1, 2, 3, 5, 6, 7]]
        at = placed(M, self.point)
        return placed(self.g, self.point) - at, J[5:] + np.cross(J[1:4], at, axis=0)

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

    @cached_property
    def free(self) -> ClosedLoop:
        """The same loop without limits."""
        none = np.full(len(self.lower), np.inf)
        return ClosedLoop(self.axes, self.slides, self.g, self.point, self.rotates, -none, none)


def placed(M: Array, point: Array) -> Array:
    """Where a motor takes a point, (3,)."""
    after = product(product(M, np.array([1.0, 0, 0, 0, 0, *point])), conjugate(M) * np.array([1.0] * 4 + [-1.0] * 4))
    return np.asarray(after[5:])
