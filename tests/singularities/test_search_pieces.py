"""Pieces of a search: those that one process does at once have the bits of each alone."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import robust_ik as rik
from robust_ik.singularities.atlas.search_pieces import TOGETHER, Chunk, run_together, together
from robust_ik.singularities.find.points_found import ARRAYS
from robust_ik.singularities.geometry.screw_chain import ScrewChain


def chunks(name, corank, count, starts=40, method="projection"):
    its = ScrewChain.of(rik.load(name))
    return [Chunk(its, corank, starts - index, (7, index), method, 1e-11) for index in range(count)]


@pytest.mark.parametrize(("name", "corank"), [("puma560", 2), ("panda", 1), ("ur5", 3), ("planar_3r", 1)])
def test_searches_that_go_together_find_what_each_finds_alone(name, corank):
    pieces = chunks(name, corank, 3)
    for found, piece in zip(run_together(pieces), pieces, strict=True):
        alone = piece.run()
        for each in ARRAYS:
            assert_array_equal(getattr(found, each), getattr(alone, each))


def test_only_chunks_of_one_search_go_together_and_not_too_many():
    one, other, slow = (chunks("puma560", *rest) for rest in ((1, 2 * TOGETHER), (2, 2), (2, 2, 40, "gradient")))
    pieces = [*one, *other, *slow]
    groups = together(pieces)
    assert [len(group) for group in groups] == [TOGETHER, TOGETHER, 2, 1, 1]
    assert all(a is b for a, b in zip([piece for group in groups for piece in group], pieces, strict=True))


def test_no_pieces_are_no_groups():
    assert together([]) == []
    assert np.size(run_together([])) == 0
