"""Imports yourdfpy's module of URDF in one place, without what only its scenes and meshes need.

yourdfpy imports trimesh at its top, and trimesh imports SciPy and networkx. To read and write a URDF, yourdfpy needs
`trimesh.transformations` alone, which is plain NumPy. So its file is executed as a module of another name, in which
`import trimesh` gives a package of another name, too: that one finds trimesh's modules, but executes none that nobody
asks for. Nothing called yourdfpy or trimesh is imported, replaced or changed: who imports them, before or after, gets
the whole ones.

`urdf` is that module, or `yourdfpy.urdf` itself if trimesh is imported already or if this way fails.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import find_spec, module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

YOURDFPY, TRIMESH = "robust_ik_yourdfpy", "robust_ik_trimesh"
"""Names of the module and of the package in `sys.modules`."""

__all__ = ["urdf"]


def _imported() -> Any:
    try:
        if "trimesh" not in sys.modules:
            return _module(_package())
    except Exception:  # another version of yourdfpy, of trimesh or of Python may need anything
        sys.modules.pop(YOURDFPY, None)
    from yourdfpy import urdf

    return urdf


def _package() -> ModuleType:
    """A package that has trimesh's folder, so that its modules can be imported, but none of its names."""
    spec = ModuleSpec(TRIMESH, None, is_package=True)
    spec.submodule_search_locations = [str(_folder("trimesh"))]
    sys.modules[TRIMESH] = package = module_from_spec(spec)
    return package


def _module(trimesh: ModuleType) -> ModuleType:
    """Yourdfpy's file executed as a module, with a package in the place of trimesh."""
    loader = SourceFileLoader(YOURDFPY, str(_folder("yourdfpy") / "urdf.py"))
    spec = spec_from_loader(YOURDFPY, loader)
    assert spec is not None
    sys.modules[YOURDFPY] = module = module_from_spec(spec)
    vars(module)["__builtins__"] = vars(builtins) | {"__import__": _import_from(trimesh)}
    _find_names(trimesh, "trimesh.{}".format)  # annotations are executed, and a type may be written as text there
    loader.exec_module(module)
    _find_names(trimesh, lambda name: getattr(import_module("trimesh"), name))
    return module


def _folder(package: str) -> Path:
    """The folder of a package, which is not imported."""
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ImportError(f"{package} is no package in a folder", name=package)
    return Path(spec.submodule_search_locations[0])


def _import_from(trimesh: ModuleType) -> Callable[..., ModuleType]:
    """What the statement `import` calls: as ever, but with a package in the place of trimesh."""

    def imported(
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        if level == 0 and name.split(".")[0] == "trimesh":
            name = name.replace("trimesh", trimesh.__name__, 1)
        return __import__(name, globals, locals, fromlist or (), level)

    return imported


def _find_names(package: ModuleType, find: Callable[[str], object]) -> None:
    """Lets a function find the names that a package does not have, except for those that Python looks up by itself."""

    def found(name: str) -> object:
        if name.startswith("__"):
            raise AttributeError(f"module {package.__name__!r} has no attribute {name!r}", name=name, obj=package)
        return find(name)

    vars(package)["__getattr__"] = found


urdf: Any = _imported()
