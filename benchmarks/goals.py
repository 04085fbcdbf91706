"""Tells which of the promised speeds and accuracies hold, from what the other commands have saved.

`python -m benchmarks.goals` reads out/benchmarks, or with `--docs` docs/benchmarks, and prints a line for each. The
exit code is the number of goals that are missed; what was not measured counts as missed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.report import OUT
from benchmarks.tables import DOCS, markdown
from robust_ik.inverses import CLASSES, SingularValueFilter

BASE, DLS = "Pinocchio + np.linalg.solve", "robust_ik DampedLeastSquares"
LM = "Robotics Toolbox ik_LM"
ARMS = ("panda", "ur5", "pa10", "xarm7")
STARRED = "*"


@dataclass(frozen=True)
class Goal:
    """One promise.

    Attributes:
        name: What is promised.
        file: The measurement that tells.
        value: From its results to the number, or None where it is missing.
        limit: What that may be.
        least: Whether the limit is a lower one.
    """

    name: str
    file: str
    value: Callable[[dict[str, Any]], float | None]
    limit: float
    least: bool = False

    def line(self, folder: Path) -> tuple[str, ...]:
        """Name, limit, measured, verdict."""
        sign = "≥" if self.least else "≤"
        try:
            found = self.value(json.loads((folder / f"{self.file}.json").read_text(encoding="utf-8"))["results"])
        except (OSError, KeyError, ValueError, TypeError):
            found = None
        if found is None:
            return self.name, f"{sign} {self.limit:g}", "–", "not measured"
        held = found >= self.limit if self.least else found <= self.limit
        return self.name, f"{sign} {self.limit:g}", f"{found:.4g}", "yes" if held else "NO"


def ratio(each: dict[str, Any], base: str) -> float:
    """The median of the ratios to another contender."""
    return each["ratio"][base]["median"]


def filters(results: dict[str, Any]) -> float:
    """The slowest built-in filter over the baseline."""
    contenders = results["contenders"]
    names = {f"robust_ik {each.__name__}" for each in CLASSES if issubclass(each, SingularValueFilter)}
    return max(ratio(contenders[name], BASE) for name in names)


def step_over(name: str) -> Callable[[dict[str, Any]], float]:
    """How many times as long as our damped least squares a peer takes."""
    return lambda results: ratio(results["contenders"][name], DLS)


def fastest(results: dict[str, Any]) -> float:
    """The same for the fastest of the compiled peers that were there."""
    names = ("PyKDL wdls", "PlaCo", "RoboPlan OInK")
    return min(ratio(results["contenders"][name], DLS) for name in names if "ratio" in results["contenders"][name])


def pose_over(case: str) -> Callable[[dict[str, Any]], float]:
    """How many times as long as ours the Robotics Toolbox takes."""
    return lambda results: ratio(results[case][LM], "robust_ik")


def mean(case: dict[str, Any]) -> float:
    """CPU time of ours."""
    return case["robust_ik"]["cpu_us"]["median"]


def over_best(name: str, times: str, part: str) -> Callable[[dict[str, Any]], float]:
    """The worst arm's error out of reach over the best known."""
    return lambda results: max(results[f"{arm}, unreachable {times}"][name]["error over best"][part] for arm in ARMS)


def accurate(results: dict[str, Any]) -> float:
    """The largest relative error of σ where every σ can be had to its last bits."""
    return max(each["ours: relative"] for name, each in results.items() if STARRED not in name)


def goals() -> Iterator[Goal]:
    """All of them."""
    yield Goal("step, DLS over Pinocchio + NumPy", "step_latency", lambda r: ratio(r["contenders"][DLS], BASE), 0.10)
    yield Goal("step, any built-in filter over the same", "step_latency", filters, 0.30)
    yield Goal("fastest compiled peer over our step", "step_latency", fastest, 4, least=True)
    yield Goal("Pink over our step", "step_latency", step_over("Pink"), 40, least=True)
    yield Goal("jparse-robotics over our step", "step_latency", step_over("jparse-robotics"), 100, least=True)
    svd_ratio = lambda r: ratio(r["6 × 7, batch"]["robust_ik"], "np.linalg.svd")  # noqa: E731
    yield Goal("SVD 6 × 7, batch, over NumPy", "svd", svd_ratio, 0.26)
    yield Goal("SVD, largest relative error of σ", "svd_errors", accurate, 1e-14)
    for arm in ARMS:
        key = f"{arm}, random"
        yield Goal(f"poses missed, {arm}", "pose_accuracy", lambda r, key=key: r[key]["missed"], 0)
        share = lambda r, key=key: 1 - r[key]["missed_fine"] / r[key]["targets"]  # noqa: E731
        yield Goal(f"share of poses to 1e-8, {arm}", "pose_accuracy", share, 0.9999, least=True)
        singular = lambda r, arm=arm: mean(r[f"{arm}, singular"]) / mean(r[f"{arm}, random"])  # noqa: E731
        yield Goal(
            f"singular targets missed, {arm}", "pose_accuracy", lambda r, a=arm: r[f"{a}, singular"]["missed"], 0
        )
        yield Goal(f"singular targets over random ones, {arm}", "pose_ik", singular, 2)
    yield Goal("ik_LM over our pose, Panda", "pose_ik", pose_over("panda, random"), 20, least=True)
    yield Goal("ik_LM over our pose, UR5", "pose_ik", pose_over("ur5, random"), 8, least=True)
    yield Goal("ik_LM over our warm start, Panda", "pose_ik", pose_over("panda, warm"), 6, least=True)
    yield Goal("ik_LM over our warm start, UR5", "pose_ik", pose_over("ur5, warm"), 6, least=True)
    yield Goal("2 × reach, error over best, median", "pose_ik", over_best("robust_ik", "2", "median"), 1.001)
    yield Goal("2 × reach, error over best, p90", "pose_ik", over_best("robust_ik", "2", "p90"), 1.02)
    yield Goal("1.1 × reach, thorough, p90", "pose_ik", over_best("robust_ik thorough", "1.1", "p90"), 1.01)
    yield Goal("batch of DLS over one by one", "batch_throughput", lambda r: _pair(r, "DLS, batch", "one"), 0.25)
    many = lambda r: r["robust_ik SVD + JParse, batch"]["cpu_us"]["median"]  # noqa: E731
    yield Goal("FK + J + SVD + filter of many, µs", "batch_throughput", many, 2)
    yield Goal(
        "speed-up by both cores", "batch_throughput", lambda r: _pair(r, "SVD + JParse, 2 threads", "cores"), 1.8, True
    )
    atlas = lambda r: sorted(each["cpu"] for each in r["pa10"])[len(r["pa10"]) // 2]  # noqa: E731
    yield Goal("atlas of the PA-10, CPU s", "atlas_time", atlas, 2)
    yield Goal("import, added, CPU ms", "import_time", lambda r: r["robust_ik, added"]["cpu_ms"]["median"], 100)
    yield Goal("robust-ik --help, CPU ms", "import_time", lambda r: r["robust-ik --help"]["cpu_ms"]["median"], 150)
    yield Goal("robust-ik robots, CPU ms", "import_time", lambda r: r["robust-ik robots"]["cpu_ms"]["median"], 1000)
    yield Goal("numba imported with the package", "import_time", lambda r: float(r["numba is imported"]), 0)


def _pair(results: dict[str, Any], name: str, key: str) -> float:
    return float(results[f"robust_ik {name}"]["pairs"][key])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", action="store_true", help="read what is in docs/benchmarks")
    folder = DOCS / "benchmarks" if parser.parse_args().docs else OUT
    lines = [goal.line(folder) for goal in goals()]
    print(markdown(("goal", "limit", "measured", "held"), lines, text_last=True))
    sys.exit(sum(line[-1] != "yes" for line in lines))


if __name__ == "__main__":
    main()
