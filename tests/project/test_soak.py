"""The soak in short, and that each of its checks can fail."""

import dataclasses
import inspect
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.compiled_loop.compiled_steps import CompiledSteps
from robust_ik.control.resolvers import priority_resolver
from robust_ik.simulation.scenarios import method_tables
from tests import soak
from tests.cases_resolvers import RESOLVERS

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_no_promise_is_broken_in_more_than_a_thousand_random_steps():
    counts = soak.soak(soak.load_robots(), 1_500, seed=0)
    assert sum(counts.values()) == 1_500
    assert all(count > 0 for count in counts.values())


def public(base):
    """Every public class derived from one, but those that only people derive from."""
    found = (getattr(rik, name) for name in rik.__all__)
    return [
        each for each in found if isinstance(each, type) and issubclass(each, base) and not inspect.isabstract(each)
    ]


def test_every_task_limit_resolver_and_limiter_is_mixed_and_has_its_place_in_the_docs(rng):
    panda, page = rik.load("panda"), (ROOT / "docs" / "task_stacks.md").read_text(encoding="utf-8")
    mixed = {type(task) for _ in range(200) for level in soak.random_stack(panda, rng) for task in level}
    assert set(public(rik.Task)) - mixed == {rik.Reach}  # whole motions are its business
    used = Path(soak.__file__).read_text(encoding="utf-8")
    for limit in public(rik.Limit):
        assert f"rik.{limit.__name__}.of" in used
    assert set(public(rik.Resolver)) <= set(method_tables.RESOLVERS)
    assert {type(each) for each in RESOLVERS} >= set(public(rik.Resolver))
    assert set(public(rik.Limiter)) <= set(method_tables.LIMITERS)
    for base in (rik.Task, rik.Limit, rik.Resolver, rik.Limiter):
        for each in public(base):
            assert f"`{each.__name__}" in page, each


def spoil(monkeypatch, change):
    """Every step of a strict resolver with its resolution changed."""
    resolve = priority_resolver.PriorityResolver.resolve

    def spoilt(self, problem):
        return change(problem, resolve(self, problem))

    monkeypatch.setattr(priority_resolver.PriorityResolver, "resolve", spoilt)
    by_numpy(monkeypatch)


def by_numpy(monkeypatch):
    """Lets NumPy make every step."""
    monkeypatch.setattr(CompiledSteps, "step", lambda *_: None)


def changed(resolution, **values):
    fields = {name: getattr(resolution, name) for name in ("qdot", "levels", "active", "contradictions", "status")}
    return rik.Resolution(**fields | values)


def first_changed(step, **values):
    """The resolution with its first level changed."""
    names = ("scale", "residual", "sigma", "corank", "kinematic_corank", "algorithmic")
    fields = {name: getattr(step.levels[0], name) for name in names}
    return changed(step, levels=(rik.LevelResult(**fields | values), *step.levels[1:]))


SPOILT = {
    "not finite": lambda problem, step: changed(step, qdot=step.qdot * np.nan),
    "speed": lambda problem, step: changed(step, qdot=step.qdot + 5.0),
    "acceleration": lambda problem, step: changed(step, contradictions=(), status=rik.Status.SCALED),
    "status": lambda problem, step: changed(step, status=rik.Status.INFEASIBLE),
    "shares": lambda problem, step: first_changed(step, scale=1.1),
    "first level": lambda problem, step: first_changed(step, residual=step.residual + 1e-6 * len(problem.levels)),
    "scale": lambda problem, step: first_changed(step, scale=0.5 ** len(problem.levels)),
}


@pytest.mark.parametrize("promise", SPOILT)
def test_the_soak_finds_a_broken_promise(monkeypatch, promise):
    spoil(monkeypatch, SPOILT[promise])
    with pytest.raises(AssertionError, match=f"^{promise}"):
        soak.soak([rik.load(name) for name in ("panda", "ur5")], 3_000, seed=1)


def test_the_soak_finds_joints_that_do_not_brake(monkeypatch):
    by_numpy(monkeypatch)
    monkeypatch.setattr("robust_ik.control.limits.joint_limits.braking_speed", lambda room, *_: np.full_like(room, 9.0))
    with pytest.raises(AssertionError, match="^position"):
        soak.soak([rik.load("panda")], 3_000, seed=1)


def test_the_soak_finds_joints_that_do_not_come_back(monkeypatch):
    ceiling = rik.JointLimits._ceiling
    monkeypatch.setattr(rik.JointLimits, "_ceiling", lambda *given: np.maximum(ceiling(*given), 0.0))
    monkeypatch.setattr(soak, "random_start", lambda robot, limits, rng: robot.configuration(limits.upper + 0.1))
    with pytest.raises(AssertionError, match="^return"):
        soak.soak([rik.load("panda")], 3_000, seed=1)


def test_the_soak_finds_links_that_come_too_near(monkeypatch):
    monkeypatch.setattr(soak, "COLLIDING", 1.0)
    within = Bounds.within

    def deaf(self, stronger):
        """Without the rows."""
        both = within(self, stronger)
        return dataclasses.replace(both, rows=both.rows[:0], floor=both.floor[:0], row_cause=())

    monkeypatch.setattr(Bounds, "within", deaf)
    with pytest.raises(AssertionError, match="^distance"):
        soak.soak([rik.load("panda")], 3_000, seed=1)


def test_the_soak_of_motions_counts_what_comes_to_rest_and_tells_what_shakes(monkeypatch):
    calm = soak.closed_loop.Ending(0.0, 0.0, False, 0.0, 1.0)
    monkeypatch.setattr(soak.closed_loop, "run", lambda draw, **_: calm)
    assert soak.loops(3, 0) == ({"arrived": 3}, [])
    outside = dataclasses.replace(calm, error=1.0, outside=1e-6)
    monkeypatch.setattr(soak.closed_loop, "run", lambda draw, **_: outside)
    counts, broken = soak.loops(20, 0)
    assert counts.total() == 20
    assert set(counts) == {"rest elsewhere", "elsewhere with noise, without shaking"}
    assert broken
    assert all("outside by 1e-06" in each for each in broken)
    creeping = dataclasses.replace(calm, error=1.0, speed=0.01)

    def slow(draw, seconds=60.0, **_):
        return creeping if seconds < soak.LONGER or draw.dt == 0.02 else dataclasses.replace(creeping, speed=0.0)

    monkeypatch.setattr(soak.closed_loop, "run", slow)
    counts, broken = soak.loops(40, 0, ("joints",))
    assert not broken
    words = {"elsewhere with noise, without shaking", "creep, then rest elsewhere", "still on their way"}
    assert set(counts) == words
    shaking = dataclasses.replace(calm, chatters=True)
    monkeypatch.setattr(soak.closed_loop, "run", lambda draw, **_: shaking)
    counts, broken = soak.loops(3, 0)
    assert not counts
    assert len(broken) == 3


def test_no_limit_is_broken_in_thousands_of_steps_of_prepared_loops():
    assert soak.prepared(20_000, seed=3) >= 20_000


@pytest.mark.parametrize("broken", ["not finite", "speed", "position", "acceleration"])
def test_each_check_of_prepared_loops_can_fail(broken):
    robot = rik.load("ur5")
    limits = rik.JointLimits.of(robot, lower=-2.0, upper=2.0, velocity=1.0, acceleration=2.0)
    goal = robot.configuration(np.full(6, 1.0))
    loop = rik.ControlLoop(rik.VelocityController(robot, None, limits), [[rik.PostureTask(goal, gain=5.0)]], 0.01)
    starts = np.zeros((3, 6))
    found = loop.runs(starts, 50)
    soak.check_runs(robot, limits, 0.01, starts, found, "")
    q, qdot = found.q.copy(), found.qdot.copy()
    if broken == "position":
        q[1, 20, 3] = 2.1
    else:
        qdot[1, 20, 3] = {"not finite": np.nan, "speed": 1.1, "acceleration": -0.5}[broken]
    with pytest.raises(AssertionError, match=broken):
        soak.check_runs(robot, limits, 0.01, starts, dataclasses.replace(found, q=q, qdot=qdot), "")


def test_no_motion_is_begun_after_the_time_that_is_given(monkeypatch, capsys):
    still = soak.closed_loop.Ending(0.0, 0.0, False, 0.0, 1.0)
    monkeypatch.setattr(soak.closed_loop, "run", lambda draw, **_: still)
    with ThreadPoolExecutor(1) as pool:
        assert soak.soak_loops(1_200, 0, pool, ("joints",)) == 0
        assert "1,200 motions of 12 arms (joints)" in capsys.readouterr().out
        assert soak.soak_loops(1_200, 0, pool, ("joints",), minutes=0.0) == 0
        assert "\n0 motions" in "\n" + capsys.readouterr().out.split("\n", 1)[-1]
