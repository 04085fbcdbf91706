"""`robust-ik compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robust_ik.cli.choice import class_of
from robust_ik.cli.shared import ReachOption, WorkersOption, check_results, console, say_written
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import in_markup, plain
from robust_ik.runtime.progress import progress_bar

if TYPE_CHECKING:
    from robust_ik.simulation.scenario import Method, Scenario
    from robust_ik.simulation.trajectory import Trajectory


def compare(
    scenario: Annotated[
        str | None, typer.Argument(metavar="[SCENARIO]", help="A name, or a TOML file; without it, what there is.")
    ] = None,
    methods: Annotated[
        list[str] | None,
        typer.Option(
            "--methods", metavar="NAME", help="Labels of the scenario; inverses, resolvers by name. Repeatable."
        ),
    ] = None,
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Write a page with the runs in 3D and their charts.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw error, joint speed and σ over time.")
    ] = None,
    reach: ReachOption = False,
    workers: WorkersOption = 1,
) -> None:
    """Run a scenario with the methods it names, or with others, and print how they fared."""
    from robust_ik.cli import terminal_tables
    from robust_ik.runtime.parallel import process_pool
    from robust_ik.simulation import comparison
    from robust_ik.simulation.scenarios import load_scenario, scenarios, with_reach

    if scenario is None:
        console.print(
            terminal_tables.scenarios({name: load_scenario(path).title for name, path in scenarios().items()})
        )
        return
    check_results(html=html, plot=plot)
    chosen = load_scenario(scenario)
    if reach:
        chosen = with_reach(chosen)
    picked = _chosen(chosen, methods)
    with process_pool(workers) as pool, progress_bar(f"comparing {len(picked)} methods") as told:
        runs = comparison.compare(chosen, picked, executor=pool, progress=told)[chosen.name]
    console.print(f"[bold]{in_markup(chosen.title or chosen.name)}[/]")
    for text in (chosen.source, chosen.note):
        if text:
            console.print(plain(text))
    console.print(terminal_tables.comparison(runs))
    if html is not None or plot is not None:
        _draw(chosen, runs, html, plot)


def _chosen(scenario: Scenario, names: list[str] | None) -> dict[str, Method]:
    """Methods by label: those of the scenario, or those that are named."""
    from robust_ik.inverses import CLASSES
    from robust_ik.simulation.scenarios import RESOLVERS

    if not names:
        if not scenario.methods:
            raise InputError(f"{scenario.name} names no methods: name some with --methods")
        return dict(scenario.methods)
    known = dict(scenario.methods)
    classes: tuple[type[Method], ...] = (*CLASSES, *RESOLVERS)
    return {name: known[name] if name in known else class_of(name, classes)() for name in names}


def _draw(scenario: Scenario, runs: dict[str, Trajectory], html: Path | None, plot: Path | None) -> None:
    from robust_ik.display import plot_runs, write_html  # takes a second to import: only if needed

    if html is not None:
        text = " ".join(part for part in (scenario.source, scenario.note) if part)
        say_written(write_html(html, runs, title=scenario.title or scenario.name, text=text))
    if plot is not None:
        say_written(plot_runs(runs, plot))
