"""Compiled kernels on disk: what is compiled once is then read by every process, from any folder.

It replaces Numba's own cache, which has three faults: it looks at the function's own file only, so that a kernel would
not notice a change of the helpers it is made of; it cannot read from a folder that is read-only, as in a container;
and an error in writing ends the program. Here the name of a file is a hash of all that its contents depend on: there
is no index, processes that compile the same kernel at once write the same file, and files may be copied.

What is read is executed, so only files that nobody else can have written are read: see `trusted_folders`.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import sys
import uuid
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numba
import numpy as np

from robust_ik.kernels.compiler.announcing import announce
from robust_ik.kernels.compiler.trusted_folders import make_folder, open_to_others, why_not_file, why_not_folder

FOLDER = Path(__file__).parents[1]
"""The folder of all kernels, with its sub-folders."""
SUFFIX = ".kernel"
KEPT = 8
"""Most files of one kernel that are left in a folder, for versions of the code, of Python and of processors."""
SETTINGS = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO_DEFAULT")
"""Numba's settings by environment variables that change the machine code; the target's own key names the processor."""
_told: list[str] = []
_refused: set[Path] = set()


def _digest(*parts: bytes) -> bytes:
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).digest()


SOURCES = _digest(*(source.read_bytes() for source in sorted(FOLDER.rglob("*.py"))))
"""Hash of the sources of all kernels, read once at the first import: the files may change while the program runs."""


def places() -> Iterator[Path]:
    """Folders where kernels may lie, best first: NUMBA_CACHE_DIR, beside the sources, the user's cache."""
    if numba.config.CACHE_DIR:
        yield Path(numba.config.CACHE_DIR) / "robust_ik"
    yield FOLDER / "__pycache__"
    from numba.misc.appdirs import AppDirs

    user = Path(AppDirs("robust_ik", appauthor=False).user_cache_dir)
    if user.is_absolute():  # not absolute for a user without a home: it would be made in the working folder
        yield user


def _trusted_places() -> Iterator[Path]:
    """The places that nobody else can write to; each other place is named once in a warning with the reason.

    Those who may write to the sources need no kernels to run code, so the folder beside the sources may be open to
    them.
    """
    for place in places():
        beside = open_to_others(FOLDER) if place == FOLDER / "__pycache__" else None
        reason = why_not_folder(place, beside)
        if reason is None:
            yield place
        elif place not in _refused:
            _refused.add(place)
            logging.getLogger("robust_ik").warning(f"compiled kernels in {place} are not used: {reason}")


class Store:
    """The file cache that Numba asks for one function's machine code; reading and writing raise no errors.

    Raises:
        OSError: The function comes from no file, or is a closure.

    Attributes:
        cache_path: Unused: there are several.
    """

    cache_path = None

    def __init__(self, function: Callable[..., Any]) -> None:
        source = Path(function.__code__.co_filename)
        self._function = function
        self._name = f"{source.stem}.{function.__qualname__}".replace("<locals>", "_")
        self._source = _digest(*(part.encode() for part in _made_of(function, {})), SOURCES)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """The compiled function; None, so that it is compiled again, if its file is missing, unreadable or damaged."""
        try:
            from numba.core.compiler import CompileResult

            target.refresh()
            name = self._file(signature, target.codegen())
            for content in filter(None, (_read(place / name) for place in _trusted_places())):
                return CompileResult._rebuild(target, *pickle.loads(content))  # noqa: SLF001
        except Exception as error:
            _tell(f"{self._name} is compiled again: {error!r}")
        announce(self._function)
        return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Writes the compiled function to the first place where that is possible."""
        try:
            from numba.core.serialize import dumps

            if compiled.library.has_dynamic_globals:
                raise ValueError("it holds addresses")  # noqa: TRY301
            content, name = dumps(compiled._reduce()), self._file(signature, compiled.codegen)  # noqa: SLF001
            if not any(_write(place / name, content) for place in _trusted_places()):
                raise PermissionError("there is no folder to write to; NUMBA_CACHE_DIR may name one")  # noqa: TRY301
        except Exception as error:
            _tell(f"{self._name} is not kept, and compiled by every process: {error}")

    def enable(self) -> None:
        """Does nothing."""

    disable = flush = enable

    def _file(self, signature: Any, codegen: Any) -> str:
        """The name of the file: a hash of all that the machine code depends on."""
        python = f"{sys.implementation.cache_tag} {getattr(sys, 'abiflags', '')}"
        settings = [getattr(numba.config, name, None) for name in SETTINGS]
        key = repr((python, numba.__version__, codegen.magic_tuple(), str(signature), settings))
        return f"{self._name}-{_digest(self._source, key.encode()).hex()[:24]}{SUFFIX}"


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
