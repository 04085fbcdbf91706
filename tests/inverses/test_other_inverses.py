"""What the inverses that are no plain filters promise beyond the contract."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.inverses import (
    ESRIM,
    SDLS,
    ChanLawrence,
    Chiaverini,
    ChiaveriniFiltering,
    DampedLeastSquares,
    DulebaAdditive,
    FilteredInverse,
    Halley,
    JParse,
    JParsePositionFirst,
    JParseWithGains,
    KelmarKhosla,
    MaciejewskiKlein,
    MoorePenrose,
    NakamuraHanafusa,
    RobustInverse,
    SmallestSingularValues,
    Sugihara,
    TrackingLoop,
    TruncatedSVD,
    UserDefinedAccuracy,
    Weighted,
)
from robust_ik.inverses.task_equation import TaskEquation
from tests.cases_others import OTHER_CASES
from tests.kinematics.test_svd import matrix

SHAPES = [(1, 1), (2, 2), (2, 5), (6, 6), (6, 7), (6, 3), (5, 1)]
seeds = st.integers(0, 2**32 - 1)


def orthogonal(rng, size):
    return np.linalg.qr(rng.normal(size=(size, size)))[0]


def positive_definite(rng, size):
    Q = orthogonal(rng, size)
    W = Q @ np.diag(rng.uniform(0.1, 5, size)) @ Q.T
    return (W + W.T) / 2


class Recorder(RobustInverse):
    """Keeps the equations that it is given."""

    source, card = "none 0000", MoorePenrose.card

    def __init__(self):
        self.equations = []

    def solve(self, J, xdot):
        return np.zeros(np.shape(J)[-1])

    def velocity(self, equation):
        self.equations.append(equation)
        return np.arange(1.0, equation.J.shape[-1] + 1)


# Duleba's additive damping


@pytest.mark.parametrize("variant", ["plain", "scaled", "floored"])
def test_duleba_additive_is_its_matrix_form(variant, rng):
    for m, n in SHAPES:
        J, xdot = rng.normal(size=(m, n)), rng.normal(size=m)
        lengths = np.sum(J**2, axis=1)
        f = {"plain": np.ones(m), "scaled": lengths, "floored": np.maximum(lengths, 2.0)}[variant]
        expected = J.T @ np.linalg.solve(J @ J.T + 0.03 * np.diag(f), xdot)
        assert_allclose(DulebaAdditive(0.03, variant, floor=2.0).solve(J, xdot), expected, atol=1e-10)


def test_duleba_adds_lambda_as_it_is_so_it_is_the_square_of_a_damping(rng):
    J, xdot = rng.normal(size=(3, 5)), rng.normal(size=3)
    plain = DulebaAdditive(squared_damping=0.04, variant="plain")
    assert_allclose(plain.solve(J, xdot), DampedLeastSquares(damping=0.2).solve(J, xdot), atol=1e-13)


@settings(deadline=None, max_examples=50)
@given(seeds, st.floats(-250, 250))
def test_only_duleba_scaled_does_not_mind_the_unit_of_a_row(seed, exponent):
    rng = np.random.default_rng(seed)
    J, xdot = rng.normal(size=(3, 4)), rng.normal(size=3)
    S = np.array([1.0, 10.0**exponent, 0.3])
    scaled = DulebaAdditive(variant="scaled")
    assert_allclose(scaled.solve(S[:, None] * J, S * xdot), scaled.solve(J, xdot), atol=1e-10)
    plain = DulebaAdditive(0.1, variant="plain")
    assert np.abs(plain.solve(10 * J, 10 * xdot) - plain.solve(J, xdot)).max() > 1e-6


@pytest.mark.parametrize("variant", ["plain", "scaled", "floored"])
def test_a_row_of_zeros_is_left_out_by_duleba(variant, rng):
    J, xdot = rng.normal(size=(3, 4)), rng.normal(size=3)
    J[1] = 0
    inverse = DulebaAdditive(variant=variant)
    assert_allclose(inverse.solve(J, xdot), inverse.solve(J[[0, 2]], xdot[[0, 2]]), atol=1e-13)


def test_duleba_scaled_has_no_largest_gain_and_floored_has():
    for t in (1e-3, 1e-6, 1e-9):
        speed = np.linalg.norm(DulebaAdditive(0.01, "scaled").solve([[1, 0], [0, t]], [0, 1]))
        assert_allclose(speed, 1 / (1.01 * t), rtol=1e-9)
    floored = DulebaAdditive(0.01, "floored", floor=0.04)
    worst = max(float(floored.solve([[t]], [1.0])[0]) for t in np.geomspace(1e-4, 1, 2001))
    assert_allclose(worst, floored.largest_gain(1.0), rtol=1e-5)
    assert_allclose(floored.largest_gain(1.0), 1 / (2 * 0.1 * 0.2), rtol=1e-12)


# Weights


@pytest.mark.parametrize("kind", ["vector", "matrix"])
def test_moore_penrose_with_joint_weights_is_the_weighted_pseudo_inverse(kind, rng):
    for _ in range(20):
        J, xdot = rng.normal(size=(3, 5)), rng.normal(size=3)
        weights = rng.uniform(0.1, 5, 5) if kind == "vector" else positive_definite(rng, 5)
        W = np.diag(weights) if kind == "vector" else weights
        qdot = Weighted(MoorePenrose(), joint_weights=weights).solve(J, xdot)
        inner = np.linalg.solve(W, J.T)
        assert_allclose(qdot, inner @ np.linalg.solve(J @ inner, xdot), atol=1e-10)
        assert_allclose(J @ qdot, xdot, atol=1e-10)
        other = qdot + rik.null_projector(J) @ rng.normal(size=5)
        assert other @ W @ other > qdot @ W @ qdot


def test_equal_joint_weights_change_nothing_and_a_heavy_joint_freezes(rng):
    J, xdot = rng.normal(size=(3, 5)), rng.normal(size=3)
    equal = Weighted(MoorePenrose(), joint_weights=[7.0] * 5)
    assert_allclose(equal.solve(J, xdot), np.linalg.pinv(J) @ xdot, atol=1e-12)
    frozen = Weighted(MoorePenrose(), joint_weights=[1, 1, 1e14, 1, 1]).solve(J, xdot)
    assert_allclose(frozen, np.insert(np.linalg.pinv(np.delete(J, 2, axis=1)) @ xdot, 2, 0.0), atol=1e-6)


def test_weighted_damped_least_squares_minimises_the_weighted_sum(rng):
    for m, n in SHAPES:
        J, xdot = rng.normal(size=(m, n)), rng.normal(size=m)
        Wq, Wx = positive_definite(rng, n), positive_definite(rng, m)
        qdot = Weighted(DampedLeastSquares(0.3), joint_weights=Wq, task_weights=Wx).solve(J, xdot)
        gradient = J.T @ Wx @ Wx @ (J @ qdot - xdot) + 0.09 * Wq @ qdot
        assert_allclose(gradient, 0, atol=1e-10)


def test_task_weights_change_nothing_where_the_inverse_is_exact(rng):
    J, xdot = rng.normal(size=(3, 5)), rng.normal(size=3)
    weighted = Weighted(MoorePenrose(), task_weights=[0.1, 1.0, 20.0])
    assert_allclose(weighted.solve(J, xdot), MoorePenrose().solve(J, xdot), atol=1e-11)


@pytest.mark.parametrize("inner", [JParse(), DampedLeastSquares(), Chiaverini(), SDLS()], ids=repr)
def test_with_a_length_scale_metres_and_millimetres_give_the_same(inner, rng):
    millimetres = np.array([1e3] * 3 + [1.0] * 3)
    for _ in range(10):
        J, xdot = matrix([1.5, 1, 0.5, 0.2, 0.05, 1e-4], 6, 7, rng), 0.1 * rng.normal(size=6)
        metres = Weighted(inner, length_scale=0.4).solve(J, xdot)
        assert_allclose(
            Weighted(inner, length_scale=400).solve(millimetres[:, None] * J, millimetres * xdot), metres, atol=1e-9
        )
        assert np.abs(Weighted(inner, length_scale=4).solve(J, xdot) - metres).max() > 1e-9


def test_a_length_scale_divides_the_linear_rows():
    weighted = Weighted(DampedLeastSquares(0.1), length_scale=0.5, linear_rows=1)
    expected = DampedLeastSquares(0.1).solve([[4, 0], [0, 3]], [2, 1])
    assert_allclose(weighted.solve([[2, 0], [0, 3]], [1, 1]), expected, atol=1e-14)


def test_weighted_passes_error_and_hessian_in_its_own_coordinates(rng):
    """With q = F q̃ and x̃ = W x: J̃(q̃) = W J(F q̃) F, whose derivative is the scaled Hessian."""
    m, n = 3, 4
    H, J0 = rng.normal(size=(m, n, n)), rng.normal(size=(m, n))
    Wq, Wx, recorder = positive_definite(rng, n), positive_definite(rng, m), Recorder()
    values, vectors = np.linalg.eigh(Wq)
    F = vectors @ np.diag(values**-0.5) @ vectors.T
    xdot, error = rng.normal(size=(2, m))
    qdot = Weighted(recorder, joint_weights=Wq, task_weights=Wx).velocity(TaskEquation(J0, xdot, error, H))
    (seen,) = recorder.equations
    assert_allclose(seen.J, Wx @ J0 @ F, atol=1e-12)
    assert_allclose(seen.xdot, Wx @ xdot, atol=1e-12)
    assert_allclose(seen.error, Wx @ error, atol=1e-12)
    for direction in np.eye(n):
        moved = Wx @ (J0 + H @ (F @ direction)) @ F
        assert_allclose(seen.hessian @ direction, moved - Wx @ J0 @ F, atol=1e-12)
    assert_allclose(qdot, F @ np.arange(1.0, n + 1), atol=1e-12)


def test_weighted_chan_lawrence_is_the_weighted_formula(rng):
    J, error = rng.normal(size=(6, 7)), rng.normal(size=6)
    We = positive_definite(rng, 6)
    values, vectors = np.linalg.eigh(We)
    root = vectors @ np.diag(np.sqrt(values)) @ vectors.T
    expected = np.linalg.solve(J.T @ We @ J + 0.7 * (error @ We @ error) / 2 * np.eye(7), J.T @ We @ error)
    assert_allclose(Weighted(ChanLawrence(0.7), task_weights=root).solve(J, error), expected, atol=1e-10)


def test_weighted_asks_for_the_hessian_and_remembers_when_what_it_wraps_does(rng):
    assert Weighted(Halley()).needs_hessian
    assert not Weighted(JParse()).needs_hessian
    inner, scale = KelmarKhosla(floor=0.05), np.array([2.0] * 3 + [1.0] * 3)
    run, by_hand = Weighted(inner, length_scale=0.5).begin(0.01), inner.begin(0.01)
    for shrink in (1.0, 0.7, 0.2):
        J, xdot = rng.normal(size=(6, 7)) * shrink, rng.normal(size=6)
        assert_allclose(run.solve(J, xdot), by_hand.solve(scale[:, None] * J, scale * xdot), atol=1e-12)


@pytest.mark.parametrize("inner", [MoorePenrose(), JParse(), DampedLeastSquares(), NakamuraHanafusa()], ids=repr)
def test_the_largest_gain_of_weighted_bounds_the_joint_speed(inner, rng):
    for _ in range(50):
        Wq, Wx = positive_definite(rng, 2), positive_definite(rng, 2)
        weighted = Weighted(inner, joint_weights=Wq, task_weights=Wx)
        J = matrix([0.5, 10 ** -rng.uniform(0.5, 4)], 2, 2, rng)
        P = np.stack([weighted.solve(J, e) for e in np.eye(2)], axis=1)
        assert np.linalg.norm(P, 2) <= weighted.largest_gain(0.5) * (1 + 1e-9)
    assert Weighted(DampedLeastSquares(0.1)).largest_gain(1.0) == DampedLeastSquares(0.1).largest_gain(1.0)
    assert Weighted(ChanLawrence()).largest_gain(1.0) == np.inf


def test_weighted_compares_by_value_however_the_weights_are_given():
    given_as_array = Weighted(JParse(), joint_weights=np.array([1, 2.0]), task_weights=np.eye(2))
    assert given_as_array == Weighted(JParse(), joint_weights=[1, 2], task_weights=[[1, 0], [0, 1]])
    assert given_as_array != Weighted(JParse(), joint_weights=[1, 3], task_weights=[[1, 0], [0, 1]])
    assert hash(given_as_array) == hash(eval(repr(given_as_array), vars(rik.inverses)))


@pytest.mark.parametrize(
    "arguments, match",
    [
        ({"joint_weights": [1, 0]}, r"joint_weights must be positive, \(k,\), or a symmetric positive definite"),
        ({"joint_weights": [[1, 2], [2, 1]]}, "joint_weights must be positive"),
        ({"joint_weights": [[1, 0.1], [0, 1]]}, "joint_weights must be positive"),
        ({"task_weights": [[1, 2, 3]]}, "task_weights must be positive"),
        ({"task_weights": [np.nan]}, "task_weights must be finite"),
        ({"task_weights": 3.0}, "task_weights must have shape"),
        ({"length_scale": 0}, "length_scale must be > 0"),
        ({"length_scale": 1, "task_weights": [1] * 6}, "task_weights or length_scale, not both"),
        ({"linear_rows": 2}, "linear_rows says which rows length_scale divides"),
        ({"length_scale": 1, "linear_rows": -1}, "linear_rows must be a whole number ≥ 0, got -1"),
        ({"length_scale": 1, "linear_rows": 1.5}, "linear_rows must be a whole number"),
    ],
)
def test_weights_that_cannot_be_meant_are_refused(arguments, match):
    with pytest.raises(rik.InputError, match=match):
        Weighted(JParse(), **arguments)


def test_weights_for_another_shape_are_refused():
    with pytest.raises(rik.InputError, match="joint_weights are for 3 joints, J has 2 columns"):
        Weighted(JParse(), joint_weights=[1, 1, 1]).solve(np.eye(2), [1, 1])
    with pytest.raises(rik.InputError, match="task_weights are for 3 rows, J has 2"):
        Weighted(JParse(), task_weights=[1, 1, 1]).solve(np.eye(2), [1, 1])
    with pytest.raises(rik.InputError, match="3 of 6 rows as linear; J has 2 rows: say linear_rows"):
        Weighted(JParse(), length_scale=0.5).solve(np.eye(2), [1, 1])
    with pytest.raises(rik.InputError, match="linear_rows is 3, J has only 2 rows"):
        Weighted(JParse(), length_scale=0.5, linear_rows=3).solve(np.eye(2), [1, 1])
    with pytest.raises(rik.InputError, match="inverse must be a RobustInverse, got 'jparse'"):
        Weighted("jparse")


# User-defined accuracy


def test_user_accuracy_with_full_weight_is_the_variable_damping(rng):
    for smallest in (0.2, 0.04, 1e-3, 0.0):
        J, xdot = matrix([1, 0.5, smallest], 3, 4, rng), rng.normal(size=3)
        plain = UserDefinedAccuracy(least_weight=1.0).solve(J, xdot)
        assert_allclose(plain, Chiaverini().solve(J, xdot), atol=1e-9)


def test_user_accuracy_is_the_pseudo_inverse_away_from_singularities(rng):
    J, xdot = matrix([1, 0.5, 0.06], 3, 4, rng), rng.normal(size=3)
    assert_allclose(UserDefinedAccuracy().solve(J, xdot), np.linalg.pinv(J) @ xdot, atol=1e-10)


@settings(deadline=None, max_examples=50)
@given(seeds)
def test_what_is_sacrificed_spares_the_other_directions(seed):
    """With a vanishing weight the other rows are solved as if the sacrificed one were not there."""
    rng = np.random.default_rng(seed)
    J, xdot = matrix([1, 0.6, 0.0], 3, 4, rng), rng.normal(size=3)
    d = rng.normal(size=3)
    others = np.linalg.svd(d[None])[2][1:]
    if np.linalg.svd(others @ J)[1][-1] < 0.2:
        return
    dropped = UserDefinedAccuracy(sacrificed=d, least_weight=1e-9, damping=0.01).solve(J, xdot)
    assert_allclose(dropped, DampedLeastSquares(0.01).solve(others @ J, others @ xdot), atol=1e-6)
    lost = rik.lost_directions(J)[:, 0]
    errors = [
        np.linalg.norm(others @ (xdot - J @ UserDefinedAccuracy(d, least_weight=w, damping=0.01).solve(J, xdot)))
        for w in (1.0, 0.01)
    ]
    assert_allclose(errors[0], np.linalg.norm(others @ lost) * abs(lost @ xdot), atol=0.01)
    assert errors[1] < 0.01 * np.linalg.norm(xdot)


def test_the_weight_law_runs_from_one_at_the_threshold_to_the_least_on_a_singularity():
    inverse = UserDefinedAccuracy(least_weight=0.2, threshold=0.1)
    weights = [float(inverse.weight(np.diag([1.0, s]))) for s in (0.2, 0.1, 0.06, 0.0)]
    assert_allclose(weights, [1, 1, 1 - 0.8 * 0.8, 0.2], atol=1e-12)


def test_a_row_and_its_unit_vector_are_the_same_sacrifice(rng):
    J, xdot = matrix([1, 0.6, 0.01], 3, 4, rng), rng.normal(size=3)
    by_row = UserDefinedAccuracy(sacrificed=1).solve(J, xdot)
    assert_allclose(UserDefinedAccuracy(sacrificed=[0, -3, 0]).solve(J, xdot), by_row, atol=1e-13)
    assert UserDefinedAccuracy([1, 1, 1]) == eval(repr(UserDefinedAccuracy([2, 2, 2])), vars(rik.inverses))


def test_user_accuracy_is_continuous_through_the_threshold_and_the_singularity():
    t = np.linspace(-0.2, 0.2, 40001)
    J = np.zeros((t.size, 2, 2))
    J[:, 0, 0], J[:, 1, 1] = 1, t
    qdot = UserDefinedAccuracy(sacrificed=[1, 2]).solve(J, [1.0, 1.0])
    assert np.abs(np.diff(qdot[t**2 < 0.0024], axis=0)).max() < 0.05
    # At the threshold it is steep like a square root, but does not jump.
    near = 0.05 + np.array([-1e-13, 1e-13])
    J = np.stack([np.diag([1.0, s]) for s in near])
    assert np.abs(np.diff(UserDefinedAccuracy(sacrificed=[1, 2]).solve(J, [1.0, 1.0]), axis=0)).max() < 1e-3


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: UserDefinedAccuracy(sacrificed=[0, 0]), "sacrificed must be a row or one direction"),
        (lambda: UserDefinedAccuracy(least_weight=0), "least_weight must be > 0"),
        (lambda: UserDefinedAccuracy(least_weight=1.1), "least_weight must be > 0 and ≤ 1, got 1.1"),
        (lambda: UserDefinedAccuracy(sacrificed=2).solve(np.eye(2), [1, 1]), r"sacrificed must lie in \[-2, 1\]"),
        (lambda: UserDefinedAccuracy([1, 0, 0]).solve(np.eye(2), [1, 1]), "sacrificed must have shape"),
        (lambda: DulebaAdditive(squared_damping=0), "squared_damping must be > 0"),
        (lambda: DulebaAdditive(variant="row"), "variant must be one of plain, scaled, floored, got 'row'"),
        (lambda: SDLS(clamp="soft"), "clamp must be one of hard, smooth, got 'soft'"),
        (lambda: SDLS(max_angle=-1), "max_angle must be > 0"),
        (lambda: SDLS(linear_rows=3).solve(np.eye(2), [1, 1]), "linear_rows is 3, J has only 2 rows"),
        (lambda: KelmarKhosla(ratio=1.5), "ratio must be > 0 and ≤ 1, got 1.5"),
        (lambda: KelmarKhosla(floor=0), "floor must be > 0"),
        (lambda: ChanLawrence(gain=0), "gain must be > 0"),
        (lambda: Sugihara(bias=0), "bias must be > 0"),
        (lambda: FilteredInverse(leakage=-1), "leakage must be ≥ 0"),
        (lambda: FilteredInverse(initial=SDLS()), "initial must be a SingularValueFilter or None"),
        (lambda: FilteredInverse().begin(0.0), "dt must be > 0"),
        (lambda: MaciejewskiKlein(directions=0), "directions must be a whole number ≥ 1, got 0"),
        (lambda: SmallestSingularValues(shift=0), "shift must be > 0"),
        (lambda: Halley(inverse=SDLS()), "inverse must be a SingularValueFilter"),
        (lambda: Halley().begin(-1.0), "horizon must be > 0"),
        (lambda: JParseWithGains(gamma=1.0), "gamma must be > 0 and < 1"),
        (lambda: JParsePositionFirst(position_gain=0), "position_gain must be > 0"),
        (lambda: TrackingLoop(JParse(), error_gain=0), "error_gain must be > 0"),
        (lambda: TrackingLoop("ESRIM"), "inverse must be a RobustInverse"),
    ],
)
def test_what_cannot_be_meant_is_refused_and_the_range_said(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()


# Selectively damped least squares


def buss_kim(J, error, gamma_max, length, linear, clamp="hard"):
    """The paper's steps one by one, with loops."""
    W = np.diag([1.0] * linear + [length] * (len(J) - linear))
    J, error = W @ J, W @ error
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    blocks = [slice(0, linear), slice(linear, len(J))]
    total = np.zeros(J.shape[1])
    for i in np.flatnonzero(s > 1e-10):
        wanted = sum(np.linalg.norm(U[block, i]) for block in blocks)
        moved = sum(abs(Vt[i, j]) * np.linalg.norm(J[b, j]) for b in blocks for j in range(J.shape[1])) / s[i]
        limit = min(1, wanted / moved) * gamma_max
        part = (U[:, i] @ error) / s[i] * Vt[i]
        largest = np.abs(part).max()
        total += part * (min(1, limit / largest) if clamp == "hard" else limit / (limit + largest))
    return total * min(1, gamma_max / np.abs(total).max())


@settings(deadline=None, max_examples=50)
@given(seeds, st.floats(-3, 2))
def test_sdls_is_the_papers_procedure(seed, exponent):
    rng = np.random.default_rng(seed)
    for m, n, linear in ((3, 7, 3), (6, 7, 3), (2, 3, 2), (6, 4, 3), (4, 6, 1)):
        J = matrix(-np.sort(-rng.uniform(0.01, 2, min(m, n))), m, n, rng)
        error = rng.normal(size=m) * 10**exponent
        given_rows = None if linear == min(3, m) else linear
        for clamp in ("hard", "smooth"):
            qdot = SDLS(0.5, clamp, length_scale=0.7, linear_rows=given_rows).solve(J, error)
            assert_allclose(qdot, buss_kim(J, error, 0.5, 0.7, linear, clamp), atol=1e-9)


@pytest.mark.parametrize("clamp", ["hard", "smooth"])
@settings(deadline=None, max_examples=50)
@given(seed=seeds, exponent=st.floats(-8, 8), smallest=st.sampled_from([0.0, 1e-200, 1e-12, 1e-3, 0.3]))
def test_no_joint_moves_more_than_the_largest_angle(clamp, seed, exponent, smallest):
    rng = np.random.default_rng(seed)
    J = matrix([2, 0.5, smallest], 3, 5, rng)
    assert np.abs(SDLS(0.2, clamp=clamp).solve(J, rng.normal(size=3) * 10**exponent)).max() <= 0.2 * (1 + 1e-12)


def test_for_small_steps_sdls_is_the_pseudo_inverse_hard_exactly_smooth_to_first_order(rng):
    J, xdot = matrix([1, 0.5, 0.2], 3, 5, rng), rng.normal(size=3)
    exact = np.linalg.pinv(J) @ xdot
    assert_allclose(SDLS().solve(J, 1e-4 * xdot), 1e-4 * exact, rtol=1e-9)
    errors = [np.linalg.norm(SDLS(clamp="smooth").solve(J, h * xdot) / h - exact) for h in (1e-4, 1e-5)]
    assert_allclose(errors[0] / errors[1], 10, rtol=0.02)
    assert errors[1] > 0


@pytest.mark.parametrize("clamp", ["hard", "smooth"])
def test_sdls_is_continuous_through_the_stretched_arm_and_in_the_step(clamp):
    q2 = np.linspace(-0.1, 0.1, 20001)
    J = np.stack([circle_jacobian(np.array([0.3, angle])) for angle in q2])
    assert np.linalg.svd(J)[1].min() < 1e-6
    assert np.abs(np.diff(SDLS(clamp=clamp).solve(J, [0.3, 0.4]), axis=0)).max() < 1e-3
    steps = np.linspace(0, 5, 20001)[:, None] * np.array([0.6, 0.8])
    assert np.abs(np.diff(SDLS(clamp=clamp).solve([[1, 0.4], [0.2, 0.7]], steps), axis=0)).max() < 1e-3


def test_sdls_jumps_where_a_joint_loses_all_effect():
    """The column vanishes with σ, so N/M stays 1: the clamp lets γ_max through, with either sign."""
    sides = [SDLS(max_angle=0.2).solve(np.diag([1.0, t]), [0.3, 0.4])[1] for t in (-1e-9, 0.0, 1e-9)]
    assert_allclose(sides, [-0.2, 0.0, 0.2], atol=1e-12)


# Kelmar and Khosla


def test_kelmar_khosla_damps_by_the_ratio_of_successive_manipulabilities(rng):
    inverse = KelmarKhosla(damping=0.3, floor=0.01)
    run = inverse.begin(0.01)
    before, after = rng.normal(size=(2, 3, 5))
    after *= 0.5
    ratio = rik.manipulability(after) / rik.manipulability(before)
    xdot = rng.normal(size=3)
    assert_allclose(run.solve(before, xdot), DampedLeastSquares(0.01).solve(before, xdot), atol=1e-12)
    expected = DampedLeastSquares(0.01 + 0.3 * (1 - ratio)) if ratio < 1 else DampedLeastSquares(0.01)
    assert_allclose(run.solve(after, xdot), expected.solve(after, xdot), atol=1e-12)


def test_kelmar_khosla_damps_on_the_way_in_only():
    run = KelmarKhosla(damping=0.3, floor=0.01).begin(0.01)
    speeds = [run.solve(np.diag([1.0, s]), [0.0, 1.0])[1] for s in (0.4, 0.2, 0.0, 0.0, 0.2, 0.2)]
    light, heavy = DampedLeastSquares(0.01).gains([0.4, 0.2]), DampedLeastSquares(0.01 + 0.3 * 0.5).gains([0.2])
    assert_allclose(speeds, [light[0], heavy[0], 0, 0, light[1], light[1]], atol=1e-12)


def test_kelmar_khosla_depends_on_the_sample_time():
    """The same approach in twice as many steps damps about half as much."""

    def damping(steps):
        s = np.linspace(1, 0.9, steps + 1)[-2:]
        return float(KelmarKhosla(damping=1.0, floor=1e-9).damping_for(1 - s[1] / s[0]))

    assert_allclose(damping(100) / damping(200), 2, rtol=0.01)


def test_kelmar_khosla_with_a_ratio_ignores_a_slow_approach():
    inverse = KelmarKhosla(damping=0.3, ratio=0.9, floor=0.01)
    assert_allclose(inverse.damping_for([-1.0, 0.0, 0.09, 0.11, 1.0]), [0.01, 0.01, 0.01, 0.043, 0.31], atol=1e-12)


def test_the_manipulability_of_a_run_neither_overflows_nor_underflows():
    run = KelmarKhosla(floor=1e-90).begin(0.01)
    for scale in (1e100, 0.5e100, 1e-100, 0.5e-100, 1e100, 0.0, 1e-100):
        assert np.isfinite(run.solve(scale * np.eye(6), np.ones(6))).all()


# Damping by the error


@pytest.mark.parametrize(
    "inverse, squared",
    [(ChanLawrence(0.7), lambda E: 0.7 * E), (Sugihara(0.02), lambda E: E + 0.02)],
    ids=["Chan", "Sugihara"],
)
def test_error_damped_reads_the_error_and_takes_xdot_for_it_without_one(inverse, squared, rng):
    J, xdot, error = rng.normal(size=(3, 5)), rng.normal(size=3), rng.normal(size=3)

    def expected(error):
        return np.linalg.solve(J.T @ J + squared(error @ error / 2) * np.eye(5), J.T @ xdot)

    assert_allclose(inverse.velocity(TaskEquation(J, xdot, error)), expected(error), atol=1e-10)
    assert_allclose(inverse.solve(J, xdot), expected(xdot), atol=1e-10)


@settings(deadline=None, max_examples=50)
@given(seeds, st.floats(-6, 6), st.floats(0.01, 10))
def test_a_step_of_chan_lawrence_is_bounded_whatever_j_is(seed, exponent, gain):
    rng = np.random.default_rng(seed)
    J = matrix([2, 10**exponent * 1e-6, 0.0], 3, 5, rng)
    step = ChanLawrence(gain).solve(J, rng.normal(size=3) * 10**exponent)
    assert np.linalg.norm(step) <= (1 + 1e-9) / np.sqrt(2 * gain)


def test_without_error_chan_lawrence_is_the_pseudo_inverse_rounding_excluded(rng):
    J, xdot = matrix([1, 0.5, 0.0], 3, 5, rng), rng.normal(size=3)
    qdot = ChanLawrence().velocity(TaskEquation(J, xdot, np.zeros(3)))
    assert_allclose(qdot, np.linalg.pinv(J, rcond=1e-10) @ xdot, atol=1e-12)


def solve_pose(robot, inverse, q, target, tolerance=1e-12, limit=60):
    """Steps of gain · dt = 1 until the error is below the tolerance: (q, errors)."""
    errors = []
    for _ in range(limit):
        equation = rik.FrameTask(target).equation(robot, q, hessian=inverse.needs_hessian)
        errors.append(float(np.linalg.norm(equation.error)))
        if errors[-1] < tolerance:
            break
        q = robot.integrate(q, inverse.velocity(equation))
    return q, errors


def test_chan_lawrence_converges_faster_and_faster_and_sugihara_linearly(rng):
    robot = rik.load("puma560")
    q = robot.configuration(np.radians([10, -40, 130, 20, 50, 15]))
    start = robot.integrate(q, 0.1 * rng.normal(size=6))
    errors = solve_pose(robot, ChanLawrence(0.01), start, robot.pose(q))[1]
    assert errors[-1] < 1e-12
    assert len(errors) < 15
    linear = np.array(solve_pose(robot, Sugihara(1e-3), start, robot.pose(q), limit=40)[1])
    assert_allclose(linear[-1] / linear[-2], linear[-2] / linear[-3], rtol=0.05)


# The filtered inverse


def test_the_filtered_inverse_relaxes_as_its_closed_form_says(rng):
    s, rate, dt = np.array([1.5, 0.6, 0.05]), 20.0, 0.01
    Q1, Q2 = orthogonal(rng, 3), orthogonal(rng, 3)
    J = Q1 @ np.diag(s) @ Q2
    inverse = FilteredInverse(rate, initial=None)
    run = inverse.begin(dt)
    theta = np.zeros((3, 3))
    for _ in range(2000):
        theta = inverse.advance(theta, J, dt)
    diagonal = np.diag(Q2 @ theta @ Q1)
    assert_allclose(diagonal, (1 - np.exp(-2 * rate * s**2 * 20)) / s, atol=1e-9)
    assert_allclose(diagonal, [0.66667, 1.66667, 17.2933], atol=5e-5)
    for _ in range(2001):  # the first call is Θ₀ẋ
        qdot = run.solve(J, [1.0, 2.0, 3.0])
    assert_allclose(qdot, theta @ [1, 2, 3], atol=1e-9)


@pytest.mark.parametrize("leakage", [0.0, 0.3])
@pytest.mark.parametrize("shape", [(3, 3), (2, 4), (4, 2), (1, 3), (3, 1)])
def test_a_step_of_the_filtered_inverse_integrates_its_flow(shape, leakage, rng):
    """Against explicit Euler in steps so small that it is right to four digits."""
    m, n = shape
    J, theta = rng.normal(size=(m, n)), rng.normal(size=(n, m))
    inverse = FilteredInverse(2.0, leakage)
    euler, h = theta.copy(), 1e-5
    for _ in range(5000):
        flow = J.T @ J @ euler + euler @ J @ J.T + 2 * leakage**2 * euler - 2 * J.T
        euler = euler - h * 2.0 * flow
    assert_allclose(inverse.advance(theta, J, 0.05), euler, atol=2e-3)
    halves = inverse.advance(inverse.advance(theta, J, 0.02), J, 0.03)
    assert_allclose(halves, inverse.advance(theta, J, 0.05), atol=1e-12)


def test_where_sigma_is_zero_the_filtered_inverse_keeps_what_it_has(rng):
    J = np.diag([1.0, 0.0])
    theta = np.array([[5.0, 1.0], [1.0, 7.0]])
    later = FilteredInverse(20.0).advance(theta, J, 100.0)
    assert_allclose(later, [[1, 0], [0, 7]], atol=1e-12)


def test_with_leakage_the_filtered_inverse_settles_at_damped_least_squares(rng):
    J = matrix([1, 0.3, 0.0], 3, 5, rng)
    theta = FilteredInverse(20.0, leakage=0.2).advance(rng.normal(size=(5, 3)), J, 100.0)
    assert_allclose(theta, DampedLeastSquares(0.2).matrix(J), atol=1e-12)


def test_the_filtered_inverse_passes_a_singularity_bounded():
    run = FilteredInverse(20.0, initial=MoorePenrose()).begin(0.01)
    speeds = [run.solve(np.diag([1.0, t]), [0.0, 1.0])[1] for t in np.linspace(0.5, -0.5, 201)]
    assert np.abs(speeds).max() < 4.5
    assert speeds[0] == 2
    assert speeds[-1] < -1


# Maciejewski and Klein


def motion(robot, seed, speed=0.5, dt=1e-3, steps=2000):
    rng = np.random.default_rng(seed)
    q = robot.configuration(rng.uniform(-np.pi, np.pi, robot.n))
    return robot.jacobian(q + np.arange(steps)[:, None] * dt * rng.uniform(-speed, speed, robot.n))


@pytest.mark.parametrize("directions", [1, 2])
def test_the_smallest_singular_value_of_a_moving_pa10_is_tracked(directions):
    for seed in range(2):
        J = motion(rik.load("pa10"), seed)
        U, s, _ = np.linalg.svd(J)
        tracked = SmallestSingularValues(directions)
        found = [tracked.update(j) for j in J]
        assert np.abs([values[-1] for values, _ in found] - s[:, -1]).max() < 2.0e-6
        assert np.abs(np.sum([vectors[:, -1] for _, vectors in found] * U[:, :, -1], axis=-1)).min() > 0.99998


def test_two_directions_see_a_crossing_that_one_misses(rng):
    """σ₂ falls below σ₃. One vector turns to it only as fast as rounding grows, two have it already."""
    falling = np.linspace(0.4, 0.1, 200)
    J = orthogonal(rng, 3) @ np.stack([np.diag([2.0, s, 0.2]) for s in falling])
    missed = {}
    for directions in (1, 2):
        tracked = SmallestSingularValues(directions)
        missed[directions] = np.abs([tracked.update(j)[0][-1] for j in J] - np.minimum(falling, 0.2)).max()
    assert missed[2] < 1e-9
    assert missed[1] > 0.02


def test_the_tracked_values_of_a_tall_and_of_a_singular_matrix_are_right(rng):
    for s in ([1, 0.5, 0.2], [1, 0.5, 0.0], [1, 0.0, 0.0], [0.0, 0.0, 0.0]):
        for m, n in ((3, 5), (5, 3), (3, 3)):
            J, tracked = matrix(s, m, n, rng), SmallestSingularValues(2)
            for step in range(4):
                values, vectors = tracked.update(J + 1e-6 * step * rng.normal(size=(m, n)))
            assert_allclose(values, s[1:], atol=1e-4)
            assert_allclose(vectors.T @ vectors, np.eye(2), atol=1e-12)


@pytest.mark.parametrize("shape", [(3, 5), (5, 3), (3, 3), (6, 7), (1, 4)])
def test_for_j_at_rest_maciejewski_klein_is_numerical_filtering(shape, rng):
    for spectrum in (
        np.linspace(1, 0.5, min(shape)),
        np.linspace(1, 0.0, min(shape)),
        np.geomspace(1, 0.01, min(shape)),
    ):
        J, xdot = matrix(spectrum, *shape, rng), rng.normal(size=shape[0])
        run = MaciejewskiKlein().begin(0.01)
        for _ in range(3):
            qdot = run.solve(J, xdot)
        assert_allclose(qdot, MaciejewskiKlein().solve(J, xdot), atol=1e-7)
        small = np.sum(spectrum < 0.05)
        if small <= 2:
            assert_allclose(qdot, ChiaveriniFiltering(floor=0.005).solve(J, xdot), atol=1e-7)


def test_a_run_of_maciejewski_klein_follows_the_exact_filter_past_singularities():
    J = motion(rik.load("pa10"), 3, speed=1.0, steps=3000)
    run, xdot = MaciejewskiKlein(threshold=0.2, damping=0.1).begin(1e-3), np.ones(6)
    exact = MaciejewskiKlein(threshold=0.2, damping=0.1).solve(J, xdot)
    found = np.array([run.solve(j, xdot) for j in J])
    assert np.linalg.svd(J)[1][:, -1].min() < 0.15
    assert np.abs(found - exact).max() < 1e-4


def test_joint_speed_is_bounded_even_when_the_tracking_is_lost(rng):
    inverse = MaciejewskiKlein(directions=1)
    run = inverse.begin(0.01)
    for _ in range(300):
        J, xdot = matrix([1, 10 ** -rng.uniform(0, 4), 10 ** -rng.uniform(4, 9)], 3, 5, rng), rng.normal(size=3)
        assert np.linalg.norm(run.solve(J, xdot)) <= inverse.largest_gain(1.0) * np.linalg.norm(xdot) * (1 + 1e-6)


@pytest.mark.parametrize("spectrum", [[1, 0.5, 0.3], [1, 0.5, 0.01], [1, 0.03, 0.01], [0.04, 0.03, 0.02]], ids=repr)
def test_with_one_direction_maciejewski_klein_damps_the_last_one_only(spectrum, rng):
    J, xdot = matrix(spectrum, 3, 5, rng), rng.normal(size=3)
    printed = ChiaveriniFiltering(floor=0.005, multi=False)
    run = MaciejewskiKlein(directions=1).begin(0.01)
    for _ in range(3):
        qdot = run.solve(J, xdot)
    assert_allclose(qdot, printed.solve(J, xdot), atol=1e-7)
    assert_allclose(MaciejewskiKlein(directions=1).solve(J, xdot), printed.solve(J, xdot), atol=1e-12)


@pytest.mark.parametrize("scale", [1e100, 1e9, 1e-9, 1e-100])
def test_a_run_of_maciejewski_klein_copes_with_units_that_dwarf_its_shift(scale, rng):
    inverse = MaciejewskiKlein()
    run = inverse.begin(0.01)
    for _ in range(5):
        qdot = run.solve(scale * matrix([1, 0.5, 0.0, 0.0], 4, 6, rng), np.ones(4))
        assert np.linalg.norm(qdot) <= inverse.largest_gain(scale) * 2 * (1 + 1e-6)


# Runs in general


@pytest.mark.parametrize("inverse", [KelmarKhosla(), FilteredInverse(), MaciejewskiKlein()], ids=repr)
def test_a_run_has_its_own_memory_and_begins_as_solve(inverse, rng):
    J, xdot = 0.02 * rng.normal(size=(4, 3, 5)), rng.normal(size=3)
    first, second = inverse.begin(0.01), inverse.begin(0.01)
    alone = [first.solve(j, xdot) for j in J]
    assert_allclose(alone[0], inverse.solve(J[0], xdot), atol=1e-12)
    assert_allclose([second.solve(j, xdot) for j in J], alone, atol=0)
    assert np.abs(alone - inverse.solve(J, xdot)).max() > 1e-3
    with pytest.raises(rik.InputError, match="shape"):
        first.solve(rng.normal(size=(2, 3, 5)), xdot)


@pytest.mark.parametrize("inverse", [KelmarKhosla(), FilteredInverse(), MaciejewskiKlein()], ids=repr)
def test_a_run_over_a_batch_is_as_many_runs(inverse, rng):
    J, xdot = rng.normal(size=(4, 2, 3, 5)), rng.normal(size=(2, 3))
    together, apart = inverse.begin(0.01), [inverse.begin(0.01) for _ in range(2)]
    for j in J:
        assert_allclose(together.solve(j, xdot), [apart[i].solve(j[i], xdot[i]) for i in range(2)], atol=1e-10)


@pytest.mark.parametrize("inverse", [KelmarKhosla(), FilteredInverse(), MaciejewskiKlein(), Halley()], ids=repr)
def test_a_simulation_uses_the_memory(inverse):
    robot = rik.load("planar_3r")
    q0 = robot.configuration([1.0, -1.5, 1.0])
    target = robot.pose(q0 + np.array([0.2, 0.1, -0.2]))
    run = rik.simulate(robot, inverse, rik.FrameTask(target, gain=3.0), q0, duration=3.0, dt=0.01, limits=())
    assert np.linalg.norm(run.final_error) < 1e-3


# Halley


def test_halley_converges_cubically_where_newton_does_quadratically():
    robot, rng = rik.load("puma560"), np.random.default_rng(0)
    iterations, orders = {2: [], 3: []}, {2: [], 3: []}
    while len(orders[3]) < 30:
        q = robot.configuration(rng.uniform(-np.pi, np.pi, 6))
        if rik.svd(robot.jacobian(q)).s[-1] < 0.05:
            continue
        offset, target = 0.15 * rng.choice([-1, 1], 6), robot.pose(q)
        for order, inverse in ((2, JParse(gamma=0.01)), (3, Halley())):
            start = robot.integrate(q, offset)
            iterations[order].append(len(solve_pose(robot, inverse, start, target)[1]) - 1)
            far, near = (
                solve_pose(robot, inverse, robot.integrate(q, offset * h), target, limit=2)[1][1] for h in (0.2, 0.1)
            )
            orders[order].append(np.log2(far / near))
    assert np.median(iterations[2]) == 5
    assert np.median(iterations[3]) == 3
    assert_allclose(np.median(orders[2]), 2, atol=0.1)
    assert_allclose(np.median(orders[3]), 3, atol=0.15)


def test_the_second_order_step_is_its_formula(rng):
    J, H = rng.normal(size=(3, 4)), rng.normal(size=(3, 4, 4))
    xdot, error = rng.normal(size=(2, 3))
    first = np.linalg.pinv(J) @ error
    bent = J + 0.5 * sum(H[:, :, k] * first[k] for k in range(4))
    qdot = Halley(MoorePenrose()).velocity(TaskEquation(J, xdot, error, H))
    assert_allclose(qdot, np.linalg.pinv(bent) @ xdot, atol=1e-10)
    assert_allclose(Halley(MoorePenrose()).solve(J, xdot), np.linalg.pinv(J) @ xdot, atol=1e-12)


def test_in_a_run_halley_looks_ahead_one_time_step_and_follows_to_second_order():
    robot = rik.load("puma560")
    q, twist = robot.configuration(np.radians([10, -40, 130, 20, 50, 15])), np.array([0.1, 0.2, -0.1, 0.4, -0.3, 0.2])

    def miss(inverse, dt):
        target = robot.pose(q)
        equation = TaskEquation(robot.jacobian(q), twist, np.full(6, np.nan), robot.hessian(q))
        moved = robot.pose(robot.integrate(q, dt * inverse.begin(dt).velocity(equation)))
        return np.linalg.norm(rik.pose_error(target, moved) - dt * twist)

    assert_allclose(miss(MoorePenrose(), 0.1) / miss(MoorePenrose(), 0.05), 4, rtol=0.1)
    assert_allclose(miss(Halley(), 0.1) / miss(Halley(), 0.05), 8, rtol=0.15)
    assert miss(Halley(), 0.05) < 0.1 * miss(MoorePenrose(), 0.05)


def test_halley_says_so_without_a_hessian_and_stays_bounded_on_a_singularity(rng):
    assert Halley().needs_hessian
    with pytest.raises(rik.InputError, match="Halley needs the Hessian"):
        Halley().velocity(TaskEquation(np.eye(2), np.ones(2), np.ones(2)))
    robot = rik.load("puma560")
    q = robot.configuration([0.1, -0.5, 2.0, 0.3, 0.0, 0.2])
    equation = TaskEquation(robot.jacobian(q), np.ones(6), 0.1 * np.ones(6), robot.hessian(q))
    assert rik.svd(equation.J).s[-1] < 1e-12
    assert np.linalg.norm(Halley().velocity(equation)) < 1e4


# J-PARSE with gains


@pytest.mark.parametrize("gain", [0.5, 1.0, 3.0])
def test_equal_gains_are_j_parse_with_that_gain(gain, rng):
    for s in ([1, 0.5, 0.3, 0.08, 0.01, 0.0], [1, 1, 1, 1, 1, 1]):
        J, xdot = matrix(s, 6, 7, rng), rng.normal(size=6)
        both = JParseWithGains(position_gain=gain, orientation_gain=gain)
        assert_allclose(both.solve(J, xdot), JParse(gain=gain).solve(J, xdot), atol=1e-9)
        assert both.largest_gain(1.0) == pytest.approx(JParse(gain=gain).largest_gain(1.0))


def test_the_gains_act_on_the_right_of_the_singular_part(rng):
    U, V, s = orthogonal(rng, 6), orthogonal(rng, 6), np.array([1, 0.8, 0.5, 0.3, 0.04, 0.01])
    J, xdot, K = U @ np.diag(s) @ V.T, rng.normal(size=6), np.diag([2.0] * 3 + [0.5] * 3)
    Up, Us, phi = U[:, :4], U[:, 4:], np.diag(s[4:] / 0.1)
    command = Up @ Up.T @ xdot + Us @ phi @ Us.T @ K @ xdot
    expected = V @ np.diag(1 / np.maximum(s, 0.1)) @ U.T @ command
    found = JParseWithGains(position_gain=2.0, orientation_gain=0.5).solve(J, xdot)
    assert_allclose(found, expected, atol=1e-10)


def test_gains_whose_roots_differ_by_more_than_two_are_refused_unless_asked_for():
    assert JParseWithGains(position_gain=9, orientation_gain=1).position_gain == 9
    assert JParseWithGains(position_gain=15, orientation_gain=15).position_gain == 15
    with pytest.raises(rik.InputError, match=r"must be ≤ 2, got 2.08 for 9.5 and 1"):
        JParseWithGains(position_gain=9.5, orientation_gain=1)
    assert JParseWithGains(position_gain=1, orientation_gain=15, allow_unstable=True).orientation_gain == 15


def smallest_eigenvalue(U, lost, k_p, k_o, phi):
    """Of the symmetric part of U_p U_pᵀ + U_s Φ U_sᵀ K_s: negative where the error can grow."""
    kept = np.eye(6) - U[:, :lost] @ U[:, :lost].T
    loop = kept + U[:, :lost] @ np.diag(phi) @ U[:, :lost].T @ np.diag([k_p] * 3 + [k_o] * 3)
    return np.linalg.eigvalsh((loop + loop.T) / 2)[0]


@settings(deadline=None, max_examples=50)
@given(seeds, st.floats(0, 2), st.floats(0.01, 9))
def test_within_the_rule_one_singular_direction_never_feeds_the_error(seed, distance, k_o):
    rng = np.random.default_rng(seed)
    k_p = (np.sqrt(k_o) + distance) ** 2
    for phi in (0.0, rng.uniform(), 1.0):
        assert smallest_eigenvalue(orthogonal(rng, 6), 1, k_p, k_o, [phi]) >= -1e-9


def worst(k_p, k_o, lost, phi):
    """Over directions that mix one linear with one angular row."""
    angles, first = np.linspace(0, np.pi, 2001), np.zeros((6, 6))
    values = []
    for a in angles:
        first[:, :] = np.eye(6)
        first[[0, 3], 0], first[[0, 3], 3] = (np.cos(a), np.sin(a)), (-np.sin(a), np.cos(a))
        values.append(smallest_eigenvalue(first[:, [0, 3, 1, 2, 4, 5]], lost, k_p, k_o, phi))
    return min(values)


def test_the_rule_is_sharp_for_one_singular_direction_and_fails_for_two():
    assert_allclose(worst(9.0, 1.0, 1, [1.0]), 0, atol=1e-5)
    assert worst(9.5, 1.0, 1, [1.0]) < -0.05
    assert_allclose(worst(9.0, 1.0, 2, [1.0, 0.0]), -(8**2) / (8 * 10), atol=1e-5)
    assert_allclose(worst(4.0, 4.0, 2, [1.0, 0.0]), 0, atol=1e-12)


@settings(deadline=None, max_examples=50)
@given(seeds)
def test_the_largest_gain_with_unequal_gains_is_a_bound(seed):
    rng = np.random.default_rng(seed)
    k_o = rng.uniform(0.01, 4)
    inverse = JParseWithGains(position_gain=(np.sqrt(k_o) + rng.uniform(0, 2)) ** 2, orientation_gain=k_o)
    s = -np.sort(-np.append(1.0, 10 ** -rng.uniform(0, 2, 5)))
    J = matrix(s, 6, 6, rng)
    P = np.stack([inverse.solve(J, e) for e in np.eye(6)], axis=1)
    assert np.linalg.norm(P, 2) <= inverse.largest_gain(1.0) * (1 + 1e-9)


def test_position_first_is_exact_for_a_regular_arm_and_spares_the_position_else(rng):
    J, xdot = matrix(np.linspace(1, 0.8, 6), 6, 7, rng), rng.normal(size=6)
    qdot = JParsePositionFirst(gamma=0.001).solve(J, xdot)
    assert_allclose(J @ qdot, xdot, atol=1e-10)
    J[5] = J[4] + J[3]  # the orientation loses a direction
    qdot = JParsePositionFirst(gamma=0.001).solve(J, xdot)
    assert_allclose(J[:3] @ qdot, xdot[:3], atol=1e-10)
    assert np.linalg.norm(J @ qdot - xdot) > 1e-3


def test_position_first_stays_bounded_where_the_second_task_vanishes_as_a_whole():
    """Position takes three of four joints; as the fourth turns the tool less and less, nothing grows."""
    for turn in (1e-1, 1e-4, 1e-8, 0.0):
        J = np.zeros((6, 4))
        J[:3, :3] = np.eye(3)
        J[3, 3], J[4, 0] = turn, 1.0
        qdot = JParsePositionFirst(gamma=0.1).solve(J, [0, 0, 0, 1.0, 0, 0])
        assert np.linalg.norm(qdot) <= 10 + 1e-9


def test_position_first_with_rows_of_one_kind_is_j_parse(rng):
    J, xdot = matrix([1, 0.5, 0.01], 3, 5, rng), rng.normal(size=3)
    inverse = JParsePositionFirst(position_gain=2.0, orientation_gain=0.5)
    assert_allclose(inverse.solve(J, xdot), JParse(gain=2.0).solve(J, xdot), atol=1e-12)
    only_turns = JParsePositionFirst(position_gain=2.0, orientation_gain=0.5, linear_rows=0)
    assert_allclose(only_turns.solve(J, xdot), JParse(gain=0.5).solve(J, xdot), atol=1e-12)


# The tracking loop


def line_of_poses(robot, q0, steps):
    """The ESRIM paper's straight line, 0.05 mm per step, with the orientation of the start."""
    start, end = np.array([0.9829, -0.3996, -0.3243]), np.array([0.3945, -0.3999, -0.4414])
    poses = np.tile(robot.pose(q0), (steps + 1, 1, 1))
    assert_allclose(poses[0, :3, 3], start, atol=1e-6)
    poses[:, :3, 3] += np.arange(steps + 1)[:, None] * 5e-5 * (end - start) / np.linalg.norm(end - start)
    return poses


def test_esrim_lags_by_its_law_on_a_regular_line():
    """(α₀ − K_i)/K_p steps of 0.05 mm: 0.280 mm."""
    robot = rik.load("srs_7r")
    q0 = np.array([-0.41543652, 1.21822063, 3.23017729, -1.44134756, 0.28953475, 1.68344849, -3.08944524])
    poses = line_of_poses(robot, q0, 1200)
    loop = TrackingLoop(Weighted(ESRIM(sigma0=1.3, alpha0=1.7), length_scale=1e-3))
    report = loop.run(
        poses, q0, forward=robot.pose, jacobian=robot.jacobian, difference=lambda a, b: rik.pose_error(b, a)
    )
    lag = np.linalg.norm(report.error[:, :3], axis=-1) * 1e3
    assert_allclose(np.median(lag), 0.28001, atol=1e-4)
    assert lag.max() < 0.2805
    assert_allclose(report.lyapunov, 0.5 * np.sum(report.error**2, axis=-1), rtol=1e-12)
    assert_allclose(report.lyapunov_change, np.diff(report.lyapunov), atol=0)
    assert report.q.shape == (1201, 7)
    assert report.steps.shape == (1200, 7)


def circle(q):
    return np.array([np.cos(q[0]) + np.cos(q.sum()), np.sin(q[0]) + np.sin(q.sum())])


def circle_jacobian(q):
    return np.array([[-np.sin(q[0]) - np.sin(q.sum()), -np.sin(q.sum())], [circle(q)[0], np.cos(q.sum())]])


def test_an_exact_inverse_without_motion_of_the_target_shrinks_the_error_by_its_gain():
    q0 = np.array([0.3, 0.8])
    goal = circle(q0) + [1e-6, -2e-6]
    report = TrackingLoop(MoorePenrose(), error_gain=0.5).run([goal] * 6, q0, forward=circle, jacobian=circle_jacobian)
    assert_allclose(report.error[1:], 0.5 * report.error[:-1], atol=1e-10)
    assert (report.lyapunov_change < 0).all()


def test_the_increment_gain_feeds_the_motion_of_the_target_forward():
    q0 = np.array([0.3, 0.8])
    targets = circle(q0) + np.arange(200)[:, None] * np.array([-1e-4, 2e-5])
    with_feed, without = (
        TrackingLoop(MoorePenrose(), increment_gain=gain).run(targets, q0, forward=circle, jacobian=circle_jacobian)
        for gain in (1.0, 0.0)
    )
    step = np.linalg.norm([1e-4, 2e-5])
    assert_allclose(np.linalg.norm(without.error[-1]), step / 0.125, rtol=1e-3)
    assert np.linalg.norm(with_feed.error[-1]) < 1e-2 * step


def test_a_loop_uses_the_memory_of_its_inverse_and_leaves_it_alone():
    q0 = np.array([0.3, 0.8])
    loop = TrackingLoop(FilteredInverse(rate=1.0, initial=TruncatedSVD()))
    arguments = {"forward": circle, "jacobian": circle_jacobian}
    targets = circle(q0) + np.arange(20)[:, None] * np.array([-1e-2, 2e-3])
    report = loop.run(targets, q0, **arguments)
    assert_allclose(loop.run(targets, q0, **arguments).q, report.q, atol=0)
    forgetful = TrackingLoop(TruncatedSVD()).run(targets, q0, **arguments)
    assert_allclose(report.steps[0], forgetful.steps[0], atol=1e-14)
    assert np.abs(report.steps[-1] - forgetful.steps[-1]).max() > 1e-5


def test_too_few_targets_and_an_arm_that_runs_away_are_refused():
    q0 = np.array([0.3, 0.8])
    loop = TrackingLoop(DampedLeastSquares(1e-6), error_gain=1e90)
    with pytest.raises(rik.InputError, match="two targets and one q0 are needed"):
        loop.run([circle(q0)], q0, forward=circle, jacobian=circle_jacobian)
    with pytest.raises(rik.InputError, match="must be finite"):
        loop.run(
            [np.zeros(2), np.ones(2), np.ones(2)],
            q0,
            forward=lambda q: circle(q) if np.abs(q).max() < 1e30 else np.full(2, np.nan),
            jacobian=circle_jacobian,
        )


# Found by attacking the family


@pytest.mark.parametrize("inverse", OTHER_CASES, ids=repr)
def test_leading_axes_that_do_not_fit_are_refused(inverse, rng):
    with pytest.raises(rik.InputError, match="do not broadcast"):
        inverse.solve(rng.normal(size=(2, 6, 7)), rng.normal(size=(3, 6)))


def test_kelmar_khosla_is_calm_while_moving_inside_a_singular_stratum():
    robot = rik.load("panda")
    run, speeds = KelmarKhosla().begin(0.01), []
    for i in range(30):
        q = robot.configuration([0.01 * i, 0, 0, 0, 0, 0, 0])
        speeds.append(np.abs(run.solve(robot.jacobian(q), [0, 0, 0.1, 0, 0, 0])).max())
    assert_allclose(speeds, speeds[0], rtol=0.05)


@pytest.mark.parametrize("inverse", [FilteredInverse(), KelmarKhosla(), MaciejewskiKlein()], ids=repr)
def test_a_run_begins_anew(inverse, rng):
    J, xdot = rng.normal(size=(5, 4, 6)), rng.normal(size=4)
    run = inverse.begin(0.01)
    first = [run.solve(each, xdot) for each in J]
    again = run.begin(0.01)
    assert_allclose([again.solve(each, xdot) for each in J], first)


@pytest.mark.parametrize("inverse", [Weighted(JParse(), joint_weights=[1, 2, 3, 4.0]), Halley(horizon=0.01)], ids=repr)
def test_velocities_of_a_batch_are_those_of_a_loop(inverse, rng):
    J, xdot, H = rng.normal(size=(5, 3, 4)), rng.normal(size=(5, 3)), rng.normal(size=(5, 3, 4, 4))
    batch = inverse.velocity(TaskEquation(J, xdot, 0.1 * xdot, H))
    loop = [inverse.velocity(TaskEquation(J[i], xdot[i], 0.1 * xdot[i], H[i])) for i in range(5)]
    assert_allclose(batch, loop, atol=1e-12)
