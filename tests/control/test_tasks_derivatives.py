"""Every task's Jacobian against differences of its error, its Hessian against differences of its Jacobian."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import (
    DampingTask,
    DirectionTask,
    FrameTask,
    JointTask,
    OrientationTask,
    PositionTask,
    PostureTask,
    RelativeTask,
    TwistTask,
)
from tests.screws import rotation

# 6 and 7 joints, continuous joints, few joints, a mimic joint that moves the tip, whole trees.
ARMS = ["ur5", "panda", "pa10", "kinova", "so101", "planar_3r", "panda+panda_rightfinger", "pr2+r_gripper_tool_frame"]
TREES = {
    "baxter": ("left_gripper", "right_gripper"),
    "pr2": ("l_gripper_tool_frame", "r_gripper_tool_frame"),
    "talos": ("gripper_left_fingertip_1_link", "wrist_right_ft_tool_link"),
    "icub": ("l_gripper", "r_hand"),
    "panda": ("panda_leftfinger", "panda_link3"),
}
WEIGHT = 3.0
ROTATIONS = ("wx", "wy", "wz")


@cache
def load(name):
    name, _, tip = name.partition("+")
    return rik.load(name, tip or None)


@cache
def whole(name):
    return rik.load(name, whole_tree=True)


def at(robot, where, rng):
    """A random configuration, or all joints at zero, which is singular for most arms."""
    return robot.random(rng) if where == "random" else robot.neutral


def sides(robot, q, h):
    unit = h * np.eye(robot.n)
    return [(robot.integrate(q, dq), robot.integrate(q, -dq)) for dq in unit]


def check_derivatives(task, robot, q, *, h=1e-6):
    """J = −∂error/∂q where the error is small, hessian = ∂J/∂q; the equation's shapes fit each other."""
    equation = task.equation(robot, q, hessian=True)
    assert equation.weight == WEIGHT
    assert task.equation(robot, q).hessian is None
    around = [(task.equation(robot, ahead), task.equation(robot, behind)) for ahead, behind in sides(robot, q, h)]
    slope = np.stack([(ahead.error - behind.error) / (2 * h) for ahead, behind in around], axis=-1)
    assert_allclose(equation.J, -slope, atol=2e-8)
    bend = np.stack([(ahead.J - behind.J) / (2 * h) for ahead, behind in around], axis=-1)
    assert_allclose(equation.hessian, bend, atol=2e-8)


def tasks_at(T, frame):
    """Tasks that are met, or nearly so, where the frame is at T."""
    R, p = T[:3, :3], T[:3, 3]
    shifted = T.copy()
    shifted[:3, 3] += (0.3, -0.2, 0.1)
    common = {"frame": frame, "weight": WEIGHT}
    return [
        FrameTask(shifted, rows=("x", "y", "z", *ROTATIONS), **common),
        FrameTask(shifted, rows=("wy", "x", "wx"), **common),
        FrameTask(shifted, rows=("x", "y", "z", "wx", "wy"), reference="target", **common),
        FrameTask(shifted, rows=("z", "wx", "wz"), reference="target", **common),
        PositionTask(p + (1.0, 2.0, -0.5), rows=("z", "x"), **common),
        OrientationTask(R, rows=ROTATIONS, **common),
        OrientationTask(R, rows=("wy", "wz"), reference="target", **common),
        OrientationTask(R @ rotation((0, 0, 1), 2.5), rows=("wx", "wy"), reference="target", **common),
        DirectionTask((0, 0, 2), R[:, 2] * 5, **common),
        DirectionTask((1, 2, -3), R @ (1, 2, -3), **common),
    ]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("where", ["random", "singular"])
def test_jacobians_and_hessians_of_tasks_on_a_frame_agree_with_differences(name, where, rng):
    robot = load(name)
    q = at(robot, where, rng)
    for frame in (None, robot.frames[len(robot.frames) // 2]):
        for task in tasks_at(robot.pose(q, frame), frame):
            check_derivatives(task, robot, q)


@pytest.mark.parametrize("name", TREES)
def test_two_tips_of_a_tree_have_tasks_of_their_own(name, rng):
    robot = whole(name)
    q = robot.random(rng)
    for frame in TREES[name]:
        for task in tasks_at(robot.pose(q, frame), frame):
            check_derivatives(task, robot, q)


@pytest.mark.parametrize("name", TREES)
@pytest.mark.parametrize("where", ["random", "singular"])
@pytest.mark.parametrize(
    "choice",
    [{}, {"rows": ("x", "z", "wy")}, {"rows": ("x", "y", "z", "wx", "wz"), "reference": "target"}],
    ids=["all rows", "some rows", "target's axes"],
)
def test_relative_jacobians_and_hessians_agree_with_differences(name, where, choice, rng):
    robot = whole(name)
    q = at(robot, where, rng)
    for frame, root in (TREES[name], TREES[name][::-1]):
        target = np.linalg.inv(robot.pose(q, root)) @ robot.pose(q, frame)
        target[:3, 3] += (0.1, 0.2, -0.3)
        check_derivatives(RelativeTask(frame, root, target, weight=WEIGHT, **choice), robot, q)


def test_a_motion_of_both_arms_together_leaves_the_relative_pose(rng):
    robot = whole("talos")
    q = robot.random(rng)
    J = RelativeTask(*TREES["talos"], np.eye(4)).equation(robot, q).J
    torso = [i for i, name in enumerate(robot.joint_names) if "torso" in name or "leg" in name or "head" in name]
    assert len(torso) > 10
    assert_allclose(J[:, torso], 0, atol=1e-12)
    assert np.linalg.matrix_rank(J) == 6


def test_the_relative_task_seen_from_the_fixed_base_is_the_frame_task(rng):
    robot = load("panda")
    q, target = robot.random(rng), robot.pose(robot.random(rng))
    arguments = {"gain": 2.0, "max_linear": 0.1, "max_angular": 0.2, "feedforward": rng.normal(size=6)}
    relative = RelativeTask(robot.tip, "panda_link0", target, **arguments).equation(robot, q, hessian=True)
    plain = FrameTask(target, **arguments).equation(robot, q, hessian=True)
    for name in ("J", "xdot", "error", "hessian"):
        assert_allclose(getattr(relative, name), getattr(plain, name), atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_joint_tasks_agree_with_differences(name, rng):
    robot = load(name)
    q = robot.random(rng)
    near = robot.integrate(q, 0.1 * rng.normal(size=robot.n))
    some = robot.joint_names[::-2]
    check_derivatives(PostureTask(near, weight=WEIGHT), robot, q)
    check_derivatives(PostureTask(near, joints=some, weight=WEIGHT), robot, q)
    check_derivatives(JointTask(some, np.full(len(some), 0.3), weight=WEIGHT), robot, q)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("reference", ["local", "local_world_aligned"])
def test_a_twist_task_moves_the_frame_by_its_twist(name, reference, rng):
    robot = load(name)
    q, twist = robot.random(rng), rng.normal(size=6)
    rows = ("x", "z", "wy")
    task = TwistTask(twist, reference=reference, rows=rows, weight=WEIGHT)
    equation = task.equation(robot, q, hessian=True)
    assert_allclose(equation.J, robot.jacobian(q, reference=reference, rows=rows))
    assert_allclose(equation.xdot, twist[[0, 2, 4]])
    assert not equation.error.any()
    bend = [
        (task.equation(robot, ahead).J - task.equation(robot, behind).J) / 2e-6
        for ahead, behind in sides(robot, q, 1e-6)
    ]
    assert_allclose(equation.hessian, np.stack(bend, axis=-1), atol=2e-8)


def test_a_damping_task_wants_joints_at_rest():
    robot = load("panda")
    equation = DampingTask(weight=WEIGHT).equation(robot, robot.rest, hessian=True)
    assert_allclose(equation.J, np.eye(7))
    assert not equation.xdot.any()
    assert not equation.hessian.any()
    assert equation.weight == WEIGHT
    assert_allclose(DampingTask(joints="panda_joint3").equation(robot, robot.rest).J, np.eye(7)[[2]])
