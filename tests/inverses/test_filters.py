"""What each filter is: its matrix form, its closed forms and numbers, its identities with others, what it refuses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.inverses import (
    EDLS,
    ESRIM,
    Chiaverini,
    ChiaveriniFiltering,
    DampedLeastSquares,
    DulebaClamp,
    JParse,
    MoorePenrose,
    NakamuraHanafusa,
    Sigmoid,
    TruncatedSVD,
    jacobian_projection,
    jacobian_safety,
    jacobian_safety_projection,
)
from robust_ik.inverses.base import Jump
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import RANK_TOLERANCE, SMALLEST_SIGMA, null_projector
from tests.cases_filters import CASES
from tests.inverses.test_inverses_contract import largest_over
from tests.kinematics.test_svd import matrix

SHAPES = [(1, 1), (1, 4), (2, 2), (2, 5), (3, 3), (6, 6), (6, 7)]
sigmas = st.just(0.0) | st.floats(SMALLEST_SIGMA, 1e3)
spectra = st.lists(sigmas, min_size=1, max_size=7).map(lambda s: np.array(sorted(s, reverse=True)))


def phi(inverse, sigma, sigma_max=1.0):
    """φ at σ with σ₁ = sigma_max, for one σ or many."""
    sigma = np.asarray(sigma, dtype=float)
    return inverse.gains(np.stack([np.full_like(sigma, sigma_max), sigma], axis=-1))[..., 1]


def near_singular(rng, count=40):
    """Random J of all shapes with m ≤ n, every other one with small singular values."""
    for index in range(count):
        m, n = SHAPES[index % len(SHAPES)]
        s = 10 ** rng.uniform(-3 if index % 2 else -1, 0.5, m)
        yield matrix(-np.sort(-s), m, n, rng)


# Matrix forms


def gram(J):
    return J @ J.T


def ridge(J, added):
    return J.T @ np.linalg.inv(gram(J) + added)


def dls(damping):
    return lambda J: ridge(J, damping**2 * np.eye(J.shape[0]))


def nakamura(damping, w0, power):
    def form(J):
        w = np.sqrt(max(np.linalg.det(gram(J)), 0.0))
        return ridge(J, (damping * max(0.0, 1 - w / w0) ** 2) ** power * np.eye(J.shape[0]))

    return form


def fading(sigma, threshold, damping):
    return (1 - (sigma / threshold) ** 2) * damping**2 if sigma < threshold else 0.0


def chiaverini(threshold, damping):
    def form(J):
        sigma = np.linalg.norm(J, -2)
        return ridge(J, fading(sigma, threshold, damping) * np.eye(J.shape[0]))

    return form


def numerical_filtering(threshold, damping, floor):
    def form(J):
        U, s, _ = np.linalg.svd(J)
        u = U[:, -1]
        return ridge(J, floor**2 * np.eye(J.shape[0]) + fading(s[-1], threshold, damping) * np.outer(u, u))

    return form


def of_the_gram(function):
    """Σ f(σᵢ) uᵢuᵢᵀ as a function of the matrix J Jᵀ, by its eigenvectors."""

    def form(J):
        squares, U = np.linalg.eigh(gram(J))
        return U @ np.diag(function(np.sqrt(squares))) @ U.T

    return form


def sigmoid(top, shift, slope):
    return lambda J: ridge(J, of_the_gram(lambda s: top / (1 + np.exp((s + shift) / slope)))(J))


def edls(beta, lower, upper):
    share = of_the_gram(lambda s: np.maximum(0, 1 - beta ** ((s - lower) / (upper - lower))))
    return lambda J: np.linalg.pinv(J, rcond=1e-12) @ share(J)


def esrim(alpha0, sigma0, squared_beta):
    def form(J):
        _, s, Vt = np.linalg.svd(J, full_matrices=True)
        beta = np.zeros(J.shape[1])
        beta[: s.size] = np.where(s < sigma0, squared_beta(s), 0)
        keep = Vt[: s.size].T  # on the row space, where αJ has its range
        normal = alpha0**2 * J.T @ J + Vt.T @ np.diag(beta) @ Vt
        return keep @ np.linalg.inv(keep.T @ normal @ keep) @ keep.T @ J.T * alpha0

    return form


def clamp(floor):
    def form(J):
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        return np.linalg.pinv(U @ np.diag(np.maximum(s, floor)) @ Vt, rcond=1e-12)

    return form


FORMS = [
    (MoorePenrose(), lambda J: np.linalg.pinv(J, rcond=1e-12)),
    (DampedLeastSquares(0.001), dls(0.001)),
    (DampedLeastSquares(0.05), dls(0.05)),
    (DampedLeastSquares(1.0), dls(1.0)),
    (TruncatedSVD(gamma=0.05), lambda J: np.linalg.pinv(J, rcond=0.05)),
    (TruncatedSVD(0.05), lambda J: np.linalg.pinv(J, rcond=0.05 / np.linalg.norm(J, 2))),
    (DulebaClamp(0.1), clamp(0.1)),
    (NakamuraHanafusa(0.1, 0.3), nakamura(0.1, 0.3, 2)),
    (NakamuraHanafusa(0.03, 0.3, squared=False), nakamura(0.03, 0.3, 1)),
    (Chiaverini(0.2, 0.1), chiaverini(0.2, 0.1)),
    (ChiaveriniFiltering(0.2, 0.1, floor=0.0, multi=False), numerical_filtering(0.2, 0.1, 0.0)),
    (ChiaveriniFiltering(0.2, 0.1, floor=0.02, multi=False), numerical_filtering(0.2, 0.1, 0.02)),
    (Sigmoid(0.01, 0.02, 0.1), sigmoid(0.01, 0.02, 0.1)),
    (EDLS(0.02, 0.0, 0.3), edls(0.02, 0.0, 0.3)),
    (EDLS(0.02, 0.1, 0.3), edls(0.02, 0.1, 0.3)),
    (ESRIM(0.3), esrim(1.0, 0.3, lambda s: 0.3**2 - s**2)),
    (ESRIM(0.3, 1.7), esrim(1.7, 0.3, lambda s: 0.3**2 - s**2)),
    (ESRIM(0.3, beta_rule="linear"), esrim(1.0, 0.3, lambda s: (0.3 - s) ** 2)),
    (
        ESRIM(0.3, 0.5, beta_rule="chiaverini", damping=0.1),
        esrim(0.5, 0.3, lambda s: (1 - (s / 0.3) ** 2) * 0.1**2),
    ),
]


@pytest.mark.parametrize("inverse, form", FORMS, ids=[repr(inverse) for inverse, _ in FORMS])
def test_the_filter_is_its_matrix_form(inverse, form, rng):
    for J in near_singular(rng):
        expected = form(J)
        assert_allclose(inverse.matrix(J), expected, atol=1e-8 * max(1.0, np.abs(expected).max()))


# Numbers and closed forms


def test_the_declared_jumps_are_those_of_the_table():
    """Under J = diag(1, t): at σ = 0 the signed gain jumps by 2φ(0⁺)."""
    assert MoorePenrose().jumps(1.0) == (Jump(RANK_TOLERANCE, 1 / RANK_TOLERANCE),)
    assert TruncatedSVD(threshold=0.05).jumps(1.0) == (Jump(0.05, 20),)
    assert TruncatedSVD(gamma=0.05).jumps(4.0) == (Jump(0.2, 5),)
    assert DulebaClamp(0.01).jumps(1.0) == (Jump(0.0, 200),)
    assert DulebaClamp(0.01, detect=0.001).jumps(1.0) == (Jump(0.0, 200), Jump(0.001, 900))
    assert DulebaClamp(gamma=0.1).jumps(2.0) == (Jump(0.0, 10),)
    ((where, height),) = ((jump.sigma, jump.height) for jump in EDLS().jumps(1.0))
    assert where == 0
    assert_allclose(height, 2 * 13.04, rtol=1e-5)
    (jump,) = JParse(gamma=0.1, gain=3.0).jumps(2.0)
    assert_allclose([jump.sigma, jump.height], [0.2, 2 / 0.2])


@pytest.mark.parametrize("inverse", [TruncatedSVD(threshold=2.0), DulebaClamp(floor=3.0, detect=2.0)])
def test_a_jump_above_the_largest_singular_value_is_none_but_counts_for_continuity(inverse):
    assert all(jump.sigma == 0 for jump in inverse.jumps(1.0))
    assert any(jump.sigma == 2 for jump in inverse.jumps(5.0))
    assert not inverse.continuous


CONTINUOUS = (DampedLeastSquares, NakamuraHanafusa, Chiaverini, ESRIM, Sigmoid)


@pytest.mark.parametrize("inverse", CASES, ids=repr)
def test_the_filters_that_are_continuous_are_these(inverse):
    assert inverse.continuous == (
        isinstance(inverse, CONTINUOUS)
        or (isinstance(inverse, ChiaveriniFiltering) and inverse.multi)
        or (isinstance(inverse, EDLS) and inverse.lower > 0 and not (inverse.raw or inverse.asymmetric))
        or (isinstance(inverse, JParse) and inverse.gain == 1)
    )


@given(st.floats(1e-3, 1e3), st.floats(1e-2, 1e2))
def test_the_peak_of_fading_damping_has_its_closed_form(threshold, ratio):
    damping = ratio * threshold
    for inverse in (Chiaverini(threshold, damping), ChiaveriniFiltering(threshold, damping)):
        if ratio >= 1 / np.sqrt(2):
            assert_allclose(inverse.largest_gain(1e6), 1 / threshold, rtol=1e-12)
            s = np.linspace(0, threshold, 200)
            assert (np.diff(phi(inverse, s, 1e6)) > -1e-12 / threshold).all()
        else:
            root = np.sqrt(1 - ratio**2)
            assert_allclose(inverse.largest_gain(1e6), 1 / (2 * damping * root), rtol=1e-12)
            assert_allclose(phi(inverse, damping / root, 1e6), inverse.largest_gain(1e6), rtol=1e-9)


def test_with_the_parameters_of_the_experiment_numerical_filtering_peaks_at_twenty():
    assert ChiaveriniFiltering(0.05, 0.07).largest_gain(2.0) == 20
    assert Chiaverini(0.05, 0.07).largest_gain(2.0) == 20


def test_edls_has_the_numbers_of_its_figures():
    assert_allclose(EDLS().largest_gain(2.0), 13.04, rtol=1e-5)
    assert_allclose(EDLS().gain_at_zero(2.0), -np.log(0.02) / 0.3, rtol=1e-12)
    clipped = EDLS(lower=0.1)
    assert_allclose(clipped.largest_gain(2.0), 4.397, rtol=1e-4)
    s = np.linspace(0.11, 0.4, 29001)
    assert_allclose(s[phi(clipped, s).argmax()], 0.176, atol=5e-4)
    assert_allclose(0.3 * phi(clipped, 0.3), 0.98, rtol=1e-12)
    assert not phi(clipped, np.linspace(0, 0.1, 50)).any()


def test_edls_without_the_max_reverses_the_motion_and_blows_up():
    raw, clipped = EDLS(lower=0.1, raw=True), EDLS(lower=0.1)
    s = np.array([0.2, 0.1001, 0.0999, 0.01, 1e-6])
    assert_allclose(phi(raw, s)[:2], phi(clipped, s)[:2])
    assert (phi(raw, s)[2:] < 0).all()
    assert phi(raw, 1e-6) < -1e6
    assert raw.largest_gain(1.0) == np.inf
    assert raw.gain_at_zero(1.0) == -np.inf
    assert EDLS(raw=True).gain_at_zero(1.0) == EDLS().gain_at_zero(1.0)


def test_esrim_has_the_largest_gains_of_its_rules():
    root = np.sqrt(2)
    assert_allclose(ESRIM(0.3).largest_gain(1.0), 1 / 0.3, rtol=1e-12)
    assert_allclose(ESRIM(0.3, beta_rule="linear").largest_gain(1.0) * 0.3, 1 / (2 * root - 2), rtol=1e-12)
    assert_allclose(1 / (2 * root - 2), 1.2071, rtol=1e-5)
    assert_allclose(phi(ESRIM(0.3, beta_rule="linear"), 0.3 / root) * 0.3, 1.2071, rtol=1e-5)
    # Scalar α: α/(2√(α² − 1)) inside for α > √2; α/(2√(1 + α²) − 2) for the linear rule.
    assert_allclose(ESRIM(0.3, 1.7).largest_gain(1.0) * 0.3, 1.7 / (2 * np.sqrt(1.7**2 - 1)), rtol=1e-9)
    linear = ESRIM(0.3, 1.7, beta_rule="linear")
    assert_allclose(linear.largest_gain(1.0) * 0.3, 1.7 / (2 * np.sqrt(1 + 1.7**2) - 2), rtol=1e-9)
    fading = ESRIM(0.3, beta_rule="chiaverini", damping=0.05)
    assert_allclose(fading.largest_gain(1.0), Chiaverini(0.3, 0.05).largest_gain(1.0), rtol=1e-9)


@pytest.mark.parametrize("alpha0", [0.5, 1.0, 1.7])
@pytest.mark.parametrize(
    "rule, squared_beta",
    [
        ({"beta_rule": "floor"}, 0.3**2 - 0.15**2),
        ({"beta_rule": "linear"}, 0.15**2),
        ({"beta_rule": "chiaverini", "damping": 0.2}, 0.75 * 0.2**2),
    ],
)
def test_esrim_has_no_step_where_its_damping_sets_in(alpha0, rule, squared_beta):
    edge = np.array([1 - 1e-9, 1 + 1e-9]) * 0.3
    for mode, outside in (("scalar", alpha0), ("singular", 1.0)):
        inverse = ESRIM(0.3, alpha0, alpha_mode=mode, **rule)
        assert_allclose(phi(inverse, edge), 1 / (outside * 0.3), rtol=1e-7)
        blended = 1 + (alpha0 - 1) * (1 - 0.25) if mode == "singular" else alpha0
        assert_allclose(phi(inverse, 0.15), blended * 0.15 / ((blended * 0.15) ** 2 + squared_beta), rtol=1e-12)
    # A hard switch of α at σ₀ would have jumped by this much.
    assert abs(1 / (alpha0 * 0.3) - 1 / 0.3) > 1 or alpha0 == 1


@pytest.mark.parametrize("inverse", [case for case in CASES if isinstance(case, ESRIM)], ids=repr)
def test_esrim_misses_its_scaled_command_by_its_share_of_damping(inverse, rng):
    """Eq. (27), (28): ‖ẋ − αJ q̇‖ ≤ max β²/(α²σ² + β²) ‖ẋ‖, zero where nothing is damped."""
    if inverse.alpha_mode == "singular":
        return
    for J in near_singular(rng):
        xdot = rng.normal(size=J.shape[0])
        s = np.linalg.svd(J, compute_uv=False)
        beta = np.where(s < inverse.sigma0, 1 / inverse.gains(s) * inverse.alpha0 * s - (inverse.alpha0 * s) ** 2, 0.0)
        bound = (beta / ((inverse.alpha0 * s) ** 2 + beta)).max() * np.linalg.norm(xdot)
        missed = np.linalg.norm(xdot - inverse.alpha0 * J @ inverse.solve(J, xdot))
        assert missed <= bound + 1e-9


def test_the_sigmoid_peaks_where_its_damping_says():
    s = np.linspace(1e-4, 0.2, 200_001)
    assert_allclose(Sigmoid().largest_gain(1.0), 25.26, rtol=1e-4)
    assert_allclose(phi(Sigmoid(), s).max(), Sigmoid().largest_gain(1.0), rtol=1e-8)
    assert_allclose(phi(Sigmoid(), 1e-9) / 1e-9, (1 + np.exp(0.02)) / 0.001, rtol=1e-6)


@pytest.mark.parametrize("squared", [True, False])
@pytest.mark.parametrize("count", [1, 2, 3, 6])
@pytest.mark.parametrize("sigma_max", [0.05, 0.6, 2.0])
def test_nakamura_hanafusa_knows_its_bound_for_a_number_of_singular_values(squared, count, sigma_max, rng):
    inverse = NakamuraHanafusa(0.1, 0.02, squared)
    bound = inverse.largest_gain(sigma_max, count)
    s = np.concatenate([np.ones((3000, 1)), 10 ** -rng.uniform(0, 4, (3000, count - 1))], axis=1) * sigma_max
    assert inverse.gains(-np.sort(-s, axis=1)).max() <= bound * (1 + 1e-12)

    def of_the_last(t):
        return inverse.gains(np.concatenate([np.full((t.size, count - 1), sigma_max), t[:, None]], axis=1))[:, -1]

    reached = largest_over(of_the_last, sigma_max) if count > 1 else of_the_last(np.array([sigma_max]))[0]
    assert_allclose(reached, bound, rtol=1e-9)
    assert bound <= inverse.largest_gain(sigma_max) * (1 + 1e-12)


def test_nakamura_hanafusa_is_smooth_where_its_damping_sets_in():
    """C¹ in w at w₀: the damping and its slope vanish there."""
    for squared in (True, False):
        inverse = NakamuraHanafusa(0.1, 0.02, squared)
        h = 1e-8
        below, at, above = phi(inverse, [0.02 - h, 0.02, 0.02 + h])
        assert_allclose([(at - below) / h, (above - at) / h], -1 / 0.02**2, rtol=1e-3)
        assert inverse.squared_damping([1.0, 0.02]) == 0
        assert_allclose(inverse.squared_damping([1.0, 0.0]), 0.1 ** (2 if squared else 1))


def test_nakamura_hanafusa_takes_singular_values_beyond_any_product():
    assert NakamuraHanafusa().largest_gain(1e100, 6) == np.inf
    assert NakamuraHanafusa().largest_gain(1e-100, 6) == NakamuraHanafusa().gains([1e-100] * 6)[0]
    assert_allclose(NakamuraHanafusa().gains([1e200, 1e200, 0.5])[-1], 2)
    assert (NakamuraHanafusa().gains([1e200, 1e200, 0.0]) == [1e-200, 1e-200, 0.0]).all()


# Numerical filtering


def test_printed_numerical_filtering_jumps_where_the_last_two_singular_values_cross():
    printed = ChiaveriniFiltering(floor=0.0, multi=False)
    (jump,) = printed.jumps(1.0, others=(0.6, 0.04))
    assert jump.sigma == 0.04
    assert_allclose(jump.height, 1 / 0.04 - 0.04 / (0.04**2 + (1 - 0.8**2) * 0.07**2), rtol=1e-12)
    assert_allclose(jump.height, 13.1, atol=0.05)
    for inverse, step in ((printed, jump.height), (ChiaveriniFiltering(), 0.0)):
        before, after = (inverse.matrix(np.diag([1, 0.04, t])) for t in (0.04 - 1e-9, 0.04 + 1e-9))
        assert_allclose(np.linalg.norm(after - before, 2), step, atol=1e-5)
    assert not printed.jumps(1.0)
    assert not printed.jumps(1.0, others=(0.06,))
    assert not ChiaveriniFiltering().jumps(1.0, others=(0.04,))


def test_printed_numerical_filtering_is_unbounded_where_two_directions_vanish_together():
    t = np.array([1e-3, 1e-6, 1e-9])
    J = np.zeros((3, 3, 4))
    J[:, 0, 0], J[:, 1, 1], J[:, 2, 2] = 1, t, t / 2
    norms = {
        name: np.linalg.norm(inverse.matrix(J), 2, axis=(-2, -1))
        for name, inverse in {
            "printed": ChiaveriniFiltering(floor=0.0, multi=False),
            "floored": ChiaveriniFiltering(floor=0.005, multi=False),
            "multi": ChiaveriniFiltering(),
        }.items()
    }
    assert_allclose(norms["printed"], 1 / t, rtol=1e-9)
    assert (norms["floored"] <= 100).all()
    assert (norms["multi"] <= 1).all()
    assert ChiaveriniFiltering(floor=0.0, multi=False).largest_gain(1.0) == np.inf


def test_numerical_filtering_is_safe_unless_asked_otherwise():
    assert ChiaveriniFiltering() == ChiaveriniFiltering(floor=0.0, multi=True)
    assert ChiaveriniFiltering(multi=False) == ChiaveriniFiltering(floor=0.005, multi=False)
    assert ChiaveriniFiltering(multi=False).largest_gain(1.0) == 100


# Identities between filters


@given(spectra, st.floats(1e-3, 0.999))
def test_jparse_is_sigma_over_the_floored_sigma_squared(s, gamma):
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
    assembled = np.where(kept, 1.0, gain * s / (gamma * s[0])) / safe
    assert_allclose(JParse(gamma, gain).gains(s), assembled, rtol=1e-12)


def test_jparse_is_its_assembled_matrices(rng):
    for J in near_singular(rng):
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        kept = s > 0.1 * s[0]
        safe = np.linalg.pinv(U @ np.diag(np.maximum(s, 0.1 * s[0])) @ Vt, rcond=1e-12)
        U_s, Phi = U[:, ~kept], np.diag(2.0 * s[~kept] / (0.1 * s[0]))
        assembled = safe @ U[:, kept] @ U[:, kept].T + safe @ U_s @ Phi @ U_s.T
        assert_allclose(JParse(0.1, 2.0).matrix(J), assembled, atol=1e-12 * np.abs(assembled).max())


@given(spectra, st.floats(1e-3, 0.999))
def test_jparse_is_esrim_with_the_floor_rule_and_a_relative_threshold(s, gamma):
    if gamma * s[0] < 1e-99:
        return
    assert_allclose(JParse(gamma).gains(s), ESRIM(gamma * s[0]).gains(s), rtol=1e-12, atol=1e-300)


@given(spectra, st.floats(1e-3, 0.999))
def test_relative_levels_are_absolute_ones_at_gamma_sigma_max(s, gamma):
    if gamma * s[0] < 1e-99:
        return
    assert_allclose(DulebaClamp(gamma=gamma).gains(s), DulebaClamp(gamma * s[0]).gains(s), rtol=1e-12)
    assert_allclose(TruncatedSVD(gamma=gamma).gains(s), TruncatedSVD(gamma * s[0]).gains(s), rtol=1e-12)


@given(spectra, st.floats(1e-3, 10), st.floats(1e-3, 10))
def test_filtering_each_singular_value_is_chiaverini_for_the_last_one(s, threshold, damping):
    multi, last = ChiaveriniFiltering(threshold, damping), ChiaveriniFiltering(threshold, damping, 0.0, multi=False)
    assert_allclose(multi.gains(s)[-1], Chiaverini(threshold, damping).gains(s)[-1], rtol=1e-12)
    assert_allclose(multi.gains(s)[-1], last.gains(s)[-1], rtol=1e-12)


def test_a_clamp_that_detects_later_than_it_raises_leaves_what_lies_between():
    s = np.array([1.0, 0.02, 0.005, 0.001, 0.0009, 1e-9])
    assert_allclose(DulebaClamp(0.01, detect=0.001).gains(s), [1, 50, 200, 1000, 100, 100])
    assert_allclose(DulebaClamp(0.01).gains(s), [1, 50, 100, 100, 100, 100])


@given(spectra, st.floats(1e-3, 0.999), st.floats(0.1, 5), st.floats(0.25, 4))
def test_the_generalised_jparse_is_a_power_of_the_ratio_to_its_threshold(s, gamma, gain, exponent):
    if s[0] < 1e-100:
        return
    threshold = gamma * s[0]
    expected = np.where(s > threshold, 1.0, gain * (s / threshold) ** (1 / exponent)) / np.maximum(s, threshold)
    assert_allclose(JParse(gamma, gain, exponent).gains(s), expected, rtol=1e-9, atol=1e-300)


def test_the_square_root_variant_of_jparse_rises_with_infinite_slope():
    s = np.array([1e-4, 1e-8, 1e-12])
    assert_allclose(phi(JParse(), s) / s, 100, rtol=1e-12)
    assert_allclose(phi(JParse(exponent=2.0), s) / s, 10 * np.sqrt(10 / s), rtol=1e-12)


@settings(max_examples=50)
@given(st.floats(0.1, 5), st.floats(0.01, 0.5), st.floats(0.2, 3), st.floats(0.3, 3))
def test_jparse_from_limits_keeps_the_joint_speed(speed_limit, task_speed, sigma_max, gain):
    if max(1, gain) * task_speed >= speed_limit * sigma_max:
        with pytest.raises(rik.InputError, match="no gamma < 1 keeps the joint speed below"):
            JParse.from_limits(speed_limit, task_speed, sigma_max, gain)
        return
    inverse = JParse.from_limits(speed_limit, task_speed, sigma_max, gain)
    assert inverse.gain == gain
    assert_allclose(inverse.largest_gain(sigma_max) * task_speed, speed_limit, rtol=1e-12)
    assert inverse.largest_gain(1.5 * sigma_max) * task_speed < speed_limit


# Discrete stability


def test_the_discrete_lyapunov_matrix_is_no_negative_up_to_the_sharp_gain(rng):
    """S = D − (Δt/2) D UᵀKU D ≥ 0 for k_max max(1, p) Δt ≤ 2: no factor m is needed; and no more is allowed."""
    least = np.inf
    for _ in range(300):
        m, p = rng.integers(2, 7), rng.uniform(0.3, 4)
        s = -np.sort(-(10 ** rng.uniform(-3, 0, m)))
        share = s * JParse(0.1, p).gains(s)
        U, K = np.linalg.qr(rng.normal(size=(m, m)))[0], np.diag(rng.uniform(0.1, 5, m))
        D, half_step = np.diag(share), 1 / (K.max() * max(1, p))
        S = D - half_step * D @ U.T @ K @ U @ D
        least = min(least, np.linalg.eigvalsh(S).min())
        assert least > -1e-12
    assert (1.0 - 1.001 * share[0] ** 2 * K.max() / K.max()) < 0  # K = kI, d = 1: beyond the bound it fails


def test_the_task_share_never_exceeds_what_the_stability_bound_allows():
    s = np.geomspace(1e-9, 1, 1001)
    for p in (0.5, 1.0, 3.0):
        share = s * phi(JParse(0.1, p), s)
        assert (share >= 0).all()
        assert_allclose(share.max(), max(1.0, p), rtol=0.05)
        assert share.max() <= max(1.0, p) * (1 + 1e-12)


# Null-space leakage


@pytest.mark.parametrize("inverse", [DampedLeastSquares(0.1), Chiaverini(), JParse(), EDLS(lower=0.1)], ids=repr)
def test_the_projector_made_of_the_inverse_leaks_what_the_inverse_does_not_follow(inverse, rng):
    J, qdot0 = matrix([1, 0.5, 0.02], 3, 6, rng), rng.normal(size=6)
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    leaking = np.eye(6) - inverse.matrix(J) @ J
    expected = U @ ((1 - s * inverse.gains(s)) * s * (Vt @ qdot0))
    assert_allclose(J @ leaking @ qdot0, expected, atol=1e-12)
    assert np.abs(expected).max() > 1e-4
    assert_allclose(J @ null_projector(J) @ qdot0, 0, atol=1e-14)


# Ablations of J-PARSE


def test_projection_and_safety_projection_are_the_same_matrix(rng):
    """Eq. (57) and (59), each assembled as printed."""
    projection, safety = jacobian_projection(0.1), jacobian_safety(0.1)
    both = jacobian_safety_projection(0.1)
    for J in near_singular(rng):
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        kept = s > 0.1 * s[0]
        J_p = U @ np.diag(np.where(kept, s, 0)) @ Vt
        J_s = U @ np.diag(np.maximum(s, 0.1 * s[0])) @ Vt
        pinv_p, pinv_s = np.linalg.pinv(J_p, rcond=1e-9), np.linalg.pinv(J_s, rcond=1e-9)
        scale = 1e-12 * np.abs(pinv_s).max()
        assert_allclose(projection.inverse.matrix(J), pinv_p, atol=scale)
        assert_allclose(safety.inverse.matrix(J), pinv_s, atol=scale)
        assert_allclose(both.inverse.matrix(J), pinv_s @ J_p @ pinv_p, atol=scale)
        identity = np.eye(J.shape[1])
        assert_allclose(projection.null_projector(J), identity - pinv_p @ J_p, atol=1e-12)
        assert_allclose(safety.null_projector(J), identity - pinv_s @ J_s, atol=1e-12)
        assert_allclose(both.null_projector(J), safety.null_projector(J), atol=1e-12)
    assert projection.inverse == both.inverse


def test_only_the_projector_tells_projection_from_safety_projection(rng):
    J, qdot0 = matrix([1, 0.5, 0.05], 3, 6, rng), rng.normal(size=6)
    (_, loose), (_, tight) = jacobian_projection(0.1), jacobian_safety_projection(0.1)
    assert_allclose(np.trace(loose(J)) - np.trace(tight(J)), 1, atol=1e-12)
    assert np.linalg.norm(loose(J) @ qdot0 - tight(J) @ qdot0) > 0.1
    assert np.linalg.norm(J @ loose(J), 2) < 0.05 * (1 + 1e-9)
    healthy = matrix([1, 0.5, 0.2], 3, 6, rng)
    assert_allclose(loose(healthy), tight(healthy), atol=1e-12)
    assert_allclose(loose(np.zeros((2, 3))), np.eye(3))


# The asymmetric EDLS


def diagonal_equation(s, slopes, xdot):
    """J = diag(s), where moving joint i changes σᵢ by slopes[i]."""
    hessian = np.zeros((len(s),) * 3)
    for i, slope in enumerate(slopes):
        hessian[i, i, i] = slope
    return TaskEquation(np.diag(s), np.array(xdot), np.zeros(len(s)), hessian)


def test_asymmetric_edls_damps_only_what_lowers_its_own_singular_value():
    symmetric, asymmetric = EDLS(), EDLS(asymmetric=True, floor=0.05)
    s = np.array([1.0, 0.1, 0.02])
    damped, free = symmetric.gains(s), [1.0, 10.0, 20.0]
    for xdot in ([1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]):
        towards = asymmetric.velocity(diagonal_equation(s, -np.sign(xdot), xdot))
        away = asymmetric.velocity(diagonal_equation(s, np.sign(xdot), xdot))
        assert_allclose(towards, damped * xdot, rtol=1e-12)
        assert_allclose(away, np.multiply(free, xdot), rtol=1e-12)
        assert_allclose(asymmetric.solve(np.diag(s), xdot), damped * xdot, rtol=1e-12)
    mixed = asymmetric.velocity(diagonal_equation(s, [1, -1, 1], [1.0, 1.0, 1.0]))
    assert_allclose(mixed, [free[0], damped[1], free[2]], rtol=1e-12)


def planar_arm(q):
    """Jacobian and Hessian of two unit links in the plane."""
    (s1, s12), (c1, c12) = np.sin([q[0], q.sum()]), np.cos([q[0], q.sum()])
    J = np.array([[-s1 - s12, -s12], [c1 + c12, c12]])
    hessian = np.array([[[-c1 - c12, -c12], [-c12, -c12]], [[-s1 - s12, -s12], [-s12, -s12]]])
    return J, hessian


def test_asymmetric_edls_leaves_the_boundary_of_an_arm_faster_than_it_approaches_it():
    inverse = EDLS(asymmetric=True)
    q = np.array([0.3, 0.1])
    J, hessian = planar_arm(q)
    outwards = np.array([np.cos(q[0] + q[1] / 2), np.sin(q[0] + q[1] / 2)])
    velocity = {sign: inverse.velocity(TaskEquation(J, sign * outwards, np.zeros(2), hessian)) for sign in (1.0, -1.0)}
    assert_allclose(velocity[-1.0], np.linalg.inv(J) @ -outwards, rtol=1e-3)
    assert np.linalg.norm(velocity[1.0]) < 0.6 * np.linalg.norm(velocity[-1.0])
    smallest = {sign: np.linalg.norm(planar_arm(q + 1e-6 * v)[0], -2) for sign, v in velocity.items()}
    assert smallest[1.0] < np.linalg.norm(J, -2) < smallest[-1.0]


def test_asymmetric_edls_declares_a_bound_that_holds_for_its_velocity(rng):
    for inverse in (EDLS(asymmetric=True, floor=0.02), EDLS(asymmetric=True, floor=0.5)):
        speeds = []
        for _ in range(300):
            s = -np.sort(-(10 ** rng.uniform(-4, 0.3, 3)))
            xdot = rng.normal(size=3)
            qdot = inverse.velocity(diagonal_equation(s, rng.normal(size=3), xdot / np.linalg.norm(xdot)))
            speeds.append(np.linalg.norm(qdot) / inverse.largest_gain(s[0]))
        assert max(speeds) <= 1 + 1e-12
        assert max(speeds) > 0.7
    assert EDLS(asymmetric=True, floor=0.02).largest_gain(1.0) == 50
    assert_allclose(EDLS(asymmetric=True, floor=0.5).largest_gain(1.0), 13.04, rtol=1e-5)


def test_asymmetric_edls_says_that_it_needs_the_hessian():
    inverse = EDLS(asymmetric=True)
    assert inverse.needs_hessian
    assert not EDLS().needs_hessian
    assert not MoorePenrose().needs_hessian
    with pytest.raises(rik.InputError, match="needs the equation's Hessian"):
        inverse.velocity(TaskEquation(np.eye(2), np.ones(2), np.zeros(2)))
    equation = diagonal_equation([1.0, 0.1], [1, -1], [1.0, 1.0])
    assert_allclose(EDLS().velocity(equation), EDLS().solve(np.diag([1.0, 0.1]), [1, 1]))


@pytest.mark.parametrize("lower, rests_at", [(0.1, 0.2241), (0.0, None)])
def test_edls_rests_off_the_boundary_or_chatters_on_it(lower, rests_at):
    """The planar arm of J-PARSE, told to reach 0.2 too far: k = 0.1, Δt = 0.01, 80 s."""
    inverse, q, target = EDLS(lower=lower), np.array([-np.pi / 4, np.pi / 4]), 1.1 * np.sqrt(2) * np.ones(2)
    elbow = []
    for _ in range(8000):
        tip = np.array([np.cos(q[0]) + np.cos(q.sum()), np.sin(q[0]) + np.sin(q.sum())])
        error = target - tip
        error = error / max(1.0, np.linalg.norm(error))
        q = q + 0.01 * inverse.solve(planar_arm(q)[0], 0.1 * error)
        elbow.append(q[1])
    changes = np.count_nonzero(np.diff(np.sign(elbow)))
    if rests_at is None:
        assert 3990 < changes < 4010
    else:
        assert changes == 0
        assert_allclose(elbow[-1], rests_at, atol=1e-4)
        assert_allclose(2 - 2 * np.cos(elbow[-1] / 2), 1.26e-2, rtol=5e-3)


# What is refused


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: DampedLeastSquares(0.0), "damping must be > 0, got 0"),
        (lambda: DampedLeastSquares(-1), "damping must be > 0, got -1"),
        (lambda: DampedLeastSquares(np.nan), "damping must be > 0, got nan"),
        (lambda: DampedLeastSquares("much"), "damping must be > 0, got 'much'"),
        (lambda: MoorePenrose(tolerance=0.0), "tolerance must be > 0 and < 1"),
        (lambda: MoorePenrose(tolerance=2.0), "tolerance must be > 0 and < 1"),
        (lambda: TruncatedSVD(0.1, 0.1), "give threshold or gamma, not both: got threshold=0.1 and gamma=0.1"),
        (lambda: TruncatedSVD(0.0), "threshold must be > 0"),
        (lambda: TruncatedSVD(gamma=1.0), "gamma must be > 0 and < 1, got 1.0"),
        (lambda: DulebaClamp(0.1, gamma=0.1), "give floor or gamma, not both"),
        (lambda: DulebaClamp(-0.1), "floor must be > 0, got -0.1"),
        (lambda: DulebaClamp(gamma=1.5), "gamma must be > 0 and < 1, got 1.5"),
        (lambda: DulebaClamp(0.01, detect=0.02), "detect must be ≤ floor, got detect=0.02 and floor=0.01"),
        (lambda: DulebaClamp(0.01, detect=0.0), "detect must be > 0"),
        (lambda: DulebaClamp(gamma=0.1, detect=0.01), "detect goes with floor, not with gamma"),
        (lambda: NakamuraHanafusa(damping=-0.1), "damping must be > 0, got -0.1"),
        (lambda: NakamuraHanafusa(manipulability_threshold=0), "manipulability_threshold must be > 0"),
        (lambda: NakamuraHanafusa().largest_gain(1.0, 0), "count must be ≥ 1, got 0"),
        (lambda: Chiaverini(threshold=0.0), "threshold must be > 0"),
        (lambda: Chiaverini(damping=0.0), "damping must be > 0"),
        (lambda: ChiaveriniFiltering(threshold=-1.0), "threshold must be > 0"),
        (lambda: ChiaveriniFiltering(damping=np.inf), "damping must be > 0, got inf"),
        (lambda: ChiaveriniFiltering(floor=-0.1), "floor must be ≥ 0, got -0.1"),
        (lambda: EDLS(beta=1.0), "beta must be > 0 and < 1, got 1.0"),
        (lambda: EDLS(beta=0.0), "beta must be > 0 and < 1"),
        (lambda: EDLS(lower=-0.1), "lower must be ≥ 0, got -0.1"),
        (lambda: EDLS(lower=0.5), "lower must be < upper, got lower=0.5 and upper=0.3"),
        (lambda: EDLS(lower=0.3, upper=0.3), "lower must be < upper"),
        (lambda: EDLS(upper=np.nan), "upper must be finite, got nan"),
        (lambda: EDLS(floor=0.0), "floor must be > 0"),
        (lambda: ESRIM(0.0), "sigma0 must be > 0"),
        (lambda: ESRIM(0.1, -1.0), "alpha0 must be > 0, got -1.0"),
        (lambda: ESRIM(beta_rule="step"), "beta_rule must be one of floor, linear, chiaverini, got 'step'"),
        (lambda: ESRIM(alpha_mode="matrix"), "alpha_mode must be one of scalar, singular, got 'matrix'"),
        (lambda: ESRIM(beta_rule="chiaverini"), "damping must be > 0, got None"),
        (lambda: ESRIM(damping=0.1), 'damping goes with beta_rule="chiaverini" only, got 0.1'),
        (lambda: Sigmoid(squared_damping=0.0), "squared_damping must be > 0"),
        (lambda: Sigmoid(shift=-0.1), "shift must be ≥ 0, got -0.1"),
        (lambda: Sigmoid(slope=0.0), "slope must be > 0"),
        (lambda: JParse(gamma=1.0), "gamma must be > 0 and < 1, got 1.0"),
        (lambda: JParse(gamma=0.0), "gamma must be > 0 and < 1"),
        (lambda: JParse(gain=0.0), "gain must be > 0"),
        (lambda: JParse(exponent=0.0), "exponent must be > 0"),
        (lambda: JParse.from_limits(0.0, 1.0), "speed_limit must be > 0"),
        (lambda: JParse.from_limits(1.0, -1.0), "task_speed must be > 0"),
        (lambda: JParse.from_limits(1.0, 0.1, 0.0), "sigma_max_lower_bound must be > 0"),
        (lambda: JParse.from_limits(1.0, 1.0), "it would take gamma = 1; allow more joint speed"),
        (lambda: jacobian_projection(1.0), "gamma must be > 0 and < 1"),
        (lambda: jacobian_safety(0.0), "gamma must be > 0 and < 1"),
    ],
)
def test_a_parameter_out_of_range_is_refused_and_the_range_said(make, match):
    with pytest.raises(rik.InputError, match=match):
        make()


def test_the_default_tolerance_counts_rounding_as_zero(rng):
    for _ in range(200):
        J = matrix([1, 0.5, 0.0], 3, 3, rng)
        assert np.linalg.norm(MoorePenrose().matrix(J), 2) < 2.1
    assert RANK_TOLERANCE <= 1e-12


def test_a_sigmoid_that_damps_nothing_is_refused():
    with pytest.raises(rik.InputError, match="at most 600 times slope"):
        Sigmoid(shift=1.0, slope=1e-3)


@pytest.mark.parametrize("squared", [True, False])
def test_the_bound_of_adaptive_damping_holds_where_w_rounds_at_its_threshold(squared):
    inverse = NakamuraHanafusa(squared=squared)
    for sigma_max, count in [(5000.0, 6), (2.0, 6), (50.0, 4)]:
        undamped = inverse.manipulability_threshold / sigma_max ** (count - 1)
        met = inverse.gains([sigma_max] * (count - 1) + [undamped * 1.000001])[-1]
        assert met <= inverse.largest_gain(sigma_max, count) * (1 + 1e-9)
        assert inverse.largest_gain(sigma_max, count) >= 0.99 / undamped


def test_a_product_of_singular_values_that_overflows_is_beyond_every_threshold():
    for inverse in (NakamuraHanafusa(), NakamuraHanafusa(squared=False)):
        for s in ([1e154, 0.9e154], [1e150, 1e150, 1e150], [1e300, 3e7]):
            assert_allclose(inverse.gains(s) * s, 1.0)
