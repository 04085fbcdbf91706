"""What every robust inverse promises, checked for all of them. A new inverse adds one row to CASES."""

import itertools
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik import inverses
from robust_ik.inverses import DampedLeastSquares, JParse, MoorePenrose, SingularValueFilter
from robust_ik.linalg import RANK_TOLERANCE, SMALLEST_SIGMA
from tests.test_linalg import matrix

CASES = [
    MoorePenrose(),
    MoorePenrose(tolerance=1e-3),
    DampedLeastSquares(),
    DampedLeastSquares(damping=0.5),
    JParse(),
    JParse(gamma=0.02),
    JParse(gamma=0.3, gain=2.0),
    JParse(gain=0.5),
]
SHAPES = [(1, 1), (2, 2), (3, 3), (2, 5), (6, 6), (6, 7), (6, 9), (6, 3), (5, 1)]
SPECTRA = {
    "healthy": lambda k: np.linspace(2, 1, k),
    "one vanishing": lambda k: np.concatenate([np.linspace(2, 1, k - 1), [0.0]]),
    "one nearly vanishing": lambda k: np.concatenate([np.linspace(2, 1, k - 1), [1e-7]]),
    "rank one": lambda k: np.concatenate([[1.5], np.zeros(k - 1)]),
    "repeated": lambda k: np.full(k, 0.7),
    "repeated and small": lambda k: np.concatenate([[3.0], np.full(k - 1, 0.05)]),
    "graded": lambda k: 10.0 ** -np.arange(k),
    "huge": lambda k: 1e100 * np.linspace(2, 1, k),
    "tiny": lambda k: 1e-100 * np.linspace(2, 1, k),
}
all_inverses = pytest.mark.parametrize("inverse", CASES, ids=repr)


def jacobians(rng):
    for (m, n), spectrum in itertools.product(SHAPES, SPECTRA):
        yield matrix(SPECTRA[spectrum](min(m, n)), m, n, rng)


def test_every_exported_inverse_has_a_row():
    exported = {getattr(inverses, name) for name in inverses.__all__}
    concrete = {c for c in exported if issubclass(c, rik.RobustInverse) and not getattr(c, "__abstractmethods__", None)}
    assert concrete == {type(case) for case in CASES}


@all_inverses
def test_it_names_its_source_and_prints_and_compares_by_value(inverse):
    assert re.search(r"\d{4}", inverse.source)
    assert type(inverse).__doc__
    assert "Source:" in type(inverse).__doc__
    assert eval(repr(inverse), vars(inverses)) == inverse
    assert hash(inverse) == hash(eval(repr(inverse), vars(inverses)))


@all_inverses
def test_joint_speed_is_bounded_by_the_declared_largest_gain(inverse, rng):
    for J in jacobians(rng):
        xdot = rng.normal(size=J.shape[0])
        bound = inverse.largest_gain(np.linalg.norm(J, 2))
        qdot = inverse.solve(J, xdot)
        assert np.isfinite(qdot).all()
        assert np.linalg.norm(qdot) <= bound * np.linalg.norm(xdot) * (1 + 1e-9)


@all_inverses
@pytest.mark.parametrize("sigma_max", [0.01, 0.3, 1.0, 20.0])
def test_the_declared_largest_gain_is_the_least_upper_bound(inverse, sigma_max):
    # Fine in logarithm, and finer still just above where φ may jump.
    jump = [j.sigma * (1 + 1e-9) for j in inverse.jumps(sigma_max)]
    peak = [getattr(inverse, "damping", sigma_max), getattr(inverse, "gamma", 1.0) * sigma_max]
    s = np.unique(np.concatenate([np.geomspace(1e-18, 1, 4001) * sigma_max, jump, peak]))
    s = s[(s <= sigma_max) & (s > 0)]
    values = inverse.gains(np.stack([np.full_like(s, sigma_max), s], axis=-1))[:, 1]
    assert_allclose(values.max(), inverse.largest_gain(sigma_max), rtol=1e-5)


@all_inverses
def test_it_is_exact_where_declared_and_nowhere_else(inverse, rng):
    for J in jacobians(rng):
        U, s, _ = np.linalg.svd(J, full_matrices=False)
        given_share = np.diag(U.T @ J @ np.array([inverse.solve(J, u) for u in U.T]).T)
        exact = inverse.is_exact(s)
        assert_allclose(given_share[exact], 1, rtol=1e-6)
    s = -np.sort(-rng.uniform(0, 2, (500, 4)), axis=-1)
    share = s * inverse.gains(s)
    assert ((np.abs(share - 1) < 1e-12) == inverse.is_exact(s)).all()


@all_inverses
def test_the_gain_is_continuous_but_for_the_declared_jumps(inverse):
    """Sweep one signed singular value t of diag(1, t); between neighbours J# may only step where a jump is declared."""
    t = np.concatenate([-np.geomspace(1, 1e-16, 3000), [0.0], np.geomspace(1e-16, 1, 3000)])
    J = np.zeros((t.size, 2, 2))
    J[:, 0, 0], J[:, 1, 1] = 1, t
    entry = inverse.matrix(J)[:, 1, 1]
    steps = np.abs(np.diff(entry))
    allowed = 0.02 * np.maximum(np.abs(entry[1:]), np.abs(entry[:-1])) + 1e-9
    for jump in inverse.jumps(1.0):
        sides = [jump.sigma * (1 - 1e-9), jump.sigma * (1 + 1e-9)]
        low, high = inverse.gains(np.array([[1.0, side] for side in sides]))[:, 1]
        assert_allclose(abs(high - low), jump.height, rtol=1e-6)
        near = (np.abs(t[1:]) >= jump.sigma * 0.98) & (np.abs(t[1:]) <= jump.sigma * 1.02)
        allowed[near] += jump.height
        allowed[:-1][near[1:]] += jump.height
    assert (steps <= allowed).all()
    assert inverse.continuous == (not inverse.jumps(1.0))


@all_inverses
def test_the_declared_gain_at_zero_is_the_limit(inverse):
    for sigma_max in (0.1, 1.0, 7.0):
        near = inverse.gains(np.array([sigma_max, 1e-160 * sigma_max]))[1]
        assert_allclose(inverse.gain_at_zero(sigma_max), near, atol=1e-100)


@all_inverses
def test_a_batch_equals_a_loop_and_leading_axes_broadcast(inverse, rng):
    for m, n in SHAPES:
        J, xdot = rng.normal(size=(4, 1, m, n)), rng.normal(size=(3, m))
        batch = inverse.solve(J, xdot)
        loop = [[inverse.solve(J[i, 0], xdot[j]) for j in range(3)] for i in range(4)]
        assert batch.shape == (4, 3, n)
        assert_allclose(batch, loop, rtol=1e-12, atol=1e-12)


@all_inverses
def test_matrix_and_solve_agree(inverse, rng):
    for J in jacobians(rng):
        xdot = rng.normal(size=J.shape[0])
        expected = inverse.solve(J, xdot)
        scale = max(float(np.abs(expected).max()), 1e-300)
        assert_allclose(inverse.matrix(J) @ xdot / scale, expected / scale, atol=1e-9)


@all_inverses
@pytest.mark.parametrize("shape", SHAPES)
def test_a_zero_jacobian_gives_zero_velocity(inverse, shape):
    assert not inverse.solve(np.zeros(shape), np.ones(shape[0])).any()
    assert not inverse.matrix(np.zeros(shape)).any()
    assert inverse.gain_at_zero(0.0) == 0


@all_inverses
def test_a_jacobian_too_small_to_invert_gives_zero_velocity(inverse):
    assert not inverse.solve(np.full((2, 3), 1e-310), [1.0, 1.0]).any()


@all_inverses
def test_turning_the_task_and_the_joints_turns_the_result(inverse, rng):
    J, xdot = rng.normal(size=(4, 6)), rng.normal(size=4)
    Q1, Q2 = np.linalg.qr(rng.normal(size=(4, 4)))[0], np.linalg.qr(rng.normal(size=(6, 6)))[0]
    assert_allclose(inverse.solve(Q1 @ J @ Q2.T, Q1 @ xdot), Q2 @ inverse.solve(J, xdot), atol=1e-12)


@all_inverses
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(inverse, bad):
    with pytest.raises(rik.InputError, match="J must be finite"):
        inverse.solve([[1, bad]], [1])
    with pytest.raises(rik.InputError, match="xdot must be finite"):
        inverse.solve([[1, 2]], [bad])


@all_inverses
def test_a_task_velocity_of_the_wrong_length_is_refused(inverse):
    with pytest.raises(rik.InputError, match=r"xdot must have shape \(\.\.\., 2\), got \(3,\)"):
        inverse.solve(np.eye(2), [1, 2, 3])


@all_inverses
def test_inputs_are_not_written_to(inverse, rng):
    J, xdot = rng.normal(size=(3, 4)), rng.normal(size=3)
    J.setflags(write=False)
    xdot.setflags(write=False)
    inverse.solve(J, xdot)


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: DampedLeastSquares(0.0), "damping must be > 0, got 0"),
        (lambda: DampedLeastSquares(-1), "damping must be > 0, got -1"),
        (lambda: DampedLeastSquares(np.nan), "damping must be > 0, got nan"),
        (lambda: DampedLeastSquares("much"), "damping must be > 0, got 'much'"),
        (lambda: JParse(gamma=1.0), "gamma must be > 0 and < 1, got 1.0"),
        (lambda: JParse(gamma=0.0), "gamma must be > 0 and < 1"),
        (lambda: JParse(gain=0.0), "gain must be > 0"),
        (lambda: MoorePenrose(tolerance=0.0), "tolerance must be > 0 and < 1"),
        (lambda: MoorePenrose(tolerance=2.0), "tolerance must be > 0 and < 1"),
    ],
)
def test_a_parameter_out_of_range_is_refused_and_the_range_said(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()


def test_moore_penrose_is_numpys_pseudo_inverse(rng):
    for m, n in SHAPES:
        J = rng.normal(size=(m, n))
        assert_allclose(MoorePenrose().matrix(J), np.linalg.pinv(J), atol=1e-12)


@pytest.mark.parametrize("damping", [1e-3, 0.05, 1.0])
def test_damped_least_squares_is_its_matrix_form(damping, rng):
    for m, n in SHAPES:
        J = rng.normal(size=(m, n))
        form = J.T @ np.linalg.inv(J @ J.T + damping**2 * np.eye(m))
        assert_allclose(DampedLeastSquares(damping).matrix(J), form, atol=1e-9)


sigmas = st.just(0.0) | st.floats(SMALLEST_SIGMA, 1e3)
spectra = st.lists(sigmas, min_size=1, max_size=7).map(lambda s: np.array(sorted(s, reverse=True)))


@given(spectra, st.floats(1e-3, 0.999))
def test_jparse_with_gain_one_is_sigma_over_the_floored_sigma_squared(s, gamma):
    floored = np.maximum(s, gamma * s[0])
    expected = np.where(s > 0, s / np.where(floored > 0, floored, 1) / np.where(floored > 0, floored, 1), 0)
    assert (JParse(gamma).gains(s) == expected).all()


@given(spectra, st.floats(1e-3, 0.999), st.floats(0.1, 5))
def test_jparse_is_its_assembled_form(s, gamma, gain):
    """Eq. (28): Jₛ⁺ Jₚ Jₚ⁺ ẋ + Jₛ⁺ Uₛ Φ Uₛᵀ ẋ, in the basis of the singular vectors."""
    if s[0] < 1e-100:
        return
    kept = s > gamma * s[0]
    safe = np.maximum(s, gamma * s[0])
    phi = np.where(kept, 1.0, gain * s / (gamma * s[0]))
    assert_allclose(JParse(gamma, gain).gains(s), phi / safe, rtol=1e-12)


def test_the_default_tolerance_counts_rounding_as_zero(rng):
    for _ in range(200):
        J = matrix([1, 0.5, 0.0], 3, 3, rng)
        assert np.linalg.norm(MoorePenrose().matrix(J), 2) < 2.1
    assert RANK_TOLERANCE < 1e-12


def test_filters_are_frozen():
    with pytest.raises(AttributeError):
        JParse().gamma = 0.5
    assert isinstance(JParse(), SingularValueFilter)
