"""Mesh files, read safely: as coloured triangles for drawing, as vertices for measuring."""

from robust_ik.description.meshes.mesh_files import Color, Part, UnreadableMeshError, read_mesh, read_vertices
from robust_ik.description.meshes.mesh_paths import CONVENTIONAL_FOLDERS
from robust_ik.description.meshes.triangle_meshes import Triangles

__all__ = [
    "CONVENTIONAL_FOLDERS",
    "Color",
    "Part",
    "Triangles",
    "UnreadableMeshError",
    "read_mesh",
    "read_vertices",
]
