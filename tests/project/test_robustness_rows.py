"""One more row of the robustness benchmark beside those that are kept, and what newer peers are told."""

import importlib
import json
import sys
from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

from benchmarks import environments, tables
from benchmarks.robustness import __main__ as command
from benchmarks.robustness import saved, telling
from benchmarks.robustness.contenders import PEERS, Contender, drawn
from robust_ik.simulation.robustness import BenchmarkResults
from tests.simulation.test_robustness_summary import FACTS, runs

MARKS = ("robustness_table", "robustness_words", "robustness_classes", "robustness_settings", "robustness_agreement")
EVERYONE = (Contender("Calm"), Contender("Mine"), Contender("Other"))
ODD = 1 / 7
"""A number with more digits than are kept."""


def results(**methods):
    told = {key: {**FACTS, "seconds": 2.0} for key in next(iter(methods.values()))} if methods else {}
    return BenchmarkResults(told, methods)


def kept(name, **parameters):
    return {name: Contender(name).set_to(parameters)}


@pytest.fixture
def page(tmp_path, monkeypatch):
    """A page whose rows have been written: Calm, and Other as it comes and tuned."""
    docs = tmp_path / "docs"
    (docs / "benchmarks").mkdir(parents=True)
    marks = "\n\n".join(f"<!-- {mark}: begin -->\n{mark}\n<!-- {mark}: end -->" for mark in MARKS)
    (docs / "robustness.md").write_text(marks, encoding="utf-8")
    (docs / "which_inverse.md").write_text("<!-- needs: begin -->\n<!-- needs: end -->", encoding="utf-8")
    for module in (tables, telling):
        monkeypatch.setattr(module, "DOCS", docs)
    for module in (saved, telling):
        monkeypatch.setattr(module, "OUT", tmp_path / "out")
    monkeypatch.setattr(saved, "FOLDER", docs / "benchmarks")
    for drawing in ("plot_tradeoff", "write_robustness_html"):  # seconds, and tested elsewhere
        monkeypatch.setattr(telling, drawing, lambda *_: None)
    monkeypatch.setattr(command, "ours", lambda: EVERYONE)
    monkeypatch.setattr(command, "PEERS", ())
    rows = {"Calm": runs(kept=0.03), "Other": runs(kept=ODD), "Other, tuned": runs(kept=0.02)}
    before = saved.rounded(results(**rows))
    telling.tell(before, {"Mine": "cannot be installed"}, kept("Other", a=2.0), [], page=command.PAGE, write=True)
    return docs


def run_command(monkeypatch, now, *options):
    asked = []

    def measure(contenders, *_):
        asked.extend(each.name for each in contenders)
        return now

    monkeypatch.setattr(command, "measure", measure)
    monkeypatch.setattr(sys, "argv", ["robustness", *options])
    command.main()
    return asked


def test_a_row_is_added_without_measuring_the_others(page, monkeypatch):
    record = page / "benchmarks" / "robustness.json"
    before = {row["name"]: row for row in json.loads(record.read_text(encoding="utf-8"))["results"]}
    now = results(Mine=runs(kept=0.01), **{"Mine, tuned": runs(kept=0.005)}), {}, kept("Mine", b=3.0)
    assert run_command(monkeypatch, now, "--only", "Mine", "--add", "--write") == ["Mine"]
    told = json.loads(record.read_text(encoding="utf-8"))
    assert [row["name"] for row in told["results"]] == ["Mine, tuned", "Mine", "Other, tuned", "Calm", "Other"]
    for row in told["results"][2:]:
        assert row["means"] == pytest.approx(before[row["name"]]["means"], rel=1e-12, nan_ok=True)
    assert told["tuned"] == {"Mine": {"b": 3.0}, "Other": {"a": 2.0}}
    assert told["failures"] == {}
    text = (page / "robustness.md").read_text(encoding="utf-8")
    assert text.index("`Mine, tuned`") < text.index("`Other, tuned`")
    assert "cannot be installed" not in text
    assert "robustness_agreement: begin -->\nrobustness_agreement\n" in text  # none was measured: as it stood
    kept_now = saved.load(page / "benchmarks")[0].scores
    assert list(kept_now) == ["Calm", "Mine", "Other", "Mine, tuned", "Other, tuned"]  # as if all had been measured


def test_a_contender_measured_again_loses_all_that_was_told_of_it(page, monkeypatch):
    now = results(Other=runs(kept=0.5)), {}, {}
    run_command(monkeypatch, now, "--only", "Other", "--add", "--write")
    found, failures, chosen = saved.load(page / "benchmarks")
    assert set(found.scores) == {"Calm", "Other"}
    assert found.summaries()[-1].means["kept"] == pytest.approx(0.5)
    assert failures == {"Mine": "cannot be installed"}
    assert chosen == {}


def test_one_that_fails_has_no_row_but_its_reason(page, monkeypatch):
    scenarios = saved.load(page / "benchmarks")[0].scenarios
    now = BenchmarkResults(scenarios, {}), {"Other": "failed: another tool pose"}, {}
    run_command(monkeypatch, now, "--only", "Other", "--add", "--write")
    assert "* Other is not in the table: failed: another tool pose." in (page / "robustness.md").read_text("utf-8")
    assert set(saved.load(page / "benchmarks")[0].scores) == {"Calm"}


def test_without_it_only_what_is_measured_is_told(page, monkeypatch):
    now = results(Mine=runs(kept=ODD)), {}, {}
    run_command(monkeypatch, now, "--only", "Mine", "--no-peers", "--write")
    found = saved.load(page / "benchmarks")[0]
    assert set(found.scores) == {"Mine"}
    (row,) = json.loads((page / "benchmarks" / "robustness.json").read_text(encoding="utf-8"))["results"]
    assert row["means"]["kept"] == pytest.approx(0.142857, rel=1e-12)  # what will be kept, not more digits


def test_rows_of_other_scenarios_and_of_contenders_that_are_gone_are_not_mixed_in(page):
    before = saved.load(page / "benchmarks")
    with pytest.raises(ValueError, match="other scenarios: measure all contenders anew"):
        saved.added(before, (results(Mine=runs(robots=("a", "b"))), {}, {}), EVERYONE[1:2], EVERYONE)
    now = results(Mine=runs()), {}, {}
    found, _, chosen = saved.added(before, now, EVERYONE[1:2], EVERYONE[:2])
    assert list(found.scores) == ["Calm", "Mine"]
    assert chosen == {}


def test_what_is_kept_says_what_was_measured(page, tmp_path):
    curved = {key: replace(each, kept=ODD, curves=((0.1,), (0.2,), (0.3,))) for key, each in runs().items()}
    exact = results(Curved=curved)
    measured = saved.rounded(exact)
    saved.save(measured, tmp_path)
    (tmp_path / saved.RECORD).write_text(json.dumps({"tuned": {}, "failures": {}}), encoding="utf-8")
    again = saved.load(tmp_path)[0]
    assert again.scenarios == measured.scenarios
    assert [vars(row) for row in again.summaries()] == [vars(row) for row in measured.summaries()]
    assert measured.scores["Curved"] != curved
    assert all(each.curves for each in measured.scores["Curved"].values())
    assert not any(each.curves for each in again.scores["Curved"].values())
    assert measured.summaries()[0].price == pytest.approx(exact.summaries()[0].price, rel=1e-6)


def test_the_page_has_a_row_for_every_peer_or_says_why_not(tmp_path, monkeypatch):
    monkeypatch.setattr(saved, "OUT", tmp_path)
    found, failures, chosen = saved.load(saved.FOLDER)
    for peer in PEERS:
        assert peer.name in {*found.scores, *failures}
        assert peer.name in {*chosen, *failures}
    table = (tables.DOCS / "robustness.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in table for name in found.scores)
    told = json.loads((saved.FOLDER / saved.RECORD).read_text(encoding="utf-8"))
    assert [row["name"] for row in told["results"]] == [row.name for row in found.summaries()]


def test_every_peer_has_a_script_and_an_environment():
    for peer in PEERS:
        assert (environments.SCRIPTS / f"{peer.script}_track.py").is_file()
        made = (environments.SCRIPTS / f"requirements-{peer.script}.txt").is_file()
        assert made or peer.script in environments.SYSTEM


def script(monkeypatch, name, *modules):
    """The script of a peer whose packages note what they are told."""
    noted = {module: MagicMock(name=module) for module in modules}
    for module, found in noted.items():
        monkeypatch.setitem(sys.modules, module, found)
    monkeypatch.syspath_prepend(str(environments.SCRIPTS))
    for module in (f"{name}_track", "tracking", "loops", "timing"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    made = importlib.import_module(f"{name}_track")
    for module in (f"{name}_track", "tracking", "loops", "timing"):  # others must not find them
        monkeypatch.delitem(sys.modules, module)
    return made, noted


def planar(parameters):
    from benchmarks.peers.tracking import Arm

    return Arm(
        urdf="arm.urdf", tip="tool", joints=("a", "b", "c"), placements=np.zeros((3, 4, 4)), tool=np.eye(4),
        rows=("x", "z"), parameters=parameters, speed=np.array([1.0, 2.0, 3.0]), dt=0.02,
    )  # fmt: skip


def test_embodik_is_told_the_twist_its_rows_its_limits_and_what_was_drawn(monkeypatch):
    made, noted = script(monkeypatch, "embodik", "embodik")
    robot, solver = noted["embodik"].RobotModel.return_value, noted["embodik"].KinematicsSolver.return_value
    robot.get_joint_names.return_value = ["a", "b", "c"]
    solver.solve_velocity_dq.return_value = np.array([0.1, 0.2, 0.3])
    contender = next(each for each in PEERS if each.script == "embodik")
    setting = drawn(contender)[0]
    tracker = made.make(planar(setting))
    solver.set_damping.assert_called_once_with(setting["damping"])
    solver.set_tolerance.assert_called_once_with(setting["tolerance"])
    assert solver.dt == 0.02
    assert [call.args for call in solver.set_joint_velocity_limit.call_args_list] == [(0, 1.0), (1, 2.0), (2, 3.0)]
    hand = solver.add_frame_task.return_value
    assert hand.set_position_mask.call_args.args[0].tolist() == [1, 0, 1]
    assert hand.set_orientation_mask.call_args.args[0].tolist() == [0, 0, 0]
    q, twist = np.zeros(3), np.array([0.5, 0, 0.2, 0, 0, 0])
    assert tracker.step(q, twist, np.eye(4)).tolist() == [0.1, 0.2, 0.3]
    hand.set_target_velocity.assert_called_once_with(twist)
    solver.solve_velocity_dq.assert_called_once_with(q)  # its default: with its limits


def test_roboplan_is_told_the_place_its_costs_its_limits_and_what_was_drawn(monkeypatch):
    made, noted = script(monkeypatch, "roboplan", "roboplan", "roboplan.core", "roboplan.optimal_ik")
    core, ik = noted["roboplan.core"], noted["roboplan.optimal_ik"]
    core.Scene.return_value.getJointNames.return_value = ["a", "b", "c"]
    oink = ik.Oink.return_value
    oink.num_variables = 3
    contender = next(each for each in PEERS if each.script == "roboplan")
    setting = drawn(contender)[0]
    arm = planar(setting)
    tracker = made.make(arm)
    ik.FrameTaskOptions.assert_called_once_with(
        position_cost=1.0, orientation_cost=0.0, lm_damping=setting["lm_damping"]
    )
    ik.VelocityLimit.assert_called_once_with(oink, 0.02, arm.speed)
    near, q = np.diag([1.0, 2, 3, 1]), np.zeros(3)

    def solve(at, tasks, limits, barriers, moved, regularization):
        assert at is q
        assert tasks == [ik.FrameTask.return_value]
        assert limits == [ik.PositionLimit.return_value, ik.VelocityLimit.return_value]
        assert (barriers, regularization) == ([], setting["regularization"])
        moved[:] = [0.02, 0.04, -0.02]

    oink.solveIk.side_effect = solve
    assert tracker.step(q, np.zeros(6), near).tolist() == [1, 2, -1]
    ik.FrameTask.return_value.setTargetFrameTransform.assert_called_once_with(near)
