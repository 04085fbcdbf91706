"""Curves of coupled joints, pair by pair, on the square of two angles. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.trace.coupled_curves import Curve

MOST_PANELS = 6
"""Most pairs of joints that are drawn. Chosen: all pairs of four joints, two rows of three in a figure."""
MOST_POINTS = 500
"""Most points of a curve in a drawing: more cannot be distinguished."""


@dataclass(frozen=True)
class Axis:
    """One joint as an axis of a drawing.

    Attributes:
        joint: Index from 0.
        low: Left or lower end, degrees or m.
        high: The other end.
        factor: From rad or m to what is shown.
        turns: Whether both ends are the same pose.
    """

    joint: int
    low: float
    high: float
    factor: float
    turns: bool

    @classmethod
    def of(cls, chain: ScrewChain, joint: int) -> Axis:
        """An axis from −180° to 180° for an angle, over its range for a length."""
        if np.isfinite(chain.period[joint]):
            return cls(joint, -180.0, 180.0, 180.0 / np.pi, True)
        return cls(joint, float(chain.lower[joint]), float(chain.upper[joint]), 1.0, False)

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"q{self.joint + 1} [{'°' if self.turns else 'm'}]"

    @property
    def ticks(self) -> tuple[float, ...]:
        """Values of the ticks."""
        return (-180.0, -90.0, 0.0, 90.0, 180.0) if self.turns else (self.low, (self.low + self.high) / 2, self.high)

    def shown(self, values: Array) -> Array:
        """Positions of joint values (..., n) on the axis, modulo whole turns, (...)."""
        x = values[..., self.joint] * self.factor
        return np.asarray((x + 180.0) % 360.0 - 180.0 if self.turns else x)


def pairs(chain: ScrewChain, curves: tuple[Curve, ...]) -> list[tuple[Axis, Axis]]:
    """Pairs of joints to be drawn against each other; a single coupled joint has none."""
    joints = sorted({joint for curve in curves for joint in curve.joints})
    axes = [Axis.of(chain, joint) for joint in joints]
    return list(combinations(axes, 2))[:MOST_PANELS]


def strokes(curve: Curve, across: Axis, up: Axis) -> list[Array]:
    """Parts of an ordered curve, (P, 2) each, cut at the edges of the square; at a cut both sides overlap."""
    way = np.concatenate([curve.values, curve.values[-1:] + curve.chords[-1:]]) if curve.closed else curve.values
    way = way[np.unique(np.linspace(0, len(way) - 1, MOST_POINTS).round().astype(int))]
    steps = np.stack([np.diff(way[:, axis.joint]) * axis.factor for axis in (across, up)], axis=1)
    points = np.stack([across.shown(way), up.shown(way)], axis=1)
    jumps = np.flatnonzero(np.abs(np.diff(points, axis=0) - steps).max(axis=1) > 1.0)
    pieces = []
    for begin, end in zip([0, *(jumps + 1)], [*(jumps + 1), len(points)]):
        before = [points[begin] - steps[begin - 1]] if begin > 0 else []
        after = [points[end - 1] + steps[end - 1]] if end < len(points) else []
        pieces.append(np.array([*before, *points[begin:end], *after]))
    return pieces
