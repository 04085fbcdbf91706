"""Reads mesh files of any kind as coloured triangles or as vertices; one error says what is wrong with a file."""

from __future__ import annotations

import io
import logging
import re
import warnings
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.description.joint_tree import Mesh
from robust_ik.description.meshes.confined_reading import read_inside
from robust_ik.description.meshes.mesh_paths import MESH_SUFFIXES
from robust_ik.description.meshes.mesh_size_limits import MAX_BYTES, check_mesh, check_triangles
from robust_ik.description.meshes.mesh_size_limits import UnreadableMeshError as UnreadableMeshError
from robust_ik.description.meshes.triangle_meshes import Triangles, tidy

MAX_PIXELS = 20_000_000
"""Most pixels of an image; textures have up to 4096² = 16,777,216."""
IMAGES = ("PNG", "JPEG", "GIF", "BMP", "TGA", "TIFF", "WEBP")
"""Image formats whose readers start no other program."""
LARGEST = 1e6
"""Vertices beyond this distance, m, count as a damaged file."""
Color = tuple[float, float, float, float]
_Piece = TypeVar("_Piece")


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one colour, or with a colour at every vertex.

    Attributes:
        triangles: The triangles.
        color: RGBA in [0, 1], or None if the file says none.
    """

    triangles: Triangles
    color: Color | None


def read_mesh(mesh: Mesh) -> tuple[Part, ...]:
    """The parts of a mesh file in metres, scaled as the description says.

    COLLADA's unit is applied and its up-axis is not, as in ROS and its files.

    Raises:
        UnreadableMeshError: There is no such file, or it is broken, too large or empty.
    """
    parts = _read(mesh, _parts)
    if not parts:
        raise UnreadableMeshError("holds no triangles that can be drawn")
    return parts


def read_vertices(mesh: Mesh) -> Array:
    """All vertices of a mesh file's triangles, (V, 3), m, scaled as for `read_mesh`; none merged or left out.

    Raises:
        UnreadableMeshError: As for `read_mesh`.
    """
    pieces = _read(mesh, _vertices)
    vertices = np.concatenate(pieces) if pieces else np.zeros((0, 3))
    vertices = vertices[(np.abs(vertices) <= LARGEST).all(axis=1)]
    if not len(vertices):
        raise UnreadableMeshError("holds no triangles")
    return vertices


def _read(mesh: Mesh, extract: Callable[[Any, Array], Iterable[_Piece]]) -> tuple[_Piece, ...]:
    """The results of `extract` for the scene in a file."""
    if mesh.path is None:
        raise UnreadableMeshError(mesh.problem or "not found")
    try:
        with _quiet():
            data = _bytes(mesh)
            return tuple(extract(_load(mesh, data), _scaling(mesh, data)))
    except UnreadableMeshError:
        raise
    except Exception as error:  # readers raise any error on a broken file
        raise UnreadableMeshError(f"cannot be read: {type(error).__name__}: {str(error)[:120]}") from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Silences warnings of readers about oddities of a file; what matters is in the list of missing meshes."""
    log, nothing = logging.getLogger("trimesh"), lambda _: False
    log.addFilter(nothing)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        log.removeFilter(nothing)


def _bytes(mesh: Mesh) -> bytes:
    """The content of the file, if its size and kind can be read."""
    path, root = _place(mesh)
    try:
        data = read_inside(path, root, MAX_BYTES)
    except ValueError as error:
        raise UnreadableMeshError(str(error)) from error
    except OSError as error:
        raise UnreadableMeshError(f"is no file that can be read in {root}") from error
    if zipfile.is_zipfile(io.BytesIO(data)):
        raise UnreadableMeshError("is a zip archive, which could unfold to any size")
    check_mesh(data, _kind(mesh))
    return data


def _place(mesh: Mesh) -> tuple[Path, Path]:
    """The file, and the folder in which it and the files it refers to must lie."""
    assert mesh.path is not None
    if mesh.root is not None:
        return mesh.path, mesh.root
    path = mesh.path.resolve()
    return path, path.parent


def _load(mesh: Mesh, data: bytes) -> Any:
    """The file as a trimesh scene."""
    import trimesh  # takes half a second: imported only if a mesh is read

    from robust_ik.description.meshes.mesh_file_references import ConfinedResolver

    path, root = _place(mesh)
    kind = _kind(mesh).lstrip(".")
    resolver = ConfinedResolver(path.parent, root)
    return trimesh.load(io.BytesIO(data), file_type=kind, resolver=resolver, force="scene", process=False)


def _kind(mesh: Mesh) -> str:
    """The suffix in the description; a link may lead to a file of another name."""
    written = PurePosixPath(mesh.name).suffix.lower()
    return written if written in MESH_SUFFIXES or mesh.path is None else mesh.path.suffix.lower()


def _scaling(mesh: Mesh, data: bytes) -> Array:
    unit = 1.0
    if _kind(mesh) == ".dae":
        found = re.search(rb"<unit\b[^>]{0,1000}?\bmeter\s*=\s*[\"']([^\"']{1,40})", data[:100_000])
        unit = float(found[1]) if found else 1.0
    return np.array(mesh.scale) * unit


def _parts(scene: Any, scaling: Array) -> Iterator[Part]:
    """One part for each colour of the scene, and one for each geometry with colours at its vertices."""
    by_color: dict[Color | None, list[Triangles]] = {}
    for shape, linear, shift in _placed(scene, scaling):
        color, vertex_colors = _colors(shape)
        faces = shape.faces if np.linalg.det(linear) >= 0 else shape.faces[:, ::-1]
        triangles = Triangles.of(shape.vertices @ linear.T + shift, faces, vertex_colors)
        by_color.setdefault(None if vertex_colors is not None else color, [])
        if vertex_colors is None:
            by_color[color].append(triangles)
        else:
            yield from _part([triangles], None)
    for color, pieces in by_color.items():
        yield from _part(pieces, color)


def _vertices(scene: Any, scaling: Array) -> Iterator[Array]:
    for shape, linear, shift in _placed(scene, scaling):
        yield np.asarray(shape.vertices, dtype=float)[np.unique(shape.faces)] @ linear.T + shift


def _placed(scene: Any, scaling: Array) -> Iterator[tuple[Any, Array, Array]]:
    """Every geometry with triangles, its linear map (3, 3) and its shift (3,) into the scaled scene."""
    import trimesh

    count = 0
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph.get(node)
        shape = scene.geometry[name]
        if isinstance(shape, trimesh.Trimesh) and len(shape.faces):
            count += len(shape.faces)
            check_triangles(count)
            yield shape, transform[:3, :3] * scaling[:, None], transform[:3, 3] * scaling


def _part(pieces: list[Triangles], color: Color | None) -> Iterator[Part]:
    tidied = tidy(Triangles.joined(pieces)) if pieces else None
    if tidied is not None and len(tidied.faces):
        yield Part(tidied, color)


def _colors(shape: Any) -> tuple[Color | None, NDArray[np.uint8] | None]:
    """The colour of a geometry; the colours of its vertices instead if they differ.

    Opacity in the file is ignored: exporters disagree on whether 0 or 1 is opaque.
    """
    visual = shape.visual
    if visual.kind == "texture":
        image = getattr(visual.material, "image", None) or getattr(visual.material, "baseColorTexture", None)
        if image is not None and visual.uv is not None and _may_be_opened(image):
            return _uniform(visual.to_color().vertex_colors, len(shape.vertices))
        return _rgba(visual.material.main_color), None
    if visual.kind in ("vertex", "face"):
        return _uniform(visual.vertex_colors, len(shape.vertices))
    return None, None


def _may_be_opened(image: Any) -> bool:
    """Whether an image, of which only the header has been read, is of allowed size and kind."""
    return image.width * image.height <= MAX_PIXELS and getattr(image, "format", None) in IMAGES


def _uniform(colors: Any, count: int) -> tuple[Color | None, NDArray[np.uint8] | None]:
    colors = np.asarray(colors, dtype=np.uint8)
    if colors.ndim != 2 or len(colors) != count:
        return None, None
    if (colors == colors[0]).all():
        return _rgba(colors[0]), None
    return None, colors[:, :3]


def _rgba(color: Any) -> Color:
    red, green, blue = (float(channel) / 255 for channel in np.asarray(color)[:3])
    return red, green, blue, 1.0
