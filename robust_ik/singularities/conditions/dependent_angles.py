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
        for circuit in _of_size(angles, tangents, size, [same[0] for same in groups]):
            same = next((group for group in groups if _alike(circuit, group[0])), None)
            if same is None:
                groups.append([circuit])
            else:
                same.append(circuit)
    return groups


def _alike(one: Circuit, other: Circuit) -> bool:
    """Whether two circuits of one size have the same normals."""
    cosines = np.abs(np.einsum("ni,ni->n", one.normals, other.normals))
    return len(one.angles) == len(other.angles) and bool(np.median(cosines) > 1 - 1e-6)


def independent(normals: Sequence[Array]) -> bool:
    """Whether covectors, (N, n) each, are linearly independent at most points."""
    return bool(np.median(singular_values(np.stack(normals, axis=1))[:, -1]) > INDEPENDENT)


def _of_size(angles: Sequence[Angle], tangents: Array, size: int, smaller: list[Circuit]) -> list[Circuit]:
    n, found = tangents.shape[-1], []
    for chosen in sorted(combinations(angles, size), key=_complexity):
        M = np.stack([angle.row(n) for angle in chosen])
        if any(set(circuit.angles) < set(chosen) for circuit in smaller) or _redundant(M):
            continue
        decomposed = svd(M @ tangents @ M.T)
        if np.mean(decomposed.s[:, -1] < DEPENDENT) > 0.8:
            normals = decomposed.Vt[:, -1] @ M
            found.append(Circuit(chosen, normals / np.linalg.norm(normals, axis=1, keepdims=True)))
    return found


def _redundant(M: Array) -> bool:
    return bool(singular_values(M)[-1] < 1e-9)


def _complexity(angles: Sequence[Angle]) -> tuple[int, tuple[tuple[int, ...], ...]]:
    """A sort key: few joints first, then in order."""
    return sum(len(angle.joints) for angle in angles), tuple(angle.joints for angle in angles)
