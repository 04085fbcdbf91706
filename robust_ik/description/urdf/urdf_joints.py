"""Reads the joints of a URDF; a joint that cannot move as written is an error only for chains that need it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from lxml import etree

from robust_ik.description.joint_tree import MOVING_TYPES
from robust_ik.description.notes import Notes, named
from robust_ik.description.urdf.mobile_joints import PARTS, split_mobile_joints
from robust_ik.description.urdf.urdf_numbers import LARGEST, are_numbers, numbers, shown

JOINT_TYPES = (*MOVING_TYPES, "fixed", "floating", "planar")
ENDLESS = ("continuous", *PARTS)
"""Kinds of joints that have no limits of position; those that a file states count for nothing, as in ROS."""
LEAST_AXIS = 1e-6
"""Length below which an axis is zero.

Chosen: URDF asks for 1, files write other lengths, rounding leaves less than this.
"""
LARGEST_LIMIT = 1e18
"""Largest limit; files have limits as large as 1e16."""
STANDS = "it stands still at zero, and a tip that it moves is refused"
_UNUSED = {
    "dynamics": ("damping", "friction"),
    "calibration": ("rising", "falling", "reference_position"),
    "safety_controller": ("k_velocity", "k_position", "soft_lower_limit", "soft_upper_limit"),
}
_MOVES = ("axis", "limit", "mimic", *_UNUSED)


def mend_joints(root: Any, notes: Notes) -> tuple[dict[str, tuple[str, str]], dict[str, str]]:
    """Writes joints out in full, with one degree of freedom each, and makes those that cannot move fixed.

    Returns:
        For those that cannot move, by name: the kind and the reason. For the parts of planar and floating joints, by
        name: the joint that each is a part of.
    """
    problems: dict[str, tuple[str, str]] = {}
    joints = root.findall("joint")
    for joint in joints:
        _drop_unused(joint, notes)
        if problem := _problem(joint, notes):
            _stop(joint, problem, problems, notes)
    by_name = {joint.get("name"): joint for joint in joints}
    for name, through in _circles(joints).items():
        _stop(by_name[name], f"mimics itself, through {' → '.join(through)}", problems, notes)
    parts = split_mobile_joints(root, notes)
    for joint in [joint for joint in root.findall("joint") if joint.find("mimic") is not None]:
        if whole := [part for part, of in parts.items() if of == joint.find("mimic").get("joint")]:
            _stop(
                joint,
                f"mimics {named('joint', parts[whole[0]])}, of which {', '.join(whole)} can be mimicked",
                problems,
                notes,
            )
    _straighten(root, notes)
    return problems, parts


def _stop(joint: Any, problem: str, problems: dict[str, tuple[str, str]], notes: Notes) -> None:
    name, kind = joint.get("name"), joint.get("type")
    problems[name] = (kind if kind in JOINT_TYPES else "fixed", problem)
    notes.add(f"{problem}: {STANDS}", named("joint", name))
    joint.set("type", "fixed")
    _drop(joint, _MOVES)


def _drop(joint: Any, tags: Sequence[str]) -> None:
    for part in list(joint.iterchildren(*tags)):
        joint.remove(part)


def _drop_unused(joint: Any, notes: Notes) -> None:
    """Drops unreadable elements that kinematics never use."""
    for tag, attributes in _UNUSED.items():
        for element in joint.findall(tag):
            readable = all(are_numbers(element.get(attribute), 1, LARGEST_LIMIT) for attribute in attributes)
            needed = {"dynamics": attributes, "safety_controller": attributes[:1]}.get(tag, ())
            if not readable or (needed and not any(element.get(each) is not None for each in needed)):
                joint.remove(element)
                notes.add(f"a <{tag}> that cannot be read is left out", named("joint", joint.get("name")))
    for limit in joint.findall("limit"):
        if not are_numbers(limit.get("effort"), 1, LARGEST_LIMIT):
            limit.set("effort", "0")
            notes.add("an effort that cannot be read is left out", named("joint", joint.get("name")))


def _problem(joint: Any, notes: Notes) -> str:
    """The reason why a joint cannot move as written; empty if it can."""
    kind = joint.get("type")
    if kind not in JOINT_TYPES:
        given = None if kind is None else shown(kind)
        return f"has type {given}; possible are {', '.join(JOINT_TYPES)}"
    if kind == "fixed":
        _drop(joint, ("axis", "limit", "mimic"))
        return ""
    if kind in PARTS and joint.find("mimic") is not None:
        notes.add(f"is {kind}, so that it cannot mimic a joint: it is free", named("joint", joint.get("name")))
        _drop(joint, ("mimic",))
    if kind == "floating":
        _drop(joint, ("axis",))
        return _limit_problem(joint, kind, notes)
    return _axis_problem(joint) or _mimic_problem(joint) or _limit_problem(joint, kind, notes)


def _axis_problem(joint: Any) -> str:
    axis = joint.find("axis")
    text = "1 0 0" if axis is None else axis.get("xyz", "1 0 0")
    found = numbers(text)
    if found is None or len(found) != 3:
        return f"has <axis xyz={shown(text)}>, which must hold 3 finite numbers of at most {LARGEST:g}"
    return "has a zero axis" if math.hypot(*found) < LEAST_AXIS else ""


def _mimic_problem(joint: Any) -> str:
    mimic = joint.find("mimic")
    if mimic is None:
        return ""
    if not mimic.get("joint"):
        return "has a <mimic> that names no joint"
    return next((_no_number(mimic, each, LARGEST) for each in ("multiplier", "offset") if _unread(mimic, each)), "")


def _limit_problem(joint: Any, kind: str, notes: Notes) -> str:
    limit = joint.find("limit")
    if limit is None:
        if kind in ENDLESS:
            return ""
        instead = ", or make it continuous" if kind == "revolute" else ""
        return f"is {kind} but has no <limit>; add <limit lower= upper= velocity= effort=>{instead}"
    if kind in ENDLESS:
        limit.attrib.pop("lower", None)
        limit.attrib.pop("upper", None)
    for attribute in ("lower", "upper", "velocity"):
        if _unread(limit, attribute, LARGEST_LIMIT):
            return _no_number(limit, attribute, LARGEST_LIMIT)
    if float(limit.get("velocity", "0")) < 0:
        return "has a negative speed limit"
    return _reversed(joint, limit, notes)


def _reversed(joint: Any, limit: Any, notes: Notes) -> str:
    low, high = (float(limit.get(attribute, "0")) for attribute in ("lower", "upper"))
    if low <= high:
        return ""
    stated = "" if {"lower", "upper"} <= set(limit.keys()) else " (one that is not stated is 0)"
    says = f"has its limits reversed: lower {low} > upper {high}{stated}"
    if joint.find("mimic") is None:
        return says
    for attribute in ("lower", "upper"):
        limit.attrib.pop(attribute, None)
    notes.add(f"{says}; it follows another joint, whose limits hold", named("joint", joint.get("name")))
    return ""


def _unread(element: Any, attribute: str, largest: float = LARGEST) -> bool:
    return not are_numbers(element.get(attribute), 1, largest)


def _no_number(element: Any, attribute: str, largest: float) -> str:
    text = shown(element.get(attribute))
    return f"has <{element.tag} {attribute}={text}>, which must hold 1 finite number of at most {largest:g}"


def _circles(joints: list[Any]) -> dict[str, list[str]]:
    """Joints that mimic each other in a circle, each with the first ten joints of its circle."""
    follows = {joint.get("name"): mimic.get("joint") for joint in joints if (mimic := joint.find("mimic")) is not None}
    done: set[str] = set()
    circles: dict[str, list[str]] = {}
    for first in follows:
        path: dict[str, None] = {}
        name = first
        while name in follows and name not in done and name not in path:
            path[name] = None
            name = follows[name]
        if name in path:
            through = list(path)[list(path).index(name) :]
            circles.update(dict.fromkeys(through, through[:10]))
        done.update(path)
    return circles


def _straighten(root: Any, notes: Notes) -> None:
    """Writes out defaults that a URDF may leave out, and forms that the later parsers read differently."""
    followed = {mimic.get("joint") for mimic in root.iterfind("joint/mimic")}
    for joint in root.findall("joint"):
        if joint.get("type") in MOVING_TYPES:
            _write_axis(joint, notes)
        if joint.get("type") == "continuous" and (joint.get("name") in followed or joint.find("mimic") is not None):
            # As (cos, sin) it would lose its number of turns, which the joints that follow it need.
            joint.set("type", "revolute")
            for limit in joint.findall("limit"):
                joint.remove(limit)
            etree.SubElement(joint, "limit")
            says = "is continuous and mimicked: taken as revolute without limits"
            notes.add(says, named("joint", joint.get("name")))
        for limit in joint.findall("limit"):
            for attribute in ("effort", "velocity"):
                limit.set(attribute, limit.get(attribute, "0"))


def _write_axis(joint: Any, notes: Notes) -> None:
    """Writes the unit axis; it is x if the file has none."""
    axis = joint.find("axis")
    if axis is not None and axis.get("xyz") is None:
        notes.add("has an <axis> without xyz, which is taken as x", named("joint", joint.get("name")))
    if axis is None:
        axis = etree.SubElement(joint, "axis")
    found = [float(word) for word in axis.get("xyz", "1 0 0").split()]
    length = math.hypot(*found)
    axis.set("xyz", " ".join(repr(number / length) for number in found))
