"""Small exact matrices: tuples of rows, of fractions or of polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

Vector = tuple[Any, ...]
Matrix = tuple[Vector, ...]

ZERO, ONE = Fraction(0), Fraction(1)
IDENTITY: Matrix = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))
ORIGIN: Vector = (ZERO, ZERO, ZERO)


def dot(u: Sequence[Any], v: Sequence[Any]) -> Any:
    """Σ uᵢ vᵢ; zero entries, which are most in links, are skipped."""
    result = u[0] * v[0]
    for a, b in zip(u[1:], v[1:], strict=True):
        if a and b:
            result = result + a * b
    return result


def times(A: Matrix, B: Matrix) -> Matrix:
    """The product of two matrices."""
    columns = tuple(zip(*B, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in A)


def apply(A: Matrix, v: Sequence[Any]) -> Vector:
    """A matrix times a vector."""
    return tuple(dot(row, v) for row in A)


def transpose(A: Matrix) -> Matrix:
    """The transpose; for a rotation its inverse."""
    return tuple(zip(*A, strict=True))


def cross(u: Sequence[Any], v: Sequence[Any]) -> Vector:
    """The vector product."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def plus(u: Sequence[Any], v: Sequence[Any]) -> Vector:
    """The sum of two vectors."""
    return tuple(a + b for a, b in zip(u, v, strict=True))


def minus(u: Sequence[Any], v: Sequence[Any]) -> Vector:
    """The difference of two vectors."""
    return tuple(a - b for a, b in zip(u, v, strict=True))


def turn(axis: int, cosine: Any, sine: Any) -> Matrix:
    """The rotation about x, y or z (0, 1 or 2) with this cosine and sine."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    zero = cosine * 0
    rows = [[zero + (row == column) for column in range(3)] for row in range(3)]
    rows[i][i], rows[j][j], rows[i][j], rows[j][i] = cosine, cosine, -sine, sine
    return tuple(tuple(row) for row in rows)
