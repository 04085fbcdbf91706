"""Measures our singular value decomposition: time beside `np.linalg.svd`, errors beside 60 digits.

`python -m benchmarks.svd` prints two tables; with `--write` they go into docs/benchmarks.md, JSON and figure too.
Errors are the largest of any σ, relative to itself and over σ₁. Every σ to its last bits can be had where only the rows
are scaled, by whatever: diag(d) B with B well conditioned. Where small σ come from cancellation, changing the last bit
of one entry moves them by ε σ₁; those kinds are marked, and measured by what is over σ₁.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

import robust_ik as rik
from benchmarks import figures
from benchmarks.environments import CACHE, SCRIPTS, UnavailableError, call, interpreter
from benchmarks.report import Report, options
from benchmarks.rounds import Series, batches, calls, interleave, ours

SHAPES = ((6, 7), (6, 6), (3, 7), (7, 6), (6, 14))
BATCH, SINGLES = 2000, 1000
TIMES = ("matrices", "np.linalg.svd [µs]", "ours [µs]", "ratio, q1 to q3")
ERRORS = (
    "matrices 6 × 7", "count", "ours: relative", "NumPy: relative", "ours: over σ₁", "NumPy: over σ₁",
    "ours: UᵀU − 1", "ours: U s Vᵀ − J over σ₁",
)  # fmt: skip
Decompose = Callable[[np.ndarray], Any]
numpy_svd: Decompose = partial(np.linalg.svd, full_matrices=False)


def families(count: int) -> dict[str, np.ndarray]:
    """Matrices that are hard in different ways, name → (count, 6, 7); those of cancelled σ have a star."""
    rng = np.random.default_rng(4)
    U, _, Vt = numpy_svd(rng.normal(size=(count, 6, 7)))

    def with_values(s: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray((U * s) @ Vt)

    mild = with_values(rng.uniform(0.3, 1, size=(count, 1, 6)))
    robot = rik.load("panda")
    return {
        "σ within 0.3 to 1": mild,
        "a Panda's Jacobians *": robot.jacobian(robot.random(rng, count)),
        "graded: rows of 1 to 1e-6": np.geomspace(1, 1e-6, 6)[:, None] * mild,
        "graded: rows of 1 to 1e-15": np.geomspace(1, 1e-15, 6)[:, None] * mild,
        "repeated σ: 1 1 1 0.5 0.5 0.5": with_values(np.array([1, 1, 1, 0.5, 0.5, 0.5])),
        "close σ: 1 + k 1e-12": with_values(1 + 1e-12 * np.arange(6)[::-1]),
        "rows scaled by 1e-12 to 1e12": 10.0 ** rng.uniform(-12, 12, size=(count, 6, 1)) * mild,
        "times 1e150": 1e150 * mild,
        "times 1e-150": 1e-150 * mild,
        "σ from 1 to 1e-6 *": with_values(np.geomspace(1, 1e-6, 6)),
        "σ from 1 to 1e-12 *": with_values(np.geomspace(1, 1e-12, 6)),
        "repeated σ, one of 1e-3 *": with_values(np.array([1, 1, 1, 0.5, 0.5, 1e-3])),
    }


def errors(s: np.ndarray, near: np.ndarray, rest: np.ndarray) -> tuple[float, float]:
    """The largest error of σ relative to itself, and over σ₁; `near` + `rest` is exact."""
    off = np.abs((s - near) - rest)
    return float((off / near).max()), float((off / near[:, :1]).max())


def accuracy(count: int) -> tuple[list[Sequence[str]], dict[str, Any]]:
    """The table of errors."""
    python, script = interpreter("mpmath"), SCRIPTS / "mpmath_svd.py"
    rows: list[Sequence[str]] = []
    results: dict[str, Any] = {}
    CACHE.mkdir(parents=True, exist_ok=True)
    for name, A in families(count).items():
        np.save(CACHE / "matrices.npy", A)
        call([python, str(script), str(CACHE / "matrices.npy"), str(CACHE / "values.npz")])
        with np.load(CACHE / "values.npz") as exact:
            near, rest = exact["near"], exact["rest"]
        found = rik.svd(A)
        own, theirs = errors(found.s, near, rest), errors(numpy_svd(A)[1], near, rest)
        turned = float(np.abs(np.swapaxes(found.U, -1, -2) @ found.U - np.eye(6)).max())
        again = float((np.abs((found.U * found.s[:, None]) @ found.Vt - A).max(axis=(1, 2)) / near[:, 0]).max())
        numbers = (own[0], theirs[0], own[1], theirs[1], turned, again)
        rows.append((name, str(len(A)), *(f"{number:.1e}" for number in numbers)))
        results[name] = dict(zip(ERRORS[2:], numbers))
    return rows, results


def timed(shape: tuple[int, int], rounds: int) -> list[tuple[str, Series, Series]]:
    """NumPy and ours, one matrix at a time and many at once."""
    A = np.random.default_rng(5).normal(size=(BATCH, *shape))
    found = []
    pairs = {
        "one by one": [ours(name, partial(calls, each, A[:SINGLES])) for name, each in SOLVERS.items()],
        "batch": [ours(name, partial(batches, partial(each, A), BATCH, 3)) for name, each in SOLVERS.items()],
    }
    for how, pair in pairs.items():
        series = interleave(pair, rounds)
        found.append((f"{shape[0]} × {shape[1]}, {how}", *series.values()))
    return found


SOLVERS: dict[str, Decompose] = {"np.linalg.svd": numpy_svd, "robust_ik": rik.svd}


def main() -> None:
    parser = options(__doc__)
    parser.add_argument("--matrices", type=int, default=200, help="of each kind, for the errors")
    arguments = parser.parse_args()
    rows, results, bars = [], {}, {}
    for shape in SHAPES:
        for name, theirs, own in timed(shape, arguments.rounds):
            low, middle, high = np.percentile(own.ratios(theirs), (25, 50, 75))
            times = (f"{np.median(each.cpu):.3g}" for each in (theirs, own))
            rows.append((name, *times, f"{middle:.3g}, {low:.3g} to {high:.3g}"))
            results[name] = {each.name: each.summary([theirs]) for each in (theirs, own)}
            bars[name] = {each.name: each.summary()["wall_us"] for each in (theirs, own)}
    draw = partial(figures.bars, groups=bars, label="µs a matrix, median and quartiles")
    settings = {"batch": BATCH, "one by one": SINGLES, "rounds": arguments.rounds}
    Report("svd", TIMES, rows, results, settings, figure=draw).publish(write=arguments.write)
    settings = {"count": arguments.matrices, "digits": 60}
    try:
        lines, found = accuracy(arguments.matrices)
    except UnavailableError as reason:
        lines, found = [("–", str(reason), *("–",) * 6)], {"failure": str(reason)}
    Report("svd_errors", ERRORS, lines, found, settings).publish(write=arguments.write)


if __name__ == "__main__":
    main()
