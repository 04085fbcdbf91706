"""`robust-ik path`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import typer

from robust_ik.cli.shared import (
    PackageDirOption,
    RobotArgument,
    TipOption,
    XacroOption,
    check_results,
    console,
    load_robot,
    say_written,
)
from robust_ik.errors.safe_text import in_markup
from robust_ik.runtime.output_files import write_file

if TYPE_CHECKING:
    from robust_ik.paths import PathPlan
    from robust_ik.robot.robot import Robot


def path(
    robot: RobotArgument,
    poses: Annotated[
        Path, typer.Argument(metavar="POSES.csv", help="Columns x y z, and qx qy qz qw or roll pitch yaw (rad).")
    ],
    tip: TipOption = None,
    accuracy: Annotated[
        float | None,
        typer.Option(
            "--accuracy", metavar="M", help="How far the tool may leave the path. Default: 1e-4 length scales."
        ),
    ] = None,
    unit: Annotated[str, typer.Option("--unit", metavar="UNIT", help="Of lengths in the file: m or mm.")] = "m",
    longest_step: Annotated[
        float, typer.Option("--longest-step", metavar="M", help="Positions further apart are a mistake in the file.")
    ] = 1.0,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE.csv", help="Write the joint values.")
    ] = None,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
) -> None:
    """Plan a joint motion through the poses of a file, or say where and why none goes on; exit status 2 then."""
    from robust_ik.cli import terminal_tables
    from robust_ik.paths.pose_file import read_poses

    check_results(output=output)
    targets = read_poses(poses, unit=cast("Literal['m', 'mm']", unit), longest_step=longest_step)
    arm = load_robot(robot, tip, package_dir, xacro_arg, "fixed")
    plan = arm.plan_path(targets, accuracy=accuracy)
    console.print(in_markup(plan.status.value))
    if plan.pieces:
        console.print(terminal_tables.path_pieces(plan))
    for stop in plan.stops:
        console.print(in_markup(f"· {stop}"), soft_wrap=True)
    if output is not None:
        say_written(write_file(output, written(arm, plan)))
    if not plan.followed:
        raise typer.Exit(2)


def written(robot: Robot, plan: PathPlan) -> str:
    """Joint values of a plan as CSV: the piece, the place on the path, each joint in rad or m."""
    lines = [",".join(["piece", "s", *robot.joint_names])]
    for number, piece in enumerate(plan.pieces):
        lines += [
            ",".join([str(number), repr(float(s)), *(repr(float(value)) for value in values)])
            for s, values in zip(piece.s, piece.values)
        ]
    return "\n".join(lines) + "\n"
