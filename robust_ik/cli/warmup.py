"""`robust-ik warmup`: compiles kernels ahead of time, so that nobody has to wait later."""

from __future__ import annotations

from typing import Annotated

import typer

from robust_ik.cli.shared import BaseOption, PackageDirOption, TipOption, XacroOption, console, errors, load_robot


def warmup(
    robot: Annotated[
        str | None,
        typer.Argument(metavar="[ROBOT]", help="Leave out what is for robots of another size. Default: everything."),
    ] = None,
    tip: TipOption = None,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Compile what control loops, pose solvers and searches run, once on this machine; later it is read from disk."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    from robust_ik.control.compiled_step import warmup as compile_ahead

    arm = None if robot is None else load_robot(robot, tip, package_dir, xacro_arg, base)
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
        task = bar.add_task("compiling, or reading from disk", total=None)
        seconds = compile_ahead(arm, progress=lambda done, total: bar.update(task, completed=done, total=total))
    from robust_ik.kernels.loader.announcing import MISSED

    compiled = (
        f"compiled {len(MISSED)} function{'s' if len(MISSED) > 1 else ''}"
        if MISSED
        else "everything had been compiled before"
    )
    console.print(f"Ready: {compiled}; it took {seconds:.1f} s.")
