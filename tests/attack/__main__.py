"""Runs the attacks and says what broke: `python -m tests.attack --help`."""

import argparse
import os
import sys

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from tests.attack import running

SHOWN = 20
"""Failures of an attack that are printed."""


def main(arguments=None):
    """0 if nothing broke, else 1."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scale", choices=("short", "full"), default="full")
    parser.add_argument("--only", choices=running.names(), action="append", metavar="NAME", help="may be repeated")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    given = parser.parse_args(arguments)
    console = Console()
    outcomes = [_watched(name, given, console) for name in given.only or running.names()]
    console.print(_table(outcomes))
    for outcome in outcomes:
        for failure in outcome.failures[:SHOWN]:
            console.print(f"[red]{outcome.name}[/]", end=": ")
            console.print(failure, markup=False, highlight=False)
    return int(any(outcome.failures for outcome in outcomes))


def _watched(name, given, console):
    total = sum(count for count, _ in running.chunks(name, given.scale))
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        bar = progress.add_task(name, total=total)
        return running.run(name, given.scale, given.jobs, done=lambda count: progress.advance(bar, count))


def _table(outcomes):
    table = Table("attack", "tried", "broke", "seconds", title="Attacks")
    for outcome in outcomes:
        broke = f"[red]{len(outcome.failures)}[/]" if outcome.failures else "0"
        table.add_row(outcome.name, f"{outcome.tried:,}", broke, f"{outcome.seconds:.0f}")
    return table


if __name__ == "__main__":
    sys.exit(main())
