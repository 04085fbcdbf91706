import itertools
import math
import re

import numpy as np
import pinocchio as pin
import pytest
from lxml import etree
from numpy.testing import assert_allclose, assert_array_equal

from robust_ik.description.dh.dh_table import DHJoint, DHTable, screw
from robust_ik.description.dh.dh_urdf import dh_to_urdf
from robust_ik.description.joint_tree import Box, Cylinder, Sphere
from robust_ik.description.tips import choose_tip
from robust_ik.description.urdf.urdf_reader import parse_urdf

CONVENTIONS = ("standard", "modified")
SEEDS = range(20)


def random_pose(rng):
    pose = np.eye(4)
    for axis in rng.permutation(3):
        pose = pose @ screw(int(axis), random_angle(rng), rng.normal())
    return pose


def random_angle(rng):
    return float(rng.choice([0, math.pi / 2, -math.pi / 2, math.pi, rng.uniform(-math.pi, math.pi)]))


def random_joint(rng):
    row = {"alpha": random_angle(rng), "theta": random_angle(rng)}
    row |= {key: float(rng.choice([0.0, rng.normal()])) for key in ("a", "d")}
    if rng.random() < 0.4:
        return DHJoint(kind="prismatic", lower=-1, upper=float(rng.uniform(0, 2)), **row)
    return DHJoint(**row)


def random_table(convention, seed):
    rng = np.random.default_rng(seed)
    joints = [random_joint(rng) for _ in range(rng.integers(1, 9))]
    return DHTable(joints, convention, base=random_pose(rng), tool=random_pose(rng))


def pinocchio_of(table):
    model = pin.buildModelFromXML(dh_to_urdf(table))
    return model, model.createData()


def placement(model, data, link):
    return data.oMf[model.getFrameId(link, pin.FrameType.BODY)].homogeneous


# --------------------------------------------------------------------------------------------- kinematics
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_pinocchio_finds_the_pose_of_every_link_and_of_the_tip(convention, seed):
    table = random_table(convention, seed)
    model, data = pinocchio_of(table)
    for q in np.random.default_rng(seed).uniform(-3, 3, (3, table.n)):
        pin.framesForwardKinematics(model, data, q)
        frames = table.frames(q)
        for i in range(table.n):
            assert_allclose(placement(model, data, f"link{i + 1}"), frames[i], rtol=0, atol=1e-12)
        assert_allclose(placement(model, data, "tool"), table.pose(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_pinocchio_finds_the_jacobian_of_the_tip(convention, seed):
    table = random_table(convention, seed)
    model, data = pinocchio_of(table)
    tip = model.getFrameId("tool", pin.FrameType.BODY)
    for q in np.random.default_rng(seed).uniform(-3, 3, (3, table.n)):
        J = pin.computeFrameJacobian(model, data, q, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        assert_allclose(J, table.jacobian(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("gap", [0.0, 1e-17, 1e-16, 1e-15, 1e-12, 1e-8, 1e-4])
@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_no_digit_is_lost_where_euler_angles_are_ill_defined(pitch, gap):
    base = screw(2, 0.7, 0) @ screw(1, pitch + gap, 0) @ screw(0, -0.4, 0)
    noise = gap * np.array([[1, -2, 1], [2, 1, -1], [0.5, 1, 1]]) if gap < 1e-13 else 0.0
    base[:3, :3] += noise
    table = DHTable([DHJoint(a=0.3, d=0.2, alpha=1.1)], "standard", base=base, tool=base)
    model, data = pinocchio_of(table)
    pin.framesForwardKinematics(model, data, np.array([0.5]))
    assert_allclose(placement(model, data, "tool"), table.pose([0.5]), rtol=0, atol=1e-13)


def test_a_table_of_zeros_is_a_robot_too():
    table = DHTable([DHJoint(a=0, d=0, alpha=0)], "standard")
    model, data = pinocchio_of(table)
    pin.framesForwardKinematics(model, data, np.array([0.5]))
    assert_allclose(placement(model, data, "tool"), screw(2, 0.5, 0), rtol=0, atol=1e-15)
    sizes = [size for visual in parse_urdf(dh_to_urdf(table)).visuals for size in vars(visual.shape).values()]
    assert sizes
    assert min(sizes) > 0


# --------------------------------------------------------------------------------------------------- text
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_every_number_is_plain_and_written_to_its_last_bit(convention):
    table = random_table(convention, 3)
    root = etree.fromstring(dh_to_urdf(table))
    words = [
        word
        for element in root.iter()
        for key, text in element.attrib.items()
        if key not in ("name", "link", "type")
        for word in text.split()
    ]
    assert words
    for word in words:
        assert re.fullmatch(r"-?\d+(\.\d+)?(e-?\d+)?", word), word
        assert word == repr(float(word)), word
        assert word != "-0.0"
    for joint, expected in zip(root.iter("joint"), table.placements):
        xyz = [float(word) for word in joint.find("origin").get("xyz").split()]
        assert_array_equal(xyz, expected[:3, 3])


def test_what_the_table_does_not_state_is_filled_in_as_documented():
    row = {"a": 0.1, "d": 0.0, "alpha": 0.0}
    joints = [
        DHJoint(**row),
        DHJoint(**row, lower=-0.5, upper=4.0, velocity=2.0),
        DHJoint(**row, lower=5.0),
        DHJoint(**row, upper=-5.0),
        DHJoint(**row, kind="prismatic", lower=0.25, upper=0.5, velocity=0.75),
    ]
    model, _ = pinocchio_of(DHTable(joints, "standard"))
    full = 2 * math.pi
    assert_array_equal(model.lowerPositionLimit, [-math.pi, -0.5, 5.0, -5.0 - full, 0.25])
    assert_array_equal(model.upperPositionLimit, [math.pi, 4.0, 5.0 + full, -5.0, 0.5])
    assert_array_equal(model.velocityLimit, [1000, 2, 1000, 1000, 0.75])
    assert_array_equal(model.effortLimit, [1000] * 5)


def test_the_robot_has_the_names_of_the_table_whatever_they_are():
    names = ("base", "link1", "tool_joint", "base_", 'a <b> & "c" é')
    joints = [DHJoint(a=0.1, d=0.1, alpha=0.1, name=name) for name in names]
    table = DHTable(joints, "modified", name="arm <1>")
    robot = parse_urdf(dh_to_urdf(table))
    assert robot.name == "arm <1>"
    assert robot.links == ("base__", "link1_", "link2", "link3", "link4", "link5", "tool")
    assert tuple(joint.name for joint in robot.joints) == (*names, "tool_joint_")
    assert not set(robot.links) & {joint.name for joint in robot.joints}
    model, data = pinocchio_of(table)
    assert tuple(model.names)[1:] == names
    q = np.linspace(-1, 1, 5)
    pin.framesForwardKinematics(model, data, q)
    assert_allclose(placement(model, data, "tool"), table.pose(q), rtol=0, atol=1e-14)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_our_own_reader_has_nothing_to_remark(convention):
    table = random_table(convention, 5)
    robot = parse_urdf(dh_to_urdf(table))
    assert robot.notes == ()
    assert robot.root == "base"
    assert choose_tip(robot).name == "tool"
    assert robot.moving_joints("tool") == table.joint_names


# ------------------------------------------------------------------------------------------------- shapes
def ends(visual):
    half = visual.placement[:3, 2] * visual.shape.length / 2
    return visual.placement[:3, 3] - half, visual.placement[:3, 3] + half


def links_of(robot, link):
    """The slim cylinders of a link: all its shapes but the first, which is the joint."""
    shapes = [visual for visual in robot.visuals if visual.link == link]
    return shapes if link == "base" else shapes[1:]


@pytest.mark.parametrize("seed", SEEDS[:8])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_links_are_drawn_without_a_gap_from_joint_to_joint(convention, seed):
    table = random_table(convention, seed)
    robot = parse_urdf(dh_to_urdf(table))
    for k, link in enumerate(robot.links[:-1]):
        slides = k < table.n and table.joints[k].kind == "prismatic"
        way = links_of(robot, link)[: -1 if slides else None]
        corners = [np.zeros(3), *itertools.chain(*map(ends, way)), table.placements[k][:3, 3]]
        assert_allclose(corners[::2], corners[1::2], rtol=0, atol=1e-4)
        if slides:
            lower, upper = ends(links_of(robot, link)[-1])
            joint = table.joints[k]
            axis = table.placements[k][:3, 2]
            assert_allclose(lower, corners[-1] + joint.lower * axis, rtol=0, atol=1e-4)
            assert_allclose(upper, corners[-1] + joint.upper * axis, rtol=0, atol=1e-4)


def test_the_d_and_a_of_a_row_are_drawn_and_nothing_of_no_length():
    joints = [DHJoint(a=0.3, d=0.4, alpha=1.0, theta=0.5), DHJoint(a=0, d=0, alpha=1.0)]
    base = screw(0, 0.7, 0.6) @ screw(1, 0.9, 0.0)
    lengths = {
        convention: [[v.shape.length for v in links_of(robot, link)] for link in robot.links[:-1]]
        for convention in CONVENTIONS
        for robot in [parse_urdf(dh_to_urdf(DHTable(joints, convention, base=base)))]
    }
    assert lengths == {"standard": [[0.6], [0.4, 0.3], []], "modified": [[0.6, 0.3, 0.4], [], []]}


def test_a_joint_is_a_cylinder_about_its_axis_or_a_box_on_it_and_the_tool_a_ball():
    row = {"a": 0.5, "d": 0.5, "alpha": 1.0}
    table = DHTable([DHJoint(**row), DHJoint(**row, kind="prismatic", lower=0, upper=1)], "standard")
    robot = parse_urdf(dh_to_urdf(table))
    first = {link: next(v for v in robot.visuals if v.link == link) for link in ("link1", "link2", "tool")}
    kinds = {link: type(visual.shape) for link, visual in first.items()}
    assert kinds == {"link1": Cylinder, "link2": Box, "tool": Sphere}
    for visual in first.values():
        assert_array_equal(visual.placement, np.eye(4))
    assert {visual.color for visual in robot.visuals} == {
        first["tool"].color,
        links_of(robot, "link1")[0].color,
    }


def test_shapes_grow_with_the_arm():
    def scaled(factor):
        joints = [DHJoint(a=0.3 * factor, d=0.4 * factor, alpha=1.0) for _ in range(3)]
        return parse_urdf(dh_to_urdf(DHTable(joints, "standard"))).visuals

    for small, large in zip(scaled(1.0), scaled(1000.0), strict=True):
        assert_allclose(large.placement[:3, 3], 1000 * small.placement[:3, 3], rtol=1e-12)
        assert large.shape.radius == pytest.approx(1000 * small.shape.radius, rel=1e-5)
