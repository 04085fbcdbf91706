"""All solutions of a pose: none is missed, none is twice, and what is said of their number is true."""

import pickle
from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik import BranchSolver, SolutionsStatus
from robust_ik.branches import solver as solvers
from tests import dh_arms, pinocchio_reference
from tests.arms import arm_of, ur5

NAMED = ("z1", "puma560", "kinova", "so101", "duleba_3r", "planar_2r")


@cache
def arm(name):
    return dh_arms.arm(name) if name in dh_arms.ARMS else rik.load(name)


@cache
def random_arm(kind, number):
    """A random arm that has full rank somewhere."""
    rng = np.random.default_rng([number, *kind.encode()])
    while True:
        robot = dh_arms.robot_of(dh_arms.random_rows(rng, kind))
        s = np.linalg.svd(robot.jacobian(robot.random(rng, 5)), compute_uv=False)
        if (s[:, -1] / s[:, 0]).max() > 1e-6:
            return robot


def apart(robot, a, b):
    """The largest difference of joint values, turns modulo 2π."""
    d = robot.joint_values(a) - robot.joint_values(b)
    return np.abs(np.where(robot.sliding, d, d - 2 * np.pi * np.round(d / (2 * np.pi)))).max(axis=-1)


def holds(robot, solutions, q):
    """Whether q is one of the solutions, or lies on one of their self-motions.

    At a fold the pose changes with the square of the joints: an error of 1e-12 leaves them within some 1e-6, and joints
    4 and 6 of a wrist that is nearly straight within that over its bend.
    """
    if len(solutions) and apart(robot, solutions.q, q).min() < 1e-3:
        return True
    return any(apart(robot, curve.q, q).min() < 0.15 for curve in solutions.self_motions)


def misses(robot, q, T):
    """How far Pinocchio's pose at q is from T in the robot's rows, m and rad."""
    M = pinocchio_reference.pose(robot, q, robot.tip)
    twist = np.concatenate([M[:3, 3] - T[:3, 3], rotation_vector(M[:3, :3] @ T[:3, :3].T)])
    return np.abs(twist[[["x", "y", "z", "wx", "wy", "wz"].index(row) for row in robot.rows]]).max()


def rotation_vector(R):
    return 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


# --------------------------------------------------------------------------------------------------- none is missed
@pytest.mark.parametrize("name", [*dh_arms.ARMS, *NAMED])
def test_a_configuration_is_among_the_solutions_of_its_pose(name, rng):
    robot = arm(name)
    q = robot.random(rng, 300)
    found = robot.all_solutions_many(robot.pose(q))
    assert found.complete.mean() > 0.98
    for solutions, count, one in zip(found.q, found.found, q):
        assert count
        assert apart(robot, solutions[:count], one).min() < 1e-6


@pytest.mark.parametrize("number", range(8))
@pytest.mark.parametrize("kind", dh_arms.KINDS)
def test_a_configuration_of_a_random_arm_is_among_the_solutions_of_its_pose(kind, number, rng):
    robot = random_arm(kind, number)
    q = robot.random(rng, 60)
    found = robot.all_solutions_many(robot.pose(q))
    assert found.complete.mean() > 0.95
    hits = [n and apart(robot, s[:n], one).min() < 1e-5 for s, n, one in zip(found.q, found.found, q)]
    assert np.all(hits)


@pytest.mark.parametrize("name", ["ur5", "kr16_like", "crx_like", "gen3_6_like", "jaco_like", "z1"])
def test_a_search_from_many_starts_finds_no_other_solution(name, rng):
    robot = arm(name)
    for q in robot.random(rng, 6):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        searched = robot.solve_pose(T, solutions=32, effort="thorough").solutions
        assert all(holds(robot, found, each) for each in searched)


def test_an_arm_without_structure_has_solutions_in_even_numbers_up_to_sixteen(rng):
    counts = set()
    for number in range(8):
        robot = random_arm("general", number)
        found = robot.all_solutions_many(robot.pose(robot.random(rng, 60)))
        counts |= set((found.found + found.beyond)[found.complete].tolist())
    assert counts <= set(range(2, 17, 2))
    assert len(counts) >= 4


# ------------------------------------------------------------------------------------ each is one, and none is twice
@pytest.mark.parametrize("name", [*dh_arms.ARMS, *NAMED])
def test_every_solution_reaches_the_pose_within_limits_and_none_is_twice(name, rng):
    robot = arm(name)
    for q in robot.random(rng, 20):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        for i, each in enumerate(found):
            assert misses(robot, each, T) < 1e-10
            values = robot.joint_values(each)
            assert ((values >= robot.lower) & (values <= robot.upper)).all()
            assert all(apart(robot, each, other) > 1e-6 for other in found.q[:i])
        for each in found.beyond:
            values = robot.joint_values(each)
            assert misses(robot, each, T) < 1e-10
            assert ((values < robot.lower) | (values > robot.upper)).any()


def test_solutions_are_sorted_by_distance_to_q0_with_turns_next_to_it(rng):
    robot = arm("ur5")
    for q0 in robot.random(rng, 20):
        found = robot.all_solutions(robot.pose(robot.random(rng)), q0)
        far = np.linalg.norm(found.q - q0, axis=1)
        assert (np.diff(far) >= -1e-12).all()
        assert (np.abs(found.q - q0) <= np.pi + 1e-9).all() or robot.lower.max() > -np.inf


def test_a_q0_that_is_far_away_costs_no_digits(rng):
    robot = dh_arms.arm("ur5", (-np.inf, np.inf))
    for q0 in (np.full(6, 1e9), np.array([1e12, 0, 0, -1e9, 0, 0])):
        T = robot.pose(robot.random(rng))
        found = robot.all_solutions(T, q0)
        assert len(found)
        assert all(misses(robot, each, T) < 1e-8 for each in found)


def test_turns_are_all_that_limits_leave(rng):
    robot = dh_arms.arm("ur5", (-2 * np.pi, 2 * np.pi))
    T = robot.pose(robot.random(rng))
    plain, turned = robot.all_solutions(T), robot.all_solutions(T, turns=True)
    assert len(turned) == 64 * len(plain)  # each joint has two values in ±2π
    assert len(np.unique(np.round(turned.q, 6), axis=0)) == len(turned)
    assert all(misses(robot, each, T) < 1e-9 for each in turned.q[::17])
    assert (np.diff(np.linalg.norm(turned.q - robot.rest, axis=1)) > -1e-9).all()
    assert ((turned.q >= robot.lower) & (turned.q <= robot.upper)).all()


# -------------------------------------------------------------------------------------------- poses without solutions
@pytest.mark.parametrize("name", ["ur5", "gp7_like", "crx_like", "jaco_like"])
def test_a_pose_out_of_reach_has_no_solution_and_that_is_shown(name, rng):
    robot = arm(name)
    for T in robot.pose(robot.random(rng, 20)):
        T[:3, 3] += 3.0 * robot.size * rotation_vector_unit(rng)
        found = robot.all_solutions(T)
        assert len(found) == len(found.beyond) == 0
        assert found.complete


def rotation_vector_unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


# ------------------------------------------------------------------------------------------------------ singular poses
def singular_configurations(robot, rng, count):
    """Configurations with a zero of det J along one joint, by bisection."""
    found = []
    while len(found) < count:
        values = robot.joint_values(robot.random(rng))
        joint = int(rng.integers(1, robot.n - 1))
        grid = np.repeat(values[None], 41, axis=0)
        grid[:, joint] = np.linspace(max(robot.lower[joint], -np.pi), min(robot.upper[joint], np.pi), 41)
        det = np.linalg.det(robot.jacobian(robot.configuration(grid)))
        changes = np.flatnonzero(det[:-1] * det[1:] < 0)
        if not len(changes):
            continue
        i = rng.choice(changes)
        low, high = grid[i, joint], grid[i + 1, joint]
        for _ in range(60):
            values[joint] = 0.5 * (low + high)
            same = np.linalg.det(robot.jacobian(robot.configuration(values))) * det[i] > 0
            low, high = (values[joint], high) if same else (low, values[joint])
        found.append(robot.configuration(values))
    return found


@pytest.mark.parametrize("name", ["ur5", "puma560", "kr16_like", "gp7_like"])
def test_no_singular_configuration_of_an_industrial_arm_is_missed(name, rng):
    robot = arm(name)
    for q in singular_configurations(robot, rng, 40):
        found = robot.all_solutions(robot.pose(q))
        assert holds(robot, found, q)
        assert found.singular.any()
        assert found.complete or name != "puma560"
        assert all(apart(robot, a, b) > 1e-3 for i, a in enumerate(found) for b in found.q[:i])


@pytest.mark.parametrize("name", ["z1", "crx_like", "jaco_like", "gen3_6_like"])
def test_singular_configurations_of_other_arms_are_found(name, rng):
    robot = arm(name)
    assert all(holds(robot, robot.all_solutions(robot.pose(q)), q) for q in singular_configurations(robot, rng, 12))


def test_a_straight_wrist_is_one_self_motion_of_joints_4_and_6():
    robot = rik.load("puma560")
    q = np.array([0.3, -0.4, 0.5, 0.7, 0.0, -0.2])
    found = robot.all_solutions(robot.pose(q))
    curve = next(each for each in found.self_motions if apart(robot, each.q, q).min() < 0.1)
    assert curve.moving == ("joint4", "joint6")
    assert_allclose(np.ptp(curve.q[:, 3] + curve.q[:, 5]), 0, atol=1e-9)
    assert max(misses(robot, each, robot.pose(q)) for each in curve.q) < 1e-9


@pytest.mark.parametrize("name", ["crx_like", "jaco_like"])
def test_poses_with_the_tool_straight_down_are_solved_although_axes_1_and_6_are_parallel_there(name, rng):
    robot, hits = arm(name), 0
    for _ in range(60):
        start = robot.pose(robot.random(rng))
        start[:3, :3] = np.diag([1.0, -1.0, -1.0])
        reached = robot.solve_pose(start)
        if reached.solved:
            found = robot.all_solutions(start)
            assert holds(robot, found, reached.q)
            hits += 1
    assert hits > 5


# ------------------------------------------------------------------------------------------------ what is said is true
def test_a_root_without_a_solution_is_told(rng):
    """The verdict is computed: with fewer solutions than roots it is not that there are no others."""
    robot = random_arm("general", 0)
    solver, lay = robot.branch_solver(), solvers.lay
    T, near = robot.pose(robot.random(rng, 10)), robot.joint_values(robot.rest)
    assert all(solver.solve(one, near).complete for one in T)
    broken = BranchSolver(**{each.name: getattr(solver, each.name) for each in fields(solver)})
    plans = solver.plans[solver.plans[:, lay.FIRST] < 5].copy()
    plans[:, lay.SPANS : lay.SPANS + 32] *= 1 + 0.1 * rng.normal(size=32)  # roots are no longer where solutions are
    broken.__dict__["plans"] = plans
    said = [broken.solve(one, near).status for one in T]
    assert said.count(SolutionsStatus.DOUBTFUL) >= 7


def test_the_status_of_a_search_is_that_there_may_be_others():
    robot = rik.load("so101")
    assert robot.branch_solver().method == "closed form"
    coupled = arm_of([("0 0 0.1", "0 0 0", "0 0 1", -3, 3)] * 9, "0.1 0 0")
    found = coupled.all_solutions(coupled.pose(np.zeros(9)))
    assert found.method == "search"
    assert not found.complete
    assert found.status is SolutionsStatus.SEARCHED


# ----------------------------------------------------------------------------------------------- any size and any rows
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_size_of_an_arm_does_not_matter(size, rng):
    robot = ur5(size)
    for q in robot.random(rng, 30):
        found = robot.all_solutions(robot.pose(q))
        assert found.complete
        assert holds(robot, found, q)


@pytest.mark.parametrize("kinds", ["RRPRRR", "PRRRRR", "RRRRRP", "PPRRRR", "RRRPRR"])
def test_slides_are_solved_for(kinds, rng):
    rows = dh_arms.random_rows(np.random.default_rng(8), "general")
    robot = dh_arms.robot_of(rows, kinds=kinds)
    assert robot.branch_solver().method in ("closed form", "elimination")
    for q in robot.random(rng, 40):
        assert holds(robot, robot.all_solutions(robot.pose(q)), q)


def test_a_gantry_with_a_wrist_has_two_solutions(rng):
    lines = [
        ("0 0 0.3", "0 0 0", "1 0 0", -0.5, 0.5, "slide"), ("0.1 0 0", "0 0 0", "0 1 0", -0.5, 0.5, "slide"),
        ("0.1 0 0", "0.1 0 0", "0 0 1", -0.5, 0.5, "slide"), ("0 0 0.1", "0 0 0", "0 0 1", -3, 3),
        ("0 0 0.1", "0 0 0", "0 1 0", -2, 2), ("0 0 0", "0 0 0", "1 0 0", -3, 3),
    ]  # fmt: skip
    robot = arm_of(lines, "0.1 0 0")
    assert robot.branch_solver().method == "closed form"
    for q in robot.random(rng, 40):
        found = robot.all_solutions(robot.pose(q))
        assert holds(robot, found, q)
        assert len(found) + len(found.beyond) == 2
        assert found.complete


@pytest.mark.parametrize(
    "rows", [("x", "y", "z", "wx", "wy"), ("x", "y", "z", "wy", "wz"), ("y", "z", "wx", "wy", "wz"), ("x", "y", "z")]
)
def test_arms_of_fewer_joints_are_solved_in_the_rows_they_have(rows, rng):
    lines = [
        ("0 0 0.1", "0 0 0", "0 0 1", -3, 3), ("0.05 0.02 0.1", "0.3 0 0", "0 1 0", -3, 3),
        ("0.3 0 0", "0 0.2 0.1", "1 0 0", -3, 3), ("0.2 0.1 0", "0 0 0", "0 1 0", -3, 3),
        ("0.1 0 0", "0.4 0 0", "0 0 1", -3, 3),
    ]  # fmt: skip
    robot = arm_of(lines[: len(rows)], "0.1 0.05 0.02").with_rows(rows)
    for q in robot.random(rng, 20):
        T = robot.pose(q)
        found = robot.all_solutions(T)
        assert found.complete
        assert holds(robot, found, q)
        if len(rows) == 5 and "wz" not in rows:  # the tool may turn about z
            turned = T.copy()
            turned[:3, :3] = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]]) @ T[:3, :3]
            assert holds(robot, robot.all_solutions(turned), q)


def test_a_scara_is_solved_with_one_rotation_wanted(rng):
    lines = [
        ("0 0 0.3", "0 0 0", "0 0 1", -3, 3), ("0.3 0 0", "0 0 0", "0 0 1", -3, 3),
        ("0.25 0 0", "0 0 0", "0 0 1", -0.2, 0.2, "slide"), ("0 0 0", "0 0 0", "0 0 1", -3, 3),
    ]  # fmt: skip
    robot = arm_of(lines, "0.05 0 0").with_rows(("x", "y", "z", "wz"))
    tilt = np.array([[1, 0, 0], [0, np.cos(0.4), -np.sin(0.4)], [0, np.sin(0.4), np.cos(0.4)]])
    for q in robot.random(rng, 20):
        T = robot.pose(q)
        assert holds(robot, robot.all_solutions(T), q)
        T[:3, :3] = tilt @ T[:3, :3]
        reached = robot.solve_pose(T)
        assert reached.solved
        assert holds(robot, robot.all_solutions(T), reached.q)


def test_joints_that_do_not_move_the_frame_stay_at_q0(rng):
    robot = rik.load("ur5")
    q0 = robot.random(rng)
    frame = "forearm_link"
    found = robot.all_solutions(robot.pose(q0, frame)[:3, 3], q0, frame=frame)
    assert len(found)
    assert (found.q[:, 3:] == q0[3:]).all()


# ------------------------------------------------------------------------------------------------------------- batches
def test_a_batch_gives_what_single_poses_give(rng):
    for robot in (arm("ur5"), arm("crx_like"), rik.load("kinova")):
        T = robot.pose(robot.random(rng, (3, 5)))
        many = robot.all_solutions_many(T)
        assert many.q.shape[:2] == many.found.shape == (3, 5)
        assert len(many) == 3
        for i in np.ndindex(3, 5):
            one = robot.all_solutions(T[i])
            assert len(one) == many.found[i]
            assert len(one.beyond) == many.beyond[i]
            assert one.complete == many.complete[i]
            assert_allclose(many.q[i][: len(one)], one.q, atol=1e-12)
            assert np.isnan(many.q[i][len(one) :]).all()


def test_an_empty_batch_is_an_empty_answer():
    found = arm("ur5").all_solutions_many(np.zeros((0, 4, 4)))
    assert found.q.shape[0] == 0
    assert found.found.shape == (0,)


# -------------------------------------------------------------------------------------------------------------- errors
@pytest.mark.parametrize(
    ("target", "said"),
    [
        (np.zeros((4, 4)), "target"),
        (np.full((4, 4), np.nan), "finite"),
        (np.eye(3), "shape"),
        (np.broadcast_to(np.eye(4), (2, 4, 4)), "all_solutions_many"),
        (np.diag([1.0, 1, -1, 1]), "target"),
        ("here", "real numbers"),
    ],
)
def test_a_target_that_is_no_pose_is_refused(target, said):
    with pytest.raises(rik.InputError, match=said):
        arm("ur5").all_solutions(target)


def test_other_arguments_are_checked():
    robot = arm("ur5")
    T = robot.pose(robot.rest)
    with pytest.raises(rik.InputError, match="turns"):
        robot.all_solutions(T, turns="yes")
    with pytest.raises(rik.InputError, match="q0"):
        robot.all_solutions(T, np.zeros((2, 6)))
    with pytest.raises(rik.FrameNotFoundError):
        robot.all_solutions(T, frame="nowhere")
    with pytest.raises(rik.InputError, match="rows"):
        robot.all_solutions(T, rows=("x", "q"))


def test_a_pose_that_is_far_away_leaves_the_others_of_a_batch_as_they_are(rng):
    robot = arm("ur5")
    T = robot.pose(robot.random(rng, 3))
    alone = robot.all_solutions_many(T)
    T = np.concatenate([T[:1], T[:1], T[1:]])
    T[1, :3, 3] = 9e8  # beyond what kernels take for this arm, within what is checked
    found = robot.all_solutions_many(T * np.ones((4, 1, 1)))
    assert found.found.tolist() == [alone.found[0], 0, *alone.found[1:]]
    assert len(robot.all_solutions(T[1])) == 0


def test_a_solver_can_be_sent_to_another_process(rng):
    robot = rik.load("ur5")
    T = robot.pose(robot.random(rng))
    solver = robot.branch_solver()
    one = solver.solve(T, robot.rest)
    other = pickle.loads(pickle.dumps(solver)).solve(T, robot.rest)
    assert_allclose(other.q, one.q, atol=1e-12)
    assert other.status is one.status
