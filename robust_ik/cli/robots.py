"""`robust-ik robots`, `info` and `export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robust_ik.cli.shared import (
    BaseOption,
    PackageDirOption,
    RobotArgument,
    TipOption,
    XacroOption,
    check_results,
    console,
    load_robot,
    say_written,
)
from robust_ik.errors import InputError, RobustIKError, TipError
from robust_ik.errors.safe_text import in_markup, visible
from robust_ik.runtime.output_files import check_output, write_file

if TYPE_CHECKING:
    from robust_ik.description.catalog import Entry


def robots() -> None:
    """List the robots that can be loaded by name."""
    from robust_ik.cli import terminal_tables
    from robust_ik.description.catalog import catalog

    console.print(terminal_tables.robots((entry, *_joints_and_tip(entry)) for entry in catalog().values()))
    console.print("Any .urdf or .xacro path and any DH table (.toml) loads as well. 'robust-ik info NAME' tells more.")


def _joints_and_tip(entry: Entry) -> tuple[str, str]:
    """The number of joints and the default tip; the error if the robot cannot be read."""
    from robust_ik.description.dh import read_dh
    from robust_ik.description.joint_tree import MOVING_TYPES
    from robust_ik.description.tips import choose_tip
    from robust_ik.description.urdf import read_urdf

    try:
        if entry.path.suffix == ".toml":
            return str(read_dh(entry.path).n), "tool"
        description = read_urdf(entry.path, shapes=False)
        moving = [joint for joint in description.joints if joint.kind in MOVING_TYPES and joint.mimic is None]
        if not moving:
            return "0", "(nothing moves)"
        tip = entry.known.tip if entry.known else choose_tip(description).name
        return str(len(description.moving_joints(tip))), tip
    except TipError:
        return str(len(moving)), f"{len(description.leaves)} leaves: give --tip"
    except RobustIKError as error:
        return "?", visible(error)


def info(
    robot: RobotArgument,
    tip: TipOption = None,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Print the chain, limits, tips, σ and manipulability at rest, and the reach."""
    from robust_ik.cli import terminal_tables

    arm = load_robot(robot, tip, package_dir, xacro_arg, base)
    console.print(f"[bold]{in_markup(arm.name)}[/]")
    console.print(terminal_tables.facts(arm))
    console.print(terminal_tables.joints(arm))


def export(
    robot: RobotArgument,
    output: Annotated[Path, typer.Argument(metavar="FILE.urdf", help="Where to write.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file if it exists.")] = False,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Write a robot as URDF that other tools read; a DH table becomes links, joints and simple shapes."""
    import numpy as np

    check_results(output=output)
    if check_output(output).overwrites and not force:
        raise InputError(f"{str(output)!r} exists; --force overwrites it")
    arm = load_robot(robot, None, package_dir, xacro_arg, base, whole_tree=True)
    say_written(write_file(output, arm.description.xml))
    if arm.tip == "tool" and not np.isfinite([arm.lower, arm.upper, arm.velocity_limit]).all():
        console.print("What a DH table does not state, a URDF must: a full turn for limits, 1000 for speed and effort.")
