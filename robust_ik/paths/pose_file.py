"""Poses from a CSV file; every error names the line."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Literal

import numpy as np

from robust_ik.checks import Array, checked_parameter
from robust_ik.errors import InputError, cut
from robust_ik.kinematics.rotation_vectors import rotations
from robust_ik.runtime.files import read_file

MOST_BYTES, MOST_POSES = 64_000_000, 100_000
"""Sizes beyond which a file is refused."""
NORM = 1e-2
"""How far a quaternion's length may be from 1; it is divided by its length."""
PLACES, QUATERNION, ANGLES = ("x", "y", "z"), ("qx", "qy", "qz", "qw"), ("roll", "pitch", "yaw")
UNITS = {"m": 1.0, "mm": 1e-3}


def read_poses(path: str | Path, *, unit: Literal["m", "mm"] = "m", longest_step: float = 1.0) -> Array:
    """Poses of a CSV file: one a line, with a header that names the columns.

    Columns x y z are needed; for rotations there are qx qy qz qw (a unit quaternion), or roll pitch yaw (rad, about the
    fixed axes x, y, z in this order). Other columns are left out. Commas, semicolons, tabs or spaces lie between; what
    follows # is a comment.

    Args:
        path: The file.
        unit: Of lengths, m or mm.
        longest_step: Positions that follow each other and are further apart are refused, m.

    Returns:
        Poses (p, 4, 4), or positions (p, 3) if there are no rotations; m.

    Raises:
        InputError: The file cannot be read, or a line is not what it should be; the line is named.
    """
    if not isinstance(unit, str) or unit not in UNITS:
        raise InputError(f"unit must be m or mm, got {cut(repr(unit), 40)}")
    checked_parameter("longest_step", longest_step, above=0)
    (first, header), *rest = _lines(path)
    names = [name.strip().strip('"').lower() for name in _split(header)]
    turning = _rotation_columns(names, first)
    columns = [names.index(name) for name in (*PLACES, *turning)]
    numbers = np.empty((len(rest), len(columns)))
    for row, (i, line) in enumerate(rest):
        cells = _split(line)
        if len(cells) != len(names):
            raise InputError(f"line {i}: {len(cells)} values, {len(names)} columns are named in line {first}")
        numbers[row] = [_number(cells[k], names[k], i) for k in columns]
    positions = UNITS[unit] * numbers[:, :3]
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    if (far := np.flatnonzero(steps > longest_step)).size:
        row = int(far[0])
        advice = "; if lengths are in mm, say unit='mm'" if unit == "m" else ""
        told = f"{steps[row]:.3g} m from the one before, more than {longest_step:.3g} m{advice}"
        raise InputError(f"line {rest[row + 1][0]}: the position is {told}")
    if not turning:
        return positions
    T = np.tile(np.eye(4), (len(rest), 1, 1))
    T[:, :3, 3] = positions
    if turning == ANGLES:
        x, y, z = (rotations(numbers[:, 3 + k, None] * np.eye(3)[k]) for k in range(3))
        T[:, :3, :3] = z @ y @ x
        return T
    sizes = np.linalg.norm(numbers[:, 3:], axis=1)
    if (wrong := np.flatnonzero(np.abs(sizes - 1) > NORM)).size:
        row = int(wrong[0])
        raise InputError(f"line {rest[row][0]}: the quaternion has length {sizes[row]:.4g}, not 1")
    v, w = numbers[:, 3:6] / sizes[:, None], numbers[:, 6:] / sizes[:, None]
    size = np.linalg.norm(v, axis=1, keepdims=True)
    T[:, :3, :3] = rotations(v * np.where(size > 0, 2 * np.arctan2(size, w) / np.where(size > 0, size, 1.0), 0.0))
    return T


def _lines(path: str | Path) -> list[tuple[int, str]]:
    """Lines that say something, with their numbers: the names of the columns, and at least one pose."""
    _, content = read_file(path, MOST_BYTES)
    text = content.decode("utf-8-sig", "replace").splitlines()
    lines = [(i, line) for i, each in enumerate(text, 1) if (line := each.split("#", 1)[0].strip())]
    if len(lines) < 2:
        raise InputError(f"{cut(str(path), 200)} has no poses: a line that names columns and one a pose are needed")
    if len(lines) > MOST_POSES + 1:
        raise InputError(f"{cut(str(path), 200)} has {len(lines) - 1} poses, at most {MOST_POSES} are read")
    return lines


def _split(line: str) -> list[str]:
    mark = next((mark for mark in (";", ",", "\t") if mark in line), None)
    return line.split(mark) if mark else re.split(r"\s+", line)


def _rotation_columns(names: list[str], line: int) -> tuple[str, ...]:
    """The columns that hold rotations, empty if there are none."""
    shown = cut(", ".join(names), 200)
    twice = next((name for name in (*PLACES, *QUATERNION, *ANGLES) if names.count(name) > 1), None)
    if twice:
        raise InputError(f"line {line}: column {twice} is named twice, among {shown}")
    for wanted in (PLACES, QUATERNION, ANGLES):
        missing = [name for name in wanted if name not in names]
        if missing and (wanted is PLACES or len(missing) < len(wanted)):
            raise InputError(f"line {line}: no column {' '.join(missing)} among {shown}")
    return QUATERNION if QUATERNION[0] in names else ANGLES if ANGLES[0] in names else ()


def _number(cell: str, name: str, line: int) -> float:
    try:
        value = float(cell)
    except ValueError:
        raise InputError(f"line {line}: {name} must be a number, got {cut(cell.strip(), 40)!r}") from None
    if not math.isfinite(value):
        raise InputError(f"line {line}: {name} must be finite, got {cell.strip()}")
    return value
