"""Inverse kinematics of poses, against Pinocchio's forward kinematics, on many robots."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik import PoseSolver, PoseStatus
from robust_ik.control.tasks.pose_difference import error_in_rows, pose_error
from robust_ik.robot.reach import find_reach
from robust_ik.runtime.parallel import process_pool
from tests import pinocchio_reference

ARMS = ("panda", "ur5", "pa10", "xarm7")
OTHERS = ("kinova_gen3", "puma560", "ur10_limited", "srs_10r", "kinova", "z1", "talos_arm")
SHORT = ("so101", "almarkhi_4dof", "duleba_3r")
SIX = ("x", "y", "z", "wx", "wy", "wz")


@cache
def arm(name):
    return rik.load(name)


def targets(robot, rng, count, frame=None):
    return robot.pose(robot.random(rng, count), frame)


def inside(robot, q):
    values = robot.joint_values(q)
    turning = np.isinf(robot.lower)
    return bool(((values >= robot.lower) & (values <= robot.upper) | turning).all())


def misses(robot, q, T, frame=None):
    """Position and rotation errors by Pinocchio, (2,)."""
    error = pose_error(pinocchio_reference.pose(robot, q, frame or robot.tip), T)
    return np.linalg.norm(error[:3]), np.linalg.norm(error[3:])


def unreachable(robot, rng, factor, count):
    reach = find_reach(robot)
    away = rng.normal(size=(count, 3))
    T = targets(robot, rng, count)
    T[:, :3, 3] = reach.center + factor * reach.distance * away / np.linalg.norm(away, axis=1, keepdims=True)
    return T


def tree(joints):
    """A robot from lines of "name type parent child x y z axis lower upper [mimic]"."""
    links, parts = {"base"}, []
    for name, kind, parent, child, origin, axis, lower, upper, mimic in joints:
        links.add(child)
        limit = "" if kind == "continuous" else f'<limit lower="{lower}" upper="{upper}" velocity="1" effort="1"/>'
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{origin}"/><axis xyz="{axis}"/>{limit}{mimic}</joint>'
        )
    named = "".join(f'<link name="{link}"/>' for link in sorted(links))
    return f'<robot name="made">{named}{"".join(parts)}</robot>'


def made(tmp_path, joints, tip, **options):
    path = tmp_path / "made.urdf"
    path.write_text(tree(joints))
    return rik.Robot.from_urdf(path, tip=tip, **options)


# ---------------------------------------------------------------------------------------------- reachable targets
@pytest.mark.parametrize("name", ARMS)
def test_no_reachable_target_is_missed(name, rng):
    robot = arm(name)
    T, q0 = targets(robot, rng, 2000), robot.random(rng, 2000)
    found = robot.solve_poses(T, q0)
    assert found.solved.all()
    assert found.error.max() <= 1e-8
    assert inside(robot, found.q)
    assert_allclose(robot.pose(found.q), T, atol=3e-8)
    for q, wanted in zip(found.q[:20], T):
        assert max(misses(robot, q, wanted)) <= 1.1e-8
    assert (found.status == PoseStatus.SOLVED).all()
    assert (found.iterations >= found.starts).all()


@pytest.mark.parametrize("name", OTHERS)
def test_other_arms_are_inverted_too(name, rng):
    robot = arm(name)
    T = targets(robot, rng, 200)
    found = robot.solve_poses(T)
    assert found.solved.mean() >= 0.99
    assert inside(robot, found.q)
    for q, wanted, solved in zip(found.q[:40], T, found.solved):
        assert not solved or max(misses(robot, q, wanted)) <= 1.1e-8


@pytest.mark.parametrize("name", SHORT)
def test_arms_with_few_joints_reach_what_they_can(name, rng):
    robot = arm(name).with_rows(SIX)
    T = targets(robot, rng, 50)
    found = robot.solve_poses(T, robot.random(rng, 50), effort="thorough")
    assert found.solved.mean() >= 0.95
    assert inside(robot, found.q)


@pytest.mark.parametrize("name", ARMS)
def test_near_a_solution_few_steps_are_needed(name, rng):
    robot = arm(name)
    values = robot.random(rng, 500)
    q0 = np.clip(values + rng.normal(size=values.shape) * 0.05 / np.sqrt(robot.n), robot.lower, robot.upper)
    found = robot.solve_poses(robot.pose(values), q0)
    assert found.solved.all()
    assert np.median(found.iterations) <= 4
    assert np.median(np.linalg.norm(robot.difference(found.q, values), axis=1)) < 0.1


SINGULAR = [
    ("ur5", {2: 0.0}),
    ("ur5", {4: 0.0}),
    ("ur5", {2: 0.0, 4: np.pi}),
    ("pa10", {3: 0.0}),
    ("pa10", {1: 0.0, 5: 0.0}),
    ("pa10", {1: np.pi, 2: np.pi / 2}),
    ("panda", {3: -0.467002339, 4: 0.0}),
    ("panda", {1: 0.0, 2: np.pi / 2 - 1e-9, 3: -0.4670023}),
]


@pytest.mark.parametrize("name, pins", SINGULAR)
def test_exactly_singular_targets_are_reached(name, pins, rng):
    robot = arm(name)
    q = robot.random(rng, 300)
    for joint, value in pins.items():
        q[:, joint] = value
    found = robot.solve_poses(robot.pose(q), robot.random(rng, 300))
    assert found.solved.all()


def test_a_target_that_is_turned_by_half_a_turn_is_reached(rng):
    robot = arm("ur5")
    q0 = robot.random(rng)
    for axis in (*np.eye(3), np.ones(3) / np.sqrt(3)):
        T = robot.pose(q0)
        T[:3, :3] = (2 * np.outer(axis, axis) - np.eye(3)) @ T[:3, :3]
        assert robot.solve_pose(T, q0).solved


# ---------------------------------------------------------------------------------------------- the same bits
def test_one_by_one_in_batches_and_on_threads_the_bits_are_the_same(rng):
    robot = arm("panda")
    T, q0 = targets(robot, rng, 2100), robot.random(rng, 2100)
    T[::100, :3, 3] *= 3
    together = robot.solve_poses(T, q0)
    on_threads = robot.solve_poses(T, q0, threads=2)
    told = []
    with ThreadPoolExecutor(2) as executor:
        elsewhere = robot.solve_poses(T, q0, executor=executor, progress=lambda *done: told.append(done))
    for other in (on_threads, elsewhere):
        assert_array_equal(other.solutions, together.solutions)
        assert_array_equal(other.error, together.error)
    assert told == [(1, 3), (2, 3), (3, 3)]
    for i in range(0, 2100, 50):
        alone = robot.solve_pose(T[i], q0[i])
        assert_array_equal(alone.q, together.q[i])
        assert alone.error == tuple(together.error[i])
        assert (alone.iterations, alone.starts) == (together.iterations[i], together.starts[i])
        assert alone.status is together.status[i]
        assert_array_equal(alone.sigma, together.sigma[i])


def test_leading_axes_are_kept_and_broadcast(rng):
    robot = arm("ur5")
    T, q0 = targets(robot, rng, (2, 3)), robot.random(rng, (4, 1, 3))
    found = robot.solve_poses(T, q0)
    assert found.q.shape == (4, 2, 3, 6)
    assert found.error.shape == (4, 2, 3, 2)
    assert found.sigma.shape == (4, 2, 3, 6)
    assert_array_equal(found.q[3, 1, 2], robot.solve_pose(T[1, 2], q0[3, 0, 2]).q)
    assert robot.solve_poses(np.empty((0, 4, 4))).q.shape == (0, 6)


def test_a_generator_changes_random_starts_only(rng):
    robot = arm("panda")
    T = unreachable(robot, rng, 1.1, 1)[0]
    one, same = (robot.solve_pose(T, effort="thorough", rng=np.random.default_rng(1)) for _ in range(2))
    assert_array_equal(one.q, same.q)


def test_inputs_of_other_types_and_layouts_are_taken_and_not_written_to(rng):
    robot = arm("ur5")
    T = robot.pose(robot.random(rng))
    kept = T.copy()
    expected = robot.solve_pose(T).q
    assert_array_equal(robot.solve_pose(T.tolist()).q, expected)
    assert_array_equal(robot.solve_pose(np.asfortranarray(T), robot.rest.tolist()).q, expected)
    assert_array_equal(
        robot.solve_pose(np.eye(4, dtype=int), np.zeros(6, dtype=int)).q, robot.solve_pose(np.eye(4), np.zeros(6)).q
    )
    assert_array_equal(robot.solve_pose(T, position_tolerance=np.array(1e-8)).q, expected)
    assert_array_equal(T, kept)


@pytest.mark.parametrize("name", ["panda", "ur5", "planar_2r", "so101"])
def test_every_way_to_write_a_target_and_a_start_gives_the_same_bits(name, rng):
    robot = rik.load(name)
    q = robot.random(rng)
    T, start = robot.pose(q), robot.integrate(q, 0.1 * np.ones(robot.n))
    full = robot.solve_pose(T, start)
    for target in (T.tolist(), np.asfortranarray(T), T.astype(">f8"), np.repeat(T, 2, axis=1)[:, ::2]):
        for q0 in (start, start.tolist(), start.astype(">f8")):
            assert (robot.solve_pose(target, q0).q == full.q).all()
    assert (robot.pose_solver().solve(T.tolist(), start.tolist()).q == full.q).all()
    rows = tuple(row for row in robot.rows if row in ("x", "y", "z"))
    free = robot.solve_pose(T, start, rows=rows)
    for target in (T[:3, 3], T[:3, 3].tolist(), T[:3, 3].astype(np.float32).astype(float)):
        found = robot.solve_pose(target, start)
        assert found.solver.rows == rows
        np.testing.assert_allclose(found.q, free.q, atol=1e-4)
    assert (robot.solve_pose(T[:3, 3].copy(), start).q == free.q).all()


@pytest.mark.parametrize(
    "bad", [[1, 2], [[1.0, 2], [3]], ["a", "b", "c"], [np.nan, 0, 0], [1e300, 0, 0], [[1, 2, 3]] * 3]
)
def test_a_list_that_is_no_target_is_refused_in_a_sentence(bad):
    with pytest.raises(rik.InputError, match="target"):
        rik.load("panda").solve_pose(bad)


# ---------------------------------------------------------------------------------------------- partial poses
@pytest.mark.parametrize("name", ("panda", "ur5", "pa10", "so101"))
def test_a_position_leaves_rotations_free(name, rng):
    robot = arm(name)
    p = targets(robot, rng, 300)[:, :3, 3]
    found = robot.with_rows(SIX).solve_poses(p, robot.random(rng, 300))
    assert found.solved.mean() >= 0.99
    assert_allclose(robot.pose(found.q)[found.solved, :3, 3], p[found.solved], atol=1.1e-8)
    assert inside(robot, found.q)
    assert found.sigma.shape[-1] == 3


@pytest.mark.parametrize(
    "rows", [("x", "y", "z", "wx", "wy"), ("x", "z", "wy", "wz"), ("wx", "wy", "wz"), ("z", "wx", "wz"), ("x", "y")]
)
@pytest.mark.parametrize("name", ("panda", "ur5"))
def test_partial_poses_leave_the_other_rows_free(name, rows, rng):
    robot = arm(name)
    T = targets(robot, rng, 100)
    found = robot.solve_poses(T, robot.random(rng, 100), rows=rows)
    assert found.solved.all()
    for q, wanted in zip(found.q, T):
        assert np.abs(error_in_rows(robot.pose(q), wanted, rows)).max() < 2e-8


def test_one_rotation_is_that_component_of_the_rotation_vector(rng):
    robot = arm("panda")
    rows = ("x", "y", "z", "wy")
    T = targets(robot, rng, 200)
    found = robot.solve_poses(T, robot.random(rng, 200), rows=rows)
    assert found.solved.mean() >= 0.99
    for q, wanted in zip(found.q[found.solved], T[found.solved]):
        assert np.abs(error_in_rows(robot.pose(q), wanted, rows)).max() < 2e-8


def test_planar_arms_are_inverted_in_their_rows(rng):
    robot = arm("planar_3r")
    T = targets(robot, rng, 200)
    found = robot.solve_poses(T, robot.random(rng, 200))
    assert found.solved.all()


# ---------------------------------------------------------------------------------------------- preferences
def least_margin(robot, q):
    return np.minimum(q - robot.lower, robot.upper - q).min(axis=-1)


@pytest.mark.parametrize("name", ("panda", "ur10_limited"))
def test_preferences_prefer(name, rng):
    robot = arm(name)
    T, q0 = targets(robot, rng, 200), robot.random(rng, 200)
    kinds = ("nearest", "any", "limits", "singularity")
    found = {kind: robot.solve_poses(T, q0, prefer=kind) for kind in kinds}
    assert all(each.solved.all() and inside(robot, each.q) for each in found.values())
    distance = {kind: np.linalg.norm(each.q - q0, axis=1).mean() for kind, each in found.items()}
    thorough = robot.solve_poses(T, q0, effort="thorough")
    assert distance["nearest"] < distance["any"]
    assert np.linalg.norm(thorough.q - q0, axis=1).mean() < 0.9 * distance["nearest"]
    assert least_margin(robot, found["limits"].q).mean() > 1.5 * least_margin(robot, found["any"].q).mean()
    assert found["singularity"].sigma[:, -1].mean() > 1.1 * found["any"].sigma[:, -1].mean()


def test_full_turns_are_taken_towards_q0(rng):
    robot = arm("ur5")
    q = robot.random(rng, 100)
    found = robot.solve_poses(robot.pose(q), robot.random(rng, 100) / 10 + 4.0 * (robot.upper > 4))
    turning = robot.upper > 4
    shifted = found.q[:, turning, None] + 2 * np.pi * np.array([-1, 1])
    allowed = (shifted >= robot.lower[turning, None]) & (shifted <= robot.upper[turning, None])
    q0 = np.clip(0, robot.lower, robot.upper)
    assert found.solved.all()
    assert allowed.any()
    again = robot.solve_poses(robot.pose(q), q0)
    assert np.abs(again.q[:, turning]).max() <= np.pi + 1e-12


# ---------------------------------------------------------------------------------------------- several solutions
def test_a_six_joint_arm_has_eight_distinct_solutions(rng):
    robot = arm("ur5")
    T = targets(robot, rng, 40)
    found = robot.solve_poses(T, solutions=8)
    assert found.solutions.shape == (40, 8, 6)
    assert np.median(found.found) == 8
    for solutions, count, wanted in zip(found.solutions, found.found, T):
        assert np.isnan(solutions[count:]).all()
        assert_allclose(robot.pose(solutions[:count]), np.broadcast_to(wanted, (count, 4, 4)), atol=3e-8)
        assert inside(robot, solutions[:count])
        gaps = solutions[:count, None] - solutions[None, :count]
        turned = np.abs(np.arctan2(np.sin(gaps), np.cos(gaps))).max(axis=-1)
        assert turned[~np.eye(count, dtype=bool)].min(initial=1) >= 0.1
        distances = np.linalg.norm(solutions[:count] - robot.rest, axis=1)
        assert (np.diff(distances) >= 0).all()


def test_solutions_of_redundant_arms_are_apart_by_what_was_asked(rng):
    robot = arm("panda")
    T = robot.pose(robot.rest)
    found = robot.solve_pose(T, solutions=12, apart=0.4)
    assert len(found.solutions) == 12
    gaps = np.abs(found.solutions[:, None] - found.solutions[None]).max(axis=-1)
    assert gaps[~np.eye(12, dtype=bool)].min() >= 0.4
    assert_allclose(robot.pose(found.solutions), np.broadcast_to(T, (12, 4, 4)), atol=3e-8)
    assert_array_equal(found.q, found.solutions[0])


# ---------------------------------------------------------------------------------------------- unreachable targets
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_targets_out_of_reach_are_said_to_be_and_the_closest_is_found(name, rng):
    robot = arm(name)
    for factor, effort, most in ((2.0, "normal", 1.02), (1.1, "thorough", 1.01)):
        T = unreachable(robot, rng, factor, 40)
        found = robot.solve_poses(T, robot.random(rng, 40), effort=effort)
        best = np.linalg.norm(found.error, axis=1)
        for seed in range(2):
            more = robot.solve_poses(T, robot.random(rng, 40), effort="thorough", rng=np.random.default_rng(seed))
            best = np.minimum(best, np.linalg.norm(more.error, axis=1))
        ratio = np.linalg.norm(found.error, axis=1) / best
        assert np.median(ratio) <= 1.001
        assert np.quantile(ratio, 0.9) <= most
        assert (found.status == PoseStatus.OUT_OF_REACH).all()
        assert inside(robot, found.q)
        for q, wanted, error in zip(found.q[:5], T, found.error):
            assert_allclose(misses(robot, q, wanted), error, atol=1e-9)


def test_the_closest_pose_is_a_minimum_within_limits(rng):
    robot = arm("panda")
    for scale in (0.2, 1.0):
        T = unreachable(robot, rng, 1.2, 1)[0]
        found = robot.solve_pose(T, length_scale=scale)
        error = pose_error(robot.pose(found.q), T) * np.repeat([1, scale], 3)
        slope = robot.jacobian(found.q).T @ (error * np.repeat([1, scale], 3))
        free = (found.q > robot.lower) & (found.q < robot.upper)
        assert np.abs(slope[free]).max() < 1e-5
        assert (slope[found.q == robot.lower] <= 0).all()
        assert (slope[found.q == robot.upper] >= 0).all()


def test_what_cannot_be_reached_inside_the_span_is_the_closest(rng):
    robot = arm("panda")
    T = robot.pose(robot.rest)
    T[:3, 3] = [0.0, 0.0, 0.25]
    found = robot.solve_pose(T)
    assert found.status is PoseStatus.CLOSEST
    assert not found.solved
    with pytest.raises(rik.NotReachedError, match="closest configuration.*misses by"):
        found.raise_for_status()
    assert robot.solve_pose(robot.pose(robot.rest)).raise_for_status().solved
    with pytest.raises(rik.NotReachedError, match="1 of 2 targets"):
        robot.solve_poses(np.stack([T, robot.pose(robot.rest)])).raise_for_status()


@pytest.mark.parametrize("rows", [SIX, ("x", "y", "z"), ("x", "y", "z", "wx", "wy"), ("x", "z")])
def test_the_span_is_never_passed(rows, rng):
    for name in (*ARMS, *OTHERS, *SHORT, "tiago"):
        robot = arm(name)
        T = targets(robot, rng, 300)
        problem = robot.pose_solver(rows=rows).problem
        bound, centre, carried = problem[12], problem[13:16], problem[16:19]
        points = T[:, :3, :3] @ carried + T[:, :3, 3]
        assert np.linalg.norm(points - centre, axis=1).max() <= bound * (1 + 1e-12)


# ---------------------------------------------------------------------------------------------- kinds of joints
def test_continuous_joints_are_cosines_and_sines(rng):
    robot = arm("kinova")
    assert robot.nq > robot.n
    T, q0 = targets(robot, rng, 100), robot.random(rng, 100)
    found = robot.solve_poses(T, q0)
    assert found.solved.all()
    robot.joint_values(found.q)
    assert_array_equal(robot.solve_pose(T[0], q0[0]).q, found.q[0])


def test_joints_that_slide_and_joints_that_follow_are_moved(tmp_path, rng):
    follows = '<mimic joint="a" multiplier="-0.5" offset="0.2"/>'
    joints = [
        ("s", "prismatic", "base", "0", "0 0 0.1", "0 0 1", -0.5, 0.5, ""),
        ("a", "revolute", "0", "1", "0 0 0.3", "0 1 0", -2, 2, ""),
        ("b", "revolute", "1", "2", "0 0 0.4", "0 1 0", -2, 2, follows),
        ("c", "continuous", "2", "3", "0 0 0.1", "0 0 1", 0, 0, ""),
        ("d", "revolute", "3", "4", "0 0.1 0.3", "1 0 0", -2, 2, ""),
        ("e", "prismatic", "4", "5", "0 0 0.1", "0 0 1", 0, 0.3, ""),
        ("f", "revolute", "5", "6", "0 0 0.1", "0 1 0", -2, 2, ""),
    ]
    robot = made(tmp_path, joints, "6")
    T, q0 = targets(robot, rng, 200), robot.random(rng, 200)
    found = robot.solve_poses(T, q0)
    assert robot.n == 6
    assert found.solved.mean() >= 0.99
    assert inside(robot, found.q)
    for q, wanted, solved in zip(found.q[:30], T, found.solved):
        assert not solved or max(misses(robot, q, wanted)) <= 1.1e-8
    far = np.eye(4)
    far[:3, 3] = 5.0
    assert robot.solve_pose(far).status is PoseStatus.OUT_OF_REACH


def test_a_slide_without_limits_has_no_bound(tmp_path):
    robot = made(tmp_path, [("s", "prismatic", "base", "1", "0 0 0", "0 0 1", -9, 9, "")], "1")
    robot = replace(robot, lower=np.array([-np.inf]), upper=np.array([np.inf]))
    found = robot.solve_pose([0, 0, 1000.0])
    assert found.solved
    assert_allclose(found.q, [1000], atol=1e-7)
    beside = robot.solve_pose([1.0, 0, 3])
    assert beside.status is PoseStatus.CLOSEST
    assert_allclose((*beside.q, *beside.error), (3, 1, 0), atol=1e-8)


def test_one_joint_goes_to_the_closest_angle(tmp_path):
    joint = ("a", "revolute", "base", "1", "0 0 0", "0 0 1", -1, 1, "")
    robot = made(tmp_path, [joint, ("t", "fixed", "1", "2", "1 0 0", "0 0 1", 0, 0, "")], "2")
    assert_allclose(robot.solve_pose([np.cos(0.5), np.sin(0.5), 0]).q, [0.5], atol=1e-8)
    found = robot.solve_pose([0, 2.0, 0])
    assert_allclose(found.q, [1], atol=0)
    assert found.status is PoseStatus.OUT_OF_REACH
    assert robot.solve_pose(robot.pose([0.7])).solved


def test_joints_that_do_not_move_the_frame_stay(rng):
    robot = rik.load("baxter", tip="left_gripper", whole_tree=True)
    q0 = robot.random(rng)
    T = robot.pose(robot.random(rng))
    found = robot.solve_pose(T, q0)
    moved = np.flatnonzero(robot.jacobian(q0).any(axis=0))
    still = np.setdiff1d(np.arange(robot.n), moved)
    assert found.solved
    assert_array_equal(robot.joint_values(found.q)[still], robot.joint_values(q0)[still])
    assert robot.solve_pose(robot.pose(q0, "right_gripper"), frame="right_gripper").solved


def test_q0_outside_its_limits_is_moved_inside(rng):
    robot = arm("panda")
    found = robot.solve_pose(robot.pose(robot.rest), robot.upper + 1.0)
    assert found.solved
    assert inside(robot, found.q)


def test_angles_of_many_turns_are_kept_where_there_are_no_limits(rng):
    robot = arm("pa10")
    q = robot.random(rng) + 2 * np.pi * 40
    found = robot.solve_pose(robot.pose(q), q + 0.01)
    assert found.solved
    assert np.abs(found.q - q).max() < 0.5


# ---------------------------------------------------------------------------------------------- bad inputs
def test_targets_that_cannot_be_meant_are_refused():
    robot = arm("ur5")
    skewed, flipped, far = np.eye(4), np.diag([1.0, 1, -1, 1]), np.eye(4)
    skewed[0, 1], far[0, 3] = 0.1, 1e12
    broken = np.full((4, 4), np.nan)
    for solve in (robot.solve_pose, lambda T: robot.solve_poses(np.asarray(T)[None])):
        for target, words in ((skewed, "rigid"), (flipped, "rigid"), (broken, "finite"), (far, "within")):
            with pytest.raises(rik.InputError, match=words):
                solve(target)
    with pytest.raises(rik.InputError, match="pose.*position"):
        robot.solve_pose(np.eye(3))
    with pytest.raises(rik.InputError, match="solve_poses takes many"):
        robot.solve_pose(np.tile(np.eye(4), (2, 1, 1)))
    with pytest.raises(rik.InputError, match="real numbers"):
        robot.solve_pose("there")


def test_configurations_that_cannot_be_meant_are_refused():
    robot = arm("ur5")
    for q0, words in ((np.full(6, np.nan), "finite"), (np.zeros(5), "shape"), (np.zeros((2, 6)), "one configuration")):
        with pytest.raises(rik.InputError, match=words):
            robot.solve_pose(np.eye(4), q0)
    with pytest.raises(rik.InputError, match="cosine and sine"):
        arm("kinova").solve_pose(np.eye(4), np.zeros(arm("kinova").nq))
    with pytest.raises(rik.InputError, match="broadcast"):
        robot.solve_poses(np.tile(np.eye(4), (2, 1, 1)), np.zeros((3, 6)))


def test_options_that_cannot_be_meant_are_refused():
    robot, T = arm("ur5"), np.eye(4)
    for options, words in (
        ({"prefer": "best"}, "nearest, any, limits, singularity, got 'best'"),
        ({"prefer": ["any"]}, "nearest, any"),
        ({"effort": "some"}, "normal, thorough, got 'some'"),
        ({"effort": np.array(["normal", "some"])}, "normal, thorough, got array"),
        ({"solutions": 0}, "1 to 64, got 0"),
        ({"solutions": 2.0}, "1 to 64, got 2.0"),
        ({"position_tolerance": 0}, "position_tolerance"),
        ({"rotation_tolerance": np.nan}, "rotation_tolerance"),
        ({"length_scale": -1}, "length_scale"),
        ({"apart": 0}, "apart"),
        ({"rows": ("x", "q")}, "rows"),
        ({"rows": 5}, "rows"),
    ):
        with pytest.raises(rik.InputError, match=words):
            robot.solve_pose(T, **options)
    with pytest.raises(rik.InputError, match="rows of a position"):
        robot.solve_pose([0, 0, 1.0], rows=("x", "wx"))
    with pytest.raises(rik.InputError, match="target must be an array of real numbers"):
        robot.solve_pose([[1], [2, 3]])
    with pytest.raises(rik.InputError, match="threads"):
        robot.solve_poses(T[None], threads=0)
    with pytest.raises(rik.FrameNotFoundError, match="there"):
        robot.solve_pose(T, frame="there")
    with pytest.raises(TypeError):
        robot.solve_pose(T, tolerance=1)


def test_reversed_limits_and_long_chains_are_refused(tmp_path):
    robot = arm("ur5")
    with pytest.raises(rik.InputError, match="at most the upper"):
        replace(robot, lower=robot.upper, upper=robot.lower).solve_pose(np.eye(4))
    joints = [
        (f"j{i}", "revolute", str(i - 1) if i else "base", str(i), "0 0 1", "0 1 0", -1, 1, "") for i in range(17)
    ]
    with pytest.raises(rik.InputError, match="16 independent joints"):
        made(tmp_path, joints, "16").solve_pose(np.eye(4))


def test_results_and_solvers_can_be_sent_elsewhere(rng):
    robot = arm("ur5")
    T = targets(robot, rng, 2)
    found, many = robot.solve_pose(T[0]), robot.solve_poses(T)
    again = pickle.loads(pickle.dumps(found))
    assert_array_equal(again.q, found.q)
    assert again.status is PoseStatus.SOLVED
    assert_allclose(again.sigma, found.sigma)
    assert_array_equal(pickle.loads(pickle.dumps(many)).q, many.q)
    solver = pickle.loads(pickle.dumps(robot.pose_solver()))
    assert_array_equal(solver.solve(T[1]).q, many.q[1])
    assert "SOLVED" in repr(found)
    assert "2 of 2" in repr(many)
    with pytest.raises(AttributeError):
        found.solutions = None


def test_processes_give_the_same_bits(rng):
    robot = rik.load("ur5")
    T = robot.pose(robot.random(rng, 1500))
    with process_pool(2) as executor:
        elsewhere = robot.solve_poses(T, executor=executor)
    here = robot.solve_poses(T)
    assert (elsewhere.q == here.q).all()
    assert (elsewhere.starts == here.starts).all()


@pytest.mark.parametrize("rng", [3, "a", np.random.RandomState(0)])
def test_what_is_no_generator_is_refused(rng):
    robot = rik.load("ur5")
    with pytest.raises(rik.InputError, match="rng must be"):
        robot.solve_pose(robot.pose(robot.rest), rng=rng)


def test_options_are_checked_whatever_was_asked_before():
    robot = rik.load("ur5")
    T = robot.pose(robot.rest)
    robot.solve_pose(T, solutions=1)
    with pytest.raises(rik.InputError, match="solutions"):
        robot.solve_pose(T, solutions=True)


def test_a_solver_with_other_limits_is_another_solver(rng):
    robot = arm("panda")
    solver = PoseSolver(robot.chain(), robot.lower, robot.upper, robot.rest, robot.rows)
    q, q0 = robot.random(rng), robot.random(rng)
    T = robot.pose(q)
    solver.solve(T, q0)
    lower = robot.lower.copy()
    lower[3] = -0.6
    for other in (
        replace(solver, lower=lower),
        replace(solver, rows=("x", "y", "z")),
        replace(solver, upper=lower + 1),
    ):
        fresh = PoseSolver(other.chain, other.lower, other.upper, other.rest, other.rows)
        assert_array_equal(other.solve(T, q0).q, fresh.solve(T, q0).q)
        assert_array_equal(other.solve(T, q0).q, other.quickly(T, q0).q)
    assert_array_equal(solver.solve(T, q0).q, robot.solve_pose(T, q0).q)


@pytest.mark.parametrize("name", ("ur5", "panda", "kinova"))
def test_what_is_said_to_be_solved_is_however_far_away_q0_is(name, rng):
    robot = arm(name)
    T = targets(robot, rng, 40)
    for size in (1e3, 1e6, 1e9):
        q0 = robot.configuration(rng.uniform(-size, size, (len(T), robot.n)))
        found = robot.solve_poses(T, q0=q0)
        for q, target, solved in zip(found.q, T, found.solved):
            assert inside(robot, q)
            assert not solved or max(misses(robot, q, target)) < 1.01e-8


def test_near_the_boundary_solutions_are_found_and_the_closest_is_closest(rng):
    # Poses at stretched arms, moved in or out a little.
    overs = []
    for name, pins in (("panda", {3: -0.4670023, 4: 0.0}), ("talos_arm", {3: -0.001}), ("pa10", {3: 0.0})):
        robot = arm(name)
        q = robot.random(rng, 60)
        for joint, value in pins.items():
            q[:, joint] = value
        T = robot.pose(q)
        T[:, :3, 3] += rng.choice([0.0, 1e-9, 1e-6, 1e-4], (60, 1)) * rng.normal(size=(60, 3))
        found = robot.solve_poses(T, q0=robot.random(rng, 60))
        again = robot.solve_poses(T, q0=q, effort="thorough")
        E, best = ((each.error**2).sum(axis=-1) for each in (found, again))
        assert (found.solved | ~again.solved).all()
        overs.append(E[~again.solved] / best[~again.solved])
    over = np.concatenate(overs)
    assert len(over) > 5
    assert np.median(over) < 1.01
    assert (over < 10).mean() > 0.9


def test_the_angle_of_a_rotation_is_right_from_nothing_to_half_a_turn(rng):
    robot = arm("panda")
    q0 = robot.random(rng)
    for theta in (*np.geomspace(1e-9, 3.1, 60), *np.linspace(0.031, 0.0323, 40), np.pi - 1e-9):
        axis = rng.normal(size=3)
        T = robot.pose(q0)
        T[:3, :3] = pin.exp3(theta * axis / np.linalg.norm(axis)) @ T[:3, :3]
        loose = {"position_tolerance": 1.0, "rotation_tolerance": 10.0}  # so that q0 is taken as it is
        one, many = robot.solve_pose(T, q0, **loose), robot.solve_poses(T[None], q0, **loose)
        assert_array_equal(one.q, q0)
        assert_allclose(one.error, (0.0, theta), rtol=1e-12, atol=3e-15)
        assert_array_equal(one.error, many.error[0])
