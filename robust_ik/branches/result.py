"""Results of `all_solutions`: configurations, the curves they lie on, what is known of their number. Arrays only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array


class SolutionsStatus(Enum):
    """What is known of the number of solutions; its value is the explanation."""

    EVERY = "Every solution: each root of the eliminant is accounted for."
    DEGENERATE = (
        "The pose has self-motions, or its eliminant vanishes: self-motions are those that cross joint values which "
        "were tried, and a shorter one may lie between them; single solutions may be those of two poses beside it."
    )
    CURVES = "The self-motions that cross the joint values which were tried; a shorter one may lie between them."
    DOUBTFUL = "Solutions were found, but roots of the eliminant are left: there may be others."
    SEARCHED = "Solutions were found by a search from many starts: there may be others."


@dataclass(frozen=True, eq=False)
class SelfMotion:
    """A curve of solutions of one pose: the tool stands still while the arm moves along it.

    Attributes:
        q: Configurations along it, in order, (p, nq).
        closed: Whether the last one is followed by the first one; else it ends at joint limits.
        moving: Names of the joints that move along it.
        sigma: The least singular value of the Jacobian in the wanted rows that is not always zero, (p,).
    """

    q: Array
    closed: bool
    moving: tuple[str, ...]
    sigma: Array

    def __repr__(self) -> str:
        end = "closed" if self.closed else "between joint limits"
        return f"SelfMotion({len(self.q)} configurations, {end}, moves {' '.join(self.moving)})"


@dataclass(frozen=True, eq=False)
class AllSolutions:
    """All solutions of one pose.

    Attributes:
        q: Solutions within joint limits, the nearest to q0 first, (s, nq). Of each self-motion there is one.
        beyond: Solutions that are beyond joint limits, (b, nq).
        status: What is known of their number.
        singular: Whether the Jacobian loses rank at each of `q`, (s,).
        self_motions: The curves through those of `q` that are not alone.
        method: How they were found, in words.
    """

    q: Array
    beyond: Array
    status: SolutionsStatus
    singular: NDArray[np.bool_]
    self_motions: tuple[SelfMotion, ...]
    method: str

    @property
    def complete(self) -> bool:
        """Whether it is shown that there are no others."""
        return self.status is SolutionsStatus.EVERY

    def __len__(self) -> int:
        return len(self.q)

    def __iter__(self) -> Iterator[Array]:
        return iter(self.q)

    def __getitem__(self, index: int) -> Array:
        return np.asarray(self.q[index])

    def __repr__(self) -> str:
        word = "complete" if self.complete else "not shown to be complete"
        curves = f", {len(self.self_motions)} self-motions" if self.self_motions else ""
        return f"AllSolutions({len(self.q)} within limits, {len(self.beyond)} beyond{curves}, {word}, {self.method})"


@dataclass(frozen=True, eq=False)
class ManySolutions:
    """All solutions of many poses.

    Attributes:
        q: Solutions within joint limits, the nearest to q0 first, NaN beyond those found, (..., s, nq).
        found: How many there are within limits, (...).
        beyond: How many more there are beyond limits, (...).
        complete: Whether it is shown that there are no others, (...).
        singular: Whether the Jacobian loses rank at each, (..., s).
    """

    q: Array
    found: NDArray[np.int_]
    beyond: NDArray[np.int_]
    complete: NDArray[np.bool_]
    singular: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.found)

    def __repr__(self) -> str:
        return f"ManySolutions({int(self.found.sum())} of {self.found.size} poses, {int(self.complete.sum())} complete)"
