"""The checker counts real roots by itself, and no broken count of who proves or shows leaves makes it certify more."""

import random
from fractions import Fraction

import pytest

import robust_ik as rik
from robust_ik.certificates import certify, check, leaves
from robust_ik.certificates.checker import expected_children, root_counting
from robust_ik.certificates.checker.root_counting import count_real_roots
from robust_ik.certificates.proof import proof_leaves, real_roots
from robust_ik.certificates.proof.counted_steps import TooManyStepsError, at_most
from robust_ik.certificates.prover import child_cases, number_fields
from robust_ik.singularities.atlas.evidence import Completeness


def product(factors):
    result = [Fraction(1)]
    for factor in factors:
        longer = [Fraction(0)] * (len(result) + len(factor) - 1)
        for i, a in enumerate(result):
            for j, b in enumerate(factor):
                longer[i + j] += a * b
        result = longer
    return result


def random_factor(rng):
    """A factor, and its real roots; none if they are not known."""
    kind, root = rng.randrange(5), Fraction(rng.randrange(-60, 60), rng.randrange(1, 9))
    small = Fraction(1, 10 ** rng.randrange(1, 13))
    if kind == 0:
        return [-root, Fraction(1)], {root}
    if kind == 1:
        return [root**2 + small, -2 * root, Fraction(1)], set()  # two complex ones, close to each other
    if kind == 2:
        return [root * (root + small), -2 * root - small, Fraction(1)], {root, root + small}
    if kind == 3:
        return [Fraction(0), Fraction(1)], {Fraction(0)}
    return [Fraction(1), Fraction(0), Fraction(0), Fraction(0), Fraction(1)], set()


def test_as_many_roots_are_counted_as_were_put_in():
    rng = random.Random(3)
    for _ in range(400):
        made = [random_factor(rng) for _ in range(rng.randrange(5))]
        again = [made[i] for i in range(len(made)) if rng.random() < 0.3]  # repeated ones
        f = product([[Fraction(rng.choice((-7, 1)), 3)], *(each for each, _ in [*made, *again])])
        known = set().union(*(roots for _, roots in made)) if made else set()
        assert count_real_roots(f) == len(known) == real_roots.real_root_count(f)


def test_both_counts_agree_on_random_polynomials():
    rng = random.Random(4)
    for _ in range(400):
        size = 10 ** rng.randrange(1, 12)
        f = [Fraction(rng.randrange(-size, size), rng.randrange(1, size)) for _ in range(rng.randrange(1, 12))]
        f = [*f, Fraction(rng.choice((-1, 2)))]
        assert count_real_roots(f) == real_roots.real_root_count(f)
    assert count_real_roots(["-2", "0", "1"]) == 2
    assert count_real_roots(["5"]) == 0
    with pytest.raises(ValueError, match="zero"):
        count_real_roots(["0", "0"])


def test_a_count_that_takes_too_long_is_refused_by_counting():
    tight = product(
        [[Fraction(1, 10**400) + 1, Fraction(-2), Fraction(1)]] * 3 + [[Fraction(-2), Fraction(0), Fraction(1)]]
    )
    with at_most(1e4), pytest.raises(TooManyStepsError):
        count_real_roots(tight)


def broken_prover(monkeypatch):
    """Sees no real root anywhere."""
    monkeypatch.setattr(child_cases, "has_real_root", lambda _: False)
    monkeypatch.setattr(number_fields, "has_real_root", lambda _: False)


@pytest.mark.parametrize("name, corank", [("puma560", 1), ("panda", 1), ("xarm7", 1), ("planar_3r", 2)])
def test_a_prover_that_drops_real_roots_is_refused(name, corank, monkeypatch):
    robot = rik.load(name)
    honest = certify(robot, corank)
    assert check(honest).accepted
    broken_prover(monkeypatch)
    monkeypatch.setattr(real_roots, "real_root_count", lambda _: 0)  # what the rest of the proof's room uses
    monkeypatch.setattr(real_roots, "has_real_root", lambda _: False)
    spoilt = certify(robot, corank)
    assert spoilt.to_json() != honest.to_json()
    verdict = check(spoilt)
    assert not verdict.accepted
    assert "real" in verdict.reason
    monkeypatch.setattr(expected_children, "count_real_roots", lambda _: 0)  # with it broken as well, nobody would see
    assert check(spoilt).accepted


def test_leaves_that_are_shown_at_fewer_places_than_they_have_are_not_certified(monkeypatch):
    robot = rik.load("puma560")
    assert rik.find_singularities(robot, 1).evidence[0].status is Completeness.CERTIFIED
    shown = proof_leaves.real_roots
    monkeypatch.setattr(proof_leaves, "real_roots", lambda field: shown(field)[:1])
    found = rik.find_singularities(robot, 1).evidence[0]
    assert found.status is not Completeness.CERTIFIED
    assert "would be listed" in found.words


def test_the_checker_tells_at_how_many_real_places_each_leaf_is():
    proof = certify(rik.load("puma560"), 1)
    places = check(proof).places
    assert places == tuple(len(leaf.places) for leaf in leaves(proof))
    assert max(places) > 1


def test_the_count_shares_nothing_with_the_other():
    assert not {
        name
        for name in vars(root_counting)
        if getattr(vars(root_counting)[name], "__module__", "") == real_roots.__name__
    }
