"""Puts a robot on a base that moves: in the plane of the ground, or freely."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from lxml import etree

from robust_ik.description.joint_tree import Description, Joint
from robust_ik.description.notes import Notes
from robust_ik.description.urdf.mobile_joints import free_name, names_in, split_joint, tell
from robust_ik.description.urdf.urdf_numbers import NO_LIMIT

BASE, WORLD = "base", "world"
"""Names of the joint that is added, whose parts are base_x and so on, and of the link that it moves in."""


def stand_on(description: Description, kind: str) -> Description:
    """The description with a joint between the world and its root, as parts of one degree of freedom each.

    Its origin is the root's, and its speeds have no limits.

    Args:
        description: A description.
        kind: "planar" (x and y of the root at zero, and yaw about its z) or "floating".
    """
    root, notes = etree.fromstring(description.xml.encode()), Notes()
    taken = names_in(root)
    world = free_name(WORLD, taken)
    etree.SubElement(root, "link", name=world)
    joint = etree.SubElement(root, "joint", name=free_name(BASE, set(description.parts)), type=kind)
    etree.SubElement(joint, "parent", link=world)
    etree.SubElement(joint, "child", link=description.root)
    etree.SubElement(joint, "axis", xyz="0 0 1")
    parts = tuple(_joint(part, joint.get("name")) for part in split_joint(root, joint, taken))
    tell(joint, notes)
    return replace(
        description,
        xml=str(etree.tostring(root, encoding="unicode")),
        links=(world, *description.links, *(part.child for part in parts[:-1])),
        joints=(*parts, *description.joints),
        notes=(*description.notes, *notes.sentences()),
    )


def _joint(part: Any, whole: str) -> Joint:
    upper = float(part.find("limit").get("upper", "inf"))
    end = math.inf if upper >= NO_LIMIT else upper
    ends = (part.find("parent").get("link"), part.find("child").get("link"))
    return Joint(part.get("name"), part.get("type"), *ends, -end, end, math.inf, part_of=whole)
