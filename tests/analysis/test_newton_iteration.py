"""Newton's iteration with robust inverses: how it ends. Dułęba's error laws are in `test_paper_duleba`."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik import InputError
from robust_ik.analysis.newton_iteration import NewtonStatus, newton
from robust_ik.inverses import DampedLeastSquares, JParse, MoorePenrose, RobustInverse


@pytest.fixture(scope="module")
def arm():
    return rik.load("duleba_3r")


# ------------------------------------------------------------------------------------------------ how it ends
def line(q):
    return 2 * q


def test_a_linear_task_takes_one_step_and_a_shorter_step_a_geometric_series():
    J = np.array([[2.0, 0], [0, 2.0]])
    result = newton(line, lambda q: J, MoorePenrose(), [0.0, 0], [2.0, 4])
    assert result.iterations == 1
    assert result.error < 1e-14
    assert_allclose(result.q, [1, 2])
    slow = newton(line, lambda q: J, MoorePenrose(), [0.0, 0], [2.0, 4], step=0.25, max_iterations=10)
    assert slow.status is NewtonStatus.ITERATION_LIMIT
    assert_allclose(slow.errors, np.sqrt(20) * 0.75 ** np.arange(11))
    assert_allclose(slow.path, [1, 2] * (1 - 0.75 ** np.arange(11)[:, None]), atol=1e-9)
    assert_allclose(slow.q, slow.path[-1], rtol=0)


def test_convergence_at_a_regular_target_is_quadratic(arm):
    target = arm.pose([0.2, 0.4, 1.2])[:3, 3]
    result = newton(
        lambda q: arm.pose(q)[:3, 3], arm.jacobian, MoorePenrose(), [0.3, 0.5, 1.1], target, tolerance=1e-13
    )
    assert result.converged
    assert result.iterations <= 5
    e = result.errors
    assert e[2] < 10 * e[1] ** 2
    assert e[3] < 10 * e[2] ** 2


def test_no_iteration_is_needed_or_allowed():
    at_target = newton(line, lambda q: [[2.0]], MoorePenrose(), [1.0], [2.0], max_iterations=0)
    assert at_target.converged
    assert at_target.iterations == 0
    away = newton(line, lambda q: [[2.0]], MoorePenrose(), [1.0], [3.0], max_iterations=0)
    assert away.status is NewtonStatus.ITERATION_LIMIT
    assert_allclose(away.errors, [1])


@pytest.mark.exact_start
def test_a_target_along_a_lost_direction_is_a_status_not_an_exception():
    stretched = newton(
        lambda q: np.array([np.cos(q[0]), 0.0]), lambda q: [[-np.sin(q[0])], [0]], JParse(), [0.0], [0.5, 0]
    )
    assert stretched.status is NewtonStatus.STUCK
    assert stretched.iterations == 0
    assert not stretched.converged
    assert "no motion" in stretched.status.value


def test_a_configuration_beyond_all_numbers_is_a_status_too():
    result = newton(lambda q: 0 * q, lambda q: [[1e-250]], MoorePenrose(), [0.0], [1e90])
    assert result.status is NewtonStatus.DIVERGED
    assert np.isfinite(result.q).all()


def test_a_pose_is_reached_with_minus_the_pose_error_as_kinematics():
    robot = rik.load("puma560")
    target = robot.pose(robot.rest + 0.2)
    result = newton(
        lambda q: -rik.pose_error(robot.pose(q), target),
        robot.jacobian,
        DampedLeastSquares(1e-3),
        robot.rest,
        np.zeros(6),
        integrate=robot.integrate,
    )
    assert result.converged
    assert_allclose(robot.pose(result.q), target, atol=1e-8)


# ------------------------------------------------------------------------------------------------ what the inverse sees
@dataclass(frozen=True)
class Curious(RobustInverse):
    """Looks at the Hessian and at the error, and remembers dt and how often it was asked."""

    seen: list

    @property
    def needs_hessian(self):
        return True

    def begin(self, dt):
        self.seen.append(dt)
        return Curious(self.seen)

    def solve(self, J, xdot):
        raise NotImplementedError

    def velocity(self, equation):
        self.seen.append((equation.error.copy(), equation.hessian))
        # Still at first: only an inverse without a memory is stuck then.
        return np.zeros(1) if len(self.seen) < 4 else equation.error / 2


def test_the_inverse_is_told_the_error_the_hessian_and_the_step():
    seen = []
    result = newton(line, lambda q: [[2.0]], Curious(seen), [0.0], [2.0], step=1.0, hessian=lambda q: [[[7.0]]])
    assert result.converged
    assert seen[0] == 1.0
    assert_allclose(seen[1][0], [2])
    assert_allclose(seen[1][1], [[[7]]])
    with pytest.raises(InputError, match="needs the Hessian"):
        newton(line, lambda q: [[2.0]], Curious([]), [0.0], [2.0])


def test_the_result_cannot_be_written_to_and_the_start_is_left_alone():
    q0 = np.zeros(1)
    result = newton(line, lambda q: [[2.0]], MoorePenrose(), q0, [2.0])
    assert q0[0] == 0
    for array in (result.q, result.path, result.errors):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize(
    "change, match",
    [
        ({"step": 0.0}, "step must be > 0"),
        ({"step": 1.5}, "step ≤ 1"),
        ({"tolerance": 0.0}, "tolerance must be > 0"),
        ({"max_iterations": -1}, "max_iterations ≥ 0"),
        ({"q0": [[0.0]]}, "q0 must be one vector"),
        ({"target": [1.0, 2.0]}, r"kinematics\(q\) must have shape"),
        ({"target": [np.nan]}, "target must be finite"),
        ({"kinematics": lambda q: q * np.nan}, r"kinematics\(q\) must be finite"),
        ({"jacobian": lambda q: [[1.0], [2.0]]}, r"jacobian\(q\) must have shape"),
    ],
)
def test_what_cannot_be_meant_is_refused(change, match):
    given = {"kinematics": line, "jacobian": lambda q: [[2.0]], "inverse": MoorePenrose(), "q0": [0.0], "target": [2.0]}
    with pytest.raises(InputError, match=match):
        newton(**{**given, **change})


@pytest.mark.parametrize("cap", [np.nan, np.inf, 2.5, True, -1])
def test_a_cap_that_is_no_count_is_refused(cap):
    with pytest.raises(rik.InputError, match="max_iterations"):
        rik.newton(lambda q: q, lambda q: np.eye(1), rik.JParse(), [0.0], [1.0], max_iterations=cap)


@pytest.mark.exact_start
def test_a_weighted_inverse_is_stuck_where_the_one_inside_is():
    robot = rik.load("planar_2r")
    for inverse in (rik.JParse(), rik.Weighted(rik.JParse(), joint_weights=[1.0, 1.0])):
        result = rik.newton(lambda q: robot.pose(q)[:2, 3], robot.jacobian, inverse, [0.0, 0.0], [1.0, 0.0])
        assert result.status is rik.NewtonStatus.STUCK
