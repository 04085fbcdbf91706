"""The measurement in closed loop: how it judges a run, and that the command writes its page."""

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import robust_ik as rik
from benchmarks import closed_loop, default_inverse, environments, loop_runs, report, tables
from benchmarks.environments import Peer
from benchmarks.loop_contenders import Contender, answer, default_method
from benchmarks.loop_runs import bare, everyday, random_runs
from benchmarks.loop_verdicts import Row, Run, chattering, limits_kept, sign_changes, summary, words
from benchmarks.peers.loops import Loop, Servo, ahead, driven, rotation, rotation_vector
from benchmarks.peers.ours import METHODS
from benchmarks.tables import DOCS

SPEEDS = np.array([2.0, 4.0])
TIMES = 0.01 * np.arange(50)
STRAIGHT = """
import numpy as np
from looping import run
from loops import Servo

def make(loop, arguments):
    poses = lambda q: loop.poses[np.argmin(np.abs(loop.q - q).max(axis=1))]
    shake = 1.0 if arguments.method == "shaking" else 0.0
    state = {"sign": 1.0}
    def step(q, targets):
        state["sign"] *= -1
        return state["sign"] * shake * np.ones_like(q)
    return Servo(step, poses)

run("Straight", "straight", make, version="7", method=("calm", "shaking"), collisions=("no", "yes"))
"""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.setattr(loop_runs, "CACHE", tmp_path / "out" / "peers")
    monkeypatch.setattr(environments, "CACHE", tmp_path / "out" / "peers")


@pytest.fixture
def straight(tmp_path, monkeypatch):
    """A peer that runs in this interpreter and either stands still or shakes."""
    for name in ("timing.py", "loops.py", "looping.py"):
        (tmp_path / name).write_text((environments.SCRIPTS / name).read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "straight_loop.py").write_text(STRAIGHT, encoding="utf-8")
    monkeypatch.setattr(environments, "SCRIPTS", tmp_path)
    for module in (environments, closed_loop):
        monkeypatch.setattr(module, "interpreter", lambda _: sys.executable)
    return tuple(Contender(f"Straight, `{way}`", "straight", ("--method", way)) for way in ("calm", "shaking"))


# ---------------------------------------------------------------------------------------------- verdicts
def test_a_joint_that_shakes_chatters():
    series = np.stack([2.0 * (-1.0) ** np.arange(50), np.zeros(50)], axis=1)
    assert chattering(series, SPEEDS).tolist() == [True, False]
    assert sign_changes(series).tolist() == [49, 0]


def test_a_joint_that_stops_and_starts_again_and_again_chatters():
    assert chattering(np.tile([[1.0, 0.0], [0.0, 0.0]], (25, 1)), SPEEDS)[0]


@pytest.mark.parametrize(
    "series",
    [
        np.exp(-5 * TIMES),  # coming to rest
        np.sin(2 * np.pi * TIMES),  # turning once
        0.019 * (-1.0) ** np.arange(50),  # too slow
        np.where(TIMES < 0.1, 1.0, 1e-9 * (-1.0) ** np.arange(50)),  # at rest but for rounding
        np.zeros(50),
    ],
)
def test_a_joint_that_is_calm_does_not_chatter(series):
    assert not chattering(np.stack([series, 0 * series], axis=1), SPEEDS).any()


def test_one_joint_must_be_both_fast_and_turning():
    fast, turning = np.full(50, 2.0), 1e-3 * (-1.0) ** np.arange(50)
    assert not chattering(np.stack([fast, turning], axis=1), SPEEDS).any()


@pytest.fixture
def loop():
    """One run of a gantry of two joints, as far as verdicts know: a target 1 m away."""
    target = np.eye(4)[None, None].copy()
    target[..., 0, 3] = 1.0
    return Loop(
        q=np.zeros((1, 2)), targets=target, poses=np.eye(4)[None, None], lower=-np.ones(2), upper=np.ones(2),
        speeds=SPEEDS, joints=("a", "b"), tips=("tool",), urdf="", dt=0.01, steps=200, gain=5.0, caps=(0.2, 1.0),
    )  # fmt: skip


def judged(loop, qdot, away=1.0):
    """What is said of a run with these joint velocities that ends so far away."""
    answered = iter(qdot)
    made = driven(Servo(lambda *_: next(answered), lambda _: loop.poses[0]), loop, loop.q[0], loop.targets[0])
    end = loop.targets[0].copy()
    end[:, 0, 3] -= away
    return Run.of("gantry", 0, loop, end, made)


def test_every_run_has_its_word(loop):
    still, slow, shaking = np.zeros((200, 2)), np.full((200, 2), 0.004), np.full((200, 2), 1.0)
    shaking[::2] *= -1
    found = [judged(loop, *each).word for each in ((still,), (still, 0.0), (slow,), (shaking,), (shaking, 0.0))]
    assert found == ["rests short of it", "arrives", "is still moving", "chatters", "chatters at its target"]


def test_a_run_ends_when_the_arm_rests(loop):
    servo = Servo(lambda *_: np.zeros(2), lambda _: loop.poses[0])
    assert driven(servo, loop, loop.q[0], loop.targets[0])["steps"] == 100
    moving = Servo(lambda *_: np.full(2, 0.004), lambda _: loop.poses[0])
    assert driven(moving, loop, loop.q[0], loop.targets[0])["steps"] == 200


def test_broken_limits_are_told_by_how_much(loop):
    kept, beyond = judged(loop, np.full((200, 2), 0.004)), judged(loop, np.full((200, 2), 2.5))
    assert limits_kept(summary([kept])) == "yes"
    assert limits_kept(summary([kept, beyond])) == "to 4e+00 rad, 5e-01 rad/s"


def test_steps_that_are_refused_are_counted_and_the_arm_stands_still(loop):
    def refuse(*_):
        raise ValueError("no solution")

    for step in (refuse, lambda *_: None, lambda *_: np.full(2, np.nan)):
        made = driven(Servo(step, lambda _: loop.poses[0]), loop, loop.q[0], loop.targets[0])
        assert made["refused"] == made["steps"] == 100
        assert made["q"] == [0.0, 0.0]


def test_the_sentences_name_who_is_calm_and_who_is_not(loop):
    shaking = np.full((200, 2), 1.0)
    shaking[::2] *= -1
    rows = [
        Row("quiet", "1", True, {"gantry": [judged(loop, np.zeros((200, 2)), 0.0)]}, {}),
        Row("loud", "2", False, {"gantry": [judged(loop, shaking)]}, {"other": "cannot be installed"}),
    ]
    text = words(rows, {"pairs": 1, "arms": ["gantry"], "seconds": 2.0})
    assert "Chatter in no run: quiet." in text
    assert "loud chatters most, in 1 of 1 runs, at up to 1 rad/s" in text
    assert "loud did not run on other: cannot be installed." in text
    assert "the peers that chatter in no run" not in text  # there is none
    rows.append(Row("slow", "3", False, {"gantry": [judged(loop, np.full((200, 2), 0.004))]}, {}))
    text = words(rows, {"pairs": 1, "arms": ["gantry"], "seconds": 2.0})
    assert "Of the peers that chatter in no run slow reaches most targets" in text


# ---------------------------------------------------------------------------------------------- runs
def test_rotations_go_to_vectors_and_back(rng):
    for length in (0.0, 1e-9, 1e-3, 1.0, 3.0, np.pi - 1e-6, np.pi - 1e-12):
        axis = rng.normal(size=3)
        vector = length * axis / np.linalg.norm(axis)
        np.testing.assert_allclose(rotation_vector(rotation(vector)), vector, atol=1e-9)


def test_a_peer_is_sent_where_our_capped_task_goes():
    robot, _, _ = bare("panda")
    runs = random_runs("panda", 3, 1.0)
    for q, poses, targets in zip(runs.q, runs.poses, runs.targets):
        near = ahead(runs, poses, targets)[0]
        caps = {"max_linear": runs.caps[0] / runs.gain, "max_angular": runs.caps[1] / runs.gain}
        asked = rik.FrameTask(targets[0], runs.gain, **caps).equation(robot, q).xdot
        went = np.concatenate([near[:3, 3] - poses[0, :3, 3], rotation_vector(near[:3, :3] @ poses[0, :3, :3].T)])
        np.testing.assert_allclose(went / runs.dt, asked, atol=1e-9)
        assert np.linalg.norm(asked[:3]) == pytest.approx(0.2)


def test_runs_start_within_limits_and_are_the_same_each_time():
    first, again, one = (random_runs("baxter", pairs, 1.0) for pairs in (2, 2, 1))
    assert ((first.q >= first.lower) & (first.q <= first.upper)).all()
    assert first.targets.shape == (2, 2, 4, 4)
    np.testing.assert_array_equal(first.targets, again.targets)
    np.testing.assert_array_equal(first.targets[:1], one.targets)


def test_the_two_arms_in_one_file_are_the_two_arms(rng):
    robot, _, _ = bare("baxter")
    q = robot.random(rng)
    for tip, part in (("left_gripper", q[:7]), ("right_gripper", q[7:])):
        np.testing.assert_allclose(robot.pose(q, tip), rik.load("baxter", tip=tip).pose(part), atol=1e-12)


def test_the_everyday_target_is_back_and_down():
    runs = everyday(1.0)
    np.testing.assert_allclose((runs.targets - runs.poses)[0, 0, :3, 3], (-0.45, 0, -0.1))


def test_runs_are_read_as_they_were_saved(loop, tmp_path):
    again = Loop.read(loop.save(tmp_path / "runs.npz"))
    assert {type(value) for value in vars(again).values()} == {type(value) for value in vars(loop).values()}
    assert (again.tips, again.joints, again.caps, again.steps) == (loop.tips, loop.joints, loop.caps, loop.steps)


# ---------------------------------------------------------------------------------------------- the command
def test_the_default_is_one_of_the_methods():
    assert default_method() in METHODS


def test_what_is_measured_is_kept_until_runs_change(straight, monkeypatch):
    runs = random_runs("ur5", 1, 0.3)
    made = answer(straight[0], runs, "ur5")
    monkeypatch.setattr(Peer, "__enter__", lambda _: pytest.fail("measured again"))
    assert answer(straight[0], runs, "ur5") == made
    with pytest.raises(pytest.fail.Exception, match="measured again"):
        answer(straight[0], replace(runs, steps=20), "ur5")


@pytest.mark.slow
def test_the_command_writes_its_page(straight, tmp_path, monkeypatch, capsys):
    docs = tmp_path / "docs"
    docs.mkdir()
    page = docs / "closed_loop.md"
    page.write_text((DOCS / "closed_loop.md").read_text(encoding="utf-8"), encoding="utf-8")
    for module in (tables, report):
        monkeypatch.setattr(module, "DOCS", docs)
    monkeypatch.setattr(report, "OUT", tmp_path / "out" / "benchmarks")
    monkeypatch.setattr(closed_loop, "OURS", straight)
    monkeypatch.setattr(closed_loop, "PEERS", (Contender("Nobody", "nobody"),))
    monkeypatch.setattr(
        sys, "argv", ["closed_loop.py", "--pairs", "1", "--seconds", "0.6", "--arms", "ur5", "z1", "--write"]
    )
    closed_loop.main()
    text = page.read_text(encoding="utf-8")
    assert "| Straight, `shaking` 7 | 0% | 0% | 0% | 100% | 1 |" in text
    assert "| Straight, `calm` | 0 / 1 / 0 | 0 / 1 / 0 |" in text
    assert "| Nobody | – | – |" in text
    assert "* Chatter in no run: Straight, `calm`." in text
    assert "Nobody did not run on ur5: " in text
    assert text.count("<!-- closed_loop") == 10
    assert (docs / "benchmarks" / "closed_loop.svg").stat().st_size > 0
    assert (docs / "benchmarks" / "closed_loop.json").stat().st_size > 0
    assert "Straight" in capsys.readouterr().out


@pytest.mark.slow
def test_this_package_runs_as_its_peers_do():
    runs = random_runs("panda", 1, 0.3)
    contender = Contender("ours", "robust_ik", ("--method", "QuadraticProgram()"))
    (made,) = answer(contender, runs, "panda").runs
    assert made["steps"] == 30
    assert made["refused"] == 0
    assert max(made["excess"]) <= 1e-9
    before, after = ((bare("panda")[0].pose(q)[:3, 3] - runs.targets[0, 0, :3, 3]) for q in (runs.q[0], made["q"]))
    assert np.linalg.norm(after) < np.linalg.norm(before)


def test_the_page_tells_what_the_verdicts_take():
    page = Path(DOCS / "closed_loop.md").read_text(encoding="utf-8")
    for text in ("1 mm and 0.01 rad", "last half second", "1 % of its speed limit", "five times", "1e-3 rad/s"):
        assert text in page


# ----------------------------------------------------------------------------------------------- the default inverse
def test_a_joint_shakes_where_noise_comes_out_twenty_times_as_large(rng):
    noise = default_inverse.NOISE * default_inverse.HELD * rng.normal(size=(2000, 2))
    stopping = np.linspace(3.0, 0.0, 2000)[:, None]
    assert not default_inverse.shakes(15 * noise + stopping, 0.02)
    assert default_inverse.shakes([1, 25] * noise, 0.02)


def test_every_other_target_is_out_of_reach():
    loop = random_runs("ur5", 4, 1.0)
    far = default_inverse.beyond(loop)
    moved = np.linalg.norm(far.targets[:, 0, :3, 3] - loop.targets[:, 0, :3, 3], axis=1)
    np.testing.assert_allclose(moved, [0, default_inverse.AWAY, 0, default_inverse.AWAY])
    assert np.linalg.norm(far.targets[1, 0, :3, 3]) > 1.5 * bare("ur5")[0].size


def test_the_table_of_inverses_has_a_line_for_each_and_marks_the_default(monkeypatch, capsys):
    chosen = (default_inverse.default(), rik.DampedLeastSquares(0.1))
    monkeypatch.setattr(default_inverse, "INVERSES", chosen)
    monkeypatch.setattr(default_inverse, "SECONDS", 0.5)
    arguments = ["default_inverse", "--pairs", "1", "--arms", "ur5", "--seconds", "0.3"]
    monkeypatch.setattr(sys, "argv", arguments)
    monkeypatch.setattr(default_inverse, "ProcessPoolExecutor", ThreadPoolExecutor)
    default_inverse.main()
    lines = capsys.readouterr().out.strip().splitlines()
    assert [line.split("|")[1].strip() for line in lines[2:4]] == [
        "`JParse(0.01)`, the default",
        "`DampedLeastSquares(0.1)`",
    ]


def test_words_about_inverses_follow_from_the_table():
    rows = [
        ["`A`", "40%", "1.1", "0%", "0%"],
        ["`B`, the default", "50%", "1.5", "0%", "0%"],
        ["`C`", "60%", "2.5", "2%", "0%"],
    ]
    said = default_inverse.words(rows)
    assert "of `A`; `B`, the default a joint shakes, in some of `C` one does" in said
    assert said.endswith("`B`, the default arrives most often: in 50% of the runs.")
    rows[0][1] = "55%"
    said = default_inverse.words(rows)
    assert "`A` arrives most often: in 55%" in said
    assert said.endswith("The default arrives in 50%; it is calm.")
    rows[1][-1] = "1%"
    assert default_inverse.words(rows).endswith("it is not calm.")
    assert default_inverse.words(rows[2:]) == "Every inverse shakes with noise and lag."


def test_a_tool_that_acceleration_limits_keep_from_slowing_down_is_told_to_be_too_fast():
    loop = random_runs("ur5", 1, 0.5)
    robot, way = bare("ur5")[0], np.ones(6)

    def drive(speed):
        return Servo(lambda q, _: speed * way, lambda q: robot.pose(q)[None])

    slow, fast = (default_inverse.fastest(drive(speed), loop, 0) for speed in (0.01, 0.1))
    assert 0 < slow < 1
    np.testing.assert_allclose(fast, 10 * slow, rtol=0.3)


def test_a_controller_that_is_told_nothing_has_the_inverse_that_was_measured():
    assert rik.VelocityController(rik.load("ur5")).resolver == METHODS["Sliding()"].resolver
    assert default_inverse.default() in default_inverse.INVERSES
