"""The motion of the demo: the words on its page and its runs go by the same limits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.cli.demo import SINGULAR, at_the_end, kept
from robust_ik.description.urdf.urdf_reader import lock_slides, parse_urdf
from robust_ik.simulation.scenarios import stretch

ELBOW = [("turn", "revolute", "0 0 1", 0.0), ("arm", "revolute", "0 1 0", 0.3), ("elbow", "revolute", "0 1 0", 0.5),
         ("hand", "revolute", "0 1 0", 0.4)]  # fmt: skip
CARTESIAN = [("x", "prismatic", "1 0 0", 0.0), ("y", "prismatic", "0 1 0", 0.0), ("z", "prismatic", "0 0 1", 0.0)]
ROLL = ("roll", "revolute", "0 0 1", 0.0)


def arm(joints, far=2.0):
    """A chain of (name, type, axis, length of the link before it along z), its slides going from −far to far."""
    text = []
    for i, (name, kind, axis, length) in enumerate(joints):
        end = far if kind == "prismatic" else 3.0
        text.append(
            f'<joint name="{name}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="0 0 {length}" rpy="0.2 0.1 0"/><axis xyz="{axis}"/>'
            f'<limit lower="{-end}" upper="{end}" velocity="1" effort="1"/></joint><link name="l{i + 1}"/>'
        )
    hand = f'<parent link="l{len(joints)}"/><child link="tip"/><origin xyz="0 0 .1"/>'
    text.append(f'<joint name="end" type="fixed">{hand}</joint><link name="tip"/>')
    xml = f'<robot name="made"><link name="l0"/>{"".join(text)}</robot>'
    return rik.Robot.from_description(parse_urdf(xml), "tip")


@pytest.fixture(scope="module")
def on_a_rail():
    scenario = stretch(arm([("rail", "prismatic", "1 0 0", 0.0), *ELBOW], far=1000.0))
    return scenario, {"JParse": scenario.run(rik.JParse())}


@pytest.fixture(scope="module")
def slides_only():
    scenario = stretch(arm([*CARTESIAN, ROLL]))
    return scenario, {"JParse": scenario.run(rik.JParse())}


def test_a_rail_of_kilometres_stands_still_and_the_arm_meets_its_singularity(on_a_rail):
    scenario, runs = on_a_rail
    assert scenario.locked == ("rail",)
    assert scenario.reach.distance < 2
    assert runs["JParse"].sigma[:, -1].min() < SINGULAR * runs["JParse"].sigma[0, 0]
    assert "rail stands still" in kept(scenario)
    assert "the arm is singular" in at_the_end(runs)


def test_an_arm_that_its_slides_move_about_keeps_their_limits_and_is_not_called_singular(slides_only):
    scenario, runs = slides_only
    values = scenario.robot.joint_values(runs["JParse"].q)[:, :3]
    assert scenario.locked == ()
    assert np.abs(values).max() <= 2 + 1e-9
    assert np.abs(values).max() > 1.9
    assert "stay within their limits" in kept(scenario)
    assert "is not singular" in at_the_end(runs)


def test_without_slides_the_page_says_that_no_limit_is_kept():
    scenario = stretch(arm(ELBOW))
    assert scenario.limits == ()
    assert kept(scenario).startswith("Limits of joints and of speeds are not enforced")
    assert "still" not in kept(scenario)


@pytest.mark.parametrize("name", ["tiago", "made"])
def test_a_slide_that_is_locked_leaves_every_pose_as_it_was(name, rng):
    telescope = [("lift", "prismatic", "0 1 1", 0.2), ELBOW[0], ("boom", "prismatic", "1 0 -1", 0.1), *ELBOW[1:]]
    robot = rik.load("tiago") if name == "tiago" else arm(telescope)
    kinds = [robot.description.joint[each].kind for each in robot.joint_names]
    slides = [i for i, kind in enumerate(kinds) if kind == "prismatic"]
    values = robot.joint_values(robot.random(rng))
    locked = lock_slides(robot.description, {robot.joint_names[i]: values[i] for i in slides})
    fixed = rik.Robot.from_description(locked, robot.tip)
    assert fixed.n == robot.n - len(slides)
    others = fixed.configuration(np.delete(values, slides))
    assert_allclose(fixed.pose(others), robot.pose(robot.configuration(values)), atol=1e-12)
