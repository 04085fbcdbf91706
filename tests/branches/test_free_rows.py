"""Arms of fewer joints in the rows they have: every set of rows, by an error of the test's own."""

import itertools

import numpy as np
import pytest

from robust_ik.branches.free_rows import FreeRows
from tests import dh_arms
from tests.branches.test_all_solutions import apart, holds

ROWS = ("x", "y", "z", "wx", "wy", "wz")
SETS = [rows for m in range(2, 6) for rows in itertools.combinations(ROWS, m)]
FREE = [rows for rows in SETS if sum(row[0] == "w" for row in rows) != 1]
"""With one rotation wanted an arm must turn about that axis alone: see the SCARA."""


def random_arm(count, rng, kinds=None):
    return dh_arms.robot_of(dh_arms.random_rows(rng, "general")[:count], kinds=(kinds or "RRRRRR")[:count])


def errors(robot, q, T, rows):
    """What a configuration misses: coordinates of the position, how far the free axis of rotations leaves itself."""
    M = robot.pose(q)
    found = [abs(M[i, 3] - T[i, 3]) for i, row in enumerate("xyz") if row in rows]
    turning = [i for i, row in enumerate(ROWS[3:]) if row in rows]
    D = M[:3, :3] @ T[:3, :3].T
    if len(turning) == 3:
        found.append(np.abs(D - np.eye(3)).max())
    if len(turning) == 2:
        (free,) = {0, 1, 2} - set(turning)
        found.append(np.abs(D @ np.eye(3)[free] - np.eye(3)[free]).max())
    return max(found)


@pytest.mark.parametrize("rows", FREE, ids="-".join)
def test_solutions_miss_nothing_that_is_wanted_and_none_that_a_search_finds_is_missing(rows, rng):
    robot = random_arm(len(rows), np.random.default_rng(3)).with_rows(rows)
    if robot.branch_solver().method == "search":
        pytest.skip(f"this arm has no regular configuration in {rows}")
    for q in robot.random(rng, 12):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        assert found.complete
        assert apart(robot, found.q, q).min() < 1e-6
        assert max(errors(robot, each, T, rows) for each in [*found.q, *found.beyond]) < 1e-9
        reached = robot.solve_pose(T, robot.random(rng))
        if reached.solved:
            assert apart(robot, found.q, reached.q).min() < 1e-4


@pytest.mark.parametrize(
    "rows", [("x", "y", "wx", "wy"), ("z", "wx", "wy", "wz"), ("y", "z", "wy", "wz"), ("x", "z"), ROWS[:5]]
)
def test_slides_of_an_arm_and_those_that_float_are_told_apart(rows, rng):
    robot = random_arm(len(rows), np.random.default_rng(4), "RPRRRR").with_rows(rows)
    for q in robot.random(rng, 12):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        assert holds(robot, found, q)
        assert max(errors(robot, each, T, rows) for each in found.q) < 1e-9


@pytest.mark.parametrize("rows", [("x", "y"), ("x", "y", "wx", "wy"), ("y", "z", "wx", "wy", "wz"), ("x", "y", "z")])
def test_self_motions_of_an_arm_with_a_joint_more_keep_what_is_wanted(rows, rng):
    robot = random_arm(len(rows) + 1, np.random.default_rng(3)).with_rows(rows)
    assert robot.branch_solver().method == "self-motions"
    for q in robot.random(rng, 3):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        assert found.self_motions
        assert holds(robot, found, q)
        for curve in found.self_motions:
            assert max(errors(robot, each, T, rows) for each in curve.q) < 1e-8
            assert np.ptp(curve.q, axis=0).max() > 1e-3


def test_what_is_free_is_said_by_name():
    free = FreeRows.of(("x", "wy", "wz"))
    assert free.sliding == (1, 2)
    assert free.spinning == (0,)
    assert free.wanted.tolist() == [True, False, False]
    assert free.rotates
    assert not FreeRows.of(("x", "y")).rotates
