"""J-PARSE (arXiv 2505.00306, 2025), claim by claim."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import robust_ik as rik
from benchmarks.claims import jparse
from benchmarks.claims.claim import Claim
from benchmarks.claims.jparse import at_keypoint, farthest, many, peak, spread_of, usual
from benchmarks.claims.spread import Spread
from robust_ik.analysis.stability import decrease_matrix, projector_leak, smallest_eigenvalue_along
from robust_ik.checks import Array
from robust_ik.simulation.scenarios import load_scenario

J, DLS = "J-PARSE, γ = 0.1", "DLS, λ = 0.1"
XARM = ("xarm7_line", "xarm7_plane")
NEAR = 1e-9
"""What counts as reached, m."""
BARE = "no actuators here: peaks are where the target jumps by up to 1 m at K = 10"
PATH = "path inferred, start ours"


def claims() -> list[Claim]:
    parts = (planar, theory, modifications, keypoints, ablations, real_robot, gen3, puma, online)
    return [claim for part in parts for claim in part()]


# ------------------------------------------------------------------------------------------ section VIII-A
def planar() -> list[Claim]:
    peaks = {f"g{k}": peak(many("jparse_2r", f"J-PARSE, γ = {g}", 40.0)) for k, g in enumerate((0.1, 0.05, 0.02))}
    adaptive = {f"w{k}": peak(many("jparse_2r", f"ADLS, w₀ = {w}", 40.0)) for k, w in enumerate((0.5, 0.1))}
    chatters = many("jparse_2r", "EDLS, s₋ = 0", 40.0).q[3000:, :, 1]
    turns = np.count_nonzero(np.diff(np.sign(chatters), axis=0), axis=0)
    ours = np.count_nonzero(np.diff(np.sign(many("jparse_2r", J, 40.0).q[3000:, :, 1]), axis=0), axis=0)
    stops = many("jparse_2r", "EDLS, s₋ = 0.1", 60.0).q[-1, :, 1]
    lost = "Table I lost its parameters; those of the reference code, λ unsquared in the matrix"
    return [
        Claim("2R, Fig. 3: a smaller γ gives a higher peak joint speed", "higher", peaks,
              "peaks {g0:.3g}, {g1:.3g}, {g2:.3g} rad/s, the smaller γ the higher", "g0 < g1 < g2", lost),
        Claim("2R: J-PARSE and adaptive damping can be made alike", "similar", peaks | adaptive,
              "{g1:.3g} rad/s between {w0:.3g} and {w1:.3g}", "w0 < g1 < w1", "the middle γ between the larger two w₀"),
        Claim("2R: EDLS with s₋ = 0 is not stable at a target out of reach", "fails",
              {"turns": spread_of(turns), "ours": spread_of(ours)},
              "the elbow changes sign {turns:.0f} times in 10 s, with J-PARSE {ours:.0f} times", "turns > 100 + ours",
              "φ(0⁺) = −ln β/s₊ is not 0"),
        Claim("EDLS does not enter the neighbourhood of a singularity", "stays out",
              {"rest": spread_of(stops), "lower": 0.1, "straight": 0.01}, "with s₋ = {lower} it rests at q₂ = "
              "{rest:.4f} rad",
              "rest > straight", "its gain is 0 below s₋"),
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------ sections V and VI
def theory() -> list[Claim]:
    worst, printed = _decrease()
    ratio = rik.JParse(0.1)
    step = ratio.gains([1.0, 0.1 - 1e-12])[1] / ratio.gains([1.0, 0.1 + 1e-12])[1]
    below, above = (jparse.near_its_target(J, product) for product in (1.9, 2.1))
    limits = _from_limits()
    return [
        Claim("(25)–(26), claim 4: q̇ is continuous at the threshold", "continuous",
              {"code": step, "text": 0.1 * step, "same": 1e-6}, "φ⁻/φ⁺ = {code:.6f} with σ/(γσ₁), {text:.2g} with σ/σ₁",
              {"σ/(γσ₁)": "abs(code - 1) < same", "σ/σ₁": "abs(text - 1) < same"},
              "the text has the second, the reference code the first"),
        Claim("(67): p k Δt ≤ 2/m is sufficient", "2/m",
              {"worst": worst, "printed": printed, "rounding": 1e-12, "rows": 6},
              "least eigenvalue of S down to {printed:.2g} in 1000 draws", "printed > -rounding",
              "p must read max(1, p): then even k max(1, p) Δt ≤ 2 suffices, m = {rows} times as much"),
        Claim("(50): with K = kI the error falls for k ≤ 2/Δt", "k ≤ 2/Δt",
              {"below": below, "above": above, "less": 1.9, "more": 2.1},
              "2 s multiply the error by {below:.2f} with k Δt = {less}, by {above:.0f} with {more}",
              "below < 1 < above", "", "arm, start and step ours"),
        Claim("(51)–(53): γ = ‖ẋ‖/(q̇_safe σ₁) keeps ‖q̇‖ ≤ q̇_safe", "never above", limits,
              "Gen3 with γ = {gamma:.2f}, ‖ẋ‖ up to {asked:.2f}: ‖q̇‖ up to {fastest:.2g} of {limit:.4g} rad/s",
              "asked <= task and fastest <= limit", "σ₁ ≥ 1 stands for the least σ₁, so γ is larger than needed", PATH),
        _null_space(),
    ]  # fmt: skip


def _decrease() -> tuple[float, float]:
    """Least eigenvalue of S at k max(1, p) Δt = 2, and at the printed p k Δt = 2/m."""
    rng, worst, printed = np.random.default_rng(0), np.inf, np.inf
    for _ in range(1000):
        gain, gamma, dt = rng.uniform(0.05, 3), rng.uniform(0.05, 0.5), rng.uniform(0.01, 0.5)
        shape = rng.uniform(0.1, 1, 6)
        inverse, A = rik.JParse(gamma, gain), rng.normal(size=(6, 7))
        sharp, theirs = (shape / shape.max() * most / dt for most in (2 / max(1.0, gain), 2 / (6 * gain)))
        worst = min(worst, float(np.linalg.eigvalsh(decrease_matrix(inverse, A, sharp, dt))[0]))
        printed = min(printed, float(np.linalg.eigvalsh(decrease_matrix(inverse, A, theirs, dt))[0]))
    return worst, printed


def _from_limits() -> dict[str, float]:
    label = "J-PARSE, from limits"
    runs, inverse = many("gen3_line", label, 65.0), load_scenario("gen3_line").method(label)
    asked, fastest = np.linalg.norm(runs.error, axis=-1).max(), np.linalg.norm(runs.qdot, axis=-1).max()
    return {"gamma": inverse.gamma, "asked": asked, "fastest": fastest, "limit": 0.8727, "task": 0.35}  # type: ignore[union-attr]


def _null_space() -> Claim:
    rng = np.random.default_rng(2)
    A = rng.normal(size=(200, 6, 7)) * np.array([1, 1, 1, 1, 0.1, 0.01])[:, None]
    inverse = rik.JParse(0.1)
    U, s, Vt = np.linalg.svd(A, full_matrices=False)
    safety = (U * np.maximum(s, 0.1 * s[:, :1])[:, None]) @ Vt
    moved = np.abs(A @ (np.eye(7) - np.linalg.pinv(safety) @ safety)).max()
    leak = max(float(np.max(projector_leak(inverse, each))) for each in A)
    return Claim(
        "(54): projected by I − J_s⁺J_s, the null-space term does not move the tool", "does not",
        {"moved": moved, "leak": leak, "bound": 1e-12},
        "by less than {bound:.0e} a rad/s in 200 draws; I − J#J of J-PARSE by up to {leak:.2g}", "moved < bound",
        "J_s⁺J_s = VVᵀ, exact wherever σ lies",
    )  # fmt: skip


# ------------------------------------------------------------------------------------------ section VII
def modifications() -> list[Claim]:
    plain, both, first = (many("gen3_line", label, 65.0) for label in (
        J, "J-PARSE, k_p = k_o = 2", "J-PARSE, position first"))  # fmt: skip
    error = {
        name: 1e3 * _mean(runs.position_error) for name, runs in zip(("plain", "both", "first"), (plain, both, first))
    }
    turned = {f"{name}_turned": float(runs.rotation_error.max())
              for name, runs in zip(("plain", "both", "first"), (plain, both, first))}  # fmt: skip
    grows = {name: _least_along(*gains) for name, gains in {"nine": (9.0, 1.0), "fifteen": (15.0, 1.0)}.items()}
    return [
        Claim("VII-B: gains k_p and k_o along singular directions", "used for Gen3",
              error | turned | {"one": peak(both)},
              "with 2 for both the mean error falls from {plain:.0f} to {both:.0f} mm, the largest angle from "
              "{plain_turned:.3f} to {both_turned:.3f} rad, peak {one:.2g} rad/s",
              "both < plain and both_turned < plain_turned", "equal gains are p = 2", PATH),
        Claim("VII-B: position and orientation may have gains of their own", "separately", grows | {"rounding": 1e-6},
              "½‖e‖² along the worst direction: never grows with (9, 1), with (15, 1) its least eigenvalue is "
              "{fifteen:.2g}",
              {"(9, 1)": "nine > -rounding", "(15, 1)": "fifteen > -rounding"},
              "safe with one singular direction if and only if √k_p and √k_o are at most 2 apart; the rule is ours"),
        Claim("VII-B: position by priority, orientation in what is left", "left for future work",
              error | turned | {"one": peak(first)},
              "mean error {first:.0f} instead of {plain:.0f} mm, angle up to {first_turned:.2f} instead of "
              "{plain_turned:.2f} rad, "
              "peak {one:.1f} rad/s", "first < plain and first_turned > plain_turned", "ours", PATH),
    ]  # fmt: skip


def _mean(error: Array) -> float:
    return float(np.mean(error))


def _least_along(position_gain: float, orientation_gain: float) -> float:
    """The least eigenvalue along any singular direction, negative if ½‖e‖² can grow."""
    share = np.linspace(0, 1, 2001)
    u = np.zeros((len(share), 6))
    u[:, 0], u[:, 3] = np.sqrt(share), np.sqrt(1 - share)
    gains = np.repeat([position_gain, orientation_gain], 3)
    return float(smallest_eigenvalue_along(u, gains).min())


# ------------------------------------------------------------------------------------------ section VIII-B
def keypoints() -> list[Claim]:
    line, plane = (many(name, J) for name in XARM)
    reached = {"reached": max(farthest(line, 1, 2, 3), farthest(plane, 0, 2)), "near": NEAR}
    missed = {"a": at_keypoint(line, 0), "b": at_keypoint(plane, 1), "d": at_keypoint(plane, 3)}
    wild = {name[6:]: peak(many(name, "pseudo-inverse")) for name in XARM}
    calm = {f"{name[6:]}_calm": peak(many(name, J)) for name in XARM}
    return [
        Claim("xArm7, Table II: reaches every keypoint within reach, rests at the others", "stable, no error",
              reached | missed | {"least_a": 0.327, "least_b": 0.177},
              "below {near:.0e} m where in reach; line A {a:.3f}, plane B {b:.3f}, D {d:.3f} m", "reached < near",
              "those three cannot be reached: a search from 40 starts finds nothing nearer"),
        _rests(line),
        Claim("Fig. 5: the pseudo-inverse is unstable near singularities", "crashed the simulation", wild | calm,
              "peaks {line:.0e} and {plane:.0e} rad/s against {line_calm:.3g} and {plane_calm:.3g}, line and plane",
              "line > 10 * line_calm and plane > 10 * plane_calm", "", BARE),
        _steady(),
        _gains(),
        _limits(),
    ]  # fmt: skip


def _rests(line: jparse.Runs) -> Claim:
    alone = many("xarm7_line", J, 20.0, posture=False)
    last = slice(850, 1000)
    return Claim(
        "stable at a target out of reach", "rests there",
        {"joints": spread_of(line.speed[last].max(axis=0)), "alone": spread_of(alone.speed[last].max(axis=0)),
         "tool": float(np.ptp(line.place[last], axis=0).max()), "still": 1e-3},
        "over 3 s at A the tool moves by less than {still} m; joints at up to {joints:.1g} rad/s, without null-space "
        "term {alone:.0e}", "tool < still",
        "where σ₆ is next to nothing its joint direction and the null space cannot be told apart, so the null-space "
        "term makes joints jerk",
        BARE,
    )  # fmt: skip


def _steady() -> Claim:
    line = {f"l{k}": many("xarm7_line", f"DLS, λ = {x}, leaking", 40.0) for k, x in enumerate((0.05, 0.1, 0.2))}
    plane = {f"p{k}": many("xarm7_plane", f"DLS, λ = {x}, leaking", 20.0) for k, x in enumerate((0.05, 0.1, 0.2))}
    at_b = {name: 1e3 * farthest(runs, 1) for name, runs in line.items()}
    at_a = {name: 1e3 * farthest(runs, 0) for name, runs in plane.items()}
    exact = max(farthest(many("xarm7_line", DLS), 1, 2, 3), farthest(many("xarm7_plane", DLS), 0, 2))
    return Claim(
        "Figs. 8, 9: its damping keeps DLS off its target at regular poses", "error grows with λ",
        at_b | at_a | {"exact": exact, "near": NEAR},
        "{l0:.0f}, {l1:.0f}, {l2:.0f} mm at line B, {p0:.1f}, {p1:.0f}, {p2:.0f} mm at plane A with I − J#J, "
        "growing with λ; "
        "with I − VVᵀ below {near:.0e} m at all keypoints in reach", "exact > near",
        "it is the null-space term leaking through I − J#J, not the damping, which only slows the approach",
    )  # fmt: skip


def _gains() -> Claim:
    runs = {"p1": many("xarm7_line", J)} | {f"p{p}": many("xarm7_line", f"J-PARSE, p = {p}", 42.0) for p in (2, 3, 5)}
    back = {name: jparse.seconds_until_near(each) for name, each in runs.items()}
    middle = {f"{name}_middle": each.median for name, each in back.items()}
    return Claim(
        "Fig. 10: p = 2 is considerably faster than 1, 3 gains less", "faster",
        back | middle | {f"{name}_peak": peak(each) for name, each in runs.items()},
        "within 1 cm of B after {p1:.1f}, {p2:.1f}, {p3:.1f}, {p5:.1f} s for p = 1, 2, 3, 5, peaks {p1_peak:.0f}, "
        "{p2_peak:.0f}, {p3_peak:.0f}, {p5_peak:.0f} rad/s", "p2 < p1 and p1_middle - p2_middle > p2_middle - "
        "p3_middle",
        "ranges of runs that differ by rounding; the peak grows with p, the time saved does not", BARE,
    )  # fmt: skip


def _limits() -> Claim:
    runs = [rik.simulate(replace(load_scenario(f"{name}_limits"), duration=40.0), J) for name in XARM]
    line, plane = (run.position_error[[999, 1999]] for run in runs)
    fastest = max(run.largest_speed_ratio for run in runs)
    return Claim(
        "Joint limits", "left open",
        {"a": line[0], "b": plane[1], "reached": max(line[1], plane[0]), "near": NEAR, "fastest": fastest,
         "all": 1 + 1e-9},
        "kept, joints never above their speed; line B and plane A below {near:.0e} m, line A {a:.3f} m, plane B "
        "{b:.3f} m",
        "reached < near and fastest <= all", "ours: within the URDF's limits the same keypoints are reached", BARE,
    )  # fmt: skip


# ------------------------------------------------------------------------------------------ Figures 6 and 7
def ablations() -> list[Claim]:
    safety = {name[6:]: usual(many(name, "JacobianSafety")) for name in XARM}
    calm = {f"{name[6:]}_calm": usual(many(name, J)) for name in XARM}
    line, plane = (many(name, "JacobianSafetyProjection") for name in XARM)
    dropped = {
        "b": at_keypoint(line, 1),
        "c": at_keypoint(line, 2),
        "a": at_keypoint(plane, 0),
        "pc": at_keypoint(plane, 2),
    }
    rng = np.random.default_rng(1)
    A = rng.normal(size=(200, 6, 7)) * np.array([1, 1, 1, 1, 0.1, 0.01])[:, None]
    own = {name[6:]: jparse.single(name, "JacobianProjection") for name in XARM}
    ends = {
        f"own_{name}": np.array([run.position_error[jparse.AT_KEYPOINTS] for run in runs]) for name, runs in own.items()
    }
    return [
        Claim("Figs. 6, 7: JacobianSafety commands large joint speeds", "large", safety | calm,
              "99 % are below {line:.3g} rad/s on the line and {plane:.2g} in the plane, J-PARSE's below "
              "{line_calm:.2g} and "
              "{plane_calm:.2g}", "line > 2 * line_calm and plane > 2 * plane_calm",
              "φ(0⁺) = 1/(γσ₁): it chatters at targets out of reach", BARE),
        Claim("Figs. 6, 7: SafetyProjection does not reach the poses after a singular one", "does not",
              dropped | {"near": 0.01}, "line B {b:.3f}, C {c:.2f} m; plane A {a:.3f}, C {pc:.2f} m",
              "min(b, c, a, pc) > near", "what is dropped is never fed back"),
        Claim("(57) and (59) are two ablations", "behave differently",
              {"same": max(_difference(each, 0.1) for each in A), "rounding": 1e-9}
              | {"b": spread_of(ends["own_line"][:, 1]), "c": spread_of(ends["own_line"][:, 2])}
              | {"a": spread_of(ends["own_plane"][:, 0]), "pc": spread_of(ends["own_plane"][:, 2])},
              "assembled they differ by less than {rounding:.0e}; with (57)'s own projector line B {b:.2f}, C "
              "{c:.2f} m, plane "
              "A {a:.2f}, C {pc:.2f} m", "same > rounding",
              "they differ by the null-space projector that each is paired with, and by nothing else"),
    ]  # fmt: skip


def _difference(J: Array, gamma: float) -> float:
    """Of J_p⁺ and J_s⁺ J_p J_p⁺, put together as printed, relative."""
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    kept = s > gamma * s[0]
    safety = (U * np.maximum(s, gamma * s[0])) @ Vt
    projection = (U[:, kept] * s[kept]) @ Vt[kept]
    lone = Vt[kept].T @ (U[:, kept] / s[kept]).T
    return float(np.abs(np.linalg.pinv(safety) @ projection @ lone - lone).max() / np.abs(lone).max())


# ------------------------------------------------------------------------------------------ Figures 11 and 12
def real_robot() -> list[Claim]:
    label = "J-PARSE, γ = 0.07"
    line, plane = (many(f"{name}_real", label) for name in XARM)
    wild = [peak(many(f"{name}_real", "pseudo-inverse")) for name in XARM]
    return [
        Claim(
            "Figs. 11, 12: with the real robot's gains the behaviour is stable", "stable, as in simulation",
            {"line": peak(line), "plane": peak(plane), "reached": max(farthest(line, 1, 2, 3), farthest(plane, 0, 2)),
             "near": 1e-3, "a": at_keypoint(line, 0), "b": at_keypoint(plane, 1), "limit": np.pi,
             "wild": Spread(tuple(x for each in wild for x in each.runs))},
            "within {near} m of every keypoint in reach after 20 s, {a:.2f} m from line A, {b:.2f} m from plane B; "
            "peaks {line:.2g} "
            "and {plane:.2g} rad/s, pseudo-inverse {wild:.0e}", "reached < near and max(line, plane) < limit", "",
            "no real arm: K = 1, error capped at 0.1 m; null-space cap 0.6 rad/s and γ = 0.07 from the code",
        )
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------ section VIII-C
def gen3() -> list[Claim]:
    labels = {"jparse": J, "light": "DLS, λ = 0.01", "heavy": DLS, "adaptive": "ADLS"}
    peaks = {name: peak(many("gen3_line", label, 65.0)) for name, label in labels.items()}
    return [
        Claim("Gen3, Fig. 13: crosses the inner singularity without instability", "small deviations",
              peaks | {"limit": 0.8727},
              "peaks {jparse:.3g} rad/s, DLS {light:.2g} (small λ) and {heavy:.3g}, ADLS {adaptive:.3g}",
              "jparse < limit",
              "the arm's limit is {limit:.2g} rad/s", PATH),
        _aligned(),
        *_lower_manipulability(),
    ]  # fmt: skip


def _lower_manipulability() -> list[Claim]:
    """With the paper's null-space term: how near the boundary the arm gets while the target is out of reach."""
    (ours, least), found = jparse.out_of_reach(J), {}
    lower: dict[str, int] = {}
    for kind, ending in (("leaking", ", leaking"), ("exact", "")):
        others = [jparse.out_of_reach(f"DLS, λ = {x}{ending}") for x in (0.01, 0.1)]
        found |= {f"{kind}_light": spread_of(others[0][0]), f"{kind}_heavy": spread_of(others[1][0])}
        lower[kind] = int(np.sum(ours < np.minimum(others[0][0], others[1][0])))
        lower[f"{kind}_least"] = int(np.sum(least < np.minimum(others[0][1], others[1][1])))
    numbers = {**found, "ours": spread_of(ours), **lower, "count": len(ours)}
    return [
        Claim("Gen3, Fig. 13: out of reach J-PARSE's manipulability is lower than either DLS's", "lower", numbers,
              "median Πσ out of reach {ours:.0e}, DLS {leaking_light:.0e} and {leaking_heavy:.0e} (λ = 1/100, 1/10) "
              "with the "
              "reference's I − J#J: lower from {leaking} of {count} starts, its least from {leaking_least}",
              "leaking > count / 2",
              "with the null-space term of the paper, least values depend on the start", PATH),
        Claim("Gen3: that shows that J-PARSE reaches out farther than DLS", "to a greater extent", numbers,
              "with I − VVᵀ for all: median {ours:.0e}, DLS {exact_light:.0e} and {exact_heavy:.0e}: lower from "
              "{exact} of {count} "
              "starts", "exact > count / 2",
              "it was the null-space term, leaking through I − J#J, that held DLS back; path inferred, starts ours"),
    ]  # fmt: skip


def _aligned() -> Claim:
    robot, q = rik.load("kinova_gen3"), np.random.default_rng(0).uniform(-2, 2, (2000, 7))
    q[:, 1] = 0.0
    alone = rik.svd(robot.jacobian(robot.configuration(q))).s[:, -1].max()
    q[:, 5] = 0.0
    both = rik.svd(robot.jacobian(robot.configuration(q))).s[:, -1].max()
    return Claim(
        "Gen3: joints 1 and 3 aligned are an inner singularity", "singular",
        {"alone": alone, "both": both, "small": 0.01},
        "σ₆ up to {alone:.2f} with q2 = 0; at most {both:.0e} with q2 = q6 = 0",
        {"q2 = 0 alone": "alone < small", "with the straight wrist that is there too": "both < small"},
        "with seven joints q2 = 0 loses nothing by itself", PATH,
    )  # fmt: skip


def puma() -> list[Claim]:
    labels = {"j10": J, "j5": "J-PARSE, γ = 0.05", "dls": DLS, "adls": "ADLS"}
    runs = {name: many("puma_wrist_lock", label, 60.0) for name, label in labels.items()}
    error = {name: spread_of(1e3 * each.position_error.mean(axis=0)) for name, each in runs.items()}
    peaks = {f"{name}_peak": peak(each) for name, each in runs.items()}
    better = "{0} < min(dls, adls) and {0}_peak < min(dls_peak, adls_peak)"
    return [
        Claim("PUMA: improved performance over DLS and ADLS", "better", error | peaks,
              "mean error {j10:.1f} and {j5:.1f} mm (γ = 1/10, 1/20), DLS {dls:.1f}, ADLS {adls:.1f}; peaks "
              "{j10_peak:.2f}, "
              "{j5_peak:.2f}, {dls_peak:.2f}, {adls_peak:.2f} rad/s",
              {"γ = 0.1": better.format("j10"), "γ = 0.05": better.format("j5")},
              "a trade along one curve, and γ the place on it", "path lost"),
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------ sections VIII-D, E
def online() -> list[Claim]:
    arms = {label: jparse.single("xarm7_teleoperation", label) for label in (J, DLS, "slow down", "stop")}
    reach = _named(arms, lambda run: run.pose[:, 0, 3].max())
    back = _named(arms, lambda run: run.pose[:, 0, 3].max() - run.pose[-1, 0, 3])
    still = spread_of([run.time[np.flatnonzero(np.abs(run.qdot).any(axis=1))[-1]] for run in arms["stop"]])
    marker = {label: jparse.single("gen3_marker", label) for label in (J, "slow down", "stop")}
    ends = _named(marker, lambda run: 1e3 * np.linalg.norm(run.final_error[:3]))
    far = {f"{name}_far": each for name, each in _named(marker, lambda run: run.pose[:, 0, 3].max()).items()}
    return [
        Claim("VIII-D1: the native guard stops for good, J-PARSE retrieves from the boundary", "stops / retrieves",
              reach | {f"{name}_back": each for name, each in back.items()} | {"still": still, "all": 26.0},
              "reach {jparse:.3f} m (DLS {dls:.3f}, slowing down {slow:.3f}, stopping {stop:.3f}); the guard stands "
              "from {still:.1f} s "
              "of {all:.0f} on", "stop < jparse and still < all / 2 and jparse_back > stop_back",
              "plain DLS does it as well", "a made-up stick record"),
        Claim("VIII-D2: reaches towards a distant marker and retracts", "continuous", ends | far | {"near": 20.0},
              "farthest {jparse_far:.3f} m (slowing down {slow_far:.3f}, stopping {stop_far:.3f}); at the end "
              "{jparse:.0f} mm from it "
              "({slow:.0f}, {stop:.0f})", "jparse < near and stop > near and jparse_far > max(slow_far, stop_far)",
              "slowing down does return too, short of the boundary", "a made-up marker"),
        Claim("VIII-E: policies learnt from demonstrations work near singularities", "92 demonstrations",
              {"tried": False},
              "not tried", "tried", "", "no robot, camera or training here"),
    ]  # fmt: skip


def _named(runs: dict[str, tuple[rik.Trajectory, ...]], quantity) -> dict[str, Spread]:  # type: ignore[no-untyped-def]
    names = {J: "jparse", DLS: "dls", "slow down": "slow", "stop": "stop"}
    return {names[label]: spread_of([quantity(run) for run in each]) for label, each in runs.items()}
