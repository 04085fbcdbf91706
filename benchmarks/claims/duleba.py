"""Arms with three joints as in Dułęba 2023, eq. (32), of any lengths, and what is measured on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import robust_ik as rik
from robust_ik.analysis import evaluation
from robust_ik.checks import Array
from robust_ik.description.catalog import find


def three_revolute(lengths: Sequence[float] | Array, base: float = 0.0) -> rik.Robot:
    """The arm with a₁, a₂, a₃ as given, and a₀."""
    table = rik.read_dh(find("duleba_3r").path)
    joints = [replace(joint, a=float(length)) for joint, length in zip(table.joints, lengths)]
    joints[0] = replace(joints[0], d=base)
    return rik.Robot.from_dh(replace(table, joints=tuple(joints)))


def half_plane(robot: rik.Robot, count: int) -> tuple[Array, Array]:
    """A and z of (32), (33) over a grid of q₂ and q₃, both (count, count): the tip's place with q₁ = 0."""
    q = np.zeros((count, count, 3))
    q[..., 1:] = np.stack(np.meshgrid(*[np.linspace(-np.pi, np.pi, count)] * 2, indexing="ij"), axis=-1)
    place = robot.pose(q)[..., :3, 3]
    return place[..., 0], place[..., 2]


def meets_its_axis(robot: rik.Robot, count: int = 65) -> bool:
    """Whether the tip gets onto the first joint's axis, A = 0; the stretched arm is a point of the grid."""
    A, _ = half_plane(robot, count)
    return bool(A.min() <= 1e-12)


def axis_heights(robot: rik.Robot, count: int = 401) -> Array:
    """Where on that axis it gets, between neighbours of a grid with A of different signs, (K,)."""
    A, z = half_plane(robot, count)
    row, column = np.nonzero(A[:, :-1] * A[:, 1:] <= 0)
    before, after = A[row, column], A[row, column + 1]
    share = before / np.where(before == after, 1, before - after)
    return np.asarray(z[row, column] + share * (z[row, column + 1] - z[row, column]))


def sizes(count: int = 40) -> tuple[float, float]:
    """How much the least singular value differs among arms of a decimetre to ten metres: ratios, raw and normalised.

    Rows are divided by what (46) says: the sums of the lengths that a coordinate is made of.
    """
    rng = np.random.default_rng(5)
    found = []
    for lengths in 10 ** rng.uniform(-1, 1, (count, 1)) * rng.uniform(0.8, 1.2, (count, 4)):
        robot = three_revolute(lengths[1:], base=lengths[0])
        flat, height = lengths[1:].sum(), lengths[[0, 2, 3]].sum()
        J = robot.jacobian(np.array([0.3, 0.4, 1.2]))
        found.append([rik.svd(each).s[-1] for each in (J, evaluation.normalise(J, [flat, flat, height]))])
    raw, normalised = np.array(found).T
    return float(raw.max() / raw.min()), float(normalised.max() / normalised.min())
