"""Measures what every inverse makes of three motions: the table of docs/which_inverse.md.

`python -m benchmarks.which_inverse` prints it; with `--write` it goes into the page.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish
from robust_ik.control.tasks.target_paths import Path as Target
from robust_ik.inverses import CLASSES
from robust_ik.simulation.scenarios import stretch

REACHING = ("xarm7", "panda", "ur5", "kinova", "pa10", "puma560")
COLUMNS = (
    "inverse", "far from singularities: error [mm]", "out of reach: peak [rad/s]", "… speed at rest [rad/s]",
    "… error after return [mm]", "through the wrist: peak [rad/s]", "… error [mm]", "… error [deg]",
)  # fmt: skip


def regular(inverse: rik.RobustInverse) -> list[float]:
    """A circle of 5 cm in 6 s, far from singularities, feedback 10 /s: largest error after the first second, mm."""
    robot = rik.load("panda")
    start = robot.pose(robot.rest)

    def circle(t: float) -> np.ndarray:
        T = start.copy()
        T[:3, 3] += 0.05 * np.array([0, np.sin(t * np.pi / 3), 1 - np.cos(t * np.pi / 3)])
        return T

    # What feedback alone lags behind a moving target is the same for all: the pseudo-inverse's is taken off.
    def error(each: rik.RobustInverse) -> np.ndarray:
        motion = rik.Follow(circle, gain=10)
        return rik.simulate(robot, each, motion, robot.rest, duration=6, dt=0.01, limits=(), calm=False).error[100:, :3]

    return [1e3 * float(np.linalg.norm(error(inverse) - error(rik.MoorePenrose()), axis=-1).max())]


def reaching(inverse: rik.RobustInverse) -> list[float]:
    """The demo on six arms: peak joint speed; speed that remains while the target rests out of reach; final error."""
    runs = [stretch(rik.load(name), travel=5, pause=4, settle=8).run(inverse) for name in REACHING]
    peak = max(run.largest_speed for run in runs)
    resting = max(float(np.abs(run.qdot[(run.time > 8) & (run.time < 9)]).max()) for run in runs)
    final = max(1e3 * float(np.linalg.norm(run.final_error[:3])) for run in runs)
    return [peak, resting, final]


def wrist(inverse: rik.RobustInverse) -> list[float]:
    """A path that two arms can follow, straight through their wrist singularity, in 4 s: peak speed, errors."""
    runs = [_through_wrist(inverse, name, np.array(q)) for name, q in WRISTS.items()]
    peak = max(run.largest_speed for run in runs)
    error = max(1e3 * float(run.position_error.max()) for run in runs)
    return [peak, error, max(float(np.degrees(run.rotation_error.max())) for run in runs)]


WRISTS = {"puma560": (0.0, -0.8, 0.6, 0.3, 0.0, 0.2), "ur5": (0.0, -1.2, 1.4, -1.0, 0.0, 0.3)}
"""Configurations with the fifth joint at its singular zero; it passes from 0.4 to −0.4 rad."""


def _through_wrist(inverse: rik.RobustInverse, name: str, q: np.ndarray) -> rik.Trajectory:
    robot = rik.load(name)

    def joints(t: float) -> np.ndarray:
        return q + np.array([0.1, 0, 0, 0, -0.4, 0]) * np.clip(t / 2 - 1, -1, 1)

    path: Target = lambda t: robot.pose(joints(t))  # noqa: E731
    return rik.simulate(
        robot, inverse, rik.Follow(path, gain=10), joints(0), duration=6, dt=0.01, limits=(), calm=False
    )


def measure(motions: tuple[Callable[[rik.RobustInverse], list[float]], ...]) -> list[tuple[str, ...]]:
    """A row of text per inverse."""
    chosen = [each() for each in CLASSES if each is not rik.Weighted]
    rows = []
    for inverse in track(chosen, console=Console(stderr=True), description="measuring"):
        numbers = [number for motion in motions for number in motion(inverse)]
        rows.append((f"`{type(inverse).__name__}`", *(f"{number:.2g}" for number in numbers)))
    return rows


def main() -> None:
    arguments = parser(__doc__, "which_inverse.md").parse_args()
    table = markdown(COLUMNS, measure((regular, reaching, wrist)))
    publish(table, "which_inverse.md", "measured", write=arguments.write)


if __name__ == "__main__":
    main()
