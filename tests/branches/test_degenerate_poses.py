"""Poses where roots fall together, leave continua, or the eliminant vanishes; joints at limits; slides far out."""

from dataclasses import fields

import numpy as np
import pytest

import robust_ik as rik
from robust_ik import BranchSolver, SolutionsStatus
from robust_ik.branches import solver as solvers
from tests import dh_arms
from tests.branches.test_all_solutions import apart, arm, holds, misses, singular_configurations

HALF = np.pi / 2


# ------------------------------------------------------------------------------------------------ what is found there
@pytest.mark.parametrize("name", ["ur5", "kr16_like", "crx_like", "gen3_6_like", "jaco_like"])
def test_configurations_of_right_angles_are_found_and_none_is_twice(name, rng):
    """Axes are parallel, meet and coincide there: one may be missed, never where all are said to be found."""
    robot, hits = arm(name), []
    for q in HALF * rng.integers(-1, 3, (24, 6)):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        hits.append(holds(robot, found, q))
        assert hits[-1] or not found.complete
        for i, each in enumerate(found):
            assert misses(robot, each, T) < 1e-10
            assert all(apart(robot, each, other) > 1e-6 for other in found.q[:i])
    assert np.mean(hits) > 0.9


RIGHT_ANGLES = {
    "crx_like": ([0, 0, 1, -1, 2, -1], [0, 2, 1, 1, 1, -1]),
    "gen3_6_like": ([1, -1, 1, -1, -1, 2], [0, -1, 1, 1, -1, -1]),
}


@pytest.mark.parametrize("name", RIGHT_ANGLES)
def test_a_singular_solution_does_not_hide_that_others_are_missing(name):
    """Of these poses one is missed at a root that a singular solution shares."""
    robot = arm(name)
    for turns in RIGHT_ANGLES[name]:
        T = robot.pose(HALF * np.array(turns, dtype=float))
        assert not robot.all_solutions_many(T[None]).complete[0]
        assert not robot.all_solutions(T).complete


@pytest.mark.parametrize("name", ["ur3", "ur5", "irb120_like", "kr16_like"])
def test_solutions_beside_a_straight_wrist_reach_the_pose(name, rng):
    robot = arm(name)
    for bend in (1e-3, 1e-4, 1e-5, 1e-6):
        for q in robot.random(rng, 6):
            q[4] = bend
            T = robot.pose(q)
            found = robot.all_solutions(T)
            assert holds(robot, found, q)
            assert all(misses(robot, each, T) < 1e-10 for each in found)


# ------------------------------------------------------------------------------------------------- what is said of it
def test_a_ur_with_four_parallel_axes_is_said_to_have_a_continuum(rng):
    """With joint 5 at 0 axis 6 is parallel to axes 2, 3 and 4: they turn while the tool stands still."""
    robot = arm("ur5")
    for q in robot.random(rng, 6):
        q[4] = 0.0
        found = robot.all_solutions(robot.pose(q))
        assert found.status is SolutionsStatus.DEGENERATE
        assert found.self_motions
        assert holds(robot, found, q)


@pytest.mark.parametrize("bend", [1e-10, 1e-9, 1e-8, 1e-7, 1e-6])
def test_beside_a_continuum_what_is_said_to_be_complete_is(bend, rng):
    """Much nearly reaches the pose there; what does not reach it is not among the solutions."""
    robot = arm("ur5")
    for q in robot.random(rng, 4):
        q[4] = bend
        T = robot.pose(q)
        found = robot.all_solutions(T)
        assert not found.complete or holds(robot, found, q)
        assert all(misses(robot, each, T) < 3e-10 for each in found.q)


@pytest.mark.parametrize("name", ["crx_like", "jaco_like", "gen3_6_like"])
def test_where_the_eliminant_vanishes_solutions_are_not_said_to_be_all(name, rng):
    """Axes 1 and 6 are parallel where the tool points straight down."""
    robot = arm(name)
    for T in robot.pose(robot.random(rng, 20)):
        T[:3, :3] = np.diag([1.0, -1.0, -1.0])
        assert not robot.all_solutions(T).complete


@pytest.mark.parametrize("name", ["crx_like", "gen3_6_like"])
def test_a_double_root_is_accounted_for_by_one_singular_solution(name, rng):
    robot = arm(name)
    said = [robot.all_solutions(robot.pose(q)).complete for q in singular_configurations(robot, rng, 12)]
    assert np.mean(said) > 0.5


def test_a_root_without_a_solution_is_told_of_an_arm_in_closed_form(rng):
    robot = arm("kr16_like")
    solver, lay = robot.branch_solver(), solvers.lay
    T, near = robot.pose(robot.random(rng, 10)), robot.joint_values(robot.rest)
    assert all(solver.solve(one, near).complete for one in T)
    broken = BranchSolver(**{each.name: getattr(solver, each.name) for each in fields(solver)})
    plans = solver.plans[solver.plans[:, lay.TRIPLE] > 0].copy()
    plans[:, lay.SPANS : lay.SPANS + 32] *= 1 + 0.1 * rng.normal(size=32)  # roots are no longer where solutions are
    broken.__dict__["plans"] = plans
    said = [broken.solve(one, near).status for one in T]
    assert said.count(SolutionsStatus.DOUBTFUL) >= 7


# ------------------------------------------------------------------------------------------------------------- limits
@pytest.mark.parametrize("limits", [(-0.5, 5.5), (-5.5, 0.5)])
def test_turns_are_chosen_within_limits_that_are_not_about_zero(limits, rng):
    robot = dh_arms.arm("kr16_like", limits)
    for q in rng.uniform(*limits, (20, 6)):
        for q0 in (robot.lower, robot.upper):
            found = robot.all_solutions(robot.pose(q), q0)
            assert np.abs(found.q - q).max(axis=1).min() < 1e-6


def test_a_joint_at_its_limit_is_within_limits(rng):
    robot = dh_arms.arm("kr16_like", (-1.1, 1.3))
    for _ in range(20):
        q = np.where(rng.random(6) < 0.5, robot.lower, robot.upper)
        found = robot.all_solutions(robot.pose(q), q)
        assert apart(robot, found.q[0], q) < 1e-9
        assert ((found.q >= robot.lower) & (found.q <= robot.upper)).all()


# ------------------------------------------------------------------------------------------------------------- slides
@pytest.mark.parametrize("kinds", ["RRPRRR", "PRRRRR", "RPRRRR"])
def test_slides_before_a_wrist_leave_no_root_at_infinity_without_a_solution(kinds, rng):
    rows = [
        (0.1, 0.4, -HALF), (0.2, 0.3, 1.1), (0.1, 0.2, HALF), (0, 0.4, HALF), (0, 0, -HALF), (0, 0.1, 0)
    ]  # fmt: skip
    robot = dh_arms.robot_of(rows, kinds=kinds)
    assert robot.branch_solver().method == "closed form"
    for q in robot.random(rng, 20):
        found = robot.all_solutions(robot.pose(q))
        assert holds(robot, found, q)
        assert found.complete


def test_two_slides_that_are_neighbours_are_solved_for(rng):
    rows = dh_arms.random_rows(np.random.default_rng(8), "general")
    robot = dh_arms.robot_of(rows, kinds="RRRPPR")
    for q in robot.random(rng, 60):
        assert holds(robot, robot.all_solutions(robot.pose(q)), q)


# -------------------------------------------------------------------------------------------------------------- poses
def test_a_half_turn_from_zero_is_solved_about_any_axis(rng):
    """Each of the four ways to a quaternion is the only good one somewhere."""
    robot = arm("kr16_like")
    home = robot.pose(np.zeros(6))
    for axis in np.eye(3):
        for _ in range(20):
            T = home.copy()
            T[:3, :3] = (2 * np.outer(axis, axis) - np.eye(3)) @ home[:3, :3]
            T[:3, 3] = rng.uniform(-0.6, 0.6, 3) + [0, 0, 0.7]
            found = robot.all_solutions(T)
            assert found.complete
            assert all(misses(robot, each, T) < 1e-10 for each in found)


@pytest.mark.parametrize("place", [(3, 0), (3, 3), (0, 3)])
def test_a_matrix_that_is_a_pose_but_for_one_entry_is_refused(place):
    robot = arm("ur5")
    T = robot.pose(np.full(6, 0.3))
    T[place] = 1e12 if place == (0, 3) else T[place] + 0.1
    with pytest.raises(rik.InputError):
        robot.all_solutions(T)
