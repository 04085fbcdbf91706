"""The harness of the benchmarks: what it saves and how it compares. No times are judged."""

import importlib.util
import json
import re
import sys
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

import robust_ik as rik
from benchmarks import batch_throughput, environments, figures, pose_accuracy, pose_ik, report, second_order_steps
from benchmarks.chains import Chain
from benchmarks.environments import Peer, UnavailableError
from benchmarks.goals import Goal, goals
from benchmarks.peers.timing import Sample, Work, error
from benchmarks.report import Report
from benchmarks.rounds import Series, batches, calls, interleave, needed, ours, peer
from benchmarks.step_latency import (
    COLUMNS,
    PythonFilter,
    against_numpy,
    contenders,
    damped,
    pinocchio_step,
    residuals,
    row,
)
from benchmarks.svd import errors
from benchmarks.tables import DOCS, insert
from benchmarks.works import ahead, bare, pinocchio_pose, poses, singular, twists, work_of
from benchmarks.works import arm as arm_of

ECHO = """
from timing import System, run

def make(work, arguments):
    if arguments.fail == "yes":
        raise ValueError("no such arm")
    print("noise on standard output")
    return System(lambda q, target: 2 * q, lambda q: work.poses[(work.q == q).all(axis=1)][0])

run("Echo", "echo", make, version="7", fail=("no", "yes"))
"""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.works.CACHE", tmp_path)
    monkeypatch.setattr(environments, "CACHE", tmp_path)


@pytest.fixture
def arm():
    return bare(Chain.zigzag(6))


@pytest.fixture
def echo(arm, tmp_path, monkeypatch):
    """A peer that runs in this interpreter, and its work."""
    timing = environments.SCRIPTS / "timing.py"
    (tmp_path / "timing.py").write_text(timing.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "echo_twist.py").write_text(ECHO, encoding="utf-8")
    monkeypatch.setattr(environments, "SCRIPTS", tmp_path)
    monkeypatch.setattr(environments, "interpreter", lambda _: sys.executable)
    work = work_of(*arm, *twists(arm[0], 5))
    return work, work.save(tmp_path / "work.npz")


def series(name, *cpu):
    return Series(name, samples=[Sample(each, np.array([each, 3 * each]), [0]) for each in cpu])


# ---------------------------------------------------------------------------------------------- rounds
def test_ratios_are_taken_within_a_round_not_between_medians():
    base, each = series("base", 1.0, 10.0, 2.0), series("each", 2.0, 10.0, 8.0)
    np.testing.assert_allclose(each.ratios(base), [2, 1, 4], rtol=1e-15)
    assert each.summary([base])["ratio"]["base"]["median"] == 2


def test_contenders_take_turns():
    order = []
    everyone = [ours(name, lambda name=name: calls(order.append, [name])) for name in "AB"]
    interleave(everyone, 2)
    # Both warm up; then each round calls one after the other, several times where that takes no time.
    assert [name for name, _ in groupby(order)] == ["A", "B"] * 3
    assert order.count("A") == order.count("B")


def test_a_contender_that_is_not_there_is_left_out_with_its_reason():
    found = interleave([ours("fast", lambda: needed(rik, "warp_drive")), ours("plain", lambda: calls(abs, [1]))], 2)
    assert found["fast"].summary() == {"version": "", "failure": "this robust_ik has no warp_drive"}
    assert len(found["plain"].samples) == 2


def test_a_summary_has_medians_quartiles_and_tails():
    found = series("each", 1.0, 2.0).summary()
    assert found["cpu_us_of_rounds"] == [1, 2]
    assert set(found["wall_us"]) == {"q1", "median", "q3", "mean", "p99", "p99.9", "max"}


def test_a_batch_is_counted_by_its_things():
    found = batches(lambda: np.arange(4), 4, 2)()
    assert found.us.shape == (2,)
    np.testing.assert_array_equal(found.answers, np.arange(4))


# ---------------------------------------------------------------------------------------------- reports
@pytest.fixture
def measured():
    spread = series("robust_ik", 1.0, 2.0).summary()["wall_us"]
    return Report(
        "trial", ("what", "µs"), [("a", "1")], {"a": {"median": 1.0}}, {"rounds": 2},
        figure=lambda path: figures.bars(path, {"title": {"robust_ik": spread, "other": spread}}, "µs"),
    )  # fmt: skip


def test_json_tells_machine_versions_command_and_results(measured, tmp_path):
    found = json.loads(measured.save(tmp_path).read_text(encoding="utf-8"))
    assert set(found) == {"name", "command", "settings", "machine", "versions", "results", "table"}
    assert found["machine"]["cpu"]
    assert found["machine"]["cores"] >= 1
    assert found["versions"]["numpy"] == np.__version__
    assert found["command"].startswith("python -m benchmarks.")
    assert found["table"] == {"columns": ["what", "µs"], "rows": [["a", "1"]]}


def test_a_figure_is_the_same_file_for_the_same_numbers(measured, tmp_path):
    first, second = (measured.save(tmp_path / name).with_suffix(".svg").read_bytes() for name in ("one", "two"))
    assert first == second


def test_curves_are_drawn(tmp_path):
    figures.lines(tmp_path / "a.svg", {"joints": {"ours": [(1, 2.0), (2, 3.0)]}, "size": {}}, "µs")
    assert (tmp_path / "a.svg").stat().st_size > 0


def test_numbers_that_json_does_not_have_are_refused(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        Report("trial", ("a",), results={"a": float("nan")}).save(tmp_path)


@pytest.mark.parametrize(
    "name",
    ["step_latency", "pose_ik", "pose_accuracy", "batch_throughput", "scaling", "svd", "svd_errors", "atlas_time",
     "import_time"],
)  # fmt: skip
def test_the_page_has_a_place_for_every_table(name, tmp_path):
    page = tmp_path / "page.md"
    page.write_text((DOCS / report.PAGE).read_text(encoding="utf-8"), encoding="utf-8")
    insert("a table", page, name)
    assert f"<!-- {name}: begin -->\na table\n<!-- {name}: end -->" in page.read_text(encoding="utf-8")


def test_second_order_steps_are_compared_by_how_many_singular_values_are_weak(tmp_path):
    found = second_order_steps.rows(("ur5",), 300, 20)
    assert [each[:2] for each in found] == [("ur5", "0"), ("ur5", "1"), ("ur5", "2")]
    assert all(len(each) == len(second_order_steps.COLUMNS) and min(map(float, each[2:])) > 0 for each in found)
    page = tmp_path / "page.md"
    page.write_text((DOCS / "speed.md").read_text(encoding="utf-8"), encoding="utf-8")
    insert("a table", page, "second_order_steps")
    assert "a table" in page.read_text(encoding="utf-8")


# ---------------------------------------------------------------------------------------------- peers
def test_a_peer_answers_round_by_round_whatever_it_prints(echo):
    work, path = echo
    found = interleave([peer("Echo", "echo", "twist", path)], 2)["Echo"]
    assert (found.version, len(found.samples)) == ("7", 2)
    np.testing.assert_array_equal(found.answers, 2 * work.q)
    assert found.us.shape == (10,)


def test_a_peer_that_fails_is_left_out_with_the_last_line_of_its_error(echo):
    found = interleave([peer("Echo", "echo", "twist", echo[1], ("--fail", "yes"))], 2)["Echo"]
    assert found.failure == "failed: ValueError: no such arm"


def test_a_peer_with_another_robot_is_left_out(echo, tmp_path):
    work, _ = echo
    turned = Work(**{**vars(work), "poses": work.poses[::-1].copy(), "q": work.q})
    script = (tmp_path / "echo_twist.py").read_text(encoding="utf-8")
    (tmp_path / "echo_twist.py").write_text(
        script.replace("work.poses[(work.q == q).all(axis=1)][0]", "work.poses[0]"), encoding="utf-8"
    )
    with (
        pytest.raises(UnavailableError, match="not the same task"),
        Peer("echo", "twist", turned.save(tmp_path / "t.npz")),
    ):
        pass


def test_a_peer_that_cannot_be_installed_is_left_out_with_the_reason(tmp_path, monkeypatch):
    (tmp_path / "requirements-nobody.txt").write_text("", encoding="utf-8")

    def call(command):
        if "pip" in command:
            raise UnavailableError("ERROR: No matching distribution found")

    monkeypatch.setattr(environments, "SCRIPTS", tmp_path)
    monkeypatch.setattr(environments, "call", call)
    found = interleave([peer("Nobody", "nobody", "twist", tmp_path / "work.npz")], 1)["Nobody"]
    assert found.failure == "cannot be installed: ERROR: No matching distribution found"


def test_a_system_package_that_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(environments.SYSTEM, "pykdl", (sys.executable, "import no_such_module", "a package"))
    with pytest.raises(UnavailableError, match="needs a package"):
        environments.interpreter("pykdl")


# ---------------------------------------------------------------------------------------------- work
def test_work_is_read_as_it_was_saved(echo):
    work, path = echo
    again = Work.read(path)
    assert (again.joints, again.tip, again.dt) == (work.joints, work.tip, work.dt)
    np.testing.assert_array_equal(again.targets, work.targets)


@pytest.mark.parametrize("name", ["panda", "ur5", "pa10", "xarm7"])
def test_the_bare_robot_is_the_robot(name):
    robot = rik.load(name)
    plain, chain = bare(Chain.of(robot))
    q = plain.random(np.random.default_rng(0), 20)
    np.testing.assert_allclose(plain.pose(q), robot.pose(q), atol=1e-14)
    np.testing.assert_allclose(pinocchio_pose(plain)(q), robot.pose(q), atol=1e-14)
    assert chain.joints == robot.joint_names


def test_a_target_ahead_is_where_the_twist_leads(arm):
    robot, _ = arm
    q, twist = twists(robot, 3)
    expected = robot.pose(q)
    moved = ahead(expected, twist, 1e-6)
    apart = error(moved, expected)
    np.testing.assert_allclose(apart[:, 0], 1e-6 * np.linalg.norm(twist[:, :3], axis=1), rtol=1e-6)
    np.testing.assert_allclose(apart[:, 1], 1e-6 * np.linalg.norm(twist[:, 3:], axis=1), rtol=1e-4)


def test_starts_nearby_are_near_and_within_limits(arm):
    robot, _ = arm
    q0, targets = poses(robot, "warm", 20)
    assert ((q0 >= robot.lower) & (q0 <= robot.upper)).all()
    assert (error(robot.pose(q0), targets)[:, 1] < 6 * 0.05).all()


def test_targets_out_of_reach_are_as_far_as_they_say(arm):
    robot, _ = arm
    _, near = poses(robot, "unreachable 1.1", 20)
    _, far = poses(robot, "unreachable 2", 20)
    center = far[:, :3, 3] - 2 / 0.9 * (far - near)[:, :3, 3]
    np.testing.assert_allclose(center, center[:1].repeat(20, axis=0), atol=1e-12)


def test_singular_targets_are_singular_and_within_limits():
    robot = rik.load("planar_3r")
    found = singular(robot, np.random.default_rng(0), 5)
    assert (rik.svd(robot.jacobian(found)).s[:, -1] < 1e-9).all()


def test_the_baseline_is_damped_least_squares(arm):
    robot, _ = arm
    q, twist = twists(robot, 10)
    step = pinocchio_step(robot, damped)
    found = np.array([step(*each) for each in zip(q, twist)])
    J = robot.jacobian(q)
    np.testing.assert_allclose(found, rik.DampedLeastSquares(0.05).solve(J, twist), rtol=1e-9)
    np.testing.assert_allclose(found, PythonFilter().solve(J, twist), rtol=1e-9)
    assert (residuals(J, twist, found) < 1).all()


def test_errors_of_singular_values_see_below_the_last_bit():
    near, rest = np.array([[1.0, 1e-20]]), np.array([[1e-17, 0.0]])
    relative, over = errors(np.array([[1.0, 2e-20]]), near, rest)
    np.testing.assert_allclose((relative, over), (1, 1e-17), rtol=1e-6)


# ---------------------------------------------------------------------------------------------- our own
class SlowStepper:
    """The interface of a stepper, in NumPy."""

    def __init__(self, robot, inverse):
        self.robot, self.inverse = robot, inverse

    def step(self, q, twist, out):
        out[:] = self.inverse.solve(self.robot.jacobian(q), twist)

    def steps(self, q, twists, out=None, threads=1):
        out[:] = self.inverse.solve(self.robot.jacobian(q), twists)
        return out


def test_our_steps_are_judged_by_numpy(arm, monkeypatch):
    monkeypatch.setattr(rik, "Stepper", SlowStepper, raising=False)
    robot, chain = arm
    work = twists(robot, 4)
    everyone = contenders(robot, chain, work, peers=False)
    found = interleave([each for each in everyone if "null space" not in each.name], 1)
    assert not [each.name for each in found.values() if each.failure]
    J = robot.jacobian(work[0])
    assert max(against_numpy(J, work[1], found).values()) < 1e-9
    lines = [row(each, found, J, work[1]) for each in found.values()]
    assert {len(line) for line in lines} == {len(COLUMNS)}


def test_batches_have_a_line_each(arm, monkeypatch):
    monkeypatch.setattr(rik, "Stepper", SlowStepper, raising=False)
    monkeypatch.setattr(batch_throughput, "AT_LEAST", 1)
    robot, _ = arm
    found = interleave(batch_throughput.contenders(robot, *twists(robot, 8)), 1)
    compared = batch_throughput.pairs(found)
    assert float(compared["robust_ik DLS, batch"]["one"]) > 0
    assert float(compared[f"robust_ik DLS, {batch_throughput.CORES} threads"]["cores"]) > 0


@dataclass
class Found:
    q: np.ndarray
    error: np.ndarray
    starts: np.ndarray
    status: np.ndarray


def given_away(robot, kind, targets, seed):
    """A solver that was told every answer but the first of a work."""
    rng = np.random.default_rng(seed)
    starts = robot.random(rng, targets)
    answers = robot.random(rng, targets)
    answers[0] = starts[0]
    return lambda self, wanted, q0=None, **_: Found(answers, np.zeros((targets, 2)), np.ones(targets), "solved")


def test_misses_are_counted_whatever_the_solver_claims(monkeypatch):
    robot, _ = arm_of("ur5")
    monkeypatch.setattr(rik.Robot, "solve_poses", given_away(robot, "random", 30, 100), raising=False)
    counted = pose_accuracy.count("ur5", "random", 30)
    assert (counted["missed"], counted["missed_fine"], counted["claimed"], counted["outside"]) == (1, 1, 1, 0)
    assert len(pose_accuracy.row("ur5", "random", counted)) == len(pose_accuracy.COLUMNS)


def test_answers_out_of_reach_are_measured_by_the_best_known(arm):
    robot, _ = arm
    q0, targets = poses(robot, "unreachable 2", 10)
    better, worse = Series("robust_ik"), Series("other")
    near, far = q0, robot.lower[None].repeat(10, axis=0)
    better.samples, worse.samples = [Sample(1, np.ones(10), near)], [Sample(1, np.ones(10), far)]
    best = pose_ik.best_known(robot, targets, [near, far], 0)
    verdicts = [pose_ik.judge(robot, each, targets, best)["error over best"] for each in (better, worse)]
    assert min(verdict["median"] for verdict in verdicts) == 1
    assert len(pose_ik.row("zigzag", "unreachable 2", better, {"solved": 0, "to 1e-8": 0}, better)) == len(
        pose_ik.COLUMNS
    )


def test_answers_outside_the_limits_do_not_count(arm):
    robot, _ = arm
    q = robot.random(np.random.default_rng(0), 4) + 2 * np.pi
    cheat = Series("cheat", samples=[Sample(1, np.ones(4), q)])
    verdict = pose_ik.judge(robot, cheat, robot.pose(q), None)
    assert (verdict["solved"], verdict["within limits"]) == (0, 0)


# ---------------------------------------------------------------------------------------------- goals
def test_a_goal_is_read_from_what_was_saved(tmp_path):
    Report("trial", ("a",), results={"ours": 2.0}).save(tmp_path)
    read = lambda results: results["ours"]  # noqa: E731
    assert Goal("speed", "trial", read, 3).line(tmp_path) == ("speed", "≤ 3", "2", "yes")
    assert Goal("speed", "trial", read, 3, least=True).line(tmp_path) == ("speed", "≥ 3", "2", "NO")


def test_no_goal_counts_as_held_that_was_not_measured(tmp_path):
    assert {goal.line(tmp_path)[-1] for goal in goals()} == {"not measured"}


def test_no_goal_counts_as_held_where_its_contender_failed(tmp_path):
    failed = {"contenders": {"robust_ik DampedLeastSquares": {"version": "", "failure": "none"}}, "against NumPy": {}}
    Report("step_latency", ("a",), results=failed).save(tmp_path)
    assert "yes" not in {goal.line(tmp_path)[-1] for goal in goals()}


ROOT = Path(__file__).parents[2]


def test_programs_in_texts_import_what_there_is():
    """Programs that other processes run are strings: no type checker looks at what they import."""
    wanted = re.compile(r"^\s*from (robust_ik[\w.]*) import ([\w, ]+)$", re.MULTILINE)
    found = 0
    for folder in ("benchmarks", "examples"):
        for file in (ROOT / folder).rglob("*.py"):
            for module, names in wanted.findall(file.read_text(encoding="utf-8")):
                for name in names.split(", "):
                    assert is_there(module, name.partition(" as ")[0]), f"{file.name}: {module} has no {name}"
                    found += 1
    assert found > 50
    assert not is_there("robust_ik.kernels", "store")
    assert not is_there("robust_ik.nowhere", "store")


def is_there(module, name):
    try:
        return hasattr(importlib.import_module(module), name) or bool(importlib.util.find_spec(f"{module}.{name}"))
    except ImportError:
        return False
