"""A compiled step is what kinematics and inverse give one after the other; nothing wrong passes it."""

import gc
import pickle
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.inverses.second_order.numpy_step import Remembered, numpy_step
from robust_ik.kinematics.twist_rows import ROWS
from tests import pinocchio_reference
from tests.cases_filters import CASES
from tests.cases_others import OTHER_CASES

ROBOTS = ["panda", "ur5", "pa10", "xarm7", "kinova", "tiago", "talos_arm", "duleba_3r", "z1", "planar_3r"]


@dataclass(frozen=True)
class Halving(rik.SingularValueFilter):
    """A user's own filter, in Python."""

    def gains(self, s):
        return 0.5 * np.asarray(s) / (np.asarray(s) ** 2 + 0.01)

    def largest_gain(self, sigma_max):
        return 2.5

    def is_exact(self, s):
        return np.zeros(np.shape(s), dtype=bool)


@dataclass(frozen=True)
class Cubic(GainFormula):
    """A user's own formula."""

    width: float = 0.3

    @staticmethod
    def formula(s, largest, smallest, product, place, p):
        return rik.inverses.where(s < p[0], s**2 / p[0] ** 3, 1.0 / rik.inverses.where(s > 0, s, 1.0))

    @property
    def parameters(self):
        return (self.width,)

    def largest_gain(self, sigma_max):
        return 1 / self.width

    def is_exact(self, s):
        return np.asarray(s) >= self.width


def reference_step(robot, inverse, q, twist, rows=None, secondary=None):
    """By Pinocchio and NumPy."""
    J = pinocchio_reference.jacobian(robot, q, robot.tip, "local_world_aligned")
    J = J[[ROWS.index(row) for row in (rows or robot.rows)]]
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    qdot = Vt.T @ (inverse.gains(s) * (U.T @ twist))
    return qdot if secondary is None else qdot + secondary - Vt.T @ (Vt @ secondary)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_step_is_pinocchios_jacobian_and_numpys_decomposition(name, rng):
    robot = rik.load(name)
    for inverse in [rik.DampedLeastSquares(), rik.JParse(), rik.DampedLeastSquares(1e-7), Halving()]:
        stepper = rik.Stepper(robot, inverse)
        for q in robot.random(rng, 5):
            twist = rng.normal(size=len(robot.rows))
            expected = reference_step(robot, inverse, q, twist)
            assert_allclose(stepper.step(q, twist), expected, atol=1e-9 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize("inverse", [*CASES, Halving(), Cubic()], ids=repr)
def test_every_filter_is_compiled_or_says_that_it_is_not(inverse, rng):
    robot = rik.load("panda")
    stepper = rik.Stepper(robot, inverse)
    assert stepper.compiled == (not isinstance(inverse, Halving) and not inverse.needs_hessian)
    q, twists = robot.random(rng, 21), rng.normal(size=(21, 6))
    if not inverse.needs_hessian:
        expected = inverse.solve(robot.jacobian(q), twists)
        assert_allclose(stepper.steps(q, twists), expected, atol=1e-10 * (1 + np.abs(expected).max()))
    for index in (0, 8, 20):
        one = stepper.step(q[index], twists[index])
        assert_allclose(one, stepper.steps(q, twists)[index], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("inverse", OTHER_CASES, ids=repr)
def test_any_other_inverse_is_asked_in_python(inverse, rng):
    robot = rik.load("ur5")
    stepper = rik.Stepper(robot, inverse)
    q, twist = robot.random(rng), rng.normal(size=6)
    assert not stepper.compiled or isinstance(inverse, (rik.Weighted, rik.SecondOrder))
    if not inverse.needs_hessian and not (isinstance(inverse, rik.Weighted) and inverse.inverse.needs_hessian):
        expected = inverse.solve(robot.jacobian(q), twist)
        assert_allclose(stepper.step(q, twist), expected, rtol=1e-9, atol=1e-12)


def test_batches_single_steps_and_threads_agree_bit_for_bit(rng):
    robot = rik.load("panda")
    for inverse in (rik.DampedLeastSquares(), rik.JParse(), rik.DampedLeastSquares(1e-6), rik.NakamuraHanafusa()):
        stepper = rik.Stepper(robot, inverse)
        q, twists = robot.random(rng, 203), rng.normal(size=(203, 6))
        many = stepper.steps(q, twists)
        assert (many == [stepper.step(*pair) for pair in zip(q, twists)]).all()
        assert (many == stepper.steps(q, twists, threads=3)).all()
        assert (many[57:] == stepper.steps(q[57:], twists[57:])).all()
        with ThreadPoolExecutor(4) as pool:
            assert (many == list(pool.map(stepper.step, q, twists))).all()


def test_where_the_damping_is_too_small_for_squares_no_digit_is_lost():
    robot = rik.load("ur5")
    q = np.zeros(6)  # singular
    twist = np.array([0.1, -0.2, 0.3, 0.4, 0.5, -0.6])
    for damping in (1e-3, 1e-5, 1e-9):
        inverse = rik.DampedLeastSquares(damping)
        expected = inverse.solve(robot.jacobian(q), twist)
        assert_allclose(rik.Stepper(robot, inverse).step(q, twist), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(
    "inverse", [rik.DampedLeastSquares(), rik.JParse(), Halving(), rik.SDLS(), rik.SecondOrder()], ids=repr
)
@pytest.mark.parametrize("name", ["panda", "ur5", "xarm7"])
def test_what_is_wanted_beside_the_task_moves_it_nowhere(name, inverse, rng):
    robot = rik.load(name)
    stepper = rik.Stepper(robot, inverse)
    for q in robot.random(rng, 4):
        twist, wish = rng.normal(size=6), rng.normal(size=robot.n)
        J = robot.jacobian(q)
        more = stepper.step(q, twist, secondary=wish) - stepper.step(q, twist)
        assert_allclose(more, rik.null_projector(J) @ wish, atol=1e-9)
        assert_allclose(J @ more, 0, atol=1e-10)


def test_at_a_singularity_the_wish_keeps_off_the_singular_direction(rng):
    robot = rik.load("panda")
    q = robot.neutral
    J, wish = robot.jacobian(q), rng.normal(size=7)
    more = rik.Stepper(robot, rik.JParse()).step(q, np.zeros(6), secondary=wish)
    assert_allclose(J @ more, 0, atol=1e-12)
    assert np.linalg.norm(more) <= np.linalg.norm(wish)


@pytest.mark.parametrize("inner", [rik.DampedLeastSquares(), rik.JParse(), Halving(), rik.SDLS()], ids=repr)
def test_weights_are_those_of_weighted(inner, rng):
    robot = rik.load("panda")
    A, B = rng.normal(size=(7, 7)), rng.normal(size=(6, 6))
    weights = [
        rik.Weighted(inner, joint_weights=rng.uniform(0.1, 3, 7), length_scale=0.4),
        rik.Weighted(inner, joint_weights=A @ A.T + np.eye(7), task_weights=B @ B.T + np.eye(6)),
        rik.Weighted(inner, task_weights=rng.uniform(0.1, 3, 6)),
    ]
    for inverse in weights:
        stepper = rik.Stepper(robot, inverse)
        q, twists, wish = robot.random(rng, 11), rng.normal(size=(11, 6)), rng.normal(size=(11, 7))
        J = robot.jacobian(q)
        assert_allclose(stepper.steps(q, twists), inverse.solve(J, twists), rtol=1e-8, atol=1e-10)
        both = stepper.steps(q, twists, secondary=wish)
        assert_allclose(J @ (both - stepper.steps(q, twists))[..., None], 0, atol=1e-9)
        # What is in the null space already is a wish that is granted whole.
        granted = (both - stepper.steps(q, twists))[0]
        assert_allclose(stepper.step(q[0], 0 * twists[0], secondary=granted), granted, atol=1e-9)


def test_rows_frames_and_references_are_the_robots(rng):
    robot = rik.load("panda")
    q, inverse = robot.random(rng), rik.JParse()
    for rows in [("x", "y", "z"), ("z", "wx"), ("wy",)]:
        twist = rng.normal(size=len(rows))
        expected = inverse.solve(robot.jacobian(q, rows=rows), twist)
        assert_allclose(rik.Stepper(robot, inverse, rows=rows).step(q, twist), expected, atol=1e-12)
        expected = inverse.solve(robot.with_rows(rows).jacobian(q), twist)
        assert_allclose(rik.Stepper(robot.with_rows(rows), inverse).step(q, twist), expected, atol=1e-12)
    twist = rng.normal(size=6)
    for reference in ("local", "world"):
        expected = inverse.solve(robot.jacobian(q, reference=reference), twist)
        assert_allclose(rik.Stepper(robot, inverse, reference=reference).step(q, twist), expected, atol=1e-11)
    expected = inverse.solve(robot.jacobian(q, "panda_link4"), twist)
    assert_allclose(rik.Stepper(robot, inverse, frame="panda_link4").step(q, twist), expected, atol=1e-11)


def test_a_zero_jacobian_and_a_short_arm_get_finite_motion(rng):
    robot = rik.load("panda")
    assert (rik.Stepper(robot, rik.JParse(), frame="panda_link0").step(robot.rest, np.ones(6)) == 0).all()
    short = rik.load("duleba_3r").with_rows(ROWS)
    for inverse in (rik.NakamuraHanafusa(), rik.Chiaverini(), rik.DampedLeastSquares(1e-9), rik.MoorePenrose()):
        q, twist = short.random(rng), rng.normal(size=6)
        expected = inverse.solve(short.jacobian(q), twist)
        assert_allclose(rik.Stepper(short, inverse).step(q, twist), expected, rtol=1e-7, atol=1e-9)


def test_a_step_with_out_allocates_nothing_and_returns_it(rng):
    robot = rik.load("panda")
    stepper, out = rik.Stepper(robot, rik.JParse()), np.empty(7)
    q, twist = robot.random(rng), rng.normal(size=6)
    assert stepper.step(q, twist, out) is out
    gc.disable()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()
    for _ in range(100):
        stepper.step(q, twist, out)
    after = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    gc.enable()
    assert after[0] - before[0] < 512
    assert after[1] - before[0] < 4096


@pytest.mark.parametrize("inverse", [rik.JParse(), Halving(), rik.SDLS(), rik.SecondOrder()], ids=repr)
def test_what_is_no_contiguous_double_is_converted(inverse, rng):
    robot = rik.load("ur5")
    stepper = rik.Stepper(robot, inverse)
    q, twist = robot.random(rng), rng.normal(size=6)
    expected = stepper.step(q, twist)
    locked = q.copy()
    locked.setflags(write=False)
    for other in (list(q), np.repeat(q, 2)[::2], locked, tuple(q)):
        assert_allclose(stepper.step(other, list(twist)), expected, atol=1e-15)
    single = stepper.step(q.astype(np.float32), twist.astype(np.float32))
    assert_allclose(single, expected, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(
    "inverse", [rik.DampedLeastSquares(), rik.JParse(), Halving(), rik.SDLS(), rik.SecondOrder()], ids=repr
)
def test_what_is_wrong_is_refused_and_named(inverse):
    robot = rik.load("ur5")
    stepper = rik.Stepper(robot, inverse)
    q, twist = np.zeros(6), np.ones(6)
    nan = np.array([0, 0, np.nan, 0, 0, 0])
    for wrong, match in [
        (lambda: stepper.step(nan, twist), "q must be finite"),
        (lambda: stepper.step(q, nan), "twist must be finite"),
        (lambda: stepper.step(q, nan + np.inf), "twist must be finite"),
        (lambda: stepper.step(q, twist, secondary=nan), "secondary must be finite"),
        (lambda: stepper.step(q[:5], twist), r"q must have shape \(..., 6\)"),
        (lambda: stepper.step(np.zeros(7), twist), r"q must have shape \(..., 6\)"),
        (lambda: stepper.step(q, twist[:3]), r"twist must have shape \(..., 6\)"),
        (lambda: stepper.step(q, twist, secondary=np.zeros(5)), "secondary must have shape"),
        (lambda: stepper.step(q, twist, np.zeros(5)), "out must be"),
        (lambda: stepper.step(q, twist, np.zeros(6, dtype=np.float32)), "out must be"),
        (lambda: stepper.step(q, twist, np.zeros(12)[::2]), "out must be"),
        (lambda: stepper.step(q, twist, [0.0] * 6), "out must be"),
        (lambda: stepper.step(q, twist, np.broadcast_to(0.0, 6)), "out must be"),
        (lambda: stepper.step(q, twist, np.frombuffer(bytearray(49), offset=1)), "out must be"),
        (lambda: stepper.step(q, twist, secondary=q.astype(complex)), "secondary must be an array of real numbers"),
        (lambda: stepper.step(q, twist, secondary=q.astype(object)), "secondary must be an array of real numbers"),
        (lambda: stepper.step(q, twist, secondary=np.ma.array(q)), "secondary must be an array of real numbers"),
        (lambda: stepper.step("six", twist), "q must be an array of real numbers"),
        (lambda: stepper.step(q + 1j, twist), "q must be an array of real numbers"),
        (lambda: stepper.step(np.zeros((2, 6)), twist), "step takes one q"),
        (lambda: stepper.steps(q, twist), "are needed, got"),
        (lambda: stepper.steps(np.zeros((3, 6)), np.ones((2, 6))), "are needed, got"),
        (lambda: stepper.steps(np.zeros((3, 6)), np.ones((3, 6)), threads=0), "threads must be"),
        (lambda: stepper.steps(np.zeros((3, 6)), np.ones((3, 6)), secondary=np.ones((2, 6))), "secondary must have"),
        (lambda: stepper.steps(np.zeros((3, 6)), np.full((3, 6), np.nan)), "twists must be finite"),
    ]:
        with pytest.raises(rik.InputError, match=match):
            wrong()


def test_cosines_and_sines_off_the_circle_are_refused():
    robot = rik.load("kinova")
    stepper, q = rik.Stepper(robot), robot.neutral
    q[0] = 1.5
    with pytest.raises(rik.InputError, match="must have length 1"):
        stepper.step(q, np.ones(6))


def test_what_is_no_inverse_reference_row_or_frame_is_refused():
    robot = rik.load("ur5")
    with pytest.raises(rik.InputError, match="must be a RobustInverse"):
        rik.Stepper(robot, "JParse")
    with pytest.raises(rik.InputError, match="reference must be one of"):
        rik.Stepper(robot, reference="tool")
    with pytest.raises(rik.InputError, match="rows"):
        rik.Stepper(robot, rows=("x", "q"))
    with pytest.raises(rik.FrameNotFoundError):
        rik.Stepper(robot, frame="toool0")


def test_a_formula_that_cannot_be_compiled_stays_python_with_a_word(rng):
    @dataclass(frozen=True)
    class Strange(Cubic):
        @staticmethod
        def formula(s, largest, smallest, product, place, p):
            return s * float(str(len({"a": 1}))) * np.array([p[0]]).item()

    robot = rik.load("ur5")
    with pytest.warns(UserWarning, match="stays Python"):
        stepper = rik.Stepper(robot, Strange())
    q, twist = robot.random(rng), rng.normal(size=6)
    assert not stepper.compiled
    assert_allclose(stepper.step(q, twist), Strange().solve(robot.jacobian(q), twist), atol=1e-12)


def test_velocities_beyond_all_numbers_are_refused():
    robot = rik.load("ur5")
    with pytest.raises(rik.InputError, match="too large"):
        rik.Stepper(robot, rik.JParse(gain=1e90)).step(np.zeros(6), np.full(6, 1e300))


def test_steppers_survive_pickling(rng):
    stepper = rik.Stepper(
        rik.load("panda"), rik.Weighted(rik.JParse(), length_scale=0.3), rows=("x", "y", "z", "wx", "wy", "wz")
    )
    again = pickle.loads(pickle.dumps(stepper))
    q, twist = stepper.robot.random(rng), rng.normal(size=6)
    assert (again.step(q, twist) == stepper.step(q, twist)).all()


def test_one_configuration_off_the_circle_among_many_is_refused(rng):
    robot = rik.load("kinova")
    q = robot.random(rng, 50)
    q[33, 0] = 1.5
    for inverse in (rik.DampedLeastSquares(), Halving(), rik.SDLS(), rik.SecondOrder()):
        with pytest.raises(rik.InputError, match="must have length 1"):
            rik.Stepper(robot, inverse).steps(q, np.ones((50, 6)), threads=2)


def test_rows_come_in_any_order(rng):
    robot = rik.load("panda")
    q = robot.random(rng, 9)
    for rows in [("wz", "x"), ("z", "y", "x"), ("wx", "z", "wz", "y", "x", "wy"), ("wz", "wy", "wx", "z", "y")]:
        twists = rng.normal(size=(9, len(rows)))
        for inverse in (rik.DampedLeastSquares(), rik.JParse(), Halving(), rik.SDLS()):
            stepper = rik.Stepper(robot, inverse, rows=rows)
            expected = inverse.solve(robot.jacobian(q, rows=rows), twists)
            assert_allclose(stepper.steps(q, twists), expected, atol=1e-9 * (1 + np.abs(expected).max()))
            assert_allclose(stepper.step(q[0], twists[0]), expected[0], atol=1e-9 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize("name, values", [
    ("planar_3r", [-np.pi, 0, 0]), ("planar_3r", [0, 0, 0]), ("puma560", [0] * 6), ("puma560", [0.3, 0, 0.1, 0, 0, 0]),
    ("pa10", [0] * 7), ("srs_7r", [0] * 7), ("ur5", [0] * 6), ("ur10", [0] * 6),
])  # fmt: skip
def test_what_is_wanted_beside_the_task_moves_it_nowhere_at_singularities_too(name, values, rng):
    whole = rik.load(name)
    for robot in (whole, whole.with_rows(whole.rows[:3])):
        q = robot.configuration(values)
        J = robot.jacobian(q)
        for inverse in (rik.DampedLeastSquares(), rik.JParse(), rik.MoorePenrose(), Halving()):
            stepper = rik.Stepper(robot, inverse)
            for wish in rng.normal(size=(4, robot.n)):
                done = stepper.step(q, np.zeros(len(robot.rows)), secondary=wish)
                assert_allclose(J @ done, 0, atol=1e-12)
                assert np.linalg.norm(done) <= np.linalg.norm(wish) * (1 + 1e-12)


@pytest.mark.parametrize("inverse", [rik.EDLS(), rik.DulebaClamp(), rik.JParse(), rik.DampedLeastSquares()], ids=repr)
def test_at_singularities_a_step_is_what_the_inverse_gives(inverse):
    robot = rik.load("ur10")
    J = robot.jacobian(robot.neutral)
    for twist in rik.svd(J).U.T[:5]:  # along what is lost, only the size is told: the direction is any of the kernel's
        step, solved = rik.Stepper(robot, inverse).step(robot.neutral, twist), inverse.solve(J, twist)
        assert_allclose(J @ step, J @ solved, atol=1e-9)
    lost = rik.svd(J).U[:, 5]
    sizes = [
        np.linalg.norm(each) for each in (rik.Stepper(robot, inverse).step(robot.neutral, lost), inverse.solve(J, lost))
    ]
    assert max(sizes) <= inverse.largest_gain(rik.svd(J).s[0]) * (1 + 1e-9)


def test_weights_of_any_size_are_right(rng):
    robot = rik.load("panda")
    q, twist = robot.random(rng), rng.normal(size=6)
    for inner in (rik.MoorePenrose(), rik.DampedLeastSquares(), rik.JParse()):
        for weights in ([1e78] * 6, [1e-78] * 6, [1e12] * 3 + [1.0] * 3, [1e17] * 3 + [1.0] * 3, [1e40] + [1.0] * 5):
            inverse = rik.Weighted(inner, task_weights=weights)
            expected = inverse.solve(robot.jacobian(q), twist)
            assert_allclose(rik.Stepper(robot, inverse).step(q, twist), expected, rtol=1e-6, atol=1e-9)


def test_out_may_lie_over_what_is_given(rng):
    robot = rik.load("panda")
    stepper, room = rik.Stepper(robot, rik.JParse()), np.empty(7 * 40)
    q, twists = robot.random(rng, 40), rng.normal(size=(40, 6))
    expected = stepper.steps(q, twists)
    over_twists = room[:240].reshape(40, 6)
    over_twists[:] = twists
    assert (stepper.steps(q, over_twists, room.reshape(40, 7)) == expected).all()
    over_q = q.copy()
    assert (stepper.steps(over_q, twists, over_q) == expected).all()
    one = q[3].copy()
    assert (stepper.step(one, twists[3], one) == expected[3]).all()


def in_numpy(inverse, J, twist, hessian):
    """The first step of a run of the second-order inverse, by its reference."""
    return numpy_step(inverse.parameters(0.0), J, twist, hessian, Remembered(np.zeros(J.shape[1]))).last


def near_singularities(robot, rng, count):
    """Configurations, the first half of which have weak singular values if the robot has such in any number."""
    q = robot.random(rng, 40 * count)
    s = rik.svd(robot.jacobian(q)).s
    weak, others = np.flatnonzero(s[:, -1] < 0.15 * s[:, 0])[: count // 2], np.arange(count)
    return np.concatenate([q[weak], q[others[: count - len(weak)]]])


@pytest.mark.parametrize("name", ROBOTS)
def test_second_order_steps_are_compiled_and_those_of_numpy(name, rng):
    robot, inverse = rik.load(name), rik.SecondOrder(gamma=0.15)
    stepper, m = rik.Stepper(robot, inverse), len(robot.rows)
    assert stepper.compiled
    q, twists = near_singularities(robot, rng, 40), 0.3 * rng.normal(size=(40, m))
    expected = [in_numpy(inverse, *each) for each in zip(robot.jacobian(q), twists, robot.hessian(q))]
    many = stepper.steps(q, twists)
    assert_allclose(many, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    assert (many == [stepper.step(*each) for each in zip(q, twists)]).all()
    assert (many == stepper.steps(q, twists, threads=3)).all()


def test_second_order_steps_have_rows_references_frames_and_weights(rng):
    robot, inverse = rik.load("panda"), rik.SecondOrder(gamma=0.3)
    q, A, B = robot.random(rng, 12), rng.normal(size=(7, 7)), rng.normal(size=(3, 3))
    for reference in ("local_world_aligned", "local", "world"):
        stepper = rik.Stepper(robot, inverse, reference=reference, frame="panda_link7")
        for each in q:
            twist = 0.3 * rng.normal(size=6)
            J, H = (of(each, "panda_link7", reference=reference) for of in (robot.jacobian, robot.hessian))
            assert_allclose(stepper.step(each, twist), in_numpy(inverse, J, twist, H), atol=1e-8)
    rows = ("wz", "x", "wy")
    weighted = rik.Weighted(inverse, joint_weights=A @ A.T + np.eye(7), task_weights=B @ B.T + np.eye(3))
    stepper, places = rik.Stepper(robot, weighted, rows=rows), [ROWS.index(row) for row in rows]
    assert stepper.compiled
    task, joint = weighted.factors(3, 7)
    for each in q:
        twist, wish = 0.3 * rng.normal(size=3), rng.normal(size=7)
        J, H = task @ robot.jacobian(each)[places] @ joint, robot.hessian(each)[places]
        H = np.einsum("ab,bcd,ci,dj->aij", task, H, joint, joint)
        assert_allclose(stepper.step(each, twist), joint @ in_numpy(inverse, J, task @ twist, H), atol=1e-8)
        more = stepper.step(each, twist, secondary=wish) - stepper.step(each, twist)
        assert_allclose(more, joint @ rik.null_projector(J) @ np.linalg.solve(joint, wish), atol=1e-9)


def test_a_second_order_step_asks_no_python(monkeypatch, rng):
    robot = rik.load("ur5")
    stepper, q = rik.Stepper(robot, rik.SecondOrder()), np.zeros(6)
    expected = stepper.step(q, np.ones(6))
    monkeypatch.setattr(rik.SecondOrder, "velocity", lambda *_: pytest.fail("asked"))
    monkeypatch.setattr(rik.SecondOrder, "solve", lambda *_: pytest.fail("asked"))
    assert (stepper.step(q, np.ones(6)) == expected).all()
    assert (stepper.steps(q[None], np.ones((1, 6))) == expected).all()


def test_second_order_steps_of_robots_too_large_for_kernels_and_without_motion(rng):
    robot = rik.load("panda")
    stepper = rik.Stepper(robot, rik.SecondOrder(), frame="panda_link0")
    wish = rng.normal(size=7)
    assert (stepper.step(robot.rest, np.ones(6)) == 0).all()
    assert_allclose(stepper.step(robot.rest, np.ones(6), secondary=wish), wish)
    tree = rik.load("talos", whole_tree=True)
    stepper = rik.Stepper(tree, rik.SecondOrder(), frame="gripper_left_base_link")
    assert not stepper.compiled
    q, twists = tree.random(rng, 3), rng.normal(size=(3, 6))
    assert_allclose(stepper.steps(q, twists), [stepper.step(*each) for each in zip(q, twists)], atol=1e-9)
