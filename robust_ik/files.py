"""Reads and writes whole files: bounded, all or nothing, with one sentence when it fails."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from robust_ik.errors import InputError, LoadError, RobotNotFoundError


def read_file(path: str | Path, most: int) -> tuple[Path, bytes]:
    """The absolute path and what the file holds.

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
    except (OSError, RuntimeError, ValueError) as error:
        if isinstance(error, LoadError):
            raise
        reason = error.strerror if isinstance(error, OSError) else error
        raise LoadError(f"the file {_shown(path)} cannot be read: {reason}") from error


def _shown(path: str | Path) -> str:
    text = str(path)
    return repr(text if len(text) <= 200 else text[:200] + "…")


def check_writable(path: Path) -> None:
    """Refuses a path that is a folder, or that lies below a file.

    Raises:
        InputError: It is.
    """
    if path.is_dir():
        raise InputError(f"{str(path)!r} is a folder; give the name of a file in it, such as {str(path / 'file')!r}")
    below = next((parent for parent in path.parents if parent.exists()), None)
    if below is not None and not below.is_dir():
        raise InputError(f"{str(below)!r} is no folder, so that {path.name!r} cannot be written there")


FIGURES = (".png", ".svg", ".pdf")


def check_figure(path: Path) -> None:
    """Refuses a path that is no image's, or that cannot be written.

    Raises:
        InputError: It is none.
    """
    if path.suffix.lower() not in FIGURES:
        raise InputError(f"the figure is written as one of {', '.join(FIGURES)}, got {str(path)!r}")
    check_writable(path)


def write_file(path: str | Path, text: str) -> Path:
    """Writes a text file at once or not at all; makes the folder if needed.

    Raises:
        InputError: The path is a folder, or something on the way to it is a file.
    """
    path = Path(path).expanduser()
    check_writable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name[:60]}.{secrets.token_hex(6)}.part")
    try:
        with part.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return path
