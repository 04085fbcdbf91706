"""From the mesh paths that a URDF writes to files on disk, never outside the robot's own folders."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Self

from robust_ik.errors import UrdfError

MESH_SUFFIXES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".off")
ALLOW = "allow its folder by package_dirs= (--package-dir)"
CONVENTIONAL_FOLDERS = ("urdf", "urdfs", "robots", "robot", "model", "models", "xacro")
"""A URDF in one of these belongs to the folder around it."""


@dataclass(frozen=True)
class Found:
    """A mesh file and the folder it may refer within; or why there is none."""

    path: Path | None
    root: Path | None
    problem: str = ""


@dataclass(frozen=True)
class MeshPaths:
    """Resolves `package://`, `file://`, absolute and relative paths for one URDF.

    Attributes:
        folder: The folder of the URDF, absolute and without `..`, or None for a URDF given as text.
        package_dirs: Folders given by the user: a package itself, or a folder that holds packages.
    """

    folder: Path | None
    package_dirs: tuple[Path, ...] = ()

    @classmethod
    def of(cls, folder: Path | None, package_dirs: Sequence[str | Path]) -> Self:
        """For a folder and package folders as a user writes them."""
        return cls(folder and _absolute(folder), tuple(_absolute(Path(given).expanduser()) for given in package_dirs))

    def resolve(self, name: str) -> Found:
        """The file that `name` stands for.

        One that is not there, or lies behind a link that leads outside, or is of no kind that can be drawn, is
        reported, so that the kinematics still load.

        Raises:
            UrdfError: The path climbs out of its package by `..`.
        """
        scheme, _, rest = name.partition("://")
        if not rest:
            scheme, rest = "", name
        if PurePosixPath(rest).suffix.lower() not in MESH_SUFFIXES:
            return Found(None, None, f"is none of {', '.join(MESH_SUFFIXES)}")
        try:
            if scheme in ("package", "model"):
                return self._in_package(name, rest)
            if scheme in ("", "file"):
                return self._in_folders(name, rest)
        except (OSError, RuntimeError, ValueError) as error:
            if isinstance(error, UrdfError):
                raise
            return Found(None, None, f"cannot be looked up: {error}")
        return Found(None, None, f"is a {scheme} address, which is never fetched")

    def _in_package(self, name: str, rest: str) -> Found:
        package, _, inside = rest.lstrip("/").partition("/")
        if package in ("", ".", "..") or not inside.strip("/"):
            raise UrdfError(f"mesh path {_shown(name)} names no package: package://<package>/<path> is meant")
        roots = [root for root in dict.fromkeys(self._package_roots(package)) if root.is_dir()]
        found = Found(None, None, f"no folder of package {package!r} found")
        for root in roots:
            path = _absolute(root / inside.lstrip("/"))
            if not path.is_relative_to(root):
                raise _climbs(name, root)
            found = self._checked(path, root)
            if found.path is not None:
                return found
        return Found(None, None, f"{found.problem}; give package_dirs= (--package-dir) to say where it is")

    def _package_roots(self, package: str) -> Iterator[Path]:
        for given in (*self.package_dirs, *_ros_package_dirs()):
            yield from (given / package, given) if given.name == package else (given / package,)
        if self.folder is not None:
            yield self.folder / package
            for ancestor in (self.folder, *self.folder.parents):
                if ancestor.name == package:
                    yield ancestor
                elif (ancestor / package / "package.xml").is_file():
                    yield ancestor / package

    def _in_folders(self, name: str, rest: str) -> Found:
        roots = [*self._own_roots(), *self.package_dirs]
        absolute = PurePosixPath(rest).is_absolute()
        if self.folder is None and not absolute:
            return Found(None, None, "is relative, but the URDF was given as text, in no folder")
        path = _absolute(Path(rest) if absolute or self.folder is None else self.folder / rest)
        root = next((root for root in roots if path.is_relative_to(root)), None)
        if root is not None:
            return self._checked(path, root)
        if absolute:
            return Found(None, None, f"is outside the robot's folders; {ALLOW}")
        if not (roots[0] / "package.xml").is_file():
            return Found(None, None, f"is outside {roots[0]}; {ALLOW}")
        raise _climbs(name, roots[0])

    def _own_roots(self) -> list[Path]:
        """The URDF's package: the nearest ancestor with a package.xml, else its folder (`urdf/` counts as inside)."""
        if self.folder is None:
            return []
        for ancestor in (self.folder, *self.folder.parents):
            if (ancestor / "package.xml").is_file():
                return [ancestor]
        return [self.folder.parent if self.folder.name in CONVENTIONAL_FOLDERS else self.folder]

    def _checked(self, path: Path, root: Path) -> Found:
        """The file, unless it is missing or links lead from it to where nothing may be read."""
        if not path.is_file():
            return Found(None, None, f"not found at {path}")
        real = path.resolve()
        if not any(real.is_relative_to(allowed.resolve()) for allowed in (root, *self.package_dirs)):
            return Found(None, None, f"is a link that leads out of {root}; give package_dirs= to allow {real.parent}")
        return Found(path, root)


def _absolute(path: Path) -> Path:
    """Absolute and without `..`, links left as they are."""
    return Path(os.path.abspath(path))  # noqa: PTH100


def _climbs(name: str, root: Path) -> UrdfError:
    return UrdfError(f"mesh path {_shown(name)} climbs out of {root}; put the file inside, or {ALLOW}")


def _shown(name: str) -> str:
    return repr(name if len(name) <= 200 else name[:200] + "…")


def _ros_package_dirs() -> Sequence[Path]:
    ros1 = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    ros2 = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [*(Path(folder) for folder in ros1 if folder), *(Path(prefix) / "share" for prefix in ros2 if prefix)]
