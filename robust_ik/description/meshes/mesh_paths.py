"""Finds the files of mesh paths in a URDF, never outside the robot's own folders."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path, PurePosixPath
from typing import Self

from robust_ik.errors import UrdfError, cut

MESH_SUFFIXES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".off")
ALLOW = "allow its folder by package_dirs= (--package-dir)"
CONVENTIONAL_FOLDERS = ("urdf", "urdfs", "robots", "robot", "model", "models", "xacro")
"""A URDF in a folder of one of these names belongs to the folder around it, if meshes are there too."""
SURE_FOLDERS = ("urdf", "urdfs", "xacro")
"""Names that are enough by themselves: no folder of meshes is needed around these."""
MESH_FOLDERS = ("meshes", "mesh", "visual", "visuals", "collision", "collisions", "assets", "stl", "dae", "obj")
PACKAGE_ENDINGS = ("_description", "_support")
"""A folder with such an ending is a robot's package, even without a package.xml."""
LONGEST_NAME = 4096
"""Most characters of a path: no system allows more. Linux's PATH_MAX is 4096."""


@dataclass(frozen=True)
class Found:
    """A mesh file and the folder to which its references are confined; or the reason why there is none.

    Attributes:
        path: The file, with links resolved, so that the file that is opened is the one that was checked.
        root: The folder, with links resolved.
        problem: Why there is no path; empty otherwise.
    """

    path: Path | None
    root: Path | None
    problem: str = ""


@dataclass(frozen=True)
class MeshPaths:
    """Resolves `package://`, `file://`, absolute and relative paths for one URDF.

    Files may be read from the URDF's own tree, from the folders given by the user, and from packages. Packages are
    found in the folders that ROS's environment variables name, and as folders with a package.xml around the URDF or
    beside one of those. A folder around the URDF without package.xml counts as a package only if it is the URDF's own
    tree or its name ends like a robot's package. Folders that all kinds of files share (/, /tmp, a home) never count.
    Links are resolved first.

    Attributes:
        folder: The folder of the URDF, absolute and without `..`, or None for a URDF given as text.
        package_dirs: Folders given by the user: a package itself, or a folder that holds packages.
    """

    folder: Path | None
    package_dirs: tuple[Path, ...] = ()

    @classmethod
    def of(cls, folder: Path | None, package_dirs: Sequence[str | Path]) -> Self:
        """The paths for a folder and package folders as a user writes them."""
        return cls(folder and _absolute(folder), tuple(_absolute(Path(given).expanduser()) for given in package_dirs))

    def resolve(self, name: str) -> Found:
        """The file of the mesh path `name`, or the reason why there is none.

        A file that is missing, lies behind a link that leads outside, or is of a kind that cannot be drawn raises no
        error, so that the kinematics still load.

        Raises:
            UrdfError: The path climbs out of its package by `..`.
        """
        scheme, _, rest = name.partition("://")
        if not rest:
            scheme, rest = "", name
        if len(name) > LONGEST_NAME:
            return _none(f"has {len(name)} characters; a path has at most {LONGEST_NAME}")
        if PurePosixPath(rest).suffix.lower() not in MESH_SUFFIXES:
            return _none(f"is none of {', '.join(MESH_SUFFIXES)}")
        try:
            if scheme in ("package", "model"):
                return self._in_package(name, rest)
            if scheme in ("", "file"):
                return self._in_folders(name, rest)
        except (OSError, RuntimeError, ValueError) as error:
            if isinstance(error, UrdfError):
                raise
            return _none(f"cannot be looked up: {error}")
        return _none(f"is a {scheme} address, which is never fetched")

    @cached_property
    def own_tree(self) -> Path | None:
        """The URDF's package: the nearest folder above with a package.xml, else its folder or that above `urdf/`."""
        if self.folder is None:
            return None
        for ancestor in (self.folder, *self.folder.parents):
            if _is_package(ancestor):
                return ancestor
        around, name = self.folder.parent, self.folder.name
        inside = name in SURE_FOLDERS or (name in CONVENTIONAL_FOLDERS and _holds_meshes(around))
        return around if inside and not is_shared(around) else self.folder

    @cached_property
    def _roots(self) -> dict[str, tuple[Path, ...]]:
        """The folders of the packages that have been asked for: a robot's meshes are mostly all in one."""
        return {}

    @cached_property
    def _real_folders(self) -> dict[Path, Path]:
        """The folders that have been looked into, with links resolved."""
        return {}

    def package(self, name: str) -> Path | None:
        """The folder of a package, or None."""
        return None if name in ("", ".", "..") or "/" in name else next(self._package_roots(name), None)

    # ------------------------------------------------------------------------------------------ package://
    def _in_package(self, name: str, rest: str) -> Found:
        package, _, inside = rest.lstrip("/").partition("/")
        if package in ("", ".", "..") or not inside.strip("/"):
            raise UrdfError(f"mesh path {_shown(name)} names no package: package://<package>/<path> is meant")
        found = None
        if package not in self._roots:
            self._roots[package] = tuple(dict.fromkeys(self._package_roots(package)))
        for root in self._roots[package]:
            path = _absolute(root / inside.lstrip("/"))
            if not path.is_relative_to(root):
                raise _climbs(name, root)
            found = self._checked(path, root)
            if found.path is not None:
                return found
        problem = self._why_none(package) if found is None else found.problem
        return _none(f"{problem}; give package_dirs= (--package-dir) to say where it is")

    def _package_roots(self, package: str) -> Iterator[Path]:
        """The folders that may be the package, none of them behind a link that leads to a forbidden place."""
        for given in self.package_dirs:
            if given.name == package:
                yield given
            if self._is_allowed(given / package):
                yield given / package
        for given in _ros_package_dirs():
            if given.name == package:
                yield given
            if _is_within(given / package, given) or _is_package(given / package):  # workspaces have links to packages
                yield given / package
        if self.folder is None:
            return
        if self._is_allowed(self.folder / package):
            yield self.folder / package
        for ancestor in (self.folder, *self.folder.parents):
            if ancestor.name == package and self._is_ours(ancestor):
                yield ancestor
            elif _is_package(ancestor / package) and _is_within(ancestor / package, ancestor):
                yield ancestor / package

    def _is_allowed(self, folder: Path) -> bool:
        """Whether it is a folder that, with links resolved, lies in the own tree or in a folder given by the user."""
        allowed = (*self.package_dirs, self.own_tree)
        return folder.is_dir() and any(_is_within(folder, each) for each in allowed if each is not None)

    def _is_ours(self, ancestor: Path) -> bool:
        """Whether a folder around the URDF, with the name of the package, is a package."""
        called_so = ancestor.name.endswith(PACKAGE_ENDINGS) and not is_shared(ancestor)
        return ancestor == self.own_tree or called_so or _is_package(ancestor)

    def _why_none(self, package: str) -> str:
        parents = () if self.folder is None else (self.folder, *self.folder.parents)
        called = next((ancestor for ancestor in parents if ancestor.name == package), None)
        if called is None:
            return f"no folder of package {_shown(package)} found"
        return f"{called} is called {_shown(package)} but is no package: it has no package.xml"

    # ------------------------------------------------------------------------------------------ other paths
    def _in_folders(self, name: str, rest: str) -> Found:
        own = self.own_tree
        absolute = PurePosixPath(rest).is_absolute()
        if self.folder is None and not absolute:
            return _none("is relative, but the URDF was given as text, in no folder")
        path = _absolute(Path(rest) if absolute or self.folder is None else self.folder / rest)
        roots = (*(() if own is None else (own,)), *self.package_dirs)
        root = next((root for root in roots if path.is_relative_to(root)), None)
        if root is not None:
            return self._checked(path, root)
        if absolute or own is None:
            return _none(f"is outside the robot's folders; {ALLOW}")
        if not _is_package(own):
            return _none(f"is outside {own}; {ALLOW}")
        raise _climbs(name, own)

    def _checked(self, path: Path, root: Path) -> Found:
        """The file, unless it is missing or behind a link that leads to a forbidden place."""
        if not path.is_file():
            return _none(f"not found at {path}")
        real = path.resolve() if path.is_symlink() else self._real_folder(path.parent) / path.name
        for allowed in dict.fromkeys((root, *self.package_dirs)):
            if real.is_relative_to(folder := self._real_folder(allowed)):
                return Found(real, folder)
        return _none(f"is a link that leads out of {root}; give package_dirs= to allow {real.parent}")

    def _real_folder(self, folder: Path) -> Path:
        if folder not in self._real_folders:
            self._real_folders[folder] = folder.resolve()
        return self._real_folders[folder]


def is_shared(folder: Path) -> bool:
    """Whether all kinds of files share a folder: the root and its direct children, homes, folders of temporary files.

    Such a folder is nobody's package, whatever lies in it.
    """
    real, home = folder.resolve(), os.path.expanduser("~")  # noqa: PTH111 (there may be no home)
    shared, homes = _shared_folders(home, tempfile.gettempdir())
    return len(real.parts) <= 2 or real in shared or real.parent == homes


@lru_cache(maxsize=8)
def _shared_folders(home: str, passing: str) -> tuple[frozenset[Path], Path]:
    """Folders that all kinds of files share, and the folder of homes."""
    at_home = Path(home).resolve()
    short_lived = [Path(each).resolve() for each in (passing, "/tmp", "/var/tmp", "/dev/shm")]
    above = (parent for each in short_lived for parent in each.parents)
    return frozenset({at_home, *at_home.parents, *short_lived, *above}), at_home.parent


def _is_package(folder: Path) -> bool:
    return (folder / "package.xml").is_file() and not is_shared(folder)


def _is_within(path: Path, folder: Path) -> bool:
    """Whether a path lies in a folder when all links are resolved."""
    return path.resolve().is_relative_to(folder.resolve())


def _holds_meshes(folder: Path) -> bool:
    return any((folder / name).is_dir() for name in MESH_FOLDERS)


def _none(problem: str) -> Found:
    return Found(None, None, cut(problem, 600))


def _absolute(path: Path) -> Path:
    """The path, absolute and without `..`; links are not resolved."""
    return Path(os.path.abspath(path))  # noqa: PTH100


def _climbs(name: str, root: Path) -> UrdfError:
    return UrdfError(f"mesh path {_shown(name)} climbs out of {root}; put the file inside, or {ALLOW}")


def _shown(name: str) -> str:
    return repr(cut(name, 200))


def _ros_package_dirs() -> Sequence[Path]:
    ros1 = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    ros2 = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [*(Path(folder) for folder in ros1 if folder), *(Path(prefix) / "share" for prefix in ros2 if prefix)]
