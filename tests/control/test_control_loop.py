"""ControlLoop: the steps of a controller, prepared."""

import copy
import gc
import pickle
import tracemalloc
from dataclasses import dataclass, replace

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.inverses.task_equation import TaskEquation

DT = 0.01
ROBOT = rik.load("panda")
GOAL = ROBOT.pose(ROBOT.configuration(ROBOT.joint_values(ROBOT.rest) + 0.3))
STACK = [[rik.FrameTask(GOAL, gain=5.0, max_linear=0.1)], [rik.PostureTask(ROBOT.rest)]]


@dataclass(frozen=True, eq=False)
class HeightTask(rik.Task):
    height: float

    def equation(self, robot, q, *, hessian=False):
        error = np.array([self.height - robot.pose(q)[2, 3]])
        return TaskEquation(robot.jacobian(q, rows=("z",)), error, error, None, self.weight)


def run_of(controller, stack, steps=100):
    """Velocities of a run of a controller."""
    q, found = ROBOT.rest.copy(), []
    for _ in range(steps):
        found.append(controller.step(q, stack, DT).qdot)
        q = ROBOT.integrate(q, DT * found[-1])
    return np.array(found)


def run_of_loop(loop, steps=100):
    q, found, qdot = ROBOT.rest.copy(), [], np.empty(ROBOT.n)
    for _ in range(steps):
        assert loop.step(q, qdot) is qdot
        found.append(qdot.copy())
        q = ROBOT.integrate(q, DT * qdot)
    return np.array(found)


LIMITS = {
    "joints": rik.JointLimits.of(ROBOT),
    "acceleration": rik.JointLimits.of(ROBOT, acceleration=2.0),
    "none": (),
    "collisions": [rik.JointLimits.of(ROBOT), rik.CollisionLimit.of(ROBOT)],
    "collisions first": [rik.CollisionLimit.of(ROBOT), rik.JointLimits.of(ROBOT)],
}
RESOLVERS = {
    "default": None,
    "saturation": rik.TaskPriority(rik.DampedLeastSquares(), rik.Saturation()),
    "no formula": rik.TaskPriority(rik.SDLS()),
    "memory": rik.TaskPriority(rik.FilteredInverse()),
    "hessians": rik.TaskReconstruction(bound=0.05),
    "weighted": rik.WeightedPriority(),
}


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("resolver", RESOLVERS)
def test_its_steps_are_those_of_the_controller(resolver, limits):
    controller = rik.VelocityController(ROBOT, RESOLVERS[resolver], LIMITS[limits])
    for stack in (STACK, [[HeightTask(0.3), rik.DampingTask(weight=0.1)], [rik.PostureTask(ROBOT.rest)]]):
        loop = rik.ControlLoop(controller, stack, DT)
        np.testing.assert_array_equal(run_of_loop(loop, 40), run_of(controller, stack, 40))
        controller.reset()
        assert loop.report.status in rik.Status
    plain = resolver in ("default", "saturation", "hessians", "weighted") and "collisions" not in limits
    assert rik.ControlLoop(controller, STACK, DT).compiled == plain


def test_its_last_steps_are_remembered_for_acceleration_limits_and_for_reset():
    controller = rik.VelocityController(ROBOT, None, LIMITS["acceleration"])
    loop = rik.ControlLoop(controller, STACK, DT)
    first = run_of_loop(loop, 30)
    assert np.abs(np.diff(first, axis=0)).max() <= 2.0 * DT + 1e-9
    assert not np.array_equal(run_of_loop(loop, 30), first)  # in motion
    loop.reset()
    np.testing.assert_array_equal(run_of_loop(loop, 30), first)
    loop.reset(np.full(7, 0.1))
    assert np.abs(loop.step(ROBOT.rest) - 0.1).max() <= 2.0 * DT + 1e-9


NUMBERS = [
    (rik.FrameTask(GOAL), {"target": ROBOT.pose(ROBOT.rest), "gain": 3.0, "max_linear": 0.01, "max_angular": 0.2,
                           "feedforward": np.arange(6) / 10, "weight": 2.0}),
    (rik.FrameTask(GOAL, reference="target", rows=("x", "y", "wx", "wz")), {"target": ROBOT.pose(ROBOT.rest)}),
    (rik.RelativeTask(ROBOT.tip, "panda_link3", np.eye(4)), {"target": GOAL, "feedforward": np.ones(6), "gain": 2.0}),
    (rik.PositionTask(GOAL[:3, 3]), {"target": [0.3, 0.1, 0.5], "feedforward": [0.1, 0.0, 0.2], "gain": 9.0}),
    (rik.OrientationTask(GOAL[:3, :3]), {"target": np.eye(3), "feedforward": [0.1, 0.0, 0.2], "max_angular": 0.1}),
    (rik.TwistTask(np.zeros(6)), {"twist": np.arange(6) / 5, "weight": 3.0}),
    (rik.DirectionTask([0, 0, 1], [1, 0, 0]), {"axis": [0.6, 0.8, 0], "direction": [0, 1, 0], "gain": 4.0}),
    (rik.PostureTask(ROBOT.rest), {"target": ROBOT.rest + 0.1, "max_speed": 0.05, "gain": 2.0}),
    (rik.JointTask(ROBOT.joint_names[2], 0.1), {"target": [0.4], "gain": 3.0}),
    (rik.JointRangeTask(margin=0.45), {"gain": 3.0, "max_speed": 0.1}),
    (rik.SingularValueTask(), {"gain": 2.0, "threshold": 0.9, "max_speed": 0.2}),
    (rik.ManipulabilityTask(threshold=0.5), {"threshold": 0.3, "weight": 2.0}),
    (rik.DampingTask(), {"weight": 4.0}),
]  # fmt: skip


@pytest.mark.parametrize("task, numbers", NUMBERS, ids=lambda each: type(each).__name__)
def test_what_is_set_in_place_is_what_a_new_task_would_have(task, numbers):
    rest = rik.DampingTask(weight=0.3)
    q, controller = ROBOT.rest + 0.05, rik.VelocityController(ROBOT)
    loop = rik.ControlLoop(controller, [[task, rest]], DT)
    for name, value in numbers.items():
        setattr(loop.tasks[0][0], name, value)
        np.testing.assert_array_equal(getattr(loop.tasks[0][0], name), value)
    wanted = controller.step(q, [[replace(task, **numbers), rest]], DT)
    np.testing.assert_array_equal(loop.step(q), wanted.qdot)
    # NumPy makes the step with the same numbers.
    loop.reset()
    loop.controller.compiled.step = lambda *_: None
    loop._run = lambda *_: -1
    np.testing.assert_allclose(loop.step(q), wanted.qdot, rtol=1e-9, atol=1e-12)


def test_targets_of_continuous_joints_are_joint_values():
    robot = rik.load("kinova")
    stack = [[rik.PostureTask(robot.rest, joints=robot.joint_names[:3])]]
    loop, values = rik.ControlLoop(rik.VelocityController(robot), stack, DT), robot.joint_values(robot.rest)
    values[:3] += 0.4
    loop.tasks[0][0].target[:] = values[:3]
    wanted = rik.VelocityController(robot).step(
        robot.rest, [[replace(stack[0][0], target=robot.configuration(values))]], DT
    )
    np.testing.assert_allclose(loop.step(robot.rest), wanted.qdot, atol=1e-12)
    loop._run = lambda *_: -1
    loop.reset()
    np.testing.assert_allclose(loop.step(robot.rest), wanted.qdot, atol=1e-12)


def test_what_cannot_be_set_is_refused_and_nothing_is_changed():
    loop = rik.ControlLoop(rik.VelocityController(ROBOT), [*STACK, [HeightTask(0.3)]], DT)
    task = loop.tasks[0][0]
    before = task.target.copy()
    for name, value in (("gain", 0.0), ("gain", np.nan), ("target", np.eye(3)), ("target", "x"), ("weight", np.inf)):
        with pytest.raises(rik.InputError, match=name):
            setattr(task, name, value)
    with pytest.raises(rik.InputError, match="feedforward"):
        task.feedforward = np.full(6, np.nan)
    with pytest.raises(AttributeError, match="'frame' can be set of FrameTask"):
        task.frame = "panda_link3"
    with pytest.raises(AttributeError, match="HeightTask has no compiled form"):
        loop.tasks[2][0].height = 2.0
    np.testing.assert_array_equal(task.target, before)
    assert "target" in dir(task)


def test_what_is_no_number_and_no_pose_is_refused_in_a_step():
    loop, out = rik.ControlLoop(rik.VelocityController(ROBOT), STACK, DT), np.zeros(7)
    with pytest.raises(rik.InputError, match="before a step"):
        loop.report  # noqa: B018
    for bad in (np.full(7, np.nan), np.zeros(6), np.zeros((7, 1)), "q"):
        with pytest.raises(rik.InputError):
            loop.step(bad, out)
    for wrong in (np.zeros(6), np.zeros(7, dtype=np.float32), np.zeros((2, 7))[:, 0], [0.0] * 7):
        with pytest.raises(rik.InputError, match="out"):
            loop.step(ROBOT.rest, wrong)
    target = loop.tasks[0][0].target
    for bad in (np.nan, 2.0):
        target[0, 0] = bad
        with pytest.raises(rik.InputError, match="target"):
            loop.step(ROBOT.rest, out)
        assert not out.any()
    target[:] = GOAL
    twist = rik.ControlLoop(rik.VelocityController(ROBOT), [[rik.TwistTask(np.zeros(6))]], DT)
    twist.tasks[0][0].twist[3] = np.inf
    with pytest.raises(rik.InputError, match="twist"):
        twist.step(ROBOT.rest)
    direction = rik.ControlLoop(rik.VelocityController(ROBOT), [[rik.DirectionTask([0, 0, 1], [0, 1, 0])]], DT)
    direction.tasks[0][0].direction[0] = 1.0  # not of length 1 any more: NumPy makes it so
    wanted = rik.VelocityController(ROBOT).step(ROBOT.rest, [[rik.DirectionTask([0, 0, 1], [1, 1, 0])]], DT).qdot
    np.testing.assert_allclose(direction.step(ROBOT.rest), wanted, atol=1e-12)


def test_a_refused_step_has_no_report_and_leaves_the_run_as_it_was():
    loop, q = rik.ControlLoop(rik.VelocityController(ROBOT, None, LIMITS["acceleration"]), STACK, DT), ROBOT.rest + 0.1
    twin = rik.ControlLoop(loop.controller, STACK, DT)
    loop.step(q)
    twin.step(q)
    loop.tasks[1][0].target[:] = np.nan
    with pytest.raises(rik.InputError, match="target"):
        loop.step(q + 1)
    with pytest.raises(rik.InputError, match="refused"):
        loop.report  # noqa: B018
    loop.tasks[1][0].target[:] = ROBOT.rest
    np.testing.assert_array_equal(loop.step(q), twin.step(q))
    loop.tasks[0][0].target[3] = 7.0
    with pytest.raises(rik.InputError, match="rigid"):
        loop.step(q)
    with pytest.raises(AttributeError):
        loop.dt = 0.1


def test_caps_may_be_infinite_in_many_runs():
    loop = rik.ControlLoop(rik.VelocityController(ROBOT), STACK, DT)
    free = loop.runs(STARTS[:2], 3, numbers={(0, 0): {"max_linear": [np.inf, 0.1]}})
    capped = loop.runs(STARTS[:2], 3)
    assert not np.array_equal(free.q[0], capped.q[0])
    np.testing.assert_array_equal(free.q[1], capped.q[1])


def test_other_arrays_than_contiguous_doubles_are_converted():
    loop = rik.ControlLoop(rik.VelocityController(ROBOT), STACK, DT)
    wanted = loop.step(ROBOT.rest)
    for q in (ROBOT.rest.tolist(), np.repeat(ROBOT.rest, 2)[::2], tuple(ROBOT.rest)):
        loop.reset()
        np.testing.assert_array_equal(loop.step(q), wanted)


def test_a_step_allocates_nothing():
    loop, q, out = rik.ControlLoop(rik.VelocityController(ROBOT), STACK, DT), ROBOT.rest.copy(), np.empty(7)
    loop.step(q, out)
    gc.collect()
    gc.disable()
    tracemalloc.start()
    try:
        before = tracemalloc.take_snapshot()
        for _ in range(1000):
            loop.step(q, out)
        after = tracemalloc.take_snapshot()
    finally:
        tracemalloc.stop()
        gc.enable()
    ours = [each for each in after.compare_to(before, "filename") if "robust_ik" in each.traceback[0].filename]
    assert sum(each.size_diff for each in ours) < 1000  # not one number a step


def test_it_drives_a_task_that_remembers():
    reach = rik.Reach(GOAL, gain=5.0, max_linear=0.2, max_angular=1.0)
    loop, q = rik.ControlLoop(rik.VelocityController(ROBOT), reach, DT), ROBOT.rest.copy()
    assert not loop.compiled
    for _ in range(600):
        q = ROBOT.integrate(q, DT * loop.step(q))
    assert reach.state == "arrived"


def test_it_takes_a_controller():
    with pytest.raises(rik.InputError, match="must be a VelocityController"):
        rik.ControlLoop(ROBOT, STACK, DT)
    with pytest.raises(rik.InputError, match="dt"):
        rik.ControlLoop(rik.VelocityController(ROBOT), STACK, 0.0)


RNG = np.random.default_rng(3)
STARTS, TARGETS = ROBOT.random(RNG, 6), ROBOT.pose(ROBOT.random(RNG, 6))


def test_many_runs_are_the_runs_one_by_one_to_the_bit_on_any_number_of_threads():
    for limits in ("joints", "acceleration"):
        for resolver in ("default", "saturation"):
            controller = rik.VelocityController(ROBOT, RESOLVERS[resolver], LIMITS[limits])
            loop, steps = rik.ControlLoop(controller, STACK, DT), 90
            numbers = {(0, 0): {"target": TARGETS}, (1, 0): {"gain": np.full(6, 2.0)}}
            found, threaded = (loop.runs(STARTS, steps, every=10, numbers=numbers, threads=each) for each in (1, 4))
            np.testing.assert_array_equal(found.q, threaded.q)
            np.testing.assert_allclose(found.time, DT * np.arange(10, 91, 10))
            assert found.q.shape == found.qdot.shape == (6, 9, 7)
            for run, (q, target) in enumerate(zip(STARTS, TARGETS)):
                alone = rik.ControlLoop(controller, STACK, DT)
                alone.tasks[0][0].target, alone.tasks[1][0].gain = target, 2.0
                for _ in range(steps):
                    qdot = alone.step(q)
                    q = q + DT * qdot
                np.testing.assert_array_equal(found.final_q[run], q)
                np.testing.assert_array_equal(found.q[run, -1], q)
                np.testing.assert_array_equal(found.qdot[run, -1], qdot)
            np.testing.assert_array_equal(loop.tasks[0][0].target, GOAL)  # the loop's own is what it was


UR5, KINOVA = rik.load("ur5"), rik.load("kinova")
STRAIGHT = np.zeros(6)
"""The UR5 stretched out: singular at the elbow and at the wrist."""
JPARSE = rik.JParse(0.01)


def frame(robot, **more):
    return rik.FrameTask(robot.pose(robot.rest), gain=4.0, max_linear=0.3, **more)


def posture(robot):
    return rik.PostureTask(robot.rest)


def among_singular(robot, count, singular):
    """Starts anywhere, every third one near or at a singular configuration; the last one at rest."""
    rng = np.random.default_rng(5)
    starts = robot.random(rng, count)
    starts[::3] = singular + 10.0 ** -rng.uniform(2, 14, size=(len(starts[::3]), 1)) * rng.normal(size=robot.n)
    starts[0], starts[-1] = singular, robot.rest
    return starts


def among_limits(robot, count):
    """Starts anywhere, every other one with joints at their ends; the last one at rest."""
    rng = np.random.default_rng(6)
    starts = robot.random(rng, count)
    ends = np.where(rng.random((len(starts[1::2]), robot.n)) < 0.5, robot.lower, robot.upper)
    starts[1::2] = np.where(rng.random(ends.shape) < 0.4, ends, starts[1::2])
    starts[-1] = robot.rest
    return starts


COMPANY = {
    "limits": (ROBOT, None, [[frame(ROBOT)], [posture(ROBOT)]], {}),
    "acceleration": (ROBOT, None, [[frame(ROBOT)], [posture(ROBOT)]], {"acceleration": 3.0}),
    "nearest": (
        ROBOT, rik.TaskPriority(JPARSE, rik.QuadraticProgram(), steady=True), [[frame(ROBOT)], [posture(ROBOT)]], {},
    ),
    "scaling": (ROBOT, rik.TaskPriority(JPARSE, rik.Scaling()), [[frame(ROBOT)], [posture(ROBOT)]], {}),
    "ranks": (UR5, None, [[frame(UR5)], [posture(UR5)]], {}),
    "pseudo-inverse": (UR5, rik.TaskPriority(rik.MoorePenrose()), [[frame(UR5)], [posture(UR5)]], {}),
    "stopped": (
        UR5, rik.TaskPriority(JPARSE, rik.Scaling()),
        [[rik.FrameTask(UR5.pose(STRAIGHT))], [rik.PostureTask(UR5.rest, gain=50.0)]], {},
    ),
    "decoupled": (UR5, rik.DecoupledPriority(JPARSE), [[frame(UR5, rows=("x", "wz"))], [posture(UR5)]], {}),
    "three levels": (
        ROBOT, None, [[rik.PositionTask(GOAL[:3, 3])], [rik.OrientationTask(GOAL[:3, :3])], [posture(ROBOT)]], {},
    ),
    "upwards": (UR5, None, [[rik.SingularValueTask(max_speed=0.3)], [posture(UR5)]], {}),
    "several": (UR5, None, [[frame(UR5, rows=("z",)), rik.DampingTask(weight=0.1)], [posture(UR5)]], {}),
}  # fmt: skip


@pytest.mark.parametrize("count", [11, 10, 3])
@pytest.mark.parametrize("case", COMPANY)
def test_runs_in_company_are_to_the_bit_what_they_are_alone(case, count):
    """Eight go side by side: what limits, ranks, noise or their own end do to one of them is nothing to the others."""
    robot, resolver, stack, limits = COMPANY[case]
    starts = among_singular(robot, count, STRAIGHT) if robot is UR5 else among_limits(robot, count)
    loop = rik.ControlLoop(rik.VelocityController(robot, resolver, rik.JointLimits.of(robot, **limits)), stack, DT)
    assert loop.compiled
    gains = {(len(stack) - 1, 0): {"gain": np.linspace(0.5, 3.0, count), "weight": np.geomspace(0.1, 3.0, count)}}
    for more in ({"numbers": gains}, {"noise": 1e-3, "lag": 0.03}):
        company = loop.runs(starts, 60, every=7, **more)
        alone = loop.runs(starts, 60, every=7, threads=count, **more)
        for name in ("q", "qdot", "final_q"):
            np.testing.assert_array_equal(getattr(company, name), getattr(alone, name))


def test_steps_that_numpy_has_to_make_take_part_in_many_runs():
    """At a singular configuration the way up is left to NumPy."""
    robot = rik.load("ur5")
    stack = [[rik.SingularValueTask(max_speed=0.3)], [rik.PostureTask(robot.rest)]]
    loop, q = rik.ControlLoop(rik.VelocityController(robot), stack, DT), np.zeros(6)
    found = loop.runs(np.array([q, robot.rest]), 20, every=5)
    assert loop.compiled
    for _ in range(20):
        q = robot.integrate(q, DT * loop.step(q))
    np.testing.assert_allclose(found.final_q[0], q, atol=1e-12)


def test_noise_and_lag_of_many_runs():
    controller = rik.VelocityController(ROBOT, calm=False)
    loop = rik.ControlLoop(controller, [[rik.PostureTask(ROBOT.rest, gain=10.0)]], DT)
    noise, starts = 1e-3, np.repeat(ROBOT.rest[None], 200, axis=0)
    found = loop.runs(starts, 100, noise=noise)
    # With gain g and perfect drives, q ← q − g dt (q + e): its variance is noise² g dt / (2 − g dt).
    wanted = noise * np.sqrt(0.1 / 1.9)
    assert np.std(found.q[:, -1] - ROBOT.rest) == pytest.approx(wanted, rel=0.1)
    assert abs(np.mean(found.q[:, 50:] - ROBOT.rest)) < wanted / 10
    np.testing.assert_array_equal(loop.runs(starts[:1], 100, noise=noise).q, found.q[:1])
    assert not np.array_equal(loop.runs(starts[:1], 100, noise=noise, seed=1).q, found.q[:1])
    lagging = loop.runs(starts[:1] + 0.1, 100, lag=0.05)
    first = 0.1 * (1 - (1 - np.exp(-DT / 0.05)) * 10.0 * DT)
    np.testing.assert_allclose(lagging.q[0, 0] - ROBOT.rest, first, rtol=1e-9)


def test_many_runs_of_continuous_joints_keep_their_circles():
    robot = rik.load("kinova")
    loop = rik.ControlLoop(rik.VelocityController(robot), [[rik.FrameTask(robot.pose(robot.rest), gain=3.0)]], DT)
    starts = robot.random(np.random.default_rng(1), 3)
    found, q = loop.runs(starts, 50, every=50), starts[1]
    for _ in range(50):
        q = robot.integrate(q, DT * loop.step(q))
    np.testing.assert_allclose(found.final_q[1], q, atol=1e-9)
    robot.joint_values(found.final_q)  # all are configurations


def test_what_many_runs_cannot_take_is_refused():
    loop = rik.ControlLoop(rik.VelocityController(ROBOT), STACK, DT)
    for bad in (
        {"q": ROBOT.rest}, {"q": STARTS[:, :6]}, {"q": STARTS * np.nan}, {"steps": 0}, {"every": 0}, {"threads": 0},
        {"noise": -1.0}, {"lag": np.nan}, {"seed": -1}, {"numbers": {(0, 3): {}}}, {"numbers": {0: {}}},
        {"numbers": {(0, 0): {"target": GOAL}}}, {"numbers": {(0, 0): {"frame": ["a"] * 6}}}, {"numbers": [3]},
        {"numbers": {(0, 0): 3}}, {"numbers": {(0, 0): {"gain": np.full(6, -5.0)}}}, {"q": STARTS[:0]},
        {"numbers": {(0, 0): {"weight": np.zeros(6)}}}, {"numbers": {(0, 0): {"gain": np.full(6, np.inf)}}},
        {"numbers": {(0, 0): {"gain": np.ones((2, 6))}}}, {"numbers": {(0, 0): {"target": TARGETS[None]}}},
    ):  # fmt: skip
        with pytest.raises(rik.InputError):
            loop.runs(**{"q": STARTS, "steps": 3, **bad})
    with pytest.raises(rik.InputError, match="from outside"):
        rik.ControlLoop(rik.VelocityController(ROBOT), [[HeightTask(0.3)]], DT).runs(STARTS, 3)
    with pytest.raises(rik.InputError, match="rigid"):
        loop.runs(STARTS, 3, numbers={(0, 0): {"target": np.full((6, 4, 4), 2.0)}})


def test_a_reset_keeps_the_tasks_that_one_holds():
    loop = rik.ControlLoop(rik.VelocityController(ROBOT, RESOLVERS["saturation"]), STACK, DT)
    target = loop.tasks[0][0].target
    loop.step(ROBOT.rest)
    loop.reset()
    with pytest.raises(rik.InputError, match="before a step"):
        loop.report  # noqa: B018
    target[:] = ROBOT.pose(ROBOT.rest)
    assert np.abs(loop.step(ROBOT.rest)).max() < 1e-9


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))])
@pytest.mark.parametrize("limits", ["acceleration", "collisions"])
def test_a_copy_has_memory_of_its_own(copied, limits):
    controller = rik.VelocityController(ROBOT, RESOLVERS["saturation"], LIMITS[limits])
    loop = rik.ControlLoop(controller, STACK, DT)
    loop.tasks[0][0].gain = 3.0
    for _ in range(3):
        q = loop.step(ROBOT.rest)
        controller.step(ROBOT.rest, STACK, DT)
    if copied is not copy.copy:  # of a controller it shares everything, as for any object
        twin = copied(controller)
        twin.step(ROBOT.rest + 0.5, STACK, DT)
        wanted = controller.step(ROBOT.rest, STACK, DT).qdot
        np.testing.assert_array_equal(copied(controller).qdot, wanted)
    other = copied(loop)
    other.tasks[0][0].target[:] = ROBOT.pose(ROBOT.rest)
    q = loop.step(ROBOT.rest)
    assert other.tasks[0][0].gain == 3.0
    np.testing.assert_array_equal(loop.tasks[0][0].target, GOAL)
    assert np.abs(other.step(ROBOT.rest)).max() < np.abs(q).max()
    del loop, controller
    gc.collect()
    assert np.isfinite(other.step(ROBOT.rest)).all()
    assert "target" in dir(copied(other.tasks[0][0]))
