"""Tasks that climb the manipulability or a singular value."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import ClimbingTask, ManipulabilityTask, SingularValueTask
from robust_ik.kinematics import svd

ROBOTS = ["panda", "ur5", "xarm7", "kinova", "so101", "pa10", "planar_3r", "panda+panda_rightfinger"]


def load(name):
    name, _, tip = name.partition("+")
    return rik.load(name, tip or None)


def sigma_min(J):
    return svd.svd(J).s[..., -1]


def gradient(measure, robot, q, h=1e-6):
    around = robot.integrate(q, h * np.concatenate([np.eye(robot.n), -np.eye(robot.n)]))
    values = measure(robot.jacobian(around))
    return (values[: robot.n] - values[robot.n :]) / (2 * h)


def climb(robot, q, task, steps, dt=0.02):
    for _ in range(steps):
        equation = task.equation(robot, q)
        length = equation.J[0] @ equation.J[0]
        q = robot.integrate(q, dt * equation.J[0] * (equation.xdot[0] / length if length > 0 else 0))
    return q


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize(
    "kind, measure", [(ManipulabilityTask, svd.manipulability), (SingularValueTask, sigma_min)], ids=["w", "sigma"]
)
def test_the_row_is_the_unit_gradient_and_below_the_threshold_the_measure_rises_as_asked(name, kind, measure, rng):
    robot = load(name)
    q = robot.random(rng)
    slope = gradient(measure, robot, q)
    value = float(measure(robot.jacobian(q)))
    task = kind(gain=2.0, threshold=1.001 * value, max_speed=10.0)
    equation = task.equation(robot, q, hessian=True)
    assert_allclose(equation.J[0], slope / np.linalg.norm(slope), atol=1e-5)
    assert_allclose(equation.xdot * np.linalg.norm(slope), 2.0 * 0.001 * value, rtol=1e-5)
    assert_allclose(equation.xdot, 2.0 * equation.error)
    assert equation.hessian is None
    assert_allclose(equation.weight, 0.001 / 1.001 / 0.1, rtol=1e-6)
    assert_allclose(kind().equation(robot, q).J, equation.J)


@pytest.mark.parametrize("kind", [ManipulabilityTask, SingularValueTask])
@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_at_and_above_the_threshold_nothing_is_asked(kind, factor, rng):
    robot = rik.load("panda")
    J = robot.jacobian(robot.rest)
    value = float(svd.manipulability(J) if kind is ManipulabilityTask else sigma_min(J))
    equation = kind(threshold=factor * value, weight=2.0).equation(robot, robot.rest)
    assert equation.J.shape == (1, 7)
    assert not equation.J.any()
    assert not equation.xdot.any()
    assert equation.weight == 2.0


@pytest.mark.parametrize("kind", [ManipulabilityTask, SingularValueTask])
def test_the_joint_speed_it_asks_for_is_capped_everywhere(kind, rng):
    robot = rik.load("ur5")
    for q in [robot.neutral, *robot.random(rng, 20)]:
        for threshold in (None, 1e3):
            equation = kind(gain=50.0, threshold=threshold, max_speed=0.3).equation(robot, q)
            assert 0 < equation.xdot[0] <= 0.3 * (1 + 1e-12)
            assert_allclose(np.linalg.norm(equation.J), 1)


@pytest.mark.parametrize("kind", [ManipulabilityTask, SingularValueTask])
def test_it_leads_out_of_a_singularity_and_on_either_side(kind):
    # 2R with a stretched elbow: w = a1 a2 |sin q2|.
    robot = rik.load("planar_2r")
    for elbow in (0.0, 1e-9, -1e-9):
        q = climb(robot, np.array([0.3, elbow]), kind(), 20)
        assert_allclose(abs(q[1]), 20 * 0.02 * 0.5, atol=0.02)
        assert elbow * q[1] >= 0


def test_the_climb_ends_smoothly_at_the_top():
    # Manipulability is greatest at an elbow of ±90°.
    robot = rik.load("planar_2r")
    q = climb(robot, np.array([0.3, 0.4]), ManipulabilityTask(), 1000)
    assert_allclose(q[1], np.pi / 2, atol=1e-6)
    assert_allclose(ManipulabilityTask().equation(robot, q).xdot, 0, atol=1e-6)
    # So too below a threshold that cannot be reached.
    q = climb(robot, np.array([0.3, 0.4]), ManipulabilityTask(threshold=99.0), 1000)
    assert_allclose(q[1], np.pi / 2, atol=1e-6)


@pytest.mark.parametrize("kind, target", [(ManipulabilityTask, 0.02), (SingularValueTask, 0.03)])
def test_the_threshold_is_approached_from_below_and_not_passed(kind, target):
    robot = rik.load("ur5")
    start = robot.configuration([0.3, -1.0, 0.01, -0.5, 0.05, 0.1])
    q = climb(robot, start, kind(gain=2.0, threshold=target), 500)
    J = robot.jacobian(q)
    value = float(svd.manipulability(J) if kind is ManipulabilityTask else sigma_min(J))
    assert_allclose(value, target, rtol=1e-3)
    assert value <= target


@pytest.mark.parametrize("kind", [ManipulabilityTask, SingularValueTask])
@pytest.mark.parametrize("name", ["ur5", "panda", "pa10", "srs_7r", "xarm7"])
def test_it_leads_out_of_the_zero_position_where_singularities_cross_and_several_singular_values_vanish(kind, name):
    # UR5: elbow and wrist, where even the gradient of the one singular value vanishes; PA-10 and S-R-S: corank 3.
    robot = rik.load(name)
    assert sigma_min(robot.jacobian(robot.neutral)) < 1e-15
    q = climb(robot, robot.neutral, kind(), 100)
    assert sigma_min(robot.jacobian(q)) > 0.01


def test_a_frame_that_no_joint_moves_asks_for_nothing():
    robot = rik.load("panda")
    for kind in (ManipulabilityTask, SingularValueTask):
        assert not kind(frame="panda_link0").equation(robot, robot.rest).J.any()


class Fixed:
    """A stand-in for a robot with a given J and its derivative."""

    name, tip, n, rows, length_scale = "fixed", "tip", 3, ("x", "y", "wz"), 1.0

    def __init__(self, J, H):
        self.J, self.H = J, H

    def jacobian(self, q, frame=None, rows=None):
        return self.J

    def hessian(self, q, frame=None, rows=None):
        return self.H


def test_where_singular_values_coincide_the_row_does_not_depend_on_their_basis(rng):
    H = rng.normal(size=(3, 3, 3))
    Q, W = (np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(2))
    rows = []
    for tiny in (0, 1e-15, 1e-9):
        for _ in range(3):
            J = Q @ np.diag([2.0, 1.0, 1.0]) @ W + tiny * rng.normal(size=(3, 3))
            rows.append(SingularValueTask().equation(Fixed(J, H), np.zeros(3)).J)
    assert_allclose(rows, np.broadcast_to(rows[0], np.shape(rows)), atol=1e-5)
    share = np.einsum("ij,ijk->k", Q[:, 1:] @ W[1:], H)
    assert_allclose(rows[0][0], share / np.linalg.norm(share), atol=1e-9)


def test_the_length_scale_multiplies_angular_rows(rng):
    robot = rik.load("panda")
    q = robot.random(rng)
    scale = np.repeat([1.0, 0.2], 3)[:, None]
    slope = gradient(lambda J: svd.svd(scale * J).s[..., 2], robot, q)
    J = SingularValueTask(index=2, length_scale=0.2).equation(robot, q).J
    assert_allclose(J[0], slope / np.linalg.norm(slope), atol=1e-6)


def test_a_measure_of_ones_own_needs_one_method():
    class First(ClimbingTask):
        def measure(self, J, hessian, rows):
            return float(J[0] @ J[0]) / 2, J[0] @ hessian[0]

    robot = rik.load("planar_2r")
    assert First(rows=("x",)).equation(robot, np.array([0.3, 0.4])).J.shape == (1, 2)


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: ManipulabilityTask(threshold=0.0), "threshold must be > 0"),
        (lambda: ManipulabilityTask(threshold=np.nan), "threshold must be > 0"),
        (lambda: ManipulabilityTask(max_speed=np.inf), "max_speed must be > 0"),
        (lambda: ManipulabilityTask(rows=("q",)), "rows must be some of"),
        (lambda: SingularValueTask(index=1.5), "index must be a whole number"),
        (lambda: SingularValueTask(length_scale=-1.0), "length_scale must be > 0"),
        (lambda: SingularValueTask(index=2).equation(rik.load("planar_2r"), np.zeros(2)), "2 singular values, got 2"),
    ],
)
def test_what_cannot_be_meant_is_refused(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()
