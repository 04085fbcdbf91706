"""Loads any kind of robot: by name, from a URDF or xacro path, a DH file, or a module of robot_descriptions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np

from robust_ik.checks.public_arguments import checked_but
from robust_ik.description.catalog import Entry, catalog, find
from robust_ik.description.dh import read_dh
from robust_ik.description.robot_modules import DescribedRobot, described, of_module
from robust_ik.description.urdf import checked_arguments
from robust_ik.errors import InputError, LoadError, cut
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.mobile_base import Base, check_base, on_base
from robust_ik.robot.robot import Robot
from robust_ik.runtime.files import checked_folders

URDF_SUFFIXES = (".urdf", ".xacro", ".xml")
OTHER_XML = (".mjcf", ".sdf", ".srdf", ".world")
"""Files that are read only to say what they are."""
_USD = (".usd", ".usda", ".usdc", ".usdz")


@dataclass(frozen=True)
class _Wishes:
    """The arguments of `load`."""

    tip: str | None
    package_dirs: Sequence[str | Path]
    rows: Sequence[str] | None
    whole_tree: bool
    xacro_args: Mapping[str, object] | None


@checked_but("xacro_args")
def load(
    robot: str | Path | ModuleType,
    tip: str | None = None,
    *,
    package_dirs: Sequence[str | Path] = (),
    rows: Sequence[str] | None = None,
    whole_tree: bool = False,
    xacro_args: Mapping[str, object] | None = None,
    base: Base = "fixed",
) -> Robot:
    """A robot by name or from a file.

    Args:
        robot: A name that `robust-ik robots` lists, the path of a `.urdf`, a `.xacro` (with xacrodoc installed) or a
            DH table (`.toml`), or a robot of robot_descriptions (if installed): "panda_description", or the module.
        tip: Link or joint frame to move. By default the documented tool frame of a known robot, else the end of the
            one arm, which is the link that its fingers share; `Robot.notes` say if it was guessed.
        package_dirs: Folders of packages for the URDF's mesh paths, or for xacro's `$(find …)`.
        rows: Task rows, of x y z wx wy wz; default all six, or those the DH table states.
        whole_tree: Keep every joint, also those that do not move the tip; then the tip may be left out.
        xacro_args: Values of the arguments of a xacro file.
        base: "planar" or "floating" puts it on a base that moves, in front of what moves in the file; see `on_base`.

    Returns:
        The robot; joints that do not move the tip are dropped unless `whole_tree`.

    Raises:
        RobotNotFoundError: No such name, no such file.
        LoadError: The file is broken, unsafe or not supported, or the package that reads it is not installed.
        TipError: The tip is ambiguous (the message lists the candidates), or no joint moves it.
        FrameNotFoundError: There is no such tip (the message lists what exists).
    """
    if not isinstance(robot, (str, Path, ModuleType)):
        raise InputError(f"robot must be a name, a path or a module, got {cut(repr(robot), 200)}")
    package_dirs = checked_folders(package_dirs, "package_dirs")
    wishes = _Wishes(tip, package_dirs, rows, whole_tree, checked_arguments(xacro_args))
    check_base(base)
    return on_base(_load_any(robot, wishes), base)


def _load_any(robot: str | Path | ModuleType, wishes: _Wishes) -> Robot:
    if isinstance(robot, ModuleType):
        return _load_described(of_module(robot), wishes)
    name, suffix = str(robot), Path(robot).suffix.lower()
    if suffix in (*URDF_SUFFIXES, ".toml"):
        return _load_file(robot, wishes)
    if name not in catalog() and _is_file(name):
        return _load_other(name, suffix, wishes)
    if name not in catalog() and (found := described(name)) is not None:
        return _load_described(found, wishes)
    return _load_known(find(name), wishes)


def _is_file(name: str) -> bool:
    try:
        return Path(name).expanduser().is_file()
    except (OSError, RuntimeError, ValueError):
        return False


def _load_other(name: str, suffix: str, wishes: _Wishes) -> Robot:
    """Loads other XML files as a URDF is loaded; for any other file, raises an error that says what it is."""
    if suffix in OTHER_XML:
        return _load_file(name, wishes)
    if suffix in _USD:
        raise LoadError(f"{cut(name, 200)!r} is USD, not a URDF: take the URDF that it was made from, or convert it")
    raise LoadError(f"{cut(name, 200)!r} is neither a .urdf, nor a .xacro, nor a .toml (DH table) file")


def _load_file(path: str | Path, wishes: _Wishes) -> Robot:
    if Path(path).suffix.lower() != ".toml":
        return Robot.from_urdf(
            path,
            wishes.tip,
            package_dirs=wishes.package_dirs,
            rows=ROWS if wishes.rows is None else wishes.rows,
            whole_tree=wishes.whole_tree,
            xacro_args=wishes.xacro_args,
        )
    if wishes.xacro_args:
        raise InputError("xacro_args are for .xacro files, and a DH table has no arguments")
    arm = Robot.from_dh(read_dh(path))
    if wishes.tip not in (None, "tool"):
        raise InputError(f"a DH table has one tip, 'tool', got tip={wishes.tip!r}; use pose(q, frame) for other frames")
    return arm if wishes.rows is None else arm.with_rows(wishes.rows)


def _load_known(entry: Entry, wishes: _Wishes) -> Robot:
    """A robot of the catalogue, under its name there, with its documented tip and rest if they apply."""
    known = entry.known
    if known is not None and wishes.tip is None and not wishes.whole_tree:
        wishes = replace(wishes, tip=known.tip)
    robot = replace(_load_file(entry.path, wishes), name=entry.name)
    if known is not None and len(known.rest) == robot.n:
        return replace(robot, rest=robot.configuration(np.array(known.rest)))
    return robot


def _load_described(found: DescribedRobot, wishes: _Wishes) -> Robot:
    """A robot of robot_descriptions, under its name there."""
    arguments = {**found.xacro_args, **(wishes.xacro_args or {})}
    folders = (*wishes.package_dirs, *(folder for folder in found.package_dirs if Path(folder).is_dir()))
    robot = _load_file(found.path, replace(wishes, package_dirs=folders, xacro_args=arguments))
    return replace(robot, name=found.name)
