"""Task reconstruction: measures of manipulability stay above their bounds (P12). Kim's runs: test_paper_kim."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers.task_reconstruction import measure_gradient, smooth
from robust_ik.control.within_bounds.null_space import Freedom
from robust_ik.inverses.task_equation import TaskEquation

BOUND = 0.06
SINGLE = rik.TaskReconstruction(rik.MoorePenrose(), bound=BOUND)


# ------------------------------------------------------------------------------------------------ sign of eq. (22)
@pytest.mark.parametrize("q", [[0.3, 0.05, 0.05], [0.3, 0.03, -0.02]])
def test_the_corrected_sign_climbs_to_half_the_bound_and_the_printed_one_falls_into_the_singularity(q):
    """Nothing is asked; the start is below the bound."""
    robot = rik.load("planar_3r")
    stay = rik.TwistTask(np.zeros(6))
    climbing = rik.simulate(robot, SINGLE, stay, q, duration=1.0, dt=2e-3)
    falling = rik.simulate(robot, replace(SINGLE, printed_sign=True), stay, q, duration=0.03, dt=1e-4)
    start = climbing.manipulability[0, 0]
    assert start < BOUND / 2
    assert_allclose(climbing.manipulability[-1, 0], BOUND / 2, atol=2e-3)
    assert (np.diff(climbing.manipulability[:, 0]) > -1e-12).all()
    assert falling.manipulability.min() < start / 10


# ---------------------------------------------------------------------------------------------------- families
@pytest.mark.parametrize("name", ["planar_3r", "panda", "xarm7", "pa10"])
def test_the_measure_of_a_task_never_falls_below_half_its_bound(name, rng):
    """P12, up to what a step of 1 ms makes of curvature; toward targets anywhere, also out of reach."""
    robot = rik.load(name)
    samples = robot.random(rng, 200)
    bound = 0.5 * float(np.median(rik.manipulability(robot.jacobian(samples))))
    good = samples[rik.manipulability(robot.jacobian(samples)) > bound]
    for q in good[:3]:
        target = robot.pose(robot.random(rng))
        target[:3, 3] *= rng.choice([1.0, 3.0])
        task = rik.FrameTask(target, gain=2.0, max_linear=0.3, max_angular=0.5)
        resolver = rik.TaskReconstruction(bound=bound)
        stack = [[task], [rik.PostureTask(robot.rest)]]
        run = rik.simulate(robot, resolver, stack, q, duration=0.4, dt=1e-3, limits=())
        assert run.manipulability[:, 0].min() > bound / 2 * 0.998


def test_where_measures_are_far_from_their_bounds_nothing_is_changed(rng):
    robot = rik.load("panda")
    for q in robot.random(rng, 10):
        stack = [[rik.FrameTask(robot.pose(robot.random(rng)))], [rik.PostureTask(robot.rest)]]
        plain, bent = (
            rik.VelocityController(robot, resolver, ()).step(q, stack, 0.01).qdot
            for resolver in (rik.TaskPriority(rik.JParse(0.01)), rik.TaskReconstruction(bound=1e-9))
        )
        assert_allclose(bent, plain, atol=1e-10 * (1 + np.abs(plain).max()))


def test_only_what_makes_the_measure_fall_is_taken_away(rng):
    """Below the bound, a task velocity that makes the measure rise comes through whole."""
    robot = rik.load("planar_3r")
    q = np.array([0.3, 0.4, -0.2])
    J, H = robot.jacobian(q), robot.hessian(q)
    m = float(rik.manipulability(J))
    slope = rik.manipulability_gradient(J, H)
    for xdot in rng.normal(size=(50, 2)):
        problem = VelocityProblem((TaskEquation(J, xdot, xdot, H),), Bounds.free(3))
        plain = np.linalg.pinv(J) @ xdot
        qdot = rik.TaskReconstruction(rik.MoorePenrose(), bound=1.5 * m).resolve(problem).qdot
        if slope @ plain >= 0:
            assert_allclose(qdot, plain, atol=1e-12)
        else:
            assert slope @ plain - 1e-12 <= slope @ qdot <= 1e-12


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_the_gradient_of_a_levels_measure_against_finite_differences(levels, rng):
    """Without differentiating projectors (maths of section 6.4), for levels of one to three rows of a 7-joint arm."""
    robot = rik.load("panda")
    rows = (("x", "y"), ("z", "wx", "wy"), ("wz",))[:levels]

    def equations(q, hessian):
        return [
            TaskEquation(robot.jacobian(q, rows=each), np.zeros(len(each)), np.zeros(len(each)),
                         robot.hessian(q, rows=each) if hessian else None)
            for each in rows
        ]  # fmt: skip

    def measure(q):
        freedom = Freedom.whole(7)
        for equation in equations(q, False):
            reduced = freedom.reduce(equation.J)
            freedom = Freedom(reduced.below)
        return float(np.prod(reduced.s))

    for q in robot.random(rng, 5):
        slope = measure_gradient(equations(q, True), measure(q))
        step = 1e-6 * np.eye(7)
        numeric = [(measure(q + each) - measure(q - each)) / 2e-6 for each in step]
        assert_allclose(slope, numeric, atol=1e-6)


def test_a_level_without_a_hessian_or_without_full_rank_is_left_alone(rng):
    robot = rik.load("panda")
    twice = [[rik.PositionTask([0.4, 0, 0.4])], [rik.FrameTask(robot.pose(robot.rest))], [rik.ManipulabilityTask()]]
    for q in [robot.neutral, *robot.random(rng, 5)]:
        step = rik.VelocityController(robot, rik.TaskReconstruction(bound=10.0), ()).step(q, twice, 0.01)
        assert np.isfinite(step.qdot).all()


def test_the_shape_is_a_parameter_and_runs_from_nothing_to_everything():
    assert [smooth(x) for x in (0, 0.5, 1)] == [0, 0.5, 1]
    q, robot = np.array([0.3, 0.4, -0.2]), rik.load("planar_3r")
    m = float(rik.manipulability(robot.jacobian(q)))
    task = rik.TwistTask(np.array([0.1, 0, 0, 0, 0, 0]))
    moved = [
        rik.VelocityController(robot, replace(SINGLE, bound=1.4 * m, shape=shape), ()).step(q, task, 0.01).qdot
        for shape in (smooth, lambda share: share, lambda share: 0.0)
    ]
    assert np.linalg.norm(moved[0] - moved[1]) > 1e-3
    assert_allclose(moved[2], np.linalg.pinv(robot.jacobian(q)) @ [0.1, 0], atol=1e-12)


def test_bounds_for_a_stack_are_fractions_of_what_its_measures_usually_are(rng):
    robot = rik.load("panda")
    frame, posture = rik.FrameTask(robot.pose(robot.rest)), rik.PostureTask(robot.rest)
    bounds = rik.measure_bounds(robot, [[frame], [frame], [posture]], 0.5)
    usual = np.median(rik.manipulability(robot.jacobian(robot.random(np.random.default_rng(0), 300))))
    assert_allclose(bounds, [usual / 2, 0, 0], atol=1e-12)
    with pytest.raises(rik.InputError, match="fraction must be > 0 and < 1"):
        rik.measure_bounds(robot, frame, 1.0)


@pytest.mark.parametrize("arguments, match", [
    ({"bound": -1.0}, "bound must be ≥ 0, got -1.0"),
    ({"bound": ()}, "one for each level, got none"),
    ({"recovery": 0}, "recovery must be > 0"),
    ({"shape": 3}, "shape must be a function"),
    ({"inverse": rik.SDLS()}, "takes filters such as JParse"),
])  # fmt: skip
def test_what_cannot_be_meant_is_refused(arguments, match):
    with pytest.raises(rik.InputError, match=match):
        rik.TaskReconstruction(**arguments)
