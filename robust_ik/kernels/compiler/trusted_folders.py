"""Which folders and files nobody but this user and the administrator can have written to, as ssh asks of its keys.

A kernel is machine code: who can put a file where one is read runs what he likes as whoever reads it. Windows keeps
such rights elsewhere; there everything is trusted.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

SOURCES = Path(__file__).parent
"""Whoever owns these could run anything already."""
OTHERS, GROUP = stat.S_IWOTH, stat.S_IWGRP


def open_to_others(path: Path) -> tuple[int, int] | None:
    """The write permission of its group and of others, and the group; None if it is not there."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mode & (OTHERS | GROUP), status.st_gid


def why_not_folder(folder: Path, like: tuple[int, int] | None = None) -> str | None:
    """Why what lies in a folder may be another user's; None if it is not.

    Args:
        folder: It need not be there; then the folders above it are asked.
        like: What `open_to_others` says of a folder that may be as open, whose own place is not asked about.
    """
    if not hasattr(os, "getuid"):
        return None
    try:
        real = Path(os.path.realpath(folder))
        if like is not None:
            return _why_not(real.stat(), str(real), like) if real.exists() else None
        for each in (real, *real.parents):
            if each.exists():
                # In a sticky folder, as /tmp is, nobody can move or remove what is another's.
                status, sticky = each.stat(), each != real
                if sticky and status.st_mode & stat.S_ISVTX and status.st_uid in _trusted():
                    continue
                if reason := _why_not(status, str(each), None):
                    return reason
    except OSError as error:
        return f"{folder} cannot be looked at: {error.strerror}"
    return None


def why_not_file(descriptor: int, path: Path) -> str | None:
    """Why an open file may be another user's; None if it is not. It may be as open as the folder that it lies in."""
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
    """Whether a group is the user's own and has nobody else in it, as many systems give to each user."""
    import grp  # not on Windows
    import pwd

    try:
        user, named = pwd.getpwuid(os.getuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return user.pw_gid == group and named.gr_name == user.pw_name and set(named.gr_mem) <= {user.pw_name}
