"""Reads the shapes of a URDF; unreadable ones are left out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.description.joint_tree import Box, Cylinder, Mesh, Shape, Sphere, Visual
from robust_ik.description.meshes.mesh_paths import MeshPaths
from robust_ik.description.notes import Notes, named
from robust_ik.description.urdf.urdf_numbers import are_numbers, numbers, shown

_NEEDED = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}, "mesh": {}}
_LEFT_OUT = "it is left out, in drawings and where collisions are looked for"
_MASSES = {"mass": ("value",), "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
LARGEST_MASS = 1e18
"""Largest mass, kg, and inertia, kg m².

Chosen: as large as limits may be (`urdf_joints.LARGEST_LIMIT`), far below overflow.
"""


def mend_shapes(root: Any, notes: Notes) -> None:
    """Leaves out shapes, colours and masses that cannot be read: kinematics do not need them."""
    for link in root.findall("link"):
        name = named("link", link.get("name"))
        _mend_masses(link, name, notes)
        for part in [*link.findall("visual"), *link.findall("collision")]:
            if problem := _problem(part):
                link.remove(part)
                notes.add(f"a <{part.tag}> {problem}: {_LEFT_OUT}", name)
            for material in part.findall("material"):
                _mend_colour(material, name, notes)
    seen: set[str] = set()
    for material in root.findall("material"):
        name = named("material", material.get("name", ""))
        _mend_colour(material, name, notes)
        if material.get("name") in seen:
            root.remove(material)
            notes.add("it is defined twice; the first is taken", name)
        seen.add(material.get("name"))


def _mend_masses(link: Any, name: str, notes: Notes) -> None:
    for inertial in link.findall("inertial"):
        origins = [(each, attribute) for each in inertial.findall("origin") for attribute in ("xyz", "rpy")]
        if not all(_is_whole(inertial.find(tag), attributes) for tag, attributes in _MASSES.items()) or not all(
            are_numbers(origin.get(attribute), 3) for origin, attribute in origins
        ):
            link.remove(inertial)
            notes.add("a mass or inertia that is incomplete or no number is left out", name)


def _is_whole(element: Any, attributes: tuple[str, ...]) -> bool:
    """Whether an element exists with all its numbers; else Pinocchio's reader would print a warning."""
    return element is not None and all(are_numbers(element.get(each, ""), 1, LARGEST_MASS) for each in attributes)


def _mend_colour(material: Any, name: str, notes: Notes) -> None:
    """Makes a colour four numbers: the first four if there are more, opaque if there are three."""
    for color in material.findall("color"):
        found = numbers(color.get("rgba", ""))
        if found is not None and len(found) == 4:
            continue
        if found is None or len(found) < 3:
            material.remove(color)
            notes.add("a colour that is not four numbers is left out", name)
        else:
            color.set("rgba", " ".join(f"{channel:g}" for channel in (*found, 1.0)[:4]))
            notes.add(f"a colour of {len(found)} numbers is read as {color.get('rgba')}", name)


def _problem(part: Any) -> str:
    """The reason why a shape cannot be read; empty if it can."""
    for origin in part.findall("origin"):
        for attribute in ("xyz", "rpy"):
            if not are_numbers(origin.get(attribute), 3):
                return f"has <origin {attribute}={shown(origin.get(attribute))}>, which must hold 3 finite numbers"
    shapes = part.findall("geometry/*")
    if not shapes:
        return "has no geometry"
    if shapes[0].tag not in _NEEDED:
        return f"is a {str(shapes[0].tag)[:60]}, which is no shape of a URDF"
    return _size_problem(shapes[0])


def _size_problem(shape: Any) -> str:
    for attribute, count in _NEEDED[shape.tag].items():
        found = numbers(shape.get(attribute, ""))
        if found is None or len(found) != count or min(found) < 0:
            given = shown(shape.get(attribute, ""))
            numbers_ = "1 number that is" if count == 1 else f"{count} numbers that are"
            return f"is a {shape.tag} that needs {attribute} with {numbers_} not negative, got {given}"
    if shape.tag == "mesh" and not shape.get("filename"):
        return "is a mesh that names no file"
    if shape.tag == "mesh" and (text := shape.get("scale")) is not None:
        scale = numbers(text)
        if scale is None or len(scale) not in (1, 3):
            return f"is a mesh that needs a scale of 1 or 3 numbers, got {shown(text)}"
    return ""


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
