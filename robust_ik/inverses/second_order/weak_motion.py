"""The kernel motion that serves the weak rows best: least f(z) = ½‖Dz + τ/2 K[z, z] − c‖² + ½ zᵀ diag(μ) z.

f is a quartic with several minima. At a singularity its gradient at rest vanishes, but along a direction in which the
curvature serves the command f falls to both sides: rest is a saddle, and both sides are tried. Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.inverses.second_order.weak_rows import WeakRows, combined, upright
from robust_ik.kernels.second_order.second_order_layout import (
    BENT,
    ENOUGH,
    FARTHEST,
    FIRST_COME,
    FLAT,
    FLOOR,
    HYSTERESIS,
    LEAST_FADE,
    LITTLE,
    MOVING,
    ROUNDS,
    SHORTEST,
    STEPS,
    STIFF,
    TINY,
    TRIES,
)


@dataclass(frozen=True, eq=False)
class Quartic:
    """f, with what it was made from.

    Attributes:
        D: (k, p).
        K: τ times the curvature, (k, p, p).
        c: What is asked of it, (k,): the command, or as much of it as joints at `speed` can serve by curvature.
        mu: μ, (p,).
        look_ahead: τ, s.
        curvature: κ = max |eig C|/‖c‖, 1/rad.
    """

    D: Array
    K: Array
    c: Array
    mu: Array
    look_ahead: float
    curvature: float

    def residual(self, z: Array) -> Array:
        """C − Dz − τ/2 K[z, z], (k,)."""
        return np.asarray(self.c - (self.D + 0.5 * (self.K @ z)) @ z)

    def value(self, z: Array) -> float:
        """f(z)."""
        r = self.residual(z)
        return 0.5 * float(r @ r) + 0.5 * float(z @ (self.mu * z))

    @property
    def at_rest(self) -> Array:
        """The second derivative of f at z = 0, (p, p)."""
        return np.asarray(self.D.T @ self.D - combined(self.c, self.K) + np.diag(self.mu))

    def damped(self) -> Array:
        """The minimum without curvature, (p,)."""
        rows, wanted = np.vstack([self.D, np.diag(np.sqrt(self.mu))]), np.concatenate([self.c, np.zeros(len(self.mu))])
        return np.asarray(np.linalg.lstsq(rows, wanted, rcond=None)[0])

    def descended(self, z: Array) -> Array:
        """A minimum of f near z, (p,): Newton's method with |eigenvalues|, damped until f falls."""
        least, damping, value = 0.5 * float(self.mu.min()) + 1e-12, 0.0, self.value(z)
        enough, diagonal = ENOUGH * (float(np.sqrt(self.c @ self.c)) + 1e-12), np.diag(self.mu)
        for _ in range(ROUNDS):
            bent = self.K @ z
            slope, r = self.D + bent, self.c - (self.D + 0.5 * bent) @ z
            gradient = self.mu * z - r @ slope
            if np.abs(gradient).max() < enough:
                break
            values, vectors = np.linalg.eigh(slope.T @ slope - combined(r, self.K) + diagonal)
            values, slant = np.maximum(np.abs(values), least), vectors.T @ gradient
            for _ in range(TRIES):
                further = z - vectors @ (slant / (values + damping))
                lower = self.value(further)
                if lower < value:
                    break
                damping = max(4 * damping, 1e-3 * values[-1])
            else:
                break
            z, value, damping = further, lower, 0.25 * damping if damping > 4e-9 else 0.0
        return z


def quartic(rows: WeakRows, speed: float, acceleration: float, horizon: float, dt: float) -> Quartic:
    """F of weak rows.

    The look-ahead is the shortest that the actuators can honour. Towards a fold with curvature κ, tracking ẋ to the end
    takes a speed that grows without bound; a look-ahead τ brings it down to √(2c/(κτ)), and the deceleration to
    √(2c/(κτ³)).

    Args:
        rows: The weak rows.
        speed: Joint speed limit, rad/s.
        acceleration: Joint acceleration limit, rad/s².
        horizon: Longest look-ahead, s.
        dt: Time step, s.
    """
    k, p = rows.cross.shape
    size = rows.speed + TINY
    curvature = float(np.abs(np.linalg.eigvalsh(rows.pull)).max()) / size
    kappa = max(curvature, STIFF)
    wanted = max((2 * size / (kappa * acceleration**2)) ** (1 / 3), 2 * size / (kappa * speed**2))
    tau = min(max(wanted, SHORTEST, STEPS * dt), horizon)
    D = tau * rows.cross
    D[np.arange(k), np.arange(k)] += rows.sigma
    possible = float(np.linalg.norm(D, 2)) * speed + 0.5 * tau * curvature * speed**2
    bent = float(np.clip((curvature / FLAT - LITTLE) / (1 - LITTLE), 0, 1))
    cut = bent * max(0.0, 1 - possible / size)
    size *= 1 - rows.fade * cut
    squared = FLOOR**2 + max(0.0, (size / (2 * speed)) ** 2 - BENT * size * curvature * tau)
    mu = squared * np.concatenate([rows.fades, np.full(p - k, max(rows.fade, LEAST_FADE))])
    return Quartic(D, tau * rows.bend, (1 - rows.fades * cut) * rows.command, mu, tau, curvature)


def weak_motion(f: Quartic, rows: WeakRows, last: Array, speed: float) -> Array:
    """The z, (p,), with the least f; nearly equal minima are told apart by the last velocity.

    Args:
        f: The quartic.
        rows: The weak rows that it was made from.
        last: The last joint velocities, (n,).
        speed: Joint speed limit, rad/s: the faded part of z is at most FARTHEST times as fast.
    """
    kernel, size = rows.kernel, float(np.linalg.norm(rows.fades * f.c)) + TINY
    before, start = kernel.T @ last, f.damped()
    start = start * min(1.0, FARTHEST * speed / max(float(np.linalg.norm(start)), TINY))
    starts = [start]
    values, vectors = np.linalg.eigh(f.at_rest)
    if values[0] < 0:
        d = vectors[:, 0]
        far = min(np.sqrt(2 * size / (max(f.curvature, STIFF) * f.look_ahead)), FARTHEST * speed)
        side = chosen_side(before @ d, start @ d, kernel @ d, speed)
        starts.append(side * far * d)
        if abs(before @ d) <= MOVING * speed:
            starts.append(-side * far * d)
    if np.abs(before).max() > MOVING * speed:
        starts.append(before)
    ends = [f.descended(z) for z in starts]
    turn = HYSTERESIS * (size / speed) ** 2
    costs = [f.value(z) + turn * min(1.0, float(np.sum((z - before) ** 2))) for z in ends]
    z = ends[int(np.argmin(np.array(costs) + FIRST_COME * size**2 * np.arange(len(costs))))]
    fastest = float(np.linalg.norm(rows.reach * z))
    return z * (1 - rows.reach * max(0.0, 1 - FARTHEST * speed / max(fastest, TINY)))


def chosen_side(before: float, start: float, motion: Array, speed: float) -> float:
    """±1: on along the last velocity, else as the first-order motion, else so that the largest joint turns positive."""
    if abs(before) > MOVING * speed:
        return float(np.sign(before))
    if abs(start) > MOVING**2 * speed:
        return float(np.sign(start))
    return upright(motion)
