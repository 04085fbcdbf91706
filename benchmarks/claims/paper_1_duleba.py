"""Dułęba 2023: singularity-robust inverse kinematics for serial manipulators."""

from __future__ import annotations

from functools import cache
from timeit import repeat

import numpy as np

import robust_ik as rik
from benchmarks.claims.claim import TypedClaim as Claim
from robust_ik import evaluation
from robust_ik.checks import Array
from robust_ik.scenarios import reach_points

ONE, TWO = "Algorithm 1", "Algorithm 2"
TIMES = np.linspace(0, 2, 11)
FLOOR, DETECT, DELTA = 1e-2, 1e-3, 1e-9
RAMP = np.append(np.ones((5000, 2)), np.geomspace(1e-5, 1, 5000)[:, None], axis=1)
"""Spectra (1, 1, σ) with σ from far below d_min to far above."""


def claims() -> list[Claim]:
    """Every claim, section by section."""
    return [*additive(), *other_inverses(), *criteria(), *simulation(), *at_the_end(), *directions(), *puma()]


@cache
def axis() -> rik.Scenario:
    return rik.load_scenario("duleba_axis")


@cache
def followed(label: str, cap: int = 10_000) -> tuple[rik.NewtonResult, ...]:
    """Path (37) at 11 points, ξ = 1."""
    return reach_points(axis(), label, tuple(TIMES), tolerance=DELTA, max_iterations=cap)


def sigma(q: Array) -> Array:
    return rik.svd(axis().robot.jacobian(q)).s


def additive() -> list[Claim]:
    rng = np.random.default_rng(0)
    B = rng.normal(size=(1000, 3, 3))
    A, M = B @ np.swapaxes(B, -1, -2) + 0.1 * np.eye(3), B[..., :2] @ np.swapaxes(B[..., :2], -1, -2)
    least = evaluation.determinant_excess(A, M).min()
    single = float(evaluation.determinant_excess([[2.0]], [[3.0]]))
    J, S = rng.normal(size=(3, 4)), np.diag([1000.0, 1.0, 0.1])
    xdot = rng.normal(size=3)

    def change(variant: str) -> float:
        inverse = rik.DulebaAdditive(1e-2, variant)
        return float(np.linalg.norm(inverse.solve(S @ J, S @ xdot) - inverse.solve(J, xdot)))

    return [
        Claim(
            "(7) det(A + M) > det A + det M for every M ≠ 0", "always",
            f"least excess of 1000 draws with m = 3: {least:.1g}; with m = 1: {single:.0f}", "wrong",
            "m ≥ 2 is needed too; for one row both sides are equal",
        ),
        Claim(
            "(12) suits the rows of J, which (11) treats alike", "no number",
            f"units of rows changed: q̇ moves by {change('scaled'):.0e} with (12), {change('plain'):.0e} with (11)",
            "holds", "P(SJ) S = P(J) for diagonal S > 0",
        ),
    ]  # fmt: skip


def other_inverses() -> list[Claim]:
    rng = np.random.default_rng(1)
    J = np.outer(*rng.normal(size=(2, 2)))
    fatal = float(evaluation.fatal_dampings(J)[0])
    left = abs(np.linalg.det(J + fatal * np.eye(2)))
    K = rng.normal(size=(3, 4))
    U, D2 = rik.svd(K).U, np.diag(rik.svd(K).s ** 2)
    right, printed = (float(np.abs(U @ D2 @ last - K @ K.T).max()) for last in (U.T, U))
    W = np.diag([1.0, 2, 3, 4])
    qdot = rik.Weighted(rik.MoorePenrose(), joint_weights=np.diag(W)).solve(K, K[:, 0])
    null = rik.lost_directions(K.T)[:, 0]
    rise = min((qdot + h * null) @ W @ (qdot + h * null) - qdot @ W @ qdot for h in (-1e-3, 1e-3))
    possible = evaluation.allows_multiplicative_inverse(3, 4, 1)
    return [
        Claim("(19) fails for n = 4, m = 3, c = 1", "not satisfied", "satisfied" if possible else "not satisfied",
              "holds", "the null space has 2 dimensions, Ψ needs 3"),
        Claim("(23) M = U D² U", "as printed", f"error {printed:.1f}; with Uᵀ at the end {right:.0e}", "wrong",
              "misprint: the last factor is Uᵀ"),
        Claim("(44) det(J + λI) may vanish for λ ≠ 0", "may", f"at λ = −tr J it is {left:.0e}", "holds",
              "damp J Jᵀ, never J"),
        Claim("(45) comes from maximising J q̇ at fixed q̇ᵀWq̇", "maximum",
              f"leaving it inside the null space raises q̇ᵀWq̇ by at least {rise:.0e}", "holds in kind",
              "true along a given direction of ẋ; it is the least q̇ᵀWq̇ among all q̇ with J q̇ = ẋ"),
    ]  # fmt: skip


def criteria() -> list[Claim]:
    rng = np.random.default_rng(2)
    s = -np.sort(-np.append(rng.uniform(FLOOR, 1, (10_000, 2)), rng.uniform(0, FLOOR, (10_000, 1)), axis=1))
    both = evaluation.compare_damping_and_clamp(s[..., None] * np.eye(3), FLOOR)
    full = evaluation.compare_damping_and_clamp(np.zeros((3, 3)), FLOOR)
    gain = {
        name: FLOOR * float(inverse.gains(RAMP)[:, -1].max())
        for name, inverse in {
            ONE: evaluation.DulebaMatched(FLOOR), TWO: rik.DulebaClamp(FLOOR), "equal": rik.DampedLeastSquares(FLOOR)
        }.items()
    }  # fmt: skip
    six = FLOOR * evaluation.DulebaMatched(FLOOR).peak(6)
    J = rng.normal(size=(6, 6))
    damping, xdot = 1e-4 * np.eye(6), J[:, 0]
    decomposing, solving = (
        min(repeat(each, number=200, repeat=20))
        for each in (lambda: np.linalg.svd(J), lambda: J.T @ np.linalg.solve(J @ J.T + damping, xdot))
    )
    return [
        Claim("(30), (31) for f₁ = f₂ the clamp gets farther: h₁ < h₂", "always, c < m",
              f"in {np.mean(both.damped < both.clamped):.0%} of 10⁴ draws; "
              f"at c = m = 3 h₁/h₂ = {full.damped / full.clamped:.2f}",
              "holds", "h₂ − h₁ = (1 − c/m) d_min² at exact corank c"),
        Claim("(41) ‖Δq‖ ≤ ν/d_min after the cure", "bound of the clamp",
              f"largest gain × d_min: clamp {gain[TWO]:.2f}, matched damping {gain[ONE]:.2f}, with six rows {six:.2f}",
              "holds", "for the clamp only: the damping with f₁ = f₂ exceeds it from three rows on"),
        Claim("question 3: the SVD method computes least", "as detection is shared",
              f"6 × 6: one SVD takes {decomposing / solving:.0f} times as long as a solution with J Jᵀ + λI",
              "holds in kind",
              "if singularities are detected by an SVD anyway; constant damping needs no detection"),
        Claim("Conclusion: the clamp is the best, and lowers joint speeds", "for equal modification",
              f"for equal safety, λ = d_min², (11) has {gain['equal'] / gain[TWO]:.2f} of the clamp's largest gain",
              "open", "which one wins depends on what is held equal; and only the clamp jumps at σ = 0"),
    ]  # fmt: skip


def simulation() -> list[Claim]:
    coranks = [int(rik.svd(axis().robot.jacobian(each.q)).corank(DETECT)) for each in followed(TWO)]
    largest = max(abs(np.linalg.det(axis().robot.jacobian(each.q))) for each in followed(TWO))
    most = {label: max(each.iterations for each in followed(label)[:-1]) for label in (ONE, TWO)}
    reached = {label: sum(each.converged for each in followed(label)[:-1]) for label in (ONE, TWO)}
    drift = max(abs(np.degrees(each.q[0]) - 300) for label in (ONE, TWO) for each in followed(label))
    q = np.array([[each.q for each in followed(label)] for label in (ONE, TWO)])
    end = np.degrees(followed(TWO)[-1].q)
    return [
        Claim("(37) every point of the path is singular, the last with corank 2", "A = 0; s₃ = 0 too at t = 2",
              f"det J at most {largest:.0e}; coranks {''.join(map(str, coranks))}", "holds", "lengths as printed"),
        Claim("Fig. 3: q₂ and q₃", "a drawing, no numbers",
              f"q₂ {np.degrees(q[1, 0, 1]):.2f}° → {end[1]:.2f}°, q₃ {np.degrees(q[1, 0, 2]):.2f}° → {end[2]:.2f}°",
              "holds in kind", "branch and number of points are not given: ours are q₃ > 0 and 11"),
        Claim("q₁ stays at 300°", "numerical noise", f"within {drift:.0e}°", "holds", "its column of J is zero"),
        Claim("both algorithms reach all points before t = 2 with δ = 10⁻⁹", "all",
              f"{reached[ONE]} and {reached[TWO]} of 10, in at most {most[ONE]} and {most[TWO]} iterations", "holds",
              "ξ = 1, ours"),
        Claim("the two trajectories are almost the same", "almost",
              f"before t = 2 within {np.degrees(np.abs(q[0] - q[1])[:-1].max()):.0e}°", "holds",
              "same points, same branch"),
    ]  # fmt: skip


def at_the_end() -> list[Claim]:
    one, two = followed(ONE)[-1], followed(TWO)[-1]
    passes = int(np.argmax(sigma(one.path)[:, 1] < DETECT))
    constant = one.errors[-1] * one.iterations
    return [
        Claim("t = 2: Algorithm 2 arrives with δ = 10⁻⁹", "arrives", f"after {two.iterations} iterations", "holds",
              f"its error falls as {two.errors[1400] * 1400**2:.1e}/N², so a cap below that stops it too"),
        Claim("t = 2: Algorithm 1 cannot, and stops at a distance", "5.6e-6",
              f"{one.errors[passes]:.2e} at N = {passes}, {one.errors[1000]:.1e} at 1000, {one.errors[-1]:.1e} at 10⁴",
              "wrong",
              f"no floor: it falls as {constant:.2e}/N, to δ in {constant / DELTA:.0f} iterations; "
              "at 5.6e-6 d₂ passes 10⁻³"),
        Claim("one budget explains both", "not said",
              f"at N = {passes}, where Algorithm 1 is at {one.errors[passes]:.1e}, Algorithm 2 is at "
              f"{two.errors[passes]:.1e}", "open", "neither ξ nor a cap nor another way to stop is given"),
        Claim("detection d_m < 10⁻³, raised to d_min = 10⁻²", "two thresholds",
              f"1/σ jumps from {1 / DETECT:.0f} to {rik.DulebaClamp(FLOOR, detect=DETECT).gains([1, 0.999e-3])[1]:.0f}"
              " at 10⁻³",
              "open", "(22) itself has one threshold; used here: d_min for both"),
    ]  # fmt: skip


def directions() -> list[Claim]:
    before, last = followed(TWO)[5].q, np.array([np.radians(300), np.arccos(-0.6), 0])
    J, K = axis().robot.jacobian(before), axis().robot.jacobian(last)
    lost = rik.lost_directions(J, DETECT)[:, 0]
    sideways = abs(lost @ [np.sin(before[0]), -np.cos(before[0]), 0])
    angles = [np.degrees(float(rik.unavoidable_angle(each, [0.0, 0, 1], DETECT))) for each in (J, K)]
    q2 = np.linspace(-np.pi, np.pi, 20_001)
    c23 = -(0.1 + 0.2 * np.cos(q2)) / 0.5
    heights = np.abs(0.2 * np.sin(q2)[:, None] + 0.5 * np.sqrt(1 - c23**2)[:, None] * [1, -1])
    return [
        Claim("6.4: on the axis the direction (s₁, −c₁, 0) is lost", "perpendicular to all columns",
              f"cosine with the lost u₃: {sideways:.9f}", "holds",
              "where A = 0 the first column of J vanishes"),
        Claim("6.4: the angle of Δx to what is left foretells the error", "good estimator",
              f"{angles[0]:.0f}° before t = 2, {angles[1]:.2f}° at the end", "holds in kind",
              "0° converges as if regular; the end, where it is arccos 0.6, only slowly"),
        Claim("(36) and the range of z on the axis", "a₂ + a₃ ≥ a₁ gives all of it",
              f"lengths 0.1, 0.2, 0.5: z between {heights.min():.3f} and {heights.max():.3f} on either side only",
              "wrong", "(36) is when the axis is met; the whole range needs a₁ ≥ a₂ − a₃ and a₁ ≥ a₃ − a₂ too"),
    ]  # fmt: skip


def puma() -> list[Claim]:
    words = ", ".join(row.words for row in rik.find_singularities(rik.load("puma560")).of_corank(1))
    peak = {}
    for which in ("wrist", "elbow", "shoulder"):
        scenario = rik.load_scenario(f"puma_{which}")
        peak[which] = [rik.simulate(scenario, label).largest_speed for label in scenario.methods]
    text = "; ".join(f"{which} " + ", ".join(f"{x:.3g}" for x in values[:4]) for which, values in peak.items())
    return [
        Claim("PUMA 560: the shoulder by a relation, elbow and wrist explicitly", "no formulas", words, "holds",
              "found and certified as all there are"),
        Claim("PUMA 560 through them (motions ours): largest joint speed with J⁺, Algorithms 1, 2, (11) λ = d_min²",
              "no motion given", text + " rad/s", "holds in kind",
              "Algorithm 2 below Algorithm 1, as the paper expects; plain damping of equal safety below both; "
              "peaks of J⁺ depend on rounding"),
    ]  # fmt: skip
