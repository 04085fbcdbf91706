"""Ctrl-C, a signal to end, a reader that has gone: the status is right, nothing half done is left."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from multiprocessing import active_children

import pytest

import robust_ik as rik
from robust_ik.runtime.parallel import process_pool
from robust_ik.singularities import find_singularities
from robust_ik.singularities.atlas import search_run
from robust_ik.singularities.atlas.evidence import Completeness

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals of Unix")

WAITING = """
import sys, time
from importlib import import_module
from unittest.mock import patch
from robust_ik.cli import main
module, _, name = sys.argv.pop(1).rpartition(".")
def wait(*_, **__):
    print("begun", file=sys.stderr, flush=True)
    time.sleep(300)
patch.object(import_module(module), name, wait).start()
main()
"""
"""The command, with one function that waits in place of what it does."""

WRITING = "robust_ik.runtime.output_files._keep_rights"
INT, TERM = signal.SIGINT, signal.SIGTERM


@pytest.mark.parametrize(
    "number, where, command",
    [
        (INT, "robust_ik.simulation.scenarios.stretch", ("demo", "planar_2r", "-o", "x.html")),
        (TERM, "robust_ik.simulation.comparison.compare", ("compare", "xarm7_line", "--html", "x.html")),
        (INT, "robust_ik.cli.terminal_tables.facts", ("info", "planar_2r")),
        (INT, WRITING, ("export", "planar_2r", "old", "--force")),
        (TERM, WRITING, ("export", "planar_2r", "old", "--force")),
        (INT, "robust_ik.certificates.certify", ("certify", "planar_2r", "-o", "x.json")),
        (TERM, "robust_ik.singularities.find_singularities", ("singularities", "planar_2r", "--json", "x.json")),
    ],
)
def test_a_command_that_a_signal_ends_says_so_by_its_status_and_leaves_nothing_half_done(
    tmp_path, number, where, command
):
    (tmp_path / "old").write_text("as it was")
    with subprocess.Popen(
        [sys.executable, "-c", WAITING, where, *command],
        cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    ) as program:  # fmt: skip
        assert "begun" in program.stderr.readline()
        program.send_signal(number)
        _, errors = program.communicate(timeout=60)
    assert program.returncode == 128 + number
    assert "Traceback" not in errors
    assert [path.name for path in tmp_path.iterdir()] == ["old"]
    assert (tmp_path / "old").read_text() == "as it was"


STOPPING = """
import signal
from unittest.mock import patch
from robust_ik.cli import main
from robust_ik.singularities.atlas.corank_search import CorankSearch
def read(search, starts, real=CorankSearch.read):
    if search.corank == 2:
        signal.raise_signal(signal.SIGINT)
    return real(search, starts)
with patch.object(CorankSearch, "read", read):
    main()
"""


def test_ctrl_c_in_a_search_keeps_what_was_found_and_exits_with_130(tmp_path):
    command = ["singularities", "planar_3r", "--starts", "50", "--no-certify", "--json", "a.json", "--html", "a.html"]
    done = subprocess.run(
        [sys.executable, "-c", STOPPING, *command],
        cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 130
    assert "corank 2: none found yet; interrupted: the search was stopped" in " ".join(done.stdout.split())
    assert done.stderr == "Interrupted: this is what was found until then.\n"
    atlas = rik.SingularityAtlas.load(tmp_path / "a.json")
    assert atlas.interrupted
    assert [each.status for each in atlas.evidence] == [Completeness.INTERRUPTED] * len(atlas.evidence)
    assert len(atlas.of_corank(1)) > 0
    assert "The search was stopped" in (tmp_path / "a.html").read_text()


@pytest.mark.parametrize("where", ["rows", "verdicts"])
def test_ctrl_c_while_rows_are_made_keeps_those_that_are_and_claims_nothing(monkeypatch, where):
    def stop(*_):
        raise KeyboardInterrupt

    def rows(*given, real=search_run.make_rows):
        yield from real(*given)
        raise KeyboardInterrupt

    monkeypatch.setattr(search_run, "make_rows" if where == "rows" else "judged", rows if where == "rows" else stop)
    atlas = find_singularities(rik.load("planar_2r"), starts=50)
    assert atlas.interrupted
    assert [stratum.words for stratum in atlas] == ["q2 ∈ {0, π}"]
    assert {each.status for each in atlas.evidence} == {Completeness.INTERRUPTED}
    assert "certified" not in atlas.explanation


@pytest.mark.parametrize("stopped", [KeyboardInterrupt, SystemExit, ValueError, None])
def test_processes_end_with_the_work_also_those_that_are_busy(stopped):
    before, futures = set(active_children()), []

    def work():
        with process_pool(2) as pool:
            pool.submit(abs, -1).result(60)  # they have come up
            futures.extend(pool.submit(time.sleep, 3000) for _ in range(4))
            if stopped is not None:
                raise stopped

    if stopped is None:
        work()
    else:
        with pytest.raises(stopped):
            work()
    patient = time.monotonic() + 60  # two threads wait for them: one may be told later than the other
    while not (set(active_children()) <= before and all(each.done() for each in futures)):
        assert time.monotonic() < patient
        time.sleep(0.01)
    assert set(active_children()) <= before
    assert all(isinstance(each, Future) and each.done() for each in futures)


def test_a_reader_that_has_had_enough_is_no_error(tmp_path):
    for command in (["inverses"], ["export", "panda", "/dev/stdout"]):
        with subprocess.Popen(
            [sys.executable, "-c", "from robust_ik.cli import main; main()", *command],
            cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        ) as program:  # fmt: skip
            program.stdout.close()
            assert program.stderr.read() == ""
            assert program.wait(60) != 0
