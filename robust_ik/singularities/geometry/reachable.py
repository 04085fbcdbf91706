"""The task rows that a chain can move at all. NumPy only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robust_ik.kinematics.svd import singular_values
from robust_ik.kinematics.twist_rows import always_deficient, movable_rows
from robust_ik.singularities.geometry.screw_chain import ScrewChain

SAMPLES = 20


def reachable_rows(chain: ScrewChain) -> ScrewChain:
    """The chain in its task rows if they have full rank somewhere, else in those of them that have.

    In metres, whatever its length scale: which rows can be moved is no matter of units.
    """

    def deficient(rows: tuple[str, ...]) -> bool:
        J = replace(chain, rows=rows, length_scale=1.0).jacobian(values)
        return always_deficient(singular_values(J), len(rows), chain.n)

    values = chain.random(np.random.default_rng(0), SAMPLES)
    rows = movable_rows(chain.rows, deficient)
    return chain if rows == chain.rows else replace(chain, rows=rows)
