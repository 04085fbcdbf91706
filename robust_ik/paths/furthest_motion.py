"""The motion that goes furthest from one place of a path, with the least motion of joints. Arrays only.

The ladder of solutions is climbed; where it ends places are added, and solutions are followed through them; what is
found is looked at between places, and steps that are jumps are banned. This repeats until nothing changes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.full_turns import with_turns
from robust_ik.checks import Array
from robust_ik.kernels.paths import ladder_layout as lay
from robust_ik.paths.between_solutions import CLOSE, Between
from robust_ik.paths.layer_solver import LONGEST, LayerSolver
from robust_ik.paths.solution_layers import Layers

FINEST = 1e-5
"""Shortest step between places that are solved for, rad, and lengths over the length scale: a jump there is one."""
ADDED = 4
"""How many places are added between two at a time."""
CARRIED = 16
"""How many states are followed through the places that are added."""
MOST = 1024
"""Most states of a place. Chosen: the eight solutions of a UR with two turns of each joint are 512."""
TURNS = (1e9, 3.01 * np.pi, 1.01 * np.pi)
"""How far from `near` joints may begin, rad: all turns within limits, or fewer where there would be too many."""
ROUNDS = 100
"""How often places are added, or steps banned, without getting further, before the motion that is known is taken."""
FAST, NOTHING = 8.0, 1e-3
"""Joints are fast where one moves this many times as much as the tool, lengths over the length scale, and so much."""
BEHIND = 4
"""How many places behind those states are led lazily: the path may be right again there."""
WIDTHS = (24, 24, 12, 12, 6, 6, 3, 3, 1, 1)
"""Over how many places to either side means are taken, one after the other."""
SAME = 1e-6
"""Solutions that differ by less are one, rad and m."""
PREFERRED = 1e-3
"""How much being away from `near` at the start counts beside motion along the path."""


@dataclass(eq=False)
class FurthestMotion:
    """A search from one place on.

    Attributes:
        solver: Solves the poses of places.
        between: Looks between solutions.
        layers: The solutions along the path; places are added.
        first: Where motions begin, an index of layers.
        near: Joint values that starts are sorted by, (n,).
        start: Joint values that the motion begins at, (n,); None for any.
    """

    solver: LayerSolver
    between: Between
    layers: Layers
    first: int
    near: Array
    start: Array | None
    banned: list[tuple[float, float, int, int]] = field(default_factory=list)
    """Steps that are jumps: a place, the next one, a solution at each."""
    eased_at: Array = field(default_factory=lambda: np.zeros(0))
    """Places behind which joints were fast, and states were led lazily: once each."""
    led_on: set[float] = field(default_factory=set)
    """Places that have no room for others behind them, from which states were led on: once each."""

    def run(self) -> tuple[Array, Array, int]:
        """Places and joint values of the motion, and the last layer that it reaches, `first` − 1 if there is none."""
        furthest, rounds = -1.0, 0
        while True:
            reached, states, numbers = self.climbed()
            if reached < self.first:
                return np.zeros(0), np.zeros((0, len(self.near))), reached
            s = self.layers.s[self.first : reached + 1]
            rounds = 0 if s[-1] > furthest else rounds + 1
            furthest, is_last = max(furthest, s[-1]), rounds >= ROUNDS
            nodes, values = self.way(reached, states, numbers)
            if not is_last and reached + 1 < len(self.layers) and self.opened(reached, states, numbers, values):
                continue
            finer_s, finer, wrong = self.between.finer(s, values)
            if wrong is None and not is_last and self.eased(reached, states, numbers, values):
                continue
            if wrong is None and self.solver.branches.is_redundant:
                finer_s, finer = self.smoother(s, values, finer_s, finer)
            while wrong is not None and is_last:  # what is known of it is taken, up to the jump
                s, values, reached = s[: wrong + 1], values[: wrong + 1], self.first + wrong
                finer_s, finer, wrong = self.between.finer(s, values)
            if wrong is None:
                return finer_s, finer, reached
            self.banned.append((float(s[wrong]), float(s[wrong + 1]), int(nodes[wrong]), int(nodes[wrong + 1])))

    def smoother(self, s: Array, values: Array, finer_s: Array, finer: Array) -> tuple[Array, Array]:
        """The motion of an arm with a joint too many, which is not bound to the values that are tried of that joint.

        Configurations are led from the mean of those around them; what is not shorter is not taken.

        Args:
            s: Places of the motion, (m,).
            values: Joint values there, (m, n).
            finer_s: Places of the same motion with what lies between, (f,).
            finer: Joint values there.
        """
        targets, weights, best = self.layers.targets[self.first :][: len(s)], self.solver.weights, values.copy()
        for width in (each for each in WIDTHS if 2 * each < len(s)):
            before, behind = 2 * best[0] - best[width:0:-1], 2 * best[-1] - best[-2 : -width - 2 : -1]
            sums = np.cumsum(np.concatenate([best[:1] * 0, before, best, behind]), axis=0)
            middle = (sums[2 * width + 1 :] - sums[: -2 * width - 1]) / (2 * width + 1)
            middle[[0, -1]], middle[:, ~self.solver.moving] = best[[0, -1]], best[:, ~self.solver.moving]
            found, is_close = self.solver.led(targets, middle, CLOSE * self.between.accuracy)
            best[is_close] = found[is_close]
        if np.abs(np.diff(best, axis=0) * weights).max(initial=0.0) > LONGEST:
            return finer_s, finer
        smooth_s, smooth, wrong = self.between.finer(s, best)
        if wrong is not None or travel(smooth, weights) >= travel(finer, weights):
            return finer_s, finer
        return smooth_s, smooth

    def climbed(self) -> tuple[int, Array, Array]:
        """The last layer that motions reach; their states and numbers, see `kernels.paths`."""
        from robust_ik.kernels.paths import ladder

        layers, first, n = self.layers, self.first, len(self.near)
        many, (nodes, values) = len(layers) - first, self.starts()
        most = max(len(nodes), min(MOST, len(nodes) * int(layers.counts.max())), 1)
        states, numbers = np.empty((many, most, lay.VALUES + n)), np.zeros((many, lay.NUMBERS))
        numbers[0, lay.ALIVE] = len(nodes)
        states[0, : len(nodes), lay.NODE], states[0, : len(nodes), lay.PARENT] = nodes, -1
        states[0, : len(nodes), lay.COST] = PREFERRED * self.away(values)
        states[0, : len(nodes), lay.VALUES :] = values
        at = {float(s): layer for layer, s in enumerate(layers.s[first:])}
        steps = [(at[low], a, b) for low, high, a, b in self.banned if at[high] == at[low] + 1]
        bans = np.array(steps).reshape(-1, 3)
        reached = ladder.compiled(
            np.ascontiguousarray(layers.values[first:]), layers.counts[first:].astype(float), self.solver.joints,
            np.ascontiguousarray(bans, dtype=float), LONGEST, states, numbers, np.empty(layers.values.shape[1]),
        )  # fmt: skip
        return first + reached, states, numbers

    def starts(self) -> tuple[NDArray[np.int_], Array]:
        """Solutions at the first place with their turns: which one each is, (k,), and joint values (k, n)."""
        known = self.layers.values[self.first, : self.layers.counts[self.first]]
        solver = self.solver
        if self.start is not None:
            d = np.abs(solver.difference(known, self.start)).max(axis=1)
            return np.array([int(d.argmin())]), self.start[None]
        finite = np.isfinite(solver.lower) & np.isfinite(solver.upper) & ~solver.sliding & solver.moving
        lower, upper, q = solver.lower[finite], solver.upper[finite], known[:, finite]
        low, high = solver.lower.copy(), solver.upper.copy()
        for around in TURNS:
            low[finite] = np.maximum(lower, np.minimum(self.near[finite] - around, upper - 2 * around))
            high[finite] = np.minimum(upper, low[finite] + 2 * around)
            turns = np.floor((high[finite] - q) / (2 * np.pi)) - np.ceil((low[finite] - q) / (2 * np.pi)) + 1
            if np.maximum(turns, 0).prod(axis=1).sum() <= MOST:
                break
        values, nodes = with_turns(known, low, high, finite)
        order = np.argsort(self.away(values), kind="stable")[:MOST]
        return nodes[order], values[order]

    def away(self, values: Array) -> Array:
        """How far joint values (k, n) are from `near`, (k,), rad, with slides over the length scale."""
        return np.asarray(np.linalg.norm((values - self.near) * self.solver.weights, axis=1))

    def way(self, reached: int, states: Array, numbers: Array) -> tuple[NDArray[np.int_], Array]:
        """The solutions of the motion to the last layer with the least motion: which ones, and joint values."""
        last = reached - self.first
        at = int(np.argmin(states[last, : int(numbers[last, lay.ALIVE]), lay.COST]))
        rows = []
        for layer in range(last, -1, -1):
            rows.append(states[layer, at])
            at = int(states[layer, at, lay.PARENT])
        made = np.array(rows[::-1])
        return made[:, lay.NODE].astype(int), made[:, lay.VALUES :]

    def opened(self, reached: int, states: Array, numbers: Array, values: Array) -> bool:
        """Looks for ways on where a motion ends; whether there is anything new."""
        return self.eased(reached, states, numbers, values) or self.added(reached, states, numbers)

    def added(self, reached: int, states: Array, numbers: Array) -> bool:
        """Adds places where motions ended far from the next solutions; whether there were any.

        First behind the last place that was reached; if that is no use, behind all places before, once more each time.
        """
        gaps = np.diff(self.layers.s)
        sizes = self.between.path.size_of(self.layers.s[:-1], gaps)
        ended = numbers[:, lay.ENDED] > numbers[:, lay.LIMITED]
        if ended[reached - self.first] and sizes[reached] > FINEST:
            self.refine([reached], states, numbers)
            return True
        places = [self.first + int(i) for i in np.flatnonzero(ended[: reached - self.first + 1])]
        known = int(self.layers.counts.sum())
        for i in places:  # the tool stands still there, or hardly moves
            if sizes[i] <= FINEST and float(self.layers.s[i]) not in self.led_on:
                self.led_on.add(float(self.layers.s[i]))
                alive = states[i - self.first, : int(numbers[i - self.first, lay.ALIVE])]
                self.carry(alive, range(i + 1, i + 2), lazily=False)
        if self.layers.counts.sum() > known:
            return True
        behind = [i for i in places if sizes[i] > FINEST]
        if behind:
            self.refine(behind, states, numbers)
        return bool(behind)

    def refine(self, behind: list[int], states: Array, numbers: Array) -> None:
        """Adds places behind layers, with the solutions that states there lead to."""
        layers, path = self.layers, self.between.path
        ends = [(layers.s[i], layers.s[i + 1]) for i in behind]
        s = np.concatenate([a + (b - a) * np.arange(1, ADDED + 1) / (ADDED + 1) for a, b in ends])
        kept = [states[i - self.first, : int(numbers[i - self.first, lay.ALIVE])] for i in behind]
        self.layers = layers.joined(self.solver.layers(s, path.at(s), self.near))
        for (a, _), alive in zip(ends, kept):
            start = int(np.searchsorted(self.layers.s, a))
            self.carry(alive, range(start + 1, start + ADDED + 2), lazily=False)

    def carry(self, states: Array, layers: range, *, lazily: bool) -> None:
        """Leads the states with the least motion through layers, and adds what is found to their solutions."""
        order = np.argsort(states[:, lay.COST], kind="stable")[:CARRIED]
        at = states[order, lay.VALUES :]
        for layer in layers:
            targets = np.repeat(self.layers.targets[layer][None], len(at), axis=0)
            found, is_close = self.solver.led(targets, at, CLOSE * self.between.accuracy, lazily=lazily)
            at = found[is_close]
            if not len(at):
                break
            self.layers = self.layers.with_solutions(layer, at, self.solver.sliding, SAME)

    def eased(self, reached: int, states: Array, numbers: Array, values: Array) -> bool:
        """Leads states lazily through places where joints of the motion are fast; whether there are new ones of these.

        Within the accuracy a motion may pass a singularity where the exact one would turn its wrist.
        """
        s = self.layers.s[self.first : reached + 1]
        tool = self.between.path.size_of(s[:-1], np.diff(s))
        motion = np.abs(self.solver.weights * np.diff(values, axis=0)).max(axis=1, initial=0.0)
        fast = (motion > FAST * tool) & (motion > NOTHING)
        fast &= ~np.isin(s[:-1], self.eased_at)
        self.eased_at = np.concatenate([self.eased_at, s[:-1][fast]])
        begins = np.flatnonzero(fast & ~np.concatenate([[False], fast[:-1]]))
        for begin in begins.tolist():
            end = begin + int(np.argmin(np.append(fast[begin:], False))) + BEHIND
            alive = states[begin, : int(numbers[begin, lay.ALIVE])]
            self.carry(alive, range(self.first + begin + 1, min(self.first + end, len(self.layers))), lazily=True)
        return len(begins) > 0


def travel(values: Array, weights: Array) -> float:
    """How far joints move in all along joint values (m, n), rad."""
    return float(np.linalg.norm(np.diff(values, axis=0) * weights, axis=1).sum())
