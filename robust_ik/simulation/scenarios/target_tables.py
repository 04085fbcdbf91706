"""Makes targets from plain tables: kind of path, start, speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.control.tasks import Circle, Keypoints, Line, Replay, Sinusoid, Turning, pose
from robust_ik.errors import InputError, listed, suggest

Maker = Callable[["Table"], Any]


class Table:
    """A table that is read key by key; it reports missing keys and keys that were not read."""

    def __init__(self, data: object, where: str, *, start: Array | None = None, unit: float = 1.0) -> None:
        """A table.

        Args:
            data: The table's data.
            where: Its name in messages.
            start: The tip's pose at the start, (4, 4).
            unit: Factor from the table's angles to rad.
        """
        if not isinstance(data, dict):
            raise InputError(f"{where} must be a table, got {data!r}")
        self.data, self.where, self.start, self.unit = data, where, start, unit
        self.read: set[str] = set()

    def get(self, key: str, default: Any = None) -> Any:
        """The value of a key, or the default."""
        self.read.add(key)
        return self.data.get(key, default)

    def need(self, key: str) -> Any:
        """The value of a key.

        Raises:
            InputError: The key is missing.
        """
        if key not in self.data:
            raise InputError(f"{self.where} needs {key!r}; it has: {listed(list(self.data))}")
        return self.get(key)

    def number(self, key: str, default: float | None = None) -> float:
        """A positive number, or the default."""
        value = self.need(key) if default is None else self.get(key, default)
        return checked_parameter(f"{self.where}.{key}", value, above=0)

    def array(self, key: str, shape: tuple[int | None, ...]) -> Array:
        """Numbers of this shape."""
        return as_array(self.need(key), f"{self.where}.{key}", shape)

    def angles(self, key: str, default: tuple[float, ...]) -> Array:
        """Three angles, in rad."""
        return as_array(self.get(key, default), f"{self.where}.{key}", (3,)) * self.unit

    def done(self) -> None:
        """Raises if some keys were not read.

        Raises:
            InputError: There are such keys.
        """
        for key in self.data:
            if key not in self.read:
                raise InputError(f"{self.where} has no use for {key!r}; {suggest(key, self.read)}")

    @property
    def begin(self) -> Array:
        """The start pose of a path: the one that is given, else the tip's at the start of the run."""
        if "position" in self.data:
            return pose(self.array("position", (3,)), self.angles("rpy", (0.0, 0.0, 0.0)))
        if self.start is None:
            raise InputError(f"{self.where} needs 'position': there is no start to begin at")
        return np.array(self.start)


def target(data: object, where: str, start: Array, unit: float) -> Any:
    """A path from a table with its kind: keypoints, line, arc, sinusoid, hold; for the kind twists a `Replay`.

    Args:
        data: The table.
        where: Its name in messages.
        start: The tip's pose at the start, (4, 4), where paths begin unless the table gives another position.
        unit: Factor from the table's angles to rad.

    Raises:
        InputError: There is no such kind, or a value is missing, unknown or not valid.
    """
    table = Table(data, where, start=start, unit=unit)
    kind = table.need("kind")
    if kind not in MAKERS:
        raise InputError(f"{where}: there is no kind {kind!r}; {suggest(str(kind), MAKERS)}")
    try:
        path = MAKERS[kind](table)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(where) else f"{where}: {text}") from error
    table.done()
    return path


def _keypoints(table: Table) -> Keypoints:
    positions = table.array("positions", (None, 3))
    turns = np.asarray(table.get("rpy", (0.0, 0.0, 0.0)), dtype=float) * table.unit
    each = np.broadcast_to(turns, (len(positions), 3))
    return Keypoints(np.array([pose(p, r) for p, r in zip(positions, each)]), table.number("seconds"))


def _hold(table: Table) -> Keypoints:
    return Keypoints(table.begin[None], table.number("seconds"))


def _line(table: Table) -> Line | Circle | Turning:
    return _turning(table, Line(table.begin, table.array("to", (3,)), table.number("speed")))


def _arc(table: Table) -> Line | Circle | Turning:
    centre, normal = table.array("centre", (3,)), table.array("normal", (3,))
    return _turning(table, Circle(table.begin, centre, normal, table.number("period"), table.number("turns", 1.0)))


def _turning(table: Table, path: Line | Circle) -> Line | Circle | Turning:
    """The path, with a turn to another orientation if one is given."""
    if table.get("to_rpy") is None:
        return path
    return Turning(path, pose((0, 0, 0), table.angles("to_rpy", (0.0, 0.0, 0.0)))[:3, :3])


def _sinusoid(table: Table) -> Sinusoid:
    return Sinusoid(table.begin, table.array("amplitude", (3,)), table.number("period"), table.number("swings", 1.0))


def _twists(table: Table) -> Replay:
    """The rows of a recording: seconds, then a twist."""
    samples = table.array("samples", (None, 7))
    if samples.ndim != 2:
        raise InputError(f"samples must be lines of seconds and a twist, (k, 7), got shape {samples.shape}")
    return Replay(samples[:, 0], samples[:, 1:])


MAKERS: Mapping[str, Maker] = {
    "keypoints": _keypoints,
    "hold": _hold,
    "line": _line,
    "arc": _arc,
    "sinusoid": _sinusoid,
    "twists": _twists,
}
