"""Almarkhi and Maciejewski 2019, "Singularity analysis for redundant manipulators of arbitrary kinematic structure"."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import robust_ik as rik
from benchmarks.claims.almarkhi import (
    FIG_1,
    FIG_2,
    FIG_3,
    FIG_6,
    FIG_9,
    ROTATED,
    SUBSPACE,
    TABLE_3,
    TABLE_4,
    atlas,
    chain,
    cosines,
    derivatives,
    example_arm,
    lost_by_figure_6,
    starts,
)
from benchmarks.claims.claim import Claim
from benchmarks.claims.spread import Spread, spread
from robust_ik.checks import Array
from robust_ik.description.catalog import find
from robust_ik.singularities.find.find_points import find_points
from robust_ik.singularities.find.gradient_history import gradient_descent
from robust_ik.singularities.find.gradient_search import gradient_search
from robust_ik.singularities.find.projection_search import SearchEnds, project
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.lost_motion.sparse_basis import sparse_basis

STAND_INS = "robot, start and step are not told: PA-10, a start picked out of 300"


def claims() -> list[Claim]:
    """Every claim, section by section."""
    searches = [succeeded(2, "rotation makes it converge"), succeeded(3, "2 s a point in place of 40 s")]
    return [*descents(), *searches, printed_form(), *directions(), *regional(), *pa10()]


def signed(number: float, form: str) -> str:
    """With a minus sign that is one."""
    return f"{number:{form}}".replace("-", "−")


def vector(u: Array) -> str:
    """Three digits of each entry."""
    return f"({', '.join(signed(each, '.3f') for each in u)})"


def followed(corank: int, start: int, step: float | None, most: int) -> dict[str, Spread]:
    """One descent, begun again a hair's breadth away: where the weakest two meet, turns of the gradient, its end."""

    def measure(begin: Array) -> dict[str, float]:
        run = gradient_descent(chain(), corank, begin, step=step, max_iterations=most)
        near = run.weakest[:, 1] > 0.98 * run.weakest[:, 0]
        turns = np.degrees(run.turns)
        return {"met": int(np.argmax(near)), "turn": turns.max(), "mean": turns.mean(), "steps": len(run),
                "end": run.weakest[-1, 0], "least": run.weakest[:, 0].min(), "converged": run.converged}  # fmt: skip

    return spread(measure, starts()[start])


def descents() -> list[Claim]:
    """Figures 1 to 3."""
    most, epsilon = 4000, 1e-6
    plain = followed(2, *FIG_1, most)
    stuck = followed(3, *FIG_2, most)
    rotated = followed(3, FIG_3, None, 200)
    begin = starts()[FIG_3]
    projected = spread(lambda q: float(project(chain(), 3, q[None]).tries[0]), begin)
    alone = spread(lambda q: len(gradient_descent(chain(), 3, q, rotated=False)), begin)
    return [
        Claim(
            "Fig. 1: plain descent to corank 2", "σ5 ≈ σ6 near step 600, turns to 180°, about 3000 steps",
            {**plain, "most": most},
            "σ5 ≈ σ6 at step {met:.0f}, turns to {turn:.0f}°; {steps:.0f} steps, {most} at most",
            "300 < met < 1200 and turn > 170", "when it gets below ε is luck, a bounce off zero",
            f"{STAND_INS}, α a hundredth",
        ),
        Claim(
            "Fig. 2: plain descent to corank 3", "turns of 170°, σ4 never converges",
            {**stuck, "most": most, "epsilon": epsilon},
            "turns of {turn:.0f}°, σ4 = {end:.3f} after {most} steps", "turn > 120 and least > 1000 * epsilon",
            "it creeps and is far above ε, for how long is not known", f"{STAND_INS}, α two hundredths",
        ),
        Claim(
            "Fig. 3: clusters rotated, corank 3", "16 steps, mean turn 120°",
            {**rotated, "alone": alone, "projected": projected},
            "{steps:.0f} steps, mean turn {mean:.0f}°; without rotation {alone:.0f} steps, projection {projected:.0f}",
            "converged == 1 and steps < alone", "faster with the clusters rotated, if not as fast as there",
            f"{STAND_INS}; cluster tolerance and line searches are not told either",
        ),
    ]  # fmt: skip


def succeeded(corank: int, said: str, groups: int = 4, size: int = 60) -> Claim:
    """How many random starts lead each search to a corank, and in how many steps: ranges over groups of starts."""
    numbers: dict[str, Spread | int] = {"size": size, "groups": groups}
    for name, search in (("plain", plain), ("rotated", turned), ("projection", projection)):
        found = [search(corank, each) for each in np.split(starts()[: groups * size], groups)]
        numbers[name] = Spread(tuple(each.converged.mean() for each in found))
        numbers[f"{name}_steps"] = Spread(tuple(np.median(each.tries[each.converged]) for each in found))
    numbers["helped"] = Spread((numbers["rotated"].median - numbers["plain"].median,))
    return Claim(
        f"Sec. 2.2: corank {corank} from random starts", said, numbers,
        "of {groups} times {size} starts plain {plain:.0%}, {plain_steps:.0f} steps; rotated {rotated:.0%}, "
        "{rotated_steps:.0f} steps; projection {projection:.0%}, {projection_steps:.0f} steps",
        "helped > 0 and projection > rotated",
        "rotation helps, but often stalls: the entries beside the diagonal that (12) turns are left out",
        "robot, cluster tolerance and line searches are not told; seconds are the machine's",
    )  # fmt: skip


def plain(corank: int, begin: Array) -> SearchEnds:
    """The gradient of the one singular value."""
    return gradient_search(chain(), corank, begin, rotated=False, patience=50)


def turned(corank: int, begin: Array) -> SearchEnds:
    """With clusters rotated and combined."""
    return gradient_search(chain(), corank, begin, patience=50)


def projection(corank: int, begin: Array) -> SearchEnds:
    """All weak directions brought to zero together."""
    return project(chain(), corank, begin)


def printed_form() -> Claim:
    """Equation (9)."""
    J, difference, right, printed = derivatives(500)
    cosine = cosines(J, difference, printed)
    return Claim(
        "Eq. (9), branch k < i", "… − (z_kᵀz_i) p_k",
        {"printed": np.abs(printed - difference).max(), "right": np.abs(right - difference).max(), "noise": 1e-6,
         "median": np.median(cosine), "negative": np.mean(cosine < 0), "count": len(cosine)},
        "largest error {printed:.2f}; with p_i below {noise:.0e}", "printed < noise",
        "p_i is meant; cosine with the true ∇σ6: median {median:+.2f}, negative at {negative:.0%} of {count} places",
    )  # fmt: skip


def directions() -> list[Claim]:
    """Section 2.3 and Figure 4."""
    found = sparse_basis(np.linalg.qr(SUBSPACE)[0])
    robot, q = example_arm(), [0, 0, 0, 0, 0, 0, np.pi]
    ours = sparse_basis(rik.lost_directions(robot.jacobian(q)))
    other = sparse_basis(rik.lost_directions(rik.load("pa10").jacobian(np.zeros(7))))
    off, exact, table_2 = (apart(each) for each in (found, ours, other))
    blue = ours[:, np.abs(ours[2]).argmax()]
    return [
        Claim(
            "Sec. 2.3: rotated singular directions", "(.91 v_y, .41 w_z), (.91 v_z, −.41 w_y), w_x", {"off": off},
            "largest difference {off:.3f}", "off < 0.01", "quartimax reproduces it up to sign and order",
        ),
        Claim(
            "Fig. 4: which arm", "a 7-DoF robot, not told", {"exact": exact, "other": table_2},
            "Table 2 with a₇ = 9/20 and d₇ = 0: difference {exact:.3f}; the PA-10 of Table 2: {other:.2f}",
            "exact < 0.005 < other", "the PA-10 of Table 2 loses pure v_y, v_z, w_x",
        ),
        Claim(
            "Fig. 4, text: blue direction", "Y translation, −Z rotation",
            {"v_y": abs(blue[1]), "w_z": abs(blue[5]), "v_z": signed(blue[2], "+.2f"), "w_y": signed(blue[4], "+.2f")},
            "{v_z} v_z, {w_y} w_y", "v_y > 0.5 and w_z > 0.2", "the printed matrix says Z and −Y, too",
        ),
    ]  # fmt: skip


def apart(basis: Array) -> float:
    """Largest difference from the printed directions, whatever their signs and order."""
    return float(np.abs(np.sort(np.abs(basis), axis=1) - np.sort(np.abs(ROTATED), axis=1)).max())


def regional() -> list[Claim]:
    """The 4-DoF arm."""
    name = "almarkhi_4dof"
    modified = rik.Robot.from_dh(replace(rik.read_dh(find(name).path), convention="modified"))
    other = [rik.svd(modified.jacobian(q)).s[2] for q, _ in FIG_6]
    (a, far_a, u_a, off_a), (b, far_b, u_b, off_b) = lost_by_figure_6(0), lost_by_figure_6(1)
    (row,) = atlas(name)
    two = find_points(ScrewChain.of(rik.load(name)), 2, 200)
    return [
        Claim(
            "Fig. 5: 4-DoF arm", "corank 1 only, along curves",
            {"curves": len(atlas(name).curves(row)), "two": len(two), "highest": atlas(name).highest,
             "status": atlas(name).evidence[-1].status.name.lower(), "certified": "certified"},
            "{curves} closed curves of q2, q3, q4; corank 2 from {two} of 200 starts, {status}",
            "highest == 1 and curves > 0 and two == 0 and status == certified",
            "that there is no corank 2 is proved by a case split on the minors",
        ),
        Claim(
            "Fig. 6: configurations", "singular",
            {"a": a, "b": b, "far_a": far_a, "far_b": far_b, "other_a": other[0], "other_b": other[1],
             "rounding": 0.005 * np.sqrt(4)},
            "σ3 = {a:.4f}, {b:.4f}; {far_a:.4f}, {far_b:.4f} rad from singular ones", "max(far_a, far_b) < rounding",
            "rounded to two digits; under modified DH σ3 = {other_a:.2f}, {other_b:.2f}",
        ),
        Claim(
            "Fig. 6: u3", "(0, 1, 0), (−1, 0, 0)",
            {"a": vector(u_a), "b": vector(u_b), "off_a": off_a, "off_b": off_b}, "{a}, {b}",
            "max(off_a, off_b) < 1", "rounded to whole numbers: {off_a:.1f}° and {off_b:.1f}° off",
        ),
    ]  # fmt: skip


def pa10() -> list[Claim]:
    """Section 3.3."""
    found = atlas("pa10")
    rows = {k: {row.words for row in found.of_corank(k)} for k in (1, 2, 3)}
    pieces = {k: sum(row.components for row in found.of_corank(k)) for k in (1, 2, 3)}
    status = {each.corank: each.status.name.lower() for each in found.evidence}
    coranks = np.sum(rik.svd(rik.load("pa10").jacobian(FIG_9)).s < 1e-9, axis=1)
    listed = [
        Claim(
            f"Table {table}: corank {k} of the PA-10", "4 families",
            {"families": len(rows[k]), "pieces": pieces[k], "status": status[k], "said": len(said),
             "missing": len(said - rows[k]), "further": len(rows[k] - said)},
            "{families} families in {pieces} pieces, {status}", "missing == further == 0",
            "row by row, proved complete",
        )
        for table, k, said in ((3, 1, TABLE_3), (4, 2, TABLE_4))
    ]  # fmt: skip
    return [
        *listed, table_5(rows[3], pieces[3], status[3]),
        Claim(
            "Sec. 3.3: highest corank", "3", {"highest": found.highest, "status": status[4], "certified": "certified"},
            "{highest}; none of corank 4: {status}", "highest == 3 and status == certified",
            "that there is no corank 4 is proved",
        ),
        Claim(
            "Fig. 9: both configurations", "corank 3", {"a": coranks[0], "b": coranks[1]}, "coranks {a}, {b}",
            "a == b == 3", "to rounding",
        ),
    ]  # fmt: skip


def table_5(words: set[str], pieces: int, status: str) -> Claim:
    """The table that is cut in our copy, read in both ways that its last legible entry leaves."""
    third = np.zeros((181, 7))
    third[:, 2] = np.linspace(0.02, np.pi - 0.02, 181)
    return Claim(
        "Table 5: corank 3", "θ1 any, θ2 ∈ {±π, 0}, θ3 any, …",
        {"words": "; ".join(sorted(words)), "pieces": pieces, "status": status,
         "free": int(np.sum(rik.svd(rik.load("pa10").jacobian(third)).s < 1e-9, axis=1).max()),
         "listed": words == {" and ".join(f"q{joint} ∈ {{0, π}}" for joint in (2, 3, 4, 5, 6))}},
        "{words}: {pieces} pieces, {status}",
        {"“θ3 any” as it stands": "free == 3", "θ2 to θ6 all in {±π, 0}": "listed"},
        "θ3 free leaves corank {free}; the list found is proved complete", cut="our copy of the table is cut there",
    )  # fmt: skip
