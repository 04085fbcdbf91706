"""Selectively damped least squares: each singular direction is limited by how far it moves the tip per joint motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, check_leading_axes, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.weighted import check_linear_rows, leading_rows
from robust_ik.kinematics.svd import RANK_TOLERANCE, svd

Clamp = Literal["hard", "smooth"]


@dataclass(frozen=True)
class SDLS(RobustInverse):
    """The step Σᵢ clamp((uᵢᵀẋ/σᵢ) vᵢ, γᵢ), clamped again to γ_max.

    γᵢ = γ_max Nᵢ/Mᵢ, where Nᵢ is how far the step along uᵢ should move the tip, and Mᵢ ≥ Nᵢ how far the single joints
    move it, added up even where they cancel: Nᵢ = Σ_l ‖u_{l,i}‖, Mᵢ = Σ_l Σ_j |v_{j,i}| ‖J_{l,j}‖/σᵢ over the blocks l
    of rows, linear and angular. If σᵢ → 0 because joints cancel each other, γᵢ → 0 too. No joint moves more than γ_max.

    It is a step method: `solve` takes ẋ for the wanted step Δx and gives Δq. A controller passes gain · error (plus
    feed-forward) as ẋ and takes q̇ from it: a step of one second, so that γ_max is a speed limit in rad/s; the
    error is not read again. The cap on far targets, the paper's D_max, is `FrameTask.max_linear`.

    Watch for: not linear in ẋ. If σᵢ → 0 because a single joint loses all effect, γᵢ stays: its speed jumps from
    −γ_max to γ_max. Below RANK_TOLERANCE σ₁, σᵢ counts as zero, and a joint without effect does not move. If singular
    values coincide and a clamp acts, the result depends on the basis that the decomposition happens to choose.
    γ_max limits prismatic joints too, in m. The angular block is our addition: the paper moves points only.

    Attributes:
        max_angle: γ_max > 0, rad.
        clamp: "hard" scales the part of a direction down to its limit (the paper); "smooth" scales it by γ/(γ + max|·|)
            (its code), also below the limit.
        length_scale: L > 0, m per rad: multiplies the angular rows.
        linear_rows: How many of the first rows are linear; default 3, or all of them if there are fewer.

    Source: Buss and Kim 2005.
    """

    source: ClassVar[str] = "Buss-Kim 2005"
    card: ClassVar[Card] = Card(
        formula="Σᵢ clamp((uᵢᵀẋ/σᵢ) vᵢ, γᵢ), γᵢ = γ_max Nᵢ/Mᵢ",
        largest_gain="none; |q̇ⱼ| ≤ γ_max",
        gain_at_zero="0 where joints cancel out; up to γ_max/‖ẋ‖ where one joint loses its effect",
        exact="ẋ → 0 with σ > 0",
        continuity="jumps where singular values coincide, and where a joint loses its effect",
    )
    max_angle: float = math.pi / 4
    clamp: Clamp = "hard"
    length_scale: float = 1.0
    linear_rows: int | None = None

    def __post_init__(self) -> None:
        checked_parameter("max_angle", self.max_angle, above=0)
        checked_parameter("length_scale", self.length_scale, above=0)
        check_linear_rows(self.linear_rows)
        if not isinstance(self.clamp, str) or self.clamp not in get_args(Clamp):
            raise InputError(f"clamp must be one of {', '.join(get_args(Clamp))}, got {self.clamp!r}")

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The joint step (..., n) for the wanted step ẋ; see `RobustInverse.solve`."""
        J = as_array(J, "J", (None, None))
        xdot = as_array(xdot, "xdot", (J.shape[-2],))
        check_leading_axes("J", J.shape[:-2], "xdot", xdot.shape[:-1])
        linear = leading_rows(self.linear_rows, J.shape[-2])
        scale = np.repeat([1.0, self.length_scale], [linear, J.shape[-2] - linear])
        J = scale[:, None] * J
        decomposition = svd(J)
        # A σ of rounding size has an arbitrary v: with the γ of a joint without effect, it would turn it at γ_max.
        s = np.where(decomposition.s > RANK_TOLERANCE * decomposition.s[..., :1], decomposition.s, 0.0)
        limits = self._limits(J, decomposition.U, s, decomposition.Vt, linear)
        wanted = np.einsum("...mi,...m->...i", decomposition.U, scale * xdot)
        steps = self._clamped_directions(wanted, s, decomposition.Vt, limits)
        return self._clamped_sum(np.einsum("...i,...ij->...j", steps, decomposition.Vt))

    def _limits(self, J: Array, U: Array, s: Array, Vt: Array, linear: int) -> Array:
        """γᵢ, (..., k)."""
        unit = np.where(s[..., :1] > 0, s[..., :1], 1.0)  # only ratios count: so no square overflows or underflows
        J, s = J / unit[..., None], s / unit
        wanted, moved = np.zeros_like(s), np.zeros_like(s)
        for block in (slice(0, linear), slice(linear, None)):
            wanted += np.linalg.norm(U[..., block, :], axis=-2)
            moved += np.einsum("...ij,...j->...i", np.abs(Vt), np.linalg.norm(J[..., block, :], axis=-2))
        # The paper's min(1, N/M) never acts, since moved = M σ ≥ Σ_l ‖J_l v‖ = N σ; so no division by zero either.
        return np.asarray(self.max_angle * wanted * s / np.where(s > 0, moved, 1.0))

    def _clamped_directions(self, wanted: Array, s: Array, Vt: Array, limits: Array) -> Array:
        """The clamped coefficients of vᵢ, (..., k), without division by a vanishing σ."""
        largest = np.abs(Vt).max(axis=-1)
        asked = np.abs(wanted) * largest
        if self.clamp == "hard":
            free = asked <= limits * s
            size = np.where(free, np.abs(wanted) / np.where(free & (s > 0), s, 1.0), limits / largest)
        else:
            size = np.abs(wanted) * limits / np.where(asked > 0, limits * s + asked, 1.0)
        return np.asarray(np.where(s > 0, np.sign(wanted) * size, 0.0))

    def _clamped_sum(self, step: Array) -> Array:
        """The step, scaled down so that no entry is beyond γ_max.

        The hard clamp in either case: the paper's code scales by γ_max/(γ_max + max|·|) where a limit is exceeded,
        so that the step would jump to half its size there.
        """
        largest = np.abs(step).max(axis=-1, keepdims=True)
        return np.asarray(step * (self.max_angle / np.maximum(largest, self.max_angle)))
