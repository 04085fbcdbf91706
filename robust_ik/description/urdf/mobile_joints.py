"""Planar and floating joints, taken as what they are: joints of one degree of freedom, one after the other.

A planar joint is two slides in the axes of the plane, which stand still in the frame that it moves in, then a turn
about the plane's normal. A floating joint is three slides along x, y and z, then yaw about z, pitch about the y that
yaw has turned, and roll about the x that both have turned: the angles of a URDF's rpy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import numpy as np
from lxml import etree

from robust_ik.checks import Array
from robust_ik.description.notes import Notes, named
from robust_ik.description.urdf.urdf_numbers import NO_LIMIT

PARTS = {"planar": ("x", "y", "yaw"), "floating": ("x", "y", "z", "yaw", "pitch", "roll")}
"""What stands for a joint of several degrees of freedom; `<joint>_x` and so on are their names."""
PITCH_MARGIN = 0.1
"""How far from ±π/2 the pitch of a floating joint ends, rad.

At ±π/2 yaw and roll turn about one line, whatever the robot is. Chosen: at 0.1, yaw and roll run at most ten times as
fast as the body turns; less margin lets them run faster, more forbids more orientations.
"""
MOST_PITCH = math.pi / 2 - PITCH_MARGIN
"""Limit of the pitch of a floating joint, rad; it follows from the margin."""
NEAR_X = 0.9
"""From this component along x on, the normal of a plane counts as near x, and the plane's first axis comes from y.

Chosen: any from 0.58, where y and z may be as near, to 1 would do; x is what people expect, so that y is rare.
"""

_TYPES = {"x": "prismatic", "y": "prismatic", "z": "prismatic", "pitch": "revolute"}
"""Types of the parts that have limits; the others turn without end."""


def plane_axes(normal: Array) -> tuple[Array, Array]:
    """The two axes of a plane: x as far as it lies in the plane, and normal × x; for a normal near x, y instead of x.

    For the normal z they are x and y.

    Args:
        normal: A unit vector, (3,).
    """
    start = np.array([0.0, 1.0, 0.0]) if abs(normal[0]) > NEAR_X else np.array([1.0, 0.0, 0.0])
    along = start - (start @ normal) * normal
    first = along / math.hypot(*along)
    return first, np.cross(normal, first)


def split_mobile_joints(root: Any, notes: Notes) -> dict[str, str]:
    """Writes each planar and each floating joint as joints of one degree of freedom, with links without mass between.

    Returns:
        For each of these joints, the name of the joint that it is a part of.
    """
    parts: dict[str, str] = {}
    taken = names_in(root)
    for joint in [joint for joint in root.findall("joint") if joint.get("type") in PARTS]:
        made = [part.get("name") for part in split_joint(root, joint, taken)]
        parts.update(dict.fromkeys(made, joint.get("name")))
        notes.add(f"is {joint.get('type')}: it is taken as {', '.join(made)}", named("joint", joint.get("name")))
        tell(joint, notes)
    return parts


def names_in(root: Any) -> set[str]:
    """The names of all links and joints."""
    return {each.get("name") for tag in ("link", "joint") for each in root.findall(tag)}


def free_name(name: str, taken: set[str]) -> str:
    """The name, with as many _ behind it as it takes to be none of those taken, to which it is added."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def split_joint(root: Any, joint: Any, taken: set[str]) -> list[Any]:
    """Puts the parts of a planar or floating joint in its place; they come in the order of the chain.

    Args:
        root: The tree that has the joint.
        joint: The joint, with an axis that is not zero.
        taken: Names that the parts and the links between them must not have; theirs are added.
    """
    labels, place = PARTS[joint.get("type")], root.index(joint)
    link, last = (joint.find(end).get("link") for end in ("parent", "child"))
    parts: list[Any] = []
    for label, axis in zip(labels, _axes(joint)):
        name = free_name(f"{joint.get('name')}_{label}", taken)
        child = last if label == labels[-1] else free_name(f"{name}_link", taken)
        part = etree.Element("joint", name=name, type=_TYPES.get(label, "continuous"))
        if not parts and (origin := joint.find("origin")) is not None:
            part.append(deepcopy(origin))
        etree.SubElement(part, "parent", link=link)
        etree.SubElement(part, "child", link=child)
        etree.SubElement(part, "axis", xyz=" ".join(repr(float(each)) for each in axis))
        _limit(part, label, joint.find("limit"))
        root.insert(place + len(parts), part)
        parts.append(part)
        if child != last:
            etree.SubElement(root, "link", name=child)
        link = child
    root.remove(joint)
    return parts


def _axes(joint: Any) -> Iterator[Array]:
    if joint.get("type") == "floating":
        x, y, z = np.eye(3)
        yield from (x, y, z, z, y, x)
        return
    normal = np.array(_normal(joint))
    yield from (*plane_axes(normal), normal)


def _normal(joint: Any) -> list[float]:
    """The unit normal of a planar joint's plane; x if the file has none."""
    axis = joint.find("axis")
    found = [float(word) for word in ("1 0 0" if axis is None else axis.get("xyz", "1 0 0")).split()]
    length = math.hypot(*found)
    return [number / length for number in found]


def _limit(part: Any, label: str, stated: Any) -> None:
    """Writes speed and effort as stated, and the limits of positions: those of pitch, or that a slide has none."""
    limit = etree.SubElement(part, "limit")
    for attribute in ("effort", "velocity"):
        limit.set(attribute, "0" if stated is None else stated.get(attribute, "0"))
    if label in _TYPES:
        end = MOST_PITCH if label == "pitch" else NO_LIMIT
        limit.set("lower", repr(-end))
        limit.set("upper", repr(end))


def tell(joint: Any, notes: Notes) -> None:
    """Notes what a user of a planar or floating joint should know of its parts."""
    about = named("joint", joint.get("name"))
    if joint.get("type") == "floating":
        says = f"its pitch ends at ±{MOST_PITCH:.4g} rad: at ±π/2 its coordinates are singular, though the robot is not"
        notes.add(says, about)
    elif _normal(joint)[2] != 1.0:
        stated = joint.find("axis") is not None
        normal = "as stated" if stated else "x, which URDF says if none is stated"
        notes.add(f"the normal of its plane is {normal}; Pinocchio and MoveIt take z whatever a file states", about)
