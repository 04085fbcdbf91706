"""`robust-ik benchmark`, as its user sees it."""

import json
import re

import pytest

from tests.cli.test_cli import command  # noqa: F401 (a fixture)

MINE = "import robust_ik as rik\nmine = rik.DampedLeastSquares(0.2)\n"


@pytest.fixture
def short(monkeypatch):
    """A fifth of the scenarios."""
    from robust_ik.simulation import robustness

    whole = robustness.robustness_scenarios
    monkeypatch.setattr(robustness, "robustness_scenarios", lambda *given, **more: whole(*given, **more)[::5])


@pytest.mark.usefixtures("short")
def test_benchmark_ranks_methods_and_a_file_of_ones_own_and_saves_everything(command, tmp_path):  # noqa: F811
    (tmp_path / "mine.py").write_text(MINE)
    status, out, err = command(
        "benchmark", "planar_3r", "--starts", "40", "--methods", "jparse", "--methods", "mine.py",
        "--json", "runs.json", "--html", "pages", "--plot", "tradeoff.svg",
    )  # fmt: skip
    assert status == 0, err
    for name in ("JParse", "mine"):
        assert re.search(rf"^ *{name} +\d\.\d\d .* (yes|no) \d+%", out, re.MULTILINE), out
    saved = json.loads((tmp_path / "runs.json").read_text())
    assert set(saved["methods"]) == {"JParse", "mine"}
    assert len(saved["scenarios"]) == len(saved["methods"]["mine"]) > 3
    assert {"index.html", "scenario-001.html"} <= {path.name for path in (tmp_path / "pages").iterdir()}
    assert (tmp_path / "tradeoff.svg").stat().st_size > 1000

    status, out, _ = command(
        "benchmark", "planar_3r", "--starts", "40", "--methods", "MoorePenrose", "--read", "runs.json"
    )
    assert status == 0
    assert "MoorePenrose" in out
    assert "mine" in out
    status, out, _ = command("benchmark", "--read", "runs.json")
    assert status == 0
    assert "JParse" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "name a robot, or saved results with --read"),
        (("nobody",), "nobody"),
        (("planar_3r", "--methods", "JPars"), "there is no method 'JPars'"),
        (("planar_3r", "--methods", "nowhere.py"), "there is no file nowhere.py"),
        (("planar_3r", "--methods", "bad.py"), "bad.py cannot be run: NameError"),
        (("planar_3r", "--read", "bad.py"), "these are no results of the benchmark"),
        (("planar_3r", "--plot", "x.doc"), "x.doc"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line_before_anything_runs(
    command, tmp_path, monkeypatch, arguments, message  # noqa: F811
):  # fmt: skip
    (tmp_path / "bad.py").write_text("nonsense\n")
    monkeypatch.setattr("robust_ik.simulation.robustness.measure", lambda *_: pytest.fail("it ran"))
    status, _, err = command("benchmark", *arguments)
    assert status == 1
    assert message in " ".join(err.split())
    assert err.startswith("robust-ik:")
