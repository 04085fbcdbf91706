"""What every command shares: the terminal, the arguments that name a robot, files by its name."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

console = Console()
errors = Console(stderr=True)

RobotArgument = Annotated[
    str,
    typer.Argument(metavar="ROBOT", help="A name from 'robust-ik robots', a .urdf path, or a DH table (.toml)."),
]
TipOption = Annotated[
    str | None,
    typer.Option("--tip", metavar="FRAME", help="Link or joint frame to move. Default: the tool frame."),
]
PackageDirOption = Annotated[
    list[Path] | None,
    typer.Option("--package-dir", metavar="DIR", help="Where packages lie that mesh paths name. Repeatable."),
]
WorkersOption = Annotated[
    int, typer.Option("--workers", metavar="N", help="Processes that share the work. Results do not depend on it.")
]


def file_name(name: str) -> str:
    """A robot's name as part of a file's."""
    return "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in name)
