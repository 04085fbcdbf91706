"""Files of up to 50 MB that hold very many of something: all are read or refused in seconds, in bounded memory."""

import json
import logging
import random
import struct
import tempfile
from pathlib import Path

from tests.attack.mutated_files import Reading

COUNTS = {"short": 24, "full": 400}
CHUNK = 40
LARGEST = 49_000_000

JOINT = '<joint name="j{0}" type="{1}"><parent link="{2}"/><child link="l{0}"/><axis xyz="0 0 1"/>{3}</joint>'
LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
COLLADA = '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
TABLE = '[robot]\nname = "arm.toml"\n[target]\nkind = "hold"\nseconds = 1.0\n[methods]\n'
MESH = "<visual><geometry><mesh filename='package://p§/§.stl'/></geometry></visual>"
FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
PLY = "ply\nformat ascii 1.0\nelement vertex {}\n" + "".join(f"property float {x}\n" for x in "xyz") + "end_header\n"
PRIMITIVE, SMALL = {"attributes": {"POSITION": 0}}, {"count": 3, "componentType": 5126, "type": "VEC3"}
ACCESSOR = {"count": 10**9, "componentType": 5126, "type": "MAT4"}


def robot(inside):
    return f'<robot name="r"><link name="base"/>{inside}</robot>'


def many(piece, size):
    """A piece again and again, each with its number."""
    return "".join(piece.replace("§", str(i)) for i in range(size // len(piece)))


def tree(kind, parent, size, more=LIMIT):
    piece = '<link name="l{0}"/>' + JOINT
    return robot("".join(piece.format(i, kind, parent(i), more) for i in range(size // 200)))


def attributes(size):
    return robot("<a " + many("a§='' ", size // 2) + "/>")


def gltf(**lists):
    return json.dumps({"asset": {"version": "2.0"}, **lists})


def geometry(inside):
    inside = f"<library_geometries><geometry id='g'><mesh>{inside}</mesh></geometry></library_geometries>"
    return f"{COLLADA}{inside}</COLLADA>"


MADE = [
    ("arm.urdf", lambda size: robot("<a/>" * (size // 4))),
    ("arm.urdf", lambda size: robot("<link name='b'>" + "<a/>" * (size // 4) + "</link>")),
    ("arm.urdf", attributes),
    ("arm.urdf", lambda size: tree("revolute", lambda i: "base", size)),
    ("arm.urdf", lambda size: tree("fixed", lambda i: "base", size)),
    ("arm.urdf", lambda size: tree("fixed", lambda i: f"l{i - 1}" if i else "base", min(size, 190_000))),
    ("arm.urdf", lambda size: tree("revolute", lambda i: "base", size, LIMIT + '<mimic joint="j0"/>')),
    ("arm.urdf", lambda size: robot(many('<material name="§"><color rgba="1 1 1"/></material>', size))),
    ("arm.urdf", lambda size: robot(f'<link name="{"n" * size}"/>')),
    ("arm.urdf", lambda size: robot("&#65;" * (size // 5))),
    ("arm.urdf", lambda size: robot("<!-- - -- -->" * (size // 13))),
    ("arm.urdf", lambda size: robot("<link name='b'>" + many(MESH, size) + "</link>")),
    ("arm.urdf", lambda size: robot(many("<p§:a/>", size))),
    ("arm.urdf", lambda size: "<a>" * (size // 3)),
    ("arm.srdf", lambda size: robot(many('<disable_collisions link1="a§" link2="b" reason="x"/>', size))),
    ("arm.toml", lambda size: "a" + ".a" * min(size // 2, 99_000)),
    ("arm.toml", lambda size: many("[a§]\n", min(size, 190_000))),
    ("run.toml", lambda size: "a" + ".a" * min(size // 2, 490_000)),
    ("run.toml", lambda size: many("[[a§.a.a]]\n", min(size, 990_000))),
    ("run.toml", lambda size: TABLE + many('a§ = {type="JParse"}\n', min(size, 900_000))),
    ("run.toml", lambda size: TABLE + f"a = [{'1.5,' * min(size // 4, 240_000)}]"),
    ("atlas.json", lambda size: "[" + "[]," * (size // 3) + "1]"),
    ("atlas.json", lambda size: "[" + "1234567," * (size // 8) + "1]"),
    ("proof.json", lambda size: "[" * size),
    ("proof.json", lambda size: json.dumps({"format": "9" * size})),
    ("a.stl", lambda size: "solid x\n" + FACET * (size // len(FACET))),
    ("a.stl", lambda size: "solid x\nendsolid x\n" * (size // 19)),
    ("a.stl", lambda size: bytes(80) + struct.pack("<I", size // 50) + random.Random(0).randbytes(size // 50 * 50)),
    ("a.stl", lambda size: bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(size)),
    ("a.obj", lambda size: "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "usemtl a\nf 1 2 3\n" * (size // 17)),
    ("a.obj", lambda size: "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\nf 1 2 3 1\n" * (size // 18)),
    ("a.obj", lambda size: "v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + "1 2 3 " * (size // 6)),
    ("a.obj", lambda size: "v 0 0 0\n" * (size // 8) + "f 1 2 3\n"),
    ("a.mtl", lambda size: many("newmtl a§\nKd 1 0 0\n", size)),
    ("a.off", lambda size: f"OFF\n3 {size // 8} 0\n0 0 0\n1 0 0\n0 1 0\n" + "3 0 1 2\n" * (size // 8)),
    ("a.ply", lambda size: PLY.format(size // 6) + "0 0 1\n" * (size // 6)),
    ("a.gltf", lambda size: gltf(accessors=[ACCESSOR] * (size // 60))),
    ("a.gltf", lambda size: gltf(accessors=[], nodes=[{"children": [i + 1]} for i in range(size // 20)])),
    ("a.gltf", lambda size: gltf(accessors=[SMALL], meshes=[{"primitives": [PRIMITIVE] * (size // 40)}])),
    ("a.dae", lambda size: COLLADA + "<a/>" * (size // 4) + "</COLLADA>"),
    ("a.dae", lambda size: geometry("<triangles><p>" + "0 1 2 " * (size // 6) + "</p></triangles>")),
    ("a.dae", lambda size: geometry("<source><float_array>" + "0 " * (size // 2) + "</float_array></source>")),
]  # fmt: skip
"""Which file it stands for, and its text or bytes of about a size."""


def attack(count, seed, say):
    logging.disable(logging.CRITICAL)
    rng, failures = random.Random(seed), []
    with tempfile.TemporaryDirectory() as top:
        reading = Reading(Path(top).resolve() / "robot")
        for i in range(count):
            number = (seed * CHUNK + i) % len(MADE)
            name, make = MADE[number]
            size = int(10 ** rng.uniform(4, 7.69))
            say(f"{name}, way {number}, of {size} bytes")
            content = make(min(size, LARGEST))
            content = content if isinstance(content, bytes) else content.encode()
            (reading.folder / name).write_bytes(content)
            del content
            failures += [f"{what} (way {number}, {size} bytes)" for what in reading.tried(name)]
            (reading.folder / name).write_bytes(reading.good[name])
    return failures
