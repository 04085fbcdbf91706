"""Why a motion ends: the next pose is out of reach, or beyond limits, or its solutions are others. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches import AllSolutions
from robust_ik.checks import Array
from robust_ik.kinematics.svd import full_svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.paths.layer_solver import AT_LIMIT, LONGEST, LayerSolver
from robust_ik.paths.path_error import path_error, path_twist
from robust_ik.paths.result import Hindrance, PathStop
from robust_ik.paths.solution_layers import Layers

SINGULAR = 0.03
"""σ over the largest one, with lengths over the length scale, up to which a motion is said to end at a singularity."""
LOOKED_AT = 8
"""How many poses of those out of reach are looked at."""
CONCERNED = 0.5
"""Joints that move at least this part of the one that moves most are concerned."""


class Missed(NamedTuple):
    """How a pose is missed."""

    by: float
    hindrance: Hindrance
    joints: tuple[str, ...]
    said: str


@dataclass(frozen=True, eq=False)
class PathStops:
    """Finds why motions end.

    Attributes:
        solver: The arm.
        near: Joint values, (n,).
    """

    solver: LayerSolver
    near: Array

    def unreached(self, layers: Layers, first: int, values: Array | None) -> PathStop:
        """Why poses from a layer on have no solution within limits.

        If a motion that ends at joint values (n,) would go on beyond limits, these are told; else what the pose lacks
        that is missed most, of some of them.
        """
        some = np.flatnonzero(layers.counts[first:])
        end = first + int(some[0]) if len(some) else len(layers)
        at, until = float(layers.s[max(first - 1, 0)]), float(layers.s[min(end, len(layers) - 1)])
        if values is not None:
            beyond = self.solver.values_of(self.solver.branches.solve(layers.targets[first], values).beyond)
            stop = self._limited(at, until, self.solver.difference(beyond, values), values)
            if stop is not None:
                return stop
        told = [self._missed(layers.targets[i]) for i in np.unique(np.linspace(first, end - 1, LOOKED_AT).astype(int))]
        worst = max(told, key=lambda one: (one.hindrance is Hindrance.OUT_OF_REACH, one.by))
        to_the_end = ", to the end of the path" if end == len(layers) else ""
        return PathStop(at, until, worst.hindrance, worst.joints, worst.said + to_the_end)

    def _missed(self, target: Array) -> Missed:
        solver, rows = self.solver, self.solver.branches.rows
        found = solver.branches.solve(target, self.near)
        if len(found.beyond):
            return self._beyond(found)
        closest = solver.poses(solver.closest(target, self.near))
        miss, twist = float(path_error(closest, target, rows, solver.length_scale)), path_twist(closest, target, rows)
        count = sum(row in ROWS[:3] for row in rows)
        told = [f"{1000 * float(np.linalg.norm(twist[:count])):.3g} mm"] if count else []
        told += [f"{np.degrees(float(np.linalg.norm(twist[count:]))):.3g}°"] if count < len(rows) else []
        shown = "no configuration reaches the path" if found.complete else "none was found that reaches the path"
        said = f"{shown}; the closest one found within limits misses it by up to {' and '.join(told)}"
        return Missed(miss, Hindrance.OUT_OF_REACH, (), said)

    def after(self, layers: Layers, layer: int, values: Array) -> PathStop:
        """Why a motion that ends at a layer, at joint values (n,), does not go on.

        Args:
            layers: The solutions along the path.
            layer: The last layer that is reached, not the last one of all.
            values: Joint values there.
        """
        count, s = int(layers.counts[layer + 1]), float(layers.s[layer])
        if not count:
            return self.unreached(layers, layer + 1, values)
        solver = self.solver
        motions = solver.difference(layers.values[layer + 1, :count], values)
        stop = self._limited(s, s, motions, values)
        if stop is not None:
            return stop
        far = np.abs(motions * solver.weights).max(axis=1)
        J = solver.jacobians(values)
        margin = float(solver.margins(values))
        if margin < SINGULAR:
            way = np.abs(full_svd(J).Vt[max(solver.rank, 1) - 1]) * solver.moving
            names = self._names(way >= CONCERNED * way.max())
            said = f"a singular configuration is reached, σ/σ₁ = {margin:.2g}: {' and '.join(names)} would have to jump"
            return PathStop(s, s, Hindrance.SINGULAR, names, said)
        best = int(far.argmin())
        moved = np.abs(motions[best] * solver.weights)
        names = self._names(moved >= CONCERNED * moved.max())
        said = f"the nearest solution of the next pose is {far[best]:.3g} rad away: {' and '.join(names)} would jump"
        return PathStop(s, s, Hindrance.FAR, names, said)

    def _limited(self, at: float, until: float, motions: Array, values: Array) -> PathStop | None:
        """A stop at the limits that the nearest one of motions (k, n) would pass; None if there is none near."""
        over = np.maximum(values + motions - self.solver.upper, self.solver.lower - values - motions) > AT_LIMIT
        far = np.abs(motions * self.solver.weights).max(axis=1, initial=0.0)
        passing = over.any(axis=1) & (far < LONGEST)
        if not passing.any():
            return None
        names = self._names(over[int(np.where(passing, far, np.inf).argmin())])
        return PathStop(at, until, Hindrance.LIMIT, names, f"{' and '.join(names)} would pass a limit")

    def _beyond(self, found: AllSolutions) -> Missed:
        solver = self.solver
        values = solver.values_of(found.beyond)
        over = np.maximum(np.maximum(values - solver.upper, solver.lower - values), 0.0)
        far = (over * solver.weights).max(axis=1)
        best = int(far.argmin())
        which = over[best] > AT_LIMIT
        told = [
            f"{name} by {1000 * by:.3g} mm" if slides else f"{name} by {np.degrees(by):.3g}°"
            for name, by, slides in zip(self._names(which), over[best][which], solver.sliding[which])
        ]
        said = f"reached beyond limits alone, by up to: {', '.join(told)}"
        return Missed(float(far[best]), Hindrance.BEYOND_LIMITS, self._names(which), said)

    def _names(self, which: NDArray[np.bool_]) -> tuple[str, ...]:
        return tuple(self.solver.branches.names[k] for k in np.flatnonzero(which))
