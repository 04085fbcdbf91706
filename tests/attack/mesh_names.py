"""Mesh names that try to get out: whatever is found lies, with all links resolved, where it may lie."""

import os
import random
import tempfile
from pathlib import Path

from robust_ik.description.meshes.confined_reading import read_inside
from robust_ik.description.meshes.mesh_file_references import ConfinedResolver
from robust_ik.description.meshes.mesh_paths import MeshPaths
from robust_ik.errors import RobustIKError
from tests.attack.guards import WATCH, TooSlowError, within

COUNTS = {"short": 3_000, "full": 1_000_000}
CHUNK = 20_000
WATCHED = 10
"""Of so many names one is also looked up with every file that is opened watched."""

TREE = [
    "secret.stl", "secret.bin", "out/secret.gltf", "ann/secret.stl", "ann/.ssh/id.stl", "ann/given/a.stl",
    "ann/robot/package.xml", "ann/robot/urdf/arm.urdf", "ann/robot/meshes/a.stl", "ann/robot/meshes/ä b.dae",
    "ann/robot/meshes/a%20b.stl", "ann/robot/a.bin", "ann/robot/.hidden/a.bin", "ann/next/package.xml",
    "ann/next/a.stl", "ann/bare/urdf/arm.urdf", "ann/bare/a.stl", "ann/odd/deep/arm.urdf", "ann/odd/a.stl",
]  # fmt: skip
LINKS = {
    "ann/robot/root": "/", "ann/robot/up": "..", "ann/robot/out": "../../out", "ann/robot/in": "meshes",
    "ann/robot/l.stl": "../secret.stl", "ann/robot/l.bin": "../../secret.bin", "ann/robot/loop": "loop",
    "ann/robot/urdf/p": "/", "ann/odd/deep/p": "../../..", "ann/p": "../out", "ann/given/p": "/", "ann/given/q": "..",
    "ann/bare/urdf/p": "../../robot",
}  # fmt: skip
FOLDERS = ("ann/robot/urdf", "ann/robot", "ann/bare/urdf", "ann/odd/deep", "ann/robot/in")
SCHEMES = (
    "package://", "package:///", "model://", "file://", "file:///", "", "", "PACKAGE://", "http://", "data:", "//",
    "package:/", "package:", "file:", "package://package://", "\\\\", "C:\\", "zip://",
)  # fmt: skip
ENDINGS = (".stl", ".STL", ".dae", ".obj", ".gltf", ".bin", "", ".stl.", ".stl\0", ".stl/", ".stl#a", ".stl?b", ".txt")
SEPARATORS = ("/", "/", "/", "//", "\\", "%2f", "/./", "/../", "∕", "\0", "%5c", "/ /")
ODD = (
    "..", "..", ".", "", " ", "...", "%2e%2e", "%252e", "~", "$HOME", "*", "\0", "\n", "\u202e", "\ud800", "ａ",
    "a" * 300, "%", "%zz", "..;", "..\\..", "con", "-", "{}", "{0.__class__}", "İ", "e\u0301", "\u200b..",
)  # fmt: skip
STARTS = ((), ("..",), ("..", ".."), ("p",), ("ann",))


def attack(count, seed, say):
    with tempfile.TemporaryDirectory() as folder:
        return list(_Place(Path(folder).resolve()).broken(count, random.Random(seed), say))


class _Place:
    """A folder with robots, a secret outside of each, and links that lead there."""

    def __init__(self, top):
        self.top = top
        for name in TREE:
            (top / name).parent.mkdir(parents=True, exist_ok=True)
            (top / name).write_text("x")
        for name, target in LINKS.items():
            (top / name).symlink_to(target)
        os.environ["HOME"] = str(top / "ann")
        words = {part for name in (*TREE, *LINKS) for part in Path(name).parts}
        self.words = sorted(words | {Path(name).stem for name in TREE} | {*top.parts[1:], "etc", "home", "proc", "dev"})
        own = {"ann/robot/urdf": "ann/robot", "ann/bare/urdf": "ann/bare", "ann/robot/in": "ann/robot"}
        shared = [top / "ann/next", top / "ann/robot"]
        self.paths = [
            (MeshPaths.of(top / name, given), [top / own.get(name, name), *map(Path, given), *shared])
            for name in FOLDERS
            for given in ((), (str(top / "ann/given"),))
        ]

    def broken(self, count, rng, say):
        """A sentence for each name that got out or raised what it should not."""
        for i in range(count):
            if i % 1000 == 0:
                say(f"name {i}")
            name, (paths, allowed) = self._name(rng), rng.choice(self.paths)
            try:
                with within():
                    yield from self._tried(name, paths, allowed, rng.randrange(WATCHED) == 0)
            except TooSlowError:
                yield f"{name!r} from {paths.folder} takes too long"
            except RobustIKError as error:
                if len(str(error)) > 2000:
                    yield f"the message for {name!r} has {len(str(error))} characters"
            except Exception as error:
                yield f"{name!r} from {paths.folder} raises {error!r}"

    def _tried(self, name, paths, allowed, watched):
        found = paths.resolve(name)
        real = found.path and Path(os.path.realpath(found.path))
        if real and (real != found.path or not any(real.is_relative_to(each) for each in allowed)):
            yield f"{name!r} from {paths.folder} leads to {real}"
        if found.path is None and not found.problem:
            yield f"{name!r} from {paths.folder} is not found, and it is not said why"
        if real and read_inside(found.path, found.root, 100) != b"x":
            yield f"{name!r} is not read as it is"
        if watched:
            yield from self._referred_to(name, allowed[0])

    def _referred_to(self, name, root):
        """As a reference of a mesh: only what is inside is opened."""
        WATCH.start()
        try:
            ConfinedResolver(root, root).get(name)
        except FileNotFoundError:
            pass
        finally:
            opened = WATCH.stop()
        for path in opened:
            if not Path(path).is_relative_to(root):
                yield f"the reference {name!r} opens {path}"

    def _name(self, rng):
        parts = [rng.choice(self.words if rng.random() < 0.7 else ODD) for _ in range(rng.randrange(1, 9))]
        kind = rng.random()
        if kind < 0.3:  # near to what leads somewhere
            start = rng.choice([*TREE, *LINKS])
            parts = [
                *rng.choice(([], [".."], ["..", ".."], list(self.top.parts[1:]), ["p"], ["ann"])),
                *Path(start).parts,
            ]
            parts.insert(rng.randrange(len(parts) + 1), rng.choice((".", "up", "in", "p", "..", "")))
        separator = "/" if rng.random() < 0.8 else rng.choice(SEPARATORS)
        text = rng.choice(SCHEMES[:6] if rng.random() < 0.7 else SCHEMES) + separator.join(parts)
        if kind > 0.6:
            text += rng.choice(ENDINGS)
        if rng.random() < 0.05:
            place = rng.randrange(len(text) + 1)
            text = text[:place] + chr(rng.randrange(0x110000)) + text[place:]
        return text * 500 if rng.random() < 0.002 else text
