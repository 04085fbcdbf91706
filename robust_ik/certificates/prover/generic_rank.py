"""The rank of an exact arm's Jacobian nearly everywhere, at random points modulo a large prime."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction

from robust_ik.certificates.prover.rational_matrices import (
    Matrix,
    Vector,
    apply,
    cross,
    minus,
    plus,
    times,
    turn,
)
from robust_ik.kinematics.twist_rows import ROWS

START: tuple[Matrix, Vector] = ((1, 0, 0), (0, 1, 0), (0, 0, 1)), (0, 0, 0)
"""Axes and place of the base."""
PRIME = 2**61 - 1
"""A Mersenne prime: by chance a rank is too small modulo it once in 1e17."""
POINTS = 2
"""Random points, of which the largest rank is taken. Chosen: one more than is needed."""


Motions = Sequence[tuple[int, Fraction]]
"""For each motion from the base to the tip, the index of its joint and the factor."""


def generic_rank(
    placements: Sequence[tuple[Matrix, Vector]], motions: Motions, sliding: frozenset[int], rows: Sequence[str]
) -> int:
    """The rank at nearly all configurations.

    Args:
        placements: The c + 1 constant transforms of an arm (rotation, translation), fractions.
        motions: Its c motions.
        sliding: Indices of the prismatic joints.
        rows: Task rows, of x y z wx wy wz.
    """
    links = [(tuple(tuple(map(_residue, row)) for row in R), tuple(map(_residue, p))) for R, p in placements]
    rng = random.Random(0)
    return max(_rank(_jacobian(links, motions, sliding, rows, rng)) for _ in range(POINTS))


def _residue(value: Fraction) -> int:
    """A fraction modulo the prime, which no denominator of an arm is divided by."""
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def _jacobian(
    links: Sequence[tuple[Matrix, Vector]],
    motions: Motions,
    sliding: frozenset[int],
    rows: Sequence[str],
    rng: random.Random,
) -> list[list[int]]:
    """The columns of the Jacobian at a random point, each in the task rows."""
    (axes, place), screws = START, []
    numbers = [rng.randrange(PRIME) for _ in range(1 + max(joint for joint, _ in motions))]
    for (rotation, offset), (joint, factor) in zip(links, motions):
        place, axes = plus(place, apply(axes, offset)), times(axes, rotation)
        axis, number = tuple(row[2] for row in axes), numbers[joint]
        screws.append((axis, place))
        if joint in sliding:
            place = plus(place, tuple(_residue(factor) * number * a for a in axis))
        else:
            scale = pow(1 + number * number, -1, PRIME)
            c, s = (1 - number * number) * scale % PRIME, 2 * number * scale % PRIME
            for _ in range(1, abs(int(factor))):
                c, s = (c * c - s * s) % PRIME, 2 * c * s % PRIME
            axes = times(axes, turn(2, c, s if factor > 0 else -s))
        place, axes = tuple(a % PRIME for a in place), tuple(tuple(a % PRIME for a in row) for row in axes)
    place = plus(place, apply(axes, links[-1][1]))
    columns = [[0] * len(rows) for _ in numbers]
    for (joint, factor), (axis, point) in zip(motions, screws):
        twist = (*axis, 0, 0, 0) if joint in sliding else (*cross(axis, minus(place, point)), *axis)
        moved = (_residue(factor) * twist[ROWS.index(row)] for row in rows)
        columns[joint] = [int(a + b) % PRIME for a, b in zip(columns[joint], moved)]
    return columns


def _rank(matrix: list[list[int]]) -> int:
    """The rank modulo the prime, by elimination."""
    rows, found = [list(row) for row in matrix], 0
    for column in range(len(rows[0])):
        place = next((i for i in range(found, len(rows)) if rows[i][column]), None)
        if place is None:
            continue
        rows[found], rows[place] = rows[place], rows[found]
        scale = pow(rows[found][column], -1, PRIME)
        for i in range(found + 1, len(rows)):
            ratio = rows[i][column] * scale % PRIME
            rows[i] = [(a - ratio * b) % PRIME for a, b in zip(rows[i], rows[found], strict=True)]
        found += 1
    return found
