"""Closed loops on bases that move: they reach, keep what limits say, and come to rest."""

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.urdf import parse_urdf
from robust_ik.description.urdf.mobile_joints import MOST_PITCH

DT, STEPS = 0.02, 1000
"""Twenty seconds: at a gain of 2/s the way to the target then is a thousandth of a micrometre."""


def closed(robot, stack, inverse, q=None, steps=STEPS):
    """Configurations and velocities of a closed loop."""
    controller = rik.VelocityController(robot, inverse, limits=rik.JointLimits.of(robot))
    q, found = robot.rest if q is None else q, []
    for _ in range(steps):
        step = controller.step(q, stack, DT)
        q = robot.integrate(q, DT * step.qdot)
        found.append((q, step.qdot))
    return tuple(map(np.array, zip(*found)))


@pytest.mark.parametrize("inverse", [rik.JParse(), rik.DampedLeastSquares()], ids=repr)
@pytest.mark.parametrize("base", ["planar", "floating"])
@pytest.mark.parametrize("name", ["ur5", "panda"])
def test_a_stack_reaches_a_pose_metres_away_and_rests(name, base, inverse, rng):
    robot = rik.load(name, base=base)
    target = robot.pose(robot.random(rng)).copy()
    target[:2, 3] += [3.0, -2.0]
    stack = [[rik.FrameTask(target, gain=2.0)], [rik.PostureTask(robot.rest, gain=1.0)]]
    q, qdot = closed(robot, stack, inverse)
    assert_allclose(robot.pose(q[-1]), target, atol=1e-5)
    size = np.linalg.norm(qdot, axis=1)
    assert size[-50:].max() < 0.02
    assert size[-50:].max() < size[-300:-250].max() + 1e-6
    values = robot.joint_values(q)
    assert (values >= robot.lower - 1e-9).all()
    assert (values <= robot.upper + 1e-9).all()


def test_speed_limits_of_a_base_hold(rng):
    text = ('<robot name="r"><link name="a"/><link name="b"/><joint name="base" type="planar"><parent link="a"/>'
            '<child link="b"/><axis xyz="0 0 1"/><limit velocity="0.3" effort="1"/></joint></robot>')  # fmt: skip
    robot = rik.Robot.from_description(parse_urdf(text), rows=("x", "y", "wz"))
    target = robot.pose(robot.configuration([2.0, 1.0, 2.5]))
    q, qdot = closed(robot, [[rik.FrameTask(target, gain=2.0, rows=("x", "y", "wz"))]], rik.JParse())
    assert np.abs(qdot).max() <= 0.3 + 1e-12
    assert_allclose(robot.joint_values(q[-1]), [2.0, 1.0, 2.5], atol=1e-6)
    assert np.abs(qdot[-1]).max() < 1e-6


def test_a_body_that_floats_stops_at_the_limit_of_its_pitch_and_rests():
    text = ('<robot name="r"><link name="a"/><link name="b"/><joint name="base" type="floating"><parent link="a"/>'
            '<child link="b"/><limit velocity="1" effort="1"/></joint></robot>')  # fmt: skip
    robot = rik.Robot.from_description(parse_urdf(text))
    target = np.eye(4)
    target[:3, :3], target[:3, 3] = pin.rpy.rpyToMatrix(0.2, np.pi / 2, 0.3), [1.0, 2.0, 3.0]
    q, qdot = closed(robot, [[rik.FrameTask(target, gain=2.0)]], rik.JParse())
    values = robot.joint_values(q)
    assert np.abs(values[:, 4]).max() <= MOST_PITCH + 1e-12
    assert_allclose(values[-1, 4], MOST_PITCH, atol=1e-3)
    assert_allclose(values[-1, :3], [1.0, 2.0, 3.0], atol=1e-3)
    assert np.abs(qdot[-1]).max() < 1e-3


def test_a_compiled_loop_makes_the_steps_of_the_controller(rng):
    robot = rik.load("ur5", base="planar")
    target = robot.pose(robot.random(rng)).copy()
    target[:2, 3] += 2.0
    stack = [[rik.FrameTask(target, gain=2.0)], [rik.PostureTask(robot.rest, gain=1.0)]]
    _, qdot = closed(robot, stack, rik.JParse(), steps=50)
    controller = rik.VelocityController(robot, rik.JParse(), limits=rik.JointLimits.of(robot))
    loop = rik.ControlLoop(controller, stack, DT)
    assert loop.compiled
    q = robot.rest
    for each in qdot:
        v = loop.step(q)
        assert_allclose(v, each, atol=1e-9)
        q = robot.integrate(q, DT * v)


@pytest.mark.parametrize("kind, pairs", [("planar", 0), ("floating", 1)])
def test_what_drives_on_a_floor_touches_it_and_what_floats_above_may_not(kind, pairs):
    """A floor, and a box that the joint moves; as the arm of a robot they would be neighbours, which may touch."""
    box = '<link name="{}"><collision><geometry><box size="1 1 1"/></geometry></collision></link>'
    text = f'''<robot name="r">{box.format("floor")}{box.format("car")}<joint name="base" type="{kind}">
        <parent link="floor"/><child link="car"/><origin xyz="0 0 2"/><axis xyz="0 0 1"/></joint></robot>'''
    limit = rik.CollisionLimit.of(rik.Robot.from_description(parse_urdf(text)))
    assert len(limit.pairs) == pairs
    assert [each.reason for each in limit.ignored] == ["adjacent"] * (1 - pairs)
