"""What tasks on positions, rotations, directions and joints ask for: gains, caps, short ways, what they refuse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import (
    DampingTask,
    DirectionTask,
    FrameTask,
    JointRangeTask,
    JointTask,
    ManipulabilityTask,
    OrientationTask,
    PositionTask,
    PostureTask,
    RelativeTask,
    Task,
    TwistTask,
)
from robust_ik.inverses.task_equation import TaskEquation
from tests.screws import rotation


def descend(robot, q, task, steps=200, dt=0.05):
    """Where pseudoinverse control with the task alone leads."""
    for _ in range(steps):
        equation = task.equation(robot, q)
        q = robot.integrate(q, dt * np.linalg.pinv(equation.J) @ equation.xdot)
    return q, task.equation(robot, q)


def test_position_and_orientation_are_the_two_halves_of_the_frame_task(rng):
    robot = rik.load("panda")
    q, target = robot.random(rng), robot.pose(robot.random(rng))
    whole = FrameTask(target, 2.0, 0.1, 0.2, np.arange(6.0)).equation(robot, q, hessian=True)
    position = PositionTask(target[:3, 3], 2.0, 0.1, np.arange(3.0)).equation(robot, q, hessian=True)
    turn = OrientationTask(target[:3, :3], 2.0, 0.2, np.arange(3.0, 6.0)).equation(robot, q, hessian=True)
    for name in ("J", "xdot", "error", "hessian"):
        both = np.concatenate([getattr(position, name), getattr(turn, name)])
        assert_allclose(both, getattr(whole, name), atol=1e-12)


@pytest.mark.parametrize("angle", [0.5, np.pi / 2, 3.1, np.pi])
def test_a_direction_is_reached_along_a_straight_decay_from_anywhere(angle):
    robot = rik.load("panda")
    axis = robot.pose(robot.rest)[:3, :3] @ (0, 0, 1)
    task = DirectionTask((0, 0, 3), rotation((1, 0, 0), angle) @ axis)
    assert_allclose(np.linalg.norm(task.equation(robot, robot.rest).error), angle, atol=1e-9)
    q, equation = descend(robot, robot.rest, task)
    assert_allclose(robot.pose(q)[:3, 2], task.direction, atol=1e-3)
    assert_allclose(np.linalg.norm(equation.error), angle * 0.95**200, rtol=0.2)


def test_direction_and_joint_speeds_are_capped():
    robot = rik.load("panda")
    down = DirectionTask((0, 0, 1), (0, 0, 1), gain=4.0, max_angular=0.1).equation(robot, robot.rest)
    assert_allclose(np.linalg.norm(down.xdot), 0.4)
    posture = PostureTask(robot.rest + np.linspace(-1, 1, 7), gain=2.0, max_speed=0.5).equation(robot, robot.rest)
    assert_allclose(posture.xdot, np.clip(2 * np.linspace(-1, 1, 7), -0.5, 0.5), atol=1e-12)
    assert_allclose(posture.error, np.linspace(-1, 1, 7), atol=1e-12)
    joint = JointTask("panda_joint2", 9.0, gain=2.0, max_speed=0.3).equation(robot, robot.rest)
    assert_allclose(joint.xdot, 0.3)
    assert_allclose(joint.J, np.eye(7)[[1]])


def test_continuous_joints_go_the_short_way_round():
    robot = rik.load("kinova")
    start, end = (robot.configuration([angle, *[1.0] * 5]) for angle in (3.0, -3.0))
    short = 2 * np.pi - 6
    assert_allclose(PostureTask(end).equation(robot, start).error, [short, *[0] * 5], atol=1e-12)
    name = robot.joint_names[0]
    for turns in (0, 1, -2):
        assert_allclose(JointTask(name, -3.0 + turns * 2 * np.pi).equation(robot, start).error, [short], atol=1e-12)


def test_joints_in_the_outer_parts_of_their_ranges_are_asked_back_and_others_to_rest():
    robot = rik.load("kinova")  # continuous joints among others
    ends = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    assert 0 < ends.sum() < robot.n
    lower, upper = robot.lower[ends], robot.upper[ends]
    for share, back in ((0.1, 0.2), (0.5, 0.0), (0.3, 0.0), (0.95, -0.25), (1.2, -0.5)):
        values = np.full(robot.n, 2.0)
        values[ends] = lower + share * (upper - lower)
        equation = JointRangeTask(margin=0.3, gain=2.0).equation(robot, robot.configuration(values))
        assert_allclose(equation.error[ends], back * (upper - lower), atol=1e-12)
        assert_allclose(equation.error[~ends], 0.0)
        assert_allclose(equation.xdot, 2.0 * equation.error)
        assert_allclose(equation.J, np.eye(robot.n))
    capped = JointRangeTask(max_speed=0.1).equation(robot, robot.configuration(values))
    assert_allclose(capped.xdot[ends], -0.1)


@pytest.mark.parametrize("name", ["panda", "xarm7"])
def test_what_keeps_joints_in_their_ranges_leaves_the_tool_alone_and_brings_none_further_out(name, rng):
    robot = rik.load(name)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    for _ in range(3):
        q = robot.configuration(np.where(rng.random(robot.n) < 0.5, 0.97, 0.5) * (upper - lower) + lower)
        target, first = robot.pose(q), np.linalg.norm(JointRangeTask().equation(robot, q).error)
        controller, before = rik.VelocityController(robot), first
        for _ in range(1500):
            step = controller.step(q, [[FrameTask(target, gain=5.0)], [JointRangeTask()]], 0.02)
            q = robot.integrate(q, 0.02 * step.qdot)
            outside = np.linalg.norm(JointRangeTask().equation(robot, q).error)
            assert outside <= before + 1e-9
            assert np.linalg.norm(rik.pose_error(robot.pose(q), target)) < 1e-3
            before = outside
        assert before < first


def test_joint_tasks_name_their_joints_in_the_order_given():
    robot = rik.load("panda")
    equation = JointTask(["panda_joint5", "panda_joint1"], [0.5, 0.1]).equation(robot, np.zeros(7))
    assert_allclose(equation.error, [0.5, 0.1])
    assert_allclose(equation.J, np.eye(7)[[4, 0]])
    posture = PostureTask(np.arange(7.0), joints=("panda_joint5", "panda_joint1")).equation(robot, np.zeros(7))
    assert_allclose(posture.error, [4, 0])


def test_planar_arms_have_position_rows_of_their_own():
    robot = rik.load("planar_3r")
    equation = PositionTask((0.1, 5.0, 0.2)).equation(robot, robot.rest)
    assert equation.J.shape == (2, 3)
    assert_allclose(equation.J, robot.jacobian(robot.rest))
    with pytest.raises(rik.InputError, match="some of wx wy wz"):
        OrientationTask(np.eye(3)).equation(robot, robot.rest)
    assert OrientationTask(np.eye(3), rows=("wy",)).equation(robot, robot.rest).J.shape == (1, 3)


def test_a_task_of_ones_own_needs_one_method():
    class Height(Task):
        def equation(self, robot, q, *, hessian=False):
            error = 0.5 - robot.pose(q)[2:3, 3]
            return TaskEquation(robot.jacobian(q, rows=("z",)), error, error, None, self.weight)

    robot = rik.load("panda")
    q, _ = descend(robot, robot.rest, Height(weight=2.0))
    assert_allclose(robot.pose(q)[2, 3], 0.5, atol=1e-4)
    with pytest.raises(TypeError, match="abstract"):
        Task()
    with pytest.raises(rik.InputError, match="weight must be > 0"):
        Height(weight=-1.0)


def test_two_arms_meet(rng):
    robot = rik.load("baxter", whole_tree=True)
    target = np.eye(4)
    target[:3, :3], target[:3, 3] = rotation((1, 0, 0), np.pi), (0, 0, 0.2)
    task = RelativeTask("left_gripper", "right_gripper", target, gain=1.0, max_linear=0.2, max_angular=0.5)
    q, _ = descend(robot, robot.random(rng), task, steps=400)
    seen = np.linalg.inv(robot.pose(q, "right_gripper")) @ robot.pose(q, "left_gripper")
    assert_allclose(seen, target, atol=1e-3)


T, R = np.eye(4), np.eye(3)


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: PositionTask(np.zeros(2)), "target must have shape"),
        (lambda: PositionTask(np.zeros((2, 3))), "target must be one vector"),
        (lambda: PositionTask([0, np.nan, 0]), "finite"),
        (lambda: PositionTask(np.zeros(3), rows=("wx",)), "rows must be some of x y z,"),
        (lambda: PositionTask(np.zeros(3), gain=-1), "gain must be > 0"),
        (lambda: OrientationTask(T), "target must have shape"),
        (lambda: OrientationTask(np.diag([1.0, 1, -1])), "rigid"),
        (lambda: OrientationTask(R, rows=["x"]), "rows must be some of wx wy wz,"),
        (lambda: OrientationTask(R, reference="tool"), "reference must be"),
        (lambda: DirectionTask(np.zeros(3), (0, 0, 1)), "axis must not be zero"),
        (lambda: DirectionTask((0, 0, 1), np.zeros(3)), "direction must not be zero"),
        (lambda: RelativeTask("a", "a", T), "two frames"),
        (lambda: RelativeTask("a", None, T), "root must be the name"),
        (lambda: RelativeTask("a", "b", T, reference="world axes"), "'root axes' or 'target'"),
        (lambda: JointRangeTask(margin=0.5), "margin must be > 0 and < 0.5"),
        (lambda: JointRangeTask(gain=0.0), "gain must be > 0"),
        (lambda: JointRangeTask(joints=()), "joints must be names"),
        (lambda: PostureTask(np.zeros((2, 7))), "target must be one vector"),
        (lambda: PostureTask(np.zeros(7), max_speed=0), "max_speed must be > 0"),
        (lambda: PostureTask(np.zeros(7), joints=()), "joints must be names"),
        (lambda: PostureTask(np.zeros(7), joints=("a", "a")), "each at most once"),
        (lambda: JointTask(None, 1.0), "joints must be names"),
        (lambda: JointTask(["a", "b"], 1.0), "one value for each of a, b"),
        (lambda: JointTask("a", np.inf), "finite"),
        (lambda: JointTask(["a", "b"], [1.0, [2.0]]), "real numbers"),
        (lambda: DampingTask(joints=3), "joints must be names"),
        (lambda: TwistTask(np.zeros(3)), "twist must have shape"),
        (lambda: TwistTask(np.zeros(6), reference="world"), "reference must be 'local_world_aligned' or 'local'"),
    ],
)
def test_what_cannot_be_meant_is_refused(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()


@pytest.mark.parametrize(
    "task, error, match",
    [
        (PositionTask(np.zeros(3), frame="hand"), rik.FrameNotFoundError, "no frame 'hand'; .*there are"),
        (RelativeTask("panda_hand", "panda_link99", T), rik.FrameNotFoundError, "panda_link9"),
        (JointTask("panda_joint8", 0.0), rik.FrameNotFoundError, "no independent joint 'panda_joint8'; did you mean"),
        (DampingTask(joints=("elbow",)), rik.FrameNotFoundError, "there are: panda_finger_joint1, panda_joint1"),
        (JointTask("panda_finger_joint2", 0.0), rik.FrameNotFoundError, "follows 'panda_finger_joint1'"),
        (PostureTask(np.zeros(6)), rik.InputError, r"one configuration of panda, \(8,\), got shape \(6,\)"),
        (PositionTask(np.zeros(3)), rik.TipError, "without a tip"),
    ],
)
def test_what_does_not_fit_the_robot_is_refused_with_what_exists(task, error, match):
    robot = rik.load("panda", whole_tree=True)
    with pytest.raises(error, match=match):
        task.equation(robot, robot.rest)


@pytest.mark.parametrize(
    "task",
    [
        FrameTask(T),
        PositionTask(np.zeros(3)),
        OrientationTask(R),
        DirectionTask((0, 0, 1), (0, 0, 1)),
        RelativeTask("panda_hand", "panda_link1", T),
        JointRangeTask(),
        PostureTask(np.zeros(7)),
        JointTask("panda_joint1", 0.0),
        TwistTask(np.zeros(6)),
        ManipulabilityTask(),
    ],
    ids=lambda task: type(task).__name__,
)
def test_several_configurations_at_once_are_refused(task):
    with pytest.raises(rik.InputError, match=r"one configuration, \(nq,\), got shape \(2, 7\)"):
        task.equation(rik.load("panda"), np.zeros((2, 7)))
