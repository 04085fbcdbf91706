"""What runs the tests under other settings: it tells what failed under which, and its settings are no words only."""

import os
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import robust_ik as rik
from tests import everywhere
from tests.conftest import MOVED_STARTS, QUICK, move_starts, moved_start, pytest_collection_modifyitems
from tests.everywhere import Setting

TESTS = "import os\n\ndef test_it():\n    assert 'ROBUST_IK_BROKEN' not in os.environ\n"


@pytest.fixture
def outcome(tmp_path, monkeypatch, capsys):
    """Runs a test that fails where ROBUST_IK_BROKEN is set, under some settings: (status, what was printed)."""
    (tmp_path / "test_it.py").write_text(TESTS)

    def run(*settings, options=()):
        monkeypatch.setattr(everywhere, "settings", lambda: list(settings))
        status = everywhere.main([*options, "--logs", str(tmp_path / "logs"), str(tmp_path / "test_it.py")])
        return status, capsys.readouterr().out

    return run


def test_a_failure_under_one_setting_is_told_with_its_test_and_makes_the_whole_fail(outcome):
    status, text = outcome(Setting("calm"), Setting("wild", {"ROBUST_IK_BROKEN": "1"}))
    assert status == 1
    rows = {line.split("│")[1].strip(): line for line in text.splitlines() if line.startswith("│")}
    assert "passed" in rows["calm"]
    assert "FAILED" in rows["wild"]
    assert "FAILED" in text.split("wild …")[1].splitlines()[1]


def test_what_cannot_be_run_here_is_said_and_fails_nothing_unless_nothing_is_left(outcome):
    impossible = Setting("far", {"ROBUST_IK_BROKEN": "1"}, missing="this machine cannot run it")
    status, text = outcome(Setting("calm"), impossible)
    assert status == 0
    assert "this machine cannot run it" in text
    assert outcome(impossible)[0] == 1


@pytest.mark.slow
def test_settings_are_chosen_by_a_word_and_unknown_words_are_refused(outcome):
    broken = Setting("wild", {"ROBUST_IK_BROKEN": "1"})
    assert outcome(Setting("calm"), broken, options=("--only", "cal"))[0] == 0
    with pytest.raises(SystemExit, match="no setting is called storm; there are: calm; wild"):
        outcome(Setting("calm"), broken, options=("--only", "storm"))


@pytest.mark.slow
def test_every_setting_of_this_machine_changes_what_it_says_or_is_left_out():
    found = everywhere.settings()
    assert len({each.name for each in found}) == len(found) >= 8
    assert found[0] == Setting("as it is")
    usual = everywhere.answer(everywhere.BITS)
    for each in found:
        if each.part and not each.missing:
            assert everywhere.answer(everywhere.BITS, each.variables) != usual
    nothing = everywhere.tried(Setting("x", {"SOME_VARIABLE": "1"}, "blas"), dict(zip(("blas",), usual)))
    assert nothing.missing == "it changes nothing on this machine"
    failing = everywhere.tried(Setting("x", {"PYTHONHOME": "/nowhere"}, "blas"), dict(zip(("blas",), usual)))
    assert failing.missing == "this machine cannot run it"


def test_the_load_ends_with_the_run(monkeypatch):
    started = []
    real = everywhere.subprocess.Popen
    monkeypatch.setattr(everywhere.subprocess, "Popen", lambda *args: started.append(real(*args)) or started[-1])
    with everywhere.load(True):
        assert len(started) == os.cpu_count()
        assert all(each.poll() is None for each in started)
    assert all(each.poll() is not None for each in started)
    with everywhere.load(False):
        assert len(started) == os.cpu_count()


def test_starts_are_moved_where_it_is_asked_for_and_alike_each_time(monkeypatch):
    robot = rik.load("planar_2r")
    q0 = np.array([0.1, 1.0])

    def start():
        run = rik.simulate(robot, None, rik.FrameTask(np.eye(4)), q0, duration=0.02, dt=0.01)
        return run.q[0]

    exact = start()
    move_starts(monkeypatch, 1e-3)
    moved = start()
    assert 0 < np.abs(moved - exact).max() < 1e-2
    assert (start() == moved).all()
    solved = rik.newton(lambda q: q, lambda q: np.eye(2), rik.JParse(), q0, q0, max_iterations=0)
    assert 0 < np.abs(solved.q - q0).max() < 1e-2
    assert (moved_start(robot, q0) == q0).all() or os.environ.get(MOVED_STARTS)
    monkeypatch.setenv(MOVED_STARTS, "1e-3")
    assert 0 < np.abs(moved_start(robot, q0) - q0).max() < 1e-2


def test_programs_that_fail_or_warn_answer_nothing():
    assert everywhere.answer("print(1, 2)") == ["1", "2"]
    for program in ("raise SystemExit(3)", "import warnings; warnings.warn('no'); print(1)", "syntax error"):
        assert everywhere.answer(program) == []
    assert sys.executable


def item(name, *marks, path="test_a.py"):
    return SimpleNamespace(nodeid=f"{path}::{name}", path=Path(path), get_closest_marker=lambda mark: mark in marks)


def collected(items, quick):
    dropped = []
    hook = SimpleNamespace(pytest_deselected=lambda items: dropped.extend(items))
    config = SimpleNamespace(getoption=lambda name: quick, hook=hook)
    kept = list(items)
    pytest_collection_modifyitems(config, kept)
    return kept, dropped


def test_quickly_no_slow_test_no_notebook_and_the_first_parameters_only_are_run():
    many = [item(f"test_many[{i}]") for i in range(5)]
    others = [item("test_one"), item("test_slow", "slow"), item("", path="1.ipynb")]
    assert collected([*many, *others], quick=False) == ([*many, *others], [])
    kept, dropped = collected([*many, *others], quick=True)
    assert kept == [*many[:QUICK], others[0]]
    assert dropped == [*many[QUICK:], *others[1:]]


def test_every_file_of_tests_has_one_that_is_quick():
    for path in Path(__file__).parents[1].rglob("test_*.py"):
        text = path.read_text(encoding="utf-8")
        tests, slow = re.findall(r"^ *def test_", text, re.MULTILINE), text.count("mark.slow")
        assert len(tests) > slow, path.name
