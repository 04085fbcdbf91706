"""The pages and the figure of the robustness benchmark."""

import re

import pytest

import robust_ik as rik
from robust_ik.display import plot_tradeoff, write_robustness_html
from robust_ik.simulation.robustness import BenchmarkResults
from tests.simulation.test_robustness_summary import FACTS, run, runs

CURVES = tuple(tuple(0.01 * (k + 1) for k in range(60)) for _ in range(3))


def results(name="calm <b>"):
    scores = {name: runs(), "wild": runs(kept=0.3, speed=5.0, leave=1.5, chatter=9.0)}
    first = next(iter(scores["wild"]))
    for each in scores.values():
        each[first] = run(curves=CURVES)
    return BenchmarkResults(dict.fromkeys(runs(), FACTS | {"seconds": 2.5}), scores)


def runs_of(page):
    return re.findall(r"<tr><th>(.*?)</th>", page)


def test_the_index_ranks_methods_and_links_a_page_with_curves_for_each_scenario_that_is_shown(tmp_path):
    index = write_robustness_html(tmp_path / "pages", results()).read_text(encoding="utf-8")
    assert runs_of(index)[1:] == ["1. calm &lt;b&gt;", "2. wild"]
    assert "no: calm &lt;b&gt;" in index
    assert "<script" not in index
    assert re.findall(r'href="(scenario-\d+\.html)"', index) == ["scenario-001.html"]
    page = (tmp_path / "pages" / "scenario-001.html").read_text(encoding="utf-8")
    assert page.count("<polyline") == 6
    assert "q3 = 0" in page
    assert "<b>" not in page
    assert "default-src &#x27;none&#x27;" in page


def test_what_is_not_on_the_front_is_drawn_in_grey(tmp_path):
    rows = results("calm").summaries()
    text = plot_tradeoff(rows, tmp_path / "x.svg").read_text(encoding="utf-8")
    assert text.count("#d62728") > 0
    for row in rows:
        assert row.on_front is (row.name == "calm")
    with pytest.raises(rik.InputError, match="nothing to draw"):
        plot_tradeoff([], tmp_path / "x.svg")
    with pytest.raises(rik.InputError, match="nothing to show"):
        write_robustness_html(tmp_path, BenchmarkResults({}, {}))
