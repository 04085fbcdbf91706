"""An explanation as a table of plain text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors.safe_text import visible

if TYPE_CHECKING:
    from robust_ik.analysis.explanation.step import Explanation

HEADERS = ("", "σ", "φ", "asked", "given", "lost", "what", "speed", "share", "task direction", "joint direction")
WORDS = ("what", "task direction", "joint direction")
"""The columns aligned to the left; the others hold numbers."""

SHOWN, SHOWN_FROM = 3, 0.1
"""A direction is shown by its three largest components, if they are at least this large."""

NOISE = 1e-12
"""What is smaller than this fraction of its norm is shown as 0."""


def table(explanation: Explanation) -> str:
    """A few sentences, then one line per task direction."""
    rows = [HEADERS, *(_cells(i, explanation) for i in range(len(explanation.directions)))]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADERS))]
    lines = ["  ".join(_aligned(row, widths)).rstrip() for row in rows]
    return "\n".join([*_summary(explanation), "", *lines])


def _aligned(row: tuple[str, ...], widths: Sequence[int]) -> list[str]:
    return [c.ljust(w) if name in WORDS else c.rjust(w) for name, c, w in zip(HEADERS, row, widths)]


def _summary(explanation: Explanation) -> list[str]:
    m, n = explanation.J.shape
    asked, given = np.linalg.norm(explanation.xdot), np.linalg.norm(explanation.given)
    return [
        f"{explanation.inverse!r} on a {m}×{n} Jacobian of corank {explanation.corank}",
        f"asked {asked:.4g}, given {given:.4g}, {np.degrees(explanation.angle):.1f}° apart: "
        f"{_percent(explanation.speed_lost)} of the asked speed is lost; "
        f"{np.degrees(explanation.unavoidable_angle):.1f}° cannot be avoided",
        f"largest joint speed {explanation.largest_speed:.4g} (q{explanation.fastest_joint + 1}); "
        f"{_percent(explanation.null_share)} of the motion is in the null space",
        f"smallest σ {explanation.smallest_sigma:.3g} (distance of J from a singular matrix), condition number "
        f"{explanation.condition_number:.4g}, manipulability {explanation.manipulability:.3g}; "
        f"* marks σ ≤ {explanation.threshold:.2g}",
    ]


def _cells(index: int, explanation: Explanation) -> tuple[str, ...]:
    direction = explanation.directions[index]
    asked, speed = np.linalg.norm(explanation.xdot), np.linalg.norm(explanation.qdot)
    return (
        f"{index + 1}{'*' if direction.singular else ' '}",
        f"{direction.sigma:.4g}",
        "" if direction.gain is None else f"{direction.gain:.4g}",
        _number(direction.asked, asked),
        _number(direction.given, asked),
        "" if direction.lost is None else _percent(direction.lost),
        str(direction.branch),
        _number(direction.speed, speed),
        _percent(direction.share),
        _in_words(direction.u, explanation.rows),
        _in_words(direction.v, [f"q{j + 1}" for j in range(direction.v.size)]),
    )


def _number(value: float, scale: np.floating[Any]) -> str:
    return f"{value:.4g}" if abs(value) > NOISE * scale else "0"


def _percent(fraction: float) -> str:
    return f"{round(fraction, 6) + 0.0:.1%}"  # + 0.0 turns −0.0 into 0.0


def _in_words(vector: Array, names: Sequence[str]) -> str:
    """The largest components by name, such as "+0.91 x −0.41 wz"."""
    largest = [i for i in np.argsort(-np.abs(vector))[:SHOWN] if abs(vector[i]) >= SHOWN_FROM]
    return " ".join(f"{vector[i]:+.2f} {visible(names[i])}" for i in largest).replace("-", "−")
