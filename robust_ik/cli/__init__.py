"""The `robust-ik` command. Each command imports what it needs when it runs, so that help is fast."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Annotated

import typer

import robust_ik
from robust_ik.cli import benchmark, compare, demo, inverses, path, robots, singularities, view, warmup
from robust_ik.cli.shared import console, errors, show_notes
from robust_ik.errors import RobustIKError
from robust_ik.errors.safe_text import in_markup

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
    benchmark.benchmark,
    robots.robots,
    inverses.inverses,
    view.view,
    path.path,
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
    context: typer.Context,
    version: Annotated[  # noqa: ARG001 (its callback has acted)
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Singularity-robust inverse kinematics for any robot arm."""
    show_notes(context.invoked_subcommand != "info")  # whose table has the notes


def main() -> None:
    """Runs the command; every expected error is one sentence on stderr, with exit status 1.

    After a signal it cleans up first and exits with 128 plus the signal's number, as shells do: 130 after Ctrl-C.
    """
    with _ended_by_signals():
        try:
            app()
        except BrokenPipeError:  # the reader has closed the pipe
            _quiet()
            raise SystemExit(1) from None
        except (RobustIKError, OSError) as error:
            errors.print(f"[bold red]robust-ik:[/] {in_markup(error)}", soft_wrap=True)
            raise SystemExit(1) from None
        except KeyboardInterrupt:
            raise SystemExit(128 + signal.SIGINT) from None
        finally:
            console.stderr = False


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Makes the signals that ask a program to end raise SystemExit, so that nothing is left half done."""
    names = ("SIGTERM", "SIGHUP")  # not every system has both
    before = {number: signal.signal(number, _end) for name in names if (number := getattr(signal, name, None))}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(number: int, _: FrameType | None) -> None:
    raise SystemExit(128 + number)


def _quiet() -> None:
    """Keeps Python from failing again at its end over output that could not be written."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
