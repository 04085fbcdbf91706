"""SRDF: which pairs of links need no watching, as MoveIt's setup assistant and its like write it down."""

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
"""Of an SRDF file. Chosen: over a hundred times the largest of example-robot-data (0.12 MB)."""
FOLDER = "srdf"
"""The folder of a robot's package that example-robot-data keeps SRDFs in."""


@dataclass(frozen=True)
class Srdf:
    """What an SRDF says about collisions.

    Attributes:
        path: The file.
        name: The robot that it is for.
        disabled: Pairs of links that it leaves out, and why ("Adjacent", "Never", …).
    """

    path: Path
    name: str
    disabled: Mapping[frozenset[str], str]


def read_srdf(path: str | Path) -> Srdf:
    """The pairs that an SRDF disables; whatever else it says is passed over.

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

    It is the one called like the URDF's file, the robot or the name in the URDF, in this order and whatever the case;
    else the only one whose <robot name=…> is the URDF's. Links that lead out of the package are not followed.

    Raises:
        LoadError: It, or one that had to be looked into, is broken.
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
    """The SRDFs of the package that a URDF is in."""
    package = urdf.parent.parent if urdf.parent.name in CONVENTIONAL_FOLDERS else urdf.parent
    for path in sorted((package / FOLDER).glob("*.srdf")):
        if path.is_file() and path.resolve().is_relative_to(package.resolve()):
            yield path
