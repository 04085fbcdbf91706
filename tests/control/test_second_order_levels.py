"""Levels whose inverse is SecondOrder are stepped in compiled code as by NumPy: steps, memories, whole motions."""

import copy
from dataclasses import dataclass

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits import Limit
from robust_ik.inverses.second_order import SecondOrderRun
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.second_order.second_order_layout import LAST, MEMORY_HEAD, memory_size
from tests.control.test_compiled_steps import LEAST_SPEED, LOOSE, NOISE, SAME, HeightTask, by_numpy
from tests.inverses.test_second_order import singular
from tests.soak import random_limits, random_stack, random_start

DT = 0.01
ROBOTS = {
    "ur5": {}, "puma560": {}, "panda": {}, "xarm7": {}, "kinova": {}, "tiago": {}, "pa10": {}, "planar_2r": {},
    "srs_10r": {}, "baxter": {"tip": "left_gripper"},
}  # fmt: skip
LIMITERS = (
    rik.Sliding(), rik.Saturation(), rik.QuadraticProgram(), rik.QuadraticProgram(keep_direction=True), rik.Scaling(),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class CurvedTask(rik.Task):
    """A task of a user with a Hessian, which is not there above a height."""

    height: float
    seen: float = np.inf

    def equation(self, robot, q, *, hessian=False):
        rows, z = ("x", "z"), robot.pose(q)[2, 3]
        error = np.array([0.1, self.height - z])
        H = robot.hessian(q, rows=rows) if hessian and z < self.seen else None
        return TaskEquation(robot.jacobian(q, rows=rows), 2 * error, error, H, self.weight, np.array([True, True]))


def random_resolver(rng, n):
    """One with the second-order inverse at all levels, or at some.

    SDLS is not among the others: where singular values are the same, as of a projected posture, its velocity depends on
    which of their vectors are taken.
    """
    inverse = rik.SecondOrder(float(rng.choice([0.08, 0.3])), *rng.choice([[0.5, 5.0], [2.0, 20.0]]).tolist())
    limiter, steady = LIMITERS[rng.integers(len(LIMITERS))], bool(rng.integers(2))
    return (
        rik.TaskPriority(inverse, limiter, steady=steady),
        rik.DecoupledPriority(inverse, limiter, steady=steady),
        rik.TaskPriority((inverse, rik.JParse()), limiter),
        rik.TaskPriority((rik.DampedLeastSquares(), inverse), limiter),
        rik.TaskPriority((inverse, rik.Weighted(rik.JParse(), np.linspace(1, 3, n))), limiter),
        rik.WeightedPriority(inverse, steady=steady),
    )[rng.integers(6)]


def all_kinds(robot, rng):
    """Tasks whose rows curve, or have no known curvature."""
    target = robot.pose(robot.random(rng))
    return [
        rik.FrameTask(target, gain=2.0),
        rik.FrameTask(target, reference="target", rows=("x", "wz"), weight=2.0),
        rik.FrameTask(target, frame=robot.frames[-2]),
        rik.RelativeTask(robot.tip, robot.frames[2], target),
        rik.RelativeTask(robot.tip, robot.frames[3], target, reference="target", rows=("y", "z", "wx")),
        rik.TwistTask(rng.normal(size=6), reference="local"),
        rik.TwistTask(0.1 * rng.normal(size=6)),
        rik.DirectionTask([0, 0, 1], rng.normal(size=3)),
        rik.ManipulabilityTask(threshold=10.0),
        rik.PostureTask(robot.rest),
        HeightTask(0.3),
        CurvedTask(0.3),
        CurvedTask(0.3, 0.4),
    ]


BLIND = (8, 10)
"""Places among these of tasks without a Hessian."""


def noise_of(controller, robot, q, stack, rng):
    """What changes of q as small as rounding make of the next step of a controller that NumPy steps."""
    found = []
    for _ in range(4):
        other = by_numpy(robot, controller.resolver, controller.limits, length_scale=controller.length_scale)
        other.reset(controller.qdot)
        other._driver, other.calming.memory[:] = copy.deepcopy(controller._driver), controller.calming.memory
        found.append(other.step(robot.integrate(q, NOISE * rng.normal(size=robot.n)), stack, DT).qdot)
    return np.abs(np.ptp(found, axis=0)).max()


def is_tall(robot, stack):
    """Whether a level has more rows than there are joints: which of its lost rows count is then up to rounding."""
    rows = [sum(len(task.equation(robot, robot.rest).xdot) for task in level) for level in stack]
    return max(rows) > robot.n


def off_by(one, other, robot, q, stack, steps, rng):
    """Relative differences of steps of two controllers from the same q, those that rounding makes left out."""
    found = []
    for _ in range(steps):
        noise = noise_of(other, robot, q, stack, rng)
        a, b = one.step(q, stack, DT).qdot, other.step(q, stack, DT).qdot
        size = max(LEAST_SPEED, np.abs(b).max())
        found.append(max(0.0, np.abs(a - b).max() - LOOSE * noise) / size)
        q, one.qdot = robot.integrate(q, DT * b), b
        if noise > SAME * size:
            break  # memories differ from here on
    return found


@pytest.mark.parametrize("name", ROBOTS)
def test_steps_of_runs_are_those_of_numpy(name, monkeypatch):
    robot, rng, off, made = rik.load(name, **ROBOTS[name]), np.random.default_rng(2), [], []
    for draw in range(20):
        resolver, limits = random_resolver(rng, robot.n), random_limits(robot, rng)
        q, stack = random_start(robot, limits, rng), random_stack(robot, rng)
        if draw % 2 and len(robot.rows) == 6:
            kinds = all_kinds(robot, rng)
            first = kinds[rng.integers(len(kinds))]
            stack = [[first], [kinds[i] for i in rng.choice(len(kinds), rng.integers(1, 3), replace=False)]]
        if is_tall(robot, stack) and len(robot.rows) == 6:
            continue
        scale, qdot = rng.choice([None, 0.3]), 0.1 * rng.normal(size=robot.n)
        one = rik.VelocityController(robot, resolver, limits, length_scale=scale)
        other = by_numpy(robot, resolver, limits, length_scale=scale)
        one.reset(qdot)
        other.reset(qdot)
        monkeypatch.setattr(one, "finish", lambda *given, finish=one.finish: made.append(1) or finish(*given))
        these = off_by(one, other, robot, q, stack, 12, rng)
        assert max(these) <= SAME, f"draw {draw}: {resolver}, {[[*map(type, level)] for level in stack]}"
        off += these
    assert np.median(off) < 1e-13
    assert len(made) < 0.15 * len(off)


@pytest.mark.parametrize("index", range(13))
@pytest.mark.parametrize("below", [False, True])
def test_every_kind_of_row_curves_as_in_numpy(index, below):
    """With a threshold so high that most rows are weak; without the Hessian, those that curve move otherwise."""
    robot, rng, off, bent = rik.load("xarm7"), np.random.default_rng(6), [], 0
    curves = not isinstance(all_kinds(robot, rng)[index], rik.ManipulabilityTask | rik.PostureTask | HeightTask)
    for draw in range(8):
        task, q, scale = all_kinds(robot, rng)[index], robot.random(rng), (None, 0.3)[draw % 2]
        place = rik.PositionTask(np.array([0.3, 0.2, 0.4]), rows=("x", "y"))
        tasks = [task] if curves else [task, place]
        stack = [[rik.OrientationTask(np.eye(3), rows=("wx", "wy"))], tasks] if below else [tasks]
        one, other = (
            make(robot, rik.SecondOrder(0.9), (), length_scale=scale) for make in (rik.VelocityController, by_numpy)
        )
        assert one.program(stack, DT) is not None
        off += off_by(one, other, robot, q, stack, 2, rng)
        flat = [copy.copy(each) for each in tasks]
        for each in flat:
            object.__setattr__(each, "equation", lambda *given, hessian=False, at=each.equation: at(*given))
        straight = by_numpy(robot, rik.SecondOrder(0.9), (), length_scale=scale).step(q, [*stack[:-1], flat], DT)
        one.reset()
        bent += np.abs(one.step(q, stack, DT).qdot - straight.qdot).max() > 1e-3
    assert max(off) <= SAME
    assert np.median(off) < 1e-13
    if index in BLIND:
        assert bent == 0, "of such a level no curvature is known at all"
    else:
        assert bent > 0


@pytest.mark.parametrize("name", ["ur5", "puma560", "panda", "xarm7"])
def test_motions_from_exactly_singular_configurations_end_where_those_of_numpy_do(name):
    """Where two ways cost the same, the side that is taken may be another one: the task is served alike."""
    robot, rng, ends = rik.load(name), np.random.default_rng(4), []
    limits = rik.JointLimits.of(robot, velocity=2.0, acceleration=20.0)
    for q, u in singular(robot, rng, 4):
        goal = np.array(robot.pose(q))
        goal[:3, 3] += 0.05 * u[:3]
        stack = [[rik.FrameTask(goal, gain=4.0, rows=("x", "y", "z") if robot.n == 6 else None)], [rik.PostureTask(q)]]
        off = []
        for make in (rik.VelocityController, by_numpy):
            controller, at = make(robot, rik.SecondOrder(), limits), q
            for _ in range(150):
                at = robot.integrate(at, DT * controller.step(at, stack, DT).qdot)
            off.append(np.linalg.norm(stack[0][0].equation(robot, at).error))
        ends.append(off)
    found, wanted = np.transpose(ends)
    np.testing.assert_allclose(found, wanted, rtol=1e-3, atol=1e-6)


def wrist(robot):
    """PUMA's wrist stretched, a stack that asks for what is lost there, and limits."""
    q = robot.configuration([0.2, -0.9, 1.0, 0.3, 0.0, 0.1])
    lost = rik.svd(robot.jacobian(q)).U[:, -1]
    return q, [[rik.TwistTask(0.4 * lost)], [rik.PostureTask(q)]], rik.JointLimits.of(robot, acceleration=20.0)


def run_of(controller, q, stack, steps):
    found = []
    for _ in range(steps):
        found.append(controller.step(q, stack, DT).qdot)
        q = controller.robot.integrate(q, DT * found[-1])
    return np.array(found)


def test_a_turn_goes_on_where_steps_of_numpy_take_turns_with_compiled_ones(monkeypatch):
    robot = rik.load("puma560")
    q, stack, limits = wrist(robot)
    wanted = run_of(by_numpy(robot, rik.SecondOrder(), limits), q, stack, 80)
    assert np.abs(wanted[:20]).max() < 1e-3 < 0.3 < np.abs(wanted[40:]).max(), "the wrist waits, then turns"
    mixed, count = rik.VelocityController(robot, rik.SecondOrder(), limits), iter(range(1000))
    step = mixed.compiled.step
    monkeypatch.setattr(mixed.compiled, "step", lambda *given: step(*given) if next(count) % 3 else None)
    np.testing.assert_allclose(run_of(mixed, q, stack, 80), wanted, atol=1e-9)


def test_a_turn_goes_on_after_another_stack_and_after_levels_lose_their_freedom():
    """Programs of several stacks, and equations with a row and a joint more, share one memory for each level."""
    robot = rik.load("panda")
    rng, q = np.random.default_rng(0), robot.configuration([0.3, 0.0, 0.1, -1.5, 0.0, 1.8, 0.2])
    frame, posture = rik.FrameTask(robot.pose(robot.random(rng))), rik.PostureTask(robot.rest)
    stacks = [
        [[frame], [rik.PositionTask(np.full(3, 0.4))]], [[rik.JointTask("panda_joint1", 0.0)], [frame]],
        [[rik.PositionTask(np.full(3, 0.3))], [posture]], [[posture], [frame]], [[frame]],
    ]  # fmt: skip
    one, other = rik.VelocityController(robot, rik.SecondOrder(0.3)), by_numpy(robot, rik.SecondOrder(0.3), None)
    for index in range(120):
        stack = stacks[(index // 3) % len(stacks)]
        a, b = one.step(q, stack, DT).qdot, other.step(q, stack, DT).qdot
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)
        q, one.qdot = robot.integrate(q, DT * b), b
        for level in range(len(stack)):
            runs = [each._driver.inverse_of(level) for each in (one, other)]
            assert runs[0]._shape == runs[1]._shape
            np.testing.assert_allclose(runs[0]._memory, runs[1]._memory, rtol=1e-7, atol=1e-9)


class SeenLate(Limit):
    """A speed limit of one joint that is asked for only where a step would break it."""

    def __init__(self, joint, most):
        self.joint, self.most = joint, most

    def bounds(self, robot, q, previous, dt):
        return Bounds.free(robot.n)

    def tightened(self, robot, q, qdot, dt, bounds):
        if qdot[self.joint] <= self.most + 1e-9:
            return None
        return bounds.within(Bounds.of_rows(-np.eye(robot.n)[[self.joint]], np.array([-self.most]), ("late",)))


@pytest.mark.parametrize("joint", [3, 4])
def test_steps_that_are_made_again_are_remembered_once(joint):
    """A step whose end a limit does not like is made again with the memory of the step before."""
    robot = rik.load("puma560")
    q, stack, limits = wrist(robot)
    late = SeenLate(joint, 0.05)
    one, other = (make(robot, rik.SecondOrder(), [limits, late]) for make in (rik.VelocityController, by_numpy))
    asked = late.tightened
    late.tightened, seen = lambda *given: seen.append(each := asked(*given)) or each, []
    found = run_of(one, q, stack, 80)
    assert sum(each is not None for each in seen) > 5
    np.testing.assert_allclose(found, run_of(other, q, stack, 80), atol=1e-9)
    assert one.program(stack, DT) is not None


def test_a_prepared_loop_remembers_what_numpy_has_made_of_some_steps(monkeypatch):
    """NumPy tries steps with a copy of what is remembered where a limit looks at their end."""
    robot = rik.load("puma560")
    q, stack, limits = wrist(robot)
    both = [limits, SeenLate(3, 0.5)]
    loop = rik.ControlLoop(rik.VelocityController(robot, rik.SecondOrder(), both), stack, DT)
    compiled, count, at = loop.controller.compiled, iter(range(1000)), q
    prepared = compiled.prepared
    monkeypatch.setattr(compiled, "step", lambda *_: None)
    monkeypatch.setattr(compiled, "prepared", lambda *given: prepared(*given) if next(count) % 3 else None)
    for qdot in run_of(by_numpy(robot, rik.SecondOrder(), both), q, stack, 80):
        np.testing.assert_allclose(loop.step(at), qdot, atol=1e-9)
        at = robot.integrate(at, DT * qdot)


def test_prepared_loops_and_many_runs_are_those_of_the_controller_to_the_bit():
    robot = rik.load("puma560")
    q, stack, limits = wrist(robot)
    controller = rik.VelocityController(robot, rik.SecondOrder(), limits)
    loop = rik.ControlLoop(controller, stack, DT)
    assert loop.compiled
    starts = [q, robot.rest, robot.configuration([0.2, -0.9, 1.0, 0.3, 0.02, 0.1]), q, robot.rest + 0.1]
    found = loop.runs(starts, 60, threads=2)
    for start, made in zip(starts, found.qdot):
        controller.reset()
        loop.reset()
        alone, at = run_of(controller, start, stack, 60), np.array(start)
        np.testing.assert_array_equal(made, alone)
        for wanted in alone:
            qdot = loop.step(at)
            np.testing.assert_array_equal(qdot, wanted)
            at = robot.integrate(at, DT * qdot)
    np.testing.assert_array_equal(found.qdot[0], found.qdot[3])


def test_a_refused_step_is_not_remembered():
    robot = rik.load("puma560")
    q, stack, limits = wrist(robot)
    controller = rik.VelocityController(robot, rik.SecondOrder(), limits)
    wanted, loop, at = run_of(controller, q, stack, 60), rik.ControlLoop(controller, stack, DT), q.copy()
    for index, qdot in enumerate(wanted):
        if index % 4 == 0:
            noted = loop._program.noted.copy()
            with pytest.raises(rik.InputError):
                loop.step(np.full(robot.nq, np.nan))
            loop.tasks[0][0].twist[0] += np.nan
            with pytest.raises(rik.InputError):
                loop.step(at)
            loop.tasks[0][0].twist[:] = stack[0][0].twist
            np.testing.assert_array_equal(loop._program.noted, noted)
        np.testing.assert_array_equal(loop.step(at), qdot)
        at = robot.integrate(at, DT * qdot)


def test_a_new_run_has_forgotten_the_turn():
    robot = rik.load("puma560")
    q, stack, limits = wrist(robot)
    controller = rik.VelocityController(robot, rik.SecondOrder(), limits)
    first = run_of(controller, q, stack, 50)
    controller.reset()
    np.testing.assert_array_equal(run_of(controller, q, stack, 50), first)


def test_what_has_no_compiled_form_is_left_to_numpy():
    robot, wide = rik.load("panda"), rik.load("baxter", tip="left_gripper", whole_tree=True)
    pose, second = rik.FrameTask(robot.pose(robot.rest)), rik.SecondOrder()

    @dataclass(frozen=True)
    class Own(rik.SecondOrder):
        """A user's."""

    for resolver, compiled in (
        (second, True),
        (rik.WeightedPriority((second, rik.JParse())), True),
        (rik.TaskPriority((second, rik.SDLS())), True),
        (rik.TaskPriority((second, rik.Halley())), False),
        (rik.TaskPriority((second, rik.FilteredInverse())), False),
        (rik.Weighted(second, task_weights=np.full(6, 2.0)), False),
        (Own(), False),
    ):
        made = rik.VelocityController(robot, resolver).program([[pose]], DT)
        assert (made is not None) == compiled, resolver
    for stack, compiled in (([[pose]] * 16, True), ([[pose]] * 17, False), ([[pose] * 2 + [HeightTask(0.3)]], True)):
        assert (rik.VelocityController(robot, second).program(stack, DT) is not None) == compiled
    both = rik.FrameTask(wide.pose(wide.rest, wide.tip))
    assert (rik.VelocityController(wide, second).program([[both]], DT) is not None) == (wide.n < 16)


@dataclass(frozen=True, eq=False)
class TinyTask(rik.Task):
    """Rows that hardly move, told to move fast."""

    def equation(self, robot, q, *, hessian=False):
        J, x = 1e-250 * np.eye(robot.n), np.full(robot.n, 1e90)
        return TaskEquation(J, x, x, np.zeros((robot.n,) * 3) if hessian else None)


@pytest.mark.parametrize("kind", [rik.TaskPriority, rik.DecoupledPriority, rik.WeightedPriority])
def test_velocities_that_are_no_numbers_are_refused(kind):
    robot = rik.load("planar_2r")
    for limits in ((), None):
        controller = rik.VelocityController(robot, kind(rik.SecondOrder()), limits)
        assert controller.program([[TinyTask()]], DT) is not None
        with pytest.raises(rik.InputError, match="too large"):
            controller.step(robot.rest, [[TinyTask()]], DT)


@pytest.mark.parametrize("shape", [(6, 7), (7, 8), (3, 7), (4, 8), (6, 6)])
def test_a_level_is_told_what_a_run_remembers_and_tells_it_back(shape, rng):
    """Of equations of its own shape, and with a row and a joint more, all of it; of others what SecondOrder keeps."""
    run, told = rik.SecondOrder().begin(DT), np.full(MEMORY_HEAD + memory_size(6, 7), np.nan)
    assert isinstance(run, SecondOrderRun)
    m, n = shape
    J, H = rng.normal(size=(m, n)), rng.normal(size=(m, n, n))
    run.velocity(TaskEquation(J, rng.normal(size=m), np.zeros(m), H))
    run._memory[:] = rng.normal(size=len(run._memory))
    if shape in ((7, 8), (4, 8)):  # the joint and the row beside do nothing
        run._memory[[LAST + n - 1, LAST + 2 * n - 1, -1]] = 0.0
    before = run._memory.copy()
    run.tell(6, 7, told)
    assert np.isfinite(told).all()
    assert tuple(told[:MEMORY_HEAD]) == shape
    if n >= 7:
        np.testing.assert_array_equal(told[MEMORY_HEAD + LAST :][:7], before[LAST : LAST + 7])
    run.remember(6, 7, told)
    assert run._shape == shape
    np.testing.assert_array_equal(run._memory, before)
