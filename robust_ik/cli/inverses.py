"""`robust-ik inverses`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robust_ik.cli.choice import class_of
from robust_ik.cli.shared import check_results, console, say_written
from robust_ik.errors import InputError

WIDE = 150
"""Least number of terminal columns for complete tables."""


def inverses(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help="Which; default all.")] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table as Markdown.")] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw φ(σ) and σφ(σ) of the filters into an image.")
    ] = None,
) -> None:
    """List the robust inverses and what each promises; draw their gains."""
    from robust_ik.cli import terminal_tables
    from robust_ik.inverses import CLASSES, SingularValueFilter

    check_results(plot=plot)
    chosen = [class_of(name, CLASSES) for name in names] if names else list(CLASSES)
    if plot is not None:
        from robust_ik.display import plot_gains  # takes a second to import: only if needed

        filters = [each() for each in chosen if issubclass(each, SingularValueFilter)]
        if not filters:
            raise InputError(f"{', '.join(names or ())}: no singular-value filter, so there is no φ(σ) to draw")
        say_written(plot_gains(filters, plot))
    elif markdown:
        print(terminal_tables.inverses_markdown(chosen))
    elif names:
        for each in chosen:
            console.print(terminal_tables.inverse_details(each), "")
    else:
        console.print(terminal_tables.inverses_table(chosen, wide=console.width >= WIDE))
        console.print("'robust-ik inverses NAME' tells what one promises and its parameters.")
