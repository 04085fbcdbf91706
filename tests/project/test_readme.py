"""The README says what is so."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import robust_ik as rik
from benchmarks.robustness.contenders import PEERS
from robust_ik import inverses
from robust_ik.cli import terminal_tables
from robust_ik.simulation.scenarios import stretch

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_readme_is_short():
    lines = [line for line in README.splitlines() if not line.startswith("| `")]  # tables grow with what is in them
    assert len(lines) < 140


def test_the_lines_of_python_run_as_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {}
    first, second, third = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(first, "README.md", "exec"), names)
    assert (tmp_path / "panda.html").stat().st_size > 1_000_000
    calm, other = re.findall(r"(\w+): peak ([\d.e+]+) rad/s, least σ \d\.\de-\d\d", capsys.readouterr().out)
    assert calm[0] == "JParse"
    assert 3 * float(calm[1]) < float(other[1])
    exec(compile(second, "README.md", "exec"), names)
    assert capsys.readouterr().out.startswith(names["step"].status.name.lower())
    exec(compile(third, "README.md", "exec"), names)
    assert names["found"].solved


@pytest.mark.parametrize("page", ["speed.md"])
def test_the_python_of_a_page_runs_as_printed(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in re.findall(r"```python\n(.*?)```", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.DOTALL):
        exec(compile(block, page, "exec"), names)


def test_the_table_of_inverses_is_the_one_that_the_code_gives():
    assert terminal_tables.inverses_markdown(inverses.CLASSES) in README


def test_every_public_inverse_is_in_the_table():
    public = {getattr(inverses, name) for name in inverses.__all__}
    concrete = {c for c in public if isinstance(c, type) and issubclass(c, rik.RobustInverse)}
    assert concrete - {rik.RobustInverse, rik.SingularValueFilter, rik.GainFormula} == set(inverses.CLASSES)
    assert {c.__name__ for c in inverses.CLASSES} <= set(rik.__all__)


@pytest.mark.slow
def test_the_table_of_the_demo_is_what_the_demo_measures(rng):
    """Of the pseudo-inverse, whose run hangs on the last bit, the median over starts that differ by 1e-9."""
    scenario = stretch(rik.load("xarm7"))
    beside = [scenario.robot.integrate(scenario.q0, 1e-9 * rng.normal(size=7)) for _ in range(2)]
    for name in ("DampedLeastSquares", "JParse", "MoorePenrose"):
        row = re.search(rf"^\| `{name}` \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", README, re.MULTILINE)
        starts = [scenario.q0, *beside] if name == "MoorePenrose" else [scenario.q0]
        runs = [replace(scenario, q0=q0).run(getattr(rik, name)()) for q0 in starts]
        measured = np.median([figures_of(run) for run in runs], axis=0)
        for text, number, near in zip(row.groups(), measured, ({"rel": 2e-3}, {"rel": 1e-3}, {"abs": 0.05})):
            if text.startswith("over"):
                assert number > float(text.split()[1])
            else:
                assert number == pytest.approx(float(text), **near)


def figures_of(run):
    """Peak speed in rad/s, largest and final error in mm."""
    return run.largest_speed, 1e3 * run.position_error.max(), 1e3 * max(abs(run.final_error[:3]))


def test_commands_of_the_readme_are_targets_and_subcommands():
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"^make (\w+)|`make (\w+)`", README, re.MULTILINE):
        assert f"\n{''.join(target)}:" in makefile
    cli = "".join(path.read_text() for path in (ROOT / "robust_ik" / "cli").glob("*.py"))
    for command in re.findall(r"^robust-ik (\w+)", README, re.MULTILINE):
        assert f"def {command}(" in cli


def test_files_that_the_readme_names_exist():
    for name in re.findall(r"`((?:robust_ik|tests|robots|docs)/[\w./]*)`|\]\((docs/\w+\.png)\)", README):
        assert (ROOT / "".join(name)).exists(), name


def test_everything_public_is_exported_and_documented():
    assert sorted(rik.__all__, key=str) == sorted(set(rik.__all__))
    for name in rik.__all__:
        assert getattr(rik, name).__doc__ or name == "__version__"


def test_the_page_on_which_inverse_has_measured_every_one_that_needs_no_argument():
    page = (ROOT / "docs" / "which_inverse.md").read_text(encoding="utf-8")
    table = page.split("<!-- measured: begin -->")[1].split("<!-- measured: end -->")[0]
    measured = set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE))
    assert measured == {each.__name__ for each in inverses.CLASSES} - {"Weighted"}
    others = {peer.name for peer in PEERS}
    for name in re.findall(r"`(\w+)(?:\(|`)", page):
        assert hasattr(rik, name) or hasattr(inverses, name) or name in others, name
