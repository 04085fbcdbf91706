"""Words and numbers for a family of singular configurations and its lost motion. Plain text, not HTML."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.pages.run_table import number
from robust_ik.singularities.conditions import RobotFacts, wrapped
from robust_ik.singularities.families import Stratum
from robust_ik.singularities.lost_motion import FLAT, LostMotion, WrenchScrew

NOTHING = 5e-7
"""A smaller part of a direction than this is rounding error."""


def units(facts: RobotFacts) -> list[str]:
    """The unit in which each joint is shown: ° or m."""
    return ["°" if np.isfinite(period) else "m" for period in facts.chain.period]


def shown_values(facts: RobotFacts, values: Array) -> Array:
    """Joint values (..., n) in these units."""
    return np.asarray(values * np.where(np.isfinite(facts.chain.period), 180.0 / np.pi, 1.0))


def turning_freely(facts: RobotFacts) -> list[bool]:
    """Which joints turn and have no limits, so that whole turns make no difference."""
    endless = ~np.isfinite(facts.lower) & ~np.isfinite(facts.upper)
    return [bool(each) for each in endless & np.isfinite(facts.chain.period)]


def joint_words(facts: RobotFacts, values: Array) -> list[str]:
    """Joint values, (n,), with units; joints that turn without limits are shown between −180° and 180°."""
    values = np.where(turning_freely(facts), wrapped(values, facts.chain.period), values)
    return [
        f"{_signed(value, 1)}°" if unit == "°" else f"{_signed(value, 3)} {unit}"
        for value, unit in zip(shown_values(facts, values), units(facts))
    ]


def limit_words(facts: RobotFacts, stratum: Stratum) -> str:
    """Whether a stratum lies within the joint limits, and its margin."""
    if np.isinf(stratum.margin):
        return "no limits"
    turning = np.isfinite(facts.chain.period)
    size = abs(stratum.margin)
    far = f"{np.degrees(size):.1f}°" if turning.all() else f"{size:.3f} rad or m"
    return f"within, by {far}" if stratum.within_limits else f"outside by {far}"


def axis_words(vector: Array) -> str:
    """A vector, (3,), as text: "(0, 0.6, −0.8)"."""
    return f"({', '.join(_short(value) for value in vector)})"


def direction_words(vector: Array) -> str:
    """A direction, (3,), as text: x, y or z if it is one."""
    size = float(np.linalg.norm(vector))
    unit = np.asarray(vector) / size if size > 0 else np.asarray(vector)
    largest = int(np.abs(unit).argmax())
    others = np.delete(unit, largest)
    return "xyz"[largest] if np.abs(others).max() < 1e-6 else axis_words(unit)


def twist_words(twist: Array) -> str:
    """A twist, (6,), as text, linear part first."""
    linear, angular = float(np.linalg.norm(twist[:3])), float(np.linalg.norm(twist[3:]))
    if angular < NOTHING:
        return f"translation along {direction_words(twist[:3])}"
    if linear < NOTHING:
        return f"rotation about {direction_words(twist[3:])}"
    return f"translation by {axis_words(twist[:3])} m with rotation by {axis_words(twist[3:])} rad"


def screw_words(screw: WrenchScrew) -> str:
    """A wrench as text: a force along a line, a couple about a direction, or both."""
    direction = direction_words(screw.axis)
    if screw.is_couple:
        return f"couple about {direction}"
    line = f"along {direction} through {axis_words(screw.point)} m"
    return f"force {line}" if screw.is_force else f"screw {line}, pitch {_short(screw.pitch)} m/rad"


def curvature_words(lost: LostMotion, index: int) -> str:
    """How a self-motion leads along a lost direction, with κ in units of the unit direction."""
    low, high = (float(value) for value in lost.curvature[index])
    which = "" if lost.corank == 1 else f"direction {index + 1}: "
    if max(abs(low), abs(high)) < FLAT:
        return f"{which}κ = 0"
    unit = "m/rad²" if np.abs(lost.twists[3:, index]).max() < NOTHING else "per rad²"
    if high - low < FLAT:
        return f"{which}κ = {_digits(low)} {unit}"
    return f"{which}κ from {_digits(low)} to {_digits(high)} {unit}"


def _short(value: float) -> str:
    """A number with three decimals, without trailing zeros."""
    text = f"{float(value):.3f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text.replace("-", "−")


def _digits(value: float) -> str:
    """A number with three significant digits, however small it is."""
    return number(value).replace("-", "−")


def _signed(value: float, decimals: int) -> str:
    text = f"{float(value):.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", "−")
