"""What every test may use."""

import os
import signal
from collections import Counter

import numpy as np
import pytest
from hypothesis import settings

from robust_ik.analysis import newton_iteration
from robust_ik.simulation import simulator

# The same examples in every run: a failure is then a change's, and shows again.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

MOVED_STARTS = "ROBUST_IK_MOVED_STARTS"
"""The variable that says by how much, in rad or m, runs start beside where they should: what holds must hold there."""


QUICK = 1
"""How many sets of parameters of a test are run at --quick."""


def pytest_addoption(parser):
    parser.addoption("--quick", action="store_true", help="no slow tests, and of each test the first parameters only")


def pytest_configure():
    """Lets Ctrl-C interrupt, also what tests start: shells have it ignored by what they run in the background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config, items):
    """At --quick, drops what is marked slow, the notebooks, and all but the first parameters of each test."""
    if not config.getoption("--quick"):
        return
    seen, kept, dropped = Counter(), [], []
    for item in items:
        name = item.nodeid.partition("[")[0]
        seen[name] += 1
        slow = item.get_closest_marker("slow") or item.path.suffix != ".py"
        (dropped if slow or seen[name] > QUICK else kept).append(item)
    config.hook.pytest_deselected(items=dropped)
    items[:] = kept


@pytest.fixture
def rng():
    """The same random numbers for every run of a test."""
    return np.random.default_rng(20260)


@pytest.fixture(autouse=True)
def _moved_starts(request, monkeypatch):
    """Moves the starts of simulations and iterations, unless a test says that it is about the exact one."""
    size = float(os.environ.get(MOVED_STARTS, "0"))
    if size and not request.node.get_closest_marker("exact_start"):
        move_starts(monkeypatch, size)


def aside(size, length):
    return size * np.random.default_rng(1).normal(size=length)


def moved_start(robot, q):
    """Where a loop that a test runs itself starts: at q, or as far beside it as `MOVED_STARTS` says."""
    return robot.integrate(q, aside(float(os.environ.get(MOVED_STARTS, "0")), robot.n))


def move_starts(monkeypatch, size):
    run, vector = simulator._run, newton_iteration._vector

    def moved_run(controller, motion, q, *rest):
        return run(controller, motion, controller.robot.integrate(q, aside(size, controller.robot.n)), *rest)

    def moved_vector(values, name, *rest):
        found = vector(values, name, *rest)
        return found + aside(size, found.size) if name == "q0" else found

    monkeypatch.setattr(simulator, "_run", moved_run)
    monkeypatch.setattr(newton_iteration, "_vector", moved_vector)
