"""The motion that is lost along a stratum: in words, and as a numerical example. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.lost_motion.axis_landmarks import Axes, landmarks
from robust_ik.singularities.lost_motion.lost_motion import LostMotion, lost_motion, sides
from robust_ik.singularities.lost_motion.lost_motion_words import in_words

SAMPLES = 8
"""Members for which words are found. Chosen: what all eight share is likely to hold for all; more take longer."""


@dataclass(frozen=True, eq=False)
class Lost:
    """The motion that is lost along a stratum.

    Attributes:
        words: The wrenches that the structure bears by itself, and so the motions that the tool cannot make, as far as
            they are the same throughout.
        way_out: Whether self-motions lead along lost directions, to second order, in words.
        values: Joint values of the example, rad or m, (n,).
        example: The lost motion there, in numbers; positions and world axes with the tool's point as origin.
    """

    words: str
    way_out: str
    values: Array
    example: LostMotion

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", readonly(self.values))

    def __str__(self) -> str:
        return f"{self.words}; {self.way_out}"


def lost_along(chain: ScrewChain, tool: Array, corank: int, samples: Array) -> Lost:
    """The motion that is lost along a stratum.

    Args:
        chain: What moves the tip.
        tool: The tool's axes in the last joint's axis frame, (3, 3).
        corank: Corank of the stratum.
        samples: Configurations on it as joint values, (S, n).
    """
    values = samples[np.unique(np.linspace(0, len(samples) - 1, SAMPLES).round().astype(int))]
    every = chain.in_rows(ROWS)
    lost = [_lost_at(chain, tool, corank, each) for each in values]
    axes = [Axes.of(J, np.zeros(3)) for J in every.jacobian(values)]
    words = in_words(lost, axes, landmarks(axes[0]), chain.length_scale)
    in_metres = lost[0]
    if chain.length_scale != 1.0:
        in_metres = _lost_at(replace(chain, length_scale=1.0), tool, corank, values[0])
    return Lost(words, _way_out(lost), values[0], in_metres)


def _lost_at(chain: ScrewChain, tool: Array, corank: int, values: Array) -> LostMotion:
    """The lost motion at joint values (n,), in the chain's unit of length, with the tool's point as origin."""
    T = np.eye(4)
    T[:3, :3] = chain.last_axes(values) @ tool
    rows = tuple(ROWS.index(row) for row in chain.rows)
    return lost_motion(chain.jacobian(values), chain.hessian(values), T, corank, rows, chain.full_rank)


def _way_out(lost: Sequence[LostMotion]) -> str:
    """What the curvatures of all samples show, in words."""
    curvature = np.array([each.curvature for each in lost])  # (S, k, 2)
    low, high = curvature[..., 0].min(axis=1), curvature[..., 1].max(axis=1)
    counts = {sides(*extremes) for extremes in zip(low.tolist(), high.tolist())}
    if counts == {0}:
        return "self-motions do not lead along it to second order"
    if counts == {2}:
        return "self-motions lead along it to both sides"
    if counts == {1}:
        return "self-motions lead along it to one side only: an end of reach"
    return "whether self-motions lead along it differs along the family"
