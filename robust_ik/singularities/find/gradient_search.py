"""The search of the paper, as a baseline: steepest descent of σ_{m−k+1}, with rotated clusters. Arrays only.

What the paper leaves open are parameters of `gradient_search`: how near each other singular values are that count as a
cluster, how the length of a step is searched for, and by what γ is chosen. Its defaults: 2 %, grids for both.

Source: Almarkhi-Maciejewski, section 2.2, eqs. (11) to (14).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_parameter
from robust_ik.checks.public_arguments import check_type, checked
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.find.gradient_clusters import rotated_gradients, shortest_mean
from robust_ik.singularities.find.line_search import SEARCHES, LineSearch, least_along, target_values
from robust_ik.singularities.find.projection_search import TOLERANCE, SearchEnds, project
from robust_ik.singularities.find.rank_residual import Indices, Residual, check_corank
from robust_ik.singularities.geometry.screw_chain import ScrewChain

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

Combination = Literal["searched", "shortest"]
COMBINATIONS = ("searched", "shortest")
"""How gradients of a cluster become one: (13) with each γ tried, or the shortest mean that any φ and γ make."""

STEPS = 200
"""Most steps of a search. Chosen: where it succeeds, the median is up to 148 (docs/singularities.md)."""
FOUND = 1e-6
"""σ_{m−k+1} that counts as zero, the paper's ε; below it the point is polished."""
CLUSTER = 0.02
"""Relative difference of singular values up to which they are a cluster.

Chosen: the paper says "nearly equal"; docs/singularities.md has what more and less of it does.
"""
PATIENCE = 3
"""Steps without descent after which a search ends.

Chosen: more take longer; the paper's claims are measured with 50.
"""
GAMMAS = np.linspace(0.0, 1.0, 6)
"""The grid for γ of (13). Chosen: each value costs a line search; finer ones take longer."""


@dataclass(frozen=True, eq=False)
class Slope:
    """The k smallest singular values at N configurations, and their derivatives.

    Attributes:
        weakest: σ_{m−k+1} to σ_m, (N, k).
        block: u_aᵀ (∂J/∂q) v_b of their vectors, (N, k, k, n): ∂σ/∂q on the diagonal, eq. (7).
    """

    weakest: Array
    block: Array

    @classmethod
    def at(cls, chain: ScrewChain, values: Array, corank: int) -> Slope:
        """The slope at joint values (N, n)."""
        found = svd(chain.jacobian(values))
        these = slice(chain.full_rank - corank, chain.full_rank)
        right = np.swapaxes(found.Vt[:, these], -1, -2)
        return cls(found.s[:, these], chain.contraction(values, found.U[..., these], right))

    def clusters(self, tolerance: float) -> Indices:
        """How many singular values are near the target's, including itself, (N,).

        Args:
            tolerance: Relative difference up to which they are near.
        """
        near = self.weakest >= (1 - tolerance) * self.weakest[:, :1]
        return np.asarray(np.sum(np.cumprod(near, axis=1), axis=1))


@checked
def gradient_search(
    robot: Robot | ScrewChain,
    corank: int,
    starts: ArrayLike,
    tolerance: float = TOLERANCE,
    *,
    rotated: bool = True,
    cluster: float = CLUSTER,
    combination: Combination = "searched",
    line_search: LineSearch = "grid",
    patience: int = PATIENCE,
    max_iterations: int = STEPS,
) -> SearchEnds:
    """The ends of N descents of σ_{m−k+1} by the gradient method of the paper, for comparison.

    `find_singularities` has a better method, which needs none of the parameters below. Joint limits play no part.

    Args:
        robot: An arm with a tip; its rows, lengths in metres. Or a `ScrewChain` of it, with rows and a unit of its own.
        corank: k, from 1 to the least of the numbers of rows and joints.
        starts: Joint values (`Robot.joint_values`), rad or m, (N, n).
        tolerance: ‖r‖/σ₁ that counts as zero, r being the k smallest singular values. Ends with σ_{m−k+1} below 1e-6,
            the paper's ε, are polished to it.
        rotated: Whether clusters are rotated and combined, eqs. (12) to (14); otherwise the gradient is that of the
            arbitrary vectors of the SVD, eq. (10).
        cluster: Relative difference of singular values up to which they are a cluster, from 0 to less than 1.
        combination: How the gradients of a cluster become one. "searched": rotated by (14), then by (13) with the γ
            from which a line search leads to the least σ_{m−k+1}. "shortest": the shortest one that any φ of (12) with
            any γ of (13) makes, against which all of a cluster fall fastest, to first order.
        line_search: How α of (11) is chosen. "grid": the best of a grid. "exact": the minimiser around the grid's best,
            by golden section. "nearest": the first minimiser on the way.
        patience: Steps that lower σ_{m−k+1} by less than a thousandth after which a search is given up.
        max_iterations: Most steps.

    Returns:
        Joint values, whether each converged, and its steps.

    Raises:
        TipError: The robot was loaded whole, without a tip.
        InputError: The robot cannot have this corank, or a parameter is out of range.

    Source: Almarkhi-Maciejewski, section 2.2, eqs. (11) to (14). Line search, cluster tolerance and choice of γ are
    not told there.
    """
    chain = chain_of(robot)
    check_corank(chain, corank)
    values = _starts(chain, starts)
    tolerance = checked_parameter("tolerance", tolerance, above=0)
    reading = checked_reading(rotated, cluster, combination, line_search)
    for name, count in (("patience", patience), ("max_iterations", max_iterations)):
        if count < 1:
            raise InputError(f"{name} must be at least 1, got {count}")
    target = target_values(chain, values, corank)
    idle, tries = np.zeros((2, len(values)), dtype=int)
    for _ in range(max_iterations):
        active = np.flatnonzero((target > FOUND) & (idle < patience))
        if active.size == 0:
            break
        slope = Slope.at(chain, values[active], corank)
        along = directions(chain, values[active], slope, reading)
        values[active], lower = least_along(
            chain, values[active], corank, slope.weakest[:, 0], along, reading.line_search
        )
        idle[active] = np.where(lower < 0.999 * target[active], 0, idle[active] + 1)
        target[active] = lower
        tries[active] += 1
    ended = SearchEnds(values, Residual.at(chain, values, corank), tries, np.zeros(len(values), dtype=bool))
    near = np.flatnonzero(target <= FOUND)
    polished = project(chain, corank, values[near], tolerance)
    ended.put(near, replace(polished, tries=np.zeros(len(near), dtype=int)), polished.converged)
    return ended


@dataclass(frozen=True)
class Reading:
    """What the paper leaves open, decided; the attributes are parameters of `gradient_search`."""

    rotated: bool = True
    cluster: float = CLUSTER
    combination: Combination = "searched"
    line_search: LineSearch = "grid"


def checked_reading(rotated: bool, cluster: float, combination: str, line_search: str) -> Reading:
    """The reading that these parameters describe.

    Raises:
        InputError: The tolerance is not in [0, 1), or there is no such combination or line search.
    """
    cluster = checked_parameter("cluster", cluster, least=0, below=1)
    for name, given, known in (
        ("combination", combination, COMBINATIONS),
        ("line_search", line_search, SEARCHES),
    ):
        if not isinstance(given, str) or given not in known:
            raise InputError(f"{name} must be one of {', '.join(map(repr, known))}, got {given!r}")
    return Reading(bool(rotated), cluster, combination, line_search)  # type: ignore[arg-type]


def chain_of(robot: Robot | ScrewChain) -> ScrewChain:
    """The chain that moves a robot's tip, lengths in metres; a chain is its own.

    Raises:
        TipError: The robot was loaded whole, without a tip.
        InputError: It is neither.
    """
    if isinstance(robot, ScrewChain):
        return robot
    check_type("robot", robot, "Robot")
    return ScrewChain.of(robot)


def _starts(chain: ScrewChain, starts: ArrayLike) -> Array:
    """A copy of the starts as joint values, (N, n).

    Raises:
        InputError: They have another shape.
    """
    given = as_measures(starts, "starts", (None, chain.n))
    if given.ndim != 2:
        raise InputError(f"starts must have shape (N, {chain.n}), got {given.shape}")
    return np.array(given)


def directions(chain: ScrewChain, values: Array, slope: Slope, reading: Reading) -> Array:
    """The gradient in eq. (11) at each of the values: ∂σ_{m−k+1}/∂q, within clusters eq. (13), (N, n)."""
    corank = slope.weakest.shape[1]
    chosen = slope.block[:, 0, 0].copy()
    clusters = slope.clusters(reading.cluster)
    for size in range(2, corank + 1 if reading.rotated else 0):
        which = np.flatnonzero(clusters == size)
        if which.size == 0:
            continue
        block = slope.block[which, :size, :size]
        if reading.combination == "shortest":
            chosen[which] = shortest_mean(block)
        else:
            chosen[which] = _combined(chain, values[which], corank, slope.weakest[which, 0], rotated_gradients(block))
    return chosen


def _combined(chain: ScrewChain, values: Array, corank: int, sigma: Array, gradients: Array) -> Array:
    """The gradients (N, c, n) combined to one by eq. (13), with each γ that leads to the least σ_{m−k+1}."""
    direction = gradients[:, 0]
    for other in np.moveaxis(gradients[:, 1:], 1, 0):
        tried = [gamma * direction + (1 - gamma) * other for gamma in GAMMAS]
        least = [least_along(chain, values, corank, sigma, each, None)[1] for each in tried]
        direction = np.stack(tried)[np.argmin(least, axis=0), np.arange(len(values))]
    return np.asarray(direction)
