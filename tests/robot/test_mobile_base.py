"""Robots whose base or another part moves in a plane or freely: as Pinocchio's own joints do; any robot on a base."""

import pickle
from copy import deepcopy

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.catalog import catalog
from robust_ik.description.urdf import parse_urdf
from robust_ik.description.urdf.mobile_joints import MOST_PITCH, plane_axes
from robust_ik.robot.reach import find_reach

KINDS = {"planar": 3, "floating": 6}
REFERENCES = ("local_world_aligned", "local", "world")
EXACT = 1e-12
"""Largest difference from Pinocchio, m and rad: rounding of chains of some metres."""


def central_difference(function, values, h=1e-6):
    """∂function/∂value, the joints on the last axis."""
    steps = h * np.eye(len(values))
    return np.stack([(function(values + step) - function(values - step)) / (2 * h) for step in steps], axis=-1)


# ------------------------------------------------------------------------------------------- against Pinocchio's own
class Made:
    """A random chain with a planar or floating joint in it, as a URDF and as Pinocchio's own model."""

    def __init__(self, kind, place, rng):
        self.kind, self.place = kind, place
        self.model, parts = pin.Model(), ['<robot name="r"><link name="l0"/>']
        joint, after = 0, pin.SE3.Identity()
        for i in range(4):
            rpy, xyz, axis = rng.uniform(-1.5, 1.5, 3), rng.normal(size=3), rng.normal(size=3)
            axis /= np.linalg.norm(axis)
            origin = after * pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)
            after, moves = pin.SE3.Identity(), kind if i == place else "revolute"
            if moves == "planar":
                turned = pin.SE3(np.column_stack([*plane_axes(axis), axis]), np.zeros(3))
                joint = self.model.addJoint(joint, pin.JointModelPlanar(), origin * turned, f"j{i}")
                after = turned.inverse()
            elif moves == "floating":
                joint = self.model.addJoint(joint, pin.JointModelFreeFlyer(), origin, f"j{i}")
            else:
                joint = self.model.addJoint(joint, pin.JointModelRevoluteUnaligned(axis), origin, f"j{i}")
            numbers = (" ".join(map(repr, map(float, each))) for each in (xyz, rpy, axis))
            parts.append(
                '<link name="l{1}"/><joint name="j{0}" type="{2}"><parent link="l{0}"/><child link="l{1}"/>'
                '<origin xyz="{3}" rpy="{4}"/><axis xyz="{5}"/><limit lower="-3" upper="3" velocity="1" effort="1"/>'
                "</joint>".format(i, i + 1, moves, *numbers)
            )
        self.frame = self.model.addFrame(pin.Frame("tip", joint, 0, after, pin.FrameType.OP_FRAME))
        self.data = self.model.createData()
        self.robot = rik.Robot.from_description(parse_urdf("".join([*parts, "</robot>"])), "l4")

    def of(self, values):
        """Pinocchio's configuration for our joint values, and its velocity per velocity of ours."""
        at, count = self.place, KINDS[self.kind]
        own, before, behind = values[at : at + count], values[:at], values[at + count :]
        mixing = np.eye(len(values))
        if self.kind == "planar":
            c, s = np.cos(own[2]), np.sin(own[2])
            inside = [*own[:2], c, s]
            mixing[at : at + 2, at : at + 2] = [[c, s], [-s, c]]
        else:
            yaw, pitch, roll = own[3:]
            R = pin.rpy.rpyToMatrix(roll, pitch, yaw)
            inside = [*own[:3], *pin.Quaternion(R).coeffs()]
            mixing[at : at + 3, at : at + 3] = R.T
            mixing[at + 3 : at + 6, at + 3 : at + 6] = np.array(
                [
                    [-np.sin(pitch), 0, 1],
                    [np.cos(pitch) * np.sin(roll), np.cos(roll), 0],
                    [np.cos(pitch) * np.cos(roll), -np.sin(roll), 0],
                ]
            )
        return np.array([*before, *inside, *behind]), mixing

    def values(self, rng):
        """Random joint values, with every orientation that the pitch allows."""
        values = rng.uniform(-3, 3, self.robot.n)
        if self.kind == "floating":
            values[self.place + 4] = rng.uniform(-MOST_PITCH, MOST_PITCH)
        return values


@pytest.mark.parametrize("place", [0, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_poses_and_jacobians_are_those_of_pinocchios_own_joint(kind, place, rng):
    for _ in range(20):
        made = Made(kind, place, rng)
        for _ in range(5):
            values = made.values(rng)
            q, (theirs, mixing) = made.robot.configuration(values), made.of(values)
            pin.framesForwardKinematics(made.model, made.data, theirs)
            wanted = made.data.oMf[made.frame].homogeneous
            scale = max(1.0, np.abs(wanted).max())
            assert_allclose(made.robot.pose(q), wanted, atol=EXACT * scale)
            assert_allclose(made.robot.pose(q[None])[0], wanted, atol=EXACT * scale)
            for name in REFERENCES:
                kind_of = getattr(pin.ReferenceFrame, name.upper())
                J = pin.computeFrameJacobian(made.model, made.data, theirs, made.frame, kind_of) @ mixing
                assert_allclose(made.robot.jacobian(q, reference=name), J, atol=EXACT * max(1.0, np.abs(J).max()))
                assert_allclose(
                    made.robot.jacobian(q[None], reference=name)[0], J, atol=EXACT * max(1.0, np.abs(J).max())
                )


@pytest.mark.parametrize("kind", KINDS)
def test_jacobian_and_hessian_agree_with_differences(kind, rng):
    robot = Made(kind, 1, rng).robot
    values = 0.3 * robot.joint_values(robot.random(rng))

    def at(values):
        return robot.jacobian(robot.configuration(values))

    def position(values):
        return robot.pose(robot.configuration(values))[:3, 3]

    assert_allclose(at(values)[:3], central_difference(position, values), atol=1e-7)
    assert_allclose(robot.hessian(robot.configuration(values)), central_difference(at, values), atol=1e-6)


def test_motion_along_the_slides_and_the_circle_is_that_of_the_manifold(rng):
    robot = rik.load("planar_2r", base="planar")
    q, dq = robot.random(rng), np.array([100.0, -200.0, 7.0, 0.1, 0.2])
    there = robot.integrate(q, dq)
    assert_allclose(robot.joint_values(there)[:2], robot.joint_values(q)[:2] + dq[:2])
    assert_allclose(robot.difference(q, there), [*dq[:2], 7 - 2 * np.pi, *dq[3:]], atol=1e-12)


# ------------------------------------------------------------------------------------------------ a robot on a base
@pytest.mark.parametrize("base", KINDS)
@pytest.mark.parametrize("name", ["ur5", "panda", "puma560", "almarkhi_4dof", "so100", "tiago"])
def test_a_robot_on_a_base_is_the_robot_moved(name, base, rng):
    arm, count = rik.load(name), KINDS[base]
    robot = rik.load(name, base=base)
    assert (robot.name, robot.tip, robot.rows) == (arm.name, arm.tip, arm.rows)
    assert robot.joint_names[count:] == arm.joint_names
    for each in ("lower", "upper", "velocity_limit"):
        assert_allclose(getattr(robot, each)[count:], getattr(arm, each))
    assert_allclose(robot.joint_values(robot.rest), [*np.zeros(count), *arm.joint_values(arm.rest)])
    q = arm.random(rng)
    values = np.append(rng.uniform(-1, 1, count), arm.joint_values(q))
    moved = pin.SE3.Identity().homogeneous
    moved[: count // 2 if count == 6 else 2, 3] = values[: 3 if count == 6 else 2]
    angles = values[5:2:-1] if count == 6 else [0.0, 0.0, values[2]]
    moved[:3, :3] = pin.rpy.rpyToMatrix(*angles)
    assert_allclose(robot.pose(robot.configuration(values)), moved @ arm.pose(q), atol=EXACT)


def test_mimic_joints_and_whole_trees_are_put_on_a_base(rng):
    for name in ("panda", "anymal_b"):
        tree = rik.load(name, whole_tree=True)
        robot = rik.on_base(tree, "floating")
        assert robot.n == tree.n + 6
        assert robot.tip is None
        assert robot.mixing.shape[0] == tree.mixing.shape[0] + 6
        leaf = tree.description.leaves[0]
        at_zero = robot.configuration(np.append(np.zeros(6), tree.joint_values(tree.rest)))
        assert_allclose(robot.pose(at_zero, leaf), tree.pose(tree.rest, leaf), atol=EXACT)


def test_a_table_keeps_its_limits_rows_and_rest_on_a_base():
    arm, robot = rik.load("duleba_3r"), rik.load("duleba_3r", base="planar")
    assert robot.rows == arm.rows == ("x", "y", "z")
    assert_allclose(robot.joint_values(robot.rest)[3:], arm.joint_values(arm.rest))


def test_a_base_upon_a_base_has_names_of_its_own():
    robot = rik.on_base(rik.load("ur5", base="planar"), "floating")
    assert robot.n == 3 + 6 + 6
    assert len(set(robot.joint_names)) == robot.n
    assert [len(each) for each in robot.description.parts.values()] == [6, 3]


def test_a_fixed_base_is_the_robot_itself_and_others_are_refused():
    arm = rik.load("planar_2r")
    assert rik.on_base(arm, "fixed") is arm
    for ask in (lambda: rik.on_base(arm, "omni"), lambda: rik.load("planar_2r", base="omni")):
        with pytest.raises(rik.InputError, match="base must be 'fixed', 'planar' or 'floating', got 'omni'"):
            ask()


def test_a_robot_on_a_base_is_copied_and_pickled_whole():
    robot = rik.load("ur5", base="floating")
    for other in (pickle.loads(pickle.dumps(robot)), deepcopy(robot)):
        assert other.description.parts == robot.description.parts
        assert (other.jacobian(robot.rest) == robot.jacobian(robot.rest)).all()


def test_what_the_added_base_is_written_as_is_read_as_the_same_robot(rng):
    robot = rik.load("ur5", base="floating")
    again = rik.Robot.from_description(parse_urdf(robot.description.xml), robot.tip)
    assert again.joint_names == robot.joint_names
    assert_allclose(again.lower, robot.lower)
    assert_allclose(again.upper, robot.upper)
    q = robot.random(rng)
    assert_allclose(again.pose(q), robot.pose(q), atol=EXACT)


@pytest.mark.parametrize("name", ["g1", "g1_with_hands"])
def test_the_floating_base_that_a_humanoids_file_has_in_a_comment_is_read(name, rng):
    text = catalog()[name].path.read_text()
    assert text.count("<!-- <link name=") == 1
    whole = text.replace("<!-- <link name=", "<link name=").replace("</joint> -->", "</joint>")
    fixed, robot = (rik.Robot.from_description(parse_urdf(each), "left_wrist_yaw_link") for each in (text, whole))
    parts = tuple(f"floating_base_joint_{each}" for each in ("x", "y", "z", "yaw", "pitch", "roll"))
    assert robot.joint_names == (*parts, *fixed.joint_names)
    values = rng.uniform(-1, 1, robot.n)
    moved = np.eye(4)
    moved[:3, :3], moved[:3, 3] = pin.rpy.rpyToMatrix(*values[5:2:-1]), values[:3]
    q = fixed.configuration(values[6:])
    assert_allclose(robot.pose(robot.configuration(values)), moved @ fixed.pose(q), atol=EXACT)


# -------------------------------------------------------------------------------------------------- size and samples
@pytest.mark.parametrize("base", KINDS)
def test_the_size_and_the_reach_are_those_of_what_stands_on_the_base(base):
    for name in ("ur5", "panda"):
        alone, robot = rik.load(name), rik.load(name, base=base)
        assert alone.size <= robot.size < alone.size + 0.5
        reach = find_reach(robot)
        assert find_reach(alone).distance <= reach.distance + 1e-6 < find_reach(alone).distance + 0.5
        assert_allclose(robot.joint_values(reach.q)[:2], 0.0)


def scaled(factor):
    """A 3R arm on a planar base, all lengths times a factor."""
    joints = [("0 0 1", "0 0 1"), ("0.2 0 0.3", "0 1 0"), ("0.5 0 0", "0 1 0")]
    ends = '<parent link="w"/><child link="l0"/><axis xyz="0 0 1"/>'
    text = [f'<robot name="r"><link name="w"/><link name="l0"/><joint name="base" type="planar">{ends}</joint>']
    for i, (xyz, axis) in enumerate([*joints, ("0.4 0 0", "1 0 0")]):
        lengths = " ".join(repr(factor * float(each)) for each in xyz.split())
        kind = "fixed" if i == 3 else "continuous"
        text.append(
            f'<link name="l{i + 1}"/><joint name="j{i}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="{lengths}"/><axis xyz="{axis}"/></joint>'
        )
    return rik.Robot.from_description(parse_urdf("".join([*text, "</robot>"])))


@pytest.mark.parametrize("factor", [2.0**-10, 2.0**10])
def test_a_tiny_or_huge_arm_on_a_base_is_sampled_and_solved_as_one_of_a_metre(factor):
    usual, other = scaled(1.0), scaled(factor)
    assert_allclose(other.size, factor * usual.size)
    unit = other.length_scale
    one, two = usual.random(np.random.default_rng(3), 50), other.random(np.random.default_rng(3), 50)
    assert_allclose(two[:, :2], unit * one[:, :2])
    assert_allclose(two[:, 2:], one[:, 2:])
    T = other.pose(two)
    T[:, :2, 3] += 1000 * unit
    assert other.solve_poses(T).solved.all()
