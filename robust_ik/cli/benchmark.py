"""`robust-ik benchmark`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robust_ik.cli.shared import check_results, console, load_robot, say_written
from robust_ik.errors import InputError
from robust_ik.runtime.progress import progress_bar

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot
    from robust_ik.simulation.robustness import BenchmarkResults, RobustnessScenario

DEFAULT = ("MoorePenrose", "DampedLeastSquares", "JParse", "VelocityController", "SecondOrder")
"""Methods that are run if none is named."""


def benchmark(
    robots: Annotated[
        list[str] | None,
        typer.Argument(metavar="[ROBOT]...", help="Names from 'robust-ik robots', .urdf, .xacro or DH files; or none."),
    ] = None,
    methods: Annotated[
        list[str] | None,
        typer.Option(
            "--methods", metavar="NAME", help="An inverse by name, 'all', or your Python file with one. Repeatable."
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Of the choice of scenarios.")] = 0,
    starts: Annotated[
        int, typer.Option("--starts", metavar="N", min=1, help="Random starts of the search for singularities.")
    ] = 200,
    read: Annotated[
        list[Path] | None,
        typer.Option("--read", metavar="FILE", help="Saved results to add, of the same scenarios. Repeatable."),
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Save all results.")] = None,
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FOLDER", help="Write an index and a page for each scenario.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw accuracy against calm into an image.")
    ] = None,
) -> None:
    """Test how methods fare near the singularities of robots, in scenarios made from their atlases, and rank them."""
    from robust_ik.cli.terminal_tables import robustness
    from robust_ik.simulation.robustness import BenchmarkResults, chosen_methods, known_methods, measure

    check_results(json=json, html=None if html is None else html / "index.html", plot=plot)
    if not robots and not read:
        raise InputError("name a robot, or saved results with --read")
    named = list(methods or DEFAULT)
    picked = known_methods() if named == ["all"] else chosen_methods(named)
    results: BenchmarkResults | None = None
    for path in read or ():
        saved = BenchmarkResults.load(path)
        results = saved if results is None else results.joined(saved)
    if robots:
        pieces = [_scenarios(name, seed, starts) for name in robots]
        with progress_bar(f"running {len(picked)} methods") as told:
            found = measure(pieces, picked, told)
        results = found if results is None else results.joined(found)
    assert results is not None
    rows = results.summaries()
    console.print(robustness(rows))
    if json is not None:
        say_written(results.save(json))
    if html is not None or plot is not None:
        from robust_ik.display import plot_tradeoff, write_robustness_html  # takes a second to import: only if needed

        if html is not None:
            say_written(write_robustness_html(html, results))
        if plot is not None:
            say_written(plot_tradeoff(rows, plot))


def _scenarios(name: str, seed: int, starts: int) -> tuple[Robot, tuple[RobustnessScenario, ...]]:
    """A robot and its scenarios."""
    from robust_ik.simulation.robustness import robustness_scenarios
    from robust_ik.singularities import find_singularities

    robot = load_robot(name, None, None, None, "fixed")
    with progress_bar(f"finding the singularities of {robot.name}") as told:
        atlas = find_singularities(robot, starts=starts, certify=False, progress=told)
    return robot, robustness_scenarios(robot, atlas, seed=seed)
