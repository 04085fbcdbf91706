"""Layers: places on a path and the solutions of the pose at each. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array


@dataclass(frozen=True, eq=False)
class Layers:
    """The solutions along a path.

    Attributes:
        s: Places, increasing, (m,).
        targets: The poses there, (m, 4, 4).
        values: Joint values of solutions, whatever beyond those that count, (m, k, n).
        counts: How many each place has, (m,).
        complete: Whether they are all, (m,).
    """

    s: Array
    targets: Array
    values: Array
    counts: NDArray[np.int_]
    complete: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.s)

    def joined(self, other: Layers) -> Layers:
        """Both, in the order of their places, which differ."""
        s = np.concatenate([self.s, other.s])
        order, most = np.argsort(s, kind="stable"), max(self.values.shape[1], other.values.shape[1])
        values = np.zeros((len(s), most, self.values.shape[2]))
        values[: len(self), : self.values.shape[1]] = self.values
        values[len(self) :, : other.values.shape[1]] = other.values
        pairs = [(self.targets, other.targets), (self.counts, other.counts), (self.complete, other.complete)]
        targets, counts, complete = (np.concatenate(pair)[order] for pair in pairs)
        return Layers(s[order], targets, values[order], counts, complete)

    def with_solutions(self, layer: int, values: Array, sliding: NDArray[np.bool_], same: float) -> Layers:
        """With more solutions (k, n), without those that differ by less from one that is there, turns modulo 2π."""
        count, new = int(self.counts[layer]), []
        known = [*self.values[layer, :count]]
        for each in values:
            d = np.array(known).reshape(-1, len(each)) - each
            d = np.where(sliding, d, d - 2 * np.pi * np.round(d / (2 * np.pi)))
            if not known or np.abs(d).max(axis=1).min() >= same:
                known.append(each)
                new.append(each)
        if not new:
            return self
        most, counts = max(self.values.shape[1], len(known)), self.counts.copy()
        made = np.zeros((len(self), most, self.values.shape[2]))
        made[:, : self.values.shape[1]] = self.values
        made[layer, count : len(known)], counts[layer] = new, len(known)
        return Layers(self.s, self.targets, made, counts, self.complete)
