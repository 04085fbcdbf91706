"""Files of every kind that is read, damaged and spoilt: they are read or refused, quickly, and open no other file."""

import logging
import os
import random
import re
import sys
import tempfile
import warnings
from pathlib import Path

import trimesh

import robust_ik as rik
from robust_ik.certificates import certify
from robust_ik.control.limits.srdf import read_srdf
from robust_ik.description.dh.dh_toml import read_dh
from robust_ik.description.joint_tree import Mesh
from robust_ik.description.meshes.mesh_files import UnreadableMeshError, read_mesh
from robust_ik.errors import LONGEST_MESSAGE, RobustIKError
from robust_ik.simulation.scenarios.scenario_toml import read_scenario
from robust_ik.singularities.atlas import atlas_json
from tests.attack.guards import WATCH, TooSlowError, within

COUNTS = {"short": 300, "full": 100_000}
CHUNK = 2_000
SAMPLES = Path(__file__).parent / "samples"

URDF = """<?xml version="1.0"?>
<robot name="arm"><!-- a comment -->
 <material name="red"><color rgba="1 0 0 1"/></material>
 <link name="base"><visual><origin xyz="0 0 0" rpy="0 0 1.57"/><geometry><mesh filename="package://robot/a.stl"
   scale="1 1 1"/></geometry><material name="red"/></visual>
  <collision><geometry><box size="1 2 3"/></geometry></collision>
  <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
 <link name="upper"><visual><geometry><cylinder radius="0.1" length="1"/></geometry></visual></link>
 <link name="tool"/><link name="finger"/><link name="other"/>
 <joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 1" rpy="0 0 0"/>
  <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/><dynamics damping="1" friction="0"/></joint>
 <joint name="j2" type="continuous"><parent link="upper"/><child link="tool"/><axis xyz="0 1 0"/></joint>
 <joint name="j3" type="prismatic"><parent link="tool"/><child link="finger"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="0.1" velocity="1" effort="1"/></joint>
 <joint name="j4" type="prismatic"><parent link="finger"/><child link="other"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="0.1" velocity="1" effort="1"/><mimic joint="j3" multiplier="-1" offset="0"/></joint>
 <gazebo reference="base"><sensor:camera xmlns:sensor="u"/><mu1>0.2</mu1></gazebo>
 <transmission name="t"><joint name="j1"><hardwareInterface>x</hardwareInterface></joint></transmission>
</robot>
"""
DH = """name = "arm"
convention = "modified"
angles = "deg"
rest = [0, 45, 0]
[base]
xyz = [0, 0, 0.5]
rpy = [0, 0, 90]
[[joint]]
a = 0
d = 0.1
alpha = 0
lower = -170
upper = 170
velocity = 120
[[joint]]
a = 0.4
d = 0
alpha = 90
theta = 10
[[joint]]
a = 0.3
d = 0
alpha = 0
type = "prismatic"
lower = 0
upper = 0.5
"""
SCENARIO = """title = "Out of reach"
angles = "deg"
[robot]
name = "arm.toml"
rows = ["x", "y", "z"]
[start]
joints = [0, 30, 0.1]
[target]
kind = "line"
to = [0.5, 0, 0.4]
speed = 0.1
[control]
gain = 5.0
max_linear = 0.1
dt = 0.01
duration = 2.0
limits = true
[methods]
"J-PARSE" = { type = "JParse", gamma = 0.1 }
DLS = { type = "DampedLeastSquares", damping = 0.05 }
"""
RECORDING = (
    SCENARIO.split("[target]")[0]
    + """[target]
kind = "twists"
samples = [[0, 0.1, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0, 0]]
"""
)
SRDF = """<?xml version="1.0"?>
<robot name="arm"><group name="g"><chain base_link="base" tip_link="tool"/></group>
 <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
 <disable_collisions link1="base" link2="tool" reason="Never"/></robot>
"""
MTL = "newmtl paint\nKd 1 0 0\nmap_Kd a.png\n"
OBJ = "mtllib a.mtl\no box\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 1\nvn 0 0 1\nusemtl paint\n"
OBJ += "f 1/1/1 2/2/1 3/1/1\nf 1 2 4\nf 1 3 4 2\n"
TOKENS = [
    "0", "-1", "1e308", "-1e-308", "nan", "inf", "4294967295", "-2147483648", "1e400", "99999999999999999999", "0x10",
    "1/0", "", " ", "\n", "\0", "..", "../../../etc/passwd", "/etc/passwd", "file:///etc/passwd", "package://etc/a.stl",
    "../secret.bin", "secret", "<a/>", "</robot>", "<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]>", "&b;",
    "&#0;", "<![CDATA[", "<?xml version='1.0' encoding='UTF-7'?>", "xmlns='a'", "{", "}", "[", "]", "\"", "'", "=", ",",
    "null", "true", "\u202e", "\ud800", "é", "\U0001f916", "%s%n", "{0}", "$(find x)", "${a}", "-" * 300,
    "9" * 5000, "[" * 3000, "<a>" * 300, "type", "joint", "link", "base", "tool", "j1", "mimic", "fixed", "floating",
    "planar", "prismatic", "revolute", "data:;base64,AAAA", "%2e%2e/secret.bin",
]  # fmt: skip
WORDS = re.compile(rb"[\w.+-]+|\s+|[^\w\s]")


def attack(count, seed, say):
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as top:
        return list(Reading(Path(top).resolve() / "robot").broken(count, random.Random(seed), say))


class Reading:
    """Good files of every kind, and what reads them."""

    def __init__(self, folder):
        self.folder = folder
        folder.mkdir()
        (folder.parent / "secret.bin").write_bytes(bytes(range(36)))
        box = trimesh.creation.box((1.0, 2.0, 3.0))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # pycollada's, of new versions of NumPy
            for suffix in ("stl", "ply", "glb", "off", "dae", "gltf"):
                (trimesh.Scene(box) if suffix == "gltf" else box).export(str(folder / f"a.{suffix}"))
        (folder / "text.stl").write_text(trimesh.exchange.stl.export_stl_ascii(box))
        (folder / "text.ply").write_bytes(trimesh.exchange.ply.export_ply(box, encoding="ascii"))
        proof = certify(rik.load("duleba_3r"), 1)
        texts = {
            "arm.urdf": URDF, "arm.toml": DH, "run.toml": SCENARIO, "recording.toml": RECORDING, "arm.srdf": SRDF,
            "a.mtl": MTL, "a.obj": OBJ, "proof.json": proof.to_json(),
            "atlas.json": (SAMPLES / "atlas.json").read_text(encoding="utf-8"),
        }  # fmt: skip
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        self.good = {path.name: path.read_bytes() for path in folder.iterdir()}
        self.kinds = [name for name in self.good if name != "a.png"]
        places = (folder, Path(__file__).parents[2], sys.prefix, sys.base_prefix, "/proc/self")
        self.allowed = [Path(os.path.realpath(place)) for place in places]
        self._read("arm.urdf")
        for name in self.kinds:  # what is imported late is imported now
            self._read(name)

    def broken(self, count, rng, say):
        """A sentence for each file that did harm."""
        for i in range(count):
            name = self.kinds[i % len(self.kinds)]
            say(f"{name} {i}")
            data = _mutated(self.good[name], rng, [self.good[rng.choice(self.kinds)]])
            (self.folder / name).write_bytes(data)
            for what in self.tried(name):
                kept = Path(tempfile.gettempdir()) / f"broke_{os.getpid()}_{i}_{name}"
                kept.write_bytes(data)
                yield f"{what}: the file is kept as {kept}"
            (self.folder / name).write_bytes(self.good[name])

    def tried(self, name):
        """A sentence for each harm that reading the file of that name does."""
        WATCH.start()
        try:
            with within():
                self._read(name)
        except TooSlowError:
            yield f"{name} takes too long"
        except (RobustIKError, UnreadableMeshError) as error:
            if len(str(error)) > LONGEST_MESSAGE:
                yield f"{name}: a message of {len(str(error))} characters"
            if "MemoryError" in str(error):
                yield f"{name} takes too much memory: {error}"
        except Exception as error:
            yield f"{name} raises {error!r:.300}"
        finally:
            opened = WATCH.stop()
        for path in opened:
            if not any(Path(path).is_relative_to(place) for place in self.allowed):
                yield f"{name} opens {path}"

    def _read(self, name):
        """Reads a file as people do, up to where a robot moves."""
        path = self.folder / name
        suffix = path.suffix
        if name == "arm.toml":
            read_dh(path)
        elif suffix == ".toml":
            read_scenario(path)
        elif suffix == ".urdf":
            robot = rik.load(path)
            robot.pose(robot.rest)
            for visual in robot.description.visuals[:3]:
                if isinstance(visual.shape, Mesh) and visual.shape.path is not None:
                    read_mesh(visual.shape)
        elif suffix == ".srdf":
            read_srdf(path)
        elif name == "proof.json":
            atlas_json.certificate_in(path, path.read_bytes()).check()
        elif suffix == ".json":
            atlas_json.load(path)
        else:
            mesh = self.folder / ("a.obj" if suffix == ".mtl" else "a.gltf" if suffix == ".bin" else name)
            read_mesh(Mesh(mesh.name, mesh, (1.0, 1.0, 1.0), self.folder))


def _mutated(data, rng, others):
    """The data with one to some changes, of bytes or of words."""
    kind = rng.random()
    for _ in range(1 + int(rng.expovariate(0.5))):
        data = _bytes_changed(data, rng, others) if kind < 0.35 else _words_changed(data, rng)
    if rng.random() < 0.02:  # long
        start = rng.randrange(len(data) + 1)
        piece = data[start : start + rng.choice((1, 10, 100, 1000))]
        data = data[:start] + piece * (rng.choice((10**4, 10**6)) // (len(piece) + 1)) + data[start:]
    return data


def _bytes_changed(data, rng, others):
    a, b = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    b = min(b, a + rng.choice((1, 4, 30, 10**9)))
    return rng.choice(
        (
            lambda: data[:a] + bytes([rng.randrange(256)]) + data[a + 1 :],
            lambda: data[:a] + rng.randbytes(rng.choice((1, 4, 8))) + data[a:],
            lambda: data[:a] + data[b:],
            lambda: data[:b] + data[a:],
            lambda: data[:a],
            lambda: data[:a] + rng.choice((b"\xff" * 4, bytes(4), b"\xff\xff\xff\x7f", b"\x80")) + data[a + 4 :],
            lambda: data[:a] + others[0][a : a + 200] + data[b:],
            lambda: rng.choice((b"\xff\xfe", b"\xef\xbb\xbf", b"PK\x03\x04", b"\n \n")) + data,
        )
    )()


def _words_changed(data, rng):
    words = WORDS.findall(data) or [b""]
    i, j = rng.randrange(len(words)), rng.randrange(len(words))
    token = rng.choice(TOKENS).encode("utf-8", "surrogatepass")
    kind = rng.randrange(6)
    if kind < 2:
        words[i] = token
    elif kind == 2:
        words.insert(i, token)
    elif kind == 3:
        words[i], words[j] = words[j], words[i]
    elif kind == 4:
        del words[i : i + rng.choice((1, 1, 3, 20))]
    else:
        words[i:i] = words[j : j + rng.choice((1, 5, 40))] * rng.choice((1, 1, 2, 50))
    return b"".join(words)
