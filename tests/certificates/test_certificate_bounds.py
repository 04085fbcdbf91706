"""A certificate that is made to keep the checker busy is refused by counting, before the work is done."""

import json
import random
from fractions import Fraction

import pytest

import robust_ik as rik
from robust_ik.certificates import certify, check
from robust_ik.certificates.checker.modular_arithmetic import determinant, determinant_of_numbers, random_prime
from robust_ik.certificates.proof import counted_steps, untrusted_json
from robust_ik.certificates.proof.proof import from_json
from robust_ik.certificates.proof.real_roots import _chain, real_root_count
from robust_ik.certificates.proof.untrusted_json import CertificateError, read_json


@pytest.fixture(scope="module")
def proof():
    return json.loads(certify(rik.load("duleba_3r"), 1).to_json())


def digits(count):
    return "7" + str(random.Random(0).randrange(10 ** (count - 1))).zfill(count - 1)


def form(degree, length):
    number = digits(length)
    return {"joints": [0], "degrees": [degree], "terms": [[[i], [number[i:]]] for i in range(degree + 1)]}


def node(**changed):
    minor = {"kind": "minor", "rows": [[["1"], ["0"], ["0"]]] * 3, "columns": [0, 1, 2]}
    return {"kind": "contradiction", "source": minor, **changed}


def spoilt(proof, **changed):
    return json.dumps({**proof, "nodes": [node(**changed)]})


def test_a_long_sequence_of_sturm_is_refused_before_it_is_made(proof, monkeypatch):
    monkeypatch.setattr("robust_ik.certificates.proof.real_roots._remainder", None)
    verdict = check(spoilt(proof, factors=[{"kind": "unreal", "form": form(127, 1900), "power": 1}]))
    assert not verdict.accepted
    assert "more steps" in verdict.reason


def test_what_a_check_takes_is_bounded_and_the_bound_can_be_raised(proof):
    text = json.dumps(proof)
    assert check(text).accepted
    assert "more steps" in check(text, steps=100).reason
    assert counted_steps.left() == float("inf")
    assert check(text, steps=1e6).accepted


def test_many_cases_that_each_take_little_are_refused_together(proof):
    many = node(factors=[{"kind": "unreal", "form": form(12, 1900), "power": 1}])
    counted = []

    def spend(count):
        counted.append(count)
        counted_steps.spend(count)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robust_ik.certificates.proof.real_roots.spend", spend)
        verdict = check(json.dumps({**proof, "nodes": [many] * 500}), steps=1e6)
    assert not verdict.accepted
    assert sum(counted[:-1]) < 1e6


@pytest.mark.parametrize("key", ["field", "x", "constant", "terms"])
def test_a_field_of_a_degree_that_no_prover_works_in_is_refused(proof, key):
    long = ["1"] * (untrusted_json.MAX_FIELD + 1)
    state = {
        "field": {"field": long},
        "x": {"pins": [{"joint": 0, "x": long, "y": ["1"]}]},
        "terms": {"generators": [{"joints": [0], "degrees": [1], "terms": [[[1], long]]}]},
    }
    changed = {"constant": long} if key == "constant" else {"state": state[key]}
    with pytest.raises(CertificateError, match="list of at most 17"):
        from_json(spoilt(proof, **changed))


@pytest.mark.parametrize("sign", ["[],", "{},", "1,"])
def test_a_text_that_memory_should_not_hold_is_refused_unread(sign, monkeypatch):
    monkeypatch.setattr(untrusted_json, "MOST_LISTS", 1000)
    monkeypatch.setattr(untrusted_json, "MOST_VALUES", 1000)
    assert read_json(f"[{sign * 300}1]")
    monkeypatch.setattr(untrusted_json.json, "loads", None)
    with pytest.raises(ValueError, match="holds more than"):
        read_json(f"[{sign * 2000}1]")
    with pytest.raises(CertificateError, match="holds more than"):
        from_json(f"[{sign * 2000}1]")


@pytest.mark.parametrize("degree", [1, 2, 5, 9, 14])
def test_roots_are_counted_by_whole_numbers_as_by_fractions(degree):
    rng = random.Random(degree)
    for _ in range(30):
        f = [Fraction(rng.randrange(-9, 10), rng.randrange(1, 5)) for _ in range(degree)] + [
            Fraction(rng.choice((-2, 3)))
        ]
        chain, expected = _chain(f), [f, [i * a for i, a in enumerate(f)][1:]]
        while expected[-1]:
            expected.append([-a for a in remainder(expected[-2], expected[-1])])
        assert len(chain) == len(expected) - 1
        for ours, theirs in zip(chain, expected):
            ratio = ours[-1] / theirs[-1]
            assert ratio > 0
            assert [ratio * a for a in theirs] == ours
    roots = [Fraction(k, 3) for k in range(degree)]
    product = [Fraction(1)]
    for root in roots:
        product = [a - root * b for a, b in zip([Fraction(0), *product], [*product, Fraction(0)])]
    assert real_root_count(product) == degree


def remainder(f, g):
    f = list(f)
    while len(f) >= len(g):
        ratio, shift = f[-1] / g[-1], len(f) - len(g)
        f = [a - ratio * g[i - shift] if i >= shift else a for i, a in enumerate(f[:-1])]
        while f and not f[-1]:
            f.pop()
    return f


def test_a_determinant_by_elimination_is_that_by_expansion():
    rng = random.Random(0)
    prime = random_prime(rng)
    for size in (1, 2, 5, 7):
        for matrix in (
            [[rng.choice((0, rng.randrange(prime))) for _ in range(size)] for _ in range(size)] for _ in range(9)
        ):
            assert determinant_of_numbers(matrix, prime) == determinant(matrix, prime) % prime
