"""The claims of the papers: verdicts that follow from numbers, and a page that says what was measured."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.claims import __main__ as command
from benchmarks.claims import measured
from benchmarks.claims.claim import Claim
from benchmarks.claims.spread import Spread, spread

LESS = Claim("calmer", "half", {"kim": 4.6, "other": 11.9}, "{kim:.1f} and {other:.1f} rad/s", "kim < other / 2")


def with_numbers(claim, **numbers):
    return replace(claim, numbers={**claim.numbers, **numbers})


# ------------------------------------------------------------------------------------------ verdicts
def test_a_verdict_follows_from_the_numbers_and_turns_when_two_runs_are_swapped():
    assert LESS.verdict == "holds"
    assert LESS.ours == "4.6 and 11.9 rad/s"
    assert with_numbers(LESS, kim=11.9, other=4.6).verdict == "wrong"


def test_a_verdict_cannot_be_given():
    with pytest.raises(TypeError, match="verdict"):
        Claim("calmer", "half", {}, "", "True", verdict="holds")
    with pytest.raises(AttributeError):
        LESS.verdict = "wrong"


def test_with_stand_ins_a_claim_holds_in_kind_only_and_is_not_refuted():
    stand_ins = replace(LESS, kind="link lengths: ours")
    assert stand_ins.verdict == "holds in kind"
    assert with_numbers(stand_ins, kim=20.0).verdict == "open"
    assert stand_ins.reason == "link lengths: ours"


def test_what_is_cut_in_our_copy_stays_open_whatever_the_numbers_are():
    cut = replace(LESS, cut="our copy is cut there")
    assert cut.verdict == with_numbers(cut, kim=20.0).verdict == "open"


def test_readings_that_disagree_leave_a_claim_open_and_each_is_shown():
    read = replace(LESS, holds={"half": "kim < other / 2", "a third": "kim < other / 3"})
    assert read.verdict == "open"
    assert read.reason == "read as half: holds, read as a third: does not"
    assert with_numbers(read, kim=1.0).verdict == "holds"
    assert with_numbers(read, kim=20.0).verdict == "wrong"


def test_a_condition_must_hold_at_both_ends_of_a_spread():
    assert with_numbers(LESS, kim=Spread((4, 5))).verdict == "holds"
    assert with_numbers(LESS, kim=Spread((4, 8))).verdict == "open"
    assert with_numbers(LESS, kim=Spread((7, 8))).verdict == "wrong"


@pytest.mark.parametrize("typed", ["4.6 rad/s", "{kim:.1f} rad/s, 2e-3 of it lost"])
def test_a_decimal_number_in_a_text_must_be_measured(typed):
    with pytest.raises(ValueError, match="it must be one of the numbers"):
        replace(LESS, says=typed)
    with pytest.raises(ValueError, match="it must be one of the numbers"):
        replace(LESS, why=typed)


def test_a_text_does_not_end_its_cell():
    with pytest.raises(ValueError, match="would end its cell"):
        replace(LESS, why="|z| is less")


def test_numbers_that_turn_a_condition_round_are_found_if_there_are_any():
    assert LESS.opposite().verdict == "wrong"
    assert with_numbers(LESS, kim=20.0).opposite().verdict == "holds"
    assert replace(LESS, holds="kim == kim").opposite() is None


# ------------------------------------------------------------------------------------------ spreads
def test_a_spread_prints_as_a_range_and_as_one_number_where_its_digits_are_stable():
    assert f"{Spread((53.2, 869.1)):.0f}" == "53 to 869"
    assert f"{Spread((0.03001, 0.03002)):.3f}" == "0.030"
    assert f"{Spread((1, 2, 9)).median:.0f}" == "2"


def test_an_experiment_is_begun_again_a_hairs_breadth_away():
    starts = []
    found = spread(lambda q: starts.append(q) or {"first": q[0], "sum": q.sum()}, [1.0, 2.0], amount=1e-9, count=3)
    assert_allclose(starts[0], [1, 2], rtol=0)
    assert len(found["sum"].runs) == len(starts) == 4
    assert 0 < np.abs(np.array(starts[1:]) - [1, 2]).max() <= 1e-9
    assert found["first"].high - found["first"].low > 0


def test_spreads_are_near_if_they_overlap_when_made_twice_as_wide_on_either_side():
    assert Spread((1, 2)).near(Spread((2.5, 3)))
    assert not Spread((1, 2)).near(Spread((4, 4.1)))
    assert not Spread((1, 1)).near(Spread((1.1, 1.1)))


# ------------------------------------------------------------------------------------------ the page
def test_claims_are_kept_and_read_as_they_were(tmp_path, monkeypatch):
    monkeypatch.setattr(measured, "FOLDER", tmp_path)
    claims = [with_numbers(LESS, kim=Spread((1, 2)), so=True, words="q4 ∈ {0, π}", n=np.int64(3))]
    measured.write("paper_0", claims)
    assert measured.read("paper_0") == claims
    assert measured.read("paper_1") == []


def test_a_fresh_measurement_agrees_inside_the_ranges_and_differs_in_digits_verdicts_and_words():
    kept = with_numbers(LESS, kim=Spread((4, 5)))
    inside = with_numbers(kept, kim=Spread((4.2, 5.1)))
    assert measured.differences([inside], [kept]) == []
    assert measured.renewed([inside], [kept]) == [kept]
    for other in (with_numbers(kept, other=12.0), with_numbers(kept, kim=Spread((8, 9))), replace(kept, why="so")):
        (line,) = measured.differences([other], [kept])
        assert line.startswith("calmer:\n  page  4.0 to 5.0 and 11.9 rad/s | holds")
        assert measured.renewed([other], [kept]) == [other]
    assert measured.differences([], [kept]) == ["calmer: no longer measured"]
    assert measured.differences([kept], []) == ["calmer: not on the page"]


@cache
def kept():
    return [
        pytest.param(claim, id=f"{name}-{claim.what}") for name in measured.names() for claim in measured.read(name)
    ]


@pytest.mark.parametrize("name", measured.names())
def test_the_page_says_what_was_measured(name):
    assert measured.table(measured.read(name)) in command.PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("claim", kept())
def test_each_claim_of_the_papers_would_say_the_opposite_of_other_numbers(claim):
    for reading, condition in claim.readings.items():
        spoilt = claim.opposite(reading)
        assert spoilt is not None
        assert (spoilt.outcome(condition) is True) != (claim.outcome(condition) is True)
    if len(claim.readings) == 1:
        assert replace(spoilt, cut="").verdict != replace(claim, cut="").verdict


@pytest.mark.parametrize("what, first, second", [
    ("Fig. 4c: Chiaverini's measure gets small", "kim", "chiaverini"),
    ("Fig. 4d: Chiaverini's joint speeds are larger", "kim", "chiaverini"),
    ("Figs. 3b, 4b: the task recovers sooner", "kim", "chiaverini"),
    ("Figs. 3b, 4b: it recovers without over- and undershoot, Chiaverini's does not", "kim", "chiaverini"),
    ("PUMA 560, wrist: the clamp lowers joint speeds", "one", "two"),
    ("(12) suits the rows of J, which (11) treats alike", "scaled", "plain"),
    ("6.3: normalised kinematics depend less on the lengths", "raw", "normalised"),
    ("Fig. 3: clusters rotated, corank 3", "steps", "alone"),
])  # fmt: skip
def test_with_the_runs_of_two_methods_swapped_the_page_no_longer_says_holds(what, first, second):
    (claim,) = (each for name in measured.names() for each in measured.read(name) if each.what == what)
    assert claim.verdict.startswith("holds")
    swapped = with_numbers(claim, **{first: claim.numbers[second], second: claim.numbers[first]})
    assert not swapped.verdict.startswith("holds")
