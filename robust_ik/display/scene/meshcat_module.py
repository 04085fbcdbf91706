"""MeshCat, imported in one place, so that what it needs to be quiet stands in one place."""

from __future__ import annotations

import warnings
from pathlib import Path

with warnings.catch_warnings():
    # pyzmq announces the end of a module that meshcat imports; nothing here uses it.
    warnings.simplefilter("ignore", DeprecationWarning)
    import meshcat
    from meshcat import commands, geometry
    from meshcat.servers.tree import SceneTree, find_node, walk
    from meshcat.visualizer import Visualizer

import umsgpack  # type: ignore[import-untyped, unused-ignore]

VIEWER_FOLDER = Path(meshcat.__file__).parent / "viewer" / "dist"
"""Where meshcat keeps the viewer that runs in the browser."""

EXTENSION = {"uint8": 0x12, "uint16": 0x14, "uint32": 0x16, "float32": 0x17}
"""Extension codes by which the viewer's msgpack decoder tells typed arrays."""

__all__ = [
    "EXTENSION",
    "VIEWER_FOLDER",
    "SceneTree",
    "Visualizer",
    "commands",
    "find_node",
    "geometry",
    "umsgpack",
    "walk",
]
