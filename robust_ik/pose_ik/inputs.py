"""Converts targets and initial configurations to arrays for kernels."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import NoReturn, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_rigid
from robust_ik.errors import InputError
from robust_ik.kinematics.twist_rows import ROWS

POSITIONS = ROWS[:3]
IDENTITY = np.eye(4)
"""The pose that a position is put into."""
FARTHEST = 1e9
"""Positions and joint values beyond this are refused, in units of length or rad."""


def wanted_rows(
    target: ArrayLike, rows: Sequence[str] | None, default: tuple[str, ...], *, many: bool = False
) -> Sequence[str] | None:
    """The wanted rows of a target, None for the default ones; for a position only position rows.

    Raises:
        InputError: Rows of rotation are asked for a position.
    """
    try:
        shape = np.shape(target)
    except ValueError:  # ragged, refused later
        return rows
    if (shape != (3,) and not many) or shape[-1:] != (3,):
        return rows
    if rows is None:
        return tuple(row for row in default if row in POSITIONS) or POSITIONS
    if any(row not in POSITIONS for row in rows):
        raise InputError(f"rows of a position must be some of {' '.join(POSITIONS)}, got {reprlib.repr(rows)}")
    return rows


def as_pose(target: ArrayLike) -> Array:
    """A pose (4, 4) or a position (3,) as (4, 4); the kernel checks its numbers."""
    if type(target) is np.ndarray and target.shape == (4, 4):
        return target
    T = plain(target, "target")
    if T.shape == (3,):
        return _with_position(T)
    if T.shape != (4, 4):
        raise InputError(
            f"target must be a pose (4, 4) or a position (3,), got shape {T.shape}; solve_poses takes many targets"
        )
    return T


def as_start(q0: ArrayLike, rest: Array) -> Array:
    """One configuration (nq,); the kernel checks its numbers."""
    if type(q0) is np.ndarray and q0.shape == rest.shape:
        return q0
    q = plain(q0, "q0")
    as_array(q, "q0", rest.shape)
    if q.ndim != 1:
        raise InputError(f"q0 must be one configuration ({len(rest)},), got shape {q.shape}")
    return q


def is_position(target: object) -> bool:
    """Whether a list or an array looks like a position (3,)."""
    return getattr(target, "shape", None) == (3,) or (type(target) is list and len(target) == 3)


def is_plain_pose(target: object) -> TypeGuard[Array]:
    """Whether it is a C-contiguous array (4, 4) of doubles, whatever numbers it holds."""
    if type(target) is not np.ndarray or target.shape != (4, 4):
        return False
    return target.dtype == np.float64 and bool(target.flags.c_contiguous)


def quick_pose(target: object, position: bool) -> Array | None:
    """A list or an array as a pose (4, 4) for kernels, which check its numbers; None if it is another one.

    Args:
        target: What was given.
        position: Whether a position (3,) is wanted too.
    """
    if type(target) is not np.ndarray and type(target) is not list:
        return None
    try:
        array = np.asarray(target)
    except ValueError:  # ragged
        return None
    if array.dtype.kind not in "fiu":
        return None
    if array.shape == (4, 4):
        return np.array(array, dtype=float, order="C")
    if not position or array.shape != (3,):
        return None
    T = IDENTITY.copy()
    T[:3, 3] = array
    return T


def plain(value: ArrayLike, name: str) -> Array:
    """A C-contiguous copy, of doubles."""
    return np.array(as_array(value, name, ()), dtype=float, order="C")


def as_poses(targets: ArrayLike, unit: float = 1.0) -> Array:
    """Poses (..., 4, 4) or positions (..., 3) as rigid poses, (..., 4, 4), checked.

    Args:
        targets: Poses or positions.
        unit: Positions beyond FARTHEST times this, m, are refused.
    """
    T = as_array(targets, "targets", ())
    if T.ndim and T.shape[-1] == 3:
        T = _with_position(T)
    elif T.shape[-2:] != (4, 4):
        raise InputError(f"targets must be poses (..., 4, 4) or positions (..., 3), got shape {T.shape}")
    rigid = checked_rigid(T, "targets")
    check_far(rigid[..., :3, 3], "targets", unit)
    return rigid


def as_starts(q0: ArrayLike, rest: Array) -> Array:
    """Configurations (..., nq), checked."""
    return check_far(as_array(q0, "q0", rest.shape), "q0")


def check_far(array: Array, name: str, unit: float = 1.0) -> Array:
    """Refuses numbers whose squares have lost all precision."""
    farthest = FARTHEST * unit
    if (np.abs(array) > farthest).any():
        raise InputError(f"{name} must lie within {farthest:g} m or rad, got {np.abs(array).max():g}")
    return array


def is_near(array: Array, unit: float = 1.0) -> bool:
    """Whether an array is of doubles, none of which `check_far` would refuse or is no number."""
    return array.dtype == float and bool((np.abs(array) <= FARTHEST * unit).all())


def _with_position(p: Array) -> Array:
    T = np.broadcast_to(np.eye(4), (*p.shape[:-1], 4, 4)).copy()
    T[..., :3, 3] = p
    return T


def refuse(target: Array, q0: Array, rest: Array, unit: float = 1.0) -> NoReturn:
    """Raises the error for a target or q0 that the kernel refused."""
    check_far(checked_rigid(target, "target")[:3, 3], "target", unit)
    check_far(as_array(q0, "q0", rest.shape), "q0")
    raise InputError("q0 must hold cosine and sine of continuous joints, of length 1; Robot.configuration makes them")
