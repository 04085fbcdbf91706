"""One verb for every kind of robot: a name, a URDF path, a DH file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from robust_ik.catalog import Entry, catalog, find
from robust_ik.dh_toml import read_dh
from robust_ik.errors import InputError, LoadError
from robust_ik.files import checked_folders
from robust_ik.robot import Robot
from robust_ik.rows import ROWS

URDF_SUFFIXES = (".urdf", ".xml")


def load(
    robot: str | Path,
    tip: str | None = None,
    *,
    package_dirs: Sequence[str | Path] = (),
    rows: Sequence[str] | None = None,
    whole_tree: bool = False,
) -> Robot:
    """A robot by name or from a file.

    Args:
        robot: A name that `robust-ik robots` lists, a `.urdf` path, or the path of a DH table, `.toml`.
        tip: Link or joint frame to move. By default the documented tool frame of a known robot, else the end of the
            one arm, which is the link that its fingers share; `Robot.notes` say where that was guessed.
        package_dirs: Where packages lie that the URDF's mesh paths name.
        rows: Task rows, of x y z wx wy wz; default all six, or those the DH table states.
        whole_tree: Keep every joint, also those that do not move the tip; then the tip may be left out.

    Returns:
        The robot; joints that do not move the tip are dropped unless `whole_tree`.

    Raises:
        RobotNotFoundError: No such name, no such file.
        LoadError: The file is broken, unsafe or not supported.
        TipError: The tip is ambiguous (the message lists the candidates), or no joint moves it.
        FrameNotFoundError: There is no such tip (the message lists what exists).
    """
    if not isinstance(robot, (str, Path)):
        raise InputError(f"robot must be a name or a path, got {robot!r}")
    package_dirs = checked_folders(package_dirs, "package_dirs")
    name, suffix = str(robot), Path(robot).suffix.lower()
    if suffix in (*URDF_SUFFIXES, ".toml"):
        return _load_file(robot, tip, package_dirs, rows, whole_tree)
    if name not in catalog() and _is_file(name):
        raise LoadError(f"{name!r} is neither a .urdf nor a .toml (DH table) file")
    return _load_known(find(name), tip, package_dirs, rows, whole_tree)


def _is_file(name: str) -> bool:
    try:
        return Path(name).expanduser().is_file()
    except (OSError, RuntimeError, ValueError):
        return False


def _load_file(
    path: str | Path,
    tip: str | None,
    package_dirs: Sequence[str | Path],
    rows: Sequence[str] | None,
    whole_tree: bool,
) -> Robot:
    if Path(path).suffix.lower() != ".toml":
        return Robot.from_urdf(
            path, tip, package_dirs=package_dirs, rows=ROWS if rows is None else rows, whole_tree=whole_tree
        )
    arm = Robot.from_dh(read_dh(path))
    if tip not in (None, "tool"):
        raise InputError(f"a DH table has one tip, 'tool', got tip={tip!r}; use pose(q, frame) for other frames")
    return arm if rows is None else arm.with_rows(rows)


def _load_known(
    entry: Entry,
    tip: str | None,
    package_dirs: Sequence[str | Path],
    rows: Sequence[str] | None,
    whole_tree: bool,
) -> Robot:
    """A robot of the catalogue, under its name there, with its documented tip and rest where they apply."""
    known = entry.known
    chosen = known.tip if known is not None and tip is None and not whole_tree else tip
    robot = replace(_load_file(entry.path, chosen, package_dirs, rows, whole_tree), name=entry.name)
    if known is not None and len(known.rest) == robot.n:
        return replace(robot, rest=robot.configuration(np.array(known.rest)))
    return robot
