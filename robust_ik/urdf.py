"""Reads a URDF: checks the XML before anything else looks at it, then lets yourdfpy read it."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lxml import etree

from robust_ik.description import (
    MOVING_TYPES,
    Description,
    Joint,
    Mimic,
)
from robust_ik.errors import UrdfError
from robust_ik.files import read_file
from robust_ik.meshpaths import MeshPaths
from robust_ik.urdf_checks import check_tree, safe_tree
from robust_ik.urdf_shapes import collisions, visuals

MAX_BYTES = 50_000_000
SEEMS_DEGREES = 8 * math.pi
"""Limits of more than four turns are asked about."""
NO_LIMIT = 1e6
"""A position limit as large as this is written for none."""


def read_urdf(path: str | Path, package_dirs: Sequence[str | Path] = ()) -> Description:
    """A checked description from a URDF file.

    Args:
        path: The file.
        package_dirs: Folders of packages that `package://` paths name, and further folders meshes may lie in.

    Raises:
        RobotNotFoundError: There is no such file.
        LoadError: The file cannot be read.
        UrdfError: It is broken, unsafe or not supported; the message names the place.
    """
    full, data = read_file(path, MAX_BYTES)
    description = parse_urdf(data, source=str(path), folder=full.parent, package_dirs=package_dirs)
    return replace(description, file=full)


def parse_urdf(
    xml: str | bytes,
    *,
    source: str = "URDF text",
    folder: Path | None = None,
    package_dirs: Sequence[str | Path] = (),
) -> Description:
    """A checked description from URDF text.

    Args:
        xml: The text.
        source: What to call it in messages.
        folder: The folder that relative mesh paths start from.
        package_dirs: As for `read_urdf`.

    Raises:
        UrdfError: As for `read_urdf`.
    """
    try:
        root = safe_tree(xml)
        check_tree(root)
        notes: list[str] = []
        _straighten(root, notes)
        robot = _parse(root)
        moving = {joint.name for joint in robot.joints if joint.type in MOVING_TYPES}
        joints = tuple(_joint(joint, moving, notes) for joint in robot.joints)
        _check_mimics(joints)
        paths = MeshPaths.of(folder, package_dirs)
        drawn, solid = tuple(visuals(robot, paths)), tuple(collisions(robot, paths))
    except UrdfError as error:
        raise UrdfError(f"{source}: {error}") from error
    return Description(
        name=robot.name,
        xml=etree.tostring(root, encoding="unicode"),
        links=tuple(link.name for link in robot.links),
        joints=joints,
        visuals=drawn,
        source=source,
        notes=tuple(notes),
        collisions=solid,
    )


def fix_joints(xml: str, keep: set[str]) -> str:
    """URDF text in which every joint outside `keep` is fixed at zero."""
    root = etree.fromstring(xml.encode())
    for joint in root.findall("joint"):
        if joint.get("name") not in keep:
            joint.set("type", "fixed")
    return str(etree.tostring(root, encoding="unicode"))


def _straighten(root: Any, notes: list[str]) -> None:
    """Says in full what a URDF may leave out and what the parsers below take differently."""
    followed = {mimic.get("joint") for mimic in root.iterfind("joint/mimic")}
    for joint in root.findall("joint"):
        if joint.get("type") in MOVING_TYPES:
            _write_axis(joint)
        if joint.get("type") == "continuous" and (joint.get("name") in followed or joint.find("mimic") is not None):
            # As (cos, sin) its number of turns would be lost on the joints that follow it.
            joint.set("type", "revolute")
            for limit in joint.findall("limit"):
                joint.remove(limit)
            etree.SubElement(joint, "limit")
            notes.append(f"joint {joint.get('name')!r} is continuous and mimicked: taken as revolute without limits")
        for limit in joint.findall("limit"):
            for attribute in ("effort", "velocity"):
                limit.set(attribute, limit.get(attribute, "0"))


def _write_axis(joint: Any) -> None:
    """The unit axis, x where none is written."""
    axis = joint.find("axis")
    if axis is None:
        axis = etree.SubElement(joint, "axis")
    numbers = [float(word) for word in axis.get("xyz", "1 0 0").split()]
    length = math.hypot(*numbers)
    axis.set("xyz", " ".join(repr(number / length) for number in numbers))


def _parse(root: Any) -> Any:
    """Yourdfpy's reading of the checked tree."""
    import yourdfpy  # takes half a second: only where a file is read

    try:
        return yourdfpy.URDF.load(io.BytesIO(etree.tostring(root)), build_scene_graph=False, load_meshes=False).robot
    except Exception as error:  # yourdfpy raises whatever its parsing trips over
        raise UrdfError(f"cannot be read: {type(error).__name__}: {error}") from error


def _joint(joint: Any, moving: set[str], notes: list[str]) -> Joint:
    lower, upper, velocity = -math.inf, math.inf, math.inf
    limit = joint.limit
    if limit is not None:
        velocity = limit.velocity or math.inf
        low, high = limit.lower or 0.0, limit.upper or 0.0
        if joint.type in ("revolute", "prismatic"):
            if low > high:
                stated = "" if None not in (limit.lower, limit.upper) else " (one that is not stated is 0)"
                raise UrdfError(f"joint {joint.name!r} has its limits reversed: lower {low} > upper {high}{stated}")
            if low == high == 0:
                notes.append(f"joint {joint.name!r} states no position limits: it is taken as unlimited")
            else:
                if (
                    joint.type == "revolute"
                    and max(abs(low), abs(high)) > SEEMS_DEGREES
                    and max(abs(low), abs(high)) < NO_LIMIT
                ):
                    notes.append(f"joint {joint.name!r} has limits {low:g} to {high:g} rad: are they degrees?")
                lower = low if low > -NO_LIMIT else -math.inf
                upper = high if high < NO_LIMIT else math.inf
    mimic = joint.mimic and Mimic(joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset)
    if mimic is not None and mimic.source not in moving:
        notes.append(f"joint {joint.name!r} mimics {mimic.source!r}, which is no joint that moves: it is free")
        mimic = None
    return Joint(joint.name, joint.type, joint.parent, joint.child, lower, upper, velocity, mimic)


def _check_mimics(joints: tuple[Joint, ...]) -> None:
    by_name = {joint.name: joint for joint in joints}
    done: set[str] = set()
    for joint in joints:
        followed: dict[str, None] = {}
        name: str | None = joint.name
        while name is not None and name not in done:
            if name in followed:
                raise UrdfError(f"joint {joint.name!r} mimics itself, through {' → '.join(list(followed)[:10])}")
            followed[name] = None
            mimic = by_name[name].mimic
            name = None if mimic is None else mimic.source
        done.update(followed)
