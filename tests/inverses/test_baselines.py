"""What methods are compared with: slowing down and stopping near singularities, and projectors that leak."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.analysis.stability import projector_leak
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers.classical_projections import LeakingPriority
from robust_ik.inverses.baselines import BASELINES, SlowDown, StopAtSingularity
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import null_projector
from robust_ik.simulation.scenarios.method_tables import KNOWN
from tests.cases_resolvers import named_box
from tests.inverses.test_inverses_contract import SHAPES, jacobians
from tests.kinematics.test_svd import matrix

guards = pytest.mark.parametrize("inverse", [SlowDown(), SlowDown(5.0, 5.0), StopAtSingularity()], ids=repr)


def conditioned(condition, rng, m=3, n=5):
    """A Jacobian of that condition number, σ₁ = 2."""
    return matrix(np.linspace(2.0, 2.0 / condition, m), m, n, rng)


def test_they_can_be_named_in_scenarios_and_are_not_offered():
    for baseline in (*BASELINES, LeakingPriority):
        assert KNOWN[baseline.__name__] is baseline
        assert not hasattr(rik, baseline.__name__)
        assert not hasattr(rik.inverses, baseline.__name__)


@guards
def test_far_from_singularities_they_are_the_pseudo_inverse(inverse, rng):
    J, xdot = conditioned(4.9, rng), rng.normal(size=3)
    assert_allclose(inverse.solve(J, xdot), np.linalg.pinv(J) @ xdot, atol=1e-12)


@guards
def test_at_the_last_condition_number_and_beyond_they_stand(inverse, rng):
    for condition in (inverse.stop * 1.0001, 1e3, 1e9):
        assert not inverse.solve(conditioned(condition, rng), rng.normal(size=3)).any()
    assert not inverse.solve(matrix([2, 1, 0.0], 3, 5, rng), rng.normal(size=3)).any()


@guards
def test_a_zero_jacobian_gives_zero(inverse):
    for shape in SHAPES:
        qdot = inverse.solve(np.zeros(shape), np.ones(shape[0]))
        assert qdot.shape == (shape[1],)
        assert not qdot.any()


@guards
def test_more_rows_than_joints_and_batches_are_taken(inverse, rng):
    tall = matrix([2.0, 1.0, 0.8], 6, 3, rng)
    xdot = rng.normal(size=6)
    assert_allclose(inverse.solve(tall, xdot), np.linalg.pinv(tall) @ xdot, atol=1e-12)
    for m, n in SHAPES:
        J, xdot = rng.normal(size=(4, 1, m, n)), rng.normal(size=(3, m))
        loop = [[inverse.solve(J[i, 0], xdot[j]) for j in range(3)] for i in range(4)]
        assert_allclose(inverse.solve(J, xdot), loop, rtol=1e-10, atol=1e-12)


@guards
def test_joint_speed_is_finite_and_bounded(inverse, rng):
    for J in jacobians(rng):
        xdot, sigma_max = rng.normal(size=J.shape[0]), max(np.linalg.norm(J, 2), 1e-300)
        qdot = inverse.solve(J, xdot)
        assert np.isfinite(qdot).all()
        assert np.linalg.norm(qdot) <= inverse.stop / sigma_max * np.linalg.norm(xdot) * (1 + 1e-9)


@guards
def test_scaling_j_scales_the_motion(inverse, rng):
    J, xdot = conditioned(20.0, rng), rng.normal(size=3)
    assert inverse.relative
    assert_allclose(inverse.solve(7 * J, xdot), inverse.solve(J, xdot) / 7, atol=1e-12)


def test_the_bound_of_stopping_is_reached_and_that_of_slowing_down_is_its_cards(rng):
    just = conditioned(29.999, rng)
    lost = np.linalg.svd(just)[0][:, -1]
    assert_allclose(np.linalg.norm(StopAtSingularity(30.0).solve(just, lost)), 29.999 / 2, rtol=1e-9)
    inverse, kappa = SlowDown(lower=10.0, stop=30.0), np.linspace(1, 30, 30001)
    gains = inverse.share(np.stack([np.ones_like(kappa), 1 / kappa], axis=-1)) * kappa  # σ₁ = 1
    assert_allclose(gains.max(), (30 / 2) ** 2 / (30 - 10), rtol=1e-6)


def test_slowing_down_is_linear_in_the_condition_number_between_its_thresholds():
    inverse = SlowDown(17.0, 30.0)
    kappa = np.array([1.0, 17.0, 20.25, 23.5, 30.0, 31.0])
    assert_allclose(inverse.share(np.stack([kappa, np.ones(6)], axis=-1)), [1, 1, 0.75, 0.5, 0, 0], atol=1e-12)
    assert inverse.share([0.0, 0.0]) == 0


def arm(q2):
    """J and Hessian of the planar arm with unit links, at q₁ = 0."""
    robot = rik.load("planar_2r")
    return robot.jacobian([0.0, q2], rows=("x", "y")), robot.hessian([0.0, q2], rows=("x", "y"))


@pytest.mark.parametrize("q2", [0.25, 0.1, -0.1])
def test_slowing_down_lets_go_back_and_not_on(q2):
    """κ is 20 and 50: slowed, and beyond the stop."""
    J, hessian = arm(q2)
    outwards = np.linalg.svd(J)[0][:, -1]
    outwards *= np.sign(outwards[0])
    inverse = SlowDown()
    assert inverse.needs_hessian
    on = inverse.velocity(TaskEquation(J, outwards, np.zeros(2), hessian))
    back = inverse.velocity(TaskEquation(J, -outwards, np.zeros(2), hessian))
    full = np.linalg.pinv(J) @ outwards
    assert_allclose(back, -full, rtol=1e-9)
    assert_allclose(on, inverse.share(np.linalg.svd(J)[1]) * full, atol=1e-12)
    assert np.linalg.norm(on) < 0.9 * np.linalg.norm(full)
    unaware = inverse.velocity(TaskEquation(J, -outwards, np.zeros(2)))
    assert_allclose(unaware, -on, atol=1e-12)


@pytest.mark.slow
def test_what_stops_never_leaves_again():
    """And what slows down does."""
    robot, inside = rik.load("planar_2r"), rik.Keypoints(np.array([eye_at(2.2), eye_at(1.0)]), 20.0)
    ends = {}
    for inverse in (StopAtSingularity(), SlowDown(), rik.JParse()):
        run = rik.simulate(robot, inverse, rik.Follow(inside, gain=1.0), [-0.5, 1.0], duration=40, dt=0.02, limits=())
        ends[type(inverse)] = run.position_error[-1]
        middle = run.q[int(19 / 0.02), 1]
        assert (abs(middle) < 0.01) == isinstance(inverse, rik.JParse)
    assert ends[StopAtSingularity] > 0.9
    assert ends[SlowDown] < 1e-6
    assert ends[rik.JParse] < 1e-6


def eye_at(x):
    T = np.eye(4)
    T[0, 3] = x
    return T


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: SlowDown(lower=0.5), "lower must be ≥ 1"),
        (lambda: SlowDown(30.0, 17.0), "lower ≤ stop must hold, got 30 and 17"),
        (lambda: SlowDown(stop=np.nan), "stop must be > 0"),
        (lambda: StopAtSingularity(0.9), "stop must be ≥ 1"),
    ],
)
def test_thresholds_that_cannot_be_meant_are_refused(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()


# ------------------------------------------------------------------------------------------ leaking projectors


def two_levels(rng, J):
    n = J.shape[1]
    first = TaskEquation(J, rng.normal(size=len(J)), np.zeros(len(J)))
    second = TaskEquation(np.eye(n), rng.normal(size=n), np.zeros(n))
    return VelocityProblem((first, second), Bounds.free(n)), first.xdot, second.xdot


def test_the_leaking_projector_is_the_one_with_the_damped_inverse(rng):
    inverse = rik.DampedLeastSquares(0.1)
    resolver = LeakingPriority((inverse, rik.MoorePenrose()))
    for _ in range(20):
        J = matrix([2.0, 1.0, 0.1], 3, 5, rng)
        problem, xdot, qdot0 = two_levels(rng, J)
        sharp = inverse.matrix(J)
        leaking = sharp @ xdot + (np.eye(5) - sharp @ J) @ qdot0
        assert_allclose(resolver.resolve(problem).qdot, leaking, atol=1e-12)
        exact = rik.TaskPriority((inverse, rik.MoorePenrose())).resolve(problem).qdot
        assert_allclose(J @ exact, J @ sharp @ xdot, atol=1e-9)
        leak = np.linalg.norm(J @ (leaking - sharp @ xdot))
        assert 0 < leak <= projector_leak(inverse, J) * np.linalg.norm(qdot0) * (1 + 1e-9)


def test_with_the_pseudo_inverse_nothing_leaks(rng):
    resolver = LeakingPriority(rik.MoorePenrose())
    J = matrix([2.0, 1.0, 0.5], 3, 5, rng)
    problem, xdot, qdot0 = two_levels(rng, J)
    assert_allclose(resolver.resolve(problem).qdot, np.linalg.pinv(J) @ xdot + null_projector(J) @ qdot0, atol=1e-12)


def test_bounds_cut_each_joint(rng):
    J = matrix([2.0, 1.0, 0.5], 3, 5, rng)
    problem, *_ = two_levels(rng, J)
    bounded = VelocityProblem(problem.levels, named_box(np.full(5, -0.01), np.full(5, 0.02)))
    free = LeakingPriority().resolve(problem).qdot
    assert_allclose(LeakingPriority().resolve(bounded).qdot, np.clip(free, -0.01, 0.02))
