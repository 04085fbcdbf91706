"""Motions along paths: they are continuous, on the path, within limits; where none is found none is there."""

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.kinematics.rotation_vectors import rotations
from robust_ik.paths import Hindrance, furthest_motion
from robust_ik.paths.path_error import path_error, path_twist
from tests import dh_arms, pinocchio_reference
from tests.arms import arm_of
from tests.branches.test_all_solutions import apart, arm

ARMS = ("ur5", "ur10", "puma560", "kr16_like", "crx_like", "gp7_like", "z1")


def off(robot, poses, s, values, frame=None):
    """How far the frame is from the path at places, m and rad, by Pinocchio and a slerp of the test's own."""
    found = []
    for place, one in zip(s, values):
        i = min(int(place), len(poses) - 2)
        part = place - i
        A, B = poses[i], poses[i + 1]
        M = pinocchio_reference.pose(robot, robot.configuration(one), frame or robot.tip)
        w, V = np.linalg.eig(B[:3, :3] @ A[:3, :3].T)
        axis = np.real(V[:, np.argmin(abs(w - 1))])
        D = B[:3, :3] @ A[:3, :3].T
        angle = np.arccos(np.clip((np.trace(D) - 1) / 2, -1, 1))
        K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        turns = [np.eye(3) + np.sin(x) * K + (1 - np.cos(x)) * K @ K for x in (angle, -angle)]
        sign = 1 if np.abs(turns[0] - D).max() < np.abs(turns[1] - D).max() else -1
        x = sign * part * angle
        R = (np.eye(3) + np.sin(x) * K + (1 - np.cos(x)) * K @ K) @ A[:3, :3]
        E = M[:3, :3] @ R.T
        sine = np.linalg.norm(E - E.T) / np.sqrt(8)
        turn = np.arctan2(sine, (np.trace(E) - 1) / 2)
        found.append((np.linalg.norm(M[:3, 3] - (1 - part) * A[:3, 3] - part * B[:3, 3]), turn))
    return np.array(found)


def holds_what_it_says(robot, poses, plan, accuracy):
    """Each piece, between its configurations as well: on the path, within limits, joints without jumps."""
    for piece in plan.pieces:
        assert (np.diff(piece.s) > 0).all()
        assert ((piece.values >= robot.lower) & (piece.values <= robot.upper)).all()
        assert np.abs(robot.configuration(piece.values) - piece.q).max() < 1e-12
        assert np.abs(np.diff(piece.values, axis=0)).max(initial=0) < 0.36
        s = np.interp(np.linspace(0, 1, 10 * len(piece.s) + 1), np.linspace(0, 1, len(piece.s)), piece.s)
        s = s[:: max(1, len(s) // 300)]
        assert off(robot, poses, s, [piece.at(x) for x in s]).max() < 1.1 * accuracy


def wandering(robot, rng, size, count):
    """Joint values that wander smoothly within limits, (count, n)."""
    low, high = np.clip(robot.lower, -2.5, None), np.clip(robot.upper, None, 2.5)
    middle = low + (high - low) * rng.uniform(0.3, 0.7, robot.n)
    x = np.linspace(0, 1, count)[:, None]
    swing = np.minimum(size, 0.3 * (high - low))
    return middle + swing * np.sin(2 * np.pi * (x * rng.uniform(0.2, 0.8, robot.n) + rng.random(robot.n)))


# ------------------------------------------------------------------------------------------------ what can be followed
@pytest.mark.parametrize("name", ARMS)
def test_a_path_that_an_arm_has_moved_along_is_followed(name, rng):
    robot = arm(name)
    for _ in range(3):
        values = wandering(robot, rng, 1.2, 400)  # so many that lines between poses leave the way by 0.1 mm
        poses = robot.pose(robot.configuration(values))
        plan = robot.plan_path(poses, accuracy=1e-3)
        assert plan.followed, plan.reasons
        assert plan.s[0] == 0
        assert plan.s[-1] == 399
        holds_what_it_says(robot, poses, plan, 1e-3)
        assert plan.pieces[0].travel < np.linalg.norm(np.diff(values, axis=0), axis=1).sum() * 1.01


@pytest.mark.parametrize("name", ["panda", "xarm7", "srs_7r"])
def test_an_arm_with_a_joint_more_follows_a_path_that_it_has_moved_along(name, rng):
    robot = rik.load(name)
    values = wandering(robot, rng, 0.8, 30)
    poses = robot.pose(robot.configuration(values))
    plan = robot.plan_path(poses, accuracy=2e-3)
    assert plan.followed, plan.reasons
    assert not plan.complete.any()
    holds_what_it_says(robot, poses, plan, 2e-3)


@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-5, 1e-3])
def test_a_path_through_a_straight_wrist_is_followed(bend):
    """Joint 5 goes through zero, or just not, while the wrist could as well turn by half a turn there."""
    robot = rik.load("puma560")
    x = np.linspace(-1, 1, 41)[:, None]
    values = np.array([0.3, -0.5, 0.6, 0.2, bend, -0.1]) + x * np.array([0.2, 0.1, 0.1, 0.1, 0.5, 0.2])
    poses = robot.pose(values)
    plan = robot.plan_path(poses)
    assert plan.followed, plan.reasons
    assert plan.pieces[0].travel < 2.5
    holds_what_it_says(robot, poses, plan, 1e-4)


def test_a_wrist_that_just_misses_its_singularity_turns_fast_or_passes_within_the_accuracy():
    """The tool tips past zero of joint 5, 4 mrad aside: exactly, joints 4 and 6 turn by nearly half a turn there."""
    robot = rik.load("puma560")
    middle = np.array([0.3, -0.5, 0.6, 0.2, 0.0, -0.1])
    values = middle + np.linspace(0.4, -0.4, 41)[:, None] * np.eye(6)[4]
    aside = 0.004 * rik.svd(robot.jacobian(middle)).U[:, -1]
    poses = robot.pose(values)
    poses[:, :3, 3] += aside[:3]
    poses[:, :3, :3] = rotations(aside[3:]) @ poses[:, :3, :3]
    start = robot.all_solutions(poses[0], values[0])[0]  # with the elbow the other way the wrist is not straight at all
    exact, eased = robot.plan_path(poses, start=start), robot.plan_path(poses, start=start, accuracy=0.01)
    assert exact.followed, exact.reasons
    assert eased.followed, eased.reasons
    holds_what_it_says(robot, poses, exact, 1e-4)
    holds_what_it_says(robot, poses, eased, 0.01)
    assert exact.pieces[0].travel > 3
    assert eased.pieces[0].travel < 1.2
    assert robot.plan_path(poses).pieces[0].travel < 1.2


def test_full_turns_are_counted():
    """The last joint goes on for two turns where limits allow it, and where they do not the path ends at the limit."""
    robot = dh_arms.arm("ur5", (-2 * np.pi, 2 * np.pi))
    q = np.array([0.3, -1.2, 1.1, -0.4, 1.2, 0.0])
    values = q + np.linspace(-2 * np.pi, 2 * np.pi, 80)[:, None] * np.eye(6)[5] * 0.99
    plan = robot.plan_path(robot.pose(values))
    assert plan.followed, plan.reasons
    assert np.ptp(plan.pieces[0].values[:, 5]) == pytest.approx(0.99 * 4 * np.pi, abs=1e-3)
    narrow = dh_arms.arm("ur5", (-np.pi, np.pi))
    ends = narrow.plan_path(narrow.pose(values))
    assert not ends.followed
    assert {stop.hindrance for stop in ends.stops} == {Hindrance.LIMIT}
    assert len(ends.pieces) in (2, 3)
    holds_what_it_says(narrow, narrow.pose(values), ends, 1e-4)


def test_limits_of_many_turns_leave_starts_that_can_be_tried(rng):
    """Twenty turns of each of six joints would be 64 million starts of each solution."""
    robot = dh_arms.arm("ur5", (-60.0, 70.0))
    values = wandering(robot, rng, 1.0, 30)
    for q0 in (np.zeros(6), np.full(6, -60.0), np.full(6, 70.0)):
        assert robot.plan_path(robot.pose(values), q0).followed


# --------------------------------------------------------------------------------------------- what cannot be followed
@pytest.mark.parametrize("name", ["ur5", "puma560", "crx_like"])
def test_a_path_out_of_reach_is_followed_up_to_its_end(name, rng):
    robot = arm(name)
    T = robot.pose(robot.random(rng))
    far = T.copy()
    far[:3, 3] += 3 * robot.size * T[:3, 3] / np.linalg.norm(T[:3, 3])
    plan = robot.plan_path([T, far])
    assert not plan.followed
    assert plan.stops[-1].hindrance is Hindrance.OUT_OF_REACH
    assert plan.stops[-1].until == 1.0
    assert len(plan.pieces)
    holds_what_it_says(robot, np.array([T, far]), plan, 1e-4)
    end = plan.pieces[-1].s[-1]
    for s in np.linspace(end + 1e-3, 1, 20):
        M = T.copy()
        M[:3, 3] = (1 - s) * T[:3, 3] + s * far[:3, 3]
        assert not len(robot.all_solutions(M))


def test_pieces_are_as_few_as_a_search_on_a_grid_finds(rng):
    """Branches on a fine grid, joined where they are near: the arm changes its posture no more often than it must."""
    robot, seen = dh_arms.arm("kr16_like", (-2.6, 2.6)), set()
    for _ in range(12):
        poses = np.array([robot.pose(robot.random(rng)), robot.pose(robot.random(rng))])
        D = poses[1][:3, :3] @ poses[0][:3, :3].T
        if np.trace(D) < -0.5:
            continue
        plan = robot.plan_path(poses)
        holds_what_it_says(robot, poses, plan, 1e-4)
        pieces = fewest_pieces(robot, poses, 2500)
        if plan.followed:
            assert pieces <= 1
        else:
            assert pieces != 1
        seen.add(plan.followed)
    assert seen == {True, False}


def fewest_pieces(robot, poses, count):
    """Motions that cover a path on a grid, by the furthest one each time; 0 where a pose has no solution."""
    from robust_ik.paths import PosePath

    path = PosePath(poses, 1.0, True)
    many = robot.all_solutions_many(path.at(np.linspace(0, len(poses) - 1, count)))
    if (many.found == 0).any():
        return 0
    alive, pieces = np.ones(many.found[0], dtype=bool), 1
    for i in range(count - 1):
        here, there = many.q[i][: many.found[i]][alive], many.q[i + 1][: many.found[i + 1]]
        near = np.abs(here[:, None] - there).max(axis=-1) < 0.2
        alive = near.any(axis=0)
        if not alive.any():
            alive, pieces = np.ones(len(there), dtype=bool), pieces + 1
    return pieces


def test_a_piece_begins_where_the_path_is_reached_again():
    robot = rik.load("planar_2r")
    reach = robot.pose([0.0, 0.0])[0, 3]
    plan = robot.plan_path(np.array([[0.6, 0, 0], [1.1, 0, 0], [0.6, 0, 0]]) * reach, rows=("x", "y"))
    assert [piece.s[0] for piece in plan.pieces] == pytest.approx([0.0, 1.2], abs=1e-3)
    assert [piece.s[-1] for piece in plan.pieces] == pytest.approx([0.8, 2.0], abs=1e-3)
    assert plan.stops[0].until == plan.pieces[1].s[0]


def test_the_joint_at_its_limit_is_named():
    robot = dh_arms.arm("kr16_like", (-2.0, 2.0))
    values = np.array([0.2, -0.6, 0.8, 0.3, 0.7, 0.0]) + np.linspace(1.0, 2.5, 40)[:, None] * np.eye(6)[0]
    wide = dh_arms.arm("kr16_like", (-3.0, 3.0))
    plan = robot.plan_path(wide.pose(values), start=values[0])
    assert not plan.followed
    assert plan.pieces[0].values[-1, 0] == pytest.approx(2.0, abs=1e-3)
    assert robot.joint_names[0] in plan.stops[0].joints
    assert wide.plan_path(wide.pose(values), start=values[0]).followed


def test_a_start_on_a_branch_that_ends_is_told_and_another_goes_on():
    """An elbow that is up meets the one that is down where the arm is straight; the path turns back before."""
    robot = rik.load("planar_2r")
    reach = robot.pose([0.0, 0.0])[0, 3]
    xs = np.concatenate([np.linspace(0.6, 1.02, 30), np.linspace(1.02, 0.6, 30)[1:]]) * reach
    plan = robot.plan_path(np.stack([xs, 0 * xs, 0 * xs], axis=1), rows=("x", "y"))
    assert not plan.followed
    assert len(plan.pieces) == 2
    stop = plan.stops[0]
    assert stop.hindrance is Hindrance.OUT_OF_REACH
    assert stop.at < 29 < stop.until
    assert "20" in stop.said or "mm" in stop.said


# --------------------------------------------------------------------------------------------------- rows and frames
def test_positions_and_other_rows_are_followed(rng):
    robot = rik.load("duleba_3r")
    values = wandering(robot, rng, 0.8, 30)
    points = robot.pose(values)[:, :3, 3]
    plan = robot.plan_path(points)
    assert plan.followed, plan.reasons
    at = np.array([robot.pose(each)[:3, 3] for each in plan.q[np.isin(plan.s, np.arange(30))]])
    assert np.abs(at - points).max() < 1e-4 * robot.length_scale

    lines = [
        ("0 0 0.3", "0 0 0", "0 0 1", -3, 3), ("0.3 0 0", "0 0 0", "0 0 1", -3, 3),
        ("0.25 0 0", "0 0 0", "0 0 1", -0.2, 0.2, "slide"), ("0 0 0", "0 0 0", "0 0 1", -3, 3),
    ]  # fmt: skip
    scara = arm_of(lines, "0.05 0 0").with_rows(("x", "y", "z", "wz"))
    values = wandering(scara, rng, 0.8, 30)
    assert scara.plan_path(scara.pose(values)).followed


def test_a_frame_in_the_middle_is_led_and_joints_behind_it_stay(rng):
    robot = rik.load("ur5")
    values = wandering(robot, rng, 0.5, 20)
    frame = "wrist_1_link"
    plan = robot.plan_path(robot.pose(values, frame)[:, :3, 3], values[0], frame=frame)
    assert plan.followed, plan.reasons
    assert np.ptp(plan.q[:, 4:], axis=0).max() == 0


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_the_size_of_an_arm_does_not_matter(size, rng):
    from tests.arms import ur5

    robot = ur5(size)
    poses = robot.pose(wandering(robot, rng, 0.8, 20))
    plan = robot.plan_path(poses)
    assert plan.followed, plan.reasons


# --------------------------------------------------------------------------------------------------------- the result
def test_the_same_path_has_the_same_plan(rng):
    robot = arm("ur5")
    poses = robot.pose(wandering(robot, rng, 1.0, 20))
    one, other = robot.plan_path(poses), robot.plan_path(poses)
    np.testing.assert_array_equal(one.q, other.q)


def test_a_start_is_kept_and_a_single_pose_is_a_path(rng):
    robot = arm("ur5")
    values = wandering(robot, rng, 0.8, 20)
    poses = robot.pose(values)
    for each in robot.all_solutions(poses[0]):
        plan = robot.plan_path(poses, start=each)
        assert not plan.pieces or np.abs(plan.q[0] - each).max() < 1e-12
    one = robot.plan_path(poses[:1], values[0])
    assert one.followed
    assert len(one.q) == 1
    assert apart(robot, one.q[0], values[0]) < 1e-6
    nowhere = poses[:1].copy()
    nowhere[0, :3, 3] = 9.0
    assert not robot.plan_path(nowhere).pieces


def test_what_is_given_is_checked(rng):
    robot = arm("ur5")
    poses = robot.pose(robot.random(rng, 3))
    turned = poses[:2].copy()
    turned[1, :3, :3] = turned[0, :3, :3] @ np.diag([1.0, -1.0, -1.0])
    with pytest.raises(rik.InputError, match="poses 0 and 1 are half a turn apart"):
        robot.plan_path(turned)
    with pytest.raises(rik.InputError, match="start misses the first pose by"):
        robot.plan_path(poses, start=robot.random(rng))
    with pytest.raises(rik.InputError, match="accuracy"):
        robot.plan_path(poses, accuracy=0)
    with pytest.raises(rik.InputError, match=r"\(p, 4, 4\)"):
        robot.plan_path(poses[0])
    with pytest.raises(rik.InputError):
        robot.plan_path(np.full((2, 4, 4), np.nan))
    with pytest.raises(rik.FrameNotFoundError):
        robot.plan_path(poses, frame="nowhere")
    with pytest.raises(rik.InputError, match="q0"):
        robot.plan_path(poses, np.zeros((2, 6)))


# ------------------------------------------------------------------------------------------------ what is easily wrong
def test_a_tool_that_points_the_other_way_is_half_a_turn_off():
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    for rows in (("x", "y", "z", "wx", "wy"), ("wx", "wz"), ("x", "wy", "wz")):
        free = ({"wx", "wy", "wz"} - set(rows)).pop()
        flipped = np.eye(4) if free == "wx" else down
        wanted = np.diag([-1.0, -1.0, 1.0, 1.0]) if free == "wx" else np.eye(4)
        assert path_error(flipped, wanted, rows, 1.0) == pytest.approx(np.pi)
        assert np.linalg.norm(path_twist(flipped, wanted, rows)) == pytest.approx(np.pi)


def test_joints_that_do_not_move_the_frame_stay_where_the_start_has_them(rng):
    robot = rik.load("ur5")
    values = wandering(robot, rng, 0.4, 20)
    values[:, 4:] = [0.2, 0.3]
    plan = robot.plan_path(robot.pose(values, "wrist_1_link")[:, :3, 3], start=values[0], frame="wrist_1_link")
    assert plan.followed, plan.reasons
    np.testing.assert_allclose(plan.q[:, 4:], np.tile([0.2, 0.3], (len(plan.q), 1)), atol=1e-12)
    assert plan.pieces[0].margin > 1e-3


def test_the_tool_may_stand_still(rng):
    robot = rik.load("panda")
    q = robot.random(rng)
    T = robot.pose(q)
    plan = robot.plan_path([T, T, T], start=q)
    assert plan.followed, plan.reasons
    assert plan.pieces[0].travel < 1e-6
    planar = rik.load("planar_2r")
    reach = planar.pose([0.0, 0.0])[0, 3]
    points = np.array([[x, 0, 0] for x in (reach - 0.1, reach + 3e-5, reach + 3e-5, reach - 0.1)])
    plan = planar.plan_path(points, rows=("x", "y"))
    assert plan.followed, plan.reasons


def test_a_path_just_out_of_reach_is_followed_within_the_accuracy_from_anywhere():
    planar = rik.load("planar_2r")
    reach = planar.pose([0.0, 0.0])[0, 3]
    for q0 in (None, [0.0, 0.0], [2.0, -1.0]):
        assert planar.plan_path([[reach + 3e-5, 0, 0]], q0, rows=("x", "y")).followed


def test_a_boundary_that_is_touched_often_does_not_end_the_search():
    planar = rik.load("planar_2r")
    reach = planar.pose([0.0, 0.0])[0, 3]
    xs = np.tile([reach - 0.05, reach + 3e-5], 130)
    plan = planar.plan_path(np.stack([xs, 0 * xs, 0 * xs], axis=1), rows=("x", "y"))
    assert plan.followed, plan.reasons


def test_a_search_that_gives_up_returns_what_it_has_verified(monkeypatch):
    robot = rik.load("puma560")
    poses = robot.pose(np.array([0.3, -0.5, 0.6, 0.2, 0.0, -0.1]) + np.linspace(-1, 1, 9)[:, None] * 0.3)
    whole = robot.plan_path(poses)
    monkeypatch.setattr(furthest_motion, "ROUNDS", 0)
    monkeypatch.setattr(furthest_motion, "LONGEST", 3.0)
    plan = robot.plan_path(poses)
    holds_what_it_says(robot, poses, plan, 1e-4)
    assert whole.followed


def test_what_would_take_without_end_is_refused():
    robot = arm("ur5")
    T = robot.pose(robot.rest)
    far = T.copy()
    far[0, 3] = 1e7
    with pytest.raises(rik.InputError, match="places .* the longest way between two poses is 1e\\+07 m"):
        robot.plan_path([T, far])
    with pytest.raises(rik.InputError, match="accuracy must be ≥"):
        robot.plan_path([T, T], accuracy=1e-12)


def test_a_position_that_is_missed_is_told_in_millimetres_and_a_rotation_in_degrees():
    robot = arm("ur5")
    T = robot.pose(robot.rest)
    far = T.copy()
    far[0, 3] += 3.0
    said = robot.plan_path([T, far]).stops[-1].said
    assert " mm and " in said
    assert said.endswith("°, to the end of the path")
    points = np.array([T[:3, 3], far[:3, 3]])
    said = robot.plan_path(points).stops[-1].said
    assert "°" not in said
