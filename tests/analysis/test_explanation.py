"""An explanation adds up, calls things by their right name, and can be read."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik import InputError
from robust_ik.analysis.explanation import Branch, explain, unavoidable_angle
from robust_ik.inverses import DampedLeastSquares, JParse, MoorePenrose, RobustInverse, SingularValueFilter
from tests.kinematics.test_svd import SHAPES, matrix

SPECTRA = [
    lambda k: np.linspace(2, 1, k),
    lambda k: np.concatenate([np.linspace(2, 1, k - 1), [0.0]]),
    lambda k: np.concatenate([np.linspace(2, 1, k - 1), [1e-7]]),
    lambda k: np.concatenate([[1.5], np.zeros(k - 1)]),
    lambda k: np.full(k, 0.7),
    lambda k: np.concatenate([[3.0], np.full(k - 1, 0.05)]),
    lambda k: 10.0 ** -np.arange(k),
    lambda k: 1e40 * np.linspace(2, 1, k),
    lambda k: 1e-40 * np.linspace(2, 1, k),
]


@dataclass(frozen=True)
class Weighted(RobustInverse):
    """No filter: the pseudo-inverse that spares the first joint."""

    def solve(self, J, xdot):
        J = np.asarray(J)
        root = np.diag(np.concatenate([[0.2], np.ones(J.shape[-1] - 1)]))
        return root @ np.linalg.pinv(J @ root, rcond=1e-10) @ xdot


@dataclass(frozen=True)
class Backwards(SingularValueFilter):
    """φ(σ) = −1/σ for the smallest σ of two, as the raw formula of EDLS can be."""

    def gains(self, s):
        return np.array([1.0, -1.0]) / s

    def largest_gain(self, sigma_max):
        return np.inf

    def is_exact(self, s):
        return np.array([True, False])


INVERSES = [JParse(), JParse(0.3, 2.0), DampedLeastSquares(), MoorePenrose(), Weighted()]
all_inverses = pytest.mark.parametrize("inverse", INVERSES, ids=repr)


def scaled(rng):
    """Jacobians of every shape and spectrum with a task velocity of a fitting size."""
    for (m, n), spectrum in itertools.product(SHAPES, SPECTRA):
        yield matrix(spectrum(min(m, n)), m, n, rng), rng.normal(size=m) * rng.choice([1e-6, 1.0, 1e6])


# ------------------------------------------------------------------------------------------------ it adds up
@all_inverses
def test_the_directions_add_up_to_what_is_asked_and_given(inverse, rng):
    for J, xdot in scaled(rng):
        e = explain(J, xdot, inverse)
        m, n = J.shape
        U, V = np.array([d.u for d in e.directions]).T, np.array([d.v for d in e.directions]).T
        asked, given = np.array([(d.asked, d.given) for d in e.directions]).T
        size, reached = np.linalg.norm(xdot), np.linalg.norm(J, 2) * np.linalg.norm(e.qdot)
        assert U.shape == (m, m)
        assert V.shape == (n, m)
        assert_allclose(U.T @ U, np.eye(m), atol=1e-12)
        assert_allclose(U @ asked, xdot, atol=1e-12 * size)
        assert_allclose(U @ given, J @ e.qdot, atol=1e-12 * (size + reached))
        assert_allclose(e.residual, xdot - J @ inverse.solve(J, xdot), atol=1e-12 * (size + reached))
        assert (asked >= 0).all()
        assert (np.diff([d.sigma for d in e.directions]) <= 0).all()
        assert_allclose(sum(d.share for d in e.directions) + e.null_share, 1 if e.qdot.any() else 0, atol=1e-9)
        for d in e.directions:
            assert_allclose(J @ d.v, d.sigma * d.u, atol=1e-12 * np.linalg.norm(J))
            assert_allclose(d.speed, d.v @ e.qdot, atol=1e-12 * np.linalg.norm(e.qdot))


@all_inverses
def test_for_a_filter_the_fraction_is_sigma_phi_and_for_others_given_over_asked(inverse, rng):
    for J, xdot in scaled(rng):
        for d in explain(J, xdot, inverse).directions[: min(J.shape)]:
            if isinstance(inverse, SingularValueFilter):
                assert_allclose(d.fraction, d.sigma * d.gain, atol=1e-12)
            else:
                assert d.gain is None
            if d.branch not in (Branch.LOST, Branch.UNASKED) and d.asked > 1e-3 * np.linalg.norm(xdot):
                assert_allclose(d.given, d.fraction * d.asked, rtol=1e-6, atol=1e-9 * np.linalg.norm(xdot))
                assert d.lost == 1 - d.fraction


@all_inverses
def test_overall_angle_loss_and_largest_speed(inverse, rng):
    J, xdot = rng.normal(size=(3, 5)) * 0.1, rng.normal(size=3)
    e = explain(J, xdot, inverse)
    qdot = inverse.solve(J, xdot)
    given = J @ qdot
    assert_allclose(e.given, given, atol=1e-12)
    assert_allclose(np.cos(e.angle), xdot @ given / np.linalg.norm(xdot) / np.linalg.norm(given))
    assert_allclose(e.speed_lost, 1 - xdot @ given / (xdot @ xdot), atol=1e-12)
    assert e.largest_speed == np.abs(qdot).max() == abs(qdot[e.fastest_joint])
    if isinstance(inverse, SingularValueFilter):
        assert_allclose(e.speed_lost, sum(d.lost * d.asked**2 for d in e.directions) / (xdot @ xdot), atol=1e-12)


def test_the_angle_is_right_also_where_it_is_tiny():
    e = explain(np.eye(2), [1.0, 0.0], MoorePenrose(), qdot=[1.0, 1e-9])
    assert_allclose(e.angle, 1e-9, rtol=1e-6)


# ------------------------------------------------------------------------------------------------ by its right name
def branches(J, inverse, xdot=None):
    return [d.branch for d in explain(J, np.ones(len(J)) if xdot is None else xdot, inverse).directions]


def test_every_direction_is_called_by_what_becomes_of_it():
    J = np.diag([1, 0.05, 0])
    assert branches(J, JParse()) == [Branch.EXACT, Branch.DAMPED, Branch.LOST]
    assert branches(J, MoorePenrose()) == [Branch.EXACT, Branch.EXACT, Branch.LOST]
    assert branches(J, MoorePenrose(tolerance=0.1)) == [Branch.EXACT, Branch.CUT, Branch.LOST]
    assert branches(J, DampedLeastSquares(0.1)) == [Branch.DAMPED, Branch.DAMPED, Branch.LOST]
    assert branches(np.diag([1, 0.08]), JParse(gain=2.0)) == [Branch.EXACT, Branch.AMPLIFIED]
    assert branches(np.diag([1, 0.5]), Backwards()) == [Branch.EXACT, Branch.REVERSED]


def test_what_is_not_asked_is_known_of_a_filter_only():
    J, xdot = np.diag([1, 0.05]), [1.0, 0.0]
    assert branches(J, JParse(), xdot) == [Branch.EXACT, Branch.DAMPED]
    assert branches(J, Weighted(), xdot) == [Branch.EXACT, Branch.UNASKED]
    assert branches(J, Weighted(), np.array([1.0, 1e-12])) == [Branch.EXACT, Branch.UNASKED]
    unasked = explain(J, xdot, Weighted()).directions[1]
    assert unasked.fraction is None
    assert unasked.lost is None


@all_inverses
def test_rows_that_no_joint_moves_are_lost_too(inverse, rng):
    J = matrix([2.0, 1.0], 5, 2, rng)
    e = explain(J, rng.normal(size=5), inverse)
    assert [d.branch for d in e.directions[2:]] == [Branch.LOST] * 3
    assert e.corank == 3
    assert_allclose(e.lost_directions.T @ J, 0, atol=1e-12)
    assert all(d.sigma == d.given == d.speed == 0 and not d.v.any() for d in e.directions[2:])
    assert e.smallest_sigma == pytest.approx(1)
    assert e.condition_number == pytest.approx(2)
    assert e.manipulability == pytest.approx(2)


@all_inverses
def test_nothing_asked_is_nothing_lost(inverse):
    e = explain(np.diag([1, 0.5]), [0.0, 0.0], inverse)
    assert e.speed_lost == e.angle == e.unavoidable_angle == e.largest_speed == e.null_share == 0
    assert "0.0% of the asked speed is lost" in str(e)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_zero_jacobian_loses_everything(shape):
    e = explain(np.zeros(shape), np.ones(shape[0]), JParse())
    assert {d.branch for d in e.directions} == {Branch.LOST}
    assert e.corank == shape[0]
    assert e.speed_lost == 1
    assert_allclose([e.angle, e.unavoidable_angle], np.pi / 2)
    assert e.condition_number == np.inf
    assert e.manipulability == e.smallest_sigma == e.null_share == 0
    assert "lost" in str(e)


def test_a_threshold_says_what_is_singular_but_not_what_is_lost():
    e = explain(np.diag([1, 0.05]), [1.0, 1.0], MoorePenrose(), threshold=0.1)
    assert [d.singular for d in e.directions] == [False, True]
    assert [d.branch for d in e.directions] == [Branch.EXACT, Branch.EXACT]
    assert e.corank == 1
    assert_allclose(e.unavoidable_angle, np.pi / 4)
    assert explain(np.diag([1, 0.05]), [1.0, 1.0], MoorePenrose(), threshold=0.0).corank == 0
    at_it = explain(np.diag([1, 0.5]), [1.0, 1.0], MoorePenrose(), threshold=0.5)
    assert at_it.corank == at_it.directions[1].singular == 1


def test_known_joint_velocities_are_explained_instead_of_the_inverses_own():
    J, xdot = np.array([[1.0, 0, 0], [0, 0.5, 0]]), np.array([1.0, 1.0])
    e = explain(J, xdot, MoorePenrose(), qdot=[1.0, 1.0, 2.0])
    assert [d.fraction for d in e.directions] == [1.0, 0.5]
    assert [d.branch for d in e.directions] == [Branch.EXACT, Branch.DAMPED]
    assert [d.gain for d in e.directions] == [1.0, 2.0]
    assert_allclose(e.null_share, 4 / 6)
    assert e.fastest_joint == 2


# ------------------------------------------------------------------------------------------- what cannot be avoided
@all_inverses
def test_no_inverse_beats_the_unavoidable_error_and_the_pseudo_inverse_meets_it(inverse, rng):
    for J, xdot in scaled(rng):
        size = np.linalg.norm(xdot)
        floor = np.sin(unavoidable_angle(J, xdot)) * size
        e = explain(J, xdot, inverse)
        error, rounding = np.linalg.norm(e.residual), 1e-12 * size + 1e-14 * np.linalg.norm(J) * np.linalg.norm(e.qdot)
        assert error >= floor - rounding
        if inverse == MoorePenrose():
            assert_allclose(error, floor, atol=rounding)


def test_the_unavoidable_angle_is_the_one_to_the_complement_of_the_lost_directions(rng):
    for J, xdot in scaled(rng):
        lost = rik.lost_directions(J)
        assert_allclose(
            np.sin(unavoidable_angle(J, xdot)), np.linalg.norm(lost.T @ xdot) / np.linalg.norm(xdot), atol=1e-9
        )


def test_the_unavoidable_angle_runs_over_leading_axes(rng):
    J, xdot = rng.normal(size=(4, 1, 3, 2)), rng.normal(size=(5, 3))
    angles = unavoidable_angle(J, xdot)
    assert angles.shape == (4, 5)
    assert_allclose(angles[2, 3], unavoidable_angle(J[2, 0], xdot[3]))
    thresholds = np.array([0.0, 10.0])
    assert_allclose(unavoidable_angle(np.eye(2), [1.0, 0.0], thresholds), [0, np.pi / 2])


def test_dulebas_arm_on_its_axis_cannot_move_sideways():
    """000 section 6.4: where A = 0 the direction (s₁, −c₁, 0) is lost."""
    arm, q = rik.load("duleba_3r"), np.radians([300, 90.768, 81.566])
    J = arm.jacobian(q)
    sideways = [np.sin(q[0]), -np.cos(q[0]), 0]
    # The printed angles are rounded: σ₃ is 1e-6, not 0.
    assert_allclose(unavoidable_angle(J, sideways, 1e-4), np.pi / 2, atol=1e-4)
    assert_allclose(unavoidable_angle(J, [0.0, 0, 1], 1e-4), 0, atol=1e-4)
    e = explain(J, [0.0, 0, 1], JParse(), threshold=1e-4, rows=arm.rows)
    assert e.corank == 1
    assert abs(e.lost_directions[:, 0] @ sideways) == pytest.approx(1, abs=1e-6)


def test_the_smallest_sigma_is_the_distance_of_j_from_a_matrix_of_lower_rank(rng):
    for m, n in [(3, 3), (3, 6), (5, 2)]:
        J = matrix(np.linspace(1, 0.3, min(m, n)), m, n, rng)
        e = explain(J, np.ones(m), JParse())
        last = e.directions[min(m, n) - 1]
        step = e.smallest_sigma * np.outer(last.u, last.v)
        assert_allclose(np.linalg.norm(step, 2), 0.3)
        assert np.linalg.matrix_rank(J - step, tol=1e-9) == min(m, n) - 1
        for _ in range(20):
            nearer = rng.normal(size=(m, n))
            nearer *= 0.99 * 0.3 / np.linalg.norm(nearer, 2)
            assert np.linalg.matrix_rank(J - nearer, tol=1e-6) == min(m, n)


# ------------------------------------------------------------------------------------------------ it can be read
def test_the_table_reads_like_this():
    e = explain(np.diag([1, 0.05, 0]), [0.3, 0.4, 0.0], JParse(), rows=("x", "y", "z"))
    assert str(e).splitlines() == [
        "JParse(gamma=0.1, gain=1.0, exponent=1.0) on a 3×3 Jacobian of corank 1",
        "asked 0.5, given 0.3162, 34.7° apart: 48.0% of the asked speed is lost; 0.0° cannot be avoided",
        "largest joint speed 2 (q2); 0.0% of the motion is in the null space",
        "smallest σ 0 (distance of J from a singular matrix), condition number inf, manipulability 0; "
        "* marks σ ≤ 1e-12",
        "",
        "       σ  φ  asked  given    lost  what    speed  share  task direction  joint direction",
        "1      1  1    0.3    0.3    0.0%  exact     0.3   2.2%  +1.00 x         +1.00 q1",
        "2   0.05  5    0.4    0.1   75.0%  damped      2  97.8%  +1.00 y         +1.00 q2",
        "3*     0  0      0      0  100.0%  lost        0   0.0%  +1.00 z         +1.00 q3",
    ]


@all_inverses
def test_columns_are_aligned_for_every_shape_and_size(inverse, rng):
    for J, xdot in scaled(rng):
        e = explain(J, xdot, inverse)
        header, *lines = str(e).splitlines()[5:]
        assert len(lines) == J.shape[0]
        what, task = header.index("what"), header.index("task direction")
        for line, d in zip(lines, e.directions):
            assert line[what:].startswith(str(d.branch))
            assert line[what - 2 : what] == line[task - 2 : task] == "  "
            assert line[task] in "+−"
        assert "nan" not in str(e)


def test_rounding_is_not_shown_as_motion(rng):
    J = matrix([2.0, 1.0, 0.5], 3, 5, rng)
    u = np.linalg.svd(J)[0][:, 0]
    line = str(explain(J, u, MoorePenrose())).splitlines()[7]
    assert line.split()[3:5] == ["0", "0"]


def test_rows_are_named(rng):
    def words(m, rows=None):
        return explain(np.eye(m), np.ones(m), JParse(), rows=rows).rows

    assert words(6) == ("x", "y", "z", "wx", "wy", "wz")
    assert words(2) == ("1", "2")
    assert words(2, ["x", "z"]) == ("x", "z")


def test_arrays_cannot_be_written_to_and_inputs_are_left_alone():
    J, xdot = np.eye(2), np.ones(2)
    e = explain(J, xdot, JParse())
    J[0, 0] = xdot[0] = 7
    assert e.J[0, 0] == e.xdot[0] == 1
    for array in (e.J, e.xdot, e.qdot, e.lost_directions, e.directions[0].u, e.directions[0].v):
        assert not array.flags.writeable


@pytest.mark.parametrize(
    "arguments, options, match",
    [
        ((np.ones((2, 2, 2)), [1, 1]), {}, "takes one step, got J of shape"),
        ((np.eye(2), np.ones((3, 2))), {}, "takes one step, got xdot of shape"),
        ((np.eye(2), [1, 1, 1]), {}, "xdot must have shape"),
        ((np.eye(2), [1, np.nan]), {}, "xdot must be finite"),
        ((np.eye(2), [1, 1]), {"qdot": [1.0]}, "qdot must have shape"),
        ((np.eye(2), [1, 1]), {"threshold": -1.0}, "threshold must be ≥ 0"),
        ((np.eye(2), [1, 1]), {"rows": ("x",)}, "rows must name the 2 task rows"),
        ((np.zeros((0, 2)), []), {}, "at least one row"),
    ],
)
def test_what_cannot_be_meant_is_refused(arguments, options, match):
    with pytest.raises(InputError, match=match):
        explain(*arguments, JParse(), **options)
