"""Expands one xacro file, in a process of its own that `xacro_files` starts.

A xacro file is a program. The process may read packages and the robot's own tree; it must not write files, start
programs or use the network. An audit hook enforces this once the libraries are imported. It stops careless files and
simple attacks; it does not stop code that was written to break out of it.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import sys
from pathlib import Path
from typing import Any

from robust_ik.description.meshes.mesh_paths import MeshPaths

FORBIDDEN = (
    "ctypes.", "ftplib.", "os.chmod", "os.chown", "os.exec", "os.fork", "os.kill", "os.link", "os.mkdir",
    "os.posix_spawn", "os.remove", "os.rename", "os.rmdir", "os.spawn", "os.startfile", "os.symlink", "os.system",
    "os.truncate", "pty.", "shutil.", "socket.", "sqlite3.", "subprocess.", "urllib.", "webbrowser.", "winreg.",
)  # fmt: skip
"""Python's audit events that no robot needs."""


class _Readable:
    """The folders that may be read: the robot's, those of the packages found, and Python's own."""

    def __init__(self, paths: MeshPaths) -> None:
        self.paths = paths
        given = (*paths.package_dirs, *(() if paths.own_tree is None else (paths.own_tree,)))
        self.folders = [each.resolve() for each in given]
        self.python = [Path(each).resolve() for each in (*sys.path, sys.prefix, sys.base_prefix) if each]

    def package(self, name: str) -> str:
        """The folder of a package, for `$(find name)`."""
        found = self.paths.package(name)
        if found is None:
            raise FileNotFoundError(f"no folder of package {name!r} found: give package_dirs= (--package-dir)")
        self.folders.append(found.resolve())
        return str(found)

    def audit(self, event: str, arguments: tuple[Any, ...]) -> None:
        """The audit hook: Python calls it before each request to the system."""
        if event.startswith(FORBIDDEN):
            raise PermissionError(errno.EPERM, "a xacro file may not do this", event)
        if event == "open" and isinstance(arguments[0], (str, bytes, os.PathLike)):
            self._check(Path(os.fsdecode(arguments[0])), arguments[2])

    def _check(self, path: Path, flags: Any) -> None:
        writes = isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        real = path.resolve()
        if writes or not any(real.is_relative_to(folder) for folder in (*self.folders, *self.python)):
            says = "outside the robot's folders (package_dirs=, --package-dir)"
            raise PermissionError(errno.EACCES, says, str(path))


def main() -> None:
    """Reads the request as JSON from standard input; writes the URDF, or the error, as JSON to standard output."""
    job = json.load(sys.stdin)
    _bound_memory(job["memory"])
    answer = {}
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
            answer["urdf"] = _expand(Path(job["path"]), job["arguments"], job["package_dirs"])
    except (Exception, SystemExit) as error:
        answer["error"] = f"{type(error).__name__}: {error}".strip()
    answer["said"] = said.getvalue()[-2000:]
    json.dump(answer, sys.stdout)


def _expand(path: Path, arguments: dict[str, str], package_dirs: list[str]) -> str:
    import yaml  # noqa: F401 (what xacro loads late must be there before the hook is)
    from xacrodoc import XacroDoc, packages

    readable = _Readable(MeshPaths.of(path.parent, package_dirs))
    packages.get_path = readable.package
    sys.dont_write_bytecode = True
    os.chdir(path.parent)
    sys.addaudithook(readable.audit)
    document = XacroDoc.from_file(str(path), subargs=arguments, resolve_packages=False)
    return str(document.dom.documentElement.toxml())


def _bound_memory(most: int) -> None:
    """Limits the memory of the process to `most` bytes, if the system can do that."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    except (ImportError, OSError, ValueError):
        return
