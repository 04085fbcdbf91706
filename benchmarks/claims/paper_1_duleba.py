"""Dułęba 2023: singularity-robust inverse kinematics for serial manipulators."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import robust_ik as rik
from benchmarks.claims.claim import Claim
from benchmarks.claims.duleba import axis_heights, half_plane, meets_its_axis, sizes, three_revolute
from benchmarks.claims.spread import spread
from robust_ik.analysis import evaluation
from robust_ik.checks import Array
from robust_ik.simulation.scenarios import reach_points

ONE, TWO = "Algorithm 1", "Algorithm 2"
TIMES = np.linspace(0, 2, 11)
FLOOR, DETECT, DELTA = 1e-2, 1e-3, 1e-9
TINY = 1e-10
"""Rounding is below, everything that is meant above."""
RAMP = np.append(np.ones((5000, 2)), np.geomspace(1e-5, 1, 5000)[:, None], axis=1)
"""Spectra (1, 1, σ) with σ from far below d_min to far above."""


def claims() -> list[Claim]:
    """Every claim, section by section."""
    found = [*additive(), *other_inverses(), *criteria(), *cost(), *simulation(), *at_the_end(), *where_a_is_zero()]
    return [*found, *norms(), *normalisation(), *directions(), *puma()]


@cache
def axis() -> rik.Scenario:
    """Path (37)."""
    return rik.load_scenario("duleba_axis")


@cache
def followed(label: str, cap: int = 10_000) -> tuple[rik.NewtonResult, ...]:
    """Path (37) at 11 points, ξ = 1."""
    return reach_points(axis(), label, tuple(TIMES), tolerance=DELTA, max_iterations=cap)


def sigma(q: Array) -> Array:
    """Singular values of the arm's Jacobian."""
    return rik.svd(axis().robot.jacobian(q)).s


def additive() -> list[Claim]:
    """Section 3.1."""
    rng = np.random.default_rng(0)
    B = rng.normal(size=(1000, 3, 3))
    A, M = B @ np.swapaxes(B, -1, -2) + 0.1 * np.eye(3), B[..., :2] @ np.swapaxes(B[..., :2], -1, -2)
    excess = {"several": evaluation.determinant_excess(A, M).min()}
    J, S = rng.normal(size=(3, 4)), np.diag([1000.0, 1.0, 0.1])
    xdot = rng.normal(size=3)

    def change(variant: str) -> float:
        inverse = rik.DulebaAdditive(1e-2, variant)
        return float(np.linalg.norm(inverse.solve(S @ J, S @ xdot) - inverse.solve(J, xdot)))

    return [
        Claim(
            "(7) det(A + M) > det A + det M for every M ≠ 0", "always",
            {**excess, "single": float(evaluation.determinant_excess([[2.0]], [[3.0]]))},
            "least excess of 1000 draws with m = 3: {several:.1g}; with m = 1: {single:.0f}",
            "several > 0 and single > 0", "m ≥ 2 is needed too; for one row both sides are equal",
        ),
        Claim(
            "(12) suits the rows of J, which (11) treats alike", "no number",
            {"scaled": change("scaled"), "plain": change("plain"), "tiny": TINY},
            "units of rows changed: q̇ moves by less than {tiny:.0e} with (12), by {plain:.0e} with (11)",
            "scaled < tiny < plain", "P(SJ) S = P(J) for diagonal S > 0",
        ),
    ]  # fmt: skip


def other_inverses() -> list[Claim]:
    """Equations (19), (23), (44), (45)."""
    rng = np.random.default_rng(1)
    J = np.outer(*rng.normal(size=(2, 2)))
    fatal = float(evaluation.fatal_dampings(J)[0])
    K = rng.normal(size=(3, 4))
    U, D2 = rik.svd(K).U, np.diag(rik.svd(K).s ** 2)
    signs = [U * flip for flip in np.stack(np.meshgrid(*[[1, -1]] * 3), axis=-1).reshape(-1, 3)]
    W = np.diag([1.0, 2, 3, 4])
    qdot = rik.Weighted(rik.MoorePenrose(), joint_weights=np.diag(W)).solve(K, K[:, 0])
    null = rik.lost_directions(K.T)[:, 0]
    rise = min((qdot + h * null) @ W @ (qdot + h * null) - qdot @ W @ qdot for h in (-1e-3, 1e-3))
    possible = evaluation.allows_multiplicative_inverse(3, 4, 1)
    return [
        Claim("(19) fails for n = 4, m = 3, c = 1", "not satisfied",
              {"possible": possible, "word": "satisfied" if possible else "not satisfied"}, "{word}", "not possible",
              "the null space has 2 dimensions, Ψ needs 3"),
        Claim("(23) M = U D² U", "as printed",
              {"printed": min(np.abs(each @ D2 @ each - K @ K.T).max() for each in signs),
               "right": np.abs(U @ D2 @ U.T - K @ K.T).max(), "tiny": TINY},
              "error at least {printed:.1f} whatever the signs of the columns; with Uᵀ at the end below {tiny:.0e}",
              "printed < tiny", "misprint: the last factor is Uᵀ"),
        Claim("(44) det(J + λI) may vanish for λ ≠ 0", "may",
              {"left": abs(np.linalg.det(J + fatal * np.eye(2))), "least": abs(fatal), "tiny": TINY},
              "at λ = −tr J, {least:.1f} from zero, it is below {tiny:.0e}", "left < tiny < least",
              "damp J Jᵀ, never J"),
        Claim("(45) comes from maximising J q̇ at fixed q̇ᵀWq̇", "maximum", {"rise": rise},
              "leaving it inside the null space raises q̇ᵀWq̇ by at least {rise:.0e}", "rise > 0",
              "it is the least q̇ᵀWq̇ among all q̇ with J q̇ = ẋ", "true along a given direction of ẋ"),
    ]  # fmt: skip


def criteria() -> list[Claim]:
    """Questions 1 and 2 of section 4, and what is concluded from them."""
    rng = np.random.default_rng(2)
    s = -np.sort(-np.append(rng.uniform(FLOOR, 1, (10_000, 2)), rng.uniform(0, FLOOR, (10_000, 1)), axis=1))
    both = evaluation.compare_damping_and_clamp(s[..., None] * np.eye(3), FLOOR)
    full = evaluation.compare_damping_and_clamp(np.zeros((3, 3)), FLOOR)
    inverses = {"matched": evaluation.DulebaMatched(FLOOR), "clamp": rik.DulebaClamp(FLOOR),
                "equal": rik.DampedLeastSquares(FLOOR)}  # fmt: skip
    gain = {name: FLOOR * float(inverse.gains(RAMP)[:, -1].max()) for name, inverse in inverses.items()}
    return [
        Claim("(30), (31) for f₁ = f₂ the clamp gets farther: h₁ < h₂", "always, c < m",
              {"share": np.mean(both.damped < both.clamped), "full": float(full.damped / full.clamped)},
              "in {share:.0%} of 10⁴ draws; at c = m = 3 h₁/h₂ = {full:.2f}", "share == 1",
              "h₂ − h₁ = (1 − c/m) d_min² at exact corank c"),
        Claim("(41) ‖Δq‖ ≤ ν/d_min after the cure", "bound of the clamp",
              {"clamp": gain["clamp"], "matched": gain["matched"],
               "six": FLOOR * evaluation.DulebaMatched(FLOOR).peak(6), "slack": 1 + TINY},
              "largest gain × d_min: clamp {clamp:.2f}, matched damping {matched:.2f}, with six rows {six:.2f}",
              "clamp <= slack", "for the clamp only: the damping with f₁ = f₂ exceeds it from three rows on"),
        Claim("Conclusion: the clamp is the best, and lowers joint speeds", "for equal modification",
              {**gain, "share": gain["equal"] / gain["clamp"]},
              "for equal safety, λ = d_min², (11) has {share:.2f} of the clamp's largest gain",
              {"equal modification": "clamp < matched", "equal safety": "clamp < equal"},
              "which one wins depends on what is held equal; and only the clamp jumps at σ = 0"),
    ]  # fmt: skip


def cost(n: int = 6) -> list[Claim]:
    """Question 3 of section 4, in multiplications and additions of an n × n Jacobian.

    Counts of Golub and Van Loan: all of the SVD 21 n³, J Jᵀ by its lower half n³, Cholesky n³/3, substitutions 2 n².
    """
    decomposing, solving = 21 * n**3, n**3 + n**3 // 3 + 4 * n**2
    return [
        Claim("question 3: the SVD method computes least", "as detection is shared",
              {"n": n, "clamp": decomposing + 4 * n**2, "matched": decomposing + solving, "constant": solving},
              "{n} × {n}: about {clamp} operations; Algorithm 1, whose λ needs the singular values, {matched}; "
              "(11) with a constant λ {constant}",
              "clamp < matched", "counted, not timed",
              "if singularities are detected by an SVD anyway; constant damping needs no detection"),
    ]  # fmt: skip


def simulation() -> list[Claim]:
    """Section 5, but for its last point."""
    coranks = [int(rik.svd(axis().robot.jacobian(each.q)).corank(DETECT)) for each in followed(TWO)]
    largest = max(abs(np.linalg.det(axis().robot.jacobian(each.q))) for each in followed(TWO))
    most = {label: max(each.iterations for each in followed(label)[:-1]) for label in (ONE, TWO)}
    reached = {label: sum(each.converged for each in followed(label)[:-1]) for label in (ONE, TWO)}
    drift = max(abs(np.degrees(each.q[0]) - 300) for label in (ONE, TWO) for each in followed(label))
    q = np.degrees([[each.q for each in followed(label)] for label in (ONE, TWO)])
    points = len(TIMES) - 1
    return [
        Claim("(37) every point of the path is singular, the last with corank 2", "A = 0; s₃ = 0 too at t = 2",
              {"largest": largest, "tiny": TINY, "coranks": "".join(map(str, coranks)), "said": points * "1" + "2"},
              "det J below {tiny:.0e}; coranks {coranks}", "largest < tiny and coranks == said", "lengths as printed"),
        Claim("Fig. 3: q₂ and q₃", "a drawing, no numbers",
              {"q2": q[1, 0, 1], "q3": q[1, 0, 2], "q2_end": q[1, -1, 1], "q3_end": q[1, -1, 2],
               "stretched": np.degrees(np.arccos(-0.6))},
              "q₂ {q2:.2f}° → {q2_end:.2f}°, q₃ {q3:.2f}° → {q3_end:.2f}°",
              "abs(q2_end - stretched) < 0.1 and abs(q3_end) < 0.1 < q3", "it ends stretched",
              "branch and number of points are not given: ours are q₃ > 0 and 11"),
        Claim("q₁ stays at 300°", "numerical noise", {"drift": drift, "noise": 1e-6}, "within {noise:.0e}°",
              "drift < noise", "its column of J is zero"),
        Claim("both algorithms reach all points before t = 2 with δ = 10⁻⁹", "all",
              {"one": reached[ONE], "two": reached[TWO], "points": points, "most_one": most[ONE],
               "most_two": most[TWO]},
              "{one} and {two} of {points}, in at most {most_one} and {most_two} iterations", "one == two == points",
              "ξ = 1, ours"),
        Claim("the two trajectories are almost the same", "almost",
              {"apart": np.abs(q[0] - q[1])[:-1].max(), "noise": 1e-5}, "before t = 2 within {noise:.0e}°",
              "apart < noise", "same points, same branch"),
    ]  # fmt: skip


def at_the_end() -> list[Claim]:
    """The last point, of corank 2."""
    one, two = followed(ONE)[-1], followed(TWO)[-1]
    passes = int(np.argmax(sigma(one.path)[:, 1] < DETECT))
    constant = one.errors[-1] * one.iterations
    twofold = rik.DulebaClamp(FLOOR, detect=DETECT)
    other = reach_points(axis(), twofold, tuple(TIMES), tolerance=DELTA, max_iterations=10_000)[-1]
    return [
        Claim("t = 2: Algorithm 2 arrives with δ = 10⁻⁹", "arrives",
              {"arrives": two.converged, "iterations": two.iterations, "law": two.errors[1400] * 1400**2},
              "after {iterations} iterations", "arrives",
              "its error falls as {law:.1e}/N², so a cap below that stops it too"),
        Claim("t = 2: Algorithm 1 cannot, and stops at a distance", "5.6e-6",
              {"said": 5.6e-6, "passes": passes, "there": one.errors[passes], "later": one.errors[1000],
               "last": one.errors[-1], "law": constant, "needed": constant / DELTA, "other": two.errors[passes]},
              "{there:.1e} at N = {passes}, {later:.1e} at 1000, {last:.1e} at 10⁴", "last > 0.9 * said",
              "no floor: it falls as {law:.2e}/N, to δ in {needed:.2e} iterations; at the printed distance d₂ passes "
              "10⁻³; nor is it one budget for both: at that N Algorithm 2 is at {other:.1e}"),
        Claim("detection d_m < 10⁻³, raised to d_min = 10⁻²", "two thresholds, and one in (22)",
              {"one": two.converged, "both": other.converged, "n_one": two.iterations, "n_both": other.iterations,
               "above": 1 / DETECT, "below": float(twofold.gains(np.array([1, 0.999e-3]))[1])},
              "Algorithm 2 arrives after {n_one} iterations with d_min for both, after {n_both} with the two",
              {"(22), one threshold": "one", "two thresholds": "both"},
              "with the two 1/σ jumps from {above:.0f} to {below:.0f} at 10⁻³; used here: d_min for both"),
    ]  # fmt: skip


def where_a_is_zero() -> list[Claim]:
    """Condition (36), and the range of z printed below (37)."""
    rng = np.random.default_rng(3)
    lengths = rng.uniform(0.1, 0.6, (60, 3))
    met = np.array([meets_its_axis(three_revolute(each)) for each in lengths])
    said = lengths[:, 1] + lengths[:, 2] >= lengths[:, 0]
    unequal = (0.1, 0.2, 0.5)
    z, other = axis_heights(axis().robot), axis_heights(three_revolute(unequal))
    return [
        Claim("(36): the axis is reached, A = 0, if only a₂ + a₃ ≥ a₁", "if",
              {"wrong": int((met != said).sum()), "met": int(met.sum()), "arms": len(lengths)},
              "{arms} random arms: {met} reach their axis, {wrong} of all against (36)",
              "wrong == 0 and 0 < met < arms",
              "neither more nor less is needed"),
        Claim("(37): the range of z on the axis, a₀ ± √((a₂ + a₃)² − a₁²)", "±0.4",
              {"top": z.max(), "gap": np.diff(np.sort(z)).max(), "said": np.sqrt(0.5**2 - 0.3**2),
               "hole": np.abs(other).min(), "a1": unequal[0], "a2": unequal[1], "a3": unequal[2]},
              "±{top:.3f}, with no gap", "abs(top - said) < 1e-3 and gap < 0.01",
              "for the paper's lengths; {a1}, {a2} and {a3}, where a₁ < a₃ − a₂, leave a hole of ±{hole:.2f}"),
    ]  # fmt: skip


def norms() -> list[Claim]:
    """Section 6.1."""
    A, B = np.diag([1.0, 0]), np.diag([0, 1.0])
    a, b, both = (float(np.sqrt(evaluation.safety_by_damping(rik.svd(each).s, 0))) for each in (A, B, A + B))
    J = axis().robot.jacobian(np.array([0.3, 0.4, 0.02]))
    U, s = rik.svd(J).U, rik.svd(J).s
    worst = {name: float(np.linalg.norm(inverse.solve(J, U[:, -1]))) * s[-1]
             for name, inverse in (("plain", rik.MoorePenrose()), ("clamp", rik.DulebaClamp(FLOOR)))}  # fmt: skip
    return [
        Claim("6.1, (38): the least singular value g₁ is no norm", "g₁(A) = g₁(B) = 0, g₁(A + B) = 1",
              {"a": a, "b": b, "both": both}, "{a:.0f}, {b:.0f} and {both:.0f}", "both > a + b",
              "the triangle inequality fails"),
        Claim("6.1, (40): in the worst case ‖Δq‖ = ν/d_m", "ν = d_m ‖Δq‖",
              {**worst, "d": s[-1], "bound": s[-1] / FLOOR},
              "d_m = {d:.4f}: d_m ‖Δq‖/ν is {plain:.3f} with J⁺, {clamp:.3f} with the clamp",
              "abs(plain - 1) < 1e-9 and clamp < 1 + 1e-9", "Δx is the last column of U"),
    ]  # fmt: skip


def normalisation() -> list[Claim]:
    """Section 6.3."""
    rng = np.random.default_rng(4)
    J, xdot = rng.normal(size=(3, 4)), rng.normal(size=3)
    unit, costs = np.array([180 / np.pi, 1, 1000, 1]), np.array([1.0, 2, 3, 4])
    raw, normalised = sizes()
    A, _ = half_plane(axis().robot, 65)

    def moved(inverse: rik.RobustInverse, same: rik.RobustInverse) -> float:
        """By how much a motion changes if the first joint counts in degrees and the third in millimetres."""
        return float(np.linalg.norm(same.solve(J / unit, xdot) / unit - inverse.solve(J, xdot)))

    plain = rik.MoorePenrose()
    weighted, same = (rik.Weighted(plain, joint_weights=tuple(each)) for each in (costs, costs / unit**2))
    return [
        Claim("6.3: W of (45) unifies different units of the joints", "different units and ranges",
              {"weighted": moved(weighted, same), "plain": moved(plain, plain), "tiny": TINY},
              "other units of two joints: the motion changes by less than {tiny:.0e} with W, by {plain:.1f} with J⁺",
              "weighted < tiny < plain", "W changes with the units"),
        Claim("6.3: normalised kinematics depend less on the lengths", "advised",
              {"raw": raw, "normalised": normalised},
              "arms of a decimetre to ten metres: their least σ differ by a factor of {raw:.0f}, normalised of "
              "{normalised:.1f}", "normalised < raw / 10", "every row divided by its bound of (46)"),
        Claim("6.3, (46): the sum of the lengths is a reasonable bound", "reasonable",
              {"bound": 0.3 + 0.2 + 0.3, "most": A.max()}, "{bound:.1f}, the largest x is {most:.1f}",
              "most <= bound + 1e-9 and bound < 2 * most", "here it is reached"),
    ]  # fmt: skip


def directions() -> list[Claim]:
    """Section 6.4."""
    before, last = followed(TWO)[5].q, np.array([np.radians(300), np.arccos(-0.6), 0])
    J, K = axis().robot.jacobian(before), axis().robot.jacobian(last)
    lost = rik.lost_directions(J, DETECT)[:, 0]
    sideways = abs(lost @ [np.sin(before[0]), -np.cos(before[0]), 0])
    on_the_way, end = (np.degrees(float(rik.unavoidable_angle(each, [0.0, 0, 1], DETECT))) for each in (J, K))
    few, many = followed(TWO)[5].iterations, followed(TWO)[-1].iterations
    return [
        Claim("6.4: on the axis the direction (s₁, −c₁, 0) is lost", "perpendicular to all columns",
              {"cosine": sideways}, "cosine with the lost u₃: {cosine:.6f}", "cosine > 1 - 1e-9",
              "where A = 0 the first column of J vanishes"),
        Claim("6.4: the angle of Δx to what is left foretells the error", "good estimator",
              {"before": on_the_way, "end": end, "few": few, "many": many},
              "{before:.0f}° before t = 2 ({few} iterations), {end:.2f}° at the end ({many})",
              "before < 1e-3 and end > 10 and few < many",
              "0° converges as if regular; the end, where it is the angle of a cosine of 3/5, only slowly",
              "qualitatively, as it says"),
    ]  # fmt: skip


def puma() -> list[Claim]:
    """Question 4 of section 4, and the motions that it does not try."""
    atlas = rik.find_singularities(rik.load("puma560"))
    rows = atlas.of_corank(1)
    explicit = sum(not row.relations and not row.curve and len(row.conditions) == 1 for row in rows)
    return [
        Claim("PUMA 560: the shoulder by a relation, elbow and wrist explicitly", "no formulas",
              {"words": ", ".join(row.words for row in rows), "rows": len(rows), "explicit": explicit,
               "relations": sum(len(row.relations) for row in rows),
               "status": atlas.evidence[0].status.name.lower()},
              "{words}", "explicit == 2 and relations == 1 and rows == 3", "{status} as all there are"),
        *(passed(which) for which in ("wrist", "elbow", "shoulder")),
    ]  # fmt: skip


def passed(which: str) -> Claim:
    """Largest joint speeds of one motion of the PUMA."""
    scenario = rik.load_scenario(f"puma_{which}")

    def peak(label: str, q0: Array = scenario.q0) -> float:
        return rik.simulate(replace(scenario, q0=q0), label).largest_speed

    return Claim(
        f"PUMA 560, {which}: the clamp lowers joint speeds", "for equal modification",
        {"plain": spread(lambda q0: peak("pseudo-inverse", q0), scenario.q0, count=2), "one": peak(ONE),
         "two": peak(TWO), "equal": peak("(11), λ = d_min²"), "times": 1.5},
        "Algorithm 1 {one:.3g}, Algorithm 2 {two:.3g}, (11) with λ = d_min² {equal:.3g} rad/s; J⁺ over {times} times "
        "the first",
        "two < one < plain / times",
        "how near J⁺ comes to σ = 0 in a step, and so its peak, hangs on rounding; plain damping of equal safety is "
        "below both",
        "motion: ours",
    )  # fmt: skip
