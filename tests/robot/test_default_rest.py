"""Where a robot starts when nobody says where: not where its tip has lost a motion."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.description.catalog import catalog, find
from robust_ik.robot.default_rest import MARGIN, REGULAR, SINGULAR, default_rest
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
    assert least(robot, robot.with_default_rest().rest) > 0.8 * REGULAR
    moved = np.abs(robot.difference(zero(robot), robot.with_default_rest().rest)) > 0
    assert 0 < moved.sum() <= 3


@pytest.mark.parametrize("name", ["z1", "xarm7", "so101", "panda"])
def test_where_zero_is_regular_it_stays(name):
    robot = rik.load(name)
    if least(robot, zero(robot)) > 2 * SINGULAR:
        assert_array_equal(robot.with_default_rest().rest, zero(robot))


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_choice_does_not_hang_on_the_unit_of_length(size):
    assert_allclose(ur5(size).with_default_rest().rest, ur5().with_default_rest().rest, atol=1e-12)


def two_links(noise=0.0, seed=0):
    """The Jacobian of a planar arm with two links of 1 m, as a function of its joint values, with relative noise."""
    rng = np.random.default_rng(seed)

    def jacobian(values):
        first, both = values[0], values.sum()
        rows = [[-np.sin(first) - np.sin(both), -np.sin(both)], [np.cos(first) + np.cos(both), np.cos(both)]]
        return np.array(rows) * (1 + noise * rng.normal(size=(2, 2)))

    return jacobian


def rest_of_two_links(unit, limit, **noise):
    bent = np.array([[0.0, np.pi / 2]])  # usual is what it has with its elbow at a right angle
    return default_rest(two_links(**noise), np.full(2, -limit), np.full(2, limit), np.full(2, unit), bent)


def test_the_choice_does_not_hang_on_last_bits():
    """Postures that mirror each other are equally good: the first that is tried is taken."""
    expected = rest_of_two_links(np.pi / 4, 0.9)
    assert_allclose(expected, [0, 0.81])
    for seed in range(20):
        assert_allclose(rest_of_two_links(np.pi / 4, 0.9, noise=1e-12, seed=seed), expected, atol=1e-12)


def test_joints_are_bent_until_the_least_singular_value_is_half_of_the_usual():
    jacobian = two_links()
    usual = np.linalg.svd(jacobian(np.array([0.0, np.pi / 2])), compute_uv=False)[-1]
    found = rest_of_two_links(0.1, np.inf)
    assert np.linalg.svd(jacobian(found), compute_uv=False)[-1] >= REGULAR * usual
    assert_allclose(np.sign(found), [0, 1])


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
