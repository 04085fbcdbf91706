"""Converts rotations of URDF 1.1, written as quaternions, to angles, which every reader understands."""

from __future__ import annotations

import math
import re
from typing import Any

from robust_ik.description.notes import Notes, named
from robust_ik.description.urdf.urdf_numbers import numbers, shown
from robust_ik.errors import UrdfError

KNOWN = ("1.0", "1.1", "1.2")


def write_rotations(root: Any, notes: Notes) -> None:
    """Writes `quat_xyzw` of origins as `rpy`, in files of a version that has it, and removes the version.

    Raises:
        UrdfError: A joint's quaternion cannot be read, or stands beside angles.
    """
    version = str(root.attrib.pop("version", "1.0")).strip()
    if version not in KNOWN:
        notes.add(f"URDF version {shown(version)} is not known: it is read as {KNOWN[-1]}")
    has = version not in ("1.0", "1") and re.fullmatch(r"1\.0+", version) is None
    for path in ("joint/origin", "link/*/origin"):
        for origin in root.iterfind(path):
            if (text := origin.attrib.pop("quat_xyzw", None)) is not None:
                owner = next(origin.iterancestors("joint", "link"))
                name = named(owner.tag, owner.get("name"))
                if has:
                    _write_angles(origin, text, name, owner.tag == "joint")
                else:
                    notes.add('has an <origin> with quat_xyzw, which <robot version="1.1"> would make count', name)


def _write_angles(origin: Any, text: str, name: str, needed: bool) -> None:
    found = numbers(text)
    readable = found is not None and len(found) == 4 and math.hypot(*found) > 0 and origin.get("rpy") is None
    if found is not None and readable:
        origin.set("rpy", " ".join(map(repr, _angles(*found))))
    elif needed:
        raise UrdfError(
            f"line {origin.sourceline}: <origin quat_xyzw={shown(text)}> must hold 4 finite numbers, not all zero, "
            f"without rpy beside them (in {name})"
        )
    else:
        origin.set("rpy", text)  # not three numbers, so that the shape is left out


def _angles(x: float, y: float, z: float, w: float) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a quaternion of any length."""
    length = math.hypot(x, y, z, w)
    x, y, z, w = x / length, y / length, z / length, w / length
    first, second, third = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    flat = math.hypot(first, second)
    if flat < 1e-12:  # pitch of ±90°: only the difference of roll and yaw counts
        return 0.0, math.atan2(-third, flat), math.atan2(-2 * (x * y - w * z), 1 - 2 * (x * x + z * z))
    roll = math.atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    return roll, math.atan2(-third, flat), math.atan2(second, first)
