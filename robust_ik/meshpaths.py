"""From the mesh paths that a URDF writes to files on disk, never outside the robot's own folders."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from robust_ik.errors import UrdfError

MESH_SUFFIXES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".off")
_CONVENTIONAL_FOLDERS = ("urdf", "urdfs", "robots", "robot", "model", "models", "xacro")


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
        folder: The folder of the URDF, or None for a URDF given as text.
        package_dirs: Folders given by the user: a package itself, or a folder that holds packages.
    """

    folder: Path | None
    package_dirs: tuple[Path, ...] = ()

    def resolve(self, name: str) -> Found:
        """The file that `name` stands for.

        A path that leaves its package by `..` or by a link is refused; one that is merely not there, or of no kind
        that can be drawn, is reported, so that the kinematics still load.

        Raises:
            UrdfError: The path climbs out of its package.
        """
        scheme, _, rest = name.partition("://")
        if not rest:
            scheme, rest = "", name
        if PurePosixPath(rest).suffix.lower() not in MESH_SUFFIXES:
            return Found(None, None, f"is none of {', '.join(MESH_SUFFIXES)}")
        if scheme in ("package", "model"):
            return self._in_package(name, rest)
        if scheme not in ("", "file"):
            return Found(None, None, f"is a {scheme} address, which is never fetched")
        return self._in_folders(name, rest)

    def _in_package(self, name: str, rest: str) -> Found:
        package, _, inside = rest.lstrip("/").partition("/")
        if package in ("", ".", "..") or not inside:
            raise UrdfError(f"mesh path {name!r} names no package: package://<package>/<path> is meant")
        roots = [root for root in dict.fromkeys(self._package_roots(package)) if root.is_dir()]
        for root in roots:
            path = _inside(root, inside, name)
            if path.is_file():
                return Found(path, root)
        where = f"not in {roots[0]}" if roots else f"no folder of package {package!r} found"
        return Found(None, None, f"{where}; give package_dirs= (--package-dir) to say where it is")

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
        roots = [*self.package_dirs, *([self._own_root()] if self.folder is not None else [])]
        if PurePosixPath(rest).is_absolute():
            path = Path(os.path.normpath(rest))
            root = next((root for root in roots if path.is_relative_to(root)), None)
            if root is None:
                return Found(None, None, "is outside the robot's folders; give package_dirs= to allow its folder")
            return self._checked(_inside(root, str(path.relative_to(root)), name), root)
        if self.folder is None:
            return Found(None, None, "is relative, but the URDF was given as text; give package_dirs=")
        root = self._own_root()
        beside = _inside(root, str(self.folder.relative_to(root) / rest), name)
        return self._checked(beside, root)

    def _own_root(self) -> Path:
        """The URDF's package: the nearest ancestor with a package.xml, else its folder (`urdf/` counts as inside)."""
        assert self.folder is not None
        for ancestor in (self.folder, *self.folder.parents):
            if (ancestor / "package.xml").is_file():
                return ancestor
        return self.folder.parent if self.folder.name in _CONVENTIONAL_FOLDERS else self.folder

    @staticmethod
    def _checked(path: Path, root: Path) -> Found:
        return Found(path, root) if path.is_file() else Found(None, None, f"not found at {path}")


def _inside(root: Path, inside: str, name: str) -> Path:
    """`root / inside`, refused when `..` or a link leads out of root."""
    path = Path(os.path.normpath(root / inside))
    if not path.is_relative_to(root) or not path.resolve().is_relative_to(root.resolve()):
        raise UrdfError(
            f"mesh path {name!r} climbs out of {root}; put the file inside, or name its folder in package_dirs="
        )
    return path


def _ros_package_dirs() -> Sequence[Path]:
    ros1 = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    ros2 = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [*(Path(folder) for folder in ros1 if folder), *(Path(prefix) / "share" for prefix in ros2 if prefix)]
