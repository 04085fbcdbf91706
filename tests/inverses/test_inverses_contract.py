"""What every robust inverse promises, and every filter besides. New rows: `cases_filters.py`, `cases_others.py`."""

import itertools
import re
from dataclasses import astuple

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik import inverses
from robust_ik.inverses.task_equation import TaskEquation
from tests.cases_filters import CASES
from tests.cases_others import OTHER_CASES
from tests.kinematics.test_svd import matrix

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
LARGEST_SIGMAS = [0.003, 0.01, 0.3, 1.0, 20.0]
all_inverses = pytest.mark.parametrize("inverse", CASES + OTHER_CASES, ids=repr)
all_filters = pytest.mark.parametrize("inverse", CASES, ids=repr)


def jacobians(rng):
    for (m, n), spectrum in itertools.product(SHAPES, SPECTRA):
        yield matrix(SPECTRA[spectrum](min(m, n)), m, n, rng)


# Every inverse


def test_every_exported_inverse_has_a_row():
    exported = [getattr(inverses, name) for name in inverses.__all__]
    classes = {c for c in exported if isinstance(c, type) and issubclass(c, rik.RobustInverse)}
    concrete = {c for c in classes if not getattr(c, "__abstractmethods__", None)}
    assert concrete == {type(case) for case in CASES + OTHER_CASES}


@all_inverses
def test_it_names_its_source_and_prints_and_compares_by_value(inverse):
    assert re.search(r"\d{4}", inverse.source)
    assert "Source:" in type(inverse).__doc__
    assert "Watch for:" in type(inverse).__doc__
    again = eval(repr(inverse), vars(inverses))
    assert again == inverse
    assert hash(again) == hash(inverse)


@all_inverses
def test_its_card_is_complete(inverse):
    assert all(isinstance(entry, str) and entry.strip() for entry in astuple(inverse.card))


@all_inverses
def test_joint_speed_is_finite_and_bounded_by_the_declared_largest_gain(inverse, rng):
    for J in jacobians(rng):
        xdot = rng.normal(size=J.shape[0])
        bound = inverse.largest_gain(np.linalg.norm(J, 2))
        qdot = inverse.solve(J, xdot)
        assert np.isfinite(qdot).all()
        assert np.linalg.norm(qdot) <= bound * np.linalg.norm(xdot) * (1 + 1e-9)


@all_inverses
def test_a_controller_gets_finite_velocities_from_it_and_from_its_run(inverse, rng):
    for m, n in SHAPES:
        J, xdot, hessian = rng.normal(size=(m, n)), rng.normal(size=m), rng.normal(size=(m, n, n))
        equation = TaskEquation(J, xdot, 0.1 * xdot, hessian if inverse.needs_hessian else None)
        for driver in (inverse, inverse.begin(0.01)):
            qdot = driver.velocity(equation)
            assert qdot.shape == (n,)
            assert np.isfinite(qdot).all()


@all_inverses
def test_a_batch_equals_a_loop_and_leading_axes_broadcast(inverse, rng):
    for m, n in SHAPES:
        J, xdot = rng.normal(size=(4, 1, m, n)), rng.normal(size=(3, m))
        batch = inverse.solve(J, xdot)
        loop = [[inverse.solve(J[i, 0], xdot[j]) for j in range(3)] for i in range(4)]
        assert batch.shape == (4, 3, n)
        assert_allclose(batch, loop, rtol=1e-10, atol=1e-12)


@all_inverses
def test_a_zero_jacobian_gives_zero_velocity(inverse):
    for shape in SHAPES:
        assert not inverse.solve(np.zeros(shape), np.ones(shape[0])).any()


@all_inverses
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(inverse, bad):
    with pytest.raises(rik.InputError, match="J must be finite"):
        inverse.solve([[1, 2], [3, bad]], [1, 1])
    with pytest.raises(rik.InputError, match="xdot must be finite"):
        inverse.solve([[1, 2], [3, 5]], [1, bad])


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


@all_inverses
def test_it_is_frozen(inverse):
    with pytest.raises(AttributeError):
        inverse.source = "elsewhere"


# Filters


@all_filters
def test_a_filter_needs_no_arguments(inverse):
    assert type(inverse)() == type(inverse)()


@all_filters
def test_matrix_and_solve_agree(inverse, rng):
    for J in jacobians(rng):
        xdot = rng.normal(size=J.shape[0])
        expected = inverse.solve(J, xdot)
        scale = max(float(np.abs(expected).max()), 1e-300)
        assert_allclose(inverse.matrix(J) @ xdot / scale, expected / scale, atol=1e-9)


@all_filters
def test_what_is_exactly_lost_gets_no_gain(inverse):
    for s in ([0.0], [1.0, 0.0], [0.02, 0.01, 0.0, 0.0], [1e150, 1.0, 0.0]):
        assert not inverse.gains(s)[np.array(s) == 0].any()
    assert not inverse.solve(np.full((2, 3), 1e-310), [1.0, 1.0]).any()
    assert inverse.gain_at_zero(0.0) == 0
    assert inverse.largest_gain(0.0) == 0


@all_filters
def test_turning_the_task_and_the_joints_turns_the_result(inverse, rng):
    J, xdot = rng.normal(size=(4, 6)), rng.normal(size=4)
    Q1, Q2 = np.linalg.qr(rng.normal(size=(4, 4)))[0], np.linalg.qr(rng.normal(size=(6, 6)))[0]
    assert_allclose(inverse.solve(Q1 @ J @ Q2.T, Q1 @ xdot), Q2 @ inverse.solve(J, xdot), atol=1e-12)


@all_filters
def test_secondary_motions_do_not_leak_through_the_exact_projector(inverse, rng):
    for spectrum in ([2, 1, 0.5], [2, 0.04, 0.03], [2, 1, 0.0], [1, 0.0, 0.0]):
        J, xdot, qdot0 = matrix(spectrum, 3, 6, rng), rng.normal(size=3), rng.normal(size=6)
        qdot = inverse.solve(J, xdot)
        with_secondary = qdot + rik.null_projector(J) @ qdot0
        scale = max(1.0, float(np.linalg.norm(qdot)))
        assert_allclose(J @ with_secondary / scale, J @ qdot / scale, atol=1e-14)


def largest_over(family, sigma_max):
    """The largest |φ| over t in (0, sigma_max]: a grid in log t, then ever closer around the best."""
    t = np.geomspace(1e-18, 1, 2001) * sigma_max
    for _ in range(12):
        values = family(t)
        best = int(values.argmax())
        t = np.linspace(t[max(best - 1, 0)], t[min(best + 1, t.size - 1)], 101)
    return float(max(values.max(), family(t).max()))


@all_filters
@pytest.mark.parametrize("sigma_max", LARGEST_SIGMAS)
def test_the_declared_largest_gain_is_the_least_upper_bound(inverse, sigma_max, rng):
    def family(ones, several):
        def largest(t):
            s = np.concatenate([np.full((t.size, ones), sigma_max), np.repeat(t[:, None], several, axis=1)], axis=1)
            return np.abs(inverse.gains(s)).max(axis=-1)

        return largest

    bound = inverse.largest_gain(sigma_max)
    exponents = rng.uniform(0, 6, (2000, 5))
    spectra = -np.sort(-np.concatenate([np.ones((2000, 1)), 10**-exponents], axis=1) * sigma_max, axis=-1)
    assert np.abs(inverse.gains(spectra)).max() <= bound * (1 + 1e-9)
    if inverse.needs_hessian:
        return  # The bound covers `velocity` too; see its own tests.
    reached = [largest_over(family(*counts), sigma_max) for counts in ((1, 1), (1, 2), (15, 1))]
    reached.append(float(np.abs(inverse.gains([sigma_max])[0])))
    if np.isinf(bound):
        assert max(reached) > 1e9
    else:
        assert_allclose(max(reached), bound, rtol=1e-6)


@all_filters
def test_it_is_exact_where_declared_and_nowhere_else(inverse, rng):
    for J in jacobians(rng):
        decomposition = rik.svd(J)
        U, s = decomposition.U, decomposition.s
        given_share = np.diag(U.T @ J @ np.array([inverse.solve(J, u) for u in U.T]).T)
        # A σ of the order of rounding is not the σ that `solve` saw.
        assert_allclose(given_share[inverse.is_exact(s) & (s > 1e-9 * s[0])], 1, rtol=1e-6)
    s = -np.sort(-(rng.uniform(0, 1, (2000, 4)) ** rng.uniform(0.2, 3, (2000, 1))), axis=-1)
    share = s * inverse.gains(s)
    assert ((np.abs(share - 1) < 1e-14) == inverse.is_exact(s)).all()


def discontinuities(function, t, scale):
    """(where, how high) the function jumps between neighbours in t: each interval is halved towards its larger step."""
    low, high = t[:-1].copy(), t[1:].copy()
    f_low, f_high = function(low), function(high)
    for _ in range(80):
        middle = (low + high) / 2
        f_middle = function(middle)
        left = np.abs(f_middle - f_low) >= np.abs(f_high - f_middle)
        low, f_low = np.where(left, low, middle), np.where(left, f_low, f_middle)
        high, f_high = np.where(left, middle, high), np.where(left, f_middle, f_high)
    steps = np.abs(f_high - f_low)
    found = steps > 1e-7 * np.maximum(np.abs(f_low), np.abs(f_high)) + 1e-9 * scale
    return list(zip(high[found], steps[found]))


@all_filters
@pytest.mark.parametrize("sigma_max", LARGEST_SIGMAS)
def test_the_gain_is_continuous_but_for_the_declared_jumps(inverse, sigma_max):
    """One singular value t runs from 0 to σ₁, the other stays: J = diag(σ₁, t)."""
    declared = {jump.sigma: jump.height for jump in inverse.jumps(sigma_max)}
    bound = inverse.largest_gain(sigma_max)
    scale = bound if 0 < bound < np.inf else 1.0
    t = np.geomspace(1e-40, 0.999, 800) * sigma_max

    def gain(index):
        return lambda t: inverse.gains(np.stack([np.full_like(t, sigma_max), t], axis=-1))[:, index]

    found = discontinuities(gain(1), t, scale)
    expected = sorted((sigma, height) for sigma, height in declared.items() if sigma > 0)
    assert len(found) == len(expected)
    assert_allclose(np.reshape(found, (-1, 2)), np.reshape(expected, (-1, 2)), rtol=1e-6)
    assert not discontinuities(gain(0), t, scale)
    at_zero = 2 * abs(gain(1)(np.array([1e-285 * sigma_max]))[0])
    assert np.isinf(declared.get(0.0, 0.0)) or abs(at_zero - declared.get(0.0, 0.0)) <= 1e-6 * scale
    assert not np.isinf(declared.get(0.0, 0.0)) or at_zero > 1e200


@all_filters
def test_a_singular_value_that_passes_zero_comes_back_with_the_opposite_gain(inverse):
    """So φ(0⁺) ≠ 0 is a jump by 2φ(0⁺)."""
    t = np.geomspace(1e-6, 0.9, 50)
    J = np.zeros((2, t.size, 2, 2))
    J[..., 0, 0], J[0, :, 1, 1], J[1, :, 1, 1] = 1, t, -t
    positive, negative = inverse.matrix(J)[..., 1, 1]
    assert_allclose(positive, inverse.gains(np.stack([np.ones_like(t), t], axis=-1))[:, 1], rtol=1e-12)
    assert_allclose(negative, -positive, rtol=1e-12)


@all_filters
def test_the_declared_gain_at_zero_is_the_limit(inverse):
    for sigma_max in (0.1, 1.0, 7.0):
        near = inverse.gains(np.array([sigma_max, 1e-285 * sigma_max]))[1]
        declared = inverse.gain_at_zero(sigma_max)
        if np.isinf(declared):
            assert near * np.sign(declared) > 1e200
        else:
            assert_allclose(near, declared, rtol=1e-9, atol=1e-9)


@all_filters
def test_what_is_lost_exactly_is_given_nothing_and_the_card_says_so_where_one_would_think_otherwise(inverse):
    for sigma_max in (0.1, 1.0, 7.0):
        assert inverse.gains(np.array([sigma_max, 0.0]))[1] == 0
    says = "0 at σ = 0" in inverse.card.formula
    if inverse.gain_at_zero(1.0) != 0:
        assert says


@pytest.mark.parametrize("inverse", [case for case in CASES if case.continuous], ids=repr)
def test_a_continuous_filter_is_continuous_along_any_path_of_jacobians(inverse, rng):
    """Through regular, corank 1 and corank 2 matrices, and through coinciding singular values."""
    healthy, singular = rng.normal(size=(3, 4)), matrix([1, 0.0, 0.0], 3, 4, rng)
    Q1, Q2 = np.linalg.qr(rng.normal(size=(3, 3)))[0], np.linalg.qr(rng.normal(size=(4, 4)))[0]

    def crossing(t):
        return Q1 @ np.stack([np.diag(d) for d in zip(1 + 0 * t, 0.03 + 0 * t, t)]) @ Q2[:, :3].T

    def straight(t):
        return singular + t[:, None, None] * (healthy - singular)

    def shrinking(t):
        return (t**3)[:, None, None] * healthy

    # A relative threshold scales like 1/J, so it cannot be continuous at J = 0.
    relative = isinstance(inverse, inverses.JParse)
    for path in (crossing, straight, *([] if relative else [shrinking])):
        t = np.linspace(-0.25, 0.25, 402)
        values = inverse.matrix(path(t))
        worst = np.argsort(np.abs(np.diff(values, axis=0)).max(axis=(1, 2)))[-5:]
        low, high = t[worst], t[worst + 1]
        for _ in range(45):
            middle = (low + high) / 2
            at_low, at_middle, at_high = (inverse.matrix(path(t)) for t in (low, middle, high))
            left = np.abs(at_middle - at_low).max(axis=(1, 2)) >= np.abs(at_high - at_middle).max(axis=(1, 2))
            low, high = np.where(left, low, middle), np.where(left, middle, high)
        step = np.abs(inverse.matrix(path(high)) - inverse.matrix(path(low))).max()
        assert step < 1e-4 * inverse.largest_gain(1.0)
