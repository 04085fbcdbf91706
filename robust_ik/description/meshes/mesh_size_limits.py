"""Limits on the contents of a mesh file, checked before a reader trusts the sizes in its header."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from lxml import etree

from robust_ik.description.xml_size_limits import COLLADA, keeps_brackets
from robust_ik.errors import UrdfError

MAX_BYTES = 60_000_000
"""Most bytes of a mesh file; the largest real meshes of robots have 30 MB."""
MAX_TRIANGLES = 600_000
"""Most triangles, to be thinned in some seconds; real meshes have up to 200,000."""
MAX_TEXT_LINES = 2_000_000
"""Most vertices, normals and faces of a text file, which is read more slowly; real ones have up to 60,000."""
MAX_FACE_LINES = 400_000
"""Most faces of a text file, which are read slowly. Chosen: the largest of example-robot-data has 22,246."""
MAX_PARTS = 2_000
"""Most groups of an OBJ, or solids of an STL: each costs as much as a small file. Real files have up to 60."""
MAX_LINE = 20_000
"""Most characters of a line, which may hold a face with many corners.

Chosen: the longest of example-robot-data has 262.
"""
MAX_OBJECTS = 20_000
"""Most braces in the header of a glTF: nodes, primitives, accessors, materials. Real files have up to 200."""
MAX_NUMBERS = 30_000_000
"""Most numbers in all accessors of a glTF; real files have up to 5,000,000."""
MAX_WORDS = 12_000_000
"""Most numbers in a COLLADA file, written as text; real files have up to 6,000,000."""
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_LONG_LINE = re.compile(rb"[^\n]{%d}" % (MAX_LINE + 1))


class UnreadableMeshError(Exception):
    """A mesh that cannot be used; the message says why. Each caller that reads a mesh handles it."""


def check_mesh(data: bytes, kind: str) -> None:
    """Raises if a mesh file of this kind (".stl", ".dae", …) would take too much time or memory to read.

    Raises:
        UnreadableMeshError: It would, or it refers to parts that do not exist.
    """
    checks = {".dae": _check_collada, ".gltf": _check_gltf, ".glb": _check_glb, ".obj": _check_obj, ".stl": _check_stl}
    checks.get(kind, _check_lines)(data)


def check_triangles(count: int) -> None:
    """Raises if there are more triangles than can be drawn.

    Raises:
        UnreadableMeshError: There are.
    """
    _at_most(count, MAX_TRIANGLES, "triangles")


def _at_most(count: int, most: int, what: str) -> None:
    if count > most:
        raise UnreadableMeshError(f"has {count} {what}; more than {most} are refused")


# ------------------------------------------------------------------------------------------------- text
def _check_lines(data: bytes) -> None:
    """Checks PLY and OFF files: a header, then lines or bytes."""
    header = data[:100_000].partition(b"end_header")[0] if data[:3] == b"ply" else b""
    _at_most(header.count(b"element"), 50, "elements in its header")
    _at_most(header.count(b"property"), 500, "properties in its header")
    if data[:3] != b"ply" or b"format ascii" in header:
        _at_most(data.count(b"\n"), MAX_FACE_LINES, "lines")
        _check_long_lines(data)


def _check_obj(data: bytes) -> None:
    _at_most(data.count(b"\nf"), MAX_FACE_LINES, "faces")
    _at_most(data.count(b"\nv"), MAX_TEXT_LINES, "vertices and normals")
    _at_most(sum(data.count(word) for word in (b"usemtl", b"\no", b"\ng")), MAX_PARTS, "groups")
    _at_most(data.count(b"\\\n") + data.count(b"\\\r"), 10_000, "lines that go on")
    _check_long_lines(data.replace(b"\\\n", b"").replace(b"\\\r\n", b""))


def _check_stl(data: bytes) -> None:
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return _at_most(int.from_bytes(data[80:84], "little"), MAX_TRIANGLES, "triangles")
    _at_most(data.count(b"facet") // 2, MAX_FACE_LINES, "facets")
    _at_most(data.count(b"solid") // 2, MAX_PARTS, "solids")
    return None


def _check_long_lines(data: bytes) -> None:
    if _LONG_LINE.search(data):
        raise UnreadableMeshError(f"has a line of over {MAX_LINE} characters")


# ------------------------------------------------------------------------------------------------- glTF
def _check_glb(data: bytes) -> None:
    length = int.from_bytes(data[12:16], "little")
    _check_gltf(data[20 : 20 + length])


def _check_gltf(text: bytes) -> None:
    """Checks the sizes that a glTF's header claims, before memory is allocated for them."""
    for sign, times in ((b"{", 1), (b"[", 2), (b",", 25)):
        _at_most(text.count(sign), MAX_OBJECTS * times, f"signs {sign.decode()!r}")
    try:
        header = json.loads(text)
        counts = [int(each["count"]) for each in header.get("accessors", ())]
        numbers = [n * _COMPONENTS[each["type"]] for n, each in zip(counts, header.get("accessors", ()))]
        drawn = list(_drawn(header, counts))
        views = [int(each["byteLength"]) for each in header.get("bufferViews", ())]
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError) as error:
        raise UnreadableMeshError(f"cannot be read: {type(error).__name__}: {str(error)[:120]}") from error
    if min(counts, default=0) < 0 or min(views, default=0) < 0:
        raise UnreadableMeshError("claims a negative size")
    _at_most(sum(numbers), MAX_NUMBERS, "numbers")
    _at_most(sum(views), 4 * MAX_BYTES, "bytes in its views")
    check_triangles(sum(corners for corners, _ in drawn) // 3)
    _at_most(sum(values for _, values in drawn), 32 * MAX_TRIANGLES, "values at vertices")


def _drawn(header: dict[str, Any], counts: list[int]) -> Iterator[tuple[int, int]]:
    """Corners of each primitive, and values at its vertices; an accessor that is shared is counted each time."""
    for mesh in header.get("meshes", ()):
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            corners = primitive.get("indices", attributes.get("POSITION"))
            yield 0 if corners is None else counts[corners], sum(counts[each] for each in attributes.values())


# ------------------------------------------------------------------------------------------------- COLLADA
def _check_collada(data: bytes) -> None:
    """Checks the number of elements, and of triangles as often as nodes place them: nodes may contain nodes."""
    if not keeps_brackets(data) or b"<!ENTITY" in data or b"<!DOCTYPE" in data:
        raise UnreadableMeshError("is no COLLADA file, or has a DOCTYPE, which none needs")
    _at_most(_words(data), MAX_WORDS, "numbers")
    try:
        COLLADA.check(data)
        root = etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True))
    except (UrdfError, etree.XMLSyntaxError) as error:
        raise UnreadableMeshError(f"cannot be read: {str(error)[:200]}") from error
    sizes = {each.get("id"): _triangles(each) for each in root.iter("{*}geometry")}
    check_triangles(_Unfolded(root, sizes).triangles())


def _triangles(geometry: Any) -> int:
    """An upper bound on the triangles of a geometry: three corners need three numbers for each offset."""
    return sum(_words((each.text or "").encode("latin-1", "replace")) // 3 + 1 for each in geometry.iter("{*}p"))


def _words(text: bytes) -> int:
    """The number of words separated by blanks, or a few more."""
    blank = np.frombuffer(text, np.uint8) <= 32
    return int(np.count_nonzero(blank[:-1] & ~blank[1:])) + 1


class _Unfolded:
    """Counts the triangles of a COLLADA scene with every reference inserted."""

    def __init__(self, root: Any, sizes: dict[str, int]) -> None:
        self.root, self.sizes = root, sizes
        self.nodes = {each.get("id"): each for each in root.iter("{*}node") if each.get("id")}
        self.known: dict[Any, int] = {}

    def triangles(self) -> int:
        """Triangles of all scenes."""
        return sum(self._under(scene, 0) for scene in self.root.iter("{*}visual_scene"))

    def _under(self, element: Any, depth: int) -> int:
        if depth > 100:
            raise UnreadableMeshError("has nodes that hold each other, or over 100 of them in each other")
        if element not in self.known:
            self.known[element] = 1 + sum(self._of(child, depth + 1) for child in element)
        return self.known[element]

    def _of(self, child: Any, depth: int) -> int:
        tag = etree.QName(child).localname if isinstance(child.tag, str) else ""
        if tag == "node":
            return self._under(child, depth)
        target = (child.get("url") or "").lstrip("#")
        if tag == "instance_node" and target in self.nodes:
            return self._under(self.nodes[target], depth)
        return self.sizes.get(target, 0) if tag in ("instance_geometry", "instance_controller") else 0
