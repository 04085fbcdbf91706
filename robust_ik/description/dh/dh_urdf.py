"""Converts a DHTable to URDF text, so that DH tables are loaded like any other robot."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from lxml import etree

from robust_ik.checks import Array
from robust_ik.description.dh.dh_table import DHJoint, DHTable, screw
from robust_ik.description.yourdfpy_module import urdf

UNSTATED_VELOCITY = 1000.0
"""Velocity limit that is written, rad/s or m/s.

A URDF's <limit> must state one: chosen so large that it stops nothing.
"""
UNSTATED_EFFORT = 1000.0
"""Effort limit that is written, N m or N.

A URDF's <limit> must state one; a DH table has none and kinematics use none.
"""
JOINT_COLOR, LINK_COLOR = (0.13, 0.24, 0.38, 1.0), (0.80, 0.83, 0.86, 1.0)


def dh_to_urdf(table: DHTable) -> str:
    """A URDF with the table's kinematics and simple shapes for display.

    Joint i turns about or slides along the z axis of link i; all constant transforms are in the joints' origins. The
    links are "base", "link1" … "linkn" and, fixed to the last one, "tool", which is the tip; a name that a joint has
    already gets an underscore. There are no inertias.

    A URDF must have limits. So what the table does not state is filled in: a revolute joint gets ±π (a full turn from
    the other limit if only one is stated), every joint a speed limit of 1000 rad/s or m/s and an effort limit of 1000
    Nm or N. Take limits from the table, where those are infinite.

    Args:
        table: The arm.

    Returns:
        XML text. Numbers are written to their last bit; poses agree with the table's to 1e-12 of its size.
    """
    links = _link_names(table)
    robot = urdf.Robot(
        name=table.name,
        links=[urdf.Link(name=name, visuals=list(shapes)) for name, shapes in zip(links, _shapes(table))],
        joints=_joints(table, links),
        materials=[_material("joint", JOINT_COLOR), _material("link", LINK_COLOR)],
    )
    tree = urdf.URDF(robot=robot, build_scene_graph=False, load_meshes=False).write_xml()
    _write_origins(tree.getroot(), robot)
    return str(etree.tostring(tree, pretty_print=True, encoding="unicode"))


# ---------------------------------------------------------------------------------------------------- joints
def _link_names(table: DHTable) -> list[str]:
    return [_free(name, table.joint_names) for name in ("base", *(f"link{i + 1}" for i in range(table.n)))] + ["tool"]


def _free(name: str, taken: tuple[str, ...]) -> str:
    return name if name not in taken else _free(name + "_", taken)


def _joints(table: DHTable, links: list[str]) -> list[Any]:
    joints = [
        urdf.Joint(
            name=joint.name,
            type=joint.kind,
            parent=parent,
            child=child,
            origin=origin,
            axis=np.array([0.0, 0.0, 1.0]),
            limit=_limit(joint),
        )
        for joint, (parent, child), origin in zip(table.joints, itertools.pairwise(links), table.placements)
    ]
    name = _free("tool_joint", table.joint_names)
    return [*joints, urdf.Joint(name, "fixed", links[-2], links[-1], origin=table.placements[-1])]


def _limit(joint: DHJoint) -> Any:
    lower, upper = joint.lower, joint.upper
    if lower is None:
        lower = -math.pi if upper is None else upper - 2 * math.pi
    if upper is None:
        upper = math.pi if joint.lower is None else lower + 2 * math.pi
    velocity = UNSTATED_VELOCITY if joint.velocity is None else joint.velocity
    return urdf.Limit(effort=UNSTATED_EFFORT, velocity=velocity, lower=lower, upper=upper)


def _write_origins(root: Any, robot: Any) -> None:
    """Writes the origins again, since yourdfpy's Euler angles lose half the digits, or all, near a pitch of 90°."""
    shapes = (visual.origin for link in robot.links for visual in link.visuals)
    for element, pose in zip(
        root.iter("origin"), itertools.chain(shapes, (j.origin for j in robot.joints)), strict=True
    ):
        element.set("xyz", _text(pose[:3, 3]))
        element.set("rpy", _text(_rpy(pose[:3, :3])))


def _rpy(rotation: Array) -> Array:
    """Angles with rotation = Rz(yaw) Ry(pitch) Rx(roll), exact to rounding at every pitch.

    Pitch and roll are computed from Rz(−yaw)·rotation with the yaw that is returned: near a pitch of ±90° the
    yaw is ill-defined, but the product of the three is not.
    """
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    rest = screw(2, -yaw, 0.0)[:3, :3] @ rotation
    return np.array([math.atan2(-rest[1, 2], rest[1, 1]), math.atan2(-rest[2, 0], rest[0, 0]), yaw])


def _text(numbers: Array) -> str:
    return " ".join(repr(number + 0.0) for number in numbers.tolist())  # + 0.0 turns −0.0 into 0.0


# ---------------------------------------------------------------------------------------------------- shapes
def _shapes(table: DHTable) -> Iterator[Iterator[Any]]:
    """The visuals of each link: its joint, the way along d and a to the next joint, and the rail of a sliding joint."""
    size = _size(table)
    for k in range(table.n + 1):
        joint = iter([_joint_shape(table.joints[k - 1], size)] if k > 0 else [])
        yield itertools.chain(joint, _segments(_way(table, k), size), _segments(_rail(table, k), size))
    yield iter([_visual(np.eye(4), "joint", sphere=urdf.Sphere(_round(0.02 * size)))])


def _size(table: DHTable) -> float:
    """Length scale of the shapes, m: Σ|a| + Σ|d| + travel of sliding joints + tool."""
    slides = [max(abs(j.lower or 0.0), abs(j.upper or 0.0)) for j in table.joints if j.kind == "prismatic"]
    rows = [abs(joint.a) + abs(joint.d) for joint in table.joints]
    return sum(rows) + sum(slides) + float(np.linalg.norm(table.tool[:3, 3])) or 1.0


def _way(table: DHTable, k: int) -> list[Array]:
    """Corners, in the frame of link k, of the path from its joint to the next one or to the tool."""
    corners = [np.zeros(3)]
    start = table.base if k == 0 else np.eye(4)
    corners.append(start[:3, 3])
    if table.convention == "standard" and k > 0:
        row = table.joints[k - 1]
        corners.append(np.array([0.0, 0.0, row.d]))
        corners.append(np.array([row.a * math.cos(row.theta), row.a * math.sin(row.theta), row.d]))
    if table.convention == "modified" and k < table.n:
        corners.append((start @ screw(0, 0.0, table.joints[k].a))[:3, 3])
    return [*corners, table.placements[k][:3, 3]]


def _rail(table: DHTable, k: int) -> list[Array]:
    """The ends, in the frame of link k, of the rail along which the next joint slides; none if it turns."""
    if k == table.n or table.joints[k].kind == "revolute":
        return []
    ends = (min(table.lower[k], 0.0), max(table.upper[k], 0.0))
    return [(table.placements[k] @ screw(2, 0.0, end))[:3, 3] for end in ends]


def _segments(corners: list[Array], size: float) -> Iterator[Any]:
    """Slim cylinders between corners; those of zero length are left out."""
    for start, end in itertools.pairwise(corners):
        length = float(np.linalg.norm(end - start))
        if length > 1e-6 * size:
            cylinder = urdf.Cylinder(radius=_round(0.015 * size), length=_round(length))
            yield _visual(_along(start, end), "link", cylinder=cylinder)


def _along(start: Array, end: Array) -> Array:
    """A pose half way between two points, whose z axis points from one to the other."""
    x, y, z = (end - start).tolist()
    pose = screw(2, math.atan2(y, x), 0.0) @ screw(1, math.atan2(math.hypot(x, y), z), 0.0)
    pose[:3, 3] = (start + end) / 2
    return pose


def _joint_shape(joint: DHJoint, size: float) -> Any:
    """A cylinder about the axis of a revolute joint, a box on the axis of a prismatic one."""
    width, height = _round(0.03 * size), _round(0.09 * size)
    if joint.kind == "revolute":
        return _visual(np.eye(4), "joint", cylinder=urdf.Cylinder(radius=width, length=height))
    return _visual(np.eye(4), "joint", box=urdf.Box(size=np.array([2 * width, 2 * width, height])))


def _visual(pose: Array, material: str, **shape: Any) -> Any:
    return urdf.Visual(origin=pose, geometry=urdf.Geometry(**shape), material=urdf.Material(name=material))


def _material(name: str, rgba: tuple[float, ...]) -> Any:
    return urdf.Material(name=name, color=urdf.Color(rgba=np.array(rgba)))


def _round(number: float) -> float:
    """The number with six significant digits, enough for shapes."""
    return float(f"{number:.6g}")
