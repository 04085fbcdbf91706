"""Checks of what a DH table is given: each returns the clean value or says in one sentence what is wrong."""

from __future__ import annotations

import math
import reprlib
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, readonly
from robust_ik.errors import DHError, InputError
from robust_ik.kinematics.svd import svd

LARGEST = 1e6  # of lengths and angles as written; far below where products overflow
KEPT, SNAPPED = 1e-14, 1e-6  # a rotation this near to an exact one is kept as it is, is made exact


def shown(value: object) -> str:
    """The value as a message quotes it."""
    return reprlib.repr(value)


def checked_number(value: object, what: str) -> float:
    """One finite number."""
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    except OverflowError:
        number = math.inf
    if not abs(number) <= LARGEST:
        raise DHError(f"{what} must be a finite number of at most {LARGEST:g}, got {shown(value)}")
    return number


def checked_numbers(value: ArrayLike, what: str, shape: tuple[int, ...]) -> Array:
    """Finite numbers of exactly that shape."""
    try:
        array = as_array(value, what, shape)
    except InputError as error:
        raise DHError(str(error)) from None
    if array.ndim != len(shape):
        raise DHError(f"{what} must have shape {shape}, got {array.shape}")
    if any(isinstance(item, bool) or not isinstance(item, Real) for item in np.asarray(value, dtype=object).flat):
        raise DHError(f"{what} must hold numbers, got {shown(value)}")
    if not (np.abs(array) <= LARGEST).all():
        raise DHError(f"{what} must hold numbers of at most {LARGEST:g}, got {shown(array.tolist())}")
    return array


def checked_name(value: object, what: str) -> str:
    """Printable text."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise DHError(f"{what} must be printable text, got {shown(value)}")
    return value


def checked_rigid(value: ArrayLike, what: str) -> Array:
    """A read-only pose; a rotation off by rounding is replaced by the nearest exact one."""
    pose = checked_numbers(value, what, (4, 4)).copy()
    rotation = pose[:3, :3]
    error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if error > SNAPPED or np.linalg.det(rotation) < 0 or not np.array_equal(pose[3], [0, 0, 0, 1]):
        given = shown(pose.tolist())
        raise DHError(f"{what} must be a rotation and a translation with last row 0 0 0 1, got {given}")
    if error > KEPT:
        nearest = svd(rotation)
        pose[:3, :3] = nearest.U @ nearest.Vt
    return readonly(pose)
