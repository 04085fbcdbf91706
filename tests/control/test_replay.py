"""Recorded twists, played back."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import Replay
from robust_ik.simulation.scenarios import read_scenario

TIMES = np.array([0.5, 1.0, 2.0])
TWISTS = np.array([[0.1, 0, 0, 0, 0, 0], [0.3, 0.2, 0, 0, 0, 1.0], [0, 0, 0, 0, 0, 0]])
SCENARIO = """
title = "led by hand"
source = "ours"
[robot]
name = "planar_2r"
[start]
joints = [0.1, 1.0]
[target]
kind = "twists"
samples = [[0, 0, 0, 0, 0, 0, 0], [0.5, 0.1, -0.2, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 0, 0]]
[control]
dt = 0.01
[methods]
"calm" = { type = "JParse" }
"""


def test_between_samples_it_is_a_straight_line_and_outside_there_is_no_motion():
    replay = Replay(TIMES, TWISTS)
    assert_allclose(replay.twist(0.75), (TWISTS[0] + TWISTS[1]) / 2)
    assert_allclose(replay.twist(1.0), TWISTS[1])
    assert_allclose(replay.twist(1.75), TWISTS[1] / 4)
    assert not replay.twist(0.4).any()
    assert not replay.twist(2.1).any()
    assert replay.duration == 2.0


def test_it_gives_a_twist_task_above_the_levels_below():
    posture = rik.PostureTask(np.zeros(2))
    stack = Replay(TIMES, TWISTS, "link2", "local", below=[[posture]])(1.0)
    assert isinstance(stack[0][0], rik.TwistTask)
    assert (stack[0][0].frame, stack[0][0].reference) == ("link2", "local")
    assert_allclose(stack[0][0].twist, TWISTS[1])
    assert stack[1] == [posture]


def test_its_arrays_are_its_own():
    times = TIMES.copy()
    replay = Replay(times, TWISTS)
    times[0] = 0
    assert replay.times[0] == 0.5
    with pytest.raises(ValueError, match="read-only"):
        replay.twists[0, 0] = 1


@pytest.mark.parametrize(
    "times, twists, match",
    [
        ([0.0], np.zeros((1, 6)), "at least two that increase"),
        ([0.0, 0.0], np.zeros((2, 6)), "at least two that increase"),
        ([[0.0, 1.0]], np.zeros((2, 6)), "at least two that increase"),
        ([0.0, np.nan], np.zeros((2, 6)), "times must be finite"),
        ([0.0, 1.0], np.zeros((3, 6)), "twists must have shape"),
        ([0.0, 1.0], np.zeros((4, 2, 6)), "twists must have shape"),
        ([0.0, 1.0], [[0] * 6, [np.inf] * 6], "twists must be finite"),
    ],
)
def test_what_is_no_recording_is_refused(times, twists, match):
    with pytest.raises(rik.InputError, match=match):
        Replay(times, twists)


def written(tmp_path, text):
    path = tmp_path / "led.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_scenario_with_twists_runs_them_open_loop(tmp_path):
    scenario = read_scenario(written(tmp_path, SCENARIO))
    assert scenario.duration == 1.0
    run = rik.simulate(scenario, "calm")
    assert not run.error.any()
    # The arm is regular here, so the tip moves by the integral of the command, up to the explicit steps.
    assert_allclose(run.pose[-1, :2, 3] - run.pose[0, :2, 3], [0.05, -0.1], atol=1e-3)


@pytest.mark.parametrize(
    "old, new, match",
    [
        ("dt = 0.01", "dt = 0.01\ngain = 2.0", "control has no use for 'gain'"),
        ("[1.0, 0, 0, 0, 0, 0, 0]]", "[0.2, 0, 0, 0, 0, 0, 0]]", "target: times must be at least two that increase"),
        (", [1.0, 0, 0, 0, 0, 0, 0]]", ", [1.0, 0]]", "target.samples"),
        ("samples", "lines", "target needs 'samples'"),
    ],
)
def test_a_scenario_says_what_is_wrong_with_its_twists(tmp_path, old, new, match):
    assert old in SCENARIO
    with pytest.raises(rik.InputError, match=match):
        read_scenario(written(tmp_path, SCENARIO.replace(old, new)))
