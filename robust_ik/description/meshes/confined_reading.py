"""Opens files without a gap between check and reading: the file that is read is the one that was checked."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def read_inside(path: Path, root: Path, most: int) -> bytes:
    """The content of a plain file inside a folder.

    The file is opened first and checked afterwards: the open file must be the one at that path, the path must lead
    through no link, and it must lie inside. So a folder or file that is exchanged for a link in between is refused.

    Args:
        path: The file, with links resolved.
        root: The folder in which it must lie, with links resolved.
        most: A file of more bytes is refused before it is read.

    Raises:
        OSError: There is no such file, it is not a plain file, or it is outside.
        ValueError: It is too large.
    """
    wait_for_none = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
    with os.fdopen(os.open(path, os.O_RDONLY | wait_for_none), "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise FileNotFoundError(f"{path} is no file")
        real = Path(os.path.realpath(path))
        if real != path or not real.is_relative_to(root) or not os.path.samestat(status, real.stat()):
            raise PermissionError(f"{path} is not in {root}")
        if status.st_size > most:
            raise ValueError(f"is larger than {most / 1e6:g} MB")
        return file.read(most)
