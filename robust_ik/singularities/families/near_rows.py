"""Tells whether a family of nearly the same arm is one of the arm itself. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence

from robust_ik.singularities.families.leaf_survey import accounts
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.geometry.screw_chain import ScrewChain

NEARLY_ALL = 0.9
"""Share of the members that lead to listed configurations. Chosen: a few end where strata cross."""


def is_listed(chain: ScrewChain, strata: Sequence[Stratum], row: Stratum) -> bool:
    """Whether the singular configurations of an arm next to a row of another arm lie on its own rows with equations.

    Args:
        chain: The arm.
        strata: Its own rows.
        row: A row of an arm that is nearly the same.
    """
    found = project(chain, row.corank, row.samples)
    if not found.converged.any():
        return False
    leaves = [leaf for each in strata if not each.curve and each.corank >= row.corank for leaf in each.leaves]
    met = accounts(chain, row.corank, leaves, found.values[found.converged])
    return bool(met.sum() >= NEARLY_ALL * len(row.samples))
