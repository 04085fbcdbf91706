"""What runs come to: the Pareto front, prices and intervals, saved results, methods by name and from files."""

import math
from itertools import product

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.simulation.robustness import (
    CONTROLLER,
    KINDS,
    BenchmarkResults,
    RunKey,
    RunScore,
    by_class,
    chosen_methods,
    dominated_by,
    known_methods,
    means_of,
    price,
    summaries,
)

FACTS = {"exit": "fold", "place": "q3 = 0", "dt": 0.01, "drive": False, "noise": 0.0, "leavable": True, "shown": True}


def run(kept=0.01, speed=0.5, leave=1.0, chatter=1.0, curves=()):
    return RunScore(
        kept=kept, kept_peak=kept, lost=kept, final=kept, leave=leave, left=float(leave < 2), speed=speed,
        chatter=chatter, violations=0.0, failed=0.0, rest=0.0, cost=1.0, curves=curves,
    )  # fmt: skip


def runs(robots=("a", "b", "c"), spread=0.0, **given):
    """Two runs of two classes on each robot; `spread` makes robots differ."""
    found = {}
    for place, (robot, kind, name) in enumerate(product(robots, ("cross", "start"), ("first", "second"))):
        more = {key: value * (1 + spread * math.sin(place)) for key, value in given.items()}
        score = run(**more) if kind == "start" else run(**{**more, "leave": math.nan})
        found[RunKey(robot, kind, f"{kind} {name}")] = score
    return found


def test_the_front_is_made_of_those_that_nobody_beats():
    found = dominated_by({"fast": (1, 9), "calm": (9, 1), "middle": (5, 5), "bad": (6, 6), "worst": (9, 9)})
    assert found["fast"] == found["calm"] == found["middle"] == ()
    assert found["bad"] == ("middle",)
    assert set(found["worst"]) == {"fast", "calm", "middle", "bad"}
    assert dominated_by({"one": (1, 2), "twin": (1, 2 + 1e-12)}) == {"one": (), "twin": ()}
    with pytest.raises(rik.InputError, match="numbers are missing of b"):
        dominated_by({"a": (1, 2), "b": (1, math.nan)})
    with pytest.raises(rik.InputError, match="the same numbers"):
        dominated_by({"a": (1, 2), "b": (1,)})


def test_rows_are_ranked_by_price_and_a_beaten_one_is_told_by_whom():
    rows = summaries({"good": runs(), "bad": runs(kept=0.05, speed=0.9, leave=1.5, chatter=4.0)})
    assert [row.name for row in rows] == ["good", "bad"]
    assert rows[0].on_front
    assert rows[0].front_share == 1
    assert rows[1].beaten_by == ("good",)
    assert not rows[1].on_front
    assert rows[1].front_share == 0
    assert rows[0].price == pytest.approx(np.mean([0.01 / 0.02, 0.5, 1.0, 0.5]))


def test_the_same_verdict_says_the_opposite_where_numbers_do():
    calm = summaries({"ours": runs(chatter=0.1), "theirs": runs(kept=0.001)})
    assert all(row.on_front for row in calm)
    beaten = summaries({"ours": runs(chatter=0.1), "theirs": runs(kept=0.001, chatter=0.05)})
    assert {row.name: row.on_front for row in beaten} == {"ours": False, "theirs": True}


def test_robots_and_classes_count_alike_however_many_runs_they_have():
    few = {RunKey("a", "cross", "1"): run(kept=0.1)} | {RunKey("b", "start", "1"): run(kept=0.3)}
    many = few | {RunKey("b", "start", str(i)): run(kept=0.3) for i in range(2, 30)}
    assert means_of(few)["kept"] == pytest.approx(0.2)
    assert means_of(many)["kept"] == pytest.approx(0.2)
    assert by_class(many, "kept") == pytest.approx({"cross": 0.1, "start": 0.3})
    assert set(by_class(many, "kept")) <= set(KINDS)


def test_one_wild_run_counts_no_more_than_its_cap():
    wild = {RunKey("a", "cross", "1"): run(kept=1e9, speed=1e9)}
    assert means_of(wild) == pytest.approx({"kept": 1.0, "speed": 10.0, "leave": 1.0, "chatter": 1.0})
    assert price(means_of(wild)) == pytest.approx((50 + 10 + 1 + 0.5) / 4)


def test_where_nothing_is_to_be_left_the_price_is_of_the_other_numbers():
    scores = {RunKey("a", "cross", "1"): run(leave=math.nan)}
    assert price(means_of(scores)) == pytest.approx((0.5 + 0.5 + 0.5) / 3)
    (row,) = summaries({"one": scores})
    assert row.on_front
    assert "leave" not in row.intervals


def test_intervals_hold_the_mean_are_wider_where_robots_differ_and_are_the_same_again():
    first = summaries({"x": runs(spread=0.5, kept=0.01)})[0]
    again = summaries({"x": runs(spread=0.5, kept=0.01)})[0]
    same = summaries({"x": runs()})[0]
    low, high = first.intervals["kept"]
    assert low < first.means["kept"] < high
    assert first.intervals == again.intervals
    assert same.intervals["kept"] == pytest.approx((0.01, 0.01))


def test_methods_that_ran_something_else_are_not_compared():
    other = dict(list(runs().items())[:-1])
    with pytest.raises(rik.InputError, match="less has not run 1 of 12 scenarios, such as 'start second'"):
        summaries({"all": runs(), "less": other})


def test_results_come_back_from_a_file_and_are_joined(tmp_path):
    scores = {"x": runs(), "y": runs(kept=0.3)}
    results = BenchmarkResults(dict.fromkeys(runs(), FACTS | {"seconds": 2.5}), scores)
    again = BenchmarkResults.load(results.save(tmp_path / "saved.json"))
    assert again.scenarios == results.scenarios
    assert [row.means["kept"] for row in again.summaries()] == [row.means["kept"] for row in results.summaries()]
    more = BenchmarkResults(results.scenarios, {"z": runs()})
    assert set(again.joined(more).scores) == {"x", "y", "z"}
    for text, said in (("{}", "these are no results"), ('{"format": 7}', "reads format 1, got 7"), ("x", "no results")):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(rik.LoadError, match=said):
            BenchmarkResults.load(tmp_path / "bad.json")


MINE = """
from dataclasses import dataclass
import robust_ik as rik

@dataclass(frozen=True)
class Halved(rik.RobustInverse):
    source = "me"
    def solve(self, J, xdot):
        return 0.5 * rik.DampedLeastSquares(0.1).solve(J, xdot)

gentle = rik.JParse(0.3)
"""


def test_methods_are_found_by_name_and_in_a_file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    found = chosen_methods(["jparse", str(path), CONTROLLER])
    assert list(found) == ["JParse", "Halved", "gentle", CONTROLLER]
    assert found["gentle"].made(None) == rik.JParse(0.3)
    assert found["Halved"].made(None).solve(np.eye(2), [1.0, 0])[0] == pytest.approx(0.5 / 1.01)
    assert "Weighted" not in known_methods()
    assert "SecondOrder" in known_methods()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "there is no file .*mine.py"),
        ("x = 1", "defines no inverse: it needs a class"),
        ("import nowhere_at_all", "cannot be run: ModuleNotFoundError: No module named 'nowhere_at_all'"),
        ("def broken(:", "cannot be run: SyntaxError"),
        (
            "import robust_ik as rik\nclass Needs(rik.RobustInverse):\n    def __init__(self, a): ...\n"
            "    def solve(self, J, xdot): ...",
            "Needs cannot be made without arguments",
        ),
    ],
)
def test_a_file_of_no_use_is_told_so(tmp_path, text, said):
    path = tmp_path / "mine.py"
    if text is not None:
        path.write_text(text)
    with pytest.raises(rik.InputError, match=said):
        chosen_methods([str(path)])


def test_a_method_that_does_not_exist_is_told_with_the_nearest():
    with pytest.raises(rik.InputError, match=r"there is no method 'JPars'.*JParse"):
        chosen_methods(["JPars"])
