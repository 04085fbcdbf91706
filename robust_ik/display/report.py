"""One page that shows what several inverses made of the same motion."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_ik.display.drawn_robot import MissingMesh
from robust_ik.display.marks import GAMMA
from robust_ik.display.names import distinct
from robust_ik.display.pack import packed_scene
from robust_ik.display.page import document
from robust_ik.display.results import results_charts, results_table, swatch
from robust_ik.display.runs import DrawnRuns, draw_runs
from robust_ik.display.scene import Scene
from robust_ik.display.shapes import Color
from robust_ik.errors import InputError
from robust_ik.files import write_file
from robust_ik.inverses import JParse
from robust_ik.trajectory import Trajectory

PALETTE = ("#1f77c9", "#e08a00", "#8e5bd0", "#12907f", "#b0552f", "#6b7785", "#c04f8f", "#7a8f1e")
MOST_NAMED = 40

_LEGEND = (
    ("lost", "arrow", "Lost translation", "The tip can hardly be moved along it any more; the longer, the less."),
    ("lost", "ring", "Lost rotation", "The tool can hardly be turned about its axis any more; the larger, the less."),
    ("ellipsoid", "ellipsoid", "Manipulability", "How fast the tip can move in each direction, joints at unit speed."),
    ("target", "target", "Target and its path", "Where the tip should be."),
    ("trail", "trail", "Trail of the tip", "Where the tip has been, in the colour of the method."),
)


def write_html(
    path: str | Path,
    trajectories: Mapping[str, Trajectory] | Sequence[Trajectory] | Trajectory,
    *,
    title: str = "",
    text: str = "",
    gamma: float = GAMMA,
) -> Path:
    """Writes one page, which needs nothing but itself: the runs in 3D, a button for each, results, charts.

    A run of JParse is shown first. `#method=NAME&t=SECONDS` behind the page's address opens it at a run and a time.

    Args:
        path: The file; folders on the way are made, what was there is replaced at once or not at all.
        trajectories: Runs of one robot, by what to call them; from a sequence each is called as its inverse is.
        title: Title of the page; default the robot's name.
        text: A sentence or two to put below the title.
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
        "groups": {kind: _parts(node.path.lower()) for kind, node in drawn.groups.items()},
        "runs": [
            {
                "name": name,
                "animation": base64.b64encode(animation.packed()).decode("ascii"),
                "duration": float(animation.times[-1]),
                "frames": len(animation.times),
                "trail": _parts(trail.path.lower()),
            }
            for name, animation, trail in zip(names, drawn.animations, drawn.trails)
        ],
    }
    return document(title, body, ["scene.css", "report.css"], ["scene.js", "report.js"], data)


def _named(
    trajectories: Mapping[str, Trajectory] | Sequence[Trajectory],
) -> tuple[list[str], list[Trajectory]]:
    """Names and runs, JParse's first."""
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
        f'<button type="button" data-run="{index}" aria-pressed="false">{swatch(color)}{html.escape(name)}</button>'
        for index, (name, color) in enumerate(zip(names, colors))
    )
    return f"""<main>
<section class="stage">
<div class="view">
<div id="pane"></div>
<ul class="legend">{_legend(drawn)}</ul>
</div>
<div class="player">
<button type="button" id="play" aria-label="Play or pause"></button>
<input type="range" id="time" min="0" max="1" step="0.01" value="0" aria-label="Time">
<output id="clock">0.00 s</output>
</div>
</section>
<aside>
<h1>{html.escape(title)}</h1>
<p class="facts">{html.escape(facts)}</p>
{f"<p>{html.escape(text)}</p>" if text else ""}
{_notice(drawn.robot.missing_meshes)}
<div class="methods" role="group" aria-label="Method">{buttons}</div>
{results_charts(runs, colors)}
<div class="scroll">{results_table(names, runs, colors)}</div>
</aside>
</main>"""


def _legend(drawn: DrawnRuns) -> str:
    """Entries that hide and show what they name; the first of a group does so for all of it."""
    entries = []
    for group, icon, name, meaning in _LEGEND:
        if group == "ellipsoid" and not drawn.ellipsoid_scale:
            continue
        entries.append(
            f'<li><button type="button" data-group="{group}" aria-pressed="true" title="{meaning}">'
            f'<i class="icon {icon}"></i>{name}</button></li>'
        )
    return "".join(entries)


def _notice(missing: Sequence[MissingMesh]) -> str:
    """Says which meshes are not drawn, if any."""
    if not missing:
        return ""
    named = list(dict.fromkeys((lost.name, lost.reason) for lost in missing))
    lines = "".join(
        f"<li><code>{html.escape(name)}</code> {html.escape(reason)}</li>" for name, reason in named[:MOST_NAMED]
    )
    more = f"<li>and {len(named) - MOST_NAMED} more</li>" if len(named) > MOST_NAMED else ""
    count = "One mesh is" if len(named) == 1 else f"{len(named)} meshes are"
    return (
        f'<details class="notice"{" open" if len(named) < 3 else ""}><summary>{count} not drawn; simple shapes '
        f"stand in</summary><ul>{lines}{more}</ul></details>"
    )


def _rgba(color: str) -> Color:
    red, green, blue = (int(color[start : start + 2], 16) / 255 for start in (1, 3, 5))
    return red, green, blue, 1.0


def _parts(path: str) -> list[str]:
    return [part for part in path.split("/") if part]
