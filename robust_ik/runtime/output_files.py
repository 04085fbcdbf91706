"""Writes result files whole or not at all, and checks beforehand whether a file can be written.

A file is replaced in one step and keeps its permissions; links are followed. A pipe or a device is written to. If only
the last folder of the path is missing it is made; if more are missing the path is taken for a typing mistake.
"""

from __future__ import annotations

import errno
import logging
import os
import re
import stat
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from robust_ik.errors import InputError

FIGURES = (".png", ".svg", ".pdf")
STANDARD_OUTPUT = "-"
IN_PLACE = (errno.EBUSY, errno.EXDEV, errno.EPERM, errno.EACCES)
"""Errors that forbid to replace a file but perhaps not to write to it: a mount point, or a read-only folder."""
_DESCRIPTOR = re.compile(r"/(?:dev|proc/self)/fd/(\d+)")


@dataclass(frozen=True)
class Output:
    """The destination of a result.

    Attributes:
        path: The path as it was given.
        target: The path with links resolved.
        status: Status of the existing file; None if there is none.
        descriptor: The number of an open file of this program, such as standard output, if the path names one.
        replaced: True if a new file takes the place of the old one; False if the old one is written to.
    """

    path: Path
    target: Path
    status: os.stat_result | None
    descriptor: int | None
    replaced: bool

    @property
    def overwrites(self) -> bool:
        """Whether an existing file loses its content."""
        return self.descriptor is None and self.status is not None and stat.S_ISREG(self.status.st_mode)

    @property
    def new_folder(self) -> Path | None:
        """The folder that has to be made; None if it exists."""
        return None if self.descriptor is not None or self.target.parent.exists() else self.target.parent


def check_output(path: str | Path) -> Output:
    """The destination of a result, if it can be written there; leaves nothing behind.

    Args:
        path: A file, a pipe or a device; ~ stands for the home folder, - for standard output.

    Raises:
        InputError: The path is a folder, lies below a file or in a folder that does not exist, or nothing may be
            written there.
    """
    try:
        given = Path(path).expanduser()
        return _looked_at(given)
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"nothing can be written to {_shown(path)}: {_reason(error)}") from error


def check_outputs(outputs: Mapping[str, str | Path | None]) -> list[Output]:
    """`check_output` of each output that is given; no two may be the same file.

    Args:
        outputs: Paths by what to call them in a message; None is left out.

    Raises:
        InputError: One cannot be written, or two are the same.
    """
    checked = {name: check_output(path) for name, path in outputs.items() if path is not None}
    places: dict[Path, str] = {}
    for name, output in checked.items():
        if (other := places.setdefault(output.target, name)) != name and output.replaced:
            raise InputError(f"{other} and {name} cannot both be written to {_shown(output.path)}")
    return list(checked.values())


def check_figure(path: str | Path) -> Path:
    """The path of an image file, with ~ replaced, if it can be written.

    Raises:
        InputError: Its ending is no image format, or it cannot be written.
    """
    given = check_output(path).path
    if given.suffix.lower() not in FIGURES:
        raise InputError(f"the figure is written as one of {', '.join(FIGURES)}, got {_shown(path)}")
    return given


def write_file(path: str | Path, content: str | bytes) -> Path:
    """Writes a result; text is written in UTF-8, lone surrogates as escapes.

    Args:
        path: As for `check_output`.
        content: The whole content.

    Raises:
        InputError: It cannot be written; the old content is then kept.
    """
    output = check_output(path)
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    try:
        _write(output, data)
    except BrokenPipeError:  # the reader has closed the pipe: no error of the path
        raise
    except OSError as error:
        raise InputError(f"{_shown(path)} could not be written: {_reason(error)}") from error
    return output.path


def _looked_at(path: Path) -> Output:
    descriptor = _descriptor(path)
    target = Path(os.path.realpath(path))
    try:
        status = os.fstat(descriptor) if descriptor is not None else path.stat()
    except FileNotFoundError:
        _check_parents(path, target)
        return Output(path, target, None, None, replaced=True)
    except NotADirectoryError:
        raise _below_a_file(path) from None
    if descriptor is not None:
        return Output(path, target, status, descriptor, replaced=False)
    return _existing(path, target, status)


def _existing(path: Path, target: Path, status: os.stat_result) -> Output:
    if stat.S_ISDIR(status.st_mode):
        raise InputError(f"{str(path)!r} is a folder; give the name of a file in it, such as {str(path / 'file')!r}")
    own = next((number for number in (1, 2) if _same(number, status)), None)
    if stat.S_ISREG(status.st_mode) and own is None:
        return Output(path, target, status, None, replaced=_check_replaceable(path, target))
    if stat.S_ISBLK(status.st_mode) or stat.S_ISSOCK(status.st_mode):
        raise InputError(f"{str(path)!r} is a disk or a socket: give a file, a pipe or a terminal")
    if own is None and not os.access(path, os.W_OK):
        raise InputError(f"{str(path)!r} may not be written to")
    return Output(path, target, status, own, replaced=False)


def _descriptor(path: Path) -> int | None:
    if str(path) == STANDARD_OUTPUT:
        return 1
    found = _DESCRIPTOR.fullmatch(str(path))
    return int(found[1]) if found else None


def _same(descriptor: int, status: os.stat_result) -> bool:
    """Whether standard output or error goes to that file: to replace it would cut them off."""
    try:
        return os.path.samestat(os.fstat(descriptor), status)
    except OSError:
        return False


def _check_parents(path: Path, target: Path) -> None:
    """Raises if a new file has no folder to lie in."""
    folder = target.parent
    if not folder.exists():
        folder = folder.parent
        if not folder.exists():
            missing = next(each for each in reversed(target.parents) if not each.exists())
            raise InputError(f"there is no folder {str(missing)!r} to write {_shown(path)} in: make it first")
    if not folder.is_dir():
        raise _below_a_file(path)
    _probe(folder, target.name)


def _below_a_file(path: Path) -> InputError:
    below = next((parent for parent in path.parents if os.path.lexists(parent)), path.parent)
    return InputError(f"{str(below)!r} is no folder, so that {path.name!r} cannot be written there")


def _check_replaceable(path: Path, target: Path) -> bool:
    """Whether a new file may take the place of this one; if not, raises unless the old one may be written to."""
    try:
        _probe(target.parent, target.name)
    except InputError:
        if not os.access(path, os.W_OK):
            raise
        return False
    return True


def _probe(folder: Path, name: str) -> None:
    """Makes a file and removes it, since permissions do not show a full disk, a read-only one, or /proc."""
    part = _part(folder, name)
    try:
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))
    except OSError as error:
        raise InputError(f"nothing can be written in the folder {str(folder)!r}: {_reason(error)}") from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _part(folder: Path, name: str) -> Path:
    import secrets  # takes as long as the rest of this module: imported only if a file is written

    return folder / f".{os.fsdecode(os.fsencode(name)[:60])}.{secrets.token_hex(6)}.part"


def _write(output: Output, data: bytes) -> None:
    if output.descriptor is not None:
        _write_to_stream(output.descriptor, data)
        return
    if (folder := output.new_folder) is not None:
        folder.mkdir(exist_ok=True)
        logging.getLogger("robust_ik").info(f"made the folder {_shown(folder)}")
    if output.replaced:
        try:
            _replace(output, data)
            return
        except OSError as error:
            if output.status is None or error.errno not in IN_PLACE:
                raise
    _write_in_place(output, data)


def _write_to_stream(descriptor: int, data: bytes) -> None:
    """Writes to an open file, after all that was printed before."""
    sys.stdout.flush()
    printed = getattr(sys.stdout, "buffer", None)
    if descriptor == 1 and printed is not None:
        printed.write(data)
        printed.flush()
        return
    with os.fdopen(os.dup(descriptor), "wb") as file:
        file.write(data)


def _write_in_place(output: Output, data: bytes) -> None:
    """Writes to an existing file; if it has disappeared meanwhile, that is an error."""
    cut = os.O_TRUNC if output.status is not None and stat.S_ISREG(output.status.st_mode) else 0
    with os.fdopen(os.open(output.path, os.O_WRONLY | cut | getattr(os, "O_NOCTTY", 0)), "wb") as file:
        file.write(data)


def _replace(output: Output, data: bytes) -> None:
    part = _part(output.target.parent, output.target.name)
    mode = 0o666 if output.status is None else 0o600  # for the owner alone until it has the right one
    binary = getattr(os, "O_BINARY", 0)
    try:
        with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | binary, mode), "wb") as file:
            if output.status is not None:
                _keep_rights(file.fileno(), output.status)
            file.write(data)
        part.replace(output.target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _keep_rights(descriptor: int, status: os.stat_result) -> None:
    if hasattr(os, "fchmod"):  # missing on some Windows
        with suppress(OSError):
            os.fchown(descriptor, status.st_uid, status.st_gid)
        os.fchmod(descriptor, stat.S_IMODE(status.st_mode))


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _shown(path: object) -> str:
    text = str(path)
    return repr(text if len(text) <= 200 else text[:200] + "…")
