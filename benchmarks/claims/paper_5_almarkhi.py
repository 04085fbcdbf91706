"""Almarkhi and Maciejewski 2019, "Singularity analysis for redundant manipulators of arbitrary kinematic structure"."""

from __future__ import annotations

import time
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
from benchmarks.claims.claim import TypedClaim as Claim
from robust_ik.catalog import find
from robust_ik.singularities.descent import Search, project
from robust_ik.singularities.finder import find_points
from robust_ik.singularities.gradient import gradient_search
from robust_ik.singularities.history import descend
from robust_ik.singularities.kinematics import ScrewChain
from robust_ik.singularities.sparse import sparse_basis


def claims() -> list[Claim]:
    return [*_descents(), *_printed_form(), *_directions(), *_regional(), *_pa10()]


def _holds(so: object) -> str:
    return "holds" if so else "wrong"


def _signed(number: float, form: str) -> str:
    return f"{number:{form}}".replace("-", "−")


def _vector(u: np.ndarray) -> str:
    return f"({', '.join(_signed(each, '.3f') for each in u)})"


def _descents() -> list[Claim]:
    plain = descend(chain(), 2, starts()[FIG_1[0]], step=FIG_1[1], most=4000)
    stuck = descend(chain(), 3, starts()[FIG_2[0]], step=FIG_2[1], most=4000)
    rotated = descend(chain(), 3, starts()[FIG_3])
    met = [int(np.argmax(each.weakest[:, 1] > 0.98 * each.weakest[:, 0])) for each in (plain, stuck)]
    turns = [np.degrees(each.turns.max()) for each in (plain, stuck)]
    end = f"below ε after {len(plain)}" if plain.converged else f"not below ε in {len(plain)}"
    projected = project(chain(), 3, starts()[[FIG_2[0], FIG_3]])
    return [
        Claim(
            "Fig. 1: plain descent to corank 2", "σ5 ≈ σ6 near step 600, turns to 180°, about 3000 steps",
            f"σ5 ≈ σ6 at step {met[0]}, turns to {turns[0]:.0f}°, {end}", "holds in kind",
            "robot, start, step are not told: PA-10, a start picked out of 300, α = 0.01; when it ends is luck",
        ),
        Claim(
            "Fig. 2: plain descent to corank 3", "turns of 170°, σ4 never converges",
            f"turns of {turns[1]:.0f}°, σ4 = {stuck.weakest[-1, 0]:.2f} after {len(stuck)} steps", "holds in kind",
            "stand-ins as above, α = 0.02; it creeps and is far above ε, for how long is not known",
        ),
        Claim(
            "Fig. 3: clusters rotated, corank 3", "16 steps, mean turn 120°",
            f"{len(rotated)} steps, mean turn {np.degrees(rotated.turns.mean()):.0f}°; projection {projected.tries[1]}",
            "holds in kind", "robot, cluster tolerance and line searches are not told; a start picked out of 300",
        ),
        *_success(),
    ]  # fmt: skip


def _success(count: int = 60) -> list[Claim]:
    found = []
    for corank, said in ((2, "rotation makes it converge"), (3, "under 2 s a point, 40 s without rotation")):
        cells = []
        for name, search in (("plain", _plain), ("rotated", _rotated), ("projection", _projected)):
            begin = time.perf_counter()
            each = search(corank, starts()[:count])
            took = (time.perf_counter() - begin) / max(int(each.converged.sum()), 1)
            steps = np.median(each.tries[each.converged])
            cells.append(f"{name} {each.converged.mean():.0%}, {steps:.0f} steps, {1e3 * took:.1f} ms a point")
        found.append(
            Claim(
                f"Sec. 2.2: corank {corank} from {count} random starts", said, "; ".join(cells), "holds in kind",
                "rotation helps, but often stalls: the entries beside the diagonal that (12) turns are left out",
            )
        )  # fmt: skip
    return found


def _plain(corank: int, begin: np.ndarray) -> Search:
    return gradient_search(chain(), corank, begin, rotated=False, patience=50)


def _rotated(corank: int, begin: np.ndarray) -> Search:
    return gradient_search(chain(), corank, begin, patience=50)


def _projected(corank: int, begin: np.ndarray) -> Search:
    return project(chain(), corank, begin)


def _printed_form() -> list[Claim]:
    J, difference, right, printed = derivatives(500)
    wrong, good = np.abs(printed - difference).max(), np.abs(right - difference).max()
    cosine = cosines(J, difference, printed)
    return [
        Claim(
            "Eq. (9), branch k < i", "… − (z_kᵀz_i) p_k", f"largest error {wrong:.2f}; with p_i {good:.0e}",
            "wrong" if wrong > 1e-3 > good else "open",
            f"p_i is meant; cosine with the true ∇σ6: median {np.median(cosine):+.2f}, negative at "
            f"{np.mean(cosine < 0):.0%} of 500 configurations",
        )
    ]  # fmt: skip


def _directions() -> list[Claim]:
    found = sparse_basis(np.linalg.qr(SUBSPACE)[0])
    off = np.abs(np.sort(np.abs(found), axis=1) - np.sort(np.abs(ROTATED), axis=1)).max()
    robot, q = example_arm(), [0, 0, 0, 0, 0, 0, np.pi]
    ours = sparse_basis(rik.lost_directions(robot.jacobian(q)))
    exact = np.abs(np.sort(np.abs(ours), axis=1) - np.sort(np.abs(ROTATED), axis=1)).max()
    blue = ours[:, np.abs(ours[2]).argmax()]
    return [
        Claim(
            "Sec. 2.3: rotated singular directions", "(.91 v_y, .41 w_z), (.91 v_z, −.41 w_y), w_x",
            f"largest difference {off:.3f}", _holds(off < 0.01), "quartimax reproduces it up to sign and order",
        ),
        Claim(
            "Fig. 4: which arm", "a 7-DoF robot, not told", f"Table 2 with a7 = .45, d7 = 0: difference {exact:.3f}",
            _holds(exact < 0.005), "not the PA-10 of Table 2: that one loses pure v_y, v_z, w_x",
        ),
        Claim(
            "Fig. 4, text: blue direction", "Y translation, −Z rotation",
            f"{_signed(blue[2], '+.2f')} v_z, {_signed(blue[4], '+.2f')} w_y", "wrong",
            "the printed matrix says Z and −Y, too",
        ),
    ]  # fmt: skip


def _regional() -> list[Claim]:
    name = "almarkhi_4dof"
    modified = rik.Robot.from_dh(replace(rik.read_dh(find(name).path), convention="modified"))
    other = [rik.svd(modified.jacobian(q)).s[2] for q, _ in FIG_6]
    (a, far_a, u_a, off_a), (b, far_b, u_b, off_b) = lost_by_figure_6(0), lost_by_figure_6(1)
    (row,) = atlas(name)
    two = find_points(ScrewChain.of(rik.load(name)), 2, 200)
    words = f"{len(atlas(name).curves(row))} closed curves of q2, q3, q4; corank 2 from {len(two)} of 200 starts"
    return [
        Claim(
            "Fig. 5: 4-DoF arm", "corank 1 only, along curves",
            f"{words}, {atlas(name).evidence[-1].status.name.lower()}",
            _holds(atlas(name).highest == 1), "that there is no corank 2 is proved by a case split on the minors",
        ),
        Claim(
            "Fig. 6: configurations", "singular",
            f"σ3 = {a:.4f}, {b:.4f}; {far_a:.4f}, {far_b:.4f} rad from singular ones",
            _holds(max(far_a, far_b) < 0.0051),
            f"rounded to two digits; under modified DH σ3 = {other[0]:.2f}, {other[1]:.2f}",
        ),
        Claim(
            "Fig. 6: u3", "(0, 1, 0), (−1, 0, 0)", f"{_vector(u_a)}, {_vector(u_b)}", "wrong",
            f"rounded to whole numbers: {off_a:.1f}° and {off_b:.1f}° off",
        ),
    ]  # fmt: skip


def _pa10() -> list[Claim]:
    rows = {k: {row.words for row in atlas("pa10").of_corank(k)} for k in (1, 2, 3)}
    pieces = {k: sum(row.components for row in atlas("pa10").of_corank(k)) for k in (1, 2, 3)}
    status = {each.corank: each.status.name.lower() for each in atlas("pa10").evidence}
    robot = rik.load("pa10")
    third = np.zeros((181, 7))
    third[:, 2] = np.linspace(0.02, np.pi - 0.02, 181)
    highest = int(np.sum(rik.svd(robot.jacobian(third)).s < 1e-9, axis=1).max())
    coranks = np.sum(rik.svd(robot.jacobian(FIG_9)).s < 1e-9, axis=1)
    words = "{} families in {} pieces, {}"
    return [
        Claim(
            "Table 3: corank 1 of the PA-10", "4 families",
            words.format(len(rows[1]), pieces[1], status[1]), _holds(rows[1] == TABLE_3), "row by row, proved complete",
        ),
        Claim(
            "Table 4: corank 2", "4 families",
            words.format(len(rows[2]), pieces[2], status[2]), _holds(rows[2] == TABLE_4), "row by row, proved complete",
        ),
        Claim(
            "Table 5: corank 3", "θ1 any, θ2 ∈ {±π, 0}, θ3 any, …", f"{rows[3].pop()}: {pieces[3]} pieces, {status[3]}",
            "wrong" if highest < 3 else "open",
            f"our copy of the table is cut there; θ3 free leaves corank {highest}; the list found is proved complete",
        ),
        Claim(
            "Sec. 3.3: highest corank", "3", f"{atlas('pa10').highest}; none of corank 4: {status[4]}",
            _holds(atlas("pa10").highest == 3), "that there is no corank 4 is proved",
        ),
        Claim(
            "Fig. 9: both configurations", "corank 3", f"coranks {coranks[0]}, {coranks[1]}",
            _holds((coranks == 3).all()), "to rounding",
        ),
    ]  # fmt: skip
