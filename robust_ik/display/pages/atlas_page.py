"""A page that shows every family of singular configurations of an arm."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robust_ik.checks.public_arguments import checked
from robust_ik.display.drawings.drawn_families import DrawnFamilies, DrawnMotion, draw_families
from robust_ik.display.drawings.family_motions import Family, ShownMotion, families
from robust_ik.display.pages.family_page_words import shown_values, turning_freely, twist_words, units
from robust_ik.display.pages.family_table import family_table
from robust_ik.display.pages.viewer_html import Entry, animation_data, missing_notice, node_parts, stage
from robust_ik.display.scene.html_page import document
from robust_ik.display.scene.packed_scene import packed_scene
from robust_ik.display.scene.scene import Scene
from robust_ik.errors.safe_text import in_html
from robust_ik.robot.robot import Robot
from robust_ik.runtime.output_files import write_file
from robust_ik.singularities.atlas import SingularityAtlas
from robust_ik.singularities.conditions import RobotFacts
from robust_ik.singularities.lost_motion import FLAT, sides
from robust_ik.singularities.trace import within_limits

PURE = 1e-6
"""A translation with a smaller rotation part than this is pure, and vice versa."""

_LEGEND: tuple[Entry, ...] = (
    ("lost", "arrow", "Lost translation", "No joint motion moves the tip along it; longer where more is lost."),
    ("lost", "ring", "Lost rotation", "No joint motion turns the tool about its axis."),
    (
        "wrench",
        "wrench",
        "Wrench it bears",
        "A load that the structure holds by itself, since no joint does work on it: line of a force, ring of a couple.",
    ),
    ("trail", "trail", "Path of the tip", "Where the tip comes in this motion."),
)
_MOTIONS = (
    '<div class="motions" role="group" aria-label="ShownMotion"><button type="button" data-motion="walk" '
    'aria-pressed="true">Through the family</button><button type="button" data-motion="sway" aria-pressed="false">'
    "Way out</button></div>"
)


@checked
def write_atlas_html(path: str | Path, atlas: SingularityAtlas, robot: Robot, *, title: str = "") -> Path:
    """Writes one self-contained page: every family in 3D and in numbers.

    `#row=NUMBER&t=SECONDS` behind the page's address opens it at a row and a time; `&motion=sway` on the way out.

    Args:
        path: The file; a missing folder is made, an existing file is replaced at once or not at all.
        atlas: An atlas from `find_singularities`.
        robot: Its robot.
        title: Title of the page; default "Singularities of" the robot.

    Returns:
        The path.

    Raises:
        InputError: The atlas is of another robot, or the path is a folder.
    """
    return write_file(path, atlas_page(atlas, robot, title=title))


def atlas_page(atlas: SingularityAtlas, robot: Robot, *, title: str = "") -> str:
    """The page that `write_atlas_html` writes."""
    shown = families(atlas, robot)
    scene = Scene()
    drawn = draw_families(scene, robot, shown)
    title = title or f"Singularities of {atlas.robot.name}"
    data = {
        "scene": packed_scene(scene.commands),
        "groups": {kind: node_parts(node) for kind, node in drawn.groups.items()},
        "units": units(atlas.robot),
        "turning": turning_freely(atlas.robot),
        "rows": [
            {
                "walk": _motion_data(atlas.robot, walk, _walk_caption(family)),
                "sway": _motion_data(atlas.robot, sway, _sway_caption(atlas.robot, family)),
            }
            for family, walk, sway in zip(shown, drawn.walks, drawn.sways)
        ],
    }
    styles, scripts = ["scene.css", "report.css", "atlas.css"], ["scene.js", "player.js", "atlas.js"]
    return document(title, _body(title, atlas, robot, shown, drawn), styles, scripts, data)


def _motion_data(facts: RobotFacts, drawn: DrawnMotion, caption: str) -> dict[str, Any]:
    return animation_data(drawn.animation, drawn.trail) | {"caption": caption, "values": _packed(facts, drawn.motion)}


def _packed(facts: RobotFacts, motion: ShownMotion) -> str:
    """Joint values of all frames in degrees or m, as packed 32-bit numbers."""
    return base64.b64encode(shown_values(facts, motion.values).astype(np.float32).tobytes()).decode("ascii")


def _walk_caption(family: Family) -> str:
    stratum = family.stratum
    moving = []
    if stratum.free:
        moving.append(f"{', '.join(f'q{joint + 1}' for joint in stratum.free)} may have any value")
    coupled = sorted({joint for curve in family.curves for joint in curve.joints})
    if coupled:
        moving.append(f"{', '.join(f'q{joint + 1}' for joint in coupled)} move together")
    where = "" if family.inside or np.isinf(stratum.margin) else ". Outside the joint limits"
    return f"Singular all the way: {'; '.join(moving) or 'no joint can move'}{where}."


def _sway_caption(facts: RobotFacts, family: Family) -> str:
    """The caption of the motion out of the family."""
    way, beyond = family.way, "" if within_limits(facts, family.way.values) else " Partly outside the joint limits."
    if abs(way.curvature) < FLAT:
        return f"Joints along a self-motion: to second order the tool gains nothing along what is lost.{beyond}"
    low, high = family.lost.curvature[way.direction].tolist()
    both = sides(low, high) == 2
    other = "another self-motion leads to the other side" if both else "to the other side there is no way"
    return f"Joints along a self-motion, either way: the tool leaves {_leaving(family)}; {other}.{beyond}"


def _leaving(family: Family) -> str:
    """Where the way out leads, if there are short words for it."""
    twist = np.sign(family.way.curvature) * family.lost.twists[:, family.way.direction]
    pure = min(float(np.linalg.norm(twist[:3])), float(np.linalg.norm(twist[3:]))) < PURE
    return f"by {twist_words(twist)}" if pure else "along what is lost"


def _listed(sentences: Sequence[str]) -> str:
    return f'<ul class="sure">{"".join(f"<li>{in_html(sentence)}.</li>" for sentence in sentences)}</ul>'


def _body(title: str, atlas: SingularityAtlas, robot: Robot, shown: Sequence[Family], drawn: DrawnFamilies) -> str:
    facts = atlas.robot
    count = f"{len(shown)} families" if len(shown) != 1 else "1 family"
    known = f"{facts.name} · {robot.n} joints · tip {facts.tip} · task {' '.join(facts.chain.rows)} · {count}"
    caption = '<p class="caption" id="caption"></p>\n' if shown else ""
    interrupted = (
        '<p class="notice">The search was stopped: there may be more families.</p>' if atlas.interrupted else ""
    )
    nearly = f"<h2>Nearly singular</h2>\n{_listed(atlas.nearness)}\n" if atlas.nearness else ""
    table = family_table(facts, shown) if shown else "<p>No family of singular configurations was found.</p>"
    return f"""<main class="atlas{"" if shown else " empty"}">
{stage(_LEGEND if shown else (), over=caption, beside=_MOTIONS if shown else "")}
<aside>
<h1>{in_html(title)}</h1>
<p class="facts">{in_html(known)}</p>
{missing_notice(drawn.robot.missing_meshes)}{interrupted}
{table}
{nearly}<h2>How sure this is</h2>
{_listed(atlas.sureness)}
</aside>
</main>"""
