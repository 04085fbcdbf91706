"""The compiled second-order step is the one in NumPy: for any equation, at singularities, over whole runs."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.inverses.second_order.numpy_step import Remembered, numpy_step
from robust_ik.inverses.second_order.turning import PATIENCE, Turn
from robust_ik.inverses.second_order.weak_motion import quartic
from robust_ik.inverses.second_order.weak_rows import weak_rows
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order import velocity_8, velocity_16
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from tests.inverses.test_second_order import equation

ARMS = ("panda", "ur5", "pa10", "puma560", "xarm7", "z1", "duleba_3r", "planar_3r")
DT = 0.01


class Both:
    """A run in compiled code, and the same run in NumPy, each with its own memory."""

    def __init__(self, inverse, m, n, dt=DT):
        self.parameters, self.shape = inverse.parameters(dt), (m, n)
        self.memory, self.remembered = np.zeros(lay.memory_size(m, n)), Remembered(np.zeros(n))
        self.kernel = velocity_8 if max(m, n) <= 8 else velocity_16

    def step(self, J, xdot, H):
        """The velocities of both, (2, n)."""
        out = np.empty(self.shape[1])
        xdot = np.ascontiguousarray(xdot)
        assert self.kernel(J, xdot, H, self.parameters, self.memory, out)
        self.remembered = numpy_step(self.parameters, J, xdot, H, self.remembered)
        return np.array([out, self.remembered.last])

    @property
    def memories(self):
        """What both remember, (2, size), zeros where there is nothing."""
        (m, n), turn = self.shape, self.remembered.turn
        way, asked = np.zeros(n) if turn.way is None else turn.way, np.zeros(m) if turn.asked is None else turn.asked
        told = [turn.waited, turn.progressed, turn.turned, turn.way is not None, turn.asked is not None]
        mine = self.memory.copy()
        mine[lay.LAST + n : lay.LAST + 2 * n] *= mine[lay.HAS_WAY]
        mine[lay.LAST + 2 * n :] *= mine[lay.HAS_ASKED]
        return np.array([mine, [*told, *self.remembered.last, *way, *asked]])

    def alike(self, J, xdot, H):
        """Whether a step is the same by both; if not, it is one between minima that are equally good."""
        found = self.step(J, xdot, H)
        if np.abs(found[0] - found[1]).max() <= 1e-9 * max(1.0, np.abs(found[1]).max()):
            return True
        gamma, speed, acceleration, horizon, _, dt = self.parameters
        rows = weak_rows(J, xdot, H, gamma)
        f = quartic(rows, speed, acceleration, horizon, dt)
        costs = [f.value(rows.kernel.T @ (qdot - rows.kept)) for qdot in found]
        assert abs(costs[1] - costs[0]) < 1e-9 * (1e-3 + rows.speed**2)
        return False


def spectrum(rng, count):
    """Singular values, some of them weak: random, repeated, tiny or zero."""
    weak = rng.integers(0, count + 1)
    s = rng.uniform(0.3, 1.0, count)
    s[count - weak :] = 0.08 * rng.random(weak) * rng.choice([0.0, 1e-9, 1e-3, 1.0, 1.0], weak)
    if weak > 1 and rng.random() < 0.3:
        s[count - weak :] = s[-1]
    return np.sort(s)[::-1]


@pytest.mark.parametrize("largest", [8, 16])
def test_it_is_the_step_in_numpy_for_any_equation_and_memory(largest, rng):
    same, count = 0, 300 if largest == 8 else 80
    for index in range(count):
        m, n = rng.integers(1, largest + 1, 2)
        k = min(m, n)
        U, V = (np.linalg.qr(rng.normal(size=(size, size)))[0] for size in (m, n))
        J = (U[:, :k] * spectrum(rng, k)) @ V[:k]
        H, xdot = (
            10.0 ** rng.uniform(-3, 0.5) * rng.normal(size=(m, n, n)),
            10.0 ** rng.uniform(-3, 1) * rng.normal(size=m),
        )
        both = Both(rik.SecondOrder(turn=float(index % 2)), m, n)
        for _ in range(4):
            if not both.alike(J, xdot, H):
                break
            xdot = xdot + 0.05 * rng.normal(size=m)
            J = J + 0.003 * (index % 3) * rng.normal(size=(m, n))
        else:
            same += 1
            assert_allclose(*both.memories, rtol=1e-6, atol=1e-7)
    assert same > 0.98 * count


def singular_configurations(robot, corank, rng, count):
    """Configurations at which the `corank` last singular values vanish."""
    found = project(ScrewChain.of(robot), corank, rng.uniform(-2.6, 2.6, (8 * count, robot.n)))
    for values in found.values[found.converged][:count]:
        yield robot.configuration(values)


@pytest.mark.parametrize("name", ARMS)
def test_at_singular_configurations_of_real_arms_too(name, rng):
    robot = rik.load(name)
    seen, same = 0, 0
    for corank in (1, 2, 3):
        for q in singular_configurations(robot, corank, rng, 6):
            J, H = robot.jacobian(q), robot.hessian(q)
            for share in (0.0, 0.01, 0.3):
                xdot = share * rng.normal(size=len(J))
                both = Both(rik.SecondOrder(), *J.shape)
                seen += 1
                same += all(both.alike(J, xdot, H) for _ in range(3))
    assert seen >= 18
    assert same >= 0.9 * seen


@pytest.mark.parametrize("name", ARMS)
def test_whole_runs_from_a_singular_configuration_stay_together(name, rng):
    """Waiting, turning and giving up included: a run of 3 s, closed around the compiled step."""
    robot, seen = rik.load(name), 0
    for q in singular_configurations(robot, 1, rng, 3):
        J = robot.jacobian(q)
        asked = 0.2 * np.linalg.svd(J)[0][:, -1] + 0.02 * rng.normal(size=len(J))
        both = Both(rik.SecondOrder(), *J.shape)
        for step in range(300):
            e = equation(robot, q, asked if step < 200 else -asked)
            if not both.alike(e.J, e.xdot, e.hessian):
                break
            q = robot.integrate(q, DT * np.clip(both.remembered.last, -2, 2))
            seen += 1
    assert seen > 300


def test_a_turn_that_lasts_is_remembered_alike():
    """The wrist of a PUMA, held still: it waits, turns, changes sides and ends; another command, and it begins anew."""
    robot = rik.load("puma560")
    q = robot.configuration([0.3, -0.8, 2.6, 0.5, 0.0, 0.9])
    J, H = robot.jacobian(q), robot.hessian(q)
    lost = np.linalg.svd(J)[0][:, -1]
    both, sides = Both(rik.SecondOrder(), 6, 6, dt=0.004), set()
    for step in range(2600):
        found = both.step(J, (0.3 if step < 2400 else -0.3) * lost, H)
        assert_allclose(found[0], found[1], rtol=0, atol=1e-9)
        assert_allclose(*both.memories, rtol=1e-9, atol=1e-9)
        sides.add(np.sign(np.round(found[0, 3], 6)))
    assert sides == {-1.0, 0.0, 1.0}
    assert both.memory[lay.TURNED] > 0
    q[4] = 0.9
    J = robot.jacobian(q)
    for _ in range(300):  # the same command, with progress of more than a second: all is forgotten
        both.step(J, -0.3 * lost, H)
        assert_allclose(*both.memories, rtol=1e-9, atol=1e-9)
    assert both.memory[lay.TURNED] == 0


def test_turns_that_would_move_the_tool_against_the_command_are_alike(rng):
    """As far as they move, beside kernel motions of any kind."""
    turned = 0
    for _ in range(100):
        U, V = (np.linalg.qr(rng.normal(size=(size, size)))[0] for size in (3, 4))
        J, H = (U * [1.0, 0.6, 0.05 * rng.random()]) @ V[:3], 10.0 ** rng.uniform(-2, 0) * rng.normal(size=(3, 4, 4))
        xdot = np.ascontiguousarray(U[:, 2]) * rng.uniform(0.05, 0.5)
        both = Both(rik.SecondOrder(), 3, 4)
        both.memory[lay.WAITED], both.remembered = 2 * PATIENCE, Remembered(np.zeros(4), Turn(waited=2 * PATIENCE))
        for _ in range(3):
            assert both.alike(J, xdot, H)
            assert_allclose(*both.memories, rtol=1e-7, atol=1e-7)
        turned += both.memory[lay.TURNED] > 0
    assert turned > 20


def test_the_kernel_for_more_joints_gives_the_same(rng):
    for _ in range(50):
        J, H, xdot = rng.normal(size=(3, 5)), rng.normal(size=(3, 5, 5)), rng.normal(size=3)
        J[2] *= 0.01
        parameters, found = rik.SecondOrder().parameters(DT), np.empty((2, 5))
        for kernel, out in zip((velocity_8, velocity_16), found):
            assert kernel(J, xdot, H, parameters, np.zeros(lay.memory_size(3, 5)), out)
        assert_allclose(found[0], found[1], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("m, n", [(2, 17), (17, 3)])
def test_what_no_kernel_has_room_for_is_left_to_numpy(m, n, rng):
    J, H, xdot = rng.normal(size=(m, n)), rng.normal(size=(m, n, n)), rng.normal(size=m)
    J[:, -1] *= 1e-3
    run, remembered = rik.SecondOrder().begin(DT), Remembered(np.zeros(n))
    for _ in range(3):
        remembered = numpy_step(run.parameters, J, xdot, H, remembered)
        assert_allclose(run.velocity(TaskEquation(J, xdot, xdot, H)), remembered.last)


def test_a_run_keeps_its_memory_and_another_one_has_its_own():
    """The last velocities decide to which side a symmetric point is left."""
    J, H = np.diag([1.0, 0.0]), np.zeros((2, 2, 2))
    H[1, 1, 1] = 0.2
    there, back = (TaskEquation(J + np.diag([0, s]), np.array([0.0, 0.1]), np.zeros(2), H) for s in (-3e-3, 3e-3))
    first, second = rik.SecondOrder().begin(DT), rik.SecondOrder().begin(DT)
    assert first.velocity(there)[1] < -0.5
    assert first.velocity(back)[1] < -0.5
    more = TaskEquation(np.vstack([back.J, [0, 0]]), np.array([0, 0.1, 0]), np.zeros(3), np.vstack([H, 0 * H[:1]]))
    assert first.velocity(more)[1] < -0.5
    assert second.velocity(back)[1] > 0.5
    assert first.begin(DT).velocity(back)[1] > 0.5


def test_a_task_may_get_rows_and_joints_within_a_run(rng):
    run = rik.SecondOrder().begin(DT)
    for m, n in ((3, 4), (2, 4), (3, 4), (3, 5), (9, 4), (1, 1)):
        J, H, xdot = rng.normal(size=(m, n)), rng.normal(size=(m, n, n)), rng.normal(size=m)
        assert np.isfinite(run.velocity(TaskEquation(J, xdot, xdot, H))).all()


def test_with_another_number_of_rows_the_turn_begins_anew():
    robot = rik.load("puma560")
    q = robot.configuration([0.3, -0.8, 2.6, 0.5, 0.0, 0.9])
    J, H, run = robot.jacobian(q), robot.hessian(q), rik.SecondOrder().begin(0.004)
    asked = 0.3 * np.linalg.svd(J)[0][:, -1]
    for _ in range(150):
        moved = run.velocity(TaskEquation(J, asked, asked, H))
    assert np.abs(moved).max() > 0.1
    more = TaskEquation(np.vstack([J, 0 * J[:1]]), np.append(asked, 0), np.zeros(7), np.vstack([H, 0 * H[:1]]))
    assert np.abs(run.velocity(more)).max() < 1e-6


SIZES = (1e-300, 1e-150, 1.0, 1e150, 1e300)


def made(step):
    """What a step gives, None if it is refused as too large."""
    try:
        return step()
    except rik.InputError as error:
        if "too large" not in str(error):
            raise
        return None


@pytest.mark.parametrize("of_J", [1e-300, 1e-290, 1e-150, 1.0, 1e150, 1e300])
def test_velocities_of_extreme_equations_are_numbers_or_refused_alike(of_J, rng):
    for of_H in SIZES:
        for of_x in (1e-300, 1e-150, 1.0, 1e99):
            for small in (0.02, 0.0, 1e-9):
                J, H, xdot = rng.normal(size=(3, 4)), of_H * rng.normal(size=(3, 4, 4)), of_x * rng.normal(size=3)
                J[2] *= small
                J, run, start = of_J * J, rik.SecondOrder().begin(DT), Remembered(np.zeros(4))
                given = TaskEquation(J, xdot, xdot, H)
                found = made(lambda run=run, given=given: [run.velocity(given) for _ in range(2)])
                with np.errstate(over="ignore"):
                    last = made(
                        lambda e=given, p=run.parameters, r=start: numpy_step(p, e.J, e.xdot, e.hessian, r).last
                    )
                assert (found is None) == (last is None)
                assert found is None or (np.isfinite(found).all() and np.isfinite(last).all())


def test_a_jacobian_of_nothing_rows_of_nothing_and_one_joint():
    for J in (np.zeros((2, 3)), np.zeros((1, 1)), np.zeros((4, 2))):
        m, n = J.shape
        both = Both(rik.SecondOrder(), m, n)
        assert not both.step(J, np.ones(m), np.ones((m, n, n))).any()
    for J in (np.array([[1e-3]]), np.array([[0.0, 1e-3]]), np.array([[0.0], [2.0]]), np.eye(3, 2)):
        both = Both(rik.SecondOrder(), *J.shape)
        for _ in range(3):
            assert both.alike(J, np.ones(len(J)), np.ones((*J.shape, J.shape[1])))


@pytest.mark.parametrize("twice", [0.0, 0.03])
def test_where_singular_values_are_equal_the_basis_does_not_matter(twice, rng):
    """Two weak rows with one σ, in turned task axes and turned joints."""
    for _ in range(30):
        U, V = (np.linalg.qr(rng.normal(size=(size, size)))[0] for size in (4, 5))
        J, H = (U * [1.0, 0.7, twice, twice]) @ V[:4], rng.normal(size=(4, 5, 5))
        xdot, parameters, found = 0.2 * rng.normal(size=4), rik.SecondOrder().parameters(DT), []
        for Q, W in ((np.eye(4), np.eye(5)), [np.linalg.qr(rng.normal(size=(size, size)))[0] for size in (4, 5)]):
            turned = np.einsum("ab,bcd,ci,dj->aij", Q, H, W, W)
            out = np.empty(5)
            args = [np.ascontiguousarray(each) for each in (Q @ J @ W, Q @ xdot, turned)]
            assert velocity_8(*args, parameters, np.ones(lay.memory_size(4, 5)) * 0, out)
            found.append(W @ out)
        gamma, speed, acceleration, horizon, _, dt = parameters
        rows = weak_rows(J, xdot, H, gamma)
        f = quartic(rows, speed, acceleration, horizon, dt)
        costs = [f.value(rows.kernel.T @ (qdot - rows.kept)) for qdot in found]
        assert np.abs(found[1] - found[0]).max() < 1e-6 or abs(costs[1] - costs[0]) < 1e-6 * (1e-3 + rows.speed**2)
