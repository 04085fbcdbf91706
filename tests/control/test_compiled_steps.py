"""A controller's steps in compiled code are those of NumPy, for every task, limiter, inverse and limit."""

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest

import robust_ik as rik
from robust_ik import checks
from robust_ik.control import bounds
from robust_ik.control.bounds import Bounds
from robust_ik.control.compiled_loop import control_program
from robust_ik.control.compiled_loop.control_program import form_of
from robust_ik.control.compiled_loop.resolver_program import is_compilable
from robust_ik.control.resolvers import task_reconstruction, weighted_priority
from robust_ik.control.tasks import measure_climbing, singular_value
from robust_ik.control.within_bounds import acceleration_ramp, active_set, bounded_qp, feasible_start, motion_cost
from robust_ik.control.within_bounds import level_fit as fit_by_numpy
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import level_fit, level_freedom, reconstructed_motion, resolve_levels, weighted_levels
from robust_ik.kernels.control.rows import climbing_rows, frame_motion, pose_rows
from robust_ik.kernels.within_bounds import feasible_start as compiled_start
from robust_ik.kernels.within_bounds import polyhedron_projection
from robust_ik.kinematics import svd
from tests.cases_resolvers import RESOLVERS
from tests.soak import random_limits, random_stack, random_start

ROBOTS = {
    "panda": {}, "ur5": {}, "ur10": {}, "xarm7": {}, "kinova": {}, "kinova_gen3": {}, "tiago": {}, "pa10": {},
    "puma560": {}, "planar_2r": {}, "srs_10r": {}, "baxter": {"tip": "left_gripper", "whole_tree": True},
}  # fmt: skip
DT = 0.01
SAME = 1e-9
"""Relative difference of joint velocities that counts as none."""
NOISE = 1e-13
"""Changes of q as small as rounding; where they change NumPy's own step, that step is no better determined."""
LOOSE = 30
"""Times what NOISE makes of NumPy's own step, by which steps may differ."""
DRAWS = 30
LEAST_SPEED = 1e-2
"""Velocities below this are compared absolutely, rad/s."""


@dataclass(frozen=True, eq=False)
class HeightTask(rik.Task):
    """A task of a user: it has no compiled form."""

    height: float
    gain: float = 1.0

    def equation(self, robot, q, *, hessian=False):
        error = np.array([self.height - robot.pose(q)[2, 3]])
        rows = robot.jacobian(q, rows=("x", "y", "z"))[2:]
        return TaskEquation(rows, self.gain * error, error, None, self.weight, np.array([True]))


def by_numpy(robot, resolver, limits, **named):
    """A controller whose steps NumPy makes."""
    controller = rik.VelocityController(robot, resolver, limits, **named)
    controller.compiled.step = lambda *_: None
    return controller


def is_eligible(resolver):
    """Whether a resolver's steps are compiled with most stacks."""
    curved = any(type(each) is rik.SecondOrder for each in resolver.inverses)
    return is_compilable(resolver) and (curved or not resolver.needs_hessian)


def step_of(make, robot, q, qdot, stack, dt=DT):
    controller = make(robot)
    controller.reset(qdot)
    return controller.step(q, stack, dt)


def noise_of(make, robot, q, qdot, stack, rng):
    """What changes of q as small as rounding make of NumPy's step."""
    steps = [
        step_of(make, robot, robot.integrate(q, NOISE * rng.normal(size=robot.n)), qdot, stack).qdot for _ in range(4)
    ]
    return np.abs(np.ptp(steps, axis=0)).max()


def assert_same(found, wanted, noise, where):
    size = max(LEAST_SPEED, np.abs(wanted.qdot).max())
    assert np.abs(found.qdot - wanted.qdot).max() <= SAME * size + noise, where
    if noise > SAME * size:
        return
    assert found.status is wanted.status, where
    assert found.active == wanted.active, where
    assert found.contradictions == wanted.contradictions, where
    for one, other in zip(found.levels, wanted.levels):
        np.testing.assert_allclose(one.residual, other.residual, rtol=1e-7, atol=1e-8 * max(1, size), err_msg=where)
        np.testing.assert_allclose(one.sigma, other.sigma, rtol=1e-9, atol=1e-10, err_msg=where)
        assert (one.corank, one.kinematic_corank) == (other.corank, other.kinematic_corank), where
        assert one.algorithmic == other.algorithmic, where


@pytest.mark.parametrize("name", ROBOTS)
def test_steps_are_those_of_numpy(name, monkeypatch):
    robot, rng, compiled = rik.load(name, **ROBOTS[name]), np.random.default_rng(5), 0
    eligible = 0
    for draw in range(DRAWS):
        resolver, limits = RESOLVERS[rng.integers(len(RESOLVERS))], random_limits(robot, rng)
        q, stack, qdot = random_start(robot, limits, rng), random_stack(robot, rng), 0.1 * rng.normal(size=robot.n)
        scale = rng.choice([None, 0.3])
        numpy = lambda robot: by_numpy(robot, resolver, limits, length_scale=scale)  # noqa: B023, E731
        noise = LOOSE * noise_of(numpy, robot, q, qdot, stack, rng)
        controller = rik.VelocityController(robot, resolver, limits, length_scale=scale)
        controller.reset(qdot)
        eligible += is_eligible(resolver)
        with monkeypatch.context() as watched:
            made = []
            watched.setattr(type(controller), "_within_shares", lambda _, *given, log=made: log.append(1) or given[-1])
            found = controller.step(q, stack, DT)
        compiled += not made
        wanted = step_of(numpy, robot, q, qdot, stack)
        assert_same(found, wanted, noise, f"draw {draw}: {resolver}, {[[*map(type, level)] for level in stack]}")
    assert compiled >= 0.75 * eligible > 0


RECONSTRUCTIONS = [
    rik.TaskReconstruction(bound=(1.0, 0.3)),
    rik.TaskReconstruction(rik.Chiaverini(), rik.Sliding(), bound=0.5, steady=True),
    rik.TaskReconstruction(rik.DampedLeastSquares(), rik.QuadraticProgram(), bound=2.0, compensate=False),
    rik.TaskReconstruction(rik.JParse(), rik.Saturation(), bound=5.0, printed_sign=True),
]


@pytest.mark.parametrize("name", ["panda", "kinova", "srs_10r", "baxter"])
def test_measures_below_their_bounds_are_kept_as_by_numpy(name, monkeypatch):
    """Bounds are so large that most measures are below them, with every kind of task that has a derivative."""
    robot, rng, seen = rik.load(name, **ROBOTS[name]), np.random.default_rng(1), []
    keep = task_reconstruction.TaskReconstruction._sparing
    monkeypatch.setattr(
        task_reconstruction.TaskReconstruction, "_sparing", lambda *given: seen.append(given[2]) or keep(*given)
    )
    for draw in range(24):
        resolver, limits = RECONSTRUCTIONS[draw % 4], random_limits(robot, rng)
        q, qdot = robot.random(rng), 0.1 * rng.normal(size=robot.n)
        near = robot.pose(robot.random(rng))
        tasks = [
            rik.FrameTask(near, gain=2.0, reference="target", rows=("x", "wz")),
            rik.FrameTask(near, rows=("x", "y", "z")),
            rik.TwistTask(rng.normal(size=6), reference="local", rows=("y", "wx")),
            rik.TwistTask(rng.normal(size=6), frame=robot.frames[-2], rows=("z",)),
            rik.DirectionTask([0, 0, 1], rng.normal(size=3), weight=2.0),
            rik.JointTask(robot.joint_names[0], 0.3),
        ]
        chosen = rng.choice(len(tasks), 4, replace=False)
        stack = [[tasks[chosen[0]]], [tasks[chosen[1]], tasks[chosen[2]]], [tasks[chosen[3]]]]
        scale = (None, 0.3)[draw % 2]
        numpy = lambda robot: by_numpy(robot, resolver, limits, length_scale=scale)  # noqa: B023, E731
        noise = LOOSE * noise_of(numpy, robot, q, qdot, stack, rng)
        wanted = step_of(numpy, robot, q, qdot, stack)
        controller = rik.VelocityController(robot, resolver, limits, length_scale=scale)
        controller.reset(qdot)
        before = len(seen)
        found = controller.step(q, stack, DT)
        assert len(seen) == before, "NumPy made the step"
        assert_same(found, wanted, noise, f"draw {draw}: {resolver}, {[[*map(type, level)] for level in stack]}")
    assert np.mean([any(each is not None for each in guards[:-1]) for guards in seen if len(guards) > 1]) > 0.1


def test_what_compiled_code_has_no_derivative_of_is_left_to_numpy():
    robot = rik.load("panda")
    pose, own = rik.FrameTask(robot.pose(robot.rest)), HeightTask(0.3)
    relative = rik.RelativeTask("panda_link7", "panda_link2", np.eye(4))
    for resolver, stack, compilable, compiled in (
        (rik.TaskReconstruction(), [[pose], [rik.ManipulabilityTask()]], True, True),
        (rik.TaskReconstruction(), [[pose], [relative]], True, False),
        (rik.TaskReconstruction(), [[own]], True, False),
        (rik.TaskReconstruction(shape=lambda share: share), [[pose]], False, False),
        (rik.WeightedPriority(), [[pose], [own]], True, True),
        (rik.WeightedPriority(rik.SDLS()), [[pose]], False, False),
    ):
        assert is_compilable(resolver) == compilable
        assert (rik.VelocityController(robot, resolver).program(stack, DT) is not None) == compiled


def test_joints_that_are_locked_stop_no_others():
    """Each of their bounds leaves no room, on both sides: what is left of a step beside them is rounding."""
    robot, rng, least = rik.load("baxter", **ROBOTS["baxter"]), np.random.default_rng(0), 0
    for _ in range(40):
        speeds = np.where(rng.random(robot.n) < 0.7, 0.0, 0.05)
        limits = rik.JointLimits.of(robot, velocity=speeds)
        target = robot.pose(robot.random(rng))
        stack = [[rik.FrameTask(target, gain=5.0)], [rik.PostureTask(robot.random(rng))]]
        for resolver in (rik.WeightedPriority(), rik.TaskPriority(limiter=rik.QuadraticProgram())):
            q = robot.random(rng)
            found = rik.VelocityController(robot, resolver, limits).step(q, stack, DT)
            wanted = by_numpy(robot, resolver, limits).step(q, stack, DT)
            np.testing.assert_allclose(found.qdot, wanted.qdot, rtol=1e-7, atol=1e-9)
            least += np.abs(wanted.qdot).max() > 0
    assert least >= 40


@pytest.mark.parametrize("acceleration", [np.inf, 5.0])
def test_steps_of_a_run_are_those_of_numpy_where_singular_configurations_are_crossed(acceleration):
    robot = rik.load("puma560")
    limits = rik.JointLimits.of(robot, velocity=2.0, acceleration=acceleration)
    stack = [[rik.TwistTask([0.0, 0.1, 0.0, 0.0, 0.3, 0.0])], [rik.PostureTask(robot.rest)]]
    found, wanted = rik.VelocityController(robot, None, limits), by_numpy(robot, None, limits)
    q = robot.configuration([0.2, -0.9, 1.0, 0.3, 0.0, 0.1])  # the wrist is singular
    for _ in range(100):
        one, other = found.step(q, stack, DT), wanted.step(q, stack, DT)
        np.testing.assert_allclose(one.qdot, other.qdot, rtol=1e-7, atol=1e-9)
        q = robot.integrate(q, DT * other.qdot)
        found.qdot = other.qdot


def test_every_task_of_the_package_has_a_compiled_form_but_those_with_a_memory():
    robot = rik.load("panda")
    kinds = [kind for name in dir(rik) if isinstance(kind := getattr(rik, name), type) and issubclass(kind, rik.Task)]
    assert len(kinds) > 12
    without = {kind for kind in kinds if "form" not in vars(kind)}
    assert without - {rik.Task} == {rik.Reach}
    assert form_of(HeightTask(0.3), robot) is None

    class Own(rik.FrameTask):
        def equation(self, robot, q, *, hessian=False):
            return super().equation(robot, q + 0.1, hessian=hessian)

    assert form_of(Own(robot.pose(robot.rest)), robot) is None  # its equation is another one


def test_rows_of_own_tasks_and_motions_of_inverses_that_are_no_formula_take_part():
    robot = rik.load("panda")
    stack = [[HeightTask(0.3, weight=2.0), rik.DampingTask(weight=0.1)], [rik.PostureTask(robot.rest, gain=3.0)]]
    for inverse in (rik.SDLS(), rik.Weighted(rik.JParse(), joint_weights=np.arange(1.0, 8.0)), rik.KelmarKhosla()):
        resolver = rik.TaskPriority(inverse)
        found, wanted = rik.VelocityController(robot, resolver), by_numpy(robot, resolver, None)
        q = robot.rest + 0.1
        for _ in range(5):
            one, other = found.step(q, stack, DT), wanted.step(q, stack, DT)
            assert_same(one, other, 0.0, str(inverse))
            q = robot.integrate(q, DT * one.qdot)
        program = found.compiled.program(q, [tuple(level) for level in stack], DT, found.begun(DT), found.calming)
        assert (program is None) == isinstance(inverse, rik.KelmarKhosla)  # which remembers


def test_a_task_may_change_its_targets_gains_and_weight_but_not_unseen_its_frame_or_rows():
    robot = rik.load("panda")
    first = rik.FrameTask(robot.pose(robot.rest), gain=2.0)
    target = robot.pose(robot.rest + 0.1)
    for later in (
        replace(first, target=target), replace(first, gain=7.0), replace(first, weight=3.0),
        replace(first, max_linear=1e-3),
        replace(first, feedforward=np.ones(6)), replace(first, rows=("x", "y")), replace(first, frame="panda_link5"),
        replace(first, reference="target"), rik.PositionTask(target[:3, 3]),
    ):  # fmt: skip
        controller = rik.VelocityController(robot)
        controller.step(robot.rest + 0.05, [[first], [rik.DampingTask()]], DT)
        found = controller.step(robot.rest + 0.05, [[later], [rik.DampingTask()]], DT)
        fresh = rik.VelocityController(robot)
        fresh.reset(found.qdot)
        wanted = rik.VelocityController(robot).step(robot.rest + 0.05, [[later], [rik.DampingTask()]], DT)
        np.testing.assert_array_equal(found.qdot, wanted.qdot)


def test_a_report_belongs_to_its_step_whenever_it_is_read():
    robot = rik.load("panda")
    controller, stack = rik.VelocityController(robot), [[rik.FrameTask(robot.pose(robot.rest + 0.3), gain=50.0)]]
    first = controller.step(robot.rest, stack, DT)
    later = controller.step(robot.rest + 0.2, stack, DT)
    wanted = by_numpy(robot, None, None).step(robot.rest, stack, DT)
    assert_same(first, wanted, 0.0, "first")
    assert first.text == wanted.text
    assert not np.array_equal(first.residual, later.residual)
    assert not first.qdot.flags.writeable
    copied = replace(first, qdot=later.qdot)
    assert copied.levels is first.levels


def test_bad_input_is_refused_as_by_numpy():
    robot = rik.load("panda")
    controller, stack = rik.VelocityController(robot), [[rik.FrameTask(robot.pose(robot.rest))]]
    controller.step(robot.rest, stack, DT)
    for bad in (np.full(7, np.nan), np.zeros(6), np.zeros((2, 7)), "q", np.full(7, np.inf)):
        with pytest.raises(rik.InputError):
            controller.step(bad, stack, DT)
    for dt in (0.0, -1.0, np.nan, "1"):
        with pytest.raises(rik.InputError, match="dt"):
            controller.step(robot.rest, stack, dt)
    np.testing.assert_array_equal(
        controller.step(robot.rest.tolist(), stack, DT).qdot, controller.step(robot.rest, stack, DT).qdot
    )
    np.testing.assert_array_equal(controller.step(np.repeat(robot.rest, 2)[::2], stack, DT).qdot, controller.qdot)


def test_programs_are_made_once_for_a_structure(monkeypatch):
    robot, made = rik.load("panda"), []
    of = control_program.ControlProgram.__init__
    monkeypatch.setattr(
        control_program.ControlProgram, "__init__", lambda self, *a, **k: made.append(1) or of(self, *a, **k)
    )
    controller = rik.VelocityController(robot)
    for i in range(6):
        frame = [rik.FrameTask(robot.pose(robot.rest + 0.01 * i), gain=1.0 + i)]
        stack = [frame] if i % 2 else [frame, [rik.PostureTask(robot.rest)]]
        controller.step(robot.rest, stack, DT)
    assert len(made) == 2


def test_two_frames_and_a_relative_task_of_a_tree_of_two_arms():
    robot = rik.load("baxter", tip="left_gripper", whole_tree=True)
    left, right = "left_gripper", "right_gripper"
    rng, q = np.random.default_rng(2), robot.rest
    goal = robot.configuration(robot.joint_values(q) + 0.2 * rng.normal(size=robot.n))
    both = np.linalg.inv(robot.pose(goal, left)) @ robot.pose(goal, right)
    stack = [
        [rik.RelativeTask(right, left, both, gain=5.0)],
        [rik.FrameTask(robot.pose(goal, left), frame=left), rik.PositionTask(np.ones(3), frame=right)],
        [rik.PostureTask(robot.rest)],
    ]  # fmt: skip
    assert_same(
        rik.VelocityController(robot).step(q, stack, DT),
        by_numpy(robot, None, None).step(q, stack, DT),
        0.0,
        "two arms",
    )


@dataclass(frozen=True, eq=False)
class Slower(rik.Limit):
    """A limit that asks for less speed on seeing where a step ends."""

    def bounds(self, robot, q, previous, dt):
        return Bounds.free(robot.n)

    def tightened(self, robot, q, qdot, dt, bounds):
        if np.isfinite(bounds.upper).any():
            return None
        most = 0.9 * np.abs(qdot) + 1e-3
        return replace(bounds, lower=-most, upper=most, lower_cause=np.full(7, "slow"), upper_cause=np.full(7, "slow"))


@pytest.mark.parametrize(
    "inverse", [rik.JParse(), rik.FilteredInverse(), rik.Weighted(rik.FilteredInverse()), rik.SDLS()]
)
def test_steps_that_are_made_again_are_not_remembered_and_their_last_bounds_are_told(inverse):
    robot = rik.load("panda")
    resolver = rik.TaskPriority(inverse)
    found, wanted = rik.VelocityController(robot, resolver, Slower()), by_numpy(robot, resolver, Slower())
    q, stack = robot.rest + 0.05, [[rik.FrameTask(robot.pose(robot.rest + 0.9), gain=5.0)]]
    for _ in range(10):
        one, other = found.step(q, stack, DT), wanted.step(q, stack, DT)
        np.testing.assert_allclose(one.qdot, other.qdot, rtol=1e-9, atol=1e-12)
        assert one.active == other.active
        q = robot.integrate(q, DT * one.qdot)
    assert "slow" in one.active


def test_any_number_of_levels_and_any_length_of_step_is_as_by_numpy():
    robot, resolver = rik.load("panda"), rik.TaskPriority(rik.JParse(), rik.Saturation())
    wide = [[rik.FrameTask(robot.pose(robot.rest + 0.9), gain=20.0)], [rik.PostureTask(robot.rest + 1)]]
    for stack in (wide, [*wide, *([rik.DampingTask()] for _ in range(20))]):
        found, wanted = rik.VelocityController(robot, resolver), by_numpy(robot, resolver, None)
        q = robot.rest
        for step in range(30):
            dt = (0.01, 0.001, 0.02)[step % 3]
            one, other = found.step(q, stack, dt), wanted.step(q, stack, dt)
            np.testing.assert_allclose(one.qdot, other.qdot, rtol=1e-8, atol=1e-10)
            q, found.qdot = robot.integrate(q, dt * other.qdot), other.qdot


def test_limits_that_are_set_hold_from_then_on():
    robot = rik.load("panda")
    controller, stack = rik.VelocityController(robot), [[rik.FrameTask(robot.pose(robot.rest + 0.1), gain=5.0)]]
    assert np.abs(controller.step(robot.rest, stack, DT).qdot).max() > 0.1
    controller.limits = rik.JointLimits.of(robot, velocity=0.01)
    assert np.abs(controller.step(robot.rest, stack, DT).qdot).max() <= 0.01 + 1e-9
    with pytest.raises(rik.InputError, match="limits must be limits"):
        controller.limits = [1.0]
    assert len(controller.limits) == 1


def test_a_report_may_be_read_by_many_threads():
    robot = rik.load("panda")
    controller, stack = rik.VelocityController(robot), [[rik.FrameTask(robot.pose(robot.rest + 0.1))]]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            for _ in range(50):
                step = controller.step(robot.rest, stack, DT)
                assert len({id(each) for each in pool.map(lambda _, step=step: step.status, range(4))}) == 1
    finally:
        sys.setswitchinterval(interval)
    with pytest.raises(AttributeError, match="no attribute 'speed'"):
        step.speed  # noqa: B018


def test_what_is_too_large_to_be_squared_is_refused():
    robot = rik.load("panda")
    controller, stack = rik.VelocityController(robot), [[rik.FrameTask(robot.pose(robot.rest))]]
    q = robot.rest.copy()
    q[2] = 1e200
    with pytest.raises(rik.InputError, match="1e\\+100"):
        controller.step(q, stack, DT)


def test_units_of_rows_belong_to_their_step():
    robot = rik.load("panda")
    limits, scale = rik.JointLimits.of(robot), 0.2

    @dataclass(frozen=True, eq=False)
    class Row(rik.Task):
        metres: bool

        def equation(self, robot, q, *, hessian=False):
            row = robot.jacobian(q, rows=("x", "y", "z"))[:1]
            return TaskEquation(row, np.ones(1), np.ones(1), None, 1.0, np.array([self.metres]))

    controller = rik.VelocityController(robot, None, limits, length_scale=scale)
    first, later = (controller.step(robot.rest, [[rik.DampingTask()], [Row(each)]], DT) for each in (True, False))
    assert first.levels[1].residual[0] == pytest.approx(1.0)
    assert later.levels[1].residual[0] == pytest.approx(1.0)


def test_a_task_that_does_not_fit_is_refused_at_every_step():
    robot = rik.load("panda")
    controller = rik.VelocityController(robot)
    controller.step(robot.rest, [[rik.PostureTask(robot.rest)]], DT)
    wrong = [[rik.PostureTask(np.zeros(3))]]
    for _ in range(2):
        with pytest.raises(rik.InputError, match="one configuration of panda"):
            controller.step(robot.rest, wrong, DT)
    assert np.abs(controller.step(robot.rest, [[rik.PostureTask(robot.rest)]], DT).qdot).max() < 1e-12


def test_numbers_that_kernels_repeat_are_those_of_numpy():
    """Kernels stand below what they are the compiled form of, and cannot import it."""
    assert level_freedom.RANK_TOLERANCE == svd.RANK_TOLERANCE
    assert level_freedom.LARGEST == frame_motion.LARGEST == checks.LARGEST_PARAMETER
    assert pose_rows.RIGID == checks.RIGID_TOLERANCE
    for name in ("SAME", "ROUNDING", "SHORT"):
        assert getattr(polyhedron_projection, name) == getattr(active_set, name)
    assert (level_fit.PRICE, level_fit.TURN, level_fit.HUGE) == (
        motion_cost.PRICE,
        fit_by_numpy.TURN,
        fit_by_numpy.HUGE,
    )
    assert pytest.approx(fit_by_numpy.SHARE_PRICE**-0.5, rel=1e-15) == level_fit.SHARE_SCALE
    assert level_fit.ROUNDING == bounds.ROUNDING
    assert level_fit.ALL_BUT == 1 - bounded_qp.ALL_BUT
    assert bounds.CONTRADICTION / 2 == compiled_start.SHORT
    for name in ("PRICE", "ROUNDS", "INSIDE"):
        assert getattr(compiled_start, name) == getattr(feasible_start, name)
    assert resolve_levels.EVEN == acceleration_ramp.EVEN
    assert weighted_levels.REGULARISATION == bounded_qp.REGULARISATION
    assert weighted_levels.LEAST == weighted_priority.LEAST
    assert (reconstructed_motion.SMALL, reconstructed_motion.DEPENDENT) == (task_reconstruction.SMALL, svd.DEPENDENT)
    assert (climbing_rows.FADE, climbing_rows.CLUSTER) == (measure_climbing.FADE, singular_value.CLUSTER)
