"""What holds for levels of tasks, whatever the inverse and the way to meet limits."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.within_bounds.feasible_start import feasible_start
from robust_ik.control.within_bounds.null_space import Freedom
from robust_ik.inverses.task_equation import TaskEquation
from tests.cases_filters import CASES
from tests.cases_others import OTHER_CASES
from tests.cases_resolvers import (
    INVERSES,
    LIMITERS,
    RESOLVERS,
    SMALL_SIGMAS,
    STRICT,
    named_box,
    random_equation,
    random_levels,
    random_matrix,
    random_problem,
)
from tests.soak import ROBOTS, random_stack

INSTANCES = [cls() for cls in rik.inverses.CLASSES if cls is not rik.Weighted] + [
    rik.Weighted(rik.JParse()),
    rik.Weighted(rik.DampedLeastSquares()),
]
each_strict = pytest.mark.parametrize("resolver", STRICT, ids=lambda r: f"{type(r).__name__} {r.inverse} {r.limiter}")


def alone(problem, levels):
    """The same problem without the levels below."""
    return replace(problem, levels=problem.levels[:levels])


# ------------------------------------------------------------------------------------------------ the recursion
def test_the_recursion_has_the_identities_of_nested_null_spaces(rng):
    """Maths 6.1: J₁N₂ = 0, rank N_k = n − Σ rank, Π det(ĴĴᵀ) = det(J_st J_stᵀ), N Ĵ# = Ĵ# for every filter."""
    for _ in range(50):
        levels = [rng.normal(size=(m, 9)) for m in rng.integers(1, 4, 3)]
        freedom, product, left = Freedom.whole(9), 1.0, 9
        for index, J in enumerate(levels):
            N, reduced = freedom.basis @ freedom.basis.T, freedom.reduce(J)
            assert_allclose(reduced.matrix, J @ N, atol=1e-13)
            for inverse in (*INVERSES, rik.MoorePenrose(), rik.Sigmoid(), rik.EDLS()):
                assert_allclose(N @ inverse.matrix(J @ N), inverse.matrix(J @ N), atol=1e-12)
            product *= np.prod(reduced.s) ** 2
            freedom, left = Freedom(reduced.below), left - len(J)
            assert freedom.basis.shape == (9, left)
            for above in levels[: index + 1]:
                assert np.abs(above @ freedom.basis).max(initial=0) < 1e-13
        stack = np.concatenate(levels)
        assert_allclose(product, np.linalg.det(stack @ stack.T), rtol=1e-10)


def test_task_priority_is_equation_15_written_out_with_pinv(rng):
    for _ in range(100):
        n = int(rng.integers(4, 10))
        levels = [random_equation(rng, random_matrix(rng, m, n)) for m in (1, 2, 1)]
        qdot, N = np.zeros(n), np.eye(n)
        for each in levels:
            reduced = each.J @ N
            qdot = qdot + np.linalg.pinv(reduced) @ (each.xdot - each.J @ qdot)
            N = N - np.linalg.pinv(reduced) @ reduced
        problem = VelocityProblem(tuple(levels), Bounds.free(n))
        found = rik.TaskPriority(rik.MoorePenrose()).resolve(problem)
        assert_allclose(found.qdot, qdot, atol=1e-10 * max(1.0, np.abs(qdot).max()))
        assert found.status is rik.Status.TRACKING
        assert (found.scale == 1).all()


def test_with_one_level_every_strict_resolver_is_its_inverse(rng):
    for _ in range(30):
        equation = random_levels(rng, 6, levels=1)[0]
        problem = VelocityProblem((equation,), Bounds.free(6))
        for inverse in (*INVERSES, rik.Sigmoid(), rik.SDLS(), rik.UserDefinedAccuracy()):
            expected = inverse.velocity(equation)
            for kind in (rik.TaskPriority, rik.DecoupledPriority):
                assert_allclose(
                    kind(inverse).resolve(problem).qdot, expected, atol=1e-11 * (1 + np.abs(expected).max())
                )


# ---------------------------------------------------------------------------------------------------- priorities
@each_strict
def test_lower_levels_change_nothing_above_them_wherever_it_is(resolver):
    """Task velocities and scales to 1e-9, beside the 1e-12 σ₁ ‖q̇‖ of directions that count as lost."""
    rng = np.random.default_rng(1)
    for _ in range(60):
        problem = random_problem(rng)
        runs = [resolver.resolve(alone(problem, count)) for count in range(1, len(problem.levels) + 1)]
        for count, run in enumerate(runs):
            for level in range(count):
                tolerance = 1e-9 + 1e-10 * np.abs(run.qdot).max()
                assert_allclose(run.levels[level].residual, runs[level].levels[level].residual, atol=tolerance)
                assert_allclose(run.levels[level].scale, runs[level].levels[level].scale, atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_on_real_robots_lower_levels_change_nothing_above_them(name):
    robot, rng = rik.load(name, **ROBOTS[name]), np.random.default_rng(2)
    limits = rik.JointLimits.of(robot, velocity=np.minimum(robot.velocity_limit, 2.0))
    singular = robot.configuration(np.clip(0.0, limits.lower, limits.upper))
    for index, resolver in enumerate(STRICT):
        q = singular if index % 2 else robot.random(rng)
        stack = random_stack(robot, rng)
        steps = [rik.VelocityController(robot, resolver, limits).step(q, stack[:k], 0.01) for k in (1, len(stack))]
        assert_allclose(steps[1].residual, steps[0].residual, atol=1e-9)
        assert_allclose(steps[1].scale[0], steps[0].scale[0], atol=1e-9)


@pytest.mark.parametrize("resolver", RESOLVERS, ids=repr)
def test_bounds_hold_to_rounding_and_numbers_are_finite_in_every_problem(resolver):
    rng = np.random.default_rng(3)
    for _ in range(60):
        problem = random_problem(rng)
        step = resolver.resolve(problem)
        _, bounds = feasible_start(problem.bounds)
        assert (step.qdot >= bounds.lower).all()
        assert (step.qdot <= bounds.upper).all()
        assert (bounds.rows @ step.qdot >= bounds.floor - 1e-10).all()
        assert ((step.scale >= 0) & (step.scale <= 1)).all()
        assert (step.status is rik.Status.INFEASIBLE) == bool(step.contradictions)
        assert all(np.isfinite(level.residual).all() for level in step.levels)
        assert step.text.startswith(step.status.name.lower())


def test_without_acting_limits_every_limiter_gives_the_inverses_motion(rng):
    for _ in range(40):
        levels = random_levels(rng, int(rng.integers(1, 10)), speed=1.0)
        n = levels[0].J.shape[1]
        free = VelocityProblem(levels, Bounds.free(n))
        wide = VelocityProblem(levels, named_box(np.full(n, -1e18), np.full(n, 1e18)))
        for kind in (rik.TaskPriority, rik.DecoupledPriority):
            motions = [kind(limiter=limiter).resolve(each) for limiter in LIMITERS for each in (free, wide)]
            for motion in motions:
                assert (motion.qdot == motions[0].qdot).all()
                assert (motion.scale == 1).all()


@pytest.mark.parametrize("inverse", INSTANCES, ids=repr)
def test_any_inverse_works_at_any_level_and_in_any_run(inverse):
    rng = np.random.default_rng(4)
    for _ in range(25):
        problem = random_problem(rng)
        _, bounds = feasible_start(problem.bounds)
        for resolver in (rik.TaskPriority(inverse), rik.DecoupledPriority(inverse, rik.Scaling())):
            run = resolver.begin(0.01)
            for step in (resolver.resolve(problem), run.resolve(problem), run.resolve(problem)):
                assert np.isfinite(step.qdot).all()
                assert bounds.contains(step.qdot)


def test_where_a_task_has_no_hessian_an_inverse_that_could_use_one_is_of_first_order(rng):
    for inverse in (
        rik.Halley(),
        rik.Weighted(rik.Halley(), length_scale=0.5, linear_rows=1),
        rik.EDLS(asymmetric=True),
    ):
        for _ in range(10):
            levels = tuple(replace(each, hessian=None) for each in random_levels(rng, 6, levels=2, speed=1.0))
            for kind in (rik.TaskPriority, rik.DecoupledPriority):
                step = kind(inverse).resolve(VelocityProblem(levels[:1], Bounds.free(6)))
                assert_allclose(step.qdot, inverse.solve(levels[0].J, levels[0].xdot), atol=1e-9)
                assert np.isfinite(kind(inverse).begin(0.1).resolve(VelocityProblem(levels, Bounds.free(6))).qdot).all()


@pytest.mark.parametrize(
    "inverse, rows",
    [
        (rik.Weighted(rik.JParse(), joint_weights=(1.0, 2, 3, 4, 5, 6, 7)), 3),
        (rik.Weighted(rik.JParse(), task_weights=(1.0, 2, 3)), 3),
        (rik.Weighted(rik.JParse(), length_scale=0.3), 6),
        (rik.Weighted(rik.Weighted(rik.JParse(), joint_weights=np.diag(np.arange(1.0, 8))), length_scale=2.0), 6),
    ],
    ids=repr,
)
def test_weights_work_at_lower_levels_and_bound_the_speed_of_algorithmic_singularities(inverse, rows, rng):
    first = random_equation(rng, rng.normal(size=(rows - 2, 7)))
    for nearness in (1.0, 1e-2, 1e-4, 1e-6, 1e-9, 0.0):
        J = rng.normal(size=(rows, rows - 2)) @ first.J + nearness * rng.normal(size=(rows, 7))
        problem = VelocityProblem((first, random_equation(rng, J)), Bounds.free(7))
        resolver = rik.TaskPriority((rik.JParse(), inverse))
        alone_, both = (resolver.resolve(each) for each in (alone(problem, 1), problem))
        asked = np.linalg.norm(problem.levels[1].xdot - J @ alone_.qdot)
        bound = inverse.largest_gain(np.linalg.norm(J, 2))
        assert np.linalg.norm(both.qdot - alone_.qdot) <= bound * asked


# ---------------------------------------------------------------------------------------------------- relative
NEITHER = (rik.FilteredInverse(rate=5.0, leakage=0.1, initial=None), rik.DulebaAdditive())
"""Always zero; relative to the lengths of rows, not to σ₁."""
BY_COMMAND = tuple(each for each in OTHER_CASES if isinstance(each, rik.SecondOrder))
"""Relative, and damped by the command: it is c J and c ẋ that give the same velocities."""


@pytest.mark.parametrize(
    "inverse", [each for each in CASES + OTHER_CASES if each not in NEITHER + BY_COMMAND], ids=repr
)
def test_thresholds_are_relative_if_and_only_if_velocities_scale_with_the_inverse_of_the_jacobian(inverse, rng):
    same = True
    for (m, n), small in zip([(3, 5), (6, 7), (2, 2), (5, 3)] * 3, np.repeat([0.3, 0.02, 1e-3], 4)):
        J, xdot = random_matrix(rng, m, n, small), rng.normal(size=m)
        for c in (1e-3, 0.1, 7.0, 100.0):
            expected = inverse.solve(J, xdot) / c
            same &= np.allclose(inverse.solve(c * J, xdot), expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    assert same == inverse.relative


# -------------------------------------------------------------------------------------- algorithmic singularities
def sweep(rng, n):
    """Two levels; the second one, but for t times something else, is a combination of the first one's rows."""
    m = int(rng.integers(1, n))
    first = random_equation(rng, random_matrix(rng, m, n))
    rows = int(rng.integers(1, n + 1))
    mix, other, xdot = rng.normal(size=(rows, m)), rng.normal(size=(rows, n)), rng.normal(size=rows)

    def at(t):
        J = mix @ first.J + t * other
        return VelocityProblem((first, TaskEquation(J, xdot, xdot, np.zeros((rows, n, n)))), Bounds.free(n))

    return at


@pytest.mark.parametrize("inverse", [each for each in INSTANCES if np.isfinite(each.largest_gain(1.0))], ids=repr)
def test_the_largest_gain_bounds_the_speed_through_an_algorithmic_singularity(inverse):
    """For relative inverses with σ₁ of J itself, not of J N."""
    rng = np.random.default_rng(5)
    for _ in range(8):
        at = sweep(rng, int(rng.integers(2, 8)))
        for t in np.concatenate([[0.0], np.geomspace(1e-14, 1, 11)]):
            problem = at(t)
            first, both = (rik.TaskPriority(inverse).resolve(alone(problem, count)) for count in (1, 2))
            J, xdot = problem.levels[1].J, problem.levels[1].xdot
            size = np.linalg.norm(J, 2)
            sizes = [size] if inverse.relative else np.geomspace(1e-6, 1, 30) * size
            bound = max(inverse.largest_gain(each) for each in sizes) * np.linalg.norm(xdot - J @ first.qdot)
            assert np.linalg.norm(both.qdot - first.qdot) <= 1.01 * bound + 1e-9


def largest_jump(function, times):
    """The largest step that stays when the interval around it is halved 45 times."""
    values, largest = [function(t) for t in times], 0.0
    steps = [np.abs(b - a).max() for a, b in itertools.pairwise(values)]
    for index in np.argsort(steps)[-3:]:
        low, high, at_low, at_high = *times[index : index + 2], *values[index : index + 2]
        for _ in range(45):
            middle = (low + high) / 2
            at_middle = function(middle)
            if np.abs(at_middle - at_low).max() >= np.abs(at_high - at_middle).max():
                high, at_high = middle, at_middle
            else:
                low, at_low = middle, at_middle
        largest = max(largest, np.abs(at_high - at_low).max())
    return largest


@pytest.mark.parametrize("limiter", [None, *(each for each in LIMITERS if each != rik.Scaling())], ids=repr)
@pytest.mark.parametrize("inverse", INVERSES, ids=repr)
@pytest.mark.parametrize("kind", ["kinematic", "algorithmic"])
def test_velocities_are_continuous_through_singularities(kind, inverse, limiter):
    """Without limits whatever the limiter, and within them with all but `Scaling`.

    That one jumps where a joint at its bound begins to move outwards, from all to nothing. At σ ≤ 1e-12 σ₁ exactly,
    lower levels gain the direction.
    """
    rng, times = np.random.default_rng(6), np.linspace(-1, 1, 60) + 0.00123
    first, second = rng.normal(size=(2, 6)), rng.normal(size=(2, 6))
    mix, asked = rng.normal(size=2), rng.normal(size=(2, 2))
    U, s, Vt = np.linalg.svd(first, full_matrices=False)
    bounds = Bounds.free(6) if limiter is None else named_box(np.full(6, -0.3), np.full(6, 0.3))
    resolver = rik.TaskPriority(inverse, limiter or rik.Saturation())

    def velocity(t):
        J1 = (U * [s[0], s[1] * (t if kind == "kinematic" else 1)]) @ Vt
        J2 = second if kind == "kinematic" else np.stack([mix @ J1 + t * second[0], second[1]])
        levels = tuple(TaskEquation(J, xdot, xdot) for J, xdot in zip((J1, J2), asked))
        return resolver.resolve(VelocityProblem(levels, bounds)).qdot

    assert largest_jump(velocity, times) < 1e-6


@pytest.mark.parametrize("small", SMALL_SIGMAS)
def test_what_a_singular_level_leaves_does_not_depend_on_how_small_its_sigma_is_but_for_zero(small, rng):
    reduced = Freedom.whole(7).reduce(random_matrix(rng, 3, 7, small))
    assert reduced.below.shape[1] == (4 if small > 1e-12 else 5)
    released = Freedom.whole(7).reduce(random_matrix(rng, 3, 7, small), release=0.1)
    assert released.below.shape[1] == 5


# ---------------------------------------------------------------------------------------------------- decoupled
def test_decoupled_levels_are_exact_exactly_where_their_rows_do_not_meet(rng):
    for _ in range(30):
        Q = np.linalg.qr(rng.normal(size=(7, 7)))[0].T
        apart = [random_equation(rng, rng.normal(size=(2, 2)) @ rows) for rows in (Q[:2], Q[2:4])]
        decoupled, priority = rik.DecoupledPriority(rik.MoorePenrose()), rik.TaskPriority(rik.MoorePenrose())
        met = decoupled.resolve(VelocityProblem(tuple(apart), Bounds.free(7)))
        scale = 1 + np.abs(met.qdot).max()
        assert max(np.abs(level.residual).max() for level in met.levels) < 1e-9 * scale
        meeting = (apart[0], random_equation(rng, rng.normal(size=(2, 7))))
        missed = decoupled.resolve(VelocityProblem(meeting, Bounds.free(7)))
        exact = priority.resolve(VelocityProblem(meeting, Bounds.free(7)))
        assert np.abs(missed.levels[1].residual).max() > 1e-3
        assert np.abs(exact.levels[1].residual).max() < 1e-9 * (1 + np.abs(exact.qdot).max())
        assert_allclose(missed.levels[0].residual, 0, atol=1e-9 * scale)


def test_no_algorithmic_singularity_makes_decoupled_levels_fast_with_the_pseudo_inverse(rng):
    for _ in range(20):
        at = sweep(rng, 6)
        for t in (0.0, 1e-12, 1e-9, 1e-6, 1e-3):
            problem = at(t)
            step = rik.DecoupledPriority(rik.MoorePenrose(tolerance=1e-6)).resolve(problem)
            own = [rik.MoorePenrose(tolerance=1e-6).solve(each.J, each.xdot) for each in problem.levels]
            assert np.linalg.norm(step.qdot) <= sum(np.linalg.norm(each) for each in own) * (1 + 1e-9)


def test_the_first_level_makes_up_for_what_limits_force_on_it(rng):
    """A joint that must come back moves; the others keep the task where it is."""
    J = rng.normal(size=(2, 6))
    lower = np.r_[0.1, -np.ones(5)]
    still = TaskEquation(J, np.zeros(2), np.zeros(2))
    for kind, limiter in itertools.product((rik.TaskPriority, rik.DecoupledPriority), LIMITERS[:-1]):
        step = kind(limiter=limiter).resolve(VelocityProblem((still,), named_box(lower, np.ones(6))))
        assert_allclose(step.residual, 0, atol=1e-4)
        assert step.qdot[0] >= 0.1
        assert step.scale[0] > 0.999


def test_a_level_that_asks_for_rest_and_is_moved_is_not_tracking():
    still = TaskEquation(np.eye(2), np.zeros(2), np.zeros(2))
    box = named_box([0.1, -1], [1, 1])
    for inverse in (rik.JParse(), rik.DampedLeastSquares(1e9)):  # the one is slowed, the other asks for nothing
        step = rik.TaskPriority(inverse).resolve(VelocityProblem((still,), box))
        assert_allclose(step.residual, [-0.1, 0])
        assert step.status is not rik.Status.TRACKING


# ------------------------------------------------------------------------------------------------------ weighted
def test_weighted_levels_approach_strict_ones_as_the_ratio_of_weights_falls(rng):
    """Down to a ratio of about 1e-3: then the regularisation, 1e-9 of the trace, weighs against the second level."""
    for sizes in [(2, 3), (3, 4)] * 10:
        levels = tuple(random_equation(rng, random_matrix(rng, m, 6)) for m in sizes)
        problem = VelocityProblem(levels, Bounds.free(6))
        strict = rik.TaskPriority(rik.MoorePenrose()).resolve(problem).qdot
        distance = [
            np.linalg.norm(rik.WeightedPriority(rik.MoorePenrose(), (1.0, ratio)).resolve(problem).qdot - strict)
            for ratio in (1e-1, 1e-2, 1e-3)
        ]
        assert distance[2] < 0.02 * (1 + np.linalg.norm(strict))
        assert sizes == (2, 3) or distance[0] > 3 * distance[1]


def test_weights_go_on_as_a_geometric_row():
    resolver = rik.WeightedPriority(weights=(1.0, 0.1, 0.05))
    assert [resolver.weight_of(level) for level in range(5)] == pytest.approx([1, 0.1, 0.05, 0.025, 0.0125])
    assert rik.WeightedPriority(weights=(2.0,)).weight_of(7) == 2.0


# ---------------------------------------------------------------------------------------------- memory and arguments
def test_every_level_has_a_memory_of_its_own(rng):
    levels = random_levels(rng, 6, levels=2, kind="regular", speed=1.0)
    run = rik.TaskPriority(rik.FilteredInverse(rate=5.0)).begin(0.01)
    assert len({id(run.inverse_of(level)) for level in range(4)}) == 4
    first = run.resolve(VelocityProblem(levels, Bounds.free(6)))
    again = rik.TaskPriority(rik.FilteredInverse(rate=5.0)).begin(0.01).resolve(VelocityProblem(levels, Bounds.free(6)))
    assert (first.qdot == again.qdot).all()
    plain = rik.TaskPriority(rik.JParse())
    assert plain.begin(0.01) is plain


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: rik.TaskPriority("JParse"), "inverse must be a robust inverse such as JParse"),
        (lambda: rik.TaskPriority(()), "or a sequence of them, got"),
        (lambda: rik.TaskPriority(limiter="qp"), r"limiter must be Sliding\(\), Saturation\(\), QuadraticProgram"),
        (lambda: rik.TaskPriority(release=1.0), "release must be ≥ 0 and < 1"),
        (lambda: rik.WeightedPriority(weights=()), "weights must be one number > 0 for each level"),
        (lambda: rik.WeightedPriority(weights=(1.0, -1.0)), "weights must be > 0"),
        (lambda: rik.WeightedPriority(backend="none"), "backend must be one of .*daqp"),
        (lambda: rik.QuadraticProgram(backend="none"), "backend must be one of .*daqp"),
    ],
)
def test_what_cannot_be_meant_is_refused(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()


def test_the_resolution_cannot_be_written_to(rng):
    step = rik.TaskPriority().resolve(random_problem(rng))
    with pytest.raises(ValueError, match="read-only"):
        step.qdot[0] = 1.0
