"""Robots of the package robot_descriptions (PyPI), if installed; it downloads each robot at its first use."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from robust_ik.errors import LoadError, RobotNotFoundError, cut, suggest

PACKAGE = "robot_descriptions"


@dataclass(frozen=True)
class DescribedRobot:
    """The files of a robot of robot_descriptions.

    Attributes:
        name: The module's name.
        path: Its URDF or xacro file.
        package_dirs: Folders of its packages.
        xacro_args: Arguments for its xacro file.
    """

    name: str
    path: Path
    package_dirs: tuple[str, ...]
    xacro_args: Mapping[str, object]


def described(name: str) -> DescribedRobot | None:
    """The robot of this name in robot_descriptions, with or without the package's name in front; None if there is none.

    Only names in its own list are imported.

    Raises:
        RobotNotFoundError: The name asks for one of its robots, but there is none, or the package is not installed.
        LoadError: It cannot be downloaded, or has no URDF.
    """
    wanted = name.removeprefix(f"{PACKAGE}.")
    claimed = wanted != name
    if importlib.util.find_spec(PACKAGE) is None:
        if claimed or wanted.endswith("_description"):
            raise RobotNotFoundError(
                f"there is no robot called {cut(name, 200)!r}; if one of robot_descriptions is meant: "
                "pip install robot_descriptions"
            )
        return None
    known = importlib.import_module(PACKAGE).DESCRIPTIONS
    if wanted not in known:
        if claimed:
            raise RobotNotFoundError(f"robot_descriptions has no {cut(wanted, 200)!r}; {suggest(wanted, known)}")
        return None
    try:
        module = importlib.import_module(f"{PACKAGE}.{wanted}")
    except Exception as error:  # git, the network and the disk raise errors of their own
        reason = cut(" ".join(f"{type(error).__name__}: {error}".split()), 300)
        raise LoadError(
            f"robot_descriptions could not fetch {wanted!r}, which it downloads at its first use: {reason}"
        ) from error
    return of_module(module)


def of_module(module: ModuleType) -> DescribedRobot:
    """The files that a module of robot_descriptions, or a similar one, names.

    Raises:
        LoadError: It names no URDF and no xacro file.
    """
    name = module.__name__.rpartition(".")[2]
    path = getattr(module, "URDF_PATH", None) or getattr(module, "XACRO_PATH", None)
    if path is None:
        has = " It has MJCF, which is not read." if hasattr(module, "MJCF_PATH") else ""
        raise LoadError(f"the module {name!r} has no URDF: neither URDF_PATH nor XACRO_PATH.{has}")
    places = [getattr(module, each, None) for each in ("PACKAGE_PATH", "REPOSITORY_PATH")]
    given = [str(place) for place in places if place] + [
        str(place) for place in getattr(module, "XACRO_PACKAGE_PATHS", {}).values()
    ]
    folders = dict.fromkeys(folder for place in given for folder in (place, str(Path(place).parent)))
    return DescribedRobot(name, Path(path), tuple(folders), dict(getattr(module, "XACRO_ARGS", {})))
