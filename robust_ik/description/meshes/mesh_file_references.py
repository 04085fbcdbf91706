"""Reads the files that a mesh refers to, from inside its folder only."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from trimesh.resolvers import Resolver

from robust_ik.description.meshes.confined_reading import read_inside

MAX_REFERENCE_BYTES = 50_000_000
"""Most bytes of all files that one mesh refers to, each counted as often as it is read."""
MAX_MATERIAL_BYTES = 1_000_000
"""Most bytes of one file of materials; real ones have some hundred."""
REFERENCES = (
    ".mtl", ".bin", ".glbin", ".buffer", ".png", ".jpg", ".jpeg", ".gif", ".bmp", ".tga", ".tif", ".tiff", ".webp"
)  # fmt: skip
"""Endings of materials, buffers and images. A mesh refers to no other files, and others must not be read."""

if TYPE_CHECKING:
    _Base: Any = object
else:
    _Base = Resolver


class ConfinedResolver(_Base):  # type: ignore[misc]
    """Reads materials, textures and buffers that a mesh refers to, only below a root folder.

    Files outside (by "..", an absolute path, a link or an address) count as missing. So do files in hidden folders
    below the root (`.git`, `.ssh`), files of kinds to which meshes do not refer, and files beyond the limit of bytes.

    Attributes:
        folder: The folder from which references start.
        root: The folder that references must not leave.
        left: Bytes that may still be read.
    """

    def __init__(self, folder: Path, root: Path) -> None:
        self.folder, self.root = folder, root.resolve()
        self.left = MAX_REFERENCE_BYTES

    def get(self, key: str) -> bytes:
        """The bytes of a file that a mesh refers to.

        Raises:
            FileNotFoundError: There is no such file inside the root.
        """
        for name in dict.fromkeys((str(key), unquote(str(key)))):
            path = self._inside(name)
            if path is not None:
                try:
                    data = read_inside(path, self.root, self._most(path))
                except (OSError, ValueError):
                    continue
                self.left -= len(data)
                return data
        raise FileNotFoundError(f"{str(key)[:200]!r} is not in {self.root}")

    def _inside(self, name: str) -> Path | None:
        """The file, with links resolved, if it lies inside the root and a mesh may refer to it."""
        name = name.strip().replace("\\", "/")
        if not name or "\0" in name or "://" in name:
            return None
        try:
            path = Path(os.path.normpath(self.folder / name)).resolve()
            if not path.is_relative_to(self.root) or not path.is_file():
                return None
        except (OSError, ValueError, RuntimeError):
            return None
        hidden = any(part.startswith(".") for part in path.relative_to(self.root).parts)
        return path if not hidden and path.suffix.lower() in REFERENCES else None

    def _most(self, path: Path) -> int:
        return min(self.left, MAX_MATERIAL_BYTES) if path.suffix.lower() == ".mtl" else self.left

    def keys(self) -> Iterator[str]:
        """No names: files are asked for by name, and folders are never listed."""
        return iter(())

    def __contains__(self, key: str) -> bool:
        return self._inside(str(key)) is not None

    def write(self, name: str, _: Any) -> None:
        """Raises: nothing is written beside a mesh."""
        raise PermissionError(f"nothing is written beside a mesh, got {name!r}")

    def namespaced(self, namespace: str) -> ConfinedResolver:
        """A resolver with the same limits, for references from a folder below."""
        return ConfinedResolver(self.folder / namespace, self.root)
