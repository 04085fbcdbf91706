"""Projections of many configurations at once, and differences of angles one at a time."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import robust_ik as rik
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.geometry.screw_chain import ScrewChain


@pytest.mark.parametrize("tolerance", [1e-11, 1e-14, 0.0])
@pytest.mark.parametrize("corank", [1, 2])
@pytest.mark.parametrize("name", ["pa10", "panda", "srs_10r", "duleba_3r"])
def test_a_batch_ends_where_each_search_alone_ends(name, corank, tolerance, rng):
    chain = ScrewChain.of(rik.load(name))
    starts = chain.random(rng, 20)
    ends = project(chain, corank, starts, tolerance)
    assert len(set(ends.tries.tolist())) > 1
    for index in range(len(starts)):
        alone = project(chain, corank, starts[index : index + 1], tolerance)
        assert_array_equal(alone.values[0], ends.values[index])
        assert_array_equal(alone.residual.s[0], ends.residual.s[index])
        assert_array_equal(alone.residual.derivative[0], ends.residual.derivative[index])
        assert alone.residual.scale[0] == ends.residual.scale[index]
        assert (alone.tries[0], alone.converged[0]) == (ends.tries[index], ends.converged[index])


def test_none_at_all_can_be_projected():
    ends = project(ScrewChain.of(rik.load("pa10")), 1, np.empty((0, 7)))
    assert ends.values.shape == (0, 7)
    assert ends.converged.shape == ends.tries.shape == (0,)


@pytest.mark.parametrize("period", [2 * np.pi, 1.0, np.inf])
def test_a_number_is_wrapped_as_an_array_is(period, rng):
    exact = period * np.array([-2, -1.5, -1, -0.5, 0, 0.5, 1, 1.5]) if np.isfinite(period) else np.arange(3.0)
    for value in (*rng.uniform(-20, 20, 50), *exact, np.inf, np.nan):
        with np.errstate(invalid="ignore"):
            assert_array_equal(wrapped(float(value), period), wrapped(np.array([value]), period)[0])
