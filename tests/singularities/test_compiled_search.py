"""Searches in one call of compiled code: they do what NumPy's do, step by step."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.errors import InputError
from robust_ik.singularities.find import compiled_search, projection_search
from robust_ik.singularities.find.compiled_search import LARGEST
from robust_ik.singularities.find.projection_search import TOLERANCE, project, project_by_numpy
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.geometry.screw_chain import ScrewChain, largest_rank
from tests.deficient_arms import KINDS, DeficientArm
from tests.singularities.test_screw_chain import any_chain

NAMES = ("pa10", "srs_10r", "planar_3r", "duleba_3r", "so101", "talos_arm")
BATCHES = (0, 1, 2, 3, 8, 21)
"""None, one alone, too few to go side by side, side by side, all places taken, and more than there are places."""

MARGIN = 500
"""Numbers before and after each array that are looked at."""


def of_robot(name):
    return ScrewChain.of(rik.load(name))


def of_no_robot(seed):
    """Slides, joints that follow others, joints that do not move, one joint, more rows than joints."""
    made = any_chain(seed)
    return replace(made, rank=max(largest_rank(made), 1))


def deficient(kind):
    return ScrewChain.of(DeficientArm.drawn(kind, 0).robot())


def many_joints(count):
    made = any_chain(0)
    rng = np.random.default_rng(count)
    return replace(
        made,
        joint_names=tuple(f"q{i}" for i in range(count)),
        rows=("x", "y", "z", "wx", "wy", "wz"),
        rotations=np.linalg.qr(rng.normal(size=(count, 3, 3)))[0],
        offsets=rng.normal(size=(count, 3)),
        sliding=(False,) * count,
        mixing=np.eye(count),
        lower=np.full(count, -np.pi),
        upper=np.full(count, np.pi),
        period=np.full(count, 2 * np.pi),
        slides=(False,) * count,
    )


CHAINS = [
    *(pytest.param(of_robot, name, id=name) for name in NAMES),
    *(pytest.param(of_no_robot, seed, id=f"any {seed}") for seed in range(25)),
    *(pytest.param(deficient, kind, id=kind) for kind in KINDS),
    *(pytest.param(many_joints, count, id=f"{count} joints") for count in (9, 16)),
]


def assert_same(residual, reference):
    for name in ("s", "derivative", "scale"):
        ours, theirs = getattr(residual, name), getattr(reference, name)
        assert_allclose(ours, theirs, rtol=0, atol=1e-9 * max(1.0, np.abs(theirs).max(initial=0.0)))
    assert (residual.corank, residual.full) == (reference.corank, reference.full)


@pytest.mark.parametrize("made, name", CHAINS)
def test_compiled_searches_end_where_those_of_numpy_end(made, name, rng):
    chain = made(name)
    for corank in range(1, min(3, chain.full_rank) + 1):
        for count in BATCHES:
            starts = chain.random(rng, count)
            given = starts.copy()
            ours, theirs = project(chain, corank, starts), project_by_numpy(chain, corank, starts)
            assert_array_equal(starts, given)
            assert_array_equal(ours.converged, theirs.converged)
            assert_array_equal(ours.tries, theirs.tries)
            assert_allclose(ours.values, theirs.values, rtol=0, atol=1e-9)
            assert_same(ours.residual, theirs.residual)
            assert_same(Residual.at(chain, starts, corank), Residual.by_numpy(chain, starts, corank))


def test_every_chain_here_is_searched_by_compiled_code_and_larger_ones_by_numpy(monkeypatch, rng):
    numpy_s = []
    monkeypatch.setattr(projection_search, "project_by_numpy", lambda *given: numpy_s.append(project_by_numpy(*given)))
    for made, name in (each.values for each in CHAINS):
        chain = made(name)
        project(chain, 1, chain.random(rng, 1))
    assert numpy_s == []
    chain = many_joints(LARGEST + 1)
    project(chain, 1, chain.random(rng, 4))
    (ends,) = numpy_s
    assert ends.converged.all()
    assert_array_equal(ends.residual.relative <= TOLERANCE, True)


@pytest.mark.parametrize("made, name", CHAINS)
def test_nothing_is_written_beside_the_room_that_is_given(made, name, monkeypatch, rng):
    chain, kernel_for = made(name), compiled_search._kernel

    def guarded(small):
        def call(pack, task, rules, kept, room, *filled):
            places = [np.full(each.size + 2 * MARGIN, 7.0) for each in (room, *filled)]
            inner = [place[MARGIN:-MARGIN].reshape(each.shape) for place, each in zip(places, (room, *filled))]
            inner[1][:] = filled[0]
            good = kernel_for(small)(pack, task, rules, kept, *inner)
            for place, each, given in zip(places, inner, (room, *filled)):
                assert (place[:MARGIN] == 7.0).all()
                assert (place[-MARGIN:] == 7.0).all()
                given[:] = each
            return good

        return call

    monkeypatch.setattr(compiled_search, "_kernel", guarded)
    for corank in range(1, min(3, chain.full_rank) + 1):
        for count in BATCHES:
            project(chain, corank, chain.random(rng, count))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_said_as_numpy_says_it(bad, rng):
    chain = of_robot("pa10")
    starts = chain.random(rng, 11)
    starts[7, 2] = bad
    for search in (project, project_by_numpy):
        with pytest.raises(InputError), np.errstate(invalid="ignore"):
            search(chain, 1, starts)


@pytest.mark.parametrize("layout", ["a view", "read-only", "column by column"])
def test_starts_may_lie_in_memory_as_they_like(layout, rng):
    chain = of_robot("pa10")
    starts = chain.random(rng, 6)
    expected = project(chain, 1, starts).values
    given = np.repeat(starts, 2, axis=0)[::2] if layout == "a view" else np.array(starts, order="F")
    given.setflags(write=layout != "read-only")
    assert_array_equal(project(chain, 1, given).values, expected)


def test_no_step_is_tried_where_a_search_ends_at_once(rng):
    chain = of_robot("panda")
    there = project(chain, 1, chain.random(rng, 20))
    again = project(chain, 1, there.values[there.converged])
    assert_array_equal(again.tries, 0)
    assert_array_equal(again.values, there.values[there.converged])
