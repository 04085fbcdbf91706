"""The ESRIM paper's examples from many starts of the same pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.claims.many import TINY, along_self_motion, loaded, run_many
from benchmarks.claims.spread import Spread
from robust_ik.checks import Array

TOLERANCE = 0.5
"""mm."""
COPIES = 3
COARSE, FINE = 0.05, 0.01
"""Time steps: at 5 mm/s they are 0.25 mm, the scenarios' own, and 0.05 mm, the paper's."""
PAST = {"esrim_line": 12.0, "esrim_arc": 40.0, "esrim_10_axis": 33.0, "esrim_arc_second": 22.0}
"""Seconds until the singularity is passed."""


@dataclass(frozen=True, eq=False)
class Passes:
    """What became of runs from N starts, and from N that differ from them by rounding, and so on.

    Attributes:
        error: Largest distance from the path, (COPIES, N), mm.
        turned: Largest angle from it, (COPIES, N), degrees.
        step: Largest ‖Δθ‖, (COPIES, N), rad.
        sigma: Least singular value, (COPIES, N), m and rad.
    """

    error: Array
    turned: Array
    step: Array
    sigma: Array

    def __getitem__(self, some: slice) -> Passes:
        """Those from some of the starts."""
        return Passes(self.error[:, some], self.turned[:, some], self.step[:, some], self.sigma[:, some])

    @property
    def left(self) -> Spread:
        """Share of the starts from which the tolerance is left, %."""
        return Spread(tuple(100 * np.mean(self.error > TOLERANCE, axis=1)))


def passes(name: str, label: str, distances: Sequence[float] | Array, dt: float = COARSE) -> Passes:
    """A scenario with one of its methods until its singularity is passed, from starts so far along the self-motion."""
    scenario = replace(loaded(name), duration=PAST[name], dt=dt)
    q = np.tile(along_self_motion(scenario, distances), (COPIES, 1))
    q[len(distances) :] += np.random.default_rng(0).uniform(-TINY, TINY, q[len(distances) :].shape)
    runs = run_many(scenario, label, q)
    found = (
        1e3 * runs.position_error.max(axis=0),
        np.degrees(runs.rotation_error.max(axis=0)),
        dt * np.linalg.norm(runs.qdot, axis=-1).max(axis=0),
        runs.sigma[..., -1].min(axis=0),
    )
    return Passes(*(each.reshape(COPIES, -1) for each in found))
