"""Compiled kernels on disk: what is compiled once is then read by every process, from any folder.

It replaces Numba's own cache, which has four faults: nothing is read from it without importing Numba, which takes half
a second; it looks at the function's own file only, so that a kernel would not notice a change of the helpers it is made
of; it cannot read from a folder that is read-only, as in a container; and an error in writing ends the program. Here
the name of a file is a hash of all that its contents depend on: there
is no index, processes that compile the same kernel at once write the same file, and files may be copied.

What is read is executed, so only files that nobody else can have written are read: see `trusted_folders`.
"""

from __future__ import annotations

import hashlib
import logging
import os
import uuid
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar

import numpy as np

from robust_ik.kernels.loader.announcing import announce
from robust_ik.kernels.loader.shipped import FOLDER as SHIPPED
from robust_ik.kernels.loader.shipped import shipped
from robust_ik.kernels.loader.target import target
from robust_ik.kernels.loader.trusted_folders import make_folder, open_to_others, why_not_file, why_not_folder

Used = TypeVar("Used")

FOLDER = Path(__file__).parents[1]
"""The folder of all kernels, with its sub-folders."""
SUFFIX = ".kernel"
KEPT = 8
"""Most files of one kernel that are left in a folder, for versions of the code, of Python and of processors."""
_told: list[str] = []
_refused: set[Path] = set()


@dataclass(frozen=True)
class Made:
    """Machine code that has just been compiled.

    Attributes:
        content: As `machine_code.load` takes it.
        fixed: Why it only serves this process; None if it serves others.
    """

    content: bytes
    fixed: str | None = None


def _digest(*parts: bytes) -> bytes:
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).digest()


SOURCES = _digest(*(source.read_bytes() for source in sorted(FOLDER.rglob("*.py"))))
"""Hash of the sources of all kernels, read once at the first import: the files may change while the program runs."""


def places() -> Iterator[Path]:
    """Folders where kernels may lie, best first: NUMBA_CACHE_DIR, beside the sources, the user's cache."""
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(named) / "robust_ik"
    yield FOLDER / "__pycache__"
    from platformdirs import user_cache_path

    with suppress(RuntimeError):  # raised, or the path is not absolute, for a user without a home
        user = user_cache_path("robust_ik", appauthor=False)
        if user.is_absolute():  # else it would be made in the working folder
            yield user


def _trusted_places() -> Iterator[Path]:
    """The places that nobody else can write to; each other place is named once in a warning with the reason.

    Those who may write to the sources need no kernels to run code, so the folder beside the sources may be open to
    them.
    """
    return filter(_is_trusted, places())


def _is_trusted(place: Path) -> bool:
    reason = why_not_folder(place, open_to_others(FOLDER) if place.parent == FOLDER else None)
    if reason is not None and place not in _refused:
        _refused.add(place)
        logging.getLogger("robust_ik").warning(f"compiled kernels in {place} are not used: {reason}")
    return reason is None


class NotCompilableError(Exception):
    """A function is not made of what can be compiled."""


def obtained(name: str, sources: bytes | None, use: Callable[[bytes], Used], make: Callable[[], Made]) -> Used:
    """What is made of machine code that lies on disk or, if it lies nowhere, is compiled and put there.

    Reading and writing raise no errors: what is missing, unreadable or damaged is compiled again.

    Args:
        name: "module.function".
        sources: Hash of all sources that the code is made of; None if they may be others in another process.
        use: Makes the result, of machine code as `make` gives it.
        make: Compiles.
    """
    if sources is not None:
        for content in filter(None, map(_read, _files(name, sources))):
            try:
                return use(content)
            except Exception as error:
                _tell(f"{name} is compiled again: {error!r}")
    announce(name)
    made = make()
    result = use(made.content)
    if sources is not None:
        _keep(name, _file(name, sources, target()), made)
    return result


def _file(name: str, sources: bytes, compiled_for: str) -> str:
    return f"{name}-{_digest(sources, compiled_for.encode()).hex()[:24]}{SUFFIX}"


def _files(name: str, sources: bytes) -> Iterator[Path]:
    """Where machine code may lie, best first: what was shipped serves all processes alike."""
    if (compiled_for := shipped()) is not None and _is_trusted(SHIPPED):
        yield SHIPPED / _file(name, sources, compiled_for)
    file = _file(name, sources, target())
    for place in _trusted_places():
        yield place / file


def _keep(name: str, file: str, made: Made) -> None:
    """Writes machine code to the first place where that is possible."""
    try:
        if made.fixed is not None:
            raise ValueError(made.fixed)  # noqa: TRY301
        if not any(_write(place / file, made.content) for place in _trusted_places()):
            raise PermissionError("there is no folder to write to; NUMBA_CACHE_DIR may name one")  # noqa: TRY301
    except Exception as error:
        _tell(f"{name} is not kept, and compiled by every process: {error}")


def name_of(function: Callable[..., Any]) -> str:
    """The function's module, without its packages, and its name."""
    module = function.__module__ or ""  # None for a function of a text that is executed
    return f"{module.rpartition('.')[2]}.{function.__qualname__}".replace("<locals>", "_")


def sources_of(function: Callable[..., Any], types: str) -> bytes | None:
    """Hash of the sources of a function, for these types of arguments; None if no file determines the function."""
    try:
        made_of = (*_made_of(function, {}), function.__qualname__, types)
    except OSError:
        return None
    return _digest(*(part.encode() for part in made_of), SOURCES)


def _made_of(function: Callable[..., Any], seen: dict[Any, str]) -> Iterable[str]:
    """The sources of a function and of the functions it uses, with the constants they use: they may lie in any file."""
    if function.__closure__ is not None:
        raise OSError("what a closure holds is in no file")
    if function not in seen:
        file = Path(function.__code__.co_filename)
        ours = FOLDER in file.parents  # SOURCES covers these
        seen[function] = file.read_text(encoding="utf-8")
        for name in function.__code__.co_names:
            value = function.__globals__.get(name)
            value = getattr(value, "py_func", value)  # the Python function of a compiled one
            if isinstance(value, FunctionType):
                _made_of(value, seen)
            elif isinstance(value, (int, float, tuple)) and not isinstance(value, np.generic):
                seen[function] += f"{name} = {value!r}\n"
            elif value is not None and not ours and not _is_constant(value):
                raise OSError(f"{name} may be something else in another process")
    return seen.values()


def _is_constant(value: Any) -> bool:
    """Whether a name means the same in every process: modules of NumPy and Python, and NumPy's functions."""
    if isinstance(value, ModuleType):
        return value.__name__.partition(".")[0] in ("numpy", "math", "cmath", "operator")
    return isinstance(value, np.ufunc)


def _read(path: Path) -> bytes | None:
    """The content of a file if it is whole, else None: damaged machine code would end the process."""
    try:
        with path.open("rb") as file:
            reason = why_not_file(file.fileno(), path)
            content = b"" if reason else file.read()
    except OSError:
        return None
    if reason:
        _tell(f"{path} is not used: {reason}")
    return content[32:] if content[:32] == _digest(content[32:]) else None


def _write(path: Path, content: bytes) -> bool:
    """Writes a file in one step, so that nobody ever reads half of it; False if that fails."""
    part = path.with_name(f"{path.name}.{uuid.uuid4().hex}")
    try:
        make_folder(path.parent)
        try:
            _put(part, _digest(content) + content)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError:
        return False
    _prune(path)
    return True


def _put(path: Path, content: bytes) -> None:
    """Writes a new file that only this user can write to, whatever the umask is."""
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644), "wb") as file:
        file.write(content)


def _prune(path: Path) -> None:
    """Removes all but the newest files of this kernel."""
    with suppress(OSError):  # another process may remove them at the same time
        others = path.parent.glob(f"{path.name.rpartition('-')[0]}-*{SUFFIX}")
        for old in sorted(others, key=lambda each: each.stat().st_mtime, reverse=True)[KEPT:]:
            old.unlink(missing_ok=True)


def _tell(message: str) -> None:
    """Logs the first message of this process only: it is about seconds, not about results."""
    if not _told:
        logging.getLogger("robust_ik").warning(message)
    _told.append(message)
