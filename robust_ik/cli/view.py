"""`robust-ik view`."""

from __future__ import annotations

import threading
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from robust_ik.cli.shared import (
    BaseOption,
    PackageDirOption,
    RobotArgument,
    TipOption,
    XacroOption,
    console,
    load_robot,
)
from robust_ik.errors.safe_text import in_markup


def view(
    robot: RobotArgument,
    tip: TipOption = None,
    atlas: Annotated[
        Path | None,
        typer.Option("--atlas", metavar="FILE.json", help="An atlas that was saved; else families are searched."),
    ] = None,
    port: Annotated[int, typer.Option("--port", metavar="N", help="TCP port. Default: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Move a robot in the browser, and see what it cannot do there; Ctrl-C ends it."""
    from robust_ik import display
    from robust_ik.singularities import SingularityAtlas

    known = None if atlas is None else SingularityAtlas.load(atlas)
    arm = load_robot(robot, tip, package_dir, xacro_arg, base)
    with console.status("drawing the robot …"):
        page = display.view(arm, port=port, atlas=known)
    with page:
        for mesh in page.missing_meshes:
            console.print(f"[yellow]not drawn:[/] {in_markup(mesh.name)}", soft_wrap=True)
        console.print(f"Open in a browser on this machine: [bold]{in_markup(page.url)}[/]", soft_wrap=True)
        console.print("Who has this address can move what is shown. Ctrl-C ends it.")
        if browser:
            webbrowser.open(page.url)
        threading.Event().wait()
