"""Relations between joints: their derivatives."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.trig_relations import Factor, Relation

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
