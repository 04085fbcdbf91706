"""How a level's motion is fitted into the bounds: direction, share, optimality."""

from itertools import pairwise

import numpy as np
import pytest
import qpsolvers
from numpy.testing import assert_allclose
from scipy.optimize import linprog

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.within_bounds import active_set
from robust_ik.control.within_bounds.feasible_start import feasible_start
from robust_ik.control.within_bounds.filtered_motion import filtered_motion
from robust_ik.control.within_bounds.level_fit import TURN, Wish
from robust_ik.control.within_bounds.motion_cost import PRICE
from robust_ik.control.within_bounds.null_space import Freedom
from robust_ik.inverses.task_equation import TaskEquation
from tests.cases_resolvers import BOXES, named_box, random_problem

SCALING, SATURATION, SLIDING = rik.Scaling(), rik.Saturation(), rik.Sliding()
NEAREST, DIRECTED = rik.QuadraticProgram(), rik.QuadraticProgram(keep_direction=True)
BACKENDS = [name for name in ("daqp", "proxqp", "quadprog") if name in qpsolvers.available_solvers]
WORTH = 1e-3
"""Wishes smaller than this are left out where shares are compared: the tolerance on bounds is 1e-12."""


def wishes(count, seed):
    """What levels of random problems within limits wish, one after another."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        problem = random_problem(rng, bounds=rng.choice([kind for kind in BOXES if kind != "free"]))
        qdot, bounds = feasible_start(problem.bounds)
        freedom = Freedom.whole(len(qdot))
        for equation in problem.levels:
            reduced = freedom.reduce(equation.J)
            missing = equation.xdot - equation.J @ qdot
            motion = freedom.project(filtered_motion(rik.JParse(), reduced, equation, missing, freedom))
            wish = Wish(qdot, motion, reduced, freedom, bounds, rng.choice([0.0, 0.01]))
            yield wish
            limiter = (SCALING, SATURATION, NEAREST, DIRECTED, SLIDING)[rng.integers(5)]
            qdot = np.clip(qdot + limiter.limit(wish)[0], bounds.lower, bounds.upper)
            freedom = Freedom(reduced.below)


def largest_share(wish):
    """The share that linear programming finds, with any help from what moves the level nowhere, and that help."""
    task = wish.reduced.motions
    along = task.T @ (task @ wish.motion)
    length = np.linalg.norm(along)
    directions = np.column_stack([along / length, wish.reduced.idle])
    bounds = wish.bounds
    rows = np.concatenate([directions, -directions, -bounds.rows @ directions])
    room = np.concatenate(
        [bounds.upper - wish.qdot, wish.qdot - bounds.lower, bounds.rows @ wish.qdot - bounds.floor]
    ).clip(0)
    spans = [(0, length)] + [(None, None)] * (directions.shape[1] - 1)
    found = linprog(-np.eye(directions.shape[1])[0], rows, room, bounds=spans, method="highs")
    return found.x[0] / length, wish.reduced.idle @ found.x[1:]


def metric(wish):
    """H/σ₁², (n, n), over the level's freedom."""
    return (wish.cost.directions * wish.cost.weights) @ wish.cost.directions.T


def missed(wish, change):
    """½ (change − motion)ᵀ H (change − motion)."""
    return float((change - wish.motion) @ metric(wish) @ (change - wish.motion)) / 2


def inside(wish, change):
    return wish.bounds.contains(wish.qdot + change, 1e-11)


@pytest.mark.parametrize("limiter", [SCALING, SATURATION, DIRECTED], ids=repr)
def test_the_direction_of_the_task_is_kept_but_for_a_thousandth_of_the_wish(limiter):
    for wish in wishes(150, seed=1):
        change, share = limiter.limit(wish)
        assert 0 <= share <= 1
        assert inside(wish, change)
        effect = wish.reduced.matrix @ wish.motion
        turn = TURN * np.sqrt(wish.motion @ metric(wish) @ wish.motion) * wish.reduced.sigma_max
        rounding = 1e-11 * (1 + np.abs(effect).max(initial=0))
        aside = wish.reduced.matrix @ change - share * effect
        assert np.linalg.norm(aside) <= (0 if limiter is SCALING else turn) + rounding


def test_a_limiter_that_keeps_the_direction_gives_all_that_is_worth_its_price():
    """At least the largest share there is less what its help costs, and never less than by scaling."""
    seen, largest = 0, 0
    for wish in wishes(250, seed=2):
        if np.abs(wish.motion).max() < WORTH:
            continue
        optimum, aid = largest_share(wish)
        value = wish.motion @ metric(wish) @ wish.motion
        least = max(optimum - aid @ metric(wish) @ aid / (2 * value), SCALING.limit(wish)[1])
        for limiter in (SATURATION, DIRECTED):
            share = limiter.limit(wish)[1]
            assert least - 1e-6 <= share <= 1
        seen, largest = seen + 1, largest + (abs(share - optimum) < 1e-3)
    assert seen > 200
    assert largest > 0.8 * seen  # help is mostly cheap, and a turn mostly of no use


def test_the_quadratic_program_leaves_less_undone_than_any_other_motion_inside_the_bounds():
    rng = np.random.default_rng(3)
    for wish in wishes(150, seed=3):
        change, share = NEAREST.limit(wish)
        assert 0 <= share <= 1
        assert inside(wish, change)
        least = missed(wish, change) - 1e-7 * (1 + float(wish.motion @ wish.motion))
        others = [limiter.limit(wish)[0] for limiter in (SCALING, SATURATION, DIRECTED, SLIDING)]
        for _ in range(10):
            push = wish.freedom.basis @ rng.normal(size=wish.freedom.basis.shape[1]) * rng.choice([1e-3, 1.0])
            others.append(change + push * wish.bounds.largest_step(wish.qdot + change, push))
        assert all(missed(wish, each) >= least for each in others)


@pytest.mark.parametrize("keep_direction", [False, True])
def test_the_answer_does_not_depend_on_the_backend(keep_direction, monkeypatch):
    """Nor on whether it answers at all: locked joints and huge wishes make solvers fail."""

    def broken(*_, **__):
        raise ValueError("no")

    for wish in wishes(60, seed=4):
        results = [rik.QuadraticProgram(keep_direction, backend).limit(wish) for backend in BACKENDS]
        with monkeypatch.context() as patch:
            patch.setattr(qpsolvers, "solve_qp", broken)
            results.append(rik.QuadraticProgram(keep_direction).limit(wish))
        effects = [wish.reduced.matrix @ change for change, _ in results]
        scale = 1 + np.abs(wish.motion).max()
        for (_, share), effect in zip(results, effects):
            assert_allclose(effect, effects[0], atol=1e-6 * scale)
            assert_allclose(share, results[0][1], atol=1e-6)


def test_the_active_set_method_finds_the_point_where_multipliers_tell_that_nothing_is_better(rng):
    for _ in range(200):
        d, r = int(rng.integers(1, 9)), int(rng.integers(1, 20))
        root = rng.normal(size=(d, d)) * 10.0 ** rng.uniform(-2, 0, d)
        hessian, slope = root.T @ root + 1e-6 * np.eye(d), rng.normal(size=d) * 10.0 ** rng.uniform(-2, 4)
        rows, room = rng.normal(size=(r, d)), np.where(rng.random(r) < 0.3, 0.0, rng.uniform(0, 1, r))
        rows = np.concatenate([rows, np.eye(d), -np.eye(d)])
        room = np.concatenate([room, np.ones(2 * d)])
        y = active_set.minimise(hessian, slope, rows, room, np.zeros(d))
        assert (rows @ y <= room + 1e-9).all()
        gradient = hessian @ y + slope
        # The least of the linearised cost over the constraints is here: the KKT conditions of a convex problem.
        least = linprog(gradient, rows, room, bounds=[(None, None)] * d, method="highs").fun
        assert gradient @ y <= least + 1e-6 * (1 + np.abs(gradient).max())


def test_locked_joints_stop_nothing_that_does_not_need_them(rng):
    """Rounding towards a bound that a joint lies on must not stop the others."""
    for limiter in (SCALING, SATURATION, NEAREST, DIRECTED, SLIDING):
        for _ in range(20):
            J = rng.normal(size=(3, 6))
            J[:, [1, 4]] = 0.0
            box = named_box(np.where(np.isin(range(6), (1, 4)), 0.0, -9), np.where(np.isin(range(6), (1, 4)), 0.0, 9))
            levels = tuple(TaskEquation(each, np.ones(1), np.ones(1)) for each in J[:, None])
            step = rik.TaskPriority(rik.MoorePenrose(), limiter).resolve(VelocityProblem(levels, box))
            if np.abs(step.qdot).max() < 8.9:
                assert (step.scale == 1).all()
                assert step.status is rik.Status.TRACKING


def test_sliding_gives_all_where_keeping_the_direction_does_and_else_no_less_than_it():
    seen = {True: 0, False: 0}
    for wish in wishes(200, seed=6):
        value = wish.motion @ metric(wish)
        kept, share = SATURATION.limit(wish)
        slid, given = SLIDING.limit(wish)
        assert inside(wish, slid)
        if wish.bounds.fastest is None:  # slower at speed limits
            assert value @ slid >= value @ kept - 1e-9 * (1 + abs(value @ wish.motion))
        seen[share == 1] += 1
        if share == 1:
            assert_allclose(given, 1, atol=1e-6)
    assert min(seen.values()) > 50


def test_other_joints_take_over_where_several_stop_the_motion_at_once():
    J = np.array([[1.0, 2, -2, -2], [0, 0, 1, -1]])
    box = named_box([-9.0, 0, 0, -9], [0.0, 0, 0, 9])
    problem = VelocityProblem((TaskEquation(J, np.ones(2), np.ones(2)),), box)
    step = rik.TaskPriority(rik.MoorePenrose(), SATURATION).resolve(problem)
    assert step.scale == [1]
    assert_allclose(step.residual, 0, atol=TURN * np.sqrt(2))


def test_what_is_released_still_counts_as_the_levels_own_motion(rng):
    """Help for the direction must not move the task, in released directions either."""
    for _ in range(20):
        U, Vt = np.linalg.qr(rng.normal(size=(3, 3)))[0], np.linalg.qr(rng.normal(size=(6, 6)))[0][:3]
        equation = TaskEquation((U * [2.0, 1.0, 0.1]) @ Vt, rng.normal(size=3), np.zeros(3))
        problem = VelocityProblem((equation,), named_box(np.full(6, -0.1), np.full(6, 0.1)))
        for limiter in (SATURATION, DIRECTED):
            step = rik.TaskPriority(limiter=limiter, release=0.2).resolve(problem)
            effect = equation.J @ rik.JParse().solve(equation.J, equation.xdot)
            assert_allclose(equation.J @ step.qdot, step.scale[0] * effect, atol=2 * TURN * np.linalg.norm(effect))


def test_other_joints_take_over_all_of_the_wish_or_all_but_the_price():
    J = np.array([[1.0, 1.0]])
    problem = VelocityProblem((TaskEquation(J, np.ones(1), np.ones(1)),), named_box([-1.0, -1.0], [0.2, 1.0]))
    for limiter in (SATURATION, DIRECTED, SLIDING):
        step = rik.TaskPriority(limiter=limiter).resolve(problem)
        assert step.scale == [1]
        assert step.status is rik.Status.TRACKING
        assert_allclose(step.qdot, [0.2, 0.8], atol=1e-6)
    step = rik.TaskPriority(limiter=NEAREST).resolve(problem)
    assert 1 - PRICE < step.scale[0] < 1
    assert_allclose(step.qdot, [0.2, 0.8], atol=PRICE)
    slowed = rik.TaskPriority(limiter=SCALING).resolve(problem)
    assert_allclose(slowed.scale, [0.4], atol=1e-9)
    assert slowed.status is rik.Status.SCALED


def test_narrower_bounds_never_give_the_optimum_a_larger_share(rng):
    for _ in range(30):
        J, xdot = rng.normal(size=(3, 6)), rng.normal(size=3)
        level = (TaskEquation(J, xdot, xdot),)
        size = rng.uniform(0.1, 1, 6)
        for limiter in (SCALING, SATURATION, DIRECTED):
            shares = [
                rik.TaskPriority(limiter=limiter)
                .resolve(VelocityProblem(level, named_box(-c * size, c * size)))
                .scale[0]
                for c in (2.0, 1.0, 0.5, 0.1, 0.0)
            ]
            assert all(a >= b - 1e-9 for a, b in pairwise(shares))


def test_a_level_without_bounds_or_without_freedom_is_left_as_it_is():
    nothing = Freedom(np.zeros((3, 0))).reduce(np.eye(3))
    for limiter in (SCALING, SATURATION, NEAREST, DIRECTED, SLIDING):
        wish = Wish(np.zeros(3), np.zeros(3), nothing, Freedom(np.zeros((3, 0))), Bounds.free(3))
        change, share = limiter.limit(wish)
        assert not change.any()
        assert share == 1


@pytest.mark.parametrize("limiter", [SLIDING, NEAREST, SCALING], ids=repr)
def test_where_only_speed_limits_act_all_joints_are_slower_alike(limiter, rng):
    robot = rik.load("ur5")
    limits = rik.JointLimits.of(robot, lower=-1e3, upper=1e3)
    for _ in range(40):
        q, stack = robot.random(rng), [[rik.TwistTask(rng.normal(size=6) * 10 ** rng.uniform(-1, 1))]]
        free = rik.VelocityController(robot, rik.TaskPriority(limiter=limiter), ()).step(q, stack, 0.01).qdot
        within = rik.VelocityController(robot, rik.TaskPriority(limiter=limiter), limits).step(q, stack, 0.01).qdot
        share = min(1.0, float((robot.velocity_limit / np.abs(free)).min()))
        np.testing.assert_allclose(within, share * free, rtol=1e-9, atol=1e-12)
