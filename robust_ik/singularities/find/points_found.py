"""The result of a search for singular configurations. NumPy only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.find.rank_residual import Indices, Mask

ARRAYS = ("values", "residual", "iterations", "coranks", "dimensions", "folded", "minima", "floors")


@dataclass(frozen=True, eq=False)
class Points:
    """The S singular configurations that a search found, and the ends of its F failed searches.

    Attributes:
        corank: The corank k that was looked for; at each point it is at least that.
        values: Joint values, angles in [−π, π), (S, n).
        residual: ‖r‖/σ₁ of each, at most the tolerance, (S,).
        iterations: Steps tried on the way to it, (S,).
        coranks: Corank at each, (S,): more than k on strata of higher corank.
        dimensions: Local dimension of the stratum at each, (S,).
        folded: Whether the residual vanishes to second order in some direction off the stratum, (S,): at a crossing
            that no shake left, or everywhere on some strata. There n − rank ∂r/∂q is more than the dimension, which is
            measured by samples instead.
        minima: Ends of the failed searches, usually local minima, (F, n).
        floors: ‖r‖/σ₁ there, (F,).
    """

    corank: int
    values: Array
    residual: Array
    iterations: Indices
    coranks: Indices
    dimensions: Indices
    folded: Mask
    minima: Array
    floors: Array

    def __post_init__(self) -> None:
        for name in ARRAYS:
            array = getattr(self, name)
            object.__setattr__(self, name, readonly(array, array.dtype))

    @classmethod
    def joined(cls, parts: Sequence[Points]) -> Points:
        """The points of several searches for one corank, in order."""
        arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS}
        return cls(corank=parts[0].corank, **arrays)

    def __len__(self) -> int:
        return len(self.values)

    @property
    def exact(self) -> Mask:
        """Which points have exactly the corank that was looked for, (S,)."""
        return np.asarray(self.coranks == self.corank)

    @property
    def failed(self) -> int:
        """How many starts led to no point."""
        return len(self.minima)

    @property
    def success(self) -> float:
        """The fraction of starts that led to a point."""
        return len(self) / (len(self) + self.failed)
