"""Checks the XML of a URDF before anything else looks at it."""

from __future__ import annotations

import math
import re
from collections import Counter
from typing import Any

from lxml import etree

from robust_ik.description import MOVING_TYPES
from robust_ik.errors import UrdfError
from robust_ik.urdf_shapes import check_shapes

JOINT_TYPES = (*MOVING_TYPES, "fixed", "floating", "planar")
MAX_DEPTH = 1000
"""Joints from the root to a leaf; the parsers below recurse."""
LARGEST, LARGEST_LIMIT = 1e6, 1e18
"""Metres and radians as written, far below where products overflow; limits are written as large as 1e16."""
LEAST_AXIS = 1e-6
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


def safe_tree(xml: str | bytes, kind: str = "a URDF") -> Any:
    """The XML tree of a URDF or of its like, with no entity expanded, no DTD loaded, nothing fetched."""
    parser = etree.XMLParser(
        resolve_entities=False,
        load_dtd=False,
        no_network=True,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        root = etree.fromstring(_bytes(xml), parser)
    except etree.XMLSyntaxError as error:
        raise UrdfError(f"not well-formed XML: {error.msg}") from error
    if root.getroottree().docinfo.internalDTD is not None:
        raise UrdfError(f"it has a DOCTYPE, which could define entities; {kind} needs none: remove it")
    if root.tag != "robot" and etree.QName(root).localname == "robot":
        raise UrdfError(f"it has a default XML namespace (xmlns=…); {kind} has none: remove it")
    if root.tag != "robot":
        raise UrdfError(f"the root element is <{etree.QName(root).localname}>, not <robot>")
    return root


def _bytes(xml: str | bytes) -> bytes:
    """Text as UTF-8 bytes; what it declares of its encoding is no longer so and dropped."""
    if isinstance(xml, bytes):
        return xml
    try:
        return re.sub(r"^\s*<\?xml[^>]*\?>", "", xml).encode()
    except UnicodeEncodeError as error:
        raise UrdfError(f"not text: {error.reason} at character {error.start}") from error


def check_tree(root: Any) -> None:
    """Names, references and numbers, so that what follows cannot trip over them."""
    if not root.get("name"):
        root.set("name", "robot")
    links = [_named(link) for link in root.findall("link")]
    joints = root.findall("joint")
    if not links:
        raise UrdfError("it has no <link>")
    for kind, names in (("link", links), ("joint", [_named(joint) for joint in joints])):
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise UrdfError(f"two {kind}s are called {twice[0]!r}")
    for tag, attributes in _NUMBERS.items():
        for element in root.iter(tag):
            for attribute, count in attributes.items():
                _check_numbers(element, attribute, count)
    known = set(links)
    for joint in joints:
        _check_joint(joint, known)
    _check_is_tree(links, joints)
    check_shapes(root)


_NUMBERS: dict[str, dict[str, int]] = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "dynamics": {"damping": 1, "friction": 1},
    "mass": {"value": 1},
    "inertia": {"ixx": 1, "ixy": 1, "ixz": 1, "iyy": 1, "iyz": 1, "izz": 1},
    "limit": {"lower": 1, "upper": 1, "velocity": 1, "effort": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "color": {"rgba": 4},
}


def _named(element: Any) -> str:
    if not element.get("name"):
        raise UrdfError(f"a <{element.tag}> in line {element.sourceline} has no name")
    return str(element.get("name"))


def _check_numbers(element: Any, attribute: str, count: int) -> None:
    text = element.get(attribute)
    if text is None:
        return
    words = text.split()
    numbers = [float(word) if _NUMBER.fullmatch(word) else math.nan for word in words]
    largest = LARGEST_LIMIT if element.tag == "limit" else LARGEST
    if len(numbers) != count or not all(abs(number) <= largest for number in numbers):
        raise UrdfError(
            f"line {element.sourceline}: <{element.tag} {attribute}={text!r}> must hold {count} finite "
            f"number{'s' if count > 1 else ''} of at most {largest:g} (in {_place(element)})"
        )


def _place(element: Any) -> str:
    owner = next((e for e in element.iterancestors("joint", "link")), None)
    return "the robot" if owner is None else f"{owner.tag} {owner.get('name')!r}"


def _check_joint(joint: Any, links: set[str]) -> None:
    name, kind = joint.get("name"), joint.get("type")
    if kind not in JOINT_TYPES:
        raise UrdfError(f"joint {name!r} has type {kind!r}; possible are {', '.join(JOINT_TYPES)}")
    for end in ("parent", "child"):
        element = joint.find(end)
        link = None if element is None else element.get("link")
        if link not in links:
            raise UrdfError(f"joint {name!r} has {end} link {link!r}, which does not exist")
    if kind in ("revolute", "prismatic") and joint.find("limit") is None:
        raise UrdfError(
            f"joint {name!r} is {kind} but has no <limit>; add <limit lower= upper= velocity= effort=>"
            + (", or make it continuous" if kind == "revolute" else "")
        )
    if (mimic := joint.find("mimic")) is not None and not mimic.get("joint"):
        raise UrdfError(f"joint {name!r} has a <mimic> that names no joint")
    if float(_attribute(joint, "limit", "velocity", "0")) < 0:
        raise UrdfError(f"joint {name!r} has a negative speed limit")
    if kind in (*MOVING_TYPES, "planar"):
        length = math.hypot(*(float(word) for word in _attribute(joint, "axis", "xyz", "1 0 0").split()))
        if length < LEAST_AXIS:
            raise UrdfError(f"joint {name!r} has a zero axis")


def _attribute(joint: Any, tag: str, attribute: str, default: str) -> str:
    element = joint.find(tag)
    return default if element is None else str(element.get(attribute, default))


def _check_is_tree(links: list[str], joints: list[Any]) -> None:
    above: dict[str, str] = {}
    for joint in joints:
        child = joint.find("child").get("link")
        if child in above:
            raise UrdfError(f"link {child!r} is the child of two joints; a URDF is a tree")
        above[child] = joint.find("parent").get("link")
    roots = [link for link in links if link not in above]
    if len(roots) != 1:
        found = ", ".join(roots) if roots else "none: the joints form a loop"
        raise UrdfError(f"exactly one link must have no parent joint, found {found}")
    below: dict[str, list[str]] = {}
    for child, parent in above.items():
        below.setdefault(parent, []).append(child)
    depth = {roots[0]: 0}
    stack = [roots[0]]
    while stack:
        link = stack.pop()
        for child in below.get(link, ()):
            depth[child] = depth[link] + 1
            stack.append(child)
    lost = [link for link in links if link not in depth]
    if lost:
        raise UrdfError(f"the joints form a loop through {', '.join(lost[:5])}")
    if max(depth.values()) > MAX_DEPTH:
        raise UrdfError(f"it is {max(depth.values())} joints deep; more than {MAX_DEPTH} are refused")
