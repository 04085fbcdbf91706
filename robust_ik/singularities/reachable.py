"""The task rows that a chain can move at all. NumPy only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robust_ik.linalg import svd
from robust_ik.rows import ROWS
from robust_ik.singularities.kinematics import ScrewChain

SAMPLES = 20
LOST = 1e-3
"""A file that rounds π/2 leaves ratios of singular values of 1e-5."""


def reachable_rows(chain: ScrewChain) -> ScrewChain:
    """The chain in its task rows if they have full rank somewhere, else in those of them that have, positions first.

    An arm with fewer joints than task rows is singular everywhere in them.
    """
    if not _always_deficient(chain):
        return chain
    chosen: tuple[str, ...] = ()
    for row in sorted(chain.rows, key=ROWS.index):
        done = len(chosen) > 1 and row.startswith("w")
        if not done and not _always_deficient(replace(chain, rows=(*chosen, row))):
            chosen = (*chosen, row)
    return replace(chain, rows=chosen or chain.rows[:1])


def _always_deficient(chain: ScrewChain) -> bool:
    if chain.m > chain.n:
        return True
    s = svd(chain.jacobian(chain.random(np.random.default_rng(0), SAMPLES))).s
    return bool((s[:, -1] <= LOST * s[:, 0]).all())
