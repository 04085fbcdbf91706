"""Singularity-robust inverse kinematics for any robot arm, on Pinocchio.

Conventions: rad, m, s. Twists are (..., 6), linear rows first. The default reference of Jacobians is
LOCAL_WORLD_ALIGNED: the tool's point, the world's axes. Arrays take leading batch axes everywhere.

A public name is imported when it is first used, so that `import robust_ik` takes almost no time. The imports in
`__init__.pyi` list the names and the modules that they come from.
"""

import ast as _ast
from importlib import import_module as _import_module
from importlib.util import find_spec as _find_spec
from pathlib import Path as _Path


def _homes() -> dict[str, str]:
    """The module from which each public name is imported."""
    stub = _ast.parse(_Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [statement for statement in stub.body if isinstance(statement, _ast.ImportFrom)]
    return {alias.name: str(each.module) for each in imports for alias in each.names}


_HOMES = _homes()

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> object:
    """Imports a public name or a module of the package; from then on it is a plain attribute."""
    if name == "__version__":
        from importlib.metadata import version  # reads files, which takes longer than the rest of this module

        value: object = version("robust-ik")
    elif _HOMES.get(name, __name__) != __name__:
        value = getattr(_import_module(_HOMES[name]), name)
    elif name.startswith("_") or _find_spec(f"{__name__}.{name}") is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}", name=name, obj=_import_module(__name__))
    else:
        value = _import_module(f"{__name__}.{name}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """All names of the package, imported already or not."""
    return sorted({*globals(), *__all__})
