"""Relations fitted to points: their bases, and that the quick test never leaves out what fits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from robust_ik.singularities.conditions import relation_fitting
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.relation_bases import Basis, linear_bases, other_bases, product_bases
from robust_ik.singularities.conditions.relation_fitting import simplest
from robust_ik.singularities.conditions.trig_relations import evaluate

TURN = 2 * np.pi
FIRST, SECOND, THIRD = (Angle((joint,), (1,), TURN) for joint in range(3))
SUM, SLIDE = Angle((1, 2), (1, -1), TURN), Angle((3,), (1,), np.inf)


@pytest.mark.parametrize("bases", [linear_bases, product_bases, other_bases])
@pytest.mark.parametrize("angles", [(FIRST,), (FIRST, SLIDE), (SECOND, SUM), (FIRST, SECOND, THIRD)])
def test_a_basis_has_the_values_and_the_number_of_its_terms(bases, angles, rng):
    values, known = rng.uniform(-2, 2, (7, 4)), {}
    for basis in bases(angles):
        products = basis.at(values, known)
        assert_array_equal(products, evaluate(basis.terms, values))
        assert_array_equal(basis.at(values, known), products)
        assert len(basis) == len(basis.terms) == products.shape[1]


def test_a_relation_is_the_same_whatever_was_looked_for_at_these_points_before(rng):
    values = rng.uniform(-1, 1, (60, 4))
    values[:, 2] = np.arcsin(0.6 * np.cos(values[:, 1]))
    known = {}
    assert simplest([(FIRST, SECOND)], values, known=known) is None
    found, alone = simplest([(SECOND, THIRD)], values, known=known), simplest([(SECOND, THIRD)], values)
    assert found is not None
    assert alone is not None
    assert found.terms == alone.terms
    assert_array_equal(found.coefficients, alone.coefficients)


def family(rng, noise, strays):
    """Points of c2 = a c1 + b s3, of c2 = a, or of nothing; some of them off, as points at crossings are."""
    values = rng.uniform(-1, 1, (int(rng.integers(60, 250)), 4))
    a, b = rng.uniform(-0.4, 0.4, 2)
    kind = rng.integers(3)
    if kind == 0:
        values[:, 1] = np.arccos(a * np.cos(values[:, 0]) + b * np.sin(values[:, 2]))
    elif kind == 1:
        values[:, 1] = np.arccos(a)
    values += noise * rng.standard_normal(values.shape)
    off = rng.random(len(values)) < strays
    values[off] += rng.uniform(-0.1, 0.1, (int(off.sum()), 4))
    return values


@pytest.mark.parametrize("strays", [0.0, 0.03, 0.2])
@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-9, 1e-7, 1e-5])
def test_the_quick_test_leaves_out_nothing_that_fits(noise, strays, monkeypatch, rng):
    choices, met = [(FIRST, SECOND, THIRD), (FIRST, THIRD), (SECOND,), (SECOND, SUM)], 0
    for _ in range(6):
        values = family(rng, noise, strays)
        for odd in (False, True):
            quick = simplest(choices, values, odd=odd)
            with monkeypatch.context() as patch:
                patch.setattr(relation_fitting, "_may_fit", lambda products, limits: np.ones(len(products), bool))
                slow = simplest(choices, values, odd=odd)
            assert (quick is None) == (slow is None)
            if quick is not None:
                met += 1
                assert quick.terms == slow.terms
                assert_allclose(quick.coefficients, slow.coefficients, atol=1e-15)
    assert met or noise > 1e-9 or strays > 0.1


def test_the_quick_test_leaves_out_most_bases_of_points_without_a_relation(rng):
    values = rng.uniform(-1, 1, (200, 4))
    bases = other_bases((FIRST, SECOND, THIRD))
    strict = relation_fitting.FITS, relation_fitting.UNIQUE
    assert not relation_fitting._hopeful(bases, values, strict, {})
    twice = values.copy()
    twice[:, 0] = twice[:, 1] = 0.3
    assert not relation_fitting._hopeful([Basis(((FIRST, 2), (SECOND, 2)))], twice, strict, {})
