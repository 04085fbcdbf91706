"""`robust-ik demo`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robust_ik.cli.choice import class_of
from robust_ik.cli.shared import (
    BaseOption,
    PackageDirOption,
    ReachOption,
    RobotArgument,
    TipOption,
    XacroOption,
    check_results,
    console,
    errors,
    file_name,
    load_robot,
)
from robust_ik.errors.safe_text import in_markup

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from robust_ik.inverses import RobustInverse
    from robust_ik.robot.robot import Robot
    from robust_ik.simulation.scenarios import Stretch
    from robust_ik.simulation.trajectory import Trajectory

SHOWN_FIRST = ("MoorePenrose", "DampedLeastSquares", "JParse")
METHOD_HELP = f"An inverse that 'robust-ik inverses' lists, but Weighted. Repeatable; default {', '.join(SHOWN_FIRST)}."


def demo(
    robot: RobotArgument = "xarm7",
    tip: TipOption = None,
    method: Annotated[
        list[str] | None,
        typer.Option("--method", metavar="NAME", help=METHOD_HELP),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="The HTML file. Default: robust-ik-demo-ROBOT.html here."),
    ] = None,
    reach: ReachOption = False,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Reach beyond the arm's reach and come back, with each method; write the animation as one HTML file."""
    from robust_ik.cli import terminal_tables
    from robust_ik.simulation.scenarios import stretch, with_reach

    chosen = _methods(method)
    check_results(output=output)
    arm = load_robot(robot, tip, package_dir, xacro_arg, base)
    path = output or Path(f"robust-ik-demo-{file_name(arm.name)}.html")
    if output is None:
        check_results(output=path)
    with console.status("finding the reach and a good start …"):
        scenario = stretch(arm)
    if reach:
        scenario = with_reach(scenario)
    _explain_rows(arm, scenario)
    runs = _run(scenario, chosen)
    console.print(terminal_tables.comparison(runs))
    with console.status("writing the animation …"):
        _write_page(path, runs, scenario)
    for mesh in terminal_tables.missing_meshes(arm):
        console.print(f"[yellow]not drawn:[/] {in_markup(mesh)}")
    console.print(f"Open in a browser: [bold]{in_markup(path.resolve())}[/]", soft_wrap=True)


def _write_page(path: Path, runs: dict[str, Trajectory], scenario: Stretch) -> None:
    from robust_ik.display import write_html  # takes a second to import: only if needed

    robot = scenario.robot
    write_html(
        path,
        runs,
        title=f"{robot.name}: out of reach, and back",
        text=f"The target leaves the arm's reach of {scenario.reach.distance:.3f} m by {_beyond(scenario):.0%} and "
        f"comes back. {at_the_end(runs)} {kept(scenario)}",
    )


SINGULAR = 0.01
"""σ over the largest one below which the page calls the arm singular."""


def at_the_end(runs: dict[str, Trajectory]) -> str:
    """Whether the arm is singular at the end of its reach, according to the runs."""
    run = min(runs.values(), key=lambda each: float((each.sigma[:, -1] / each.sigma[:, 0]).min()))
    share = run.sigma[:, -1] / run.sigma[:, 0]
    if share.min() < SINGULAR:
        return f"At the end of its reach the arm is singular: the smallest σ falls to {share.min():.1g} of the largest."
    return f"At the end of its reach the arm is not singular: σ stays above {share.min():.1g} of the largest."


def kept(scenario: Stretch) -> str:
    """Which limits the runs keep, and which they do not."""
    if scenario.limits:
        return "Joints that slide stay within their limits; no other limits are enforced."
    locked = scenario.locked
    still = f"; {' and '.join(locked)} {'stand' if len(locked) > 1 else 'stands'} still" if locked else ""
    return f"Limits of joints and of speeds are not enforced, to show what each method does by itself{still}."


def _methods(names: list[str] | None) -> dict[str, RobustInverse]:
    from robust_ik.inverses import CLASSES, Weighted

    runnable = [each for each in CLASSES if each is not Weighted]  # with default parameters: Weighted wraps another
    chosen = [class_of(name, runnable) for name in names or SHOWN_FIRST]
    return {each.__name__: each() for each in chosen}


def _explain_rows(arm: Robot, scenario: Stretch) -> None:
    rows, reach = scenario.robot.rows, scenario.reach.distance
    console.print(
        f"[bold]{in_markup(arm.name)}[/]: {arm.n} joints, tip {in_markup(arm.tip)}, reach {reach:.3f} m; "
        f"the target goes {_beyond(scenario):.0%} beyond it and back in {scenario.path.duration:.0f} s. "
        f"{in_markup(kept(scenario))}"
    )
    if rows != arm.rows:
        console.print(f"{arm.n} joints cannot move it in all of {' '.join(arm.rows)}: it follows {' '.join(rows)}.")


def _beyond(scenario: Stretch) -> float:
    offset = scenario.path.goal - scenario.reach.center
    return float((offset @ offset) ** 0.5 / scenario.reach.distance - 1)


def _run(scenario: Stretch, methods: dict[str, RobustInverse]) -> dict[str, Trajectory]:
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        runs = {}
        for name, inverse in methods.items():
            task = bar.add_task(name, total=None)
            runs[name] = scenario.run(inverse, partial(_show, bar, task))
        return runs


def _show(bar: Progress, task: TaskID, done: int, total: int) -> None:
    if done % 50 == 0 or done == total:
        bar.update(task, completed=done, total=total)
