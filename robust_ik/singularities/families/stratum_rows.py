"""Makes the rows of the atlas from verified leaves: words, pieces, limits, floors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.connected_pieces import count_components
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.families.leaf_merging import rows
from robust_ik.singularities.families.limit_margin import margins
from robust_ik.singularities.families.stratum import Stratum, stratum
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.find.tangent_walk import relative_sigmas
from robust_ik.singularities.lost_motion.along_a_stratum import lost_along

FILLS = 16
"""Random members of a leaf at which σ is measured. Chosen: more find a larger largest σ, but take longer."""
EDGE = 1e-9
"""A margin above minus this counts as within the limits, rad."""


def make_rows(facts: RobotFacts, leaves: Sequence[Leaf], rng: np.random.Generator) -> Iterator[list[Stratum]]:
    """The rows of each corank that has any, coranks ascending."""
    for corank in sorted({leaf.corank for leaf in leaves}):
        groups = rows([leaf for leaf in leaves if leaf.corank == corank])
        yield sorted((_row(facts, group, rng) for group in groups), key=_order)


def in_metres(facts: RobotFacts, row: Stratum) -> Stratum:
    """A row of joint values in `facts.units`, as one of values in rad and m."""
    if (facts.units == 1).all():
        return row
    metric = facts.measured_in(1 / facts.units)
    told = row.measured_in(1 / facts.units, facts.symbols)
    return replace(told, lost=lost_along(metric.chain, facts.tool, row.corank, told.samples))


def _order(row: Stratum) -> tuple[int, int, tuple[tuple[int, ...], ...], str]:
    """A sort key: large dimensions first, then by joints."""
    return row.corank, -row.dimension, tuple(each.angle.joints for each in row.conditions), row.words


def _row(facts: RobotFacts, leaves: Sequence[Leaf], rng: np.random.Generator) -> Stratum:
    pieces, exact = count_components(facts.chain, leaves[0], rng)
    members = np.concatenate([leaf.filled(facts.chain, rng, FILLS) for leaf in leaves])
    residual = float(relative_sigmas(facts.chain, members)[:, facts.chain.full_rank - leaves[0].corank].max())
    row = stratum(leaves, facts.symbols, (pieces * len(leaves), exact), residual)
    off, floor = _as_given(facts, row, members)
    lost = lost_along(facts.chain, facts.tool, row.corank, row.samples)
    return replace(_within(facts, row), off=off, floor=floor, lost=lost)


def _as_given(facts: RobotFacts, row: Stratum, members: Array) -> tuple[float, float]:
    """Largest σ_{r−k+1} of the model as given, at samples and members (N, n) of a row, and after descent from these."""
    weakest = facts.given.full_rank - row.corank
    told = replace(facts.given.measured_in(1 / facts.units), length_scale=facts.length_scale)
    off = float(svd(told.jacobian(np.concatenate([members, row.samples]) * facts.units)).s[:, weakest].max())
    if facts.given is facts.chain:
        return off, 0.0
    found = project(facts.given, row.corank, members)
    floors = svd(told.jacobian(found.values * facts.units)).s[:, weakest]
    return off, float(np.where(found.converged, 0.0, floors).max())


def _within(facts: RobotFacts, row: Stratum) -> Stratum:
    """The row with the part of it that lies within the joint limits."""
    leaves = row.leaves
    sizes = margins(facts.chain, leaves, facts.lower, facts.upper)
    inside = tuple(tuple(pin.value for pin in leaf.pins) for size, leaf in zip(sizes, leaves) if size >= -EDGE)
    return replace(row, within_limits=bool(inside), margin=max(sizes), inside=inside)
