"""Paths followed point by point by Newton's iteration."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik import InputError
from robust_ik.simulation.scenarios import load_scenario, reach_points

LINE = load_scenario("puma_wrist")
"""Six rows, feed-forward, a gain of 10: none of it matters here."""


@pytest.mark.exact_start
def test_every_point_is_reached_and_each_starts_where_the_one_before_ended():
    times = [0.0, 0.5, 1.0]
    results = reach_points(LINE, "pseudo-inverse", times, tolerance=1e-10)
    assert all(found.converged for found in results)
    assert results[0].iterations == 0
    assert_allclose(results[0].path[0], LINE.q0)
    for before, after in itertools.pairwise(results):
        assert_allclose(after.path[0], before.q, rtol=0)
    for time, found in zip(times, results):
        assert_allclose(LINE.robot.pose(found.q), LINE.motion.path(time), atol=1e-9)


def test_the_step_is_the_share_of_the_error_that_is_asked_for():
    (short,) = reach_points(LINE, "pseudo-inverse", [0.1], step=0.25, max_iterations=12)
    assert short.status is rik.NewtonStatus.ITERATION_LIMIT
    assert_allclose(short.errors[1:] / short.errors[:-1], 0.75, atol=0.02)


def test_a_simulation_takes_one_iteration_for_each_time_step():
    axis = load_scenario("duleba_axis")
    run = rik.simulate(replace(axis, duration=0.1), "Algorithm 2")
    stepped = reach_points(axis, "Algorithm 2", run.time, max_iterations=1, tolerance=1e-15)
    assert_allclose(run.q[1:], [found.q for found in stepped[:-1]], atol=1e-12)


def test_an_inverse_that_needs_the_hessian_gets_it():
    far = [1.0]
    halley, plain = (reach_points(LINE, each, far, tolerance=1e-10)[0] for each in (rik.Halley(), rik.MoorePenrose()))
    assert halley.converged
    assert halley.iterations < plain.iterations


def test_what_cannot_be_meant_is_refused():
    with pytest.raises(InputError, match="no method 'wild'"):
        reach_points(LINE, "wild", [0.0])
    with pytest.raises(InputError, match="iterated for with an inverse, got TaskPriority"):
        reach_points(LINE, rik.TaskPriority(), [0.0])
    with pytest.raises(InputError, match="puma_wrist follows no path: its motion is list"):
        reach_points(replace(LINE, motion=[[rik.FrameTask(np.eye(4))]]), rik.JParse(), [0.0])
