"""Scenarios that come with the package, by name: TOML files, and computed motions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType

from robust_ik.errors import RobotNotFoundError, suggest
from robust_ik.simulation.scenario import Scenario
from robust_ik.simulation.scenarios.scenario_toml import read_scenario

DATA = Path(str(files("robust_ik.simulation.scenarios"))) / "data"


@cache
def scenarios() -> Mapping[str, Path]:
    """The TOML file of every scenario that comes with the package, by name."""
    return MappingProxyType({path.stem: path for path in sorted(DATA.glob("*.toml"))})


def load_scenario(scenario: str | Path) -> Scenario:
    """A scenario by name or from a TOML file; for the format see `read_scenario`.

    Args:
        scenario: A name that `robust-ik compare --list` shows, or a path.

    Raises:
        RobotNotFoundError: There is no such name or file.
        LoadError: The file is no TOML, or its robot cannot be loaded.
        InputError: A key is unknown or missing, or a value is not valid.
    """
    name = str(scenario)
    if name in scenarios():
        return read_scenario(scenarios()[name])
    if name.lower().endswith(".toml"):
        return read_scenario(scenario)
    raise RobotNotFoundError(f"there is no scenario {name[:200]!r}; {suggest(name, scenarios())}")
