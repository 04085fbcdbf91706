"""The rows of a task that are nearly lost, to second order in the joint motions that are free there.

J = U diag(σ) Vᵀ is split at γσ₁. The kept rows fix a part q̇ₚ of the motion; what is left free is the kernel, weak
right singular vectors and null space together: at σ = 0 nothing tells them apart. For a kernel motion z, over a
look-ahead τ, the weak rows move at σᵢzᵢ + τ (Gz)ᵢ + τ/2 Kᵢ[z, z]: by what σ is, by how it changes as the kept rows
move, and by its own curvature. Everything is divided by σ₁, so that task speeds are in rad/s. Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.kernels.second_order.second_order_layout import LARGE, NEARLY
from robust_ik.kinematics.svd import whole_svd


@dataclass(frozen=True, eq=False)
class WeakRows:
    """The k weak rows of a task of rank r + k, and the p kernel motions.

    Attributes:
        sigma: σ/σ₁ of the weak rows, (k,).
        directions: U₂, what is nearly lost, (m, k).
        span: Kept and weak directions, (m, r + k).
        largest: σ₁.
        command: c = U₂ᵀẋ/σ₁, (k,), rad/s.
        fades: w, (k,): 0 at the threshold, 1 from half of it.
        reach: The same for each kernel motion, (p,): that of its row, of null-space motions the largest.
        kernel: Z, orthonormal columns, (n, p); the first k belong to the weak rows.
        kept: q̇ₚ, the motion of the kept rows, (n,).
        bend: K, (k, p, p), symmetric, faded: per rad.
        cross: G, (k, p), faded.
        turning: How fast the lost command turns towards the kept rows along the kernel, (r, p), 1/rad.
    """

    sigma: Array
    directions: Array
    span: Array
    largest: float
    command: Array
    fades: Array
    reach: Array
    kernel: Array
    kept: Array
    bend: Array
    cross: Array
    turning: Array

    @property
    def fade(self) -> float:
        """The largest of the fades."""
        return float(self.fades.max())

    @property
    def speed(self) -> float:
        """‖w c‖, rad/s."""
        return float(np.linalg.norm(self.fades * self.command))

    @property
    def pull(self) -> Array:
        """C = Σ cᵢKᵢ, (p, p): along its positive eigenvectors curvature leads where the command wants to go."""
        return combined(self.command, self.bend)


def combined(weights: Array, matrices: Array) -> Array:
    """Σ wᵢMᵢ: (k,), (k, a, b) → (a, b)."""
    k, a, b = matrices.shape
    return np.asarray((weights @ matrices.reshape(k, a * b)).reshape(a, b))


def upright(motion: Array) -> float:
    """±1, so that the largest joint of a motion (n,), the first of those that are nearly as large, turns positive."""
    size = np.abs(motion)
    return 1.0 if motion[np.argmax(size >= NEARLY * size.max())] >= 0 else -1.0


def fade(fraction: Array) -> Array:
    """1 up to half of the threshold, 0 from the threshold on, with slope 0 at both: (...) → (...)."""
    t = np.clip(2 * (1 - fraction), 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t))


def shortened(array: Array, most: float) -> Array:
    """The array, or a part of it whose largest entry is `most`."""
    largest = float(np.abs(array).max(initial=0.0))
    return array * (most / largest) if largest > most else array


def weak_rows(
    J: Array, xdot: Array, hessian: Array, gamma: float, *, least: float = 0.0, faded: bool = True
) -> WeakRows:
    """Splits J q̇ = ẋ at γσ₁.

    Args:
        J: (m, n), not zero.
        xdot: ẋ, (m,).
        hessian: ∂J/∂q, (m, n, n).
        gamma: γ.
        least: Least σ₁ to compare with, where a few rows may vanish together.
        faded: Whether what is second-order fades towards γ; else it counts in full.

    Returns:
        The weak rows; none, (0,), where all σ ≥ γσ₁. Rows that an arm with fewer joints never has are left out.
    """
    found = whole_svd(J)
    largest = max(float(found.s[0]), least)
    s, asked = found.s / largest, found.U.T @ xdot / largest
    r = int(np.sum(s >= gamma))
    U, V, Z = found.U[:, r : len(s)], found.Vt[:r].T, found.Vt[r:].T
    kept = V @ (asked[:r] / s[:r])
    fades = fade(s[r:] / gamma) if faded else np.ones(len(s) - r)
    reach = np.concatenate([fades, np.full(Z.shape[1] - len(fades), fades.max(initial=0.0))])
    m, n = J.shape
    forms = shortened(U.T @ hessian.reshape(m, n * n), LARGE * largest).reshape(-1, n, n) / largest
    forms = 0.5 * (forms + np.swapaxes(forms, 1, 2))
    along = forms @ Z
    bend = (Z.T @ along) * (reach[:, None] * reach) * fades[:, None, None]
    cross = (shortened(kept, LARGE) @ along) * reach * fades[:, None]
    command = shortened(asked[r : len(s)], LARGE)
    size = np.linalg.norm(command)
    lost = command / size if size > 0 else command
    turning = V.T @ combined(lost, along) / s[:r, None]
    return WeakRows(s[r:], U, found.U[:, : len(s)], largest, command, fades, reach, Z, kept, bend, cross, turning)
