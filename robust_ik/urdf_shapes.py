"""The shapes of a URDF: checks that they can be read, and turns them into values."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.description import Box, Cylinder, Mesh, Shape, Sphere, Visual
from robust_ik.errors import UrdfError
from robust_ik.meshpaths import MeshPaths

_NEEDED = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length"), "mesh": ("filename",)}
_COUNTS = {"size": 3, "radius": 1, "length": 1}
_POSITIVE = re.compile(r"\+?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_NUMBER = re.compile(rf"-?{_POSITIVE.pattern}")


def check_shapes(root: Any) -> None:
    """Refuses shapes that cannot be read; drops those of a kind that URDF does not have, such as capsules.

    Raises:
        UrdfError: Sizes are missing or not positive.
    """
    for link in root.findall("link"):
        for part in [*link.findall("visual"), *link.findall("collision")]:
            shapes = part.findall("geometry/*")
            if not shapes or shapes[0].tag not in _NEEDED:
                link.remove(part)
                continue
            _check_shape(shapes[0], link.get("name"))


def _check_shape(shape: Any, link: str) -> None:
    for attribute in _NEEDED[shape.tag]:
        text = shape.get(attribute, "")
        count = _COUNTS.get(attribute)
        words = text.split()
        if count is None:
            continue
        if len(words) != count or not all(_POSITIVE.fullmatch(word) and 0 <= float(word) <= 1e6 for word in words):
            raise UrdfError(
                f"line {shape.sourceline}: <{shape.tag}> of link {link!r} needs {attribute} with {count} "
                f"number{'s' if count > 1 else ''} that are not negative, got {text!r}"
            )
    scale = shape.get("scale", "1").split()
    if len(scale) not in (1, 3) or not all(_NUMBER.fullmatch(word) and abs(float(word)) <= 1e6 for word in scale):
        raise UrdfError(
            f"line {shape.sourceline}: <mesh> of link {link!r} needs a scale of 1 or 3 numbers, "
            f"got {shape.get('scale')!r}"
        )


def visuals(robot: Any, paths: MeshPaths) -> Iterator[Visual]:
    """The visuals of yourdfpy's robot, meshes resolved.

    Raises:
        UrdfError: A mesh path climbs out of its package.
    """
    materials = {material.name: material for material in robot.materials}
    for link in robot.links:
        for visual in link.visuals:
            color = _color(visual.material, materials)
            yield Visual(link.name, _placement(visual), _shape(visual.geometry, paths), color)


def collisions(robot: Any, paths: MeshPaths) -> Iterator[Visual]:
    """The collision shapes of yourdfpy's robot, meshes resolved; errors as for `visuals`."""
    for link in robot.links:
        for collision in link.collisions:
            yield Visual(link.name, _placement(collision), _shape(collision.geometry, paths))


def _placement(part: Any) -> Array:
    return readonly(np.eye(4) if part.origin is None else part.origin)


def _shape(geometry: Any, paths: MeshPaths) -> Shape:
    if geometry.box is not None:
        x, y, z = (float(side) for side in geometry.box.size)
        return Box((x, y, z))
    if geometry.sphere is not None:
        return Sphere(float(geometry.sphere.radius))
    if geometry.cylinder is not None:
        return Cylinder(float(geometry.cylinder.radius), float(geometry.cylinder.length))
    name = geometry.mesh.filename or ""
    found = paths.resolve(name)
    x, y, z = np.broadcast_to(1.0 if geometry.mesh.scale is None else geometry.mesh.scale, 3).tolist()
    return Mesh(name, found.path, (x, y, z), found.root, found.problem)


def _color(material: Any, materials: dict[str, Any]) -> tuple[float, float, float, float] | None:
    if material is None:
        return None
    if material.color is None:
        material = materials.get(material.name)
    if material is None or material.color is None:
        return None
    red, green, blue, alpha = (float(channel) for channel in material.color.rgba)
    return red, green, blue, alpha
