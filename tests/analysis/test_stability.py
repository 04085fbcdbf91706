"""What is said about a control loop before it runs, against loops that do run."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik import InputError, load, null_projector, svd
from robust_ik.analysis import stability
from robust_ik.inverses import (
    DampedLeastSquares,
    DulebaClamp,
    JParse,
    MoorePenrose,
    SingularValueFilter,
    TruncatedSVD,
    Weighted,
)
from tests.kinematics.test_svd import matrix


# ------------------------------------------------------------------------------------------------ targets in reach
class Bump(SingularValueFilter):
    """4(1 − σ): σφ(σ) has its peak, 1, between the ends."""

    def gains(self, s):
        return 4 * (1 - s)

    def largest_gain(self, sigma_max):
        return 4.0

    def is_exact(self, s):
        return s == 0.5


@pytest.mark.parametrize(
    "inverse, sigma_max, expected",
    [
        (JParse(), 3.0, 1.0),
        (JParse(gain=0.2), 3.0, 1.0),
        (JParse(gain=2.5), 0.1, 2.5),
        (DampedLeastSquares(0.5), 1.0, 0.8),
        (DampedLeastSquares(0.5), 100.0, 1e4 / (1e4 + 0.25)),
        (MoorePenrose(), 1.0, 1.0),
        (DulebaClamp(floor=0.1), 2.0, 1.0),
        (Bump(), 0.9, 1.0),
        (TruncatedSVD(threshold=0.1), 2.0, 1.0),
        (TruncatedSVD(threshold=0.1), 0.05, 0.0),
    ],
)
def test_the_largest_share_is_the_supremum_of_sigma_phi(inverse, sigma_max, expected):
    assert_allclose(stability.largest_share(inverse, sigma_max), expected, rtol=1e-11)


def test_the_sharp_gain_never_lets_v_grow_and_the_papers_is_m_times_smaller(rng):
    """P9: S ≥ 0 at equality for 500 random J, K and p; 1 % more gain breaks it for K = kI."""
    for _ in range(500):
        m = int(rng.integers(1, 7))
        inverse, dt = JParse(gamma=rng.uniform(0.05, 0.9), gain=rng.uniform(0.2, 4)), rng.uniform(1e-3, 1)
        J = matrix(np.sort(rng.uniform(0, 2, m))[::-1], m, m + int(rng.integers(0, 3)), rng)
        k = stability.largest_stable_gain(inverse, dt, 2.0)
        assert_allclose(k, 2 / (max(1, inverse.gain) * dt), rtol=1e-9)
        K = rng.uniform(0.01, 1, m) * k
        K[rng.integers(m)] = k
        S = stability.decrease_matrix(inverse, J, K, dt)
        assert np.linalg.eigvalsh(S).min() >= -1e-9
    assert_allclose(stability.conservative_gain(JParse(gain=2), 0.1, 6, 2.0), 10 / 6, rtol=1e-9)
    S = stability.decrease_matrix(JParse(), np.eye(2, 3), 1.01 * stability.largest_stable_gain(JParse(), 0.1, 1.0), 0.1)
    assert np.linalg.eigvalsh(S).min() < -1e-3


def test_the_printed_bound_would_be_unstable_for_a_small_gain_along_singular_directions():
    """(67) with p = 0.1 in place of max(1, p): k = 2/(m p Δt) makes the regular directions blow up for m = 2."""
    dt, m, p = 0.1, 2, 0.1
    printed = 2 / (m * p * dt)
    assert np.abs(stability.error_factors(JParse(gain=p), np.eye(2), printed, dt)).max() == 9
    ours = stability.conservative_gain(JParse(gain=p), dt, m, 1.0)
    assert np.abs(stability.error_factors(JParse(gain=p), np.eye(2), ours, dt)).max() < 1


@pytest.mark.parametrize(
    "inverse", [JParse(), JParse(gain=3.0), DampedLeastSquares(0.3), DulebaClamp(floor=0.1)], ids=repr
)
def test_the_decrease_matrix_says_by_how_much_v_changes_in_one_step(inverse, rng):
    for m, n in [(1, 1), (3, 3), (3, 7), (6, 4)]:
        J, error = rng.normal(size=(5, m, n)), rng.normal(size=(5, m))
        K, dt = rng.uniform(0.5, 3, m), 0.2
        after = error - dt * np.einsum("bij,bj->bi", J, inverse.solve(J, K * error))
        change = stability.lyapunov(after, K) - stability.lyapunov(error, K)
        S = stability.decrease_matrix(inverse, J, K, dt)
        assert_allclose(change, -dt * np.einsum("bi,bij,bj->b", K * error, S, K * error), atol=1e-12)
        rate = stability.lyapunov_rate(inverse, J, error, K)
        assert (rate <= 0).all()
        assert_allclose(rate, -np.sum((K * error) * np.einsum("bij,bj->bi", J, inverse.solve(J, K * error)), -1))


def test_the_weighted_v_falls_in_continuous_time_where_the_plain_one_rises(rng):
    K, inverse = np.array([9.0, 1.0]), JParse(gamma=0.5)
    J = np.array([[1, -1], [1, 1]]) / np.sqrt(2) @ np.diag([1, 0.05])
    plain_rose = 0
    for error in rng.normal(size=(200, 2)):
        rate = -J @ inverse.solve(J, K * error)
        small = 1e-7
        weighted = stability.lyapunov(error + small * rate, K) - stability.lyapunov(error, K)
        assert weighted < 0
        assert_allclose(weighted / small, stability.lyapunov_rate(inverse, J, error, K), rtol=1e-4, atol=1e-6)
        plain_rose += error @ rate > 1e-3
    assert plain_rose > 10


@pytest.mark.parametrize("inverse", [JParse(gain=2.0), DampedLeastSquares(0.3), MoorePenrose()], ids=repr)
def test_the_error_factors_are_the_eigenvalues_of_one_step(inverse, rng):
    for m, n in [(3, 3), (2, 5), (4, 2)]:
        J, k, dt = rng.normal(size=(m, n)), 3.0, 0.1
        step = np.eye(m) - dt * k * J @ inverse.matrix(J)
        factors = np.concatenate([stability.error_factors(inverse, J, k, dt), np.ones(max(m - n, 0))])
        assert_allclose(np.sort(factors), np.sort(np.linalg.eigvalsh((step + step.T) / 2)), atol=1e-12)


def test_a_loop_converges_just_below_the_largest_stable_step_and_diverges_just_above():
    inverse, K = JParse(gain=2.0, gamma=0.5), 4.0
    J = np.diag([1.0, 0.5])  # at the threshold, where σφ = p
    dt = stability.largest_stable_dt(inverse, K, 1.0)
    assert_allclose(dt, 0.25)
    assert_allclose(stability.largest_stable_dt(inverse, [1.0, K], 1.0), 0.25)
    for factor, grows in [(0.99, False), (1.01, True)]:
        error = np.array([0.0, 1.0])
        for _ in range(500):
            error = error - factor * dt * J @ inverse.solve(J, K * error)
        assert (np.linalg.norm(error) > 1) == grows


def test_i_minus_j_sharp_j_leaks_and_the_exact_projector_does_not(rng):
    J = rng.normal(size=(4, 3, 7))
    for inverse in (DampedLeastSquares(0.1), JParse(gamma=0.5), MoorePenrose()):
        leaking = np.eye(7) - inverse.matrix(J) @ J
        assert_allclose(stability.projector_leak(inverse, J), np.linalg.norm(J @ leaking, 2, (-2, -1)), atol=1e-12)
    assert_allclose(J @ null_projector(J), 0, atol=1e-12)
    assert_allclose(stability.projector_leak(DampedLeastSquares(0.1), 0.1 * np.eye(2)), 0.05)


def test_a_leaking_projector_holds_the_task_off_its_target_and_the_exact_one_does_not():
    inverse, q0 = DampedLeastSquares(0.1), np.array([0.3, -0.2])
    J = np.array([[1.0, 0.5]])
    for projector, rests in [(np.eye(2) - inverse.matrix(J) @ J, False), (null_projector(J), True)]:
        error = np.array([0.0])
        for _ in range(2000):
            error = error - 0.05 * J @ (inverse.solve(J, 2 * error) + projector @ q0)
        assert (abs(error[0]) < 1e-12) == rests


def test_the_largest_share_does_not_depend_on_the_scale_of_a_relative_filter():
    for sigma_max in (1e-6, 1.0, 1e6):
        assert_allclose(stability.largest_share(JParse(gain=3.0), sigma_max), 3, rtol=1e-9)


# ------------------------------------------------------------------------------------------------ unequal gains
@pytest.mark.parametrize(
    "k_p, k_o, safe", [(9, 1, True), (9.2, 1, False), (9.5, 1, False), (15, 1, False), (15, 15, True), (1, 9, True)]
)
def test_the_rule_for_unequal_gains_is_the_eigenvalue_test_over_all_directions(k_p, k_o, safe):
    assert stability.block_gains_are_stable(k_p, k_o) == safe
    angle = np.linspace(0, np.pi, 20001)
    u = np.zeros((angle.size, 6))
    u[:, 1], u[:, 4] = np.cos(angle), np.sin(angle)
    smallest = stability.smallest_eigenvalue_along(u, [k_p] * 3 + [k_o] * 3).min()
    assert (smallest >= -1e-9) == safe
    if (k_p, k_o) in [(9, 1), (1, 9)]:
        assert_allclose(smallest, 0, atol=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0, 2.0])
def test_the_smallest_eigenvalue_is_negative_exactly_where_d_b_squared_exceeds_four_a(share, rng):
    gains = np.array([12.0, 12, 12, 1, 1, 1])
    u = rng.normal(size=(300, 6))
    unit = u / np.linalg.norm(u, axis=-1, keepdims=True)
    a = np.sum(gains * unit**2, axis=-1)
    b = np.linalg.norm(gains * unit - a[:, None] * unit, axis=-1)
    assert ((stability.smallest_eigenvalue_along(u, gains, share) < -1e-12) == (share * b**2 > 4 * a)).all()
    assert stability.block_gains_are_stable(12, 1, 0.3)
    assert not stability.block_gains_are_stable(12, 1, 1.0)


def test_the_rule_does_not_cover_two_singular_directions():
    """K_s = diag(4, 1) keeps the rule; but d = (1, 0.001) in its plane makes the symmetric part indefinite."""
    assert stability.block_gains_are_stable(4, 1)
    U = np.array([[1, -1], [1, 1]]) / np.sqrt(2)
    G = U @ np.diag([1, 1e-3]) @ U.T @ np.diag([4, 1])
    assert_allclose(np.linalg.det((G + G.T) / 2), -((4 - 1) ** 2) / 16, rtol=0.02)  # b = (k_p − k_o)/2: −b²/4


# ------------------------------------------------------------------------------------------------ targets out of reach
@pytest.mark.parametrize(
    "inverse, sigma_max, at_zero, steepest",
    [
        (DampedLeastSquares(0.01), 2.0, 1e4, 1e4),
        (DampedLeastSquares(3.0), 2.0, 1 / 9, 1 / 9),
        (JParse(gamma=0.1, gain=1.0), 2.0, 25.0, 25.0),
        (JParse(gamma=0.1, gain=3.0), 2.0, 75.0, 75.0),
        (JParse(gamma=0.1, gain=0.5), 2.0, 12.5, 25.0),
        (DulebaClamp(floor=0.1), 2.0, np.inf, np.inf),
        (TruncatedSVD(threshold=0.1), 2.0, 0.0, 100.0),
    ],
)
def test_slopes_of_known_filters(inverse, sigma_max, at_zero, steepest):
    assert_allclose(stability.slope_at_zero(inverse, sigma_max), at_zero, rtol=1e-9)
    assert_allclose(stability.steepest_slope(inverse, sigma_max), steepest, rtol=1e-6)


def test_a_gain_that_vanishes_like_the_root_of_sigma_has_an_infinite_slope():
    class Root(Bump):
        def gains(self, s):
            return np.sqrt(s)

    assert stability.slope_at_zero(Root(), 1.0) == np.inf
    assert stability.steepest_slope(Root(), 1.0) == np.inf


def test_the_sigma_rate_is_the_slope_of_the_smallest_singular_value_along_its_own_v(rng):
    J, hessian = rng.normal(size=(8, 3, 5)), rng.normal(size=(8, 3, 5, 5))
    along = np.einsum("bijk,bk->bij", hessian, svd(J).Vt[:, -1])
    slope = (svd(J + 1e-6 * along).s - svd(J - 1e-6 * along).s)[:, -1] / 2e-6
    assert_allclose(stability.sigma_rate(J, hessian), np.abs(slope), atol=1e-6)


def two_r(q):
    """Position, Jacobian and Hessian of the planar 2R arm with unit links."""
    (s1, s12), (c1, c12) = np.sin([q[0], q[0] + q[1]]), np.cos([q[0], q[0] + q[1]])
    J = np.array([[-s1 - s12, -s12], [c1 + c12, c12]])
    hessian = np.array([[[-c1 - c12, -c12], [-c12, -c12]], [[-s1 - s12, -s12], [-s12, -s12]]])
    return np.array([c1 + c12, s1 + s12]), J, hessian


def stretch(inverse, dt, steps, q2=0.05):
    """q₂ over time while the 2R arm reaches for a target 0.2 beyond its boundary with k = 0.1."""
    q, target, seen = np.array([np.pi / 4 - q2 / 2, q2]), 1.1 * np.sqrt(2) * np.ones(2), []
    for _ in range(steps):
        x, J, _ = two_r(q)
        q = q + dt * inverse.solve(J, 0.1 * (target - x))
        seen.append(q[1])
    return np.array(seen)


def test_the_critical_step_of_the_stretched_2r_arm():
    """G7: 0.0250 s for λ = 0.01; at rest below it, 4.5e-3 rad of swing above."""
    inverse = DampedLeastSquares(0.01)
    _, J, hessian = two_r([np.pi / 4, 0.0])
    rate = float(stability.sigma_rate(J, hessian))
    assert_allclose(rate, 0.4, atol=1e-12)
    sigma_max = svd(J).s[0]
    assert_allclose(sigma_max, np.sqrt(5))
    critical = stability.critical_dt(stability.slope_at_zero(inverse, sigma_max), rate, 0.02)
    assert_allclose(critical, 0.025, rtol=1e-9)
    assert np.abs(stretch(inverse, 0.024, 1500)[-10:]).max() < 1e-7
    swing = np.abs(stretch(inverse, 0.026, 1500)[-10:])
    assert_allclose(swing, 4.5e-3, rtol=0.01)
    predicted = stability.limit_cycle_amplitude(inverse, sigma_max, dt=0.026, rate=rate, lost_speed=0.02)
    assert_allclose(swing, predicted * 2 / np.sqrt(5), rtol=2e-3)  # q₂ is 2/√5 of the unit vector v
    assert_allclose(predicted, np.sqrt(0.026 * 0.02 * rate / 2 - 1e-4) / rate, rtol=1e-6)
    assert stability.limit_cycle_amplitude(inverse, sigma_max, dt=0.024, rate=rate, lost_speed=0.02) == 0


def test_the_clamped_2r_arm_swings_with_the_predicted_amplitude():
    _, J, hessian = two_r([np.pi / 4, 0.0])
    rate, dt = float(stability.sigma_rate(J, hessian)), 0.01
    q2 = stretch(DulebaClamp(floor=0.1), dt, 3000, q2=0.0333)[-400:]
    predicted = stability.limit_cycle_amplitude(DulebaClamp(floor=0.1), np.sqrt(5), dt=dt, rate=rate, lost_speed=0.02)
    assert_allclose(predicted, dt * 10 * 0.02 / 2, rtol=1e-6)
    assert_allclose(np.ptp(q2) / 2, predicted * 2 / np.sqrt(5), rtol=0.02)
    assert (q2[:-1] * q2[1:] < 0).all()


def scalar_swing(inverse, dt, y, rate=0.4, lost_speed=0.02, steps=3000):
    seen = [y]
    for _ in range(steps):
        sigma = min(rate * abs(y), 1.0)
        y = y - dt * lost_speed * inverse.gains(np.array([1.0, sigma]))[1] * np.sign(y)
        seen.append(y)
    return np.abs(seen)


@pytest.mark.parametrize(
    "inverse", [DampedLeastSquares(0.01), JParse(0.1), JParse(0.1, gain=0.3), TruncatedSVD(threshold=0.1)], ids=repr
)
def test_no_swing_grows_below_the_step_of_the_steepest_slope(inverse, rng):
    dt = stability.critical_dt(stability.steepest_slope(inverse, 1.0), 0.4, 0.02)
    for y in 10.0 ** rng.uniform(-6, 0, 20):
        swing = scalar_swing(inverse, 0.99 * dt, y, steps=60)
        assert (np.diff(swing) <= 0).all()
    if stability.slope_at_zero(inverse, 1.0):
        local = stability.critical_dt(stability.slope_at_zero(inverse, 1.0), 0.4, 0.02)
        assert scalar_swing(inverse, 1.02 * local, 1e-8, steps=60)[-1] > 2e-8


def test_below_the_local_critical_step_a_large_swing_may_still_persist():
    """J-PARSE with p = 0.01: φ'(0) is a hundred times less than the steepest φ/σ, at the threshold."""
    inverse = JParse(0.1, gain=0.01)
    local = stability.critical_dt(stability.slope_at_zero(inverse, 1.0), 0.4, 0.02)
    cycle = stability.limit_cycle_amplitude(inverse, 1.0, dt=0.2 * local, rate=0.4, lost_speed=0.02)
    assert cycle > 0.1 / 0.4
    assert_allclose(scalar_swing(inverse, 0.2 * local, cycle, steps=10), cycle, rtol=1e-3)
    assert scalar_swing(inverse, 0.2 * local, 1e-3, steps=60)[-1] < 1e-7


def test_where_nothing_pulls_nothing_swings():
    assert stability.critical_dt(1e4, 0.4, 0.0) == np.inf
    assert stability.critical_dt(0.0, 0.4, 0.02) == np.inf
    assert stability.critical_dt(2.0, 0.5, -0.5) == stability.critical_dt(2.0, 0.5, 0.5) == 4
    assert stability.critical_dt(np.inf, 0.4, 0.02) == 0
    assert stability.limit_cycle_amplitude(DulebaClamp(floor=0.1), 1.0, dt=0.1, rate=0.4, lost_speed=0.0) == 0
    assert stability.limit_cycle_amplitude(MoorePenrose(), 1.0, dt=1e9, rate=0.4, lost_speed=1.0) == np.inf


@pytest.mark.parametrize(
    "call, match",
    [
        (lambda: stability.largest_stable_gain(JParse(), 0.0, 1.0), "dt must be > 0"),
        (lambda: stability.largest_stable_gain(JParse(), 0.1, 0.0), "sigma_max must be > 0"),
        (lambda: stability.largest_stable_dt(JParse(), [1, -1], 1.0), "gain must be one number > 0"),
        (lambda: stability.lyapunov([1, 2, 3], [1, 2]), "gain must have one entry or 3"),
        (lambda: stability.lyapunov_rate(JParse(), np.eye(2), [1, 2, 3], 1.0), "error must have shape"),
        (lambda: stability.decrease_matrix(JParse(), np.eye(2), [1, 2, 3], 0.1), "gain must have one entry or 2"),
        (lambda: stability.conservative_gain(JParse(), 0.1, 0, 1.0), "rows must be ≥ 1"),
        (lambda: stability.critical_dt(-1.0, 1.0, 1.0), "slope must be ≥ 0"),
        (lambda: stability.critical_dt(1.0, 1.0, np.nan), "lost_speed must be finite"),
        (lambda: stability.block_gains_are_stable(0, 1), "position_gain must be > 0"),
        (lambda: stability.smallest_eigenvalue_along([0, 0], [1, 1]), "u must not be zero"),
        (lambda: stability.smallest_eigenvalue_along([1, 0], [1, 1, 1]), "one entry or 2"),
    ],
)
def test_what_cannot_be_meant_is_refused(call, match):
    with pytest.raises(InputError, match=match):
        call()


def test_the_bounds_take_what_sigma_rate_gives():
    robot = load("planar_2r")
    q = np.array([0.3, 0.0])
    rate = stability.sigma_rate(robot.jacobian(q), robot.hessian(q))
    slope = stability.slope_at_zero(DampedLeastSquares(0.01), 2.236)
    assert stability.critical_dt(slope, rate, 0.02) > 0


def test_what_has_no_gain_is_refused_and_what_gives_nothing_is_always_stable():
    with pytest.raises(InputError, match="must be a SingularValueFilter, got Weighted"):
        stability.largest_stable_gain(Weighted(JParse()), 0.01, 1.0)
    with pytest.raises(InputError, match="must be a SingularValueFilter, got Weighted"):
        stability.slope_at_zero(Weighted(JParse()), 1.0)
    assert stability.largest_stable_gain(TruncatedSVD(threshold=2.0), 0.01, 1.0) == np.inf
