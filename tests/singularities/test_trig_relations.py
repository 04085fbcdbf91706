"""Relations between joints: their derivatives, and functions of angles that are kept."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.trig_relations import Factor, Relation, evaluate, simplest

TURN = 2 * np.pi
ONE, SUM = Angle((1,), (1,), TURN), Angle((1, 2), (1, -1), TURN)
SLIDE = Angle((3,), (1,), np.inf)
TERMS = (
    (),
    (Factor(ONE, "cos", 1.0),),
    (Factor(ONE, "sin", 0.5), Factor(SUM, "cos", 1.5)),
    (Factor(SLIDE, "power", 2.0), Factor(SUM, "sin", 1.0)),
    (Factor(SLIDE, "power", 1.0), Factor(ONE, "cos", 2.0), Factor(SUM, "sin", 1.0)),
)


@pytest.mark.parametrize("batch", [(), (5,), (2, 3)])
def test_slopes_of_a_relation_agree_with_differences(batch, rng):
    relation = Relation(TERMS, rng.uniform(-1, 1, len(TERMS)), 0.0, 1)
    values = rng.uniform(-2, 2, (*batch, 4))
    ends = [relation.of(values + step) - relation.of(values - step) for step in 1e-6 * np.eye(4)]
    assert_allclose(relation.slopes(values), np.stack(ends, axis=-1) / 2e-6, atol=1e-8)
    assert not relation.slopes(values)[..., 0].any()


def test_products_are_the_same_with_functions_that_are_kept(rng):
    values, known = rng.uniform(-2, 2, (7, 4)), {}
    for terms in (TERMS[:3], TERMS, TERMS):
        assert_array_equal(evaluate(terms, values, known), evaluate(terms, values))
    assert len(known) == len({factor for term in TERMS for factor in term})


def test_a_relation_is_the_same_whatever_was_looked_for_at_these_points_before(rng):
    values = rng.uniform(-1, 1, (60, 4))
    values[:, 2] = np.arcsin(0.6 * np.cos(values[:, 1]))
    two = (ONE, Angle((2,), (1,), TURN))
    known = {}
    assert simplest([(Angle((0,), (1,), TURN), ONE)], values, known=known) is None
    found, alone = simplest([two], values, known=known), simplest([two], values)
    assert found is not None
    assert alone is not None
    assert found.terms == alone.terms
    assert_array_equal(found.coefficients, alone.coefficients)
