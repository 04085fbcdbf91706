"""Scenarios as data: what can be said in a file, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.description.catalog import find
from robust_ik.description.dh.dh_toml import table_to_toml
from robust_ik.errors import InputError, LoadError, RobotNotFoundError
from robust_ik.simulation.scenarios import load_scenario, read_scenario, scenarios, with_reach

WHOLE = """
title = "there and back"
source = "ours"
angles = "deg"
[robot]
name = "planar_2r"
[start]
joints = [-45, 90]
[target]
kind = "line"
to = [1.0, 0.0, -0.5]
speed = 0.25
[control]
gain = 5.0
dt = 0.02
feedforward = true
[methods]
"calm" = { type = "JParse", gamma = 0.2 }
"strict" = { type = "TaskPriority", inverse = { type = "DampedLeastSquares" }, limiter = { type = "Scaling" } }
"""


def written(tmp_path, text, name="mine.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def changed(old, new):
    assert old in WHOLE
    return WHOLE.replace(old, new)


def test_a_file_says_everything_about_a_run_but_the_method(tmp_path):
    scenario = read_scenario(written(tmp_path, WHOLE))
    assert (scenario.name, scenario.title, scenario.source, scenario.note) == ("mine", "there and back", "ours", "")
    assert_allclose(scenario.q0, np.radians([-45, 90]))
    assert (scenario.dt, scenario.limits) == (0.02, ())
    start = scenario.robot.pose(scenario.q0)[:3, 3]
    assert scenario.duration == pytest.approx(math.dist(start, (1.0, 0.0, -0.5)) / 0.25)
    assert scenario.methods["calm"] == rik.JParse(gamma=0.2)
    assert scenario.methods["strict"] == rik.TaskPriority(rik.DampedLeastSquares(), limiter=rik.Scaling())


def test_its_tip_may_go_round_where_the_straight_way_ends(tmp_path):
    plain = read_scenario(written(tmp_path, WHOLE))
    asked = read_scenario(written(tmp_path, changed("dt = 0.02", "dt = 0.02\nreach = true")))
    assert [type(each.motion(0.0)[0][0]) for each in (plain, asked, with_reach(plain))] == [
        rik.FrameTask,
        rik.Reach,
        rik.Reach,
    ]
    assert_array_equal(with_reach(plain).motion(1.0)[0][0].target, plain.motion(1.0)[0][0].target)
    twists = replace(plain, motion=rik.Replay([0.0, 1.0], np.zeros((2, 6))))
    with pytest.raises(InputError, match="mine has no path to reach: its motion is Replay"):
        with_reach(twists)


def test_a_run_with_reach_gets_where_the_servo_rests_short():
    robot = rik.load("z1")
    for seed in range(20):  # a way that limits end
        q0, there = robot.random(np.random.default_rng(seed), 2)
        target = robot.pose(there)
        path = rik.Follow(lambda _, target=target: target, gain=5.0, max_linear=0.04, max_angular=0.2)
        scenario = rik.Scenario("z1", robot, q0, path, duration=6.0, limits=None)
        if np.linalg.norm(rik.simulate(scenario, None).final_error) > 0.05:
            break
    run = rik.simulate(replace(with_reach(scenario), duration=40.0), None)
    assert np.linalg.norm(run.final_error) < 1e-6
    assert run.largest_speed_ratio <= 1 + 1e-9


def test_it_is_simulated_with_its_methods_or_any_other(tmp_path):
    scenario = read_scenario(written(tmp_path, WHOLE))
    run = rik.simulate(scenario, "calm")
    assert run.name == "calm"
    assert len(run.time) == round(scenario.duration / 0.02)
    assert run.position_error[-1] < 1e-3
    assert rik.simulate(scenario, rik.DampedLeastSquares()).name == "DampedLeastSquares"
    with pytest.raises(InputError, match="no method 'wild'; there are: calm, strict"):
        rik.simulate(scenario, "wild")
    with pytest.raises(InputError, match="a Scenario has the rest"):
        rik.simulate(scenario.robot, rik.JParse())


@pytest.mark.parametrize(
    "kind, more",
    [
        ("hold", "position = [1.2, 0, 0.3]\nseconds = 2.0"),
        ("keypoints", "positions = [[1, 0, 0], [0.5, 0, 0.5]]\nseconds = 1.0"),
        ("arc", "centre = [1.0, 0, 0]\nnormal = [0, 1, 0]\nperiod = 3.0\nturns = 0.5"),
        ("sinusoid", "amplitude = [0.1, 0, 0]\nperiod = 4.0\nswings = 2.0"),
        ("line", "to = [1.0, 0, 0.2]\nspeed = 0.5\nto_rpy = [0, 10, 0]"),
    ],
)
def test_every_kind_of_target_is_a_path_with_a_duration(tmp_path, kind, more):
    text = changed('kind = "line"\nto = [1.0, 0.0, -0.5]\nspeed = 0.25', f'kind = "{kind}"\n{more}')
    scenario = read_scenario(written(tmp_path, text))
    path = scenario.motion.path
    assert path.duration == pytest.approx(scenario.duration)
    for time in np.linspace(0, 1.2 * path.duration, 7):
        R = path(time)[:3, :3]
        assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    if kind not in ("hold", "keypoints"):
        assert_allclose(path(0.0)[:3, 3], scenario.robot.pose(scenario.q0)[:3, 3])
    if kind == "line":
        turn = rik.pose_error(path(0.0), path(path.duration))[3:]
        assert np.linalg.norm(rik.pose_error(path(path.duration / 2), path(path.duration))[3:]) == pytest.approx(
            np.linalg.norm(turn) / 2
        )


def test_an_orientation_is_a_second_level_above_the_posture(tmp_path):
    more = """
[orientation]
rows = ["wy"]
gain = 3.0
[posture]
joints = [0, 0]
"""
    scenario = read_scenario(written(tmp_path, WHOLE + more))
    (_, (held,), (posture,)) = scenario.motion(0.0)
    assert (held.rows, held.gain) == (("wy",), 3.0)
    assert_allclose(held.target, scenario.robot.pose(scenario.q0)[:3, :3])
    assert isinstance(posture, rik.PostureTask)
    turned = read_scenario(written(tmp_path, WHOLE + more.replace("gain = 3.0", "rpy = [0, -90, 0]")))
    assert_allclose(turned.motion(0.0)[1][0].target, [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-15)


def test_a_robot_may_lie_beside_the_file(tmp_path):
    (tmp_path / "arm.toml").write_text(table_to_toml(rik.read_dh(find("planar_2r").path)))
    scenario = read_scenario(written(tmp_path, changed('"planar_2r"', '"arm.toml"')))
    assert scenario.robot.n == 2


@pytest.mark.parametrize(
    "text, message",
    [
        ("nonsense", "is no TOML"),
        ("a = " + "[" * 5000, "is no TOML"),
        (changed("[robot]", "[robots]"), "needs 'robot'"),
        (changed('"planar_2r"', '"planer_2r"'), "no robot called 'planer_2r'"),
        (changed('"planar_2r"', "3"), "robot.name must be"),
        (changed("joints = [-45, 90]", "joints = [-45]"), r"start.joints must have shape \(\.\.\., 2\)"),
        (changed("joints = [-45, 90]", "joints = [nan, 90]"), "start.joints"),
        (changed('"line"', '"lime"'), "no kind 'lime'; did you mean 'line'"),
        (changed("speed = 0.25", "speed = -1"), "target.speed must be"),
        (changed("speed = 0.25", "speed = 1\nsped = 2"), "target has no use for 'sped'; did you mean 'speed'"),
        (changed("to = [1.0, 0.0, -0.5]\n", ""), "target needs 'to'"),
        (changed("gain = 5.0", 'gain = "much"'), "control.gain must be"),
        (changed("dt = 0.02", "dt = 0.02\nsteps = 3"), "control has no use for 'steps'"),
        (changed("dt = 0.02", 'reach = "yes"'), "control.reach must be true or false"),
        (changed("dt = 0.02", "limits = 1"), "control.limits must be true or false"),
        (changed('"deg"', '"grad"'), 'angles must be "rad" or "deg"'),
        (changed('title = "there and back"', "title = 3"), "title must be text"),
        (changed('"JParse", gamma = 0.2', '"JPars", gamma = 0.2'), "no type 'JPars'; did you mean 'JParse'"),
        (changed("gamma = 0.2", "gama = 0.2"), "JParse has no parameter 'gama'; there are: gamma"),
        (changed("gamma = 0.2", "gamma = 2"), "methods.calm: gamma"),
        (changed('{ type = "JParse", gamma = 0.2 }', '"JParse"'), "methods.calm must be a table such as"),
        (changed('"JParse", gamma = 0.2', '"Scaling"'), "methods.calm must be a table such as"),
        (WHOLE + "\n[other]\na = 1\n", "no use for 'other'"),
        (WHOLE + "\n[orientation]\nrow = 1\n", "orientation has no use for 'row'"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_the_place(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises((InputError, LoadError), match=message):
        read_scenario(path)


def test_names_are_offered_and_files_need_not_be_in_the_package(tmp_path):
    with pytest.raises(RobotNotFoundError, match="no scenario 'xarm_line'; did you mean 'xarm7_line'"):
        load_scenario("xarm_line")
    with pytest.raises(RobotNotFoundError, match="no file"):
        load_scenario(tmp_path / "none.toml")
    assert load_scenario(written(tmp_path, WHOLE)).name == "mine"


@pytest.mark.parametrize("name", scenarios())
def test_every_scenario_of_the_package_loads_and_says_what_it_is(name):
    scenario = load_scenario(name)
    assert scenario.title
    assert scenario.source
    assert scenario.methods
    assert scenario.robot.pose(scenario.q0).shape == (4, 4)
