"""Methods of the benchmark by name, or from a Python file that defines inverses."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from robust_ik.errors import InputError, RobustIKError, suggest
from robust_ik.inverses import CLASSES, RobustInverse, Weighted
from robust_ik.inverses.baselines import BASELINES
from robust_ik.simulation.robustness.benchmark_methods import (
    BenchmarkMethod,
    ControllerMethod,
    InverseMethod,
    documented,
)

CONTROLLER = "VelocityController"
"""The name of a controller with its defaults."""


def known_methods() -> dict[str, BenchmarkMethod]:
    """Every inverse of the package, baselines, and a controller with its defaults, by name."""
    kinds = [each for each in (*CLASSES, *BASELINES) if each is not Weighted]
    return {each.__name__: documented(each) for each in kinds} | {CONTROLLER: ControllerMethod(lambda _: None)}


def chosen_methods(names: Sequence[str]) -> dict[str, BenchmarkMethod]:
    """Methods by name, ignoring case; a name that ends in .py is a file with inverses.

    Raises:
        InputError: There is no such method, or the file defines none.
    """
    known = known_methods()
    found: dict[str, BenchmarkMethod] = {}
    for name in names:
        if name.endswith(".py"):
            found |= methods_of_file(Path(name))
            continue
        match = next((each for each in known if each.lower() == name.lower()), None)
        if match is None:
            raise InputError(f"there is no method {name!r}; {suggest(name, known)}; a file of yours ends in .py")
        found[match] = known[match]
    return found


def methods_of_file(path: Path) -> dict[str, BenchmarkMethod]:
    """The inverses that a Python file defines: instances by their names, classes that are made without arguments.

    Args:
        path: The file. It is run.

    Raises:
        InputError: It is not there, cannot be run, or defines no inverse.
    """
    module = _run(path)
    found: dict[str, BenchmarkMethod] = {}
    for name, value in vars(module).items():
        if name.startswith("_"):
            continue
        if isinstance(value, RobustInverse):
            found[name] = InverseMethod.of(value)
        elif inspect.isclass(value) and issubclass(value, RobustInverse) and value.__module__ == module.__name__:
            found[name] = InverseMethod.of(_made(value, path))
    if not found:
        raise InputError(
            f"{path} defines no inverse: it needs a class that derives from rik.RobustInverse or "
            "rik.SingularValueFilter, or an instance, such as mine = rik.JParse(0.05)"
        )
    return found


def _run(path: Path) -> ModuleType:
    """The module that a file makes."""
    given = path.expanduser()
    if not given.is_file():
        raise InputError(f"there is no file {path}")
    name = f"robust_ik_method_{given.stem}"
    spec = importlib.util.spec_from_file_location(name, given)
    if spec is None or spec.loader is None:
        raise InputError(f"{path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up there
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # a file of somebody else's may raise anything
        del sys.modules[name]
        raise InputError(f"{path} cannot be run: {type(error).__name__}: {error}") from error
    return module


def _made(kind: type[RobustInverse], path: Path) -> RobustInverse:
    try:
        return kind()
    except (TypeError, RobustIKError) as error:
        raise InputError(f"{path}: {kind.__name__} cannot be made without arguments: {error}") from error
