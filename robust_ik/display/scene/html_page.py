"""Self-contained HTML pages: everything is inline, nothing is fetched, and only our own scripts run."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from string import Template
from typing import Any

from robust_ik.display.scene.meshcat_module import VIEWER_FOLDER
from robust_ik.display.scene.packed_scene import packed_scene
from robust_ik.errors.safe_text import in_html


def scene_page(commands: Iterable[bytes], title: str) -> str:
    """A page that shows a scene, given by its packed commands."""
    return document(title, '<div id="pane"></div>', ["scene.css"], ["scene.js", "still.js"], packed_scene(commands))


def live_page(host: str) -> str:
    """The page of a live server; it asks that server, at host:port, for the scene."""
    return document("robust_ik", '<div id="pane"></div>', ["scene.css"], ["scene.js", "live.js"], None, f"ws://{host}")


def document(title: str, body: str, styles: Iterable[str], scripts: Iterable[str], data: Any, connect: str = "") -> str:
    """A complete page.

    Args:
        title: Its title, any text.
        body: HTML of the body, in which all text from outside must be escaped.
        styles: Names of our style sheets.
        scripts: Names of our scripts, which run after meshcat's viewer.
        data: Data for the scripts, which read `JSON.parse(document.getElementById("data").textContent)`.
        connect: The only address to which it may connect, if any.
    """
    running = [_viewer(), "\n".join(asset(name) for name in scripts)]
    # Only scripts with these hashes run: markup that slipped in through a name could do nothing.
    allowed = " ".join(f"'sha256-{_sum(script)}'" for script in running)
    policy = f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data: blob:" + (
        f"; connect-src {connect}" if connect else ""
    )
    return Template(asset("page.html")).substitute(
        title=in_html(title),
        policy=html.escape(policy),
        style="\n".join(asset(name) for name in styles),
        body=body,
        data=json.dumps(data, ensure_ascii=True, separators=(",", ":")).replace("<", "\\u003c"),
        viewer=running[0],
        script=running[1],
    )


@cache
def asset(name: str) -> str:
    """The content of a file in `assets/`."""
    return (files("robust_ik.display") / "assets" / name).read_text(encoding="utf-8")


@cache
def _viewer() -> str:
    """Meshcat's viewer, escaped for use between script tags."""
    text = (VIEWER_FOLDER / "main.min.js").read_text(encoding="utf-8")
    return text.replace("\r\n", "\n").replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _sum(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
