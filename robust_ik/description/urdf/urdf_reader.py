"""Reads a URDF: its XML is checked first, then yourdfpy parses it."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from robust_ik.description.dh.dh_table import screw
from robust_ik.description.joint_tree import MOVING_TYPES, Description, Joint, Mimic
from robust_ik.description.meshes.mesh_paths import MeshPaths
from robust_ik.description.notes import Notes, named
from robust_ik.description.urdf.urdf_checks import check_tree, safe_tree
from robust_ik.description.urdf.urdf_joints import mend_joints
from robust_ik.description.urdf.urdf_numbers import NO_LIMIT, shown
from robust_ik.description.urdf.urdf_rotations import write_rotations
from robust_ik.description.urdf.urdf_shapes import collisions, mend_shapes, visuals
from robust_ik.description.urdf.urdf_xacro import HOW, check_expanded
from robust_ik.description.urdf.xacro_files import SUFFIX, checked_arguments, expand
from robust_ik.description.yourdfpy_module import urdf
from robust_ik.errors import InputError, UrdfError, cut, listed
from robust_ik.runtime.files import read_file

MAX_BYTES = 50_000_000
"""Most bytes of a URDF file. Chosen: over two hundred times the largest of example-robot-data (0.21 MB)."""
SEEMS_DEGREES = 8 * math.pi
"""Limits of more than four turns are noted as perhaps in degrees."""
MOST_DEGREES = 1e4
"""Limits of more than this many degrees are not noted: nobody means them."""


def read_urdf(
    path: str | Path,
    package_dirs: Sequence[str | Path] = (),
    xacro_args: Mapping[str, object] | None = None,
    *,
    shapes: bool = True,
) -> Description:
    """A checked description from a URDF file, or from a `.xacro` file where xacrodoc is installed.

    Args:
        path: The file.
        package_dirs: Folders of packages for `package://` paths, and further folders where meshes may lie.
        xacro_args: Values of the arguments of a `.xacro` file.
        shapes: Whether to read shapes and masses; links and joints alone take less than half the time.

    Raises:
        RobotNotFoundError: There is no such file.
        LoadError: The file cannot be read.
        UrdfError: It is broken, unsafe or not supported; the message names the place.
        InputError: `xacro_args` are given, but it is no `.xacro` file.
    """
    data: str | bytes
    full, data = read_file(path, MAX_BYTES)
    arguments = checked_arguments(xacro_args)
    if full.suffix.lower() == SUFFIX:
        data = expand(full, arguments, package_dirs)
    elif arguments:
        raise InputError(
            f"{cut(str(path), 200)} is no {SUFFIX} file, so that it has no arguments {listed(list(arguments))}"
        )
    description = parse_urdf(data, source=str(path), folder=full.parent, package_dirs=package_dirs, shapes=shapes)
    return replace(description, file=full)


def parse_urdf(
    xml: str | bytes,
    *,
    source: str = "URDF text",
    folder: Path | None = None,
    package_dirs: Sequence[str | Path] = (),
    shapes: bool = True,
) -> Description:
    """A checked description from URDF text.

    Args:
        xml: The text.
        source: What to call it in messages.
        folder: The folder that relative mesh paths start from.
        package_dirs: As for `read_urdf`.
        shapes: As for `read_urdf`.

    Raises:
        UrdfError: As for `read_urdf`.
    """
    notes = Notes()
    try:
        root = safe_tree(xml, notes=notes)
        if not shapes:
            _remove(root, "link/*", "material")
        left = check_expanded(root, notes)
        write_rotations(root, notes)
        _check_whole(root, left)
        problems, parts = mend_joints(root, notes)
        if parts:
            check_tree(root)  # deeper than it was
        mend_shapes(root, notes)
        robot = _parse(root)
        moving = {joint.name for joint in robot.joints if joint.type in MOVING_TYPES} | set(problems)
        joints = tuple(_joint(joint, moving, problems, parts, notes) for joint in robot.joints)
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
        notes=notes.sentences(),
        collisions=solid,
    )


def _check_whole(root: Any, left: bool) -> None:
    """Checks that links and joints form a tree; if they do not because xacro is left in the file, says so.

    Raises:
        UrdfError: They do not.
    """
    try:
        check_tree(root)
    except UrdfError as error:
        if left:
            raise UrdfError(f"it is xacro that was not expanded: {error}; {HOW}") from error
        raise


def _remove(root: Any, *paths: str) -> None:
    """Removes the elements at these paths below the root."""
    for element in [element for path in paths for element in root.iterfind(path)]:
        element.getparent().remove(element)


def fix_joints(xml: str, keep: set[str]) -> str:
    """URDF text in which all joints outside `keep` are fixed at zero, without shapes."""
    root = etree.fromstring(xml.encode())
    _remove(root, "link/visual", "link/collision", "material")
    for joint in root.findall("joint"):
        if joint.get("name") not in keep:
            joint.set("type", "fixed")
    return str(etree.tostring(root, encoding="unicode"))


def lock_slides(description: Description, values: Mapping[str, float]) -> Description:
    """The description with sliding joints fixed at given positions.

    Args:
        description: A description.
        values: Positions of the joints to fix, m, by name; these joints slide, and so do all that follow them.
    """
    root = etree.fromstring(description.xml.encode())
    places = {name: driver.multiplier * values[driver.source] + driver.offset
              for name, driver in description.driver.items() if driver.source in values}  # fmt: skip
    for joint in root.findall("joint"):
        if (place := places.get(joint.get("name"))) is not None:
            _fix_slide(joint, place)
    joints = tuple(
        replace(joint, kind="fixed", mimic=None) if joint.name in places else joint for joint in description.joints
    )
    return replace(description, xml=str(etree.tostring(root, encoding="unicode")), joints=joints)


def _fix_slide(joint: Any, place: float) -> None:
    """Makes a joint fixed, with its origin where the slide is at `place`, m."""
    origin = joint.find("origin")
    if origin is None:
        origin = etree.SubElement(joint, "origin")
    turned = np.eye(3)
    for about, angle in enumerate(float(word) for word in origin.get("rpy", "0 0 0").split()):
        turned = screw(about, angle, 0.0)[:3, :3] @ turned
    axis = [float(word) for word in joint.find("axis").get("xyz").split()]
    start = [float(word) for word in origin.get("xyz", "0 0 0").split()]
    origin.set("xyz", " ".join(repr(float(each)) for each in start + place * (turned @ axis)))
    joint.set("type", "fixed")
    for each in joint.findall("mimic"):
        joint.remove(each)


def _parse(root: Any) -> Any:
    """The robot that yourdfpy makes of the checked tree."""
    try:
        return urdf.URDF.load(io.BytesIO(etree.tostring(root)), build_scene_graph=False, load_meshes=False).robot
    except Exception as error:  # yourdfpy raises any error on input it cannot parse
        raise UrdfError(f"cannot be read: {type(error).__name__}: {error}") from error


def _joint(
    joint: Any, moving: set[str], problems: dict[str, tuple[str, str]], parts: dict[str, str], notes: Notes
) -> Joint:
    kind, problem = problems.get(joint.name, (joint.type, ""))
    lower, upper = _limits(joint, notes)
    velocity = math.inf if joint.limit is None else joint.limit.velocity or math.inf
    mimic = joint.mimic and Mimic(joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset)
    if mimic is not None and mimic.source not in moving:
        notes.add(f"mimics {shown(mimic.source)}, which is no joint that moves: it is free", named("joint", joint.name))
        mimic = None
    length = 0.0 if joint.origin is None else math.hypot(*joint.origin[:3, 3])
    ends, part_of = (joint.parent, joint.child), parts.get(joint.name, "")
    return Joint(joint.name, kind, *ends, lower, upper, velocity, mimic, problem, length, part_of)


def _limits(joint: Any, notes: Notes) -> tuple[float, float]:
    """Position limits; infinite if not stated."""
    limit, name = joint.limit, named("joint", joint.name)
    if limit is None or joint.type not in ("revolute", "prismatic"):
        return -math.inf, math.inf
    low, high = limit.lower or 0.0, limit.upper or 0.0
    if low == high == 0:
        if joint.mimic is None:
            stated = "states no position limits" if limit.lower is None else "has position limits 0 and 0, as for none"
            notes.add(f"{stated}: it is taken as unlimited", name)
        return -math.inf, math.inf
    largest = max(abs(low), abs(high))
    if joint.type == "revolute" and SEEMS_DEGREES < largest < MOST_DEGREES:
        notes.add(f"has limits {low:g} to {high:g} rad: are they degrees?", name)
    return low if low > -NO_LIMIT else -math.inf, high if high < NO_LIMIT else math.inf
