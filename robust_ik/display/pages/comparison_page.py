"""A page that compares several inverses on the same motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_ik.checks.public_arguments import checked
from robust_ik.display.drawings.drawn_runs import DrawnRuns, draw_runs
from robust_ik.display.drawings.marks import GAMMA
from robust_ik.display.pages.run_table import results_charts, results_table, swatch
from robust_ik.display.pages.viewer_html import Entry, animation_data, missing_notice, node_parts, stage
from robust_ik.display.scene.html_page import document
from robust_ik.display.scene.node_names import distinct
from robust_ik.display.scene.packed_scene import packed_scene
from robust_ik.display.scene.primitives import Color
from robust_ik.display.scene.scene import Scene
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import in_html
from robust_ik.inverses import JParse
from robust_ik.runtime.output_files import write_file
from robust_ik.simulation.trajectory import Trajectory

PALETTE = ("#1f77c9", "#e08a00", "#8e5bd0", "#12907f", "#b0552f", "#6b7785", "#c04f8f", "#7a8f1e")

_LEGEND: tuple[Entry, ...] = (
    ("lost", "arrow", "Lost translation", "The tip can hardly be moved along it any more; the longer, the less."),
    ("lost", "ring", "Lost rotation", "The tool can hardly be turned about its axis any more; the larger, the less."),
    ("ellipsoid", "ellipsoid", "Manipulability", "How fast the tip can move in each direction, joints at unit speed."),
    ("target", "target", "Target and its path", "Where the tip should be."),
    ("trail", "trail", "Trail of the tip", "Where the tip has been, in the colour of the method."),
)


@checked
def write_html(
    path: str | Path,
    trajectories: Mapping[str, Trajectory] | Sequence[Trajectory] | Trajectory,
    *,
    title: str = "",
    text: str = "",
    gamma: float = GAMMA,
) -> Path:
    """Writes one self-contained page: the runs in 3D, a button for each, results, charts.

    A run of JParse is shown first. `#method=NAME&t=SECONDS` behind the page's address opens it at a run and a time.

    Args:
        path: The file; a missing folder is made, an existing file is replaced at once or not at all.
        trajectories: Runs of one robot by name; in a sequence each has the name of its inverse.
        title: Title of the page; default the robot's name.
        text: A sentence or two below the title.
        gamma: A direction counts as being lost below this fraction of the largest singular value.

    Returns:
        The path.

    Raises:
        InputError: There is no run, the runs are of different robots, or the path is a folder.
    """
    if isinstance(trajectories, Trajectory):
        trajectories = [trajectories]
    return write_file(path, report_page(trajectories, title=title, text=text, gamma=gamma))


def report_page(
    trajectories: Mapping[str, Trajectory] | Sequence[Trajectory],
    *,
    title: str = "",
    text: str = "",
    gamma: float = GAMMA,
) -> str:
    """The page that `write_html` writes."""
    names, runs = _named(trajectories)
    colors = [PALETTE[index % len(PALETTE)] for index in range(len(runs))]
    scene = Scene()
    drawn = draw_runs(scene, runs, [_rgba(color) for color in colors], gamma)
    title = title or runs[0].robot.name
    body = _body(title, text, names, runs, colors, drawn)
    data = {
        "scene": packed_scene(scene.commands),
        "groups": {kind: node_parts(node) for kind, node in drawn.groups.items()},
        "runs": [
            {"name": name} | animation_data(animation, trail)
            for name, animation, trail in zip(names, drawn.animations, drawn.trails)
        ],
    }
    return document(title, body, ["scene.css", "report.css"], ["scene.js", "player.js", "report.js"], data)


def _named(
    trajectories: Mapping[str, Trajectory] | Sequence[Trajectory],
) -> tuple[list[str], list[Trajectory]]:
    """Names and runs, with JParse's first."""
    if isinstance(trajectories, Mapping):
        named = [(str(name), run) for name, run in trajectories.items()]
    else:
        named = [(run.name, run) for run in trajectories]
    if not named:
        raise InputError("there is no run to show: give at least one Trajectory")
    named.sort(key=lambda pair: pair[1].name != JParse.__name__)
    return distinct(name for name, _ in named), [run for _, run in named]


def _body(
    title: str, text: str, names: Sequence[str], runs: Sequence[Trajectory], colors: Sequence[str], drawn: DrawnRuns
) -> str:
    robot = runs[0].robot
    facts = f"{robot.name} · {robot.n} joints · tip {robot.tip} · task {' '.join(robot.rows)}"
    buttons = "".join(
        f'<button type="button" data-run="{index}" aria-pressed="false">{swatch(color)}{in_html(name)}</button>'
        for index, (name, color) in enumerate(zip(names, colors))
    )
    return f"""<main>
{stage(_legend(drawn))}
<aside>
<h1>{in_html(title)}</h1>
<p class="facts">{in_html(facts)}</p>
{f"<p>{in_html(text)}</p>" if text else ""}
{missing_notice(drawn.robot.missing_meshes)}
<div class="methods" role="group" aria-label="Method">{buttons}</div>
{results_charts(runs, colors)}
<div class="scroll">{results_table(names, runs, colors)}</div>
</aside>
</main>"""


def _legend(drawn: DrawnRuns) -> list[Entry]:
    return [entry for entry in _LEGEND if drawn.ellipsoid_scale or entry[0] != "ellipsoid"]


def _rgba(color: str) -> Color:
    red, green, blue = (int(color[start : start + 2], 16) / 255 for start in (1, 3, 5))
    return red, green, blue, 1.0
