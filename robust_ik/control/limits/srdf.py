"""Reads SRDF: which pairs of links need no collision check, as written by MoveIt's setup assistant and others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from robust_ik.description.meshes import CONVENTIONAL_FOLDERS
from robust_ik.description.urdf import safe_tree
from robust_ik.errors import UrdfError
from robust_ik.robot.robot import Robot
from robust_ik.runtime.files import read_file

MAX_BYTES = 20_000_000
"""Most bytes of an SRDF file. Chosen: over a hundred times the largest of example-robot-data (0.12 MB)."""
FOLDER = "srdf"
"""The folder of a robot's package in which example-robot-data keeps SRDFs."""


@dataclass(frozen=True)
class Srdf:
    """The collision part of an SRDF.

    Attributes:
        path: The file.
        name: The name of its robot.
        disabled: Pairs of links that it disables, and why ("Adjacent", "Never", …).
    """

    path: Path
    name: str
    disabled: Mapping[frozenset[str], str]


def read_srdf(path: str | Path) -> Srdf:
    """The pairs that an SRDF disables; all else in it is ignored.

    Raises:
        RobotNotFoundError: There is no such file.
        LoadError: It cannot be read.
        UrdfError: It is broken or unsafe; the message names the place.
    """
    full, data = read_file(path, MAX_BYTES)
    try:
        root = safe_tree(data, "an SRDF")
        disabled = dict(_pair(element) for element in root.findall("disable_collisions"))
    except UrdfError as error:
        raise UrdfError(f"{path}: {error}") from error
    return Srdf(full, str(root.get("name", "")), MappingProxyType(disabled))


def _pair(element: Any) -> tuple[frozenset[str], str]:
    first, second = element.get("link1", ""), element.get("link2", "")
    if not first or not second:
        raise UrdfError(f"line {element.sourceline}: <disable_collisions> needs link1 and link2")
    return frozenset((first, second)), str(element.get("reason", "no reason given"))


def find_srdf(robot: Robot) -> Srdf | None:
    """The SRDF that lies beside a robot's URDF, in its package's folder `srdf/`, as in example-robot-data.

    It is the one with the name of the URDF's file, of the robot, or in the URDF, in this order, ignoring case; else the
    only one whose <robot name=…> is the URDF's. Links that lead out of the package are not followed.

    Raises:
        LoadError: It, or another one that had to be read, is broken.
    """
    if robot.description.file is None:
        return None
    found = list(_beside(robot.description.file))
    for name in (robot.description.file.stem, robot.name, robot.description.name):
        called = [path for path in found if path.stem.casefold() == name.casefold()]
        if called:
            return read_srdf(called[0])
    alike = [srdf for srdf in map(read_srdf, found) if srdf.name == robot.description.name]
    return alike[0] if len(alike) == 1 else None


def _beside(urdf: Path) -> Iterator[Path]:
    """The SRDFs in the package of a URDF."""
    package = urdf.parent.parent if urdf.parent.name in CONVENTIONAL_FOLDERS else urdf.parent
    for path in sorted((package / FOLDER).glob("*.srdf")):
        if path.is_file() and path.resolve().is_relative_to(package.resolve()):
            yield path
