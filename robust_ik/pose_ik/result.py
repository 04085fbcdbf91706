"""Results of inverse kinematics: a configuration, and how close it comes to the target. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from operator import attrgetter
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.errors import NotReachedError
from robust_ik.kernels.pose import pose_layout as lay


class PoseStatus(Enum):
    """Status of an inversion; its value is the explanation."""

    SOLVED = "The target is reached within the tolerances, inside joint limits."
    CLOSEST = "The target was not reached: this is the closest configuration that was found."
    OUT_OF_REACH = "The target is farther away than the links span: this is the closest configuration that was found."


STATUSES = (PoseStatus.SOLVED, PoseStatus.CLOSEST, PoseStatus.OUT_OF_REACH)


class Solver(Protocol):
    """The solver of a result: a `PoseSolver`."""

    def singular_values(self, q: Array) -> Array:
        """Singular values of the Jacobian in the wanted rows, (..., nq) → (..., k), descending."""


class PoseResult:
    """A configuration that reaches a pose, or the closest one that was found. It is immutable.

    It is no dataclass: making a frozen one takes a tenth of the time of a whole solve.
    """

    __slots__ = ("_numbers", "_q", "_solver")

    def __init__(self, q: Array, numbers: Array, solver: Solver) -> None:
        self._q, self._numbers, self._solver = q, numbers, solver

    q: property = property(attrgetter("_q"), doc="The preferred configuration, or the closest, (nq,).")

    @property
    def solutions(self) -> Array:
        """Solutions found, the preferred one first, (s, nq); the closest configuration alone if there is none."""
        return self._q[None]

    @property
    def solver(self) -> Solver:
        """The solver that made this result."""
        return self._solver

    def __repr__(self) -> str:
        return f"PoseResult({self.status.name}, q={self.q!r}, error={self.error})"

    @property
    def status(self) -> PoseStatus:
        """Status of the inversion."""
        return STATUSES[int(self._numbers[lay.STATUS])]

    @property
    def solved(self) -> bool:
        """Whether the target is reached within the tolerances."""
        return self._numbers.item(lay.STATUS) == lay.SOLVED

    @property
    def error(self) -> tuple[float, float]:
        """Distance to the target's position, m, and to its rotation, rad, in the wanted rows."""
        return self._numbers.item(lay.POSITION_ERROR), self._numbers.item(lay.ROTATION_ERROR)

    @property
    def iterations(self) -> int:
        """Steps taken in all, including those of starts that were given up."""
        return int(self._numbers[lay.ITERATIONS])

    @property
    def starts(self) -> int:
        """How many starts were tried."""
        return int(self._numbers[lay.TRIED])

    @property
    def sigma(self) -> Array:
        """Singular values of the Jacobian in the wanted rows at q, (k,), descending."""
        return self.solver.singular_values(self.q)

    def raise_for_status(self) -> PoseResult:
        """The result itself if the target is reached.

        Raises:
            NotReachedError: It is not; the message says how close q comes.
        """
        if not self.solved:
            raise NotReachedError(f"{self.status.value} It misses by {_miss(self.error)}.")
        return self


class SeveralSolutions(PoseResult):
    """Result of a search for several solutions."""

    __slots__ = ("_solutions",)

    def __init__(self, solutions: Array, numbers: Array, solver: Solver) -> None:
        super().__init__(solutions[0], numbers, solver)
        self._solutions = solutions

    @property
    def solutions(self) -> Array:
        """Solutions found, the preferred one first, (s, nq)."""
        return self._solutions


@dataclass(frozen=True, eq=False, slots=True)
class PoseResults:
    """Results for many targets: configurations that reach them, or the closest ones that were found.

    Attributes:
        solutions: For each target, the preferred one first, (..., s, nq); NaN if fewer were found.
        solver: The solver that made them.
    """

    solutions: Array
    solver: Solver
    _numbers: Array

    def __len__(self) -> int:
        return len(self._numbers)

    def __repr__(self) -> str:
        return f"PoseResults({int(self.solved.sum())} of {self.solved.size} solved)"

    @property
    def q(self) -> Array:
        """Preferred or closest configurations, (..., nq)."""
        return np.asarray(self.solutions[..., 0, :])

    @property
    def status(self) -> NDArray[np.object_]:
        """Status for each target: an array of PoseStatus, (...)."""
        numbers = self._numbers[..., lay.STATUS].astype(int)
        return np.asarray(np.array(STATUSES, dtype=object)[numbers])

    @property
    def solved(self) -> NDArray[np.bool_]:
        """Which targets are reached within the tolerances, (...)."""
        return np.asarray(self._numbers[..., lay.STATUS] == lay.SOLVED)

    @property
    def error(self) -> Array:
        """Distances to the targets' positions, m, and rotations, rad, in the wanted rows, (..., 2)."""
        return np.asarray(self._numbers[..., lay.POSITION_ERROR : lay.ROTATION_ERROR + 1])

    @property
    def found(self) -> NDArray[np.int_]:
        """How many solutions each target has in `solutions`, (...)."""
        count = self._numbers[..., lay.FOUND].astype(int)
        return np.asarray(np.minimum(count, self.solutions.shape[-2]))

    @property
    def iterations(self) -> NDArray[np.int_]:
        """Steps taken for each target, (...)."""
        return self._numbers[..., lay.ITERATIONS].astype(int)

    @property
    def starts(self) -> NDArray[np.int_]:
        """How many starts were tried for each target, (...)."""
        return self._numbers[..., lay.TRIED].astype(int)

    @property
    def sigma(self) -> Array:
        """Singular values of the Jacobians in the wanted rows at q, (..., k), descending."""
        return self.solver.singular_values(self.q)

    def raise_for_status(self) -> PoseResults:
        """The results themselves if every target is reached.

        Raises:
            NotReachedError: One is not; the message says how many, and how far the worst is off.
        """
        if not self.solved.all():
            worst = np.argmax(np.where(self.solved, -1.0, np.linalg.norm(self.error, axis=-1)))
            p, r = self.error.reshape(-1, 2)[worst].tolist()
            missed = int((~self.solved).sum())
            raise NotReachedError(
                f"{missed} of {self.solved.size} targets were not reached; one misses by {_miss((p, r))}."
            )
        return self


def _miss(error: tuple[float, float]) -> str:
    return f"{error[0]:.3g} m and {error[1]:.3g} rad"
