"""Families of singular configurations as a table, with a card below each row. All text from outside is escaped."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from robust_ik.display.drawings.family_motions import Family
from robust_ik.display.pages.curve_panels import curve_panels
from robust_ik.display.pages.family_page_words import (
    axis_words,
    curvature_words,
    joint_words,
    limit_words,
    screw_words,
    twist_words,
)
from robust_ik.display.pages.run_table import number
from robust_ik.errors.safe_text import in_html
from robust_ik.singularities.atlas import cells
from robust_ik.singularities.conditions import RobotFacts

COLUMNS = 5
"""Number of columns: number, conditions, dimension, pieces, limits. Rows that span the whole table need it."""


def family_table(facts: RobotFacts, shown: Sequence[Family]) -> str:
    """HTML of the table; rows and their buttons have data-row with the index of the family."""
    head = (
        '<tr><th scope="col" class="number">#</th><th scope="col" class="what">condition, and what is lost</th>'
        '<th scope="col" class="dim">dim</th><th scope="col" class="pieces">pieces</th>'
        '<th scope="col" class="limits">joint limits</th></tr>'
    )
    bodies = []
    for corank, group in groupby(enumerate(shown), key=lambda pair: pair[1].stratum.corank):
        rows = "".join(_row(facts, index, family) for index, family in group)
        bodies.append(f"<tbody>{_heading(corank, _what(facts))}{rows}</tbody>")
    return f'<table class="families"><thead>{head}</thead>{"".join(bodies)}</table>'


def _what(facts: RobotFacts) -> tuple[str, str]:
    """What one corank, and a higher one, tells of an arm."""
    chain = facts.chain
    if chain.full_rank == chain.m:
        return "one direction is lost", "{} directions are lost at once"
    if chain.full_rank == chain.n:
        return "one motion of the joints does not move the tip", "{} motions of the joints do not move the tip"
    return "one more motion of the joints does not move the tip", "{} more motions of the joints do not move the tip"


def _heading(corank: int, what: tuple[str, str]) -> str:
    lost = what[0] if corank == 1 else what[1].format(corank)
    return (
        f'<tr class="corank"><th colspan="{COLUMNS}" scope="rowgroup">Corank {corank} <small>{lost}</small></th></tr>'
    )


def _row(facts: RobotFacts, index: int, family: Family) -> str:
    _, words, dimension, pieces, *_ = cells(family.stratum)
    lost = family.stratum.lost.words if family.stratum.lost else ""
    limits = limit_words(facts, family.stratum)
    return (
        f'<tr class="family" data-row="{index}"><td class="number">{index + 1}</td><th scope="row">'
        f'<button type="button" data-row="{index}" aria-expanded="false" aria-controls="card{index}">'
        f"{in_html(words)}</button><span>{in_html(lost)}</span></th>"
        f'<td class="dim">{dimension}</td><td class="pieces">{in_html(pieces)}</td>'
        f'<td class="limits"><span class="{"in" if family.stratum.within_limits else "out"}">{in_html(limits)}'
        f'</span></td></tr><tr class="detail" id="card{index}" hidden><td colspan="{COLUMNS}">{_card(facts, family)}'
        f"</td></tr>"
    )


CURVATURE = (
    "κ says how fast joints that move along a self-motion, by s in all, carry the tool along what is lost: by κ s²/2. "
    "Where it has one sign for all self-motions, the tool can leave to one side only"
)
"""What κ is, for those who have not read about it."""


def _card(facts: RobotFacts, family: Family) -> str:
    stratum, lost = family.stratum, family.lost
    way_out = [stratum.lost.way_out] if stratum.lost else []
    entries = [
        ("Equations", [*stratum.equations, *_unsaid(family)]),
        ("Free joints", [", ".join(f"q{joint + 1}" for joint in stratum.free) or "none"]),
        ("Example", [f"({', '.join(joint_words(facts, family.walk.values[0]))}), where the walk begins. There:"]),
        ("Lost, world axes", [twist_words(column) for column in lost.twists.T]),
        ("Lost, tool axes", [twist_words(column) for column in lost.tool_twists.T]),
        ("Borne wrench", [screw_words(screw) for screw in lost.screws]),
        ("Tool point", [f"{axis_words(lost.origin)} m"]),
        ("Way out", [*way_out, *(curvature_words(lost, index) for index in range(lost.corank)), CURVATURE]),
        ("Checked", [f"largest σ/σ₁ at random members: {stratum.residual:.1e}".replace("e-", "e−"), *_floor(family)]),
    ]
    listed = "".join(
        f"<dt>{in_html(name)}</dt><dd>{''.join(f'<p>{in_html(text)}</p>' for text in texts)}</dd>"
        for name, texts in entries
        if texts
    )
    panels = curve_panels(facts.chain, family.curves, family.walk.values[0])
    return (
        f'{panels}<dl><dt title="Where the walk begins, then as the robot moves">Joints now</dt>'
        f"<dd>{_joints(facts, family)}</dd>{listed}</dl>"
    )


def _unsaid(family: Family) -> list[str]:
    if not family.stratum.curve:
        return []
    names = ", ".join(f"q{joint + 1}" for joint in family.stratum.curve)
    return [f"{names} are coupled with no short relation: see above"]


def _floor(family: Family) -> list[str]:
    floor = family.stratum.floor
    return [f"σ of the model as given falls to {number(floor)} there"] if floor > 1e-9 else []


def _joints(facts: RobotFacts, family: Family) -> str:
    """Joint values at the start of the walk, which a script keeps up to date."""
    shown = "".join(
        f'<span>q{joint + 1} <output data-joint="{joint}">{word}</output></span>'
        for joint, word in enumerate(joint_words(facts, family.walk.values[0]))
    )
    outside = "" if family.inside or np.isinf(family.stratum.margin) else "<p>outside the joint limits</p>"
    return f'<div class="joints">{shown}</div>{outside}'
