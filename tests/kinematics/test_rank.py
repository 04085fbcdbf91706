"""One definition of rank: what counts as zero, in inverses, levels and limiters, and that rounding moves nothing."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers.step_status import verdict
from robust_ik.control.within_bounds.filtered_motion import filtered_motion
from robust_ik.control.within_bounds.null_space import Freedom
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import RANK_TOLERANCE
from tests.cases_filters import CASES
from tests.cases_others import OTHER_CASES
from tests.cases_resolvers import LIMITERS, named_box, random_matrix
from tests.kinematics.test_svd import matrix

DIRECTED, SATURATION = rik.QuadraticProgram(keep_direction=True), rik.Saturation()
EPS = float(np.finfo(float).eps)


def singular_problem(rng):
    """Exactly singular J, of products of small whole numbers, a wish that can be met, and a box."""
    n = int(rng.integers(3, 9))
    m = int(rng.integers(2, min(n, 6) + 1))
    rank = int(rng.integers(1, m))
    left, right = rng.integers(-3, 4, (m, rank)), rng.integers(-3, 4, (rank, n))
    J = (left @ right) / float(rng.integers(3, 12))
    wish = J @ rng.normal(size=n) * rng.choice([1, 5, 20])
    return J, wish, (-rng.uniform(0.1, 2, n), rng.uniform(0.1, 2, n))


def resolved(J, wish, box, limiter, inverse=None):
    problem = VelocityProblem((TaskEquation(J, wish, wish),), named_box(*box))
    return rik.TaskPriority(inverse or rik.MoorePenrose(), limiter).resolve(problem)


def largest_share(J, effect, box):
    """The largest s in [0, 1] with J q̇ = s · effect inside the box, by linear programming."""
    equal = np.column_stack([J, -effect])
    found = linprog(
        -np.eye(equal.shape[1])[-1],
        A_eq=equal,
        b_eq=np.zeros(len(J)),
        bounds=[*zip(*box), (0, 1)],
        method="highs",
    )
    return float(found.x[-1])


def test_the_share_that_keeps_the_direction_is_the_optimum_at_exactly_singular_jacobians_where_help_is_worth_it():
    rng, best = np.random.default_rng(0), {SATURATION: 0, DIRECTED: 0}
    for _ in range(300):
        J, wish, box = singular_problem(rng)
        optimum = largest_share(J, wish, box)
        for limiter in best:
            share = resolved(J, wish, box, limiter).scale[0]
            assert share <= optimum + 5e-3
            best[limiter] += share > optimum - 5e-3
    assert min(best.values()) >= 250
    assert best[SATURATION] == best[DIRECTED]


@pytest.mark.parametrize("limiter", LIMITERS, ids=repr)
@pytest.mark.parametrize("inverse", [rik.MoorePenrose(), rik.JParse(), rik.DampedLeastSquares()], ids=repr)
def test_a_change_of_j_by_rounding_changes_what_a_level_gets_by_rounding(limiter, inverse):
    rng = np.random.default_rng(1)
    for _ in range(60):
        J, wish, box = singular_problem(rng)
        size = np.linalg.norm(J, 2)
        before = resolved(J, wish, box, limiter, inverse)
        for change in (1e-17, 1e-15):
            after = resolved(J + change * size * rng.normal(size=J.shape), wish, box, limiter, inverse)
            assert_allclose(after.scale, before.scale, atol=1e-6)
            assert_allclose(J @ after.qdot, J @ before.qdot, atol=1e-5 * (1 + np.abs(wish).max()))


def test_no_level_takes_as_free_what_another_inverts():
    """Whatever σ₆ of the first level is, a second one changes it by the rounding of J q̇ only."""
    rng = np.random.default_rng(2)
    for sigma in np.geomspace(1e-16, 1e-6, 41):
        J = random_matrix(rng, 6, 7, small=sigma)
        wish, other = rng.normal(size=6), rng.normal(size=(3, 7))
        levels = TaskEquation(J, wish, wish), TaskEquation(other, rng.normal(size=3), np.zeros(3))
        resolver = rik.TaskPriority(rik.MoorePenrose())
        alone = resolver.resolve(VelocityProblem(levels[:1], Bounds.free(7))).qdot
        both = resolver.resolve(VelocityProblem(levels, Bounds.free(7))).qdot
        rounding = 50 * EPS * (np.linalg.norm(both) + np.linalg.norm(alone))
        assert np.linalg.norm(J @ (both - alone)) <= rounding + 10 * RANK_TOLERANCE * np.linalg.norm(both - alone)
        assert rounding < 0.2


@pytest.mark.parametrize("sigma", [0.0, 1e-17, 1e-14, 0.9 * RANK_TOLERANCE, 1.1 * RANK_TOLERANCE, 1e-9])
def test_inverse_level_and_measure_count_the_same_rank(sigma, rng):
    J = 2.0 * np.diag([1.0, 0.5, sigma]) @ np.linalg.qr(rng.normal(size=(5, 5)))[0][:3]
    rank = 2 + (sigma > RANK_TOLERANCE)
    reduced = Freedom.whole(5).reduce(J)
    assert reduced.rank == len(reduced.motions) == len(reduced.taken) == rank
    assert reduced.idle.shape[1] == reduced.below.shape[1] == 5 - rank
    assert rik.svd(J).corank() == 3 - rank
    assert rik.lost_directions(J).shape[1] == 3 - rank
    assert np.isinf(rik.condition_number(J)) == (rank == 2)
    assert np.count_nonzero(rik.MoorePenrose().gains(rik.svd(J).s)) == rank


# Joints without effect


def middle(robot, place):
    """Position rows of a frame in the middle of an arm: zero columns from there on, and a loss of rank."""
    return [frame for frame in robot.frames if "joint" in frame or "link" in frame][place]


@pytest.mark.parametrize("clamp", ["hard", "smooth"])
def test_sdls_tracks_a_frame_in_the_middle_and_leaves_the_joints_behind_it(clamp, rng):
    robot = rik.load("panda")
    for q in robot.random(rng, 60):
        J = robot.jacobian(q, "panda_joint3")[:3]
        idle = ~J.any(axis=0)
        inverse = rik.SDLS(clamp=clamp)
        wish = 1e-3 * J @ rng.normal(size=robot.n)
        qdot = inverse.solve(J, wish)
        assert idle.sum() >= 4
        assert not qdot[idle].any()
        assert np.linalg.norm(J @ qdot - wish) <= (1e-9 if clamp == "hard" else 0.1) * np.linalg.norm(wish)
        task = rik.PositionTask(robot.pose(robot.random(rng), "panda_joint3")[:3, 3], frame="panda_joint3")
        step = rik.VelocityController(robot, inverse).step(q, [[task]], 0.01)
        assert np.isfinite(step.qdot).all()
        assert not step.qdot[idle].any()


@pytest.mark.parametrize("inverse", [rik.SDLS(), rik.SDLS(clamp="smooth"), rik.JParse(), rik.MoorePenrose()], ids=repr)
@pytest.mark.parametrize("nearly", [0.0, 1e-17, 1e-15, 1e-13])
def test_a_joint_with_no_effect_but_rounding_is_as_good_as_none(inverse, nearly, rng):
    for _ in range(20):
        J, wish = matrix([1, 0.6, 0.3], 3, 5, rng), rng.normal(size=3)
        J[:, 2:] = 0.0  # two joints for three rows: rank 2
        noisy = J.copy()
        noisy[:, 2:] = nearly * rng.normal(size=(3, 3))
        assert_allclose(
            inverse.solve(noisy, wish), inverse.solve(J, wish), atol=1e-9 * np.abs(inverse.solve(J, wish)).max() + 1e-9
        )


def test_sdls_is_its_own_limit_however_large_or_small_j_is(rng):
    J, wish = matrix([1, 0.6, 0.01], 3, 5, rng), rng.normal(size=3)
    for size in (1e-160, 1e-100, 1e100, 1e150):
        for clamp in ("hard", "smooth"):
            inverse = rik.SDLS(clamp=clamp)
            assert_allclose(inverse.solve(size * J, size * wish), inverse.solve(J, wish), rtol=1e-9)


@pytest.mark.parametrize("inverse", CASES + OTHER_CASES, ids=repr)
def test_one_entry_of_one_among_tiny_ones_is_a_healthy_direction(inverse):
    J = np.full((3, 3), 1e-155)
    J[0, 0] = 1.0
    qdot = inverse.solve(J, [0.1, 0.0, 0.0])
    assert np.isfinite(qdot).all()
    assert np.linalg.norm(qdot) <= inverse.largest_gain(1.0) * 0.1 * (1 + 1e-9)


@pytest.mark.parametrize("limiter", LIMITERS, ids=repr)
def test_wishes_whose_squares_overflow_are_fitted_into_limits_like_others(limiter):
    J, box = 1e-170 * np.array([[1.0, 0.5, 0.2], [0.1, 1.0, 0.3]]), (-np.ones(3), np.ones(3))
    step = resolved(J, np.array([1.0, -1.0]), box, limiter, rik.MoorePenrose())
    assert np.isfinite(step.qdot).all()
    assert (np.abs(step.qdot) <= 1 + 1e-9).all()


@pytest.mark.parametrize("size", [1.0, 1e155, 1e250])
def test_a_step_that_misses_by_more_than_can_be_squared_is_told_like_any_other(size):
    equation = TaskEquation(np.eye(3), np.array([1.0, 2.0, 0.0]), np.zeros(3))
    away = size * np.array([1.0, -1.0, 5.0])
    problem, reduced = VelocityProblem((equation,), Bounds.free(3)), [Freedom.whole(3).reduce(np.eye(3))]
    told = [verdict(problem, each * away, [1.0], reduced).status for each in (1.0, -1.0)]
    assert told == [rik.Status.STUCK, rik.Status.SCALED]


@pytest.mark.parametrize("inverse", [rik.EDLS(lower=0.1, raw=True), rik.DampedLeastSquares(), rik.DulebaAdditive()])
def test_a_level_makes_up_for_a_motion_above_that_is_larger_than_any_wish(inverse):
    """Its wish is then beyond 1e100, which inverses refuse; it keeps the wish's direction."""
    rows = np.array([[1.0, 2.0, 0.5], [0.3, 1.0, 1.0]])
    equation, whole = TaskEquation(rows, np.ones(2), np.zeros(2)), Freedom.whole(3)
    wanted = np.array([1.0, -2.0])
    motions = [
        filtered_motion(inverse, whole.reduce(rows), equation, size * wanted, whole) for size in (1e100 / 2, 1e166)
    ]
    assert np.isfinite(motions).all()
    assert_allclose(motions[1], motions[0], rtol=1e-9)
