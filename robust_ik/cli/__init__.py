"""The `robust-ik` command: what a command needs is imported when it runs, so that help is there at once."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.markup import escape

import robust_ik
from robust_ik.cli import compare, demo, inverses, robots, singularities, warmup
from robust_ik.cli.shared import console, errors
from robust_ik.errors import RobustIKError

app = typer.Typer(
    help="Singularity-robust inverse kinematics for any robot arm.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
COMMANDS = (
    demo.demo,
    compare.compare,
    robots.robots,
    inverses.inverses,
    robots.info,
    singularities.singularities,
    singularities.certify,
    singularities.verify,
    robots.export,
    warmup.warmup,
)
for command in COMMANDS:
    app.command()(command)


def _version(wanted: bool) -> None:
    if wanted:
        console.print(f"robust-ik {robust_ik.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Singularity-robust inverse kinematics for any robot arm."""


def main() -> None:
    """Runs the command; every error that is meant is one sentence on stderr and exit status 1."""
    try:
        app()
    except RobustIKError as error:
        errors.print(f"[bold red]robust-ik:[/] {escape(str(error))}", soft_wrap=True)
        raise SystemExit(1) from None
    except OSError as error:
        errors.print(f"[bold red]robust-ik:[/] {escape(str(error))}", soft_wrap=True)
        raise SystemExit(1) from None
