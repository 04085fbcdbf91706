"""The page of a live view: its parts, empty; the script fills them with what it is told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from robust_ik.display.drawings.drawn_robot import MissingMesh
from robust_ik.display.live.live_session import inverses
from robust_ik.display.pages.viewer_html import missing_notice
from robust_ik.display.scene.html_page import document
from robust_ik.errors.safe_text import in_html, visible
from robust_ik.kinematics.rotation_vectors import rotation_vector
from robust_ik.robot.robot import Robot

LEGEND = (
    ("lost", "arrow", "lost motion", "The tool cannot move that way: arrows for translation, rings for rotation."),
    ("ellipsoid", "ellipsoid", "how fast it can move", "Tool velocities at unit joint speed (Yoshikawa 1985)."),
    ("target", "target", "target", "Where the tool should be; drag it."),
    ("ghosts", "ghost", "ghosts", "Nearest singular configuration (purple), all solutions of this pose (orange)."),
)
"""What can be hidden: its node, icon, name and meaning."""


def live_body(robot: Robot, missing: Sequence[MissingMesh], host: str) -> str:
    """The page of a robot.

    Args:
        robot: A robot with a tip.
        missing: Meshes that are not drawn.
        host: The server's host and port: the only one to which the page connects.
    """
    legend = "".join(
        f'<li><button type="button" data-group="{node}" aria-pressed="true" title="{in_html(meaning)}">'
        f'<i class="icon {icon}"></i>{in_html(name)}</button></li>'
        for node, icon, name, meaning in LEGEND
    )
    body = f"""<main class="live">
<section class="stage"><div class="view"><div id="pane"></div><ul class="legend">{legend}</ul></div>
<p id="said" role="status" aria-live="polite"></p></section>
<aside>
<h1>{in_html(robot.name)}</h1>
<p class="facts">{robot.n} joints, tip {in_html(robot.tip)}, rows {in_html(" ".join(robot.rows))}
<span id="gone" hidden>· the program has ended: this page shows where it was last</span></p>
{missing_notice(missing)}
<section><h2>Joints <button type="button" id="unit" aria-pressed="true">degrees</button>
<button type="button" id="rest">to rest</button></h2><div id="joints"></div></section>
<section><h2>Tool</h2><div id="tool"></div>
<p class="hint">Drag the green ball, or choose it and use arrow keys, Page Up and Page Down (Shift: finer).</p>
<button type="button" id="target">target: <span id="where"></span></button></section>
<section><h2>Singular values</h2>
<label>inverse <select id="inverse"></select></label><span id="parameters"></span>
<div id="sigma" role="img" aria-label="Singular values"></div><p id="measures"></p><ul id="weak"></ul></section>
<section><h2>Self-motion</h2><p class="hint" id="still"></p><div id="self"></div></section>
<section><h2>Nearest singular configuration</h2><p id="nearby">…</p></section>
<section><h2>Families <progress id="searched" max="1" value="0"></progress></h2>
<p id="note"></p><ol id="families"></ol></section>
<section><h2>All solutions of this pose <button type="button" id="solutions">find</button></h2>
<p id="status"></p><ol id="found"></ol></section>
<section><h2>Take along</h2><button type="button" id="python">copy as Python</button>
<button type="button" id="json">copy as JSON</button>
<textarea id="copied" rows="4" readonly hidden></textarea></section>
</aside></main>"""
    styles, scripts = ["scene.css", "report.css", "view.css"], ["scene.js", "player.js", "view.js"]
    return document(f"{robot.name}: live", body, styles, scripts, _data(robot), f"ws://{host}")


def _data(robot: Robot) -> dict[str, Any]:
    """What the script must know once."""
    turning = [robot.description.joint[name].kind != "prismatic" for name in robot.joint_names]
    finite = [None if not np.isfinite(each) else float(each) for each in (*robot.lower, *robot.upper)]
    pose = robot.pose(robot.rest)
    return {
        "name": visible(robot.name),
        "joints": [visible(name) for name in robot.joint_names],
        "turning": turning,
        "lower": finite[: robot.n],
        "upper": finite[robot.n :],
        "size": robot.size,
        "inverses": inverses(),
        "nodes": {node: ["meshcat", node] for node, *_ in LEGEND},
        "pose": {"position": pose[:3, 3].tolist(), "rotation": rotation_vector(pose[:3, :3]).tolist()},
    }
