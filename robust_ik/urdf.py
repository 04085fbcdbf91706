"""Reads a URDF: checks the XML before anything else looks at it, then lets yourdfpy read it."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yourdfpy
from lxml import etree

from robust_ik.description import (
    MOVING_TYPES,
    Box,
    Cylinder,
    Description,
    Joint,
    Mesh,
    Mimic,
    Shape,
    Sphere,
    Visual,
)
from robust_ik.errors import RobotNotFoundError, UrdfError
from robust_ik.linalg import readonly
from robust_ik.meshpaths import MeshPaths
from robust_ik.urdf_checks import check_tree, safe_tree

MAX_BYTES = 50_000_000


def read_urdf(path: str | Path, package_dirs: Sequence[str | Path] = ()) -> Description:
    """A checked description from a URDF file.

    Args:
        path: The file.
        package_dirs: Folders of packages that `package://` paths name, and further folders meshes may lie in.

    Raises:
        RobotNotFoundError: There is no such file.
        UrdfError: The file is broken, unsafe or not supported; the message names the place.
    """
    path = Path(path).expanduser()
    if not path.is_file():
        raise RobotNotFoundError(f"there is no file {str(path)!r}")
    if path.stat().st_size > MAX_BYTES:
        raise UrdfError(f"{path} has {path.stat().st_size} bytes; a URDF of over {MAX_BYTES} is refused")
    folder = Path.cwd() / path.parent
    return parse_urdf(path.read_bytes(), source=str(path), folder=folder, package_dirs=package_dirs)


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
        robot = _parse(root)
        notes: list[str] = []
        moving = {joint.name for joint in robot.joints if joint.type in MOVING_TYPES}
        joints = tuple(_joint(joint, moving, notes) for joint in robot.joints)
        _check_mimics(joints)
        paths = MeshPaths(folder, tuple(Path.cwd() / Path(given).expanduser() for given in package_dirs))
        visuals = tuple(_visuals(robot, paths))
    except UrdfError as error:
        raise UrdfError(f"{source}: {error}") from error
    return Description(
        name=robot.name,
        xml=etree.tostring(root, encoding="unicode"),
        links=tuple(link.name for link in robot.links),
        joints=joints,
        visuals=visuals,
        source=source,
        notes=tuple(notes),
    )


def fix_joints(xml: str, keep: set[str]) -> str:
    """URDF text in which every joint outside `keep` is fixed at zero."""
    root = etree.fromstring(xml.encode())
    for joint in root.findall("joint"):
        if joint.get("name") not in keep:
            joint.set("type", "fixed")
    return str(etree.tostring(root, encoding="unicode"))


def _parse(root: Any) -> Any:
    """Yourdfpy's reading of the checked tree."""
    try:
        return yourdfpy.URDF.load(io.BytesIO(etree.tostring(root)), build_scene_graph=False, load_meshes=False).robot
    except Exception as error:  # yourdfpy raises whatever its parsing trips over
        raise UrdfError(f"cannot be read: {type(error).__name__}: {error}") from error


def _joint(joint: Any, moving: set[str], notes: list[str]) -> Joint:
    lower, upper, velocity = -math.inf, math.inf, math.inf
    limit = joint.limit
    if limit is not None:
        if limit.velocity:
            velocity = abs(limit.velocity)
        low, high = limit.lower or 0.0, limit.upper or 0.0
        if joint.type in ("revolute", "prismatic"):
            if low > high:
                raise UrdfError(f"joint {joint.name!r} has its limits reversed: lower {low} > upper {high}")
            if low == high == 0:
                notes.append(f"joint {joint.name!r} states no position limits: it is taken as unlimited")
            else:
                lower, upper = low, high
    mimic = joint.mimic and Mimic(joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset)
    if mimic is not None and mimic.source not in moving:
        notes.append(f"joint {joint.name!r} mimics {mimic.source!r}, which is no joint that moves: it is free")
        mimic = None
    return Joint(joint.name, joint.type, joint.parent, joint.child, lower, upper, velocity, mimic)


def _check_mimics(joints: tuple[Joint, ...]) -> None:
    by_name = {joint.name: joint for joint in joints}
    for joint in joints:
        followed = [joint.name]
        while (mimic := by_name[followed[-1]].mimic) is not None:
            if mimic.source in followed:
                raise UrdfError(f"joint {joint.name!r} mimics itself, through {' → '.join(followed)}")
            followed.append(mimic.source)


def _visuals(robot: Any, paths: MeshPaths) -> Iterator[Visual]:
    materials = {material.name: material for material in robot.materials}
    for link in robot.links:
        for visual in link.visuals:
            shape = _shape(visual.geometry, paths)
            if shape is not None:
                placement = np.eye(4) if visual.origin is None else visual.origin
                yield Visual(link.name, readonly(placement), shape, _color(visual.material, materials))


def _shape(geometry: Any, paths: MeshPaths) -> Shape | None:
    if geometry is None:
        return None
    if geometry.box is not None:
        return Box(tuple(float(side) for side in geometry.box.size))  # type: ignore[arg-type]
    if geometry.sphere is not None:
        return Sphere(float(geometry.sphere.radius))
    if geometry.cylinder is not None:
        return Cylinder(float(geometry.cylinder.radius), float(geometry.cylinder.length))
    if geometry.mesh is not None:
        name = geometry.mesh.filename or ""
        found = paths.resolve(name)
        x, y, z = np.broadcast_to(1.0 if geometry.mesh.scale is None else geometry.mesh.scale, 3).tolist()
        return Mesh(name, found.path, (x, y, z), found.root, found.problem)
    return None


def _color(material: Any, materials: dict[str, Any]) -> tuple[float, float, float, float] | None:
    if material is None:
        return None
    if material.color is None:
        material = materials.get(material.name)
    if material is None or material.color is None:
        return None
    red, green, blue, alpha = (float(channel) for channel in material.color.rgba)
    return red, green, blue, alpha
