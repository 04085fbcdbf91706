"""Where a robot starts when nobody says where: not where its tip has lost a motion."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.description.catalog import catalog, find
from robust_ik.robot.default_rest import MARGIN, REGULAR, SINGULAR
from tests.arms import ur5

NO_JOINTS = {"hector", "iris_simple"}
ARMS = [name for name, each in catalog().items() if not (each.known and each.known.rest) and name not in NO_JOINTS]
SINGULAR_AT_ZERO = (
    "ur3",
    "ur5",
    "ur10",
    "pa10",
    "puma560",
    "planar_3r",
    "kinova_gen3",
    "srs_7r",
    "talos_arm",
    "hextilt",
)


def least(robot, q):
    """The least singular value that is not always zero, of an arm of usual size."""
    s = np.linalg.svd(robot.jacobian(q), compute_uv=False)
    usual = np.median(
        np.linalg.svd(robot.jacobian(robot.random(np.random.default_rng(5), 200)), compute_uv=False), axis=0
    )
    kept = usual > 1e-8 * usual[0]
    return s[kept][-1] / usual[kept][-1]


def zero(robot):
    return robot.configuration(np.clip(0.0, robot.lower, robot.upper))


def link(**limits):
    return rik.DHJoint(a=1.0, d=0.0, alpha=0.0, **limits)


def loaded(name):
    try:
        return rik.load(name)
    except rik.TipError:  # several arms
        return rik.load(name, whole_tree=True)


@pytest.mark.parametrize("name", ARMS)
def test_no_robot_starts_where_its_tip_has_lost_a_motion(name):
    robot = loaded(name)
    assert (robot.joint_values(robot.rest) >= robot.lower).all()
    assert (robot.joint_values(robot.rest) <= robot.upper).all()
    if robot.tip is None:
        assert_array_equal(robot.rest, zero(robot))
    else:
        assert least(robot, robot.rest) > SINGULAR / 2


@pytest.mark.parametrize("name", SINGULAR_AT_ZERO)
def test_where_zero_is_singular_a_few_joints_are_bent(name):
    robot = rik.load(name)
    assert least(robot, zero(robot)) < 1e-6
    assert least(robot, robot.with_default_rest().rest) > REGULAR / 2
    moved = np.abs(robot.difference(zero(robot), robot.with_default_rest().rest)) > 0
    assert 0 < moved.sum() <= 3


@pytest.mark.parametrize("name", ["z1", "xarm7", "so101", "panda"])
def test_where_zero_is_regular_it_stays(name):
    robot = rik.load(name)
    if least(robot, zero(robot)) > 2 * SINGULAR:
        assert_array_equal(robot.with_default_rest().rest, zero(robot))


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_choice_does_not_hang_on_the_unit_of_length_or_on_last_bits(size, monkeypatch):
    expected = ur5().with_default_rest().rest
    assert_allclose(ur5(size).with_default_rest().rest, expected, atol=1e-12)
    exact, rng = rik.Robot.jacobian, np.random.default_rng(3)
    monkeypatch.setattr(
        rik.Robot, "jacobian", lambda *a, **k: (J := exact(*a, **k)) * (1 + 1e-12 * rng.normal(size=J.shape))
    )
    assert_allclose(ur5(size).with_default_rest().rest, expected, atol=1e-12)


def test_what_is_stated_is_kept():
    known = find("panda").known.rest
    assert_allclose(rik.load("panda").joint_values(rik.load("panda").rest), known)
    joints = [link(name="q1"), link(name="q2")]
    stretched = rik.Robot.from_dh(rik.DHTable(joints, "standard", name="two", rows=("x", "y"), rest=np.zeros(2)))
    assert_array_equal(stretched.rest, [0, 0])
    bent = rik.Robot.from_dh(rik.DHTable(joints, "standard", name="two", rows=("x", "y")))
    assert least(bent, bent.rest) > REGULAR


def test_a_joint_that_cannot_move_far_stays_inside_its_limits():
    joints = [link(name="q1"), link(name="q2", lower=-0.1, upper=0.2)]
    robot = rik.Robot.from_dh(rik.DHTable(joints, "standard", name="two", rows=("x", "y")))
    assert robot.rest[0] == 0
    assert robot.rest[1] != 0
    assert -0.1 + 0.3 * MARGIN <= robot.rest[1] <= 0.2 - 0.3 * MARGIN
    assert least(robot, robot.rest) > REGULAR
