"""Checks of public arguments: each returns the clean value, or says in one sentence what was given and wanted."""

from __future__ import annotations

import math
import reprlib
from numbers import Real
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.errors import InputError

Array = NDArray[np.float64]

LEAST_PARAMETER, LARGEST_PARAMETER = 1e-100, 1e100
"""Parameters other than 0 must lie between these in magnitude, so that their squares neither vanish nor overflow."""

RIGID_TOLERANCE = 1e-6
"""Largest entry of |R Rᵀ − 1|. Chosen: rotations written with seven digits pass, those with a scale do not."""
FEW = 16
"""Most entries that are checked in Python: 16 take 1.1 µs there and 2.2 µs in NumPy; at 36 both take as long."""


def as_array(value: ArrayLike, name: str, shape: tuple[int | None, ...], *, finite: bool = True) -> Array:
    """A finite float array whose trailing axes have the wanted shape.

    Args:
        value: What was given.
        name: What to call it in the message.
        shape: Trailing shape; None stands for any length.
        finite: False accepts NaN and infinity; the caller then checks for them.

    Raises:
        InputError: The value is not real numbers, has another shape, or holds NaN or infinity.
    """
    plain = type(value) is np.ndarray and value.dtype == np.float64 and value.shape[value.ndim - len(shape) :] == shape
    if plain and (not finite or np.isfinite(value).all()):
        return np.asarray(value)
    try:
        array = np.asarray(value)
    except Exception:  # a foreign __array__ may raise anything
        array = np.asarray(None)
    if array.dtype.kind not in "biuf" or is_masked(value):
        raise InputError(f"{name} must be an array of real numbers, got {reprlib.repr(value)}")
    if array.dtype != np.float64:
        with np.errstate(over="ignore"):  # longer floats may overflow to infinity, which is refused below
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


def is_masked(value: object) -> bool:
    """Whether it is a masked array; asking about anything else does not import numpy.ma."""
    return isinstance(value, np.ndarray) and type(value) is not np.ndarray and isinstance(value, np.ma.MaskedArray)


def as_measures(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """`as_array` for positions, velocities and joint values, whose squares must not overflow.

    Raises:
        InputError: As for `as_array`, or a value is larger than LARGEST_PARAMETER.
    """
    if type(value) is np.ndarray and value.dtype == np.float64 and value.shape == shape and _is_measured(value):
        return value
    array = as_array(value, name, shape, finite=False)
    if not _is_measured(array):
        array = as_array(array, name, shape)  # raises for NaN and infinity
        raise InputError(f"{name} must lie within ±{LARGEST_PARAMETER:g}, got {_shown(array)}")
    return array


def _is_measured(array: Array) -> bool:
    if array.size <= FEW:  # for so few numbers Python's own comparisons are faster
        return all(-LARGEST_PARAMETER <= each <= LARGEST_PARAMETER for each in array.ravel().tolist())
    return bool(max(array.max(), -array.min()) <= LARGEST_PARAMETER)


def alone(array: Array, name: str, axes: int) -> Array:
    """The array, if it is one number, vector or matrix: if it has exactly `axes` axes.

    Raises:
        InputError: It has more or fewer axes.
    """
    if array.ndim != axes:
        what = "number" if axes == 0 else "vector" if axes == 1 else "matrix"
        raise InputError(f"{name} must be one {what}, got an array of shape {array.shape}")
    return array


def as_number(value: object, name: str) -> float:
    """A finite number, however small or large.

    Raises:
        InputError: It is not a finite number.
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
        InputError: They do not broadcast.
    """
    if a == b:
        return
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
        InputError: It is not a finite number, is out of range, or is too small or large to be squared.
    """
    if type(value) is float and max(LEAST_PARAMETER, least) <= value <= LARGEST_PARAMETER and above < value < below:
        return value
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    number = _as_float(value) if isinstance(value, Real) else math.nan
    if not (math.isfinite(number) and above < number < below and number >= least):
        conditions = [
            f"> {above:g}" if above > -math.inf else "",
            f"≥ {least:g}" if least > -math.inf else "",
            f"< {below:g}" if below < math.inf else "",
        ]
        finite = "finite" if isinstance(value, Real) else "one finite number"
        wanted = " and ".join(condition for condition in conditions if condition) or finite
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
    """A positive number; infinity means no cap."""
    if type(value) is float and value == math.inf:
        return value
    given = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
    return math.inf if isinstance(given, Real) and given == math.inf else checked_parameter(name, given, above=0)


def checked_rigid(value: ArrayLike, name: str) -> Array:
    """Homogeneous transforms (..., 4, 4), checked to be rotations and translations up to RIGID_TOLERANCE.

    Raises:
        InputError: They are not.
    """
    T = as_measures(value, name, (4, 4))
    if T.ndim == 2 and _is_rigid(T):  # in a loop a new task may be made at every step
        return T
    R = T[..., :3, :3]
    error = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3))
    if (error > RIGID_TOLERANCE).any() or (np.linalg.det(R) < 0).any() or (T[..., 3, :] != [0, 0, 0, 1]).any():
        raise InputError(f"{name} must be rigid: a rotation, a translation and a last row 0 0 0 1, got {_shown(T)}")
    return T


def _is_rigid(T: Array) -> bool:
    """Whether one pose is rigid: for so few numbers Python is faster than NumPy."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _), last = T.tolist()
    squares = max(abs(a * a + b * b + c * c - 1), abs(d * d + e * e + f * f - 1), abs(g * g + h * h + i * i - 1))
    angles = max(abs(a * d + b * e + c * f), abs(a * g + b * h + c * i), abs(d * g + e * h + f * i))
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return bool(max(squares, angles) <= RIGID_TOLERANCE and determinant > 0 and last == [0.0, 0.0, 0.0, 1.0])


def _shown(array: Array) -> str:
    return " ".join(np.array2string(array, threshold=8, precision=4, separator=", ").split())


def readonly(array: ArrayLike, dtype: Any = float) -> NDArray[Any]:
    """A read-only copy."""
    copy = np.array(array, dtype=dtype)
    copy.setflags(write=False)
    return copy


def checked_out(out: Any, shape: tuple[int, ...]) -> Array:
    """An array for a result.

    Raises:
        InputError: It is no writable, contiguous, aligned array of doubles of this shape.
    """
    good = isinstance(out, np.ndarray) and out.dtype == np.float64 and out.shape == shape
    if not (good and out.flags.carray):
        what = f"{out.dtype} of shape {out.shape}" if isinstance(out, np.ndarray) else repr(out)
        raise InputError(f"out must be a writable, contiguous, aligned array of doubles of shape {shape}, got {what}")
    checked: Array = out
    return checked


def is_plain(array: Any, n: int) -> TypeGuard[Array]:
    """Whether it is an array of n contiguous doubles."""
    good = type(array) is np.ndarray and array.dtype == np.float64 and array.shape == (n,)
    return good and bool(array.flags.c_contiguous and array.flags.aligned)
