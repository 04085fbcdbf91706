"""Reads whole files up to a size limit, and checks that folders exist; one sentence says what failed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from robust_ik.errors import InputError, LoadError, RobotNotFoundError


def read_file(path: str | Path, most: int) -> tuple[Path, bytes]:
    """The absolute path of a file, and its content.

    Args:
        path: The file; ~ stands for the home folder.
        most: A file of more bytes is refused before it is read.

    Raises:
        RobotNotFoundError: There is no such file.
        LoadError: It is too large or cannot be read.
    """
    try:
        full = Path(os.path.abspath(Path(path).expanduser()))  # noqa: PTH100 (resolve would follow links)
        if not full.is_file():
            raise RobotNotFoundError(f"there is no file {_shown(path)}")
        if (size := full.stat().st_size) > most:
            raise LoadError(f"{full} has {size} bytes; a file of over {most} is refused")
        return full, full.read_bytes()
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        if isinstance(error, LoadError):
            raise
        reason = error.strerror if isinstance(error, OSError) else error
        raise LoadError(f"the file {_shown(path)} cannot be read: {reason}") from error


def _shown(path: str | Path) -> str:
    text = str(path)
    return repr(text if len(text) <= 200 else text[:200] + "…")


def checked_folders(folders: Sequence[str | Path] | str | Path, name: str) -> tuple[Path, ...]:
    """The folders as paths, with ~ replaced, if all of them exist.

    Args:
        folders: Several, or one.
        name: What to call them in a message.

    Raises:
        InputError: One does not exist.
    """
    given = (folders,) if isinstance(folders, (str, Path)) else folders
    try:
        found = tuple(Path(each).expanduser() for each in given)
        missing = next((each for each in found if not each.is_dir()), None)
    except (TypeError, ValueError, OSError, RuntimeError):
        raise InputError(f"{name} must be folders, got {_shown(str(folders))}") from None
    if missing is not None:
        raise InputError(f"{name}: there is no folder {_shown(missing)}")
    return found
