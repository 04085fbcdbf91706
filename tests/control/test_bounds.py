"""Bounds on velocities: together, steps inside them, and where to start."""

from dataclasses import replace

import numpy as np
import pytest
import qpsolvers
from numpy.testing import assert_allclose

from robust_ik.control.bounds import Bounds
from robust_ik.control.within_bounds.feasible_start import PRICE, ROUNDS, feasible_start
from tests.cases_resolvers import BOXES, named_box, random_bounds


def with_rows(box, rows, floor):
    return Bounds.of_rows(rows, floor, tuple(f"pair{i}" for i in range(len(floor)))).within(box)


def random_rows(rng, box):
    """Rows of very different lengths with floors from far below to beyond what the box allows each of them."""
    count, n = int(rng.integers(1, 6)), len(box.lower)
    rows = rng.normal(size=(count, n)) * 10 ** rng.uniform(-2, 1, (count, 1))
    reach = np.maximum(rows * box.lower, rows * box.upper).sum(axis=1)
    floor = np.where(rng.random(count) < 0.3, -0.5, rng.uniform(0, 1.2, count) * reach * rng.choice([0.1, 0.5, 1.0]))
    return rows, floor, reach


def test_within_gives_what_is_in_both_and_names_who_set_it():
    weak = replace(
        named_box([-3, -1, 0.0], [1, 3, 5]), lower_cause=np.array(["a"] * 3), upper_cause=np.array(["b"] * 3)
    )
    both = weak.within(named_box([-2, -2, -2], [2, 2, 2]))
    assert_allclose([both.lower, both.upper], [[-2, -1, 0], [1, 2, 2]])
    assert both.lower_cause.tolist() == ["joint0 lower", "a", "a"]
    assert both.upper_cause.tolist() == ["b", "joint1 upper", "joint2 upper"]
    assert both.contradictions == ()


def test_the_stronger_box_wins_a_contradiction_which_is_named_and_sets_both_ends():
    weak = replace(named_box([3, -9], [4, -8]), lower_cause=np.array(["a", "b"]), upper_cause=np.array(["c", "d"]))
    both = weak.within(named_box([-2, -2], [2, 2]))
    assert_allclose([both.lower, both.upper], [[2, -2], [2, -2]])
    assert both.contradictions == ("a", "d")
    assert both.lower_cause.tolist() == ["joint0 upper", "joint1 lower"]
    assert both.upper_cause.tolist() == ["joint0 upper", "joint1 lower"]
    assert both.active(np.array([2.0, -2])) == ("joint0 upper", "joint1 lower")


def test_bounds_that_cross_by_rounding_are_no_contradiction():
    assert named_box([1 + 1e-10], [2]).within(named_box([0], [1])).contradictions == ()
    assert named_box([1 + 1e-8], [2]).within(named_box([0], [1])).contradictions == ("joint0 lower",)


def test_the_order_of_limits_that_do_not_contradict_each_other_does_not_matter(rng):
    for _ in range(50):
        boxes = [named_box(-rng.uniform(0, 2, 4), rng.uniform(0, 2, 4)) for _ in range(2)]
        one, other = boxes[0].within(boxes[1]), boxes[1].within(boxes[0])
        assert (one.lower == other.lower).all()
        assert (one.upper == other.upper).all()


def test_the_largest_step_is_inside_and_a_larger_one_is_not(rng):
    for _ in range(300):
        bounds = random_bounds(rng, int(rng.integers(1, 8)))
        qdot, bounds = feasible_start(bounds)
        change = rng.normal(size=len(qdot)) * 10.0 ** rng.uniform(-3, 4)
        share = bounds.largest_step(qdot, change)
        assert 0 <= share <= 1
        assert bounds.contains(qdot + share * change, 1e-11)
        if share < 1:
            assert not bounds.contains(qdot + (share * (1 + 1e-6) + 1e-9) * change, 0.0)


def test_rounding_towards_a_bound_stops_nothing():
    box = named_box([-1, 0.0], [1, 0.0])
    assert box.largest_step(np.zeros(2), np.array([0.5, 1e-17])) == 1
    assert box.largest_step(np.zeros(2), np.array([0.5, 1e-3])) < 1e-8


def test_without_bounds_nothing_is_active_and_every_step_is_whole(rng):
    free = Bounds.free(3)
    assert free.largest_step(np.zeros(3), 1e9 * rng.normal(size=3)) == 1
    assert free.active(np.zeros(3)) == ()
    assert free.contains(np.full(3, 1e300))


def test_a_start_is_at_rest_where_rest_is_inside_else_where_the_box_is_nearest(rng):
    for kind in BOXES:
        if kind == "rows":
            continue
        bounds = random_bounds(rng, 6, kind)
        qdot, same = feasible_start(bounds)
        assert_allclose(qdot, np.clip(0.0, bounds.lower, bounds.upper))
        assert same is bounds


def shortest_change(qdot, bounds):
    """Multipliers of the floors above rest in the shortest motion that reaches all floors; None if there is none."""
    lengths = np.linalg.norm(bounds.rows, axis=1)
    rows, floor = bounds.rows / lengths[:, None], bounds.floor / lengths
    below = rows @ qdot < floor
    floor = np.where(below, floor, np.minimum(floor, rows @ qdot))
    program = qpsolvers.Problem(np.eye(len(qdot)), np.zeros(len(qdot)), -rows, -floor, lb=bounds.lower, ub=bounds.upper)
    found = qpsolvers.solve_problem(program, solver="daqp")
    return found.z[below] if found.found else None


def test_the_box_always_holds_and_rows_come_as_near_to_their_floor_as_the_price_allows(rng):
    reachable = 0
    for _ in range(250):
        box = random_bounds(rng, int(rng.integers(1, 9)), rng.choice(["inside", "outside", "locked", "on a bound"]))
        rows, floor, _ = random_rows(rng, box)
        bounds = with_rows(box, rows, floor)
        qdot, found = feasible_start(bounds)
        assert ((qdot >= box.lower) & (qdot <= box.upper)).all()
        assert found.contains(qdot)
        lengths, rest = np.linalg.norm(rows, axis=1), np.clip(0.0, box.lower, box.upper)
        assert (rows @ qdot >= np.minimum(floor, rows @ rest) - 1e-9 * lengths).all()  # none goes further below
        short = np.maximum(floor - rows @ qdot, 0)
        assert set(found.contradictions) >= {f"pair{i}" for i in np.flatnonzero(short > 1e-9)}
        assert set(found.contradictions) <= {f"pair{i}" for i in np.flatnonzero(short > 0)}
        multipliers = shortest_change(rest, bounds)
        if multipliers is None:
            assert found.contradictions
            continue
        reachable += 1
        most = PRICE * np.linalg.norm(multipliers) / np.sqrt(ROUNDS)
        assert np.linalg.norm(short / lengths) <= most + 1e-6
    assert reachable > 50


@pytest.mark.parametrize("free", [1.0, 0.5, 0.3, 0.1, 0.03, 1e-3, 1e-6])
def test_a_row_that_joints_hardly_change_makes_none_of_them_fast(free):
    row = np.array([[np.sqrt(1 - free * free), free]])
    held = named_box([0.0, -1e9], [0.0, 1e9])
    qdot, found = feasible_start(with_rows(held, row, np.array([1.0])))
    missed = (1 + free * free / PRICE) ** -ROUNDS
    assert_allclose(qdot, [0.0, (1 - missed) / free], rtol=1e-6)
    assert qdot[1] <= 6.2
    assert_allclose(found.floor, min(1.0, free * qdot[1]), rtol=1e-9)


def test_a_start_changes_no_faster_than_floors_and_boxes_where_rows_begin_to_contradict_each_other(rng):
    """Two rows that nearly oppose each other, their floors from possible to contradictory, a joint that must move."""
    for _ in range(30):
        apart = 10.0 ** rng.uniform(-6, -0.5)
        one = rng.normal(size=4)
        one /= np.linalg.norm(one)
        rows = np.array([one, apart * rng.normal(size=4) - one])
        rows[1] /= np.linalg.norm(rows[1])
        starts = []
        for step in np.linspace(-0.02, 0.02, 81):
            box = named_box([0.1, *[-1e3] * 3], [0.1, *[1e3] * 3])
            starts.append(feasible_start(with_rows(box, rows, np.array([0.1 + step, step])))[0])
        changes = np.abs(np.diff(starts, axis=0)).max()
        assert changes <= 20 * 0.0005 * np.sqrt(2)


def test_rows_that_the_box_does_not_let_reach_their_floor_are_named_and_the_others_are_reached():
    rows, floor = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]), np.array([5.0, 0.5, -1.0])
    qdot, found = feasible_start(with_rows(named_box([-1] * 3, [1] * 3), rows, floor))
    assert_allclose(qdot, [1, 0.5, 0], atol=1e-9)
    assert found.contradictions == ("pair0",)
    assert_allclose(found.floor, [1, 0.5, -1], atol=1e-9)


def test_rows_that_contradict_each_other_are_named_and_none_gets_worse():
    rows, floor = np.array([[1.0, 1.0], [-1.0, -1.0]]), np.array([0.3, 0.1])
    qdot, found = feasible_start(with_rows(named_box([-1] * 2, [1] * 2), rows, floor))
    assert found.contradictions == ("pair0", "pair1")
    assert_allclose(qdot, [0, 0], atol=1e-12)
    one_holds = feasible_start(with_rows(named_box([-1] * 2, [1] * 2), rows, np.array([0.3, -0.1])))
    assert one_holds[1].contradictions == ("pair0",)
    assert_allclose(rows[1] @ one_holds[0], -0.1, atol=1e-9)


def test_a_row_of_zeros_that_asks_for_motion_is_a_contradiction():
    qdot, found = feasible_start(with_rows(named_box([-1], [1]), np.zeros((1, 1)), np.array([0.1])))
    assert qdot == [0]
    assert found.contradictions == ("pair0",)
    assert feasible_start(with_rows(named_box([-1], [1]), np.zeros((1, 1)), np.array([-0.1])))[1].contradictions == ()


def test_a_start_is_no_faster_than_the_rows_need(rng):
    for _ in range(50):
        row = rng.normal(size=(1, 5))
        qdot, _ = feasible_start(with_rows(named_box([-100] * 5, [100] * 5), row, np.array([0.3])))
        assert_allclose(qdot, 0.3 * row[0] / (row @ row[0]), atol=1e-9)
