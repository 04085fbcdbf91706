"""Explanation of one step of an inverse, direction by direction, as numbers and as a table of plain text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.analysis.explanation.singular_directions import Direction, take_apart
from robust_ik.checks import Array, as_array, as_measures, checked_parameter, readonly
from robust_ik.checks.public_arguments import checked, computed
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import visible
from robust_ik.inverses import RobustInverse, SingularValueFilter
from robust_ik.kinematics.svd import RANK_TOLERANCE, condition_number, lost_directions, manipulability, svd
from robust_ik.kinematics.twist_rows import ROWS

HEADERS = ("", "σ", "φ", "asked", "given", "lost", "what", "speed", "share", "task direction", "joint direction")
WORDS = ("what", "task direction", "joint direction")
"""The columns that are aligned to the left; the others hold numbers."""
SHOWN, SHOWN_FROM = 3, 0.1
"""A direction is shown by its three largest components, if they are at least this large."""
NOISE = 1e-12
"""Numbers below this fraction of their norm are shown as 0."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """One step of an inverse, split into directions; `print` shows it as a table.

    Attributes:
        inverse: The inverse that is explained.
        J: Jacobian, (m, n).
        xdot: Task velocity asked for, (m,).
        qdot: Joint velocities, (n,), rad/s or m/s.
        threshold: Absolute σ up to which a direction counts as singular.
        directions: The m task directions, by descending σ.
        lost_directions: Orthonormal columns, (m, c), that span the singular ones.
        condition_number: σ₁/σ_k, infinite at a singularity.
        manipulability: Πσ.
        unavoidable_angle: Angle between ẋ and its part that is not lost, rad; see the function of that name.
        rows: Names of the m task rows.
    """

    inverse: RobustInverse
    J: Array
    xdot: Array
    qdot: Array
    threshold: float
    directions: tuple[Direction, ...]
    lost_directions: Array
    condition_number: float
    manipulability: float
    unavoidable_angle: float
    rows: tuple[str, ...]

    @property
    def corank(self) -> int:
        """How many task directions are singular, m − rank, including those that n < m joints leave over."""
        return int(self.lost_directions.shape[1])

    @property
    def smallest_sigma(self) -> float:
        """σ_k, k = min(m, n): the distance, in the 2-norm, of J from a matrix of lower rank; it is no distance in q."""
        return float(self.directions[min(self.J.shape) - 1].sigma)

    @property
    def given(self) -> Array:
        """The task velocity given, J q̇, (m,)."""
        return np.asarray(self.J @ self.qdot)

    @property
    def residual(self) -> Array:
        """The task velocity not given, ẋ − J q̇, (m,)."""
        return np.asarray(self.xdot - self.given)

    @property
    def angle(self) -> float:
        """Angle between ẋ and J q̇, rad; 0 if nothing is asked, π/2 if nothing is given."""
        asked, given = float(np.linalg.norm(self.xdot)), float(np.linalg.norm(self.given))
        if asked == 0 or given == 0:
            return 0.0 if asked == 0 else float(np.pi / 2)
        a, g = self.xdot / asked, self.given / given
        return float(2 * np.arctan2(np.linalg.norm(a - g), np.linalg.norm(a + g)))

    @property
    def speed_lost(self) -> float:
        """1 − ẋᵀJ q̇/‖ẋ‖²: the fraction of the speed asked for that is not given along ẋ; 0 if nothing is asked."""
        asked = float(np.linalg.norm(self.xdot))
        return 1 - float((self.xdot / asked) @ (self.given / asked)) if asked > 0 else 0.0

    @property
    def fastest_joint(self) -> int:
        """Index, from 0, of the joint with the largest |q̇|."""
        return int(np.argmax(np.abs(self.qdot)))

    @property
    def largest_speed(self) -> float:
        """The largest |q̇| of any joint, rad/s or m/s."""
        return float(np.abs(self.qdot).max())

    @property
    def null_share(self) -> float:
        """The fraction of ‖q̇‖² that moves the task in no direction."""
        return max(0.0, 1 - sum(d.share for d in self.directions)) if self.qdot.any() else 0.0

    def __str__(self) -> str:
        return table(self)


@checked
def explain(
    J: ArrayLike,
    xdot: ArrayLike,
    inverse: RobustInverse,
    *,
    threshold: float | None = None,
    qdot: ArrayLike | None = None,
    rows: Sequence[str] | None = None,
) -> Explanation:
    """Explains what an inverse gives of a task velocity and what it loses, direction by direction; print the result.

    Watch for: "singular" depends on the threshold; "lost" in the table is only what no joint can move.

    Args:
        J: Jacobian, one matrix, (m, n).
        xdot: Task velocity, (m,).
        inverse: Any robust inverse.
        threshold: Absolute σ ≥ 0 up to which a direction counts as singular; default RANK_TOLERANCE σ₁.
        qdot: The joint velocities that were commanded, (n,), if known; give them for an inverse that reads the error or
            has a memory, or if null-space motion was added. Default `inverse.solve(J, xdot)`.
        rows: Names of the task rows; default x y z wx wy wz if there are six, else 1, 2, ….

    Raises:
        InputError: Shapes do not fit, or something is NaN or infinite.
    """
    J = _single(J, "J", (None, None))
    m, n = J.shape
    xdot = _single(as_measures(xdot, "xdot", ()), "xdot", (m,))
    s = svd(J).s
    follows = qdot is None
    velocity = inverse.solve(J, xdot) if qdot is None else _single(as_measures(qdot, "qdot", ()), "qdot", (n,))
    limit = RANK_TOLERANCE * float(s[0]) if threshold is None else checked_parameter("threshold", threshold, least=0)
    gains = inverse.gains(s) if isinstance(inverse, SingularValueFilter) else None
    return Explanation(
        inverse=inverse,
        J=readonly(J),
        xdot=readonly(xdot),
        qdot=readonly(velocity),
        threshold=limit,
        directions=take_apart(J, xdot, velocity, limit, gains, follows=follows),
        lost_directions=readonly(lost_directions(J, limit)),
        condition_number=float(condition_number(J)),
        manipulability=float(manipulability(J)),
        unavoidable_angle=float(unavoidable_angle(J, xdot, limit)),
        rows=_row_names(rows, m),
    )


@computed
def unavoidable_angle(J: ArrayLike, xdot: ArrayLike, threshold: ArrayLike | None = None) -> Array:
    """The angle between ẋ and its projection onto the directions that are not lost, rad in [0, π/2].

    For any inverse, ‖ẋ − J q̇‖ ≥ sin(angle) ‖ẋ‖ if it cannot move along singular directions. For m > n the task
    directions that the joints leave over are lost as well. The angle is 0 if nothing is asked.

    Args:
        J: Jacobian, (..., m, n).
        xdot: Task velocity, (..., m); leading axes broadcast against those of J.
        threshold: Absolute σ up to which a direction is lost, broadcast against the leading axes; default
            RANK_TOLERANCE σ₁.

    Returns:
        The angle, shape (...).

    Source: Duleba 2023, section 6.4.
    """
    decomposition = svd(J)
    U, s = decomposition.U, decomposition.s
    xdot = as_array(xdot, "xdot", (U.shape[-2],))
    limit = RANK_TOLERANCE * s[..., :1] if threshold is None else as_array(threshold, "threshold", ())[..., None]
    components = np.where(s > limit, np.einsum("...mk,...m->...k", U, xdot), 0.0)
    kept = np.einsum("...mk,...k->...m", U, components)
    return np.asarray(np.arctan2(np.linalg.norm(xdot - kept, axis=-1), np.linalg.norm(components, axis=-1)))


def _single(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    array = as_array(value, name, shape)
    if array.ndim != len(shape):
        raise InputError(f"explain takes one step, got {name} of shape {array.shape}")
    return array


def _row_names(rows: Sequence[str] | None, m: int) -> tuple[str, ...]:
    names = tuple(rows) if rows is not None else ROWS if m == len(ROWS) else tuple(str(i + 1) for i in range(m))
    if len(names) != m:
        raise InputError(f"rows must name the {m} task rows, got {names!r}")
    return names


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
        direction_in_words(direction.u, explanation.rows),
        direction_in_words(direction.v, [f"q{j + 1}" for j in range(direction.v.size)]),
    )


def _number(value: float, scale: np.floating[Any]) -> str:
    return f"{value:.4g}" if abs(value) > NOISE * scale else "0"


def _percent(fraction: float) -> str:
    return f"{round(fraction, 6) + 0.0:.1%}"  # + 0.0 makes −0.0 positive


def direction_in_words(vector: Array, names: Sequence[str]) -> str:
    """The largest components of a direction by name, such as "+0.91 x −0.41 wz"."""
    largest = [i for i in np.argsort(-np.abs(vector))[:SHOWN] if abs(vector[i]) >= SHOWN_FROM]
    return " ".join(f"{vector[i]:+.2f} {visible(names[i])}" for i in largest).replace("-", "−")
