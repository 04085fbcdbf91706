"""PathPlanner: joint motions along the poses of one frame, in some rows, prepared once. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.paths.between_solutions import CLOSE, Between
from robust_ik.paths.furthest_motion import ADDED, FINEST, SAME, FurthestMotion, travel
from robust_ik.paths.layer_solver import LayerSolver
from robust_ik.paths.path_error import path_error
from robust_ik.paths.path_stops import PathStops
from robust_ik.paths.pose_path import PosePath
from robust_ik.paths.result import PathPiece, PathPlan, PathStatus, PathStop
from robust_ik.paths.solution_layers import Layers

MOST_PLACES = 100_000
"""Most places that are solved for at first: what a path of a kilometre needs for an arm of usual size is a mistake."""
STEP = 0.05
"""Longest step between places that are solved for at first, rad, and lengths over the length scale."""


@dataclass(frozen=True, eq=False)
class PathPlanner:
    """Motions along paths of one frame; `Robot.path_planner` makes it.

    Attributes:
        solver: The arm.
    """

    solver: LayerSolver

    def plan(self, targets: Array, near: Array, accuracy: float, start: Array | None) -> PathPlan:
        """Motions along poses (p, 4, 4); see `Robot.plan_path`.

        Args:
            targets: The poses, checked.
            near: Joint values that the beginning is near to if nothing else decides, (n,).
            accuracy: How far the frame may leave the path, m, and rad times the length scale.
            start: Joint values that the motion begins at, (n,); None for any.

        Raises:
            InputError: The start does not reach the first pose; neighbouring poses are half a turn apart.
        """
        branches, scale = self.solver.branches, self.solver.length_scale
        wanted = targets
        if branches.arm is not None and branches.free.kept is not None:
            wanted = branches.free.reachable(targets, branches.arm.home)
        path = PosePath(wanted, scale, any(row in branches.rows for row in ROWS[3:]))
        if (count := path.count(STEP)) > MOST_PLACES:
            raise InputError(
                f"the path has {count} places {STEP:.3g} length scales apart, at most {MOST_PLACES} are solved for; "
                f"the longest way between two poses is {scale * path.steps.max():.3g} m"
            )
        if start is not None:
            near = np.where(self.solver.moving, near, start)
        between, stops = Between(path, self.solver, accuracy), PathStops(self.solver, near)
        s = path.places(STEP)
        layers = self.solver.layers(s, path.at(s), near)
        complete = layers.complete[np.isin(s, np.arange(len(path)))]
        if start is not None:
            layers = self._with_start(layers, start, accuracy)
        elif not layers.counts[0]:
            from_here = np.stack([near, self.solver.closest(layers.targets[0], near)])
            led, is_close = self.solver.led(path.at(s[[0, 0]]), from_here, CLOSE * accuracy)
            layers = layers.with_solutions(0, led[is_close], self.solver.sliding, SAME)
        pieces: list[PathPiece] = []
        reasons: list[PathStop] = []
        first, last = 0, None
        while True:
            search = FurthestMotion(self.solver, between, layers, first, near, start if first == 0 else None)
            places, values, reached = search.run()
            layers = search.layers
            if reached > first or (len(path) == 1 and reached == first):
                pieces.append(self._piece(places, values))
            if reached == len(layers) - 1:
                break
            if not layers.counts[reached + 1]:
                layers, first = self._entered(layers, path, reached + 1, near)
                reasons.append(stops.unreached(layers, reached + 1, values[-1] if len(values) else None))
                if first == len(layers):
                    break
            else:
                if reached != last:  # what ends at the same place is said once
                    reasons.append(stops.after(layers, reached, values[-1]))
                # A piece begins where the one before ends; a place from which no step leads is left out.
                last, first = reached, reached if reached > first else first + 1
        followed = len(pieces) == 1 and pieces[0].s[0] == 0.0 and pieces[0].s[-1] == len(path) - 1.0
        status = PathStatus.FOLLOWED if followed else PathStatus.INTERRUPTED
        return PathPlan(status, tuple(pieces), tuple(reasons), targets, complete)

    def _entered(self, layers: Layers, path: PosePath, first: int, near: Array) -> tuple[Layers, int]:
        """The layer where poses have solutions again behind `first`, which has none, with places added before it."""
        while True:
            some = np.flatnonzero(layers.counts[first:])
            end = first + int(some[0]) if len(some) else len(layers)
            if end == len(layers):
                return layers, end
            a, b = layers.s[end - 1], layers.s[end]
            if path.size_of(np.array([a]), np.array([b - a]))[0] <= FINEST:
                return layers, end
            s = a + (b - a) * np.arange(1, ADDED + 1) / (ADDED + 1)
            layers = layers.joined(self.solver.layers(s, path.at(s), near))

    def _with_start(self, layers: Layers, start: Array, accuracy: float) -> Layers:
        solver = self.solver
        off = float(path_error(solver.poses(start), layers.targets[0], solver.branches.rows, solver.length_scale))
        if off > accuracy:
            raise InputError(
                f"start misses the first pose by {1000 * off:.3g} mm (mrad times {solver.length_scale:.3g} m); "
                f"accuracy is {1000 * accuracy:.3g} mm: give a start there, or none"
            )
        return layers.with_solutions(0, start[None], solver.sliding, SAME)

    def _piece(self, s: Array, values: Array) -> PathPiece:
        solver = self.solver
        q = solver.branches.to_q(values)
        return PathPiece(s, q, values, travel(values, solver.weights), float(solver.margins(values).min()))
