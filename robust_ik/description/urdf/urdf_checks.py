"""Checks the XML of a URDF before any other parser reads it."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any

from lxml import etree

from robust_ik.description.notes import Notes, named
from robust_ik.description.urdf.urdf_numbers import LARGEST, are_numbers, shown
from robust_ik.description.urdf.xml_repairs import note_version, repaired
from robust_ik.description.xml_size_limits import SRDF, URDF, XmlBounds, keeps_brackets
from robust_ik.errors import UrdfError

MAX_DEPTH = 1000
"""Most joints from the root to a leaf; the parsers that follow recurse."""
_NAMES = ("link", "joint", "name")
_DECLARATION = re.compile(r"\ufeff?<\?xml[^>]*\?>")
_OTHERS = {
    "mujoco": "it is MuJoCo's MJCF, not a URDF: take the robot's URDF, or convert it (mjcf-urdf-simple-converter)",
    "sdf": "it is SDF, not a URDF: take the URDF or xacro it was made from, or convert it (sdf2urdf of pysdf)",
    "gazebo": "it is an old form of SDF, not a URDF: take the URDF or xacro that it was made from",
    "COLLADA": "it is a COLLADA file, a mesh and no URDF: take the URDF that names it",
    "srdf": "it is an SRDF, which says what may collide: take the URDF beside it",
}


def safe_tree(xml: str | bytes, kind: str = "a URDF", notes: Notes | None = None) -> Any:
    """The XML tree of a URDF or a similar file; no entity is expanded, no DTD loaded, nothing fetched.

    Args:
        xml: The text.
        kind: What it is, for messages.
        notes: Repairs are added to these.
    """
    bounds = SRDF if kind == "an SRDF" else URDF
    bounds.check(xml)
    notes = Notes() if notes is None else notes
    root = _parsed(xml, notes, bounds)
    if root.getroottree().docinfo.internalDTD is not None:
        raise UrdfError(_doctype(kind))
    if _drop_default_namespaces(root):
        notes.add(f"a default XML namespace (xmlns=…) is passed over; {kind} has none")
    if root.tag != "robot":
        name = etree.QName(root).localname
        raise UrdfError(
            (_OTHERS.get(name) if kind == "a URDF" else None) or f"the root element is <{name[:60]}>, not <robot>"
        )
    return root


def _parsed(xml: str | bytes, notes: Notes, bounds: XmlBounds) -> Any:
    """The tree of strict XML; if it is not strict, the tree of the repaired text."""
    text = xml if isinstance(xml, bytes) else _bytes(xml, notes)
    why = "it declares an encoding that is no relative of ASCII"
    if isinstance(xml, str) or keeps_brackets(xml):
        try:
            return _strict(text)
        except etree.XMLSyntaxError as error:
            why = error.msg[:300]
    mended = repaired(xml, notes)
    if mended is not None:
        bounds.check(mended)
        try:
            return _strict(mended.encode())
        except etree.XMLSyntaxError as error:  # the error that is left after the repair
            why = error.msg[:300]
        except UnicodeEncodeError as error:
            why = error.reason
    if (b"<!DOCTYPE" if isinstance(xml, bytes) else "<!DOCTYPE") in xml:  # type: ignore[operator]
        raise UrdfError(_doctype("a robot's file"))
    raise UrdfError(f"not well-formed XML: {why}")


def _strict(text: bytes) -> Any:
    parser = etree.XMLParser(
        resolve_entities=False,
        load_dtd=False,
        no_network=True,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    return etree.fromstring(text, parser)


def _doctype(kind: str) -> str:
    return f"it has a DOCTYPE, which could define entities; {kind} needs none: remove it"


def _bytes(xml: str, notes: Notes) -> bytes:
    """Text as UTF-8 bytes, without the declaration of its encoding, which would no longer be true."""
    declared = _DECLARATION.match(xml)
    if declared is not None:
        note_version(declared[0], notes)
        xml = xml[declared.end() :]
    try:
        return xml.encode()
    except UnicodeEncodeError as error:
        raise UrdfError(f"not text: {error.reason} at character {error.start}") from error


def _drop_default_namespaces(root: Any) -> bool:
    """Takes the names of elements as they are written, like readers that know no namespaces."""
    dropped = False
    for element in root.iter("{*}*"):
        if element.prefix is None and element.tag.startswith("{"):
            element.tag = etree.QName(element).localname
            dropped = True
    if dropped:
        etree.cleanup_namespaces(root)
    return dropped


def check_tree(root: Any) -> None:
    """Raises unless names, references and origins make the links and joints a tree."""
    _tidy_blanks(root)
    if not root.get("name"):
        root.set("name", "robot")
    links = [_named(link) for link in root.findall("link")]
    joints = root.findall("joint")
    if not links:
        raise UrdfError("it has no <link>")
    for kind, names in (("link", links), ("joint", [_named(joint) for joint in joints])):
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise UrdfError(f"two {kind}s are called {shown(twice[0])}")
    _check_spelling(root)
    known = set(links)
    for joint in joints:
        _check_joint(joint, known)
    _check_is_tree(links, joints)


def _tidy_blanks(root: Any) -> None:
    """Separates numbers by one blank, since Pinocchio's reader accepts nothing else."""
    for path in ("joint/*", "link/inertial/*"):
        for element in root.iterfind(path):
            for attribute, text in element.attrib.items():
                if attribute not in _NAMES and text != (tidy := " ".join(text.split())):
                    element.set(attribute, tidy)


def _named(element: Any) -> str:
    if not element.get("name"):
        raise UrdfError(f"a <{element.tag}> in line {element.sourceline} has no name")
    return str(element.get("name"))


def _check_spelling(root: Any) -> None:
    for element in root.iterchildren("*"):
        if element.tag.lower() in ("link", "joint") and element.tag not in ("link", "joint"):
            raise UrdfError(f"line {element.sourceline}: <{element.tag}> must be written <{element.tag.lower()}>")


def _check_joint(joint: Any, links: set[str]) -> None:
    name = joint.get("name")
    for end in ("parent", "child"):
        element = joint.find(end)
        link = None if element is None else element.get("link")
        if link not in links:
            raise UrdfError(
                f"{named('joint', name)} has {end} link {None if link is None else shown(link)}, which does not exist"
            )
    origin = joint.find("origin")
    for attribute in ("xyz", "rpy") if origin is not None else ():
        text = origin.get(attribute)
        if not are_numbers(text, 3):
            raise UrdfError(
                f"line {origin.sourceline}: <origin {attribute}={shown(text)}> must hold 3 finite numbers of at most "
                f"{LARGEST:g} (in {named('joint', name)})"
            )


def _check_is_tree(links: list[str], joints: list[Any]) -> None:
    above: dict[str, str] = {}
    for joint in joints:
        child = joint.find("child").get("link")
        if child in above:
            raise UrdfError(f"link {shown(child)} is the child of two joints; a URDF is a tree")
        above[child] = joint.find("parent").get("link")
    roots = [link for link in links if link not in above]
    if len(roots) != 1:
        found = ", ".join(link[:60] for link in roots[:10]) + (", …" if len(roots) > 10 else "")
        raise UrdfError(
            f"exactly one link must have no parent joint, found {found if roots else 'none: the joints form a loop'}"
        )
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
        raise UrdfError(f"the joints form a loop through {', '.join(link[:60] for link in lost[:5])}")
    if max(depth.values()) > MAX_DEPTH:
        raise UrdfError(f"it is {max(depth.values())} joints deep; more than {MAX_DEPTH} are refused")
