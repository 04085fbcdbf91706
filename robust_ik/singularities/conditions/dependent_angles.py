"""Finds which joints are coupled: the smallest dependent sets of angles on a stratum's tangent spaces.

On an irreducible stratum a set of joints is related if and only if their tangents at generic points are linearly
dependent: the smallest such sets are the circuits of a matroid. A pinned joint is a circuit of one, a free joint is in
none. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values, svd
from robust_ik.singularities.conditions.angle_sums import Angle

LARGEST = 4
"""Most angles of a set that is examined: larger sets have no short relation."""
DEPENDENT = 1e-9
"""Squared singular values of tangents below this count as zero."""
INDEPENDENT = 1e-4
"""Least singular value of independent unit covectors. Chosen: far above rounding, far below usual values."""
REDUNDANT = 1e-9
"""Smallest singular value of angles that are combinations of each other, whose entries are 0 and ±1: rounding."""
SETS = 200
"""Sets that are examined at once. Chosen: they take a megabyte."""
POINTS = 24
"""Points at which sets are compared. Chosen: enough to see that four of five agree; more take longer."""


@dataclass(frozen=True, eq=False)
class Circuit:
    """A smallest dependent set of angles, and the normals of its condition.

    Attributes:
        angles: The angles.
        normals: Unit covectors of the joints that vanish on the tangent spaces, (N, n).
    """

    angles: tuple[Angle, ...]
    normals: Array

    @property
    def joints(self) -> tuple[int, ...]:
        """Every joint in it, ascending."""
        return tuple(sorted({joint for angle in self.angles for joint in angle.joints}))


def circuit_groups(angles: Sequence[Angle], tangents: Array) -> list[list[Circuit]]:
    """All smallest dependent sets of angles, in groups with equal conditions, small ones first.

    Args:
        angles: Candidates.
        tangents: Projectors onto the tangent spaces at generic points, (N, n, n).
    """
    tangents = tangents[:POINTS]
    groups: list[list[Circuit]] = []
    for size in range(1, LARGEST + 1):
        groups += _grouped(_of_size(angles, tangents, size, [same[0] for same in groups]))
    return groups


def _grouped(circuits: list[Circuit]) -> list[list[Circuit]]:
    """Circuits of one size in groups with the same normals."""
    groups: list[list[Circuit]] = []
    rest = circuits
    while rest:
        cosines = np.abs(np.einsum("cni,ni->cn", np.stack([each.normals for each in rest]), rest[0].normals))
        alike = np.median(cosines, axis=1) > 1 - 1e-6
        alike[0] = True
        groups.append([each for each, same in zip(rest, alike) if same])
        rest = [each for each, same in zip(rest, alike) if not same]
    return groups


def independent(normals: Sequence[Array]) -> bool:
    """Whether covectors, (N, n) each, are linearly independent at most points."""
    return bool(np.median(singular_values(np.stack(normals, axis=1))[:, -1]) > INDEPENDENT)


def _of_size(angles: Sequence[Angle], tangents: Array, size: int, smaller: list[Circuit]) -> list[Circuit]:
    known = [set(circuit.angles) for circuit in smaller]
    sets = [each for each in combinations(angles, size) if not any(circuit < set(each) for circuit in known)]
    sets.sort(key=_complexity)
    rows, found = {angle: angle.row(tangents.shape[-1]) for angle in angles}, []
    for first in range(0, len(sets), SETS):
        chosen = sets[first : first + SETS]
        M = np.array([[rows[angle] for angle in each] for each in chosen])
        decomposed = svd(M[:, None] @ tangents @ np.swapaxes(M, 1, 2)[:, None])
        dependent = np.mean(decomposed.s[..., -1] < DEPENDENT, axis=1) > 0.8
        for index in np.flatnonzero(dependent & ~(singular_values(M)[:, -1] < REDUNDANT)):
            normals = decomposed.Vt[index, :, -1] @ M[index]
            found.append(Circuit(chosen[index], normals / np.linalg.norm(normals, axis=1, keepdims=True)))
    return found


def _complexity(angles: Sequence[Angle]) -> tuple[int, tuple[tuple[int, ...], ...]]:
    """A sort key: few joints first, then in order."""
    return sum(len(angle.joints) for angle in angles), tuple(angle.joints for angle in angles)
