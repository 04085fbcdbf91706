"""What a mesh file refers to is read from inside its folder, and from nowhere else."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from trimesh.resolvers import Resolver

MAX_REFERENCE_BYTES = 50_000_000

if TYPE_CHECKING:
    _Base: Any = object
else:
    _Base = Resolver


class ConfinedResolver(_Base):  # type: ignore[misc]
    """Reads materials, textures and buffers that a mesh refers to, only below a root folder.

    Whatever is outside, by "..", by an absolute path, by a link or by an address, is as good as missing.

    Attributes:
        folder: Where references start from.
        root: What they may not leave.
    """

    def __init__(self, folder: Path, root: Path) -> None:
        self.folder, self.root = folder, root.resolve()

    def get(self, key: str) -> bytes:
        """The bytes of a file that a mesh refers to.

        Raises:
            FileNotFoundError: There is no such file inside the root.
        """
        for name in dict.fromkeys((str(key), unquote(str(key)))):
            path = self._inside(name)
            if path is not None:
                return path.read_bytes()
        raise FileNotFoundError(f"{key!r} is not in {self.root}")

    def _inside(self, name: str) -> Path | None:
        """The file, if it is a plain one of sane size inside the root."""
        name = name.strip().replace("\\", "/")
        if not name or "\0" in name or "://" in name:
            return None
        try:
            path = Path(os.path.normpath(self.folder / name)).resolve()
            plain = path.is_relative_to(self.root) and path.is_file()
            return path if plain and path.stat().st_size <= MAX_REFERENCE_BYTES else None
        except (OSError, ValueError, RuntimeError):
            return None

    def keys(self) -> Iterator[str]:
        """Nothing: files are asked for by name, a folder is never listed."""
        return iter(())

    def __contains__(self, key: str) -> bool:
        return self._inside(str(key)) is not None

    def write(self, name: str, _: Any) -> None:
        """Refused: nothing is written beside a mesh."""
        raise PermissionError(f"nothing is written beside a mesh, got {name!r}")

    def namespaced(self, namespace: str) -> ConfinedResolver:
        """The same confinement, with references starting from a folder below."""
        return ConfinedResolver(self.folder / namespace, self.root)
