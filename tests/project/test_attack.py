"""The attacks in short, and that what they find is told."""

import contextlib
import time

import pytest

from tests.attack import __main__ as command
from tests.attack import running
from tests.attack.guards import WATCH, TooSlowError, within


@pytest.mark.parametrize("name", running.names())
def test_nothing_breaks_under_a_short_attack(name):
    assert running.run(name).failures == []


def test_what_breaks_hangs_or_dies_is_a_failure_and_the_command_says_so(capsys, monkeypatch):
    told = {"one": ["a thing broke [x]"], "two": []}
    monkeypatch.setattr(running, "names", lambda: list(told))
    monkeypatch.setattr(running, "chunks", lambda name, scale: [(3, 0)])
    monkeypatch.setattr(running, "chunk", lambda name, *_: told[name])
    assert command.main(["--jobs", "1"]) == 1
    assert "a thing broke [x]" in capsys.readouterr().out
    assert command.main(["--only", "two"]) == 0


def test_a_process_that_dies_is_told_and_not_waited_for():
    (failure,) = running.chunk("no_such_attack", 1, 0, 60, print)
    assert "ModuleNotFoundError" in failure


def stubborn():
    """Catches whatever comes, for a minute."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        with contextlib.suppress(Exception):
            sum(range(1000))


def deaf():
    """Catches everything, once."""
    with contextlib.suppress(BaseException):
        stubborn()


def test_what_takes_too_long_is_stopped_whatever_it_catches():
    for what in (stubborn, deaf):
        with pytest.raises(TooSlowError), within(0.05):
            what()


def test_the_watch_sees_what_is_opened(tmp_path):
    (tmp_path / "here").write_text("x")
    WATCH.start()
    (tmp_path / "here").read_bytes()
    assert WATCH.stop() == [str((tmp_path / "here").resolve())]
