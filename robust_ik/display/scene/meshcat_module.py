"""Imports MeshCat in one place, together with what keeps it quiet."""

from __future__ import annotations

import warnings
from pathlib import Path

with warnings.catch_warnings():
    # pyzmq warns that a module imported by meshcat will be removed; nothing here uses it.
    warnings.simplefilter("ignore", DeprecationWarning)
    import meshcat
    from meshcat import commands, geometry
    from meshcat.servers.tree import SceneTree, find_node, walk
    from meshcat.visualizer import Visualizer

import umsgpack  # type: ignore[import-untyped, unused-ignore]

VIEWER_FOLDER = Path(meshcat.__file__).parent / "viewer" / "dist"
"""The folder of meshcat's viewer for browsers."""

EXTENSION = {"uint8": 0x12, "uint16": 0x14, "uint32": 0x16, "float32": 0x17}
"""Codes by which the viewer's msgpack decoder recognises typed arrays."""

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
