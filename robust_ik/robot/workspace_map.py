"""Workspace maps: random configurations, their tip positions and singular values, also averaged over cells."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, checked_parameter, readonly
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError, suggest
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import checked_rows
from robust_ik.robot.robot import Robot
from robust_ik.runtime.parallel import chunk_sizes, run_pieces, seed_of
from robust_ik.runtime.progress import ProgressCallback

COUNT, CHUNK = 20_000, 5_000
"""Configurations of a map, and of a worker's piece.

Chosen: more fill finer cells; larger pieces are shared less evenly.
"""
QUANTITIES = ("smallest sigma", "manipulability", "inverse condition")
AXES = ("x", "y", "z")
MOST_CELLS = 10_000_000
"""Most cells of a map. Chosen: they take about 0.2 GB; more come only from a size in wrong units."""
ON_THE_LINE = 1e-9
"""A position this close below a border, as a fraction of a cell, counts as on it: rounding does not move it."""


@dataclass(frozen=True, eq=False)
class Cells:
    """A quantity of a map by position: cells of equal sides along some axes, unlimited along the others.

    Attributes:
        quantity: Name of the quantity.
        axes: The axes with cells, c of x y z.
        edges: For each of them the borders of cells, m; one more than there are cells.
        count: Configurations in each cell, one array axis for each of `axes`.
        best: The largest value in each cell, NaN if it is empty.
        mean: The mean value in each cell.
    """

    quantity: str
    axes: tuple[str, ...]
    edges: tuple[Array, ...]
    count: NDArray[np.int_]
    best: Array
    mean: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "edges", tuple(readonly(each) for each in self.edges))
        object.__setattr__(self, "count", readonly(self.count, int))
        object.__setattr__(self, "best", readonly(self.best))
        object.__setattr__(self, "mean", readonly(self.mean))


@dataclass(frozen=True, eq=False)
class WorkspaceMap:
    """N random configurations within the joint limits, with tip position and singular values of each.

    Attributes:
        robot: The robot.
        rows: Task rows of the Jacobian.
        length_scale: Length by which linear rows were divided, m.
        seed: Seed of the random numbers.
        q: Configurations, (N, nq).
        positions: Tip positions, world axes, m, (N, 3).
        sigma: Singular values of the Jacobian, descending, (N, k).
    """

    robot: Robot
    rows: tuple[str, ...]
    length_scale: float
    seed: int
    q: Array = field(repr=False)
    positions: Array = field(repr=False)
    sigma: Array = field(repr=False)

    def __post_init__(self) -> None:
        for name in ("q", "positions", "sigma"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.q)

    @property
    def smallest_sigma(self) -> Array:
        """σ_k, (N,): tip speed in the weakest direction for a joint speed of 1."""
        return self.sigma[:, -1]

    @property
    def manipulability(self) -> Array:
        """Π σᵢ, (N,)."""
        return np.asarray(np.prod(self.sigma, axis=1))

    @property
    def inverse_condition(self) -> Array:
        """σ_k/σ₁, (N,): 1 if all directions are alike, 0 at a singularity."""
        largest = self.sigma[:, 0]
        return np.asarray(self.sigma[:, -1] / np.where(largest > 0, largest, 1.0))

    @checked
    def values(self, quantity: str) -> Array:
        """Values of "smallest sigma", "manipulability" or "inverse condition", (N,).

        Raises:
            InputError: There is no such quantity.
        """
        if quantity not in QUANTITIES:
            raise InputError(f"there is no quantity {quantity!r}; {suggest(str(quantity), QUANTITIES)}")
        found: Array = getattr(self, quantity.replace(" ", "_"))
        return found

    @checked
    def cells(self, quantity: str = "smallest sigma", *, size: float = 0.05, axes: Sequence[str] = AXES) -> Cells:
        """Statistics of a quantity in cells of the workspace.

        Args:
            quantity: As for `values`.
            size: Side of a cell, m; cells begin at multiples of it.
            axes: The axes along which there are cells, of x y z.

        Raises:
            InputError: There is no such quantity or axis, or the cells are too many.
        """
        values, size = self.values(quantity), checked_parameter("size", size, above=0)
        if len(axes) == 0 or len(set(axes)) != len(axes) or not set(axes) <= set(AXES):
            raise InputError(f"axes must be some of x y z, each once, got {axes!r}")
        places = np.floor(self.positions[:, [AXES.index(axis) for axis in axes]] / size + ON_THE_LINE)
        first = places.min(axis=0)
        shape = places.max(axis=0) - first + 1
        if np.prod(shape) > MOST_CELLS:
            raise InputError(f"cells of {size:g} m are {np.prod(shape):.0f}, more than {MOST_CELLS}: take larger ones")
        shape = shape.astype(int)
        where = np.ravel_multi_index(tuple((places - first).astype(int).T), tuple(shape))
        count = np.bincount(where, minlength=int(np.prod(shape)))
        best = np.full(len(count), -np.inf)
        np.maximum.at(best, where, values)
        mean = np.bincount(where, values, minlength=len(count)) / np.maximum(count, 1)
        best, mean = np.where(count > 0, best, np.nan), np.where(count > 0, mean, np.nan)
        edges = tuple(size * (low + np.arange(number + 1)) for low, number in zip(first, shape))
        return Cells(
            quantity, tuple(axes), edges, count.reshape(shape), best.reshape(shape), mean.reshape(shape)
        )  # fmt: skip


@checked
def map_workspace(
    robot: Robot,
    count: int = COUNT,
    *,
    rng: np.random.Generator | int | None = None,
    rows: Sequence[str] | None = None,
    length_scale: float = 1.0,
    executor: Executor | None = None,
    progress: ProgressCallback | None = None,
) -> WorkspaceMap:
    """A map of singular values over the workspace, from random configurations within the joint limits.

    Args:
        robot: An arm with a tip.
        count: Number of configurations.
        rng: A seed, or a generator to draw one from; by default always the same.
        rows: Task rows, of x y z wx wy wz; default the robot's. σ of x y z are in m, those of all six mix m and rad.
        length_scale: Length by which linear rows are divided, m.
        executor: An executor that runs the pieces, any `concurrent.futures.Executor`; by default this process. The map
            is the same to the last bit.
        progress: Called with (pieces done, pieces in all).

    Raises:
        TipError: The robot was loaded whole, without a tip.
        InputError: A parameter is not valid.
    """
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise InputError(f"count must be a whole number of at least 1, got {count!r}")
    rows = robot.rows if rows is None else checked_rows(rows)
    length_scale = checked_parameter("length_scale", length_scale, above=0)
    robot.pose(robot.rest)  # raises here, not in a worker, for a robot without a tip
    seed, mapped = seed_of(rng), robot.with_rows(rows)
    pieces = [
        _Samples(mapped, length_scale, size, (seed, index)) for index, size in enumerate(chunk_sizes(int(count), CHUNK))
    ]
    q, positions, sigma = zip(*run_pieces(_Samples.run, pieces, executor, progress))
    return WorkspaceMap(
        robot, rows, length_scale, seed, np.concatenate(q), np.concatenate(positions), np.concatenate(sigma)
    )


@dataclass(frozen=True, eq=False)
class _Samples:
    """A piece of the map: some configurations, with a seed of their own."""

    robot: Robot
    length_scale: float
    count: int
    seed: tuple[int, ...]

    def run(self) -> tuple[Array, Array, Array]:
        """Configurations, tip positions and singular values of the piece."""
        q = self.robot.random(np.random.default_rng(self.seed), self.count)
        lengths = np.array([self.length_scale if row in AXES else 1.0 for row in self.robot.rows])
        return q, self.robot.pose(q)[:, :3, 3], svd(self.robot.jacobian(q) / lengths[:, None]).s
