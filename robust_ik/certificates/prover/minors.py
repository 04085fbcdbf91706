"""Eliminates constant pivots of a matrix, and lists the minors that remain."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from robust_ik.certificates.effort import Effort
from robust_ik.certificates.prover.number_fields import Element, coefficients
from robust_ik.certificates.prover.trig_polynomials import Trig

Texts = tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Minor:
    """A minor of the Jacobian after combining rows with constant weights.

    Attributes:
        value: Its value, a reduced trigonometric polynomial.
        rows: For each of its rows the weights of the Jacobian's rows, elements of the field given by coefficients.
        columns: Its columns.
    """

    value: Any
    rows: tuple[Texts, ...]
    columns: tuple[int, ...]


@dataclass(frozen=True)
class ReducedMatrix:
    """A matrix with its constant columns eliminated: rank = number of pivots + rank of the rest.

    Attributes:
        trig: The ring of the entries.
        pivots: (column, weights of the row, value) of every pivot.
        rest: The remaining rows, columns as in the matrix; zero in the pivot columns.
        weights: For each remaining row the weights of the matrix's rows.
    """

    trig: Trig
    pivots: tuple[tuple[int, list[Element], Element], ...]
    rest: list[list[Any]]
    weights: list[list[Element]]

    def minors(self, size: int, effort: Effort) -> Iterator[Minor]:
        """All non-zero minors of this size that contain the pivots.

        Raises:
            TooLargeError: One has too many terms, or no steps are left.
        """
        s = size - len(self.pivots)
        fixed = tuple(column for column, *_ in self.pivots)
        free = [j for j in range(len(self.rest[0])) if j not in fixed and any(row[j] for row in self.rest)]
        cache: dict[tuple[tuple[int, ...], tuple[int, ...]], Any] = {}
        for rows in itertools.combinations(range(len(self.rest)), s):
            for columns in itertools.combinations(free, s):
                before = len(cache)
                value = self._minor(rows, columns, cache)
                effort.spend((len(cache) - before) * (1 + len(value) // 16))
                effort.check_terms(len(value), "a minor")
                if value:
                    yield Minor(value, self._weights(rows), (*fixed, *columns))

    def determinant(self, size: int) -> Element:
        """The product of the first pivots, an element of the field."""
        result = self.trig.field.polynomial**0
        for _, _, value in self.pivots[:size]:
            result = self.trig.field.reduce(result * value)
        return result

    def constant(self, size: int) -> Minor:
        """The minor that consists of pivots only."""
        kept = self.pivots[:size]
        rows = tuple(tuple(coefficients(value) for value in weights) for _, weights, _ in kept)
        return Minor(None, rows, tuple(column for column, *_ in kept))

    def _weights(self, rows: tuple[int, ...]) -> tuple[Texts, ...]:
        pivots, rest = self._texts
        return (*pivots, *(rest[i] for i in rows))

    @cached_property
    def _texts(self) -> tuple[tuple[Texts, ...], tuple[Texts, ...]]:
        """The weights of the pivots' rows and of the remaining rows, each element as its coefficients."""
        pivots = [weights for _, weights, _ in self.pivots]
        first, rest = (
            tuple(tuple(coefficients(value) for value in weights) for weights in each)
            for each in (pivots, self.weights)
        )
        return first, rest

    def _minor(self, rows: tuple[int, ...], columns: tuple[int, ...], cache: dict[Any, Any]) -> Any:
        if not rows:
            return self.trig.context.constant(1)
        key = (rows, columns)
        if key not in cache:
            result = self.trig.context.constant(0)
            for place, column in enumerate(columns):
                entry = self.rest[rows[0]][column]
                if entry:
                    rest = self._minor(rows[1:], columns[:place] + columns[place + 1 :], cache)
                    if rest:
                        result += entry * rest * (-1) ** place
            cache[key] = self.trig.reduce(result)
        return cache[key]


def reduced(trig: Trig, matrix: list[list[Any]]) -> ReducedMatrix:
    """The matrix with its constant columns eliminated as long as there are any; all row operations are constant."""
    rows = [list(row) for row in matrix]
    one, zero = trig.field.polynomial**0, trig.field.polynomial * 0
    weights = [[one if i == j else zero for j in range(len(rows))] for i in range(len(rows))]
    pivots: list[tuple[int, list[Element], Element]] = []
    while (found := _pivot(rows, {column for column, *_ in pivots})) is not None:
        index, column = found
        row, weight = rows.pop(index), weights.pop(index)
        pivot = _element(trig, row[column])
        inverse = trig.field.inverse(pivot)
        for i, other in enumerate(rows):
            ratio = trig.field.reduce(_element(trig, other[column]) * inverse)
            if ratio:
                scale = trig.element(ratio)
                rows[i] = [trig.reduce(a - scale * b) for a, b in zip(other, row)]
                weights[i] = [trig.field.reduce(a - ratio * b) for a, b in zip(weights[i], weight)]
        pivots.append((column, weight, pivot))
    return ReducedMatrix(trig, tuple(pivots), rows, weights)


def _pivot(rows: list[list[Any]], used: set[int]) -> tuple[int, int] | None:
    """The position of a non-zero entry in a constant column; None if there is none."""
    if not rows:
        return None
    for column in range(len(rows[0])):
        if column not in used and all(_is_constant(row[column]) for row in rows):
            for index, row in enumerate(rows):
                if row[column]:
                    return index, column
    return None


def _is_constant(value: Any) -> bool:
    return not value or not any(value.degrees()[:-1])


def _element(trig: Trig, value: Any) -> Element:
    """A constant entry as an element of the field."""
    terms = {exponents[-1]: coefficient for exponents, coefficient in value.to_dict().items()}
    one = trig.field.polynomial**0
    x = type(one)([0, 1])
    return sum((x**power * coefficient for power, coefficient in terms.items()), start=one * 0)
