"""Reads and writes DH tables as TOML files."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.description.dh.dh_table import DHJoint, DHTable, checked_numbers, checked_rigid, screw, shown
from robust_ik.description.toml_size_limits import read_toml
from robust_ik.errors import DHError, suggest
from robust_ik.runtime.files import read_file

MAX_BYTES, MAX_LINE = 200_000, 2_000
"""Most bytes of a file (a hundred joints take a tenth) and of a line: time grows with the square of dotted keys."""


def read_dh(path: str | Path) -> DHTable:
    """A table from a TOML file; for the format see `table_from_toml`.

    Args:
        path: The file; its stem is the arm's name if the file states none.

    Raises:
        RobotNotFoundError: There is no such file.
        LoadError: It cannot be read, or has over 200 kB.
        DHError: As for `table_from_toml`.
    """
    full, data = read_file(path, MAX_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DHError(f"{path}: not UTF-8 text: {error.reason} at byte {error.start}") from error
    return table_from_toml(text, source=str(path), name=full.stem)


def table_from_toml(text: str, *, source: str = "DH text", name: str = "robot") -> DHTable:
    """A table from TOML text.

    ```toml
    name = "wrist"                  # may be left out
    convention = "modified"         # or "standard"
    angles = "deg"                  # or "rad": for all angles, also of limits and speeds
    rows = ["wx", "wy", "wz"]       # task rows; default all six
    rest = [0, 45, 0]               # may be left out

    [base]                          # likewise [tool]; may be left out
    xyz = [0, 0, 0.5]               # m
    rpy = [0, 0, 90]                # Rz(yaw) Ry(pitch) Rx(roll) as in a URDF; or matrix = 4x4 numbers

    [[joint]]                       # or all rows at once: joint = [{ a = 0, d = 0, alpha = 0 }, ...]
    a = 0                           # a, d and alpha must be there
    d = 0
    alpha = 0
    theta = 0                       # constant part; may be left out, as may all below
    type = "revolute"               # or "prismatic", which must state lower and upper
    lower = -170
    upper = 170
    velocity = 120
    name = "roll"
    ```

    Args:
        text: The text.
        source: What to call it in messages.
        name: The arm's name if the text has none.

    Raises:
        DHError: The text is no TOML (the message says where), or has unknown keys or values that are not valid.
    """
    try:
        return DHTable(**_fields({"name": name, **_toml(text)}))
    except DHError as error:
        raise DHError(f"{source}: {error}") from error


def table_to_toml(table: DHTable) -> str:
    """The table as TOML text, in radians; `table_from_toml` reads back the same numbers."""
    quote = _quoted
    lines = [f"name = {quote(table.name)}", f"convention = {quote(table.convention)}", 'angles = "rad"']
    lines.append(f"rows = [{', '.join(map(quote, table.rows))}]")
    if table.rest is not None:
        lines.append(f"rest = {table.rest.tolist()}")
    lines += ["joint = [", *(f"  {_inline(joint)}," for joint in table.joints), "]"]
    for key, pose in (("base", table.base), ("tool", table.tool)):
        if not np.array_equal(pose, np.eye(4)):
            lines += ["", f"[{key}]", "matrix = [", *(f"  {row}," for row in pose.tolist()), "]"]
    return "\n".join(lines) + "\n"


_TABLE_KEYS = ("name", "convention", "angles", "rows", "rest", "joint", "base", "tool")
_JOINT_KEYS = ("a", "d", "alpha", "theta", "type", "lower", "upper", "velocity", "name")
_POSE_KEYS = ("xyz", "rpy", "matrix")


def _toml(text: str) -> dict[str, Any]:
    if len(text) > MAX_BYTES:
        raise DHError(f"it has {len(text)} characters; a DH table of over {MAX_BYTES} is refused")
    if max(map(len, text.splitlines()), default=0) > MAX_LINE:
        raise DHError(f"it has a line of over {MAX_LINE} characters")
    try:
        return read_toml(text)
    except ValueError as error:  # also tomllib's own error, which says where
        raise DHError(f"not valid TOML: {error}") from error


def _fields(data: dict[str, Any]) -> dict[str, Any]:
    """The arguments of DHTable, in radians.

    A table is first made of the numbers as written, so that messages quote those; the checks do not depend on
    the unit of angles.
    """
    _check_keys(data, _TABLE_KEYS, ("convention", "angles", "joint"), "the table")
    degrees = _in_degrees(data["angles"])
    entries = data["joint"]
    if not isinstance(entries, list):
        raise DHError(f"joint must be a list of tables, [[joint]], got {shown(entries)}")
    result: dict[str, Any] = {key: data[key] for key in ("name", "convention", "rows", "rest") if key in data}
    result["joints"] = [_joint(entry, f"joint{i}") for i, entry in enumerate(entries, start=1)]
    for key in ("base", "tool"):
        if key in data:
            result[key] = _pose(data[key], key, degrees)
    if not degrees:
        _ask_about_degrees(result["joints"])
    if degrees:
        as_written = DHTable(**result)
        result["joints"] = [_from_degrees(joint) for joint in as_written.joints]
        if as_written.rest is not None:
            result["rest"] = np.where(as_written.revolute, _radians(as_written.rest), as_written.rest)
    return result


def _ask_about_degrees(joints: list[DHJoint]) -> None:
    for joint in joints:
        for key in ("alpha", "theta"):
            if abs(getattr(joint, key)) > 4 * math.pi:
                value = getattr(joint, key)
                raise DHError(
                    f'joint {joint.name!r} has {key} = {value:g} rad: over two turns; is angles = "deg" meant?'
                )


def _in_degrees(angles: object) -> bool:
    if angles not in ("deg", "rad"):
        raise DHError(f"angles must be 'deg' or 'rad', got {shown(angles)}")
    return angles == "deg"


def _joint(entry: object, default_name: str) -> DHJoint:
    if not isinstance(entry, dict):
        raise DHError(f"{default_name} must be a table with a, d and alpha, got {shown(entry)}")
    _check_keys(entry, _JOINT_KEYS, ("a", "d", "alpha"), f"joint {entry.get('name', default_name)!r}")
    values = {"kind" if key == "type" else key: value for key, value in entry.items()}
    return DHJoint(**{"name": default_name, **values})


def _pose(entry: object, what: str, degrees: bool) -> Array:
    if not isinstance(entry, dict):
        raise DHError(f"{what} must be a table with xyz and rpy, or matrix, got {shown(entry)}")
    _check_keys(entry, _POSE_KEYS, (), what)
    if "matrix" in entry:
        if len(entry) > 1:
            raise DHError(f"{what} has matrix and also xyz or rpy; give one of them")
        return checked_rigid(entry["matrix"], what)
    x, y, z = checked_numbers(entry.get("xyz", (0, 0, 0)), f"{what}.xyz", (3,)).tolist()
    angles = checked_numbers(entry.get("rpy", (0, 0, 0)), f"{what}.rpy", (3,))
    roll, pitch, yaw = _radians(angles) if degrees else angles
    place = screw(0, 0.0, x) @ screw(1, 0.0, y) @ screw(2, 0.0, z)
    return place @ screw(2, yaw, 0.0) @ screw(1, pitch, 0.0) @ screw(0, roll, 0.0)


def _from_degrees(joint: DHJoint) -> DHJoint:
    limits = ("lower", "upper", "velocity") if joint.kind == "revolute" else ()
    given = {key: getattr(joint, key) for key in ("alpha", "theta", *limits)}
    angles: dict[str, Any] = {key: math.radians(value) for key, value in given.items() if value is not None}
    return replace(joint, **angles)


def _radians(angles: Array) -> Array:
    # math.radians(90) is π/2 to the last bit; so is every multiple of 45°
    return np.array([math.radians(angle) for angle in angles])


def _check_keys(entry: dict[str, Any], known: tuple[str, ...], needed: tuple[str, ...], what: str) -> None:
    for key in entry:
        if key not in known:
            raise DHError(f"{what} has an unknown key {shown(key)}; {suggest(key, known)}")
    for key in needed:
        if key not in entry:
            raise DHError(f"{what} has no {key!r}; it must state {', '.join(needed)}")


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _inline(joint: DHJoint) -> str:
    """One row as a TOML inline table; repr writes every digit of a float."""
    items = {"name": _quoted(joint.name), "type": _quoted(joint.kind)}
    numbers = {key: getattr(joint, key) for key in _JOINT_KEYS if key not in ("name", "type")}
    items |= {key: repr(number) for key, number in numbers.items() if number is not None}
    return "{ " + ", ".join(f"{key} = {text}" for key, text in items.items()) + " }"
