"""Checks at the public boundary: each returns the clean value or says in one sentence what was given and wanted."""

from __future__ import annotations

import math
import reprlib
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.errors import InputError

Array = NDArray[np.float64]

LEAST_PARAMETER, LARGEST_PARAMETER = 1e-100, 1e100
"""Parameters other than 0 lie between these in magnitude, so that their squares neither vanish nor overflow."""

RIGID_TOLERANCE = 1e-6
"""How far R Rᵀ may be from 1. Chosen: rotations written with seven digits pass, those with a scale do not."""
FEW = 16
"""Entries up to which Python is faster: 16 take it 1.1 µs, and NumPy 2.2; both take as long for 36."""


def as_array(value: ArrayLike, name: str, shape: tuple[int | None, ...], *, finite: bool = True) -> Array:
    """A finite float array whose trailing axes have the wanted shape.

    Args:
        value: What was given.
        name: What to call it in the message.
        shape: Trailing shape; None stands for any length.
        finite: False leaves that to something else to check.

    Raises:
        InputError: The value is not real numbers, has another shape, or holds NaN or infinity.
    """
    try:
        array = np.asarray(value)
    except Exception:  # whatever a stranger's __array__ raises
        array = np.asarray(None)
    if array.dtype.kind not in "biuf" or isinstance(value, np.ma.MaskedArray):
        raise InputError(f"{name} must be an array of real numbers, got {reprlib.repr(value)}")
    if array.dtype != np.float64:
        with np.errstate(over="ignore"):  # of longer numbers: infinite, then
            array = array.astype(float)
    wanted = array.ndim >= len(shape) and all(
        want is None or have == want for have, want in zip(array.shape[array.ndim - len(shape) :], shape)
    )
    if not wanted:
        pattern = ", ".join(["...", *("any" if length is None else str(length) for length in shape)])
        raise InputError(f"{name} must have shape ({pattern}), got {array.shape}")
    if finite and not np.isfinite(array).all():
        shown = np.array2string(array, threshold=8, precision=4)
        raise InputError(f"{name} must be finite, got NaN or infinity in {shown}")
    return array


def as_measures(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """`as_array` of numbers whose squares do not overflow: places, velocities, joint values.

    Raises:
        InputError: They are none, or larger than LARGEST_PARAMETER.
    """
    array = as_array(value, name, shape, finite=False)
    if not _is_measured(array):
        array = as_array(array, name, shape)  # tells NaN and infinity
        raise InputError(f"{name} must lie within ±{LARGEST_PARAMETER:g}, got {_shown(array)}")
    return array


def _is_measured(array: Array) -> bool:
    if array.size <= FEW:  # of so few numbers, Python's own comparisons are faster
        return all(-LARGEST_PARAMETER <= each <= LARGEST_PARAMETER for each in array.ravel().tolist())
    return bool(max(array.max(), -array.min()) <= LARGEST_PARAMETER)


def alone(array: Array, name: str, axes: int) -> Array:
    """The array, which must be one vector or one matrix: have so many axes and no others.

    Raises:
        InputError: There are several, or none.
    """
    if array.ndim != axes:
        what = "number" if axes == 0 else "vector" if axes == 1 else "matrix"
        raise InputError(f"{name} must be one {what}, got an array of shape {array.shape}")
    return array


def as_number(value: object, name: str) -> float:
    """A finite number, however small or large.

    Raises:
        InputError: It is none.
    """
    number = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if not isinstance(number, Real):
        raise InputError(f"{name} must be a number, got {reprlib.repr(value)}")
    if not math.isfinite(_as_float(number)):
        raise InputError(f"{name} must be finite, got {reprlib.repr(value)}")
    return _as_float(number)


def check_leading_axes(first: str, a: tuple[int, ...], second: str, b: tuple[int, ...]) -> None:
    """Refuses leading axes that do not broadcast against each other.

    Args:
        first: Name of the one array.
        a: Its leading shape.
        second: Name of the other array.
        b: Its leading shape.

    Raises:
        InputError: They do not.
    """
    try:
        np.broadcast_shapes(a, b)
    except ValueError:
        raise InputError(f"the leading axes of {first} {a} and {second} {b} do not broadcast") from None


def checked_parameter(
    name: str, value: object, *, above: float = -math.inf, below: float = math.inf, least: float = -math.inf
) -> float:
    """A finite number within its range.

    Args:
        name: What to call it in the message.
        value: What was given.
        above: It must be greater than this.
        below: It must be less than this.
        least: It must be at least this.

    Raises:
        InputError: It is no finite number, out of range, or too small or large to be squared.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    number = _as_float(value) if isinstance(value, Real) else math.nan
    if not (math.isfinite(number) and above < number < below and number >= least):
        conditions = [
            f"> {above:g}" if above > -math.inf else "",
            f"≥ {least:g}" if least > -math.inf else "",
            f"< {below:g}" if below < math.inf else "",
        ]
        wanted = " and ".join(condition for condition in conditions if condition) or "finite"
        raise InputError(f"{name} must be {wanted}, got {reprlib.repr(value)}")
    if number != 0 and not LEAST_PARAMETER <= abs(number) <= LARGEST_PARAMETER:
        span = f"{LEAST_PARAMETER:g} and {LARGEST_PARAMETER:g}"
        raise InputError(f"{name} must be 0 or between {span} in magnitude, got {value!r}")
    return number


def _as_float(value: Real) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def checked_cap(name: str, value: object) -> float:
    """A positive number, or infinity for no cap."""
    given = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
    return math.inf if isinstance(given, Real) and given == math.inf else checked_parameter(name, given, above=0)


def checked_rigid(value: ArrayLike, name: str) -> Array:
    """Homogeneous transforms that are rotations and translations up to RIGID_TOLERANCE, (..., 4, 4).

    Raises:
        InputError: They are not.
    """
    T = as_measures(value, name, (4, 4))
    R = T[..., :3, :3]
    error = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3))
    if (error > RIGID_TOLERANCE).any() or (np.linalg.det(R) < 0).any() or (T[..., 3, :] != [0, 0, 0, 1]).any():
        raise InputError(f"{name} must be rigid: a rotation, a translation and a last row 0 0 0 1, got {_shown(T)}")
    return T


def _shown(array: Array) -> str:
    return " ".join(np.array2string(array, threshold=8, precision=4, separator=", ").split())


def readonly(array: ArrayLike, dtype: Any = float) -> NDArray[Any]:
    """A copy that cannot be written to."""
    copy = np.array(array, dtype=dtype)
    copy.setflags(write=False)
    return copy
