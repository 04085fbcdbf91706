"""Recognises xacro that was not expanded: xacro is a program that writes a URDF."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from lxml import etree

from robust_ik.description.notes import Notes
from robust_ik.description.urdf.urdf_numbers import shown
from robust_ik.errors import UrdfError

HOW = (
    "expand it: name the file .xacro and install robust-ik[xacro], or run 'xacro FILE > robot.urdf' (with ROS) or "
    "'xacrodoc FILE -o robot.urdf' (without)"
)
_SUBSTITUTION = re.compile(r"\$[{(]")
_HARMLESS = ("property", "arg", "macro", "include")
"""Xacro elements that add no link and no joint themselves; an include is still noted."""
_BUILDS = ("if", "unless", "insert_block", "element", "attribute", "call")


def check_expanded(root: Any, notes: Notes) -> bool:
    """Raises on xacro that would still change links and joints; other rests of xacro are noted and dropped.

    Returns:
        Whether xacro was left in the file.

    Raises:
        UrdfError: The file is unexpanded xacro.
    """
    for element in (root, *_kinematic(root)):
        for attribute, text in element.attrib.items():
            if _SUBSTITUTION.search(text):
                raise UrdfError(
                    f"it is xacro that was not expanded: line {element.sourceline} has {attribute}={shown(text)}; {HOW}"
                )
    left, defines = False, any(_is_xacro(each) for each in root.iter("{*}macro", "{*}include"))
    for parent in (root, *root.findall("link"), *root.findall("joint")):
        for element in [each for each in parent if etree.QName(each).namespace and _is_xacro(each)]:
            name = etree.QName(element).localname[:60]
            if _would_add(element, parent, defines):
                raise UrdfError(
                    f"it is xacro that was not expanded: line {element.sourceline} has <xacro:{name}>; {HOW}"
                )
            parent.remove(element)
            left = True
            notes.add(
                "left over from xacro, and passed over: expand the file if that is still to be done", f"<xacro:{name}>"
            )
    return left


def _is_xacro(element: Any) -> bool:
    return element.prefix == "xacro" or "xacro" in str(etree.QName(element).namespace)


def _would_add(element: Any, parent: Any, defines: bool) -> bool:
    """Whether xacro would replace an element by something that kinematics need.

    A call of a macro in a file that neither defines nor includes one is a rest of an expansion by hand.
    """
    name, space = etree.QName(element).localname, etree.QName(element).namespace
    if parent.tag == "link" or space.startswith("urn:undeclared:") or name in _HARMLESS:
        return False
    return name in _BUILDS or defines


def _kinematic(root: Any) -> Iterator[Any]:
    """Links and joints, and the elements inside joints."""
    yield from root.iterchildren("link")
    for joint in root.iterchildren("joint"):
        yield from joint.iter("*")
