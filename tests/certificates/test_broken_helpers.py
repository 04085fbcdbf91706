"""Whatever helper of the prover, or of what it shares with the checker, is broken: no untrue verdict survives."""

import inspect
import pkgutil
import signal
import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import cache, wraps
from importlib import import_module

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.certificates import certify, leaves, proof, prover
from robust_ik.certificates.proof import members
from robust_ik.singularities.atlas.search_pieces import ProofOf
from robust_ik.singularities.conditions import RobotFacts

ARMS = [("duleba_3r", 1), ("puma560", 1)]
NEAR = 1e-6
SECONDS = 20
READING = ("json", "untrusted_json", "counted_steps")
"""Modules that only read files and count steps: what they spoil is refused as no proof."""


def helpers():
    """Every function of the prover's modules and of those that it shares with the checker."""
    found = []
    for package in (prover, proof):
        for module in pkgutil.iter_modules(package.__path__, package.__name__ + "."):
            if module.name.rpartition(".")[2] in READING:
                continue
            for name, each in vars(import_module(module.name)).items():
                if inspect.isfunction(each) and each.__module__ == module.name and "json" not in name:
                    found.append(each)
    return found


def spoiled(value):
    """A value of the same kind that is wrong."""
    if isinstance(value, bool | np.bool_):
        return not value
    if isinstance(value, int | float | Fraction):
        return value + 1
    if isinstance(value, tuple | list):
        return value[:-1]
    if isinstance(value, dict):
        return dict(list(value.items())[:-1])
    if isinstance(value, types.GeneratorType | Iterator):
        return iter(list(value)[:-1])
    return value


def broken(function, kind):
    @wraps(function)
    def instead(*given, **named):
        found = function(*given, **named)
        if kind == "nothing":
            return type(found)() if isinstance(found, bool | int | float | tuple | list | dict) else None
        return spoiled(found)

    return instead


@contextmanager
def in_place_of(function, other):
    """Puts another function wherever the certificates use one."""
    places = [
        (module, name)
        for key, module in sys.modules.items()
        if key.startswith(("robust_ik.certificates", "robust_ik.singularities"))
        for name, value in vars(module).items()
        if value is function
    ]
    for module, name in places:
        setattr(module, name, other)
    try:
        yield
    finally:
        for module, name in places:
            setattr(module, name, function)


class TooLongError(Exception):
    """What a broken helper makes go on for ever."""


def _stop(*_):
    raise TooLongError


@cache
def true_points(name, corank):
    """Points of every leaf of the arm, and the number of leaves' places."""
    robot = rik.load(name)
    found = [place for leaf in leaves(certify(robot, corank, thorough=False)) for place in leaf.places]
    rng = np.random.default_rng(0)
    return [members(place, rng, 5) for place in found]


def verdict_of(name, corank):
    """A proof of what an atlas analyses, and whether it is accepted there."""
    facts = RobotFacts.of(rik.load(name), None, None, None, False)
    outcome = ProofOf(facts.chain, facts.exact, facts.inexact, corank).run()
    return outcome.proof, outcome.accepted


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wrong", "nothing"])
@pytest.mark.parametrize(
    "function", helpers(), ids=lambda each: f"{each.__module__.rpartition('.')[2]}.{each.__name__}"
)
def test_no_verdict_survives_that_is_not_true(function, kind):
    for name, corank in ARMS:
        wanted = true_points(name, corank)
        before = signal.signal(signal.SIGALRM, _stop)
        signal.alarm(SECONDS)
        try:
            with in_place_of(function, broken(function, kind)):
                found, accepted = verdict_of(name, corank)
        except Exception:  # a proof that fails says nothing
            continue
        finally:
            signal.alarm(0)
            signal.signal(signal.SIGALRM, before)
        if not accepted:
            continue
        places = [place for leaf in leaves(found) for place in leaf.places]
        for points in wanted:
            off = np.min([np.full(len(points), np.inf), *(each.residual(points) for each in places)], axis=0)
            assert off.max() < NEAR, f"{name}: a stratum is missing, and the list is certified"
        assert len(places) == len(wanted), f"{name}: another number of leaves, and the list is certified"


@pytest.mark.parametrize(("name", "corank"), ARMS)
def test_with_whole_helpers_the_arms_are_certified(name, corank):
    found, accepted = verdict_of(name, corank)
    assert accepted
    assert len([place for leaf in leaves(found) for place in leaf.places]) == len(true_points(name, corank))


def test_helpers_are_found():
    names = {each.__name__ for each in helpers()}
    assert len(names) > 60
    assert {"split", "factor", "real_roots", "members"} <= names
