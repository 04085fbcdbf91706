"""The `robust-ik` command."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

from robust_ik import __version__, report
from robust_ik.catalog import Entry, catalog
from robust_ik.description import MOVING_TYPES
from robust_ik.errors import InputError, RobustIKError, TipError, suggest
from robust_ik.files import check_writable, read_file, write_file
from robust_ik.inverses import CLASSES, RobustInverse, SingularValueFilter, Weighted
from robust_ik.loading import load
from robust_ik.progress import progress_bar
from robust_ik.robot import Robot
from robust_ik.scenarios import Scenario, stretch
from robust_ik.trajectory import Trajectory
from robust_ik.urdf import read_urdf

RUNNABLE = [each for each in CLASSES if each is not Weighted]
"""What can be run by name, with its default parameters: Weighted wraps another."""
WIDE = 150
"""Terminal columns from which tables show all they have."""
LARGEST_CERTIFICATE = 64_000_000
SHOWN_FIRST = ("MoorePenrose", "DampedLeastSquares", "JParse")
METHOD_HELP = f"An inverse that 'robust-ik inverses' lists, but Weighted. Repeatable; default {', '.join(SHOWN_FIRST)}."

app = typer.Typer(
    help="Singularity-robust inverse kinematics for any robot arm.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
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


def _version(wanted: bool) -> None:
    if wanted:
        console.print(f"robust-ik {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Singularity-robust inverse kinematics for any robot arm."""


@app.command()
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
    package_dir: PackageDirOption = None,
) -> None:
    """Reach beyond the arm's reach and come back, with each method; write the animation as one HTML file."""
    chosen = _methods(method)
    if output is not None:
        check_writable(output)
    arm = load(robot, tip, package_dirs=package_dir or ())
    with console.status("finding the reach and a good start …"):
        scenario = stretch(arm)
    _explain_rows(arm, scenario)
    runs = _run(scenario, chosen)
    console.print(report.comparison(runs))
    path = output or Path(f"robust-ik-demo-{_file_name(arm.name)}.html")
    with console.status("writing the animation …"):
        _write_page(path, runs, scenario)
    for mesh in report.missing_meshes(arm):
        console.print(f"[yellow]not drawn:[/] {escape(mesh)}")
    console.print(f"Open in a browser: [bold]{escape(str(path.resolve()))}[/]", soft_wrap=True)


def _write_page(path: Path, runs: dict[str, Trajectory], scenario: Scenario) -> None:
    from robust_ik.display import write_html  # takes a second to import: only where it is needed

    robot = scenario.robot
    write_html(
        path,
        runs,
        title=f"{robot.name}: out of reach, and back",
        text=f"The target leaves the arm's reach of {scenario.reach.distance:.3f} m by {_beyond(scenario):.0%} and "
        "comes back. At the end of its reach the arm is singular.",
    )


def _methods(names: list[str] | None) -> dict[str, RobustInverse]:
    chosen = [_class(name, RUNNABLE) for name in names or SHOWN_FIRST]
    return {each.__name__: each() for each in chosen}


def _class(name: str, classes: Iterable[type[RobustInverse]]) -> type[RobustInverse]:
    by_name = {each.__name__: each for each in classes}
    found = next((each for known, each in by_name.items() if known.lower() == name.lower()), None)
    if found is None:
        raise InputError(f"there is no method {name!r}; {suggest(name, by_name)}")
    return found


def _explain_rows(arm: Robot, scenario: Scenario) -> None:
    rows, reach = scenario.robot.rows, scenario.reach.distance
    console.print(
        f"[bold]{escape(arm.name)}[/]: {arm.n} joints, tip {escape(str(arm.tip))}, reach {reach:.3f} m; "
        f"the target goes {_beyond(scenario):.0%} beyond it and back in {scenario.path.duration:.0f} s"
    )
    if rows != arm.rows:
        console.print(f"{arm.n} joints cannot move it in all of {' '.join(arm.rows)}: it follows {' '.join(rows)}.")


def _beyond(scenario: Scenario) -> float:
    offset = scenario.path.goal - scenario.reach.center
    return float((offset @ offset) ** 0.5 / scenario.reach.distance - 1)


def _run(scenario: Scenario, methods: dict[str, RobustInverse]) -> dict[str, Trajectory]:
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


@app.command()
def robots() -> None:
    """List the robots that can be loaded by name."""
    console.print(report.robots((entry, *_joints_and_tip(entry)) for entry in catalog().values()))
    console.print("Any .urdf path and any DH table (.toml) loads as well. 'robust-ik info NAME' tells more.")


def _joints_and_tip(entry: Entry) -> tuple[str, str]:
    """How many joints, and which tip is moved by default; what went wrong where it cannot be read."""
    try:
        if entry.path.suffix == ".toml":
            robot = load(entry.path)
            return str(robot.n), str(robot.tip)
        description = read_urdf(entry.path)
        moving = [joint for joint in description.joints if joint.kind in MOVING_TYPES and joint.mimic is None]
        if not moving:
            return "0", "(nothing moves)"
        tip = entry.known.tip if entry.known else description.longest_leaf()
        return str(len(description.moving_joints(tip))), tip
    except TipError:
        return str(len(moving)), f"{len(description.leaves)} leaves: give --tip"
    except RobustIKError as error:
        return "?", str(error)


@app.command()
def inverses(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help="Which; default all.")] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table as Markdown.")] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw φ(σ) and σφ(σ) of the filters into an image.")
    ] = None,
) -> None:
    """List the robust inverses and what each promises; draw their gains."""
    chosen = [_class(name, CLASSES) for name in names] if names else list(CLASSES)
    if plot is not None:
        from robust_ik.display import plot_gains  # takes a second to import: only where it is needed

        filters = [each() for each in chosen if issubclass(each, SingularValueFilter)]
        if not filters:
            raise InputError(f"{', '.join(names or ())}: no singular-value filter, so there is no φ(σ) to draw")
        console.print(f"Wrote [bold]{escape(str(plot_gains(filters, plot)))}[/]", soft_wrap=True)
    elif markdown:
        print(report.inverses_markdown(chosen))
    elif names:
        for each in chosen:
            console.print(report.inverse_details(each), "")
    else:
        console.print(report.inverses_table(chosen, wide=console.width >= WIDE))
        console.print("'robust-ik inverses NAME' tells what one promises and its parameters.")


@app.command()
def info(robot: RobotArgument, tip: TipOption = None, package_dir: PackageDirOption = None) -> None:
    """Print the chain, limits, tips, σ and manipulability at rest, and the reach."""
    arm = load(robot, tip, package_dirs=package_dir or ())
    console.print(f"[bold]{escape(arm.name)}[/]")
    console.print(report.facts(arm))
    console.print(report.joints(arm))


@app.command()
def singularities(
    robot: RobotArgument,
    tip: TipOption = None,
    corank: Annotated[int | None, typer.Option("--corank", help="Only this one; default all up to the last.")] = None,
    starts: Annotated[int, typer.Option("--starts", help="Random starts for each corank.")] = 2000,
    seed: Annotated[int, typer.Option("--seed", help="The same seed gives the same atlas.")] = 0,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table as Markdown.")] = False,
    json: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Save the atlas; SingularityAtlas.load reads it.")
    ] = None,
    package_dir: PackageDirOption = None,
) -> None:
    """Find every family of singular configurations: conditions, dimension, limits, and what is lost there."""
    from robust_ik.singularities import find_singularities  # takes half a second to import: only where it is needed

    if json is not None:
        check_writable(json)
    arm = load(robot, tip, package_dirs=package_dir or ())
    with progress_bar(f"searching {arm.name}") as told:
        atlas = find_singularities(arm, corank, starts=starts, rng=seed, progress=told)
    if markdown:
        print(atlas.markdown())
    else:
        console.print(atlas.table())
    if json is not None:
        console.print(f"Wrote [bold]{escape(str(atlas.save(json)))}[/]", soft_wrap=True)


@app.command()
def certify(
    robot: RobotArgument,
    corank: Annotated[int, typer.Option("--corank", help="How many directions are lost.")] = 1,
    tip: TipOption = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Where to write the proof, as JSON.")
    ] = None,
    time_limit: Annotated[float, typer.Option("--time-limit", help="Seconds.")] = 60.0,
    package_dir: PackageDirOption = None,
) -> None:
    """Prove where an arm is singular, exactly and completely, and have the proof checked."""
    from robust_ik import certificates  # brings computer algebra: only where it is needed

    if output is not None:
        check_writable(output)
    arm = load(robot, tip, package_dirs=package_dir or ())
    with console.status("splitting cases …"):
        proof = certificates.certify(arm, corank, time_limit=time_limit)
    verdict = certificates.check(proof) if proof.arm is not None else None
    console.print(f"[bold]{escape(arm.name)}[/], corank {corank}: {certificates.word(proof, verdict)}")
    for leaf in certificates.leaves(proof):
        console.print(f"  {escape(str(leaf))}", soft_wrap=True)
    for change in proof.arm.changes if proof.arm is not None else ():
        console.print(f"[dim]straightened: {escape(change)}[/]", soft_wrap=True)
    if verdict is not None:
        console.print(escape(verdict.reason), soft_wrap=True)
    if output is not None:
        console.print(f"Wrote [bold]{escape(str(write_file(output, proof.to_json())))}[/]", soft_wrap=True)


@app.command()
def verify(
    certificate: Annotated[Path, typer.Argument(metavar="CERTIFICATE", help="A proof that 'certify' wrote.")],
) -> None:
    """Check a proof of where an arm is singular, without trusting what made it."""
    from robust_ik import certificates  # only where it is needed

    _, content = read_file(certificate, LARGEST_CERTIFICATE)
    verdict = certificates.check(content.decode("utf-8", errors="replace"))
    console.print(f"{'accepted' if verdict.accepted else 'not accepted'}: {escape(verdict.reason)}", soft_wrap=True)
    if not verdict.accepted:
        raise typer.Exit(1)


@app.command()
def export(
    robot: RobotArgument,
    output: Annotated[Path, typer.Argument(metavar="FILE.urdf", help="Where to write.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file if it exists.")] = False,
    package_dir: PackageDirOption = None,
) -> None:
    """Write a robot as URDF that other tools read; a DH table becomes links, joints and simple shapes."""
    if output.exists() and not force:
        raise InputError(f"{str(output)!r} exists; --force overwrites it")
    arm = load(robot, package_dirs=package_dir or (), whole_tree=True)
    write_file(output, arm.description.xml)
    console.print(f"Wrote [bold]{escape(str(output))}[/]", soft_wrap=True)
    if arm.tip == "tool" and not np.isfinite([arm.lower, arm.upper, arm.velocity_limit]).all():
        console.print("What a DH table does not state, a URDF must: a full turn for limits, 1000 for speed and effort.")


def _file_name(name: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in name)


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
