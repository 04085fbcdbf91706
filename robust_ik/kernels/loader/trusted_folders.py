"""Checks that only this user and the administrator can have written a folder or a file, as ssh checks its keys.

A kernel is machine code: anyone who can place a file where kernels are read can run code as the user who reads it.
Windows keeps such rights elsewhere; there everything is trusted.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

SOURCES = Path(__file__).parent
"""The owner of these sources is trusted: he could run any code already."""
OTHERS, GROUP = stat.S_IWOTH, stat.S_IWGRP


def open_to_others(path: Path) -> tuple[int, int] | None:
    """The write permissions of group and others, and the group; None if the path does not exist."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mode & (OTHERS | GROUP), status.st_gid


def why_not_folder(folder: Path, like: tuple[int, int] | None = None) -> str | None:
    """The reason why another user may have written to a folder; None if nobody can have.

    Args:
        folder: It need not exist; then the folders above it are checked.
        like: `open_to_others` of a folder that may be just as open; the folders above are then not checked.
    """
    if not hasattr(os, "getuid"):
        return None
    try:
        real = Path(os.path.realpath(folder))
        if like is not None:
            return _why_not(real.stat(), str(real), like) if real.exists() else None
        for each in (real, *real.parents):
            if each.exists():
                # In a sticky folder such as /tmp nobody can move or remove another user's files.
                status, sticky = each.stat(), each != real
                if sticky and status.st_mode & stat.S_ISVTX and status.st_uid in _trusted():
                    continue
                if reason := _why_not(status, str(each), None):
                    return reason
    except OSError as error:
        return f"{folder} cannot be looked at: {error.strerror}"
    return None


def why_not_file(descriptor: int, path: Path) -> str | None:
    """The reason why another user may have written a file; None if nobody can have. It may be as open as its folder."""
    if not hasattr(os, "getuid"):
        return None
    return _why_not(os.fstat(descriptor), "it", open_to_others(path.parent))


def make_folder(folder: Path) -> None:
    """Makes a folder, and those above it, that only this user can write to.

    Raises:
        OSError: It cannot be made.
    """
    for each in reversed([folder, *folder.parents]):
        if not each.exists():
            each.mkdir(mode=0o755, exist_ok=True)
    if not folder.is_dir():
        raise NotADirectoryError(str(folder))


def _trusted() -> set[int]:
    return {0, os.getuid(), SOURCES.stat().st_uid}


def _why_not(status: os.stat_result, name: str, like: tuple[int, int] | None) -> str | None:
    if status.st_uid not in _trusted():
        return f"{name} belongs to another user (uid {status.st_uid})"
    allowed, group = like if like is not None else (0, -1)
    if status.st_mode & OTHERS & ~allowed:
        return f"everybody can write to {name}"
    if status.st_mode & GROUP and not (allowed & GROUP and status.st_gid == group) and not _private(status.st_gid):
        return f"its group can write to {name}"
    return None


def _private(group: int) -> bool:
    """Whether a group contains this user alone, as the group that many systems make for each user."""
    import grp  # does not exist on Windows
    import pwd

    try:
        user, named = pwd.getpwuid(os.getuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return user.pw_gid == group and named.gr_name == user.pw_name and set(named.gr_mem) <= {user.pw_name}
