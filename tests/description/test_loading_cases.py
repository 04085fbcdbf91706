"""Small robots as people have them, in tests/data: what loads, with which note, and that it moves as Pinocchio says."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik

DATA = Path(__file__).parents[1] / "data"

# File: independent joints, tip given, tip taken, part of a note (None where there is nothing to note).
CASES = {
    "colour_of_three": (6, None, "a_tool", "a colour of 3 numbers"),
    "negative_radius_visual": (6, None, "a_tool", "cylinder that needs radius"),
    "reversed_limits_finger": (6, "a_tool", "a_tool", "joint 'fing': has its limits reversed"),
    "reversed_limits_mimic": (6, "a_tool", "a_tool", "joint 'fing2': has its limits reversed"),
    "xml_blank_line_first": (6, None, "a_tool", "very beginning"),
    "xml_latin1_name": (6, None, "a_tool", "Windows-1252 (Latin-1)"),
    "xml_undeclared_prefix": (6, None, "a_tool", "<sensor:ray>"),
    "zero_zero_limits": (6, None, "a_tool", "joint 'a_j1': has position limits 0 and 0"),
    "locked_joint": (6, None, "a_tool", None),
    "five_dof": (5, None, "tool", None),
    "follower_before_source": (3, None, "tool", None),
    "gantry3p": (3, None, "z", None),
    "gantry_wrist": (6, None, "tool", None),
    "gimbal_3r": (3, None, "cam", None),
    "lead_screw_mimic": (4, None, "tool", "joint 'motor': has limits -50 to 50 rad: are they degrees?"),
    "one_p": (1, None, "x", None),
    "palletiser_mimic": (4, None, "tool", None),
    "scara": (4, None, "tool", None),
    "pan_tilt": (2, None, "cam", "its links span 0.08 m"),
    "pan_tilt_centred": (2, None, "cam", None),
    "gimbal_turned_mount": (3, None, "y", None),
    "one_r": (1, None, "tip", None),
    "tiny_arm_mm": (6, None, "a_tool", "its links span 0.00103 m"),
    "lengths_rounded_6r": (6, None, "l6", None),
    "lift_and_telescope": (6, None, "l8", None),
    "torso_and_arm_8r": (8, None, "l10", None),
    "mobile_drive_1000": (8, None, "a_tool", None),
    "mobile_drive_999999": (8, None, "a_tool", None),
}


def test_every_small_robot_has_its_line_here():
    assert {path.stem for path in DATA.glob("*.urdf")} == {*CASES, "xacro_unexpanded"}


@pytest.mark.parametrize("name", CASES)
def test_a_small_robot_loads_and_says_what_was_amiss(name, rng):
    n, given, tip, note = CASES[name]
    path = DATA / f"{name}.urdf"
    robot = rik.load(path, tip=given)
    assert (robot.n, robot.tip) == (n, tip)
    assert len(robot.notes) == (note is not None)
    assert note is None or note in robot.notes[0]
    assert rik.Robot.from_urdf(path, tip=given).notes == robot.notes
    text = path.read_bytes().decode("latin-1")
    model = pin.buildModelFromXML(text)
    q = robot.random(rng)
    positions = pin.neutral(model)
    joints = robot.description.joints
    for joint in joints:
        driver = robot.description.driver[joint.name]
        if joint.kind != "fixed" and driver.source in robot.joint_names:
            value = q[robot.joint_names.index(driver.source)] * driver.multiplier + driver.offset
            positions[model.joints[model.getJointId(joint.name)].idx_q] = value
    data = model.createData()
    pin.framesForwardKinematics(model, data, positions)
    assert_allclose(robot.pose(q), data.oMf[model.getFrameId(tip, pin.FrameType.BODY)].homogeneous, atol=1e-12)


def test_explicit_limits_of_zero_leave_the_joint_unlimited():
    robot = rik.load(DATA / "zero_zero_limits.urdf")
    assert (robot.lower[0], robot.upper[0]) == (-np.inf, np.inf)


def test_a_locked_joint_keeps_its_one_value():
    robot = rik.load(DATA / "locked_joint.urdf")
    assert robot.lower[0] == robot.upper[0] == robot.rest[0] == 0.4


def test_unexpanded_xacro_is_refused_with_what_to_do():
    with pytest.raises(rik.UrdfError, match=r"xacro that was not expanded: line \d+ has xyz='\$\{w\}.*'xacro FILE > "):
        rik.load(DATA / "xacro_unexpanded.urdf")
