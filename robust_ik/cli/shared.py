"""Shared by all commands: the terminal, the arguments that name a robot, file names."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer
from rich.console import Console

from robust_ik.errors import InputError, cut
from robust_ik.errors.safe_text import in_markup
from robust_ik.runtime.files import checked_folders
from robust_ik.runtime.output_files import check_figure, check_outputs

if TYPE_CHECKING:
    from robust_ik.robot.mobile_base import Base
    from robust_ik.robot.robot import Robot

console = Console(emoji=False)
errors = Console(stderr=True, emoji=False)

RobotArgument = Annotated[
    str,
    typer.Argument(metavar="ROBOT", help="A name from 'robust-ik robots', a .urdf, .xacro or DH file (.toml)."),
]
TipOption = Annotated[
    str | None,
    typer.Option("--tip", metavar="FRAME", help="Link or joint frame to move. Default: the tool frame."),
]
XacroOption = Annotated[
    list[str] | None,
    typer.Option("--xacro-arg", metavar="NAME:=VALUE", help="An argument of a .xacro file. Repeatable."),
]
BaseOption = Annotated[
    str,
    typer.Option("--base", metavar="BASE", help="Put it on a base that moves: planar or floating. Default: fixed."),
]
PackageDirOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--package-dir",
        metavar="DIR",
        help="Where packages lie that mesh paths name. Repeatable.",
        callback=lambda given: None if given is None else list(checked_folders(given, "--package-dir")),
    ),
]
ReachOption = Annotated[
    bool, typer.Option("--reach", help="Go round where the straight way ends (rik.Reach); default a plain servo.")
]
WorkersOption = Annotated[
    int, typer.Option("--workers", metavar="N", help="Processes that share the work. Results do not depend on it.")
]


def check_results(**paths: Path | None) -> None:
    """Raises, before the work, if a result cannot be written; says which folders will be made.

    If a result goes to standard output, all messages go to standard error, so that a program can read the result.

    Args:
        paths: Paths of results by the option's name; `plot` is a figure.

    Raises:
        InputError: One cannot be written, or two go to the same file.
    """
    if (plot := paths.get("plot")) is not None:
        check_figure(plot)
    outputs = check_outputs({f"--{name}": path for name, path in paths.items()})
    for folder in dict.fromkeys(output.new_folder for output in outputs):
        if folder is not None:
            errors.print(f"There is no folder {in_markup(folder)} yet: it is made.", soft_wrap=True)
    console.stderr = any(output.descriptor == 1 for output in outputs)


def say_written(path: Path) -> None:
    """Says where a result was written."""
    console.print(f"Wrote [bold]{in_markup(path)}[/]", soft_wrap=True)


class _NoteHandler(logging.Handler):
    """Prints log records on stderr, one line each."""

    def emit(self, record: logging.LogRecord) -> None:
        """Prints one record."""
        errors.print(f"[yellow]note:[/] {in_markup(record.getMessage())}", soft_wrap=True)


def show_notes(wanted: bool) -> None:
    """Prints or hides what the package logs about reading robots."""
    handler = _NoteHandler() if wanted else logging.NullHandler()
    logging.getLogger("robust_ik").handlers = [handler]


def xacro_arguments(given: list[str] | None) -> dict[str, object]:
    """The values of `--xacro-arg NAME:=VALUE` or `NAME=VALUE`, by name.

    Raises:
        InputError: One has no name or no value.
    """
    found: dict[str, object] = {}
    for each in given or ():
        name, equals, value = each.partition("=")
        if not equals or not name.rstrip(":"):
            raise InputError(f"--xacro-arg takes NAME:=VALUE, got {cut(each, 200)!r}")
        found[name.removesuffix(":")] = value
    return found


def load_robot(
    robot: str,
    tip: str | None,
    package_dir: list[Path] | None,
    xacro_arg: list[str] | None,
    base: str,
    *,
    whole_tree: bool = False,
) -> Robot:
    """The robot that the options of a command describe."""
    from robust_ik.robot.loading import load

    return load(
        robot,
        tip,
        package_dirs=package_dir or (),
        xacro_args=xacro_arguments(xacro_arg),
        base=cast("Base", base),
        whole_tree=whole_tree,
    )


def file_name(name: str) -> str:
    """A robot's name as part of a file name."""
    return "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in name)
