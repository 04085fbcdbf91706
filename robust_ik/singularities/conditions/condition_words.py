"""Conditions as text: q4 ∈ {0, π}; a2 c2 + a3 c23 + d4 s23 = 0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np

from robust_ik.description.dh import DHTable
from robust_ik.singularities.conditions.angle_sums import Angle, wrapped
from robust_ik.singularities.conditions.trig_relations import Relation, Term

SAME = 1e-6
"""Relative difference up to which numbers have the same symbol."""
TINY = 1e-4
"""Coefficients below this are of lengths: fitted ones are larger, see `relation_fitting.SMALLEST`."""
Symbols = Mapping[str, float]


def symbols(table: DHTable | None) -> dict[str, float]:
    """The lengths of a DH table by name; in a modified table a of row i is that of the previous link, a(i − 1)."""
    if table is None:
        return {}
    shift = 1 if table.convention == "modified" else 0
    lengths = {f"a{i - shift}": joint.a for i, joint in enumerate(table.joints, start=1)}
    lengths |= {f"d{i}": joint.d for i, joint in enumerate(table.joints, start=1) if joint.kind == "revolute"}
    return {name: length for name, length in lengths.items() if abs(length) > SAME}


def condition(angle: Angle, values: Sequence[float], known: Symbols) -> str:
    """The condition that an angle has one of some values: "q4 ∈ {0, π}", "q3 = ±π/2", "tan q3 = −d4/a3"."""
    if angle.circular and (ratio := _tangent(values, known)):
        return f"tan {angle} = {ratio}" if len(angle.joints) == 1 else f"tan({angle}) = {ratio}"
    unit = "" if angle.circular else " m"
    shown = [number(value, angle.circular) for value in sorted(values, key=lambda value: (abs(value), value))]
    if len(values) == 1:
        return f"{angle} = {shown[0]}{unit}"
    if len(values) == 2 and abs(sum(values)) < SAME * (1.0 if angle.circular else max(map(abs, values))):
        return f"{angle} = ±{number(max(values), angle.circular)}{unit}"
    return f"{angle} ∈ {{{', '.join(shown)}}}{unit}"


def number(value: float, circular: bool = True) -> str:
    """A number as text: a multiple of π as such, others with six decimals."""
    part = Fraction(value / np.pi).limit_denominator(12)
    if not circular and abs(value) < TINY:
        return f"{value:.6g}".replace("-", "−")
    if not circular or abs(value - part * np.pi) > SAME:
        return f"{value:.6f}".replace("-", "−")
    if part == 0:
        return "0"
    top = {1: "π", -1: "−π"}.get(part.numerator, f"{part.numerator}π".replace("-", "−"))
    return top if part.denominator == 1 else f"{top}/{part.denominator}"


def _tangent(values: Sequence[float], known: Symbols) -> str:
    """For two values that differ by π, their tangent as a ratio of two lengths; empty if it is none."""
    if len(values) != 2 or abs(abs(wrapped(values[0] - values[1], 2 * np.pi)) - np.pi) > SAME:
        return ""
    tangent = float(np.tan(values[0]))
    if min(abs(np.cos(values[0])), abs(np.sin(values[0]))) < SAME:
        return ""
    for over, top in known.items():
        for under, bottom in known.items():
            if over != under and abs(abs(top / bottom) - abs(tangent)) < SAME * abs(tangent):
                return f"{'' if top / bottom * tangent > 0 else '−'}{over}/{under}"
    return ""


def equation(relation: Relation, known: Symbols) -> str:
    """A relation as text, its coefficients as symbols if all have one, else as numbers."""
    names = _names(relation, known) or [_shown(float(value)) for value in relation.coefficients]
    if names[0].startswith("−"):
        names = [name[1:] if name.startswith("−") else f"−{name}" for name in names]
    parts = []
    for name, term in zip(names, relation.terms):
        sign, size = ("−", name[1:]) if name.startswith("−") else ("+", name)
        parts.append(f"{sign} {_product(size, term)}")
    return " ".join(parts).removeprefix("+ ").replace("− ", "−", int(parts[0][0] == "−")) + " = 0"


def _product(size: str, term: Term) -> str:
    factors = [str(factor) for factor in term]
    return " ".join(factors if size == "1" and factors else [size, *factors])


def _shown(value: float) -> str:
    """A coefficient with six decimals; one that is tiny, of a slide of a huge arm, with six digits."""
    if abs(value) < TINY:
        return f"{value:.6g}".replace("-", "−")
    return f"{value:.6f}".rstrip("0").rstrip(".").replace("-", "−")


def _names(relation: Relation, known: Symbols) -> list[str] | None:
    """Symbols to which all coefficients are proportional, or None."""
    for length in known.values():
        for coefficient in relation.coefficients:
            scaled = relation.coefficients * (length / coefficient)
            names = [_name(float(value), known, term) for value, term in zip(scaled, relation.terms)]
            if all(names):
                return [name for name in names if name]
    return None


def _name(value: float, known: Symbols, term: Term) -> str | None:
    """The name of a length of that magnitude; of several, that of the term's last joint, else the first."""
    last = max((joint + 1 for factor in term for joint in factor.angle.joints), default=0)
    fitting = [name for name, length in known.items() if abs(abs(value) - abs(length)) < SAME * abs(length)]
    if not fitting:
        return None
    name = next((name for name in fitting if name[1:] == str(last)), fitting[0])
    return name if value * known[name] > 0 else f"−{name}"
