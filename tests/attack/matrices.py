"""Extreme matrices against every inverse: the answer is finite, silent, within its bound, and moves no idle joint."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import robust_ik as rik
from robust_ik.kinematics import svd
from tests.cases_filters import CASES
from tests.cases_others import OTHER_CASES

COUNTS = {"short": 2_000, "full": 100_000}
CHUNK = 20_000
LIMITED = False
Array = NDArray[np.float64]
SHAPES = [(1, 1), (1, 4), (3, 1), (2, 2), (3, 3), (3, 7), (6, 6), (6, 7), (6, 4), (7, 2), (6, 9), (8, 8)]
BATCH = 500
SIZES = (1e-150, 3e-3, 0.3, 1.0, 20.0, 1e150)
"""σ₁ of a batch: so that every bound is computed once."""
DIGITS = (0.0, 1.0, -1.0, 0.5, 1e-8, -1e-13, 1e-17, 1e-120, 1e-155, -1e-155, 1e-170, 1e-280, 1e-310)
NEARLY = (0.0, 1e-17, 1e-16, 1e-15, 1e-14, 1e-13, 1e-10, 1e-155, 1e-300)
"""What zero rows and columns are, exactly or nearly."""
IDLE = 1e-6
"""How fast a joint without effect may be beside ‖ẋ‖/σ₁ and the fastest joint: φ of a σ that is rounding."""
LARGEST_ARM = 20.0
"""σ₁ up to which a σ of rounding is small beside absolute dampings."""


def of_rank(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """Of any rank, 0 included."""
    k = min(m, n)
    s = rng.uniform(0.1, 1.0, (count, k)) * (np.arange(k) < rng.integers(0, k + 1, (count, 1)))
    return (rotations(rng, count, m)[:, :, :k] * s[:, None, :]) @ rotations(rng, count, n)[:, :k, :]


def spectral(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """Repeated singular values, and small ones down to rounding and beyond."""
    k = min(m, n)
    s = rng.choice([1.0, 1.0, 0.5, 0.1, 1e-3, 1e-8, 1e-12, 2e-13, 1e-14, 1e-16, 1e-17, 1e-100, 0.0], (count, k))
    return (rotations(rng, count, m)[:, :, :k] * s[:, None, :]) @ rotations(rng, count, n)[:, :k, :]


def whole_numbers(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """Few small whole numbers: exact ties, equal rows, exact loss of rank."""
    return rng.integers(-1, 2, (count, m, n)).astype(float)


def far_apart(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """Entries whose squares and products underflow beside the largest one."""
    return rng.choice(DIGITS, (count, m, n)) * rng.choice([1.0, 1.7], (count, m, n))


def one_and_tiny(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """One entry of 1, the rest tiny."""
    J = 10.0 ** rng.uniform(-300, -100, (count, 1, 1)) * rng.choice([1.0, -1.0, 0.3], (count, m, n))
    J[np.arange(count), rng.integers(m, size=count), rng.integers(n, size=count)] = 1.0
    return J


def graded(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """Rows and columns of very different lengths."""
    most = rng.choice([3.0, 12.0, 60.0, 140.0], (count, 1, 1))
    rows, columns = 10.0 ** (-most * rng.random((count, m, 1))), 10.0 ** (-most * rng.random((count, 1, n)))
    which = rng.integers(3, size=(count, 1, 1))
    J: Array = rng.normal(size=(count, m, n)) * np.where(which != 0, rows, 1.0) * np.where(which != 1, columns, 1.0)
    return J


def with_zeros(rng: np.random.Generator, count: int, m: int, n: int) -> Array:
    """Joints without effect and rows that nothing moves, exactly and nearly, at a loss of rank besides."""
    J = np.where(rng.random((count, 1, 1)) < 0.5, of_rank(rng, count, m, n), rng.normal(size=(count, m, n)))
    for shape in ((count, m, 1), (count, 1, n)):
        J = J * np.where(rng.random(shape) < 0.4, rng.choice(NEARLY, shape), 1.0)
    return J


KINDS = (of_rank, spectral, whole_numbers, far_apart, one_and_tiny, graded, with_zeros)


def rotations(rng: np.random.Generator, count: int, n: int) -> Array:
    """Orthogonal matrices, some of them permutations."""
    Q: Array = np.linalg.qr(rng.normal(size=(count, n, n)))[0]
    plain = rng.random(count) < 0.3
    Q[plain] = np.eye(n)[rng.permuted(np.tile(np.arange(n), (int(plain.sum()), 1)), axis=1)]
    return Q


def batch(rng: np.random.Generator, count: int) -> tuple[str, Array, Array, float]:
    """Matrices of one kind, shape and σ₁, with task velocities: the kind's name, J, ẋ, σ₁."""
    kind, (m, n) = KINDS[rng.integers(len(KINDS))], SHAPES[rng.integers(len(SHAPES))]
    J, size = kind(rng, count, m, n), float(rng.choice(SIZES))
    largest = np.abs(J).max(axis=(-2, -1), keepdims=True)
    J = J / np.where(largest > 0, largest, 1.0)
    sigma = np.linalg.norm(J, 2, axis=(-2, -1))[:, None, None]
    J = J / np.where(sigma > 0, sigma, 1.0) * size
    xdot = rng.normal(size=(count, m)) * rng.choice([1e-3, 1.0, 10.0], (count, 1))
    xdot *= rng.random((count, m)) < rng.choice([0.5, 1.0], (count, 1))
    return f"{kind.__name__} ({m}, {n}), largest singular value {size:g}", J, xdot, size


def faults(inverse: rik.RobustInverse, J: Array, xdot: Array, size: float) -> dict[str, NDArray[np.bool_]]:
    """What an inverse does that it must not, and for which of the matrices."""
    qdot = inverse.solve(J, xdot)
    finite = np.isfinite(qdot).all(axis=-1)
    qdot = np.where(finite[:, None], qdot, 0.0)
    fastest = np.abs(qdot).max(axis=-1)
    unit = np.where(fastest > 0, fastest, 1.0)
    length = unit * np.linalg.norm(qdot / unit[:, None], axis=-1)
    speed = np.linalg.norm(xdot, axis=-1)
    bound = inverse.largest_gain(size) * speed if inverse.largest_gain(size) < np.inf else np.inf
    idle = (J == 0).all(axis=-2)
    found = {
        "is not finite": ~finite,
        "exceeds its largest gain": length > bound * (1 + 1e-9),
    }
    if size <= LARGEST_ARM and spares_idle_joints(inverse, size):
        found["moves an idle joint"] = np.abs(np.where(idle, qdot, 0.0)).max(axis=-1) > IDLE * np.maximum(
            speed / size, fastest
        )
    if isinstance(inverse, rik.SDLS):
        found["exceeds max_angle"] = fastest > inverse.max_angle * (1 + 1e-12)
    return found


def spares_idle_joints(inverse: rik.RobustInverse, size: float) -> bool:
    """Whether φ(0⁺) = 0, so that no σ of rounding, which may belong to any joint, moves anything."""
    if isinstance(inverse, rik.ChiaveriniFiltering) and not inverse.multi:
        return False  # the second smallest σ is not damped, or hardly
    return not isinstance(inverse, rik.SingularValueFilter) or inverse.gain_at_zero(size) == 0


def decomposition_faults(J: Array) -> dict[str, NDArray[np.bool_]]:
    """What the decomposition does that it must not."""
    found = svd.full_svd(J)
    size = np.abs(J).max(axis=(-2, -1), keepdims=True)
    unit = np.where(size > 0, size, 1.0)
    rebuilt = (found.U * (found.s[:, None, :] / unit)) @ found.Vt[:, : found.s.shape[-1], :]
    right = found.Vt @ np.swapaxes(found.Vt, -1, -2)
    left = np.swapaxes(found.U, -1, -2) @ found.U
    return {
        "is not finite": ~np.isfinite(rebuilt).all(axis=(-2, -1)),
        "has no singular value though J is not zero": (found.s[:, 0] == 0) & (size[:, 0, 0] > 0),
        "does not rebuild J": np.abs(rebuilt - J / unit).max(axis=(-2, -1)) > 1e-12,
        "has factors that are not orthogonal": np.maximum(
            np.abs(right - np.eye(right.shape[-1])).max(axis=(-2, -1)),
            np.abs(left - np.eye(left.shape[-1])).max(axis=(-2, -1)),
        )
        > 1e-12,
        "does not fall": (np.diff(found.s, axis=-1) > 0).any(axis=-1),
    }


def attack(count: int, seed: int, say: Callable[[str], None]) -> list[str]:
    """Runs `count` matrices against the decomposition and every inverse.

    Args:
        count: How many matrices each one gets.
        seed: Of the random numbers.
        say: Takes lines about how far it is.

    Returns:
        What failed, a sentence for every kind of failure with the first matrix that shows it.
    """
    rng, done = np.random.default_rng(seed), 0
    failures: dict[tuple[str, str], str] = {}
    while done < count:
        some = min(BATCH, count - done)
        name, J, xdot, size = batch(rng, some)
        tries: list[tuple[str, Callable[[], dict[str, NDArray[np.bool_]]]]] = [
            ("the decomposition", lambda J=J: decomposition_faults(J))
        ]
        tries += [
            (repr(each), lambda each=each, J=J, xdot=xdot, size=size: faults(each, J, xdot, size))
            for each in [*CASES, *OTHER_CASES]
        ]
        for who, test in tries:
            for fault, where in _tried(test).items():
                if where.any():
                    place = int(np.argmax(where))
                    failures.setdefault(
                        (who, fault),
                        f"{who} {fault} for {name}: J = {J[place].tolist()}, xdot = {xdot[place].tolist()}",
                    )
        done += some
        if done % (20 * BATCH) == 0:
            say(f"{done} of {count} matrices for each of {len(tries)}, {len(failures)} kinds of failure")
    return list(failures.values())


def _tried(test: Callable[[], dict[str, NDArray[np.bool_]]]) -> dict[str, NDArray[np.bool_]]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return test()
        except Exception as error:
            return {f"raises {type(error).__name__}: {error}": np.ones(1, dtype=bool)}
