"""What the second-order inverse promises: exact, continuous, calm at the edge of reach, able to leave singularities."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.inverses.second_order.turning import AGAINST, PATIENCE, Turn
from robust_ik.inverses.second_order.weak_motion import quartic
from robust_ik.inverses.second_order.weak_rows import weak_rows
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from tests.screws import rotation

ARMS = ("puma560", "ur5", "pa10", "panda", "srs_7r", "kinova_gen3", "z1", "duleba_3r")
SPEED, ACCELERATION = 2.0, 20.0
seeds = st.integers(0, 2**32 - 1)


def equation(robot, q, xdot):
    return TaskEquation(robot.jacobian(q), xdot, xdot, robot.hessian(q))


def singular(robot, rng, count):
    """Configurations of corank 1, by their joint values: (q, lost direction u)."""
    found = project(ScrewChain.of(robot), 1, rng.uniform(-2.6, 2.6, (8 * count, robot.n)))
    for values in found.values[found.converged]:
        q = robot.configuration(values)
        whole = svd(robot.jacobian(q))
        if whole.s[-1] < 1e-8 * whole.s[0] < 0.05 * whole.s[-2]:
            yield q, whole.U[:, -1]
            count -= 1
        if count == 0:
            return


@pytest.mark.parametrize("name", ARMS)
def test_it_is_the_pseudo_inverse_where_all_singular_values_are_above_the_threshold(name, rng):
    robot, seen = rik.load(name), 0
    run = rik.SecondOrder().begin(0.01)
    for q in robot.random(rng, 200):
        J = robot.jacobian(q)
        s = np.linalg.svd(J)[1]
        if s[-1] < 0.08 * s[0]:
            continue
        xdot, seen = rng.normal(size=len(J)), seen + 1
        wanted = np.linalg.pinv(J) @ xdot
        assert_allclose(run.velocity(equation(robot, q, xdot)), wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
        assert_allclose(rik.SecondOrder().solve(J, xdot), wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
    assert seen > 5


@pytest.mark.parametrize("name", ARMS)
def test_velocities_do_not_jump_where_a_singular_value_crosses_the_threshold(name, rng):
    robot, seen = rik.load(name), 0
    for q, d, xdot in zip(
        robot.random(rng, 300), rng.normal(size=(300, robot.n)), rng.normal(size=(300, len(robot.rows)))
    ):

        def found(t, q=q, d=d, xdot=xdot):
            there = robot.integrate(q, t * d)
            s = np.linalg.svd(robot.jacobian(there))[1]
            weak = int(np.sum(s < 0.08 * s[0]))
            return weak, rik.SecondOrder().begin(0.01).velocity(equation(robot, there, 0.3 * xdot))

        low, high = 0.0, 0.05
        if found(low)[0] == found(high)[0] or max(found(low)[0], found(high)[0]) > 1:
            continue
        for _ in range(30):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if found(middle)[0] == found(low)[0] else (low, middle)
        seen += 1
        assert np.abs(found(high)[1] - found(low)[1]).max() < 1e-5
        if seen == 6:
            break
    assert seen


@given(seeds)
@settings(deadline=None, max_examples=40)
def test_turned_task_axes_make_no_difference(seed):
    rng = np.random.default_rng(seed)
    m, n = ((3, 3), (6, 6), (6, 7), (3, 5))[seed % 4]
    U, V = (np.linalg.qr(rng.normal(size=(k, k)))[0] for k in (m, n))
    s = np.r_[np.sort(rng.uniform(0.3, 1, m - 1))[::-1], rng.uniform(0, 0.06)]
    J, H, xdot = U @ np.diag(s) @ V[:m], rng.normal(size=(m, n, n)), 0.2 * rng.normal(size=m)
    Q = np.linalg.qr(rng.normal(size=(m, m)))[0]
    first, second = (
        rik.SecondOrder().begin(0.01).velocity(TaskEquation(A @ J, A @ xdot, xdot, np.tensordot(A, H, 1)))
        for A in (np.eye(m), Q)
    )
    assert_allclose(second, first, atol=1e-7)


@given(seeds)
@settings(deadline=None, max_examples=40)
def test_the_units_of_a_task_make_no_difference(seed):
    rng = np.random.default_rng(seed)
    J, H, xdot = rng.normal(size=(3, 4)), rng.normal(size=(3, 4, 4)), rng.normal(size=3)
    J[2] *= 0.02
    first, second = (
        rik.SecondOrder().begin(0.01).velocity(TaskEquation(c * J, c * xdot, xdot, c * H)) for c in (1.0, 1e-3)
    )
    assert_allclose(second, first, atol=1e-7)


@given(st.floats(1e-6, 0.04), st.floats(0.02, 3.0), st.floats(0.01, 2.0), st.sampled_from([0.001, 0.004, 0.02]))
@settings(deadline=None, max_examples=300)
def test_a_command_out_of_reach_never_crosses_the_fold(sigma, kappa, c, dt):
    """One joint before a fold, σ = κy ≤ γσ₁/2, and a command outwards: y falls by no more than dt/τ ≤ 1/4 of it."""
    J, H = np.array([[1.0, 0.0], [0.0, sigma]]), np.zeros((2, 2, 2))
    H[1, 1, 1] = -kappa
    qdot = rik.SecondOrder(speed=SPEED, acceleration=ACCELERATION).begin(dt).velocity(
        TaskEquation(J, np.array([0.0, c]), np.zeros(2), H)
    )  # fmt: skip
    y = sigma / kappa
    assert -1e-12 <= qdot[1] * dt <= 0.25 * y * (1 + 1e-6)


@given(seeds)
@settings(deadline=None, max_examples=100)
def test_everything_is_finite_and_what_is_lost_is_not_faster_than_twice_the_speed(seed):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 7, 2)
    U, V = (np.linalg.qr(rng.normal(size=(k, k)))[0] for k in (m, n))
    rank = rng.integers(0, min(m, n) + 1)
    s = np.where(np.arange(min(m, n)) < rank, 1.0, 0.03 * rng.random(min(m, n)) * rng.integers(0, 2, min(m, n)))
    J = (U[:, : len(s)] * s) @ V[: len(s)]
    H, xdot = 10.0 ** rng.uniform(-3, 1) * rng.normal(size=(m, n, n)), 10.0 ** rng.uniform(-3, 2) * rng.normal(size=m)
    run = rik.SecondOrder(speed=SPEED, acceleration=ACCELERATION).begin(0.01)
    for _ in range(4):
        qdot = run.velocity(TaskEquation(J, xdot, xdot, H))
        assert np.isfinite(qdot).all()
        assert rank == 0 or np.linalg.norm(V[rank:] @ qdot) <= 2 * SPEED * (1 + 1e-9)


@pytest.mark.parametrize("size", [1e-300, 1e-295, 0.0])
def test_a_jacobian_of_nothing_gives_no_motion(size):
    run = rik.SecondOrder().begin(0.01)
    for _ in range(2):
        assert not run.velocity(TaskEquation(size * np.eye(3), np.ones(3), np.ones(3), np.ones((3, 3, 3)))).any()


def fold(sigma, c, kappa=0.2):
    """A joint on a fold, beside one that is kept, and a command inwards."""
    H = np.zeros((2, 2, 2))
    H[1, 1, 1] = kappa
    return TaskEquation(np.diag([1.0, sigma]), np.array([0.0, c]), np.zeros(2), H)


def test_a_symmetric_point_is_left_so_that_the_joint_turns_positive_and_the_side_is_kept():
    run = rik.SecondOrder().begin(0.01)
    assert run.velocity(fold(0.0, 0.1))[1] > 0.5
    for sigma in (1e-3, -1e-3, 3e-3, -3e-3):  # noise of σ, whose sign would decide alone
        assert run.velocity(fold(sigma, 0.1))[1] > 0.5
    assert rik.SecondOrder().begin(0.01).velocity(fold(-3e-3, 0.1))[1] < -0.5


@given(seeds)
@settings(deadline=None, max_examples=30)
def test_only_the_symmetric_part_of_a_hessian_counts(seed):
    rng = np.random.default_rng(seed)
    J, H, xdot = rng.normal(size=(3, 4)), rng.normal(size=(3, 4, 4)), 0.3 * rng.normal(size=3)
    J[2] *= 0.02
    first, second = (
        rik.SecondOrder().begin(0.01).velocity(TaskEquation(J, xdot, xdot, each)) for each in (H, np.swapaxes(H, 1, 2))
    )
    assert_allclose(second, first, atol=1e-9)


@pytest.mark.parametrize("kappa", [0.01, 0.03, 0.1, 1.0])
def test_a_large_command_is_followed_out_of_a_fold_as_fast_as_joints_may(kappa):
    """It was damped to nothing once, from 20 κ rad/s on."""
    H = np.zeros((2, 2, 2))
    H[1, 1, 1] = kappa
    for c in (0.05, 0.2, 0.5, 1.0, 3.0, 30.0):
        run = rik.SecondOrder(speed=SPEED, acceleration=ACCELERATION).begin(0.01)
        qdot = run.velocity(TaskEquation(np.diag([1.0, 0.0]), np.array([0.0, c]), np.zeros(2), H))
        assert 0.2 * min(SPEED, np.sqrt(c / kappa)) < abs(qdot[1]) <= 2 * SPEED


def closed_loop(robot, q, target, dt, seconds):
    """(errors, fastest joints, σ_min) of a run within limits of speed and acceleration."""
    n = robot.n
    limits = rik.JointLimits.of(
        robot, lower=np.full(n, -np.inf), upper=np.full(n, np.inf), velocity=np.full(n, SPEED),
        acceleration=np.full(n, ACCELERATION),
    )  # fmt: skip
    controller = rik.VelocityController(robot, rik.SecondOrder(speed=SPEED, acceleration=ACCELERATION), limits)
    whole = len(robot.rows) == 6
    task = rik.FrameTask(target, gain=4) if whole else rik.PositionTask(target[:3, 3], gain=4, rows=robot.rows)
    told, last = [], np.zeros(n)
    for _ in range(int(seconds / dt)):
        qdot = controller.step(q, task, dt).qdot
        assert np.abs(qdot).max() <= SPEED * (1 + 1e-9)
        assert np.abs(qdot - last).max() <= ACCELERATION * dt * (1 + 1e-9)
        q, last = robot.integrate(q, qdot * dt), qdot
        equation = task.equation(robot, q)
        told.append((np.linalg.norm(equation.error), np.abs(qdot).max(), np.linalg.svd(equation.J)[1][-1]))
    return np.array(told).T


def beyond(robot, q, step):
    """The pose a step of the task away, (m,): metres along and radians about world axes."""
    parts = dict(zip(robot.rows, step))
    target, turn = robot.pose(q).copy(), np.array([parts.get(row, 0.0) for row in ("wx", "wy", "wz")])
    angle = np.linalg.norm(turn)
    target[:3, :3] = (rotation(turn / angle, angle) if angle > 0 else np.eye(3)) @ target[:3, :3]
    target[:3, 3] += [parts.get(row, 0.0) for row in ("x", "y", "z")]
    return target


@pytest.mark.parametrize("name", ("puma560", "ur10", "kinova", "srs_7r", "duleba_3r"))
def test_it_follows_commands_that_the_curvature_serves_and_rests_where_none_does(name, rng):
    """From exactly singular configurations: first order sees nothing there."""
    robot, asked = rik.load(name), {}
    for q, u in singular(robot, rng, 2):
        for side in (0.05, -0.05):
            kind = robot.way_out(q, side * u).exit
            error, speed, _ = closed_loop(robot, q, beyond(robot, q, side * u), 0.01, 4.0)
            asked.setdefault(kind, []).append((error.min() / error[0], speed[-1]))
    served = [end for kind in (rik.Exit.FOLD, rik.Exit.BOTH_WAYS) for end in asked.get(kind, [])]
    assert all(left < 0.75 for left, _ in served)
    assert all(speed < 1e-3 for _, speed in asked.get(rik.Exit.END_OF_REACH, []))
    plain = rik.VelocityController(robot, rik.JParse(0.01), ())
    q, u = next(singular(robot, rng, 1))
    task = rik.FrameTask(beyond(robot, q, 0.05 * u), gain=4) if len(robot.rows) == 6 else None
    if task is not None:  # what the word "first order sees nothing" means
        assert np.abs(plain.step(q, task, 0.01).qdot).max() < 1e-2


@pytest.mark.parametrize("dt", [0.001, 0.004, 0.02])
@pytest.mark.parametrize("name", ["duleba_3r", "ur5", "puma560"])
def test_at_a_target_out_of_reach_the_arm_comes_to_rest_and_sigma_only_falls(name, dt, rng):
    robot = rik.load(name)
    for q, u in singular(robot, rng, 8):
        kinds = {side: robot.way_out(q, side * u) for side in (1.0, -1.0)}
        ends = [side for side, way in kinds.items() if way.exit is rik.Exit.END_OF_REACH]
        if not ends or abs(kinds[ends[0]].curvature) < 0.05:
            continue
        inward = kinds[-ends[0]].motion
        _error, speed, sigma = closed_loop(
            robot, robot.integrate(q, 0.3 * inward), beyond(robot, q, 0.08 * ends[0] * u), dt, 3
        )
        later = int(1 / dt)
        assert speed[-1] < 1e-3
        assert np.diff(sigma[later:]).max() < 1e-9
        break
    else:
        pytest.fail("no fold was tried")


def test_a_wrist_turns_until_the_lost_direction_comes_back_and_only_after_some_patience():
    robot = rik.load("puma560")
    q = robot.configuration([0.3, -0.8, 2.6, 0.5, 0.0, 0.9])
    J = robot.jacobian(q)
    u = svd(J).U[:, -1]
    way = robot.way_out(q, u)
    assert way.exit is rik.Exit.TURN_FIRST
    assert 0.1 < way.turn < np.pi / 2
    assert_allclose(np.abs(way.motion), [0, 0, 0, np.sqrt(0.5), 0, np.sqrt(0.5)], atol=1e-9)
    error, speed, _ = closed_loop(robot, q, beyond(robot, q, 0.05 * u), 0.004, 3)
    assert speed[: int(0.2 / 0.004)].max() < 1e-3
    assert error[-1] < 0.01 * error[0]


@pytest.mark.parametrize("name", ["ur5", "puma560", "panda"])
def test_targets_far_away_are_followed_too(name, rng):
    robot, seen = rik.load(name), 0
    for q, u in singular(robot, rng, 4):
        for side in (0.5, -0.5):
            if robot.way_out(q, side * u).exit in (rik.Exit.FOLD, rik.Exit.BOTH_WAYS):
                seen += 1
                _, speed, _ = closed_loop(robot, q, beyond(robot, q, side * u), 0.02, 1.0)
                assert speed.max() > 0.1
    assert seen


def test_a_turn_that_does_not_help_ends_and_does_not_begin_again():
    robot = rik.load("puma560")
    q = robot.configuration([0.061472, 2.398154, -1.528403, 2.327342, -0.948667, -0.398702])
    target = beyond(robot, q, -0.05 * np.array([0.06143, -0.99811, 0, 0, 0, 0]))
    limits = rik.JointLimits.of(robot, lower=np.full(6, -np.inf), upper=np.full(6, np.inf), velocity=np.full(6, 2.0))
    for calm in (True, False):
        controller = rik.VelocityController(robot, rik.SecondOrder(), limits, calm=calm)
        there, task, told = q, rik.FrameTask(target, gain=4), []
        for _ in range(1000):
            qdot = controller.step(there, task, 0.02).qdot
            there = robot.integrate(there, 0.02 * qdot)
            told.append((np.abs(qdot).max(), np.linalg.norm(task.equation(robot, there).error)))
        assert max(speed for speed, _ in told[-100:]) < 1e-2
        assert max(error for _, error in told) < 0.075


def test_a_turn_changes_sides_without_a_jump():
    """J, H and ẋ stand still, so that it turns for ever: there, back, to the other side, and ends."""
    robot = rik.load("puma560")
    q = robot.configuration([0.3, -0.8, 2.6, 0.5, 0.0, 0.9])
    same = equation(robot, q, 0.3 * svd(robot.jacobian(q)).U[:, -1])
    run, all_qdot = rik.SecondOrder().begin(0.001), []
    for _ in range(9000):
        all_qdot.append(run.velocity(same)[3])
    assert np.abs(np.diff(all_qdot)).max() < 0.05
    assert max(all_qdot) > 1.5
    assert min(all_qdot) < -1.5
    assert abs(all_qdot[-1]) < 1e-12


@given(seeds)
@settings(deadline=None, max_examples=60)
def test_a_turn_hardly_moves_the_tool_against_the_command(seed):
    rng = np.random.default_rng(seed)
    U, V = (np.linalg.qr(rng.normal(size=(k, k)))[0] for k in (3, 4))
    J = (U * [1.0, 0.6, 0.05 * rng.random()]) @ V[:3]
    rows = weak_rows(J, U[:, 2] * rng.uniform(0.05, 0.5), rng.normal(size=(3, 4, 4)), 0.08)
    f = quartic(rows, SPEED, ACCELERATION, 0.25, 0.01)
    moved, _ = Turn(waited=2 * PATIENCE).added(rows, f, np.zeros(2), SPEED, 0.01)
    assert rows.command @ f.D @ moved >= -AGAINST * np.linalg.norm(rows.command) ** 2 * (1 + 1e-9)


def test_a_turn_is_forgotten_after_a_second_of_progress_or_for_another_command():
    turn = Turn(waited=0.5, turned=5.0, way=np.ones(3), asked=np.eye(2)[0])
    for _ in range(9):
        turn = turn.after(np.array([0.3, 0.1]), 0.0, 0.0, 0.1)
    assert turn.turned == 5
    for _ in range(2):
        turn = turn.after(np.array([0.3, 0.1]), 0.0, 0.0, 0.1)
    assert turn.turned == 0
    told = Turn(turned=5.0, asked=np.eye(2)[0])
    assert told.after(np.array([0.3, 0.1]), 1.0, 0.0, 0.1).turned == 5
    assert told.after(np.array([0.1, 0.3]), 1.0, 0.0, 0.1).turned == 0
    assert told.after(np.zeros(2), 0.0, 0.0, 0.1).turned == 5


def test_levels_that_get_more_or_fewer_joints_begin_anew():
    robot = rik.load("puma560")
    q = robot.configuration([0.3, -0.8, 2.6, 0.5, 0.0, 0.9])
    above = [rik.JointTask("joint1", 0.3)], [rik.PositionTask(robot.pose(q, "joint1")[:3, 3], frame="joint1")]
    main = rik.FrameTask(beyond(robot, q, 0.05 * svd(robot.jacobian(q)).U[:, -1]), gain=4)
    for first, second in (above, above[::-1]):
        controller = rik.VelocityController(robot, rik.SecondOrder(), ())
        for level in [first] * 70 + [second] * 70:
            assert np.isfinite(controller.step(q, [level, [main]], 0.01).qdot).all()


def test_a_planar_arm_told_to_leave_its_plane_stays():
    robot = rik.load("planar_3r").with_rows(("x", "y", "z"))
    q = robot.configuration([0.4, 0.7, -0.9])
    out = svd(robot.jacobian(q)).U[:, -1]
    assert robot.way_out(q, out).exit is rik.Exit.STRUCTURAL
    run = rik.SecondOrder().begin(0.01)
    for _ in range(200):
        assert np.abs(run.velocity(equation(robot, q, 0.2 * out))).max() < 1e-9


def test_what_is_missing_or_wrong_is_said():
    with pytest.raises(rik.InputError, match="SecondOrder needs the Hessian"):
        rik.SecondOrder().velocity(TaskEquation(np.eye(2), np.ones(2), np.ones(2)))
    with pytest.raises(rik.InputError, match="speed_limits must be > 0, and one of them finite"):
        rik.SecondOrder.from_limits([np.inf, np.inf])
    for dt in (-1.0, np.nan):
        with pytest.raises(rik.InputError, match="dt"):
            rik.SecondOrder().begin(dt)
    inverse = rik.SecondOrder.from_limits([2.0, 1.5, np.inf], [np.inf, 8.0, 9.0])
    assert (inverse.speed, inverse.acceleration) == (1.5, 8.0)
    assert rik.SecondOrder.from_limits([2.0]).acceleration == 20
