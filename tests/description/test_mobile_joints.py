"""Planar and floating joints of a URDF: the joints that stand for them, limits, names, notes, what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf import parse_urdf
from robust_ik.description.urdf.mobile_joints import MOST_PITCH, PITCH_MARGIN, plane_axes

LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="3"/>'
PLANAR, FLOATING = (
    ("base_x", "base_y", "base_yaw"),
    tuple(f"base_{each}" for each in ("x", "y", "z", "yaw", "pitch", "roll")),
)


def joint(name, kind, parent, child, inside=LIMIT):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def robot_of(*joints, links="abcd", tip=None, **options):
    text = "".join([*(f'<link name="{link}"/>' for link in links), *joints])
    return rik.Robot.from_description(parse_urdf(f'<robot name="r">{text}</robot>'), tip, **options)


def on(kind, inside="", **options):
    return robot_of(joint("base", kind, "a", "b", inside), joint("arm", "revolute", "b", "c"), links="abc", **options)


# ------------------------------------------------------------------------------------------------ what they become
@pytest.mark.parametrize("kind, names", [("planar", PLANAR), ("floating", FLOATING)])
def test_such_a_joint_is_taken_as_joints_of_one_degree_of_freedom(kind, names):
    robot = on(kind)
    assert robot.joint_names == (*names, "arm")
    assert robot.description.parts == {"base": names}
    kinds = [robot.description.joint[name].kind for name in names]
    assert kinds == [
        "prismatic" if name[-1] in "xyz" else "revolute" if "pitch" in name else "continuous" for name in names
    ]
    assert any(f"joint 'base': is {kind}: it is taken as {', '.join(names)}" in note for note in robot.notes)
    assert_allclose(robot.rest, robot.neutral)


def test_slides_have_no_limits_and_pitch_ends_before_its_coordinates_are_singular():
    robot = on("floating")
    assert_allclose(robot.upper[:6], [np.inf] * 4 + [MOST_PITCH, np.inf])
    assert_allclose(robot.lower, -robot.upper)
    assert np.pi / 2 - PITCH_MARGIN == MOST_PITCH
    assert any("pitch ends at ±1.471 rad: at ±π/2 its coordinates are singular" in note for note in robot.notes)
    assert_allclose(abs(np.linalg.det(robot.jacobian(robot.rest)[:, :6])), 1.0)


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_limits_of_positions_count_for_nothing_and_the_speed_is_that_of_each_joint(kind):
    robot = on(kind, LIMIT)
    assert np.isinf(robot.upper[:2]).all()
    assert_allclose(robot.velocity_limit[:-1], 2.0)
    assert np.isinf(on(kind).velocity_limit[:-1]).all()


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_negative_speed_is_refused_for_them_as_for_others(kind):
    with pytest.raises(rik.UrdfError, match="'base' has a negative speed limit"):
        on(kind, '<limit velocity="-1"/>')


@pytest.mark.parametrize(
    "normal, first",
    [([0, 0, 1], [1, 0, 0]), ([0, 0, -1], [1, 0, 0]), ([0, 1, 0], [1, 0, 0]), ([1, 0, 0], [0, 1, 0]),
     ([-1, 0, 0], [0, 1, 0]), ([0.6, 0, 0.8], [0.8, 0, -0.6])],
)  # fmt: skip
def test_the_first_axis_of_a_plane_is_x_as_far_as_it_lies_in_it_and_y_if_the_normal_is_x(normal, first):
    one, other = plane_axes(np.array(normal, dtype=float))
    assert_allclose(one, first, atol=1e-15)
    assert_allclose(np.cross(one, other), normal, atol=1e-15)
    text = " ".join(map(str, normal))
    robot = on("planar", f'<origin xyz="1 2 3" rpy="0.4 -0.5 0.6"/><axis xyz="{text}"/>')
    frame = robot.pose(robot.rest, "b")[:3, :3]
    assert_allclose(robot.jacobian(robot.rest, "b")[:3, :2], frame @ np.column_stack([one, other]), atol=1e-15)
    assert_allclose(robot.jacobian(robot.rest, "b")[3:, 2], frame @ normal, atol=1e-15)


def test_axes_of_any_plane_are_right_handed(rng):
    for normal in rng.normal(size=(200, 3)):
        normal /= np.linalg.norm(normal)
        axes = np.column_stack([*plane_axes(normal), normal])
        assert_allclose(axes.T @ axes, np.eye(3), atol=1e-14)
        assert_allclose(np.linalg.det(axes), 1.0)


def test_a_plane_without_an_axis_has_the_normal_x_and_a_note_says_so():
    robot = on("planar")
    assert_allclose(robot.jacobian(robot.rest, "b")[3:, 2], [1, 0, 0])
    assert any("the normal of its plane is x, which URDF says if none is stated" in note for note in robot.notes)
    assert any("the normal of its plane is as stated" in note for note in on("planar", '<axis xyz="0 1 0"/>').notes)
    assert len(on("planar", '<axis xyz="0 0 2"/>').notes) == 1


# --------------------------------------------------------------------------------------------------------- names
def test_a_joint_that_was_taken_apart_is_asked_for_by_its_parts():
    robot = on("planar")
    says = "in the file it moves in 3 ways and is taken as base_x, base_y, base_yaw"
    for ask in (
        lambda: robot.pose(robot.rest, "base"),
        lambda: on("planar", tip="base"),
        lambda: rik.JointTask("base", 0.0, 1.0).equation(robot, robot.rest),
    ):
        with pytest.raises(rik.FrameNotFoundError, match=says):
            ask()


def test_names_that_are_taken_already_stay_with_whom_they_are():
    robot = robot_of(
        joint("base", "planar", "base_y", "base_x_link", '<axis xyz="0 0 1"/>'),
        joint("base_x", "revolute", "base_x_link", "c"),
        links=["base_y", "base_x_link", "c"],
    )
    assert robot.joint_names == ("base_x_", "base_y_", "base_yaw", "base_x")
    assert robot.description.root == "base_y"
    assert robot.pose(robot.rest, "base_x_link").shape == (4, 4)


# ------------------------------------------------------------------------------------------------- trees and tips
@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_joint_off_the_chain_stands_still(kind):
    joints = [joint("arm", "revolute", "a", "b"), joint("side", kind, "a", "c")]
    robot = robot_of(*joints, links="abc", tip="b")
    assert robot.joint_names == ("arm",)
    assert any(f"'side': is {kind}" in note for note in robot.notes)
    assert robot_of(*joints, links="abc", whole_tree=True).n == 1 + (3 if kind == "planar" else 6)


def test_a_body_that_floats_beside_an_arm_is_no_longer_arm():
    arm = [joint(f"j{i}", "revolute", f"l{i}", f"l{i + 1}") for i in range(3)]
    description = robot_of(
        *arm, joint("box", "floating", "l0", "box"), links=[*(f"l{i}" for i in range(4)), "box"]
    ).description
    assert choose_tip(description).name == "l3"


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_the_tip_of_a_body_that_moves_is_the_link_that_its_frames_share(kind):
    fixed = [joint(f"f{leaf}", "fixed", "b", leaf, "") for leaf in "cd"]
    assert robot_of(joint("base", kind, "a", "b", ""), *fixed).tip == "b"


def test_several_planar_joints_each_have_their_parts():
    robot = robot_of(
        joint("one", "planar", "a", "b", '<axis xyz="0 0 1"/>'),
        joint("two", "planar", "b", "c", '<axis xyz="0 1 0"/>'),
        joint("three", "floating", "c", "d", ""),
    )
    assert robot.n == 12
    assert list(robot.description.parts) == ["one", "two", "three"]
    assert robot.description.floating("d") == tuple(f"three_{each[5:]}" for each in FLOATING)
    assert robot.description.floating("c") == ()


def test_a_scene_of_hundreds_of_such_joints_one_behind_the_other_is_refused_by_its_depth():
    links = [f"l{i}" for i in range(300)]
    text = "".join(f'<link name="{link}"/>' for link in links)
    text += "".join(joint(f"j{i}", "floating", f"l{i}", f"l{i + 1}", "") for i in range(299))
    with pytest.raises(rik.UrdfError, match="1794 joints deep; more than 1000 are refused"):
        parse_urdf(f'<robot name="r">{text}</robot>')


# --------------------------------------------------------------------------------------------------------- mimics
def test_a_joint_cannot_follow_all_of_a_planar_joint_but_one_of_its_parts():
    follower = joint("arm", "revolute", "b", "c", LIMIT + '<mimic joint="base"/>')
    base = joint("base", "planar", "a", "b", '<axis xyz="0 0 1"/>')
    with pytest.raises(
        rik.UrdfError, match="'arm' mimics joint 'base', of which base_x, base_y, base_yaw can be mimicked"
    ):
        robot_of(base, follower, links="abc")
    assert robot_of(base, follower, links="abc", tip="b").n == 3
    robot = robot_of(base, follower.replace('"base"', '"base_yaw" multiplier="2"'), links="abc")
    assert robot.joint_names == PLANAR
    assert robot.description.joint["base_yaw"].kind == "revolute"  # with its turns counted, as for any that is followed
    q = robot.configuration([0.0, 0.0, 0.4])
    assert_allclose(robot.jacobian(q)[3:, 2], [2 * np.cos(0.4), 2 * np.sin(0.4), 1], atol=1e-15)


@pytest.mark.parametrize("kind", ["planar", "floating"])
@pytest.mark.parametrize("follows", ['joint="arm"', 'joint="base"', "", 'joint="arm" multiplier="two"'])
def test_such_a_joint_that_mimics_is_free_and_a_note_says_so(kind, follows):
    robot = on(kind, f'<axis xyz="0 0 1"/><mimic {follows}/>')
    assert robot.n == 1 + (3 if kind == "planar" else 6)
    assert any(f"is {kind}, so that it cannot mimic a joint: it is free" in note for note in robot.notes)


def test_a_planar_joint_without_a_readable_axis_is_refused_where_it_is_needed():
    arm = joint("arm", "revolute", "a", "c")
    for axis in ("0 0 0", "0 1"):
        base = joint("base", "planar", "a", "b", f'<axis xyz="{axis}"/>')
        with pytest.raises(rik.UrdfError, match="'base' has"):
            robot_of(base, arm, links="abc", tip="b")
        assert robot_of(base, arm, links="abc", tip="c").joint_names == ("arm",)
