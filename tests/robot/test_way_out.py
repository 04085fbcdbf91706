"""Whether a command can be followed out of a singular configuration, held against the arm's own motion."""

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.kinematics.svd import svd
from robust_ik.robot.way_out import WayOut
from tests.inverses.test_second_order import ARMS, beyond, singular

S = 1e-3
"""Steps along a motion, rad: its effect to second order is 1e-6, to third 1e-9."""


@pytest.mark.parametrize("name", ARMS)
def test_the_joint_motion_moves_the_tool_along_the_command_by_half_the_curvature_to_either_side(name, rng):
    robot, seen = rik.load(name), 0
    for q, u in singular(robot, rng, 6):
        for side in (1.0, -1.0):
            way = robot.way_out(q, side * u)
            assert way.share == pytest.approx(1)
            np.testing.assert_allclose(way.lost, side * u, atol=1e-6)
            if way.exit not in (rik.Exit.FOLD, rik.Exit.BOTH_WAYS):
                assert not way.motion.any() or way.exit is rik.Exit.TURN_FIRST
                continue
            seen += 1
            size = np.abs(way.motion)
            assert way.motion[np.argmax(size > 0.99 * size.max())] > 0  # of two equal motions one is told, always
            for step in (S, -S):
                there = robot.integrate(q, step * way.motion)
                row = rik.FrameTask(robot.pose(there), gain=1) if len(robot.rows) == 6 else None
                error = row.equation(robot, q).error if row else (robot.pose(there) - robot.pose(q))[:3, 3]
                assert side * u @ error == pytest.approx(0.5 * way.curvature * S**2, rel=0.02, abs=20 * S**3)
    assert seen or name in ("srs_7r",)


@pytest.mark.parametrize("name", ARMS)
def test_a_command_and_its_opposite_get_verdicts_that_fit_each_other(name, rng):
    robot, kinds = rik.load(name), rik.Exit
    pairs = {kinds.FOLD: kinds.END_OF_REACH, kinds.END_OF_REACH: kinds.FOLD}
    for q, u in singular(robot, rng, 6):
        there, back = (robot.way_out(q, side * u) for side in (1.0, -1.0))
        assert back.exit is pairs.get(there.exit, there.exit)


def test_known_families_have_their_verdicts(rng):
    pa10, kinds = rik.load("pa10"), rik.Exit

    def found(robot, values):
        q = robot.configuration(values)
        u = svd(robot.jacobian(q)).U[:, -1]
        return {robot.way_out(q, side * u).exit for side in (1.0, -1.0)}

    assert found(pa10, [0.3, 0.8, -0.4, 0.0, 0.6, 0.9, 0.2]) == {kinds.FOLD, kinds.END_OF_REACH}
    assert found(pa10, [0.3, 0.0, np.pi / 2, 1.1, 0.6, 0.9, 0.2]) == {kinds.BOTH_WAYS}
    assert found(rik.load("puma560"), [0.3, -0.8, 2.6, 0.5, 0.0, 0.9]) == {kinds.TURN_FIRST}
    assert found(rik.load("ur5"), [0.3, -0.8, 0.0, 0.5, 1.0, 0.9]) == {kinds.FOLD, kinds.END_OF_REACH}


def test_a_command_that_is_not_lost_is_free(rng):
    robot = rik.load("panda")
    way = robot.way_out(robot.rest, rng.normal(size=6))
    assert way.exit is rik.Exit.FREE
    assert way.share == 0
    assert not way.motion.any()
    assert way.turn == 0
    assert way.text == "nothing that is asked for is lost here."
    assert robot.way_out(robot.rest, np.zeros(6)).exit is rik.Exit.FREE


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_the_size_of_an_arm_changes_no_verdict(size):
    robot, large = (rik.Robot.from_dh(planar(length)) for length in (1.0, size))
    for values in ([0.3, 0.0, 0.4], [0.3, 1.0, 0.0], [0.1, 0.7, -0.9]):
        for angle in np.linspace(0, 2 * np.pi, 7):
            twist = np.array([np.cos(angle), np.sin(angle)])
            first, second = (each.way_out(each.configuration(values), twist) for each in (robot, large))
            assert first.exit is second.exit
            np.testing.assert_allclose(second.motion, first.motion, atol=1e-9)


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_the_size_of_an_arm_with_a_slide_changes_no_verdict(size):
    def polar(length):
        half = np.pi / 2
        joints = [rik.DHJoint(a=0.0, d=0.4 * length, alpha=half), rik.DHJoint(a=0.3 * length, d=0.0, alpha=half)]
        slide = rik.DHJoint(a=0.0, d=0.5 * length, alpha=0.0, kind="prismatic", lower=-length, upper=length)
        return rik.Robot.from_dh(rik.DHTable((*joints, slide), "standard", name="polar", rows=("x", "y", "z")))

    first, second = polar(1.0), polar(size)
    unit = second.length_scale / first.length_scale
    assert 0.3 * size < unit < 3 * size
    for values in ([0.3, np.pi / 2, 0.0], [0.3, 0.2, 0.1], [0.2, 0.7, -0.3], [0.2, 0.0, -0.5]):
        for twist in np.eye(3), -np.eye(3):
            for along in twist:
                here = first.way_out(first.configuration(values), along)
                there = second.way_out(second.configuration(values * np.array([1, 1, size])), along)
                assert here.exit is there.exit


def test_commands_that_no_joint_gives_are_structural_with_their_share():
    robot = rik.load("planar_3r")
    q = robot.configuration([0.4, 0.7, -0.9])
    six = ("x", "y", "z", "wx", "wy", "wz")
    way = robot.way_out(q, np.array([0, 1.0, 0, 0, 0, 0]), rows=six)
    assert way.exit is rik.Exit.STRUCTURAL
    assert way.share == pytest.approx(1)
    assert robot.way_out(q, [1.0], rows=("y",)).exit is rik.Exit.STRUCTURAL  # J is rounding there
    straight = robot.configuration([0.0, 0.0, 0.0])
    ends = {robot.way_out(straight, [side], rows=("x",)).exit for side in (1.0, -1.0)}
    assert ends == {rik.Exit.FOLD, rik.Exit.END_OF_REACH}
    tiny = 1e-200 * svd(robot.jacobian(straight)).U[:, -1]
    assert robot.way_out(straight, tiny).exit is robot.way_out(straight, 1e200 * tiny).exit is not rik.Exit.FREE


def planar(length):
    joints = tuple(rik.DHJoint(a=length * a, d=0.0, alpha=0.0) for a in (0.5, 0.4, 0.3))
    return rik.DHTable(joints, "standard", name="planar", rows=("x", "y"))


def test_the_text_tells_the_verdict_the_joints_and_the_turn():
    robot = rik.load("puma560")
    q = robot.configuration([0.3, -0.8, 2.6, 0.5, 0.0, 0.9])
    u = svd(robot.jacobian(q)).U[:, -1]
    way = robot.way_out(q, u)
    assert isinstance(way, WayOut)
    assert str(way) == way.text
    assert way.text.startswith("100% of the command is lost: the tool cannot move this way yet")
    assert "1.00 joint4" in way.text
    assert "1.00 joint6" in way.text
    assert "rad of the fastest joint" in way.text
    with pytest.raises(rik.InputError, match="one q and one twist are needed"):
        robot.way_out(np.stack([q, q]), u)
    with pytest.raises(rik.InputError, match="threshold must be > 0 and < 1"):
        robot.way_out(q, u, threshold=2)
    assert beyond(robot, q, np.zeros(6)) == pytest.approx(robot.pose(q))


@pytest.mark.parametrize("name", ["ur5", "puma560", "duleba_3r"])
def test_what_the_atlas_says_of_the_family_stands_beside_the_verdict_and_agrees_with_it(name, rng):
    kinds = rik.Exit
    expected = {
        "to one side only": {kinds.FOLD, kinds.END_OF_REACH},
        "to both sides": {kinds.BOTH_WAYS},
        "do not lead along it": {kinds.TURN_FIRST, kinds.STRUCTURAL},
    }
    robot, met = rik.load(name), set()
    atlas = rik.find_singularities(robot, 1, starts=100, certify=False)
    for row in atlas:
        for values in row.samples[:: max(1, len(row.samples) // 20)]:
            q = robot.configuration(values)
            found = svd(robot.jacobian(q))
            u = found.U[:, -1]
            if found.s[-2] < 0.1 * found.s[0]:  # where two families cross, curvature fades
                continue
            exits = set()
            for side in (1.0, -1.0):
                way = robot.way_out(q, side * u, atlas=atlas)
                assert way.family.startswith(f"on {row.words}, corank 1: ")
                alone = robot.way_out(q, side * u).text
                assert way.text == f"{alone} Of the nearest family the atlas says: {way.family}."
                exits.add(way.exit)
            for words, kind in expected.items():
                if words in way.family:
                    met.add(words)
                    assert exits <= kind
    assert met
    beside = robot.way_out(robot.configuration(values + 0.02), np.ones(len(robot.rows)), atlas=atlas)
    assert "rad from" in beside.family
    assert beside.text.endswith(f"{beside.family}.")


def test_an_atlas_is_about_the_tip_in_the_rows_of_the_robot():
    robot = rik.load("planar_3r")
    atlas = rik.find_singularities(robot, starts=60, certify=False)
    q = robot.configuration([0.4, 0.7, -0.9])
    with pytest.raises(rik.InputError, match="give neither frame nor rows with it"):
        robot.way_out(q, [1.0], rows=("x",), atlas=atlas)
    with pytest.raises(rik.InputError, match="atlas must be a SingularityAtlas, got 1e"):
        robot.way_out(q, [1.0, 0.0], atlas=1e308)
    assert robot.way_out(q, [1.0, 0.0], atlas=atlas).family.count("corank") == 1


def wrist_turn(robot, q, lost, side):
    """How far joints 4 and 6 turn against each other until half of what is lost at q5 = 0 can be followed, rad."""
    for angle in np.arange(0.0, np.pi, 0.001):
        values = robot.joint_values(q) + side * angle * np.array([0, 0, 0, 1.0, 0, -1.0])
        found = svd(robot.jacobian(robot.configuration(values)) / np.array([[robot.length_scale]] * 3 + [[1.0]] * 3))
        if np.linalg.norm(found.U[:, found.s >= 0.02 * found.s[0]].T @ lost) >= 0.5:
            return angle
    return np.inf


def test_a_turn_is_the_shorter_one_of_both_sides_and_there_is_none_where_half_a_turn_is_too_little(rng):
    robot, kinds, sides = rik.load("puma560"), set(), set()
    for _ in range(30):
        q = robot.configuration(np.where(np.arange(6) == 4, 0.0, rng.uniform(-2.5, 2.5, 6)))
        found = svd(robot.jacobian(q) / np.array([[robot.length_scale]] * 3 + [[1.0]] * 3))
        if found.s[-2] < 0.02 * found.s[0]:
            continue
        u = found.U[:, -1]
        way = robot.way_out(q, u * np.array([robot.length_scale] * 3 + [1.0] * 3))
        forth, back = (wrist_turn(robot, q, u, side) for side in (1.0, -1.0))
        kinds.add(way.exit)
        if way.exit is rik.Exit.TURN_FIRST:
            sides.add(way.motion[3] > 0)
            assert way.turn == pytest.approx(min(forth, back), abs=0.03)
            assert way.turn == pytest.approx(forth if way.motion[3] > 0 else back, abs=0.03)
        else:
            assert way.exit is rik.Exit.STRUCTURAL
            assert min(forth, back) == np.inf
            assert (way.turn, way.motion.any()) == (np.inf, False)
    assert kinds == {rik.Exit.TURN_FIRST, rik.Exit.STRUCTURAL}
    assert sides == {False, True}


def test_a_frame_that_no_joint_moves_cannot_follow_anything():
    robot = rik.load("ur5")
    way = robot.way_out(robot.rest, [0, 0, 1, 0, 0, 0], frame=robot.description.root)
    assert (way.exit, way.share) == (rik.Exit.STRUCTURAL, 1.0)
    assert not way.motion.any()
