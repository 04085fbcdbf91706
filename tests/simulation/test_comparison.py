"""Scenarios with several methods each, run side by side."""

import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.runtime.parallel import process_pool


def line(name="line", **options):
    robot = rik.load("planar_2r")
    q0 = robot.configuration([0.3, 0.9])
    path = rik.Line(robot.pose(q0), [1.0, 0.0, 0.4], speed=0.5)
    methods = {"calm": rik.JParse(gamma=0.2), "remembers": rik.KelmarKhosla()}
    return rik.Scenario(name, robot, q0, rik.Follow(path, gain=5.0), duration=0.3, methods=methods, **options)


def assert_same(one, other):
    for each in fields(one):
        a, b = getattr(one, each.name), getattr(other, each.name)
        if isinstance(a, np.ndarray) and a.dtype != object:
            assert a.tobytes() == b.tobytes(), each.name
            assert not b.flags.writeable
        elif each.name in ("status", "active", "contradictions"):
            assert list(a) == list(b)


def test_every_scenario_is_run_with_the_methods_that_it_names():
    runs = rik.compare([line(), line("short", dt=0.05)])
    assert {name: list(each) for name, each in runs.items()} == {
        "line": ["calm", "remembers"],
        "short": ["calm", "remembers"],
    }
    assert len(runs["line"]["calm"].time) == 30
    assert len(runs["short"]["calm"].time) == 6
    assert_same(rik.simulate(line(), "calm"), runs["line"]["calm"])
    assert runs["line"]["calm"].name == "calm"


def test_other_methods_take_the_place_of_those_it_names():
    (runs,) = rik.compare(line(), {"mine": rik.DampedLeastSquares()}).values()
    assert list(runs) == ["mine"]


@pytest.mark.exact_start
@pytest.mark.slow
def test_runs_are_the_same_whoever_runs_them():
    scenarios = [line(), rik.load_scenario("jparse_2r")]
    scenarios = [replace(each, duration=0.5, limits=None) for each in scenarios]
    told = []
    alone = rik.compare(scenarios)
    with process_pool(2) as pool:
        shared = rik.compare(scenarios, executor=pool, progress=lambda *counts: told.append(counts))
    assert told[-1] == (len(told), len(told))
    for scenario in scenarios:
        assert list(alone[scenario.name]) == list(shared[scenario.name])
        for label, run in alone[scenario.name].items():
            assert_same(run, shared[scenario.name][label])
            assert shared[scenario.name][label].robot is scenario.robot


def test_scenarios_travel_between_processes():
    scenario = line()
    back = pickle.loads(pickle.dumps(scenario))
    assert dict(back.methods) == dict(scenario.methods)
    assert not back.q0.flags.writeable
    with pytest.raises(TypeError):
        back.methods["new"] = rik.JParse()


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(rik.InputError, match="a name of its own, got line, line"):
        rik.compare([line(), line()])
    with pytest.raises(rik.InputError, match="line names no methods"):
        rik.compare(line(), {})
    with pytest.raises(rik.InputError, match="method 'odd' must be an inverse or a resolver"):
        rik.compare(line(), {"odd": 3})
