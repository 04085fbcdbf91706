"""Parts shared by our pages around the 3D view: legend, player, and a note on missing meshes."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

from robust_ik.display.drawings.drawn_robot import MissingMesh
from robust_ik.display.scene.animation_tracks import Tracks
from robust_ik.display.scene.meshcat_module import Visualizer
from robust_ik.errors.safe_text import in_html

MOST_NAMED = 40
"""Most meshes that a notice names, one per line. Chosen: about a screen of lines; the others are counted."""
Entry = tuple[str, str, str, str]
"""An entry of a legend: the group that it hides, its icon, its name, its meaning."""


def stage(entries: Sequence[Entry], *, over: str = "", beside: str = "") -> str:
    """HTML of the view with a legend, and the player below.

    Args:
        entries: Entries of the legend; the first one of a group hides and shows the whole group.
        over: HTML that lies over the view.
        beside: HTML before the player's button.
    """
    legend = "".join(
        f'<li><button type="button" data-group="{group}" aria-pressed="true" title="{in_html(meaning)}">'
        f'<i class="icon {icon}"></i>{in_html(name)}</button></li>'
        for group, icon, name, meaning in entries
    )
    return f"""<section class="stage">
<div class="view">
<div id="pane"></div>
<ul class="legend">{legend}</ul>
{over}</div>
<div class="player">
{beside}<button type="button" id="play" aria-label="Play or pause"></button>
<input type="range" id="time" min="0" max="1" step="0.01" value="0" aria-label="Time">
<output id="clock">0.00 s</output>
</div>
</section>"""


def missing_notice(missing: Sequence[MissingMesh]) -> str:
    """HTML that says which meshes are not drawn, if any."""
    if not missing:
        return ""
    named = list(dict.fromkeys((lost.name, lost.reason) for lost in missing))
    lines = "".join(f"<li><code>{in_html(name)}</code> {in_html(reason)}</li>" for name, reason in named[:MOST_NAMED])
    more = f"<li>and {len(named) - MOST_NAMED} more</li>" if len(named) > MOST_NAMED else ""
    count = "One mesh is" if len(named) == 1 else f"{len(named)} meshes are"
    return (
        f'<details class="notice"{" open" if len(named) < 3 else ""}><summary>{count} not drawn; simple shapes '
        f"stand in</summary><ul>{lines}{more}</ul></details>"
    )


def animation_data(animation: Tracks, trail: Visualizer) -> dict[str, Any]:
    """The data of a motion for the player."""
    return {
        "animation": base64.b64encode(animation.packed()).decode("ascii"),
        "duration": float(animation.times[-1]),
        "frames": len(animation.times),
        "trail": node_parts(trail),
    }


def node_parts(node: Visualizer) -> list[str]:
    """The path of a node as the viewer's list of names."""
    return [part for part in node.path.lower().split("/") if part]
