"""The command that runs the robustness benchmark with peers: halves, tuning, other packages, verdicts."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from benchmarks import environments, report
from benchmarks.robustness import arms, measuring, telling
from benchmarks.robustness.agreement import ALIKE, compared, motions
from benchmarks.robustness.arms import HELD_OUT, SEEDS, TRAINING, arm, for_tuning, scenarios
from benchmarks.robustness.contenders import PEERS, TRIES, Contender, drawn, ours
from benchmarks.robustness.measuring import measured
from benchmarks.robustness.tuning import price_of, tuned
from robust_ik.inverses import CLASSES
from robust_ik.simulation.robustness import InverseMethod, RunTrace, key_of, run_scenarios, summaries
from tests.simulation.test_robustness_summary import runs

PLAIN = """
import numpy as np
from tracking import Tracker, run

LENGTHS = np.array([0.36, 0.36, 0.24])

def make(arm):
    def pose(q):
        turned = np.cumsum(q)
        c, s = np.cos(turned), np.sin(turned)
        return np.array([[c[2], -s[2], 0, LENGTHS @ c], [0, 0, -1, 0], [s[2], c[2], 0, LENGTHS @ s], [0, 0, 0, 1]])
    def step(q, twist, near):
        turned = np.cumsum(q)
        x, z = LENGTHS * np.cos(turned), LENGTHS * np.sin(turned)
        J = np.array([[-np.sum(z[k:]) for k in range(3)], [np.sum(x[k:]) for k in range(3)]])
        damping = arm.parameters.get("damping", 0.05)
        return J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(2), twist[arm.chosen])
    return Tracker(step, pose)

run("Plain", "plain", make, version="7")
"""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.setattr(arms, "CACHE", tmp_path / "out" / "peers")
    monkeypatch.setattr(measuring, "KEPT", tmp_path / "out" / "robustness")
    for cached in (arm, scenarios):
        cached.cache_clear()
    yield
    for cached in (arm, scenarios):
        cached.cache_clear()


@pytest.fixture
def plain(tmp_path, monkeypatch):
    """A peer of NumPy alone, for the planar arm."""
    for name in ("timing.py", "loops.py", "tracking.py"):
        (tmp_path / name).write_text((environments.SCRIPTS / name).read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "plain_track.py").write_text(PLAIN, encoding="utf-8")
    monkeypatch.setattr(environments, "SCRIPTS", tmp_path)
    monkeypatch.setattr(environments, "interpreter", lambda _: sys.executable)
    measuring._sources.cache_clear()
    return Contender("Plain", "plain", ranges=(("damping", 0.01, 0.5),))


def test_halves_are_of_six_different_arms_each_with_seeds_of_their_own():
    assert len(set(TRAINING)) == len(set(HELD_OUT)) == 6
    assert not set(TRAINING) & set(HELD_OUT)
    assert {SEEDS[name] for name in TRAINING}.isdisjoint({SEEDS[name] for name in HELD_OUT})
    with pytest.raises(ValueError, match="ur10 is held out"):
        for_tuning("ur10")


def test_every_inverse_takes_part_and_whatever_has_a_number_is_tuned_with_the_same_budget():
    found = {each.kind: each for each in ours()}
    assert {each.__name__ for each in CLASSES} - {"Weighted"} < set(found)
    for each in (*ours(), *PEERS):
        settings = drawn(each)
        assert len(settings) == (TRIES if each.ranges else 0)
        assert settings == drawn(each)
        for setting in settings:
            assert all(low <= setting[name] * 1.01 and setting[name] <= 1.01 * high for name, low, high in each.ranges)
    assert not {"speed", "acceleration"} & {name for name, _, _ in found["SecondOrder"].ranges}


def test_tuning_picks_the_lowest_price_and_asks_for_training_arms_only():
    contender, asked = next(each for each in ours() if each.kind == "DampedLeastSquares"), []
    wanted = drawn(contender)[1]["damping"]

    def measure(each, name):
        asked.append(name)
        return runs(robots=(name,), kept=0.01 if dict(each.parameters).get("damping") == wanted else 0.5)

    best, price = tuned(contender, measure)
    assert dict(best.parameters) == {"damping": wanted}
    assert best.label == "DampedLeastSquares, tuned"
    assert set(asked) == set(TRAINING)
    assert price == pytest.approx(price_of(best, measure))
    kept, _ = tuned(contender, lambda each, name: runs(robots=(name,), kept=0.5 if each.parameters else 0.01))
    assert kept.parameters == ()


def test_a_peer_gets_the_same_commands_drive_and_noise_as_ours(plain):
    robot, chosen = arm("planar_3r")[0], scenarios("planar_3r")
    picked = [next(each for each in chosen if each.kind == kind) for kind in ("cross", "beyond", "noise", "sampling")]
    picked += [next(each for each in chosen if each.drive and each.kind == "line")]
    traces = measuring.peer_traces(plain, "planar_3r", picked)
    mine = run_scenarios(robot, picked, InverseMethod.of(rik.DampedLeastSquares(0.05)))
    for each, a, b in zip(picked, mine, traces):
        assert_allclose(b.q, a.q, atol=1e-8, err_msg=each.name)
        assert_allclose(b.commanded, a.commanded, atol=1e-6)
        assert b.failed == 0


def test_what_was_measured_is_kept_and_other_settings_are_measured_anew(plain, monkeypatch):
    few = scenarios("planar_3r")[:3]
    monkeypatch.setattr(measuring, "scenarios", lambda _: few)
    first = measured(plain, "planar_3r")
    assert list(first) == [key_of(each) for each in few]
    with monkeypatch.context() as patched:
        patched.setattr(measuring, "peer_traces", lambda *_: pytest.fail("it ran"))
        assert measured(plain, "planar_3r") == first
    assert measured(plain.set_to({"damping": 0.4}), "planar_3r") != first
    ours_of = Contender("DampedLeastSquares", kind="DampedLeastSquares")
    again = measured(ours_of, "planar_3r")
    for key, each in again.items():
        assert each.kept == pytest.approx(first[key].kept, abs=1e-8)
        assert measured(ours_of, "planar_3r")[key].to_json() == each.to_json()


def test_two_agree_where_joint_values_do_and_the_others_are_named():
    def trace(q):
        return RunTrace(np.full((3, 2), q), np.zeros((2, 2)), 0, 0.0)

    both = compared("ours", "theirs", ["a", "b"], [trace(1.0), trace(2.0)], [trace(1.0 + 1e-9), trace(2.0)])
    assert both.words.startswith("ours and theirs agree in all of 2 motions")
    one = compared("ours", "theirs", ["a", "b"], [trace(1.0), trace(2.0)], [trace(1.0), trace(2.0 + 2 * ALIKE)])
    assert (one.alike, one.apart) == (1, ("b",))
    assert "agree in 1 of 2 motions" in one.words
    assert "not in b" in one.words
    assert all(each.kind in ("cross", "beyond", "speed") for each in motions("planar_3r"))


def test_words_say_that_we_are_beaten_where_we_are():
    good, bad = runs(kept=0.001, speed=0.1, leave=0.5, chatter=0.1), runs(kept=0.1, speed=0.9, leave=1.9, chatter=5.0)
    best = telling.words(summaries({"SecondOrder": good, "Other": bad}))
    assert any("`SecondOrder` is on the front, and in 100% of the resamples" in line for line in best)
    assert any("number 1 of 2" in line for line in best)
    worst = telling.words(summaries({"SecondOrder": bad, "Other": good}))
    assert any("`SecondOrder` is not on the front" in line and "`Other`" in line for line in worst)
    assert any("Chatter: 1 rows have less" in line for line in worst)
    assert not any("is on the front, and" in line for line in worst)


def test_scenarios_of_the_urdf_that_all_read_are_those_of_the_arm():
    robot, chain, path = arm("planar_3r")
    known = rik.load("planar_3r")
    q = np.array([0.3, 0.8, -0.9])
    assert_allclose(robot.pose(q), known.pose(q), atol=1e-9)
    assert robot.rows == known.rows
    assert path.is_file()
    assert np.abs(chain.upper).min() > 2 * np.pi
    assert replace(chain, name="x").joints == known.joint_names


@pytest.mark.parametrize(("script", "name"), [("robustness/__main__.py", "robustness"), ("svd.py", "svd")])
def test_a_record_names_the_command_that_made_it(monkeypatch, script, name):
    monkeypatch.setattr(sys, "argv", [f"/somewhere/benchmarks/{script}", "--write"])
    assert report.command() == f"python -m benchmarks.{name} --write"
