"""Times one control step from Python, joint velocities from q and a twist, without limits: ours and its peers.

`python -m benchmarks.step_latency` prints the table; with `--write` it goes into docs/benchmarks.md, JSON and figure
beside it. All get the same configurations, drawn anew for every step, and take turns; kinematics included. Ratios
are of CPU time within one round. The baseline is Pinocchio's Jacobian and `np.linalg.solve`, damped least squares.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

import robust_ik as rik
from benchmarks import figures
from benchmarks.environments import CACHE, UnavailableError
from benchmarks.peers.timing import Sample
from benchmarks.report import Report, options
from benchmarks.rounds import Contender, Round, Series, calls, interleave, needed, ours, peer
from benchmarks.works import ahead, arm, twists, work_of
from robust_ik.inverses import CLASSES

DAMPING = 0.05
BASELINE, DLS = "Pinocchio + np.linalg.solve", "robust_ik DampedLeastSquares"
COLUMNS = (
    "system", "CPU [µs]", "median [µs]", "p99 [µs]", "p99.9 [µs]", "ratio to Pinocchio + NumPy", "ratio to our DLS",
    "‖J q̇ − ẋ‖/‖ẋ‖, median",
)  # fmt: skip
Steps = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class PythonFilter(rik.SingularValueFilter):
    """A filter as a user writes it: φ(σ) = σ/(σ² + λ²) in NumPy."""

    def gains(self, s: Any) -> np.ndarray:
        """φ of a spectrum."""
        s = np.asarray(s)
        return s / (s * s + DAMPING**2)

    def largest_gain(self, sigma_max: float) -> float:
        """At σ = λ."""
        sigma = min(sigma_max, DAMPING)
        return sigma / (sigma * sigma + DAMPING**2)

    def is_exact(self, s: Any) -> np.ndarray:
        """Nowhere."""
        return np.zeros(np.shape(s), dtype=bool)


def pinocchio_step(robot: rik.Robot, solve: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Callable[..., Any]:
    """A step with Pinocchio's Jacobian, in Python."""
    model, data = robot.model, robot.model.createData()
    frame = model.getFrameId(str(robot.tip))
    return lambda q, twist: solve(pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED), twist)


def damped(J: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """Damped least squares by 6 × 6 equations."""
    return J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * np.eye(6), twist)


def damped_svd(J: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """The same by singular values."""
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    return Vt.T @ (s / (s * s + DAMPING**2) * (U.T @ twist))


def stepper(robot: rik.Robot, inverse: rik.RobustInverse, steps: Steps, *, term: bool = False) -> Round:
    """The round of our own step, into arrays that are there already."""
    make = needed(rik, "Stepper")
    try:
        step = make(robot, inverse).step
    except rik.RobustIKError as error:
        raise UnavailableError(str(error)[:120]) from None
    out = np.empty((len(steps[0]), robot.n))
    if term:
        names = [name for name in inspect.signature(step).parameters if name.startswith(("null", "secondary"))]
        if not names:
            raise UnavailableError("this Stepper takes no null-space term")
        step = partial(step, **{names[0]: np.full(robot.n, 0.1)})

    into_out = calls(step, *steps, out)

    def round_() -> Sample:
        done = into_out()
        return Sample(done.cpu_us, done.us, out.copy())

    return round_


def inverses() -> dict[str, rik.RobustInverse]:
    """What our own contenders use, damped least squares first."""
    built_in = [each() for each in CLASSES if issubclass(each, rik.SingularValueFilter)]
    built_in.sort(key=lambda each: not isinstance(each, rik.DampedLeastSquares))
    found: dict[str, rik.RobustInverse] = {f"robust_ik {type(each).__name__}": each for each in built_in}
    found["robust_ik, a filter in Python"] = PythonFilter()
    found["robust_ik Weighted(JParse)"] = rik.Weighted(rik.JParse(), joint_weights=None, length_scale=0.5)
    return found


def contenders(robot: rik.Robot, chain: Any, steps: Steps, *, peers: bool) -> list[Contender]:
    """Everyone."""
    found = [
        ours(BASELINE, lambda: calls(pinocchio_step(robot, damped), *steps)),
        ours("Pinocchio + np.linalg.svd", lambda: calls(pinocchio_step(robot, damped_svd), *steps)),
        *(ours(name, partial(stepper, robot, inverse, steps)) for name, inverse in inverses().items()),
        ours("robust_ik JParse + null space", partial(stepper, robot, rik.JParse(), steps, term=True)),
    ]
    if peers:
        work = work_of(robot, chain, *steps)
        path = work.save(CACHE / "twists.npz")
        moved = ahead(work.poses, steps[1], work.dt)
        targets = work_of(robot, chain, steps[0], moved).save(CACHE / "steps.npz")
        found += [
            peer("PyKDL wdls", "pykdl", "twist", path),
            peer("PlaCo", "placo", "step", targets, ("--plain", "yes")),
            peer("RoboPlan OInK", "roboplan", "step", targets),
            peer("EmbodiK", "embodik", "twist", path),
            peer("Pink", "pink", "step", targets, ("--plain", "yes")),
            peer("mink", "mink", "step", targets, ("--plain", "yes")),
            peer("jparse-robotics", "jparse", "twist", path),
        ]
    return found


def row(each: Series, series: dict[str, Series], J: np.ndarray, twist: np.ndarray) -> Sequence[str]:
    """A line of the table."""
    if each.failure:
        return each.name, *("–",) * 6, each.failure
    p99, last = np.percentile(each.us, (99, 99.9))
    numbers = (np.median(each.cpu), np.median(each.us), p99, last)
    ratios = (each.ratio(series[BASELINE]), each.ratio(series[DLS]))
    return (
        f"{each.name} {each.version}".strip(),
        *(f"{number:.3g}" for number in numbers),
        *ratios,
        f"{np.median(residuals(J, twist, each.answers)):.1e}",
    )


def residuals(J: np.ndarray, twist: np.ndarray, qdot: np.ndarray) -> np.ndarray:
    """How much of a twist is missing, (N,)."""
    return np.linalg.norm((J @ qdot[..., None])[..., 0] - twist, axis=1) / np.linalg.norm(twist, axis=1)


def against_numpy(J: np.ndarray, twist: np.ndarray, series: dict[str, Series]) -> dict[str, float]:
    """The largest relative difference of our own steps from the inverse in NumPy with Pinocchio's Jacobian."""
    found = {}
    for name, inverse in inverses().items():
        if series[name].samples:
            expected = inverse.solve(J, twist)
            apart = np.linalg.norm(series[name].answers - expected, axis=1) / np.linalg.norm(expected, axis=1)
            found[name] = float(apart.max())
    return found


def main() -> None:
    parser = options(__doc__)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--steps", type=int, default=2000)
    arguments = parser.parse_args()
    robot, chain = arm(arguments.robot)
    steps = twists(robot, arguments.steps)
    series = interleave(contenders(robot, chain, steps, peers=not arguments.no_peers), arguments.rounds)
    stepping = pinocchio_step(robot, lambda J, _: J)
    J = np.array([stepping(q, None) for q in steps[0]])
    bases = [series[BASELINE], series[DLS]]
    measured = {name: each.summary(bases) for name, each in series.items()}
    bars = {name: each.summary()["wall_us"] for name, each in series.items() if each.samples}
    Report(
        "step_latency",
        COLUMNS,
        [row(each, series, J, steps[1]) for each in series.values()],
        {"contenders": measured, "against NumPy": against_numpy(J, steps[1], series)},
        {"robot": arguments.robot, "steps": arguments.steps, "rounds": arguments.rounds},
        text_last=True,
        figure=lambda path: figures.bars(path, {"one control step": bars}, "µs, median and quartiles"),
    ).publish(write=arguments.write)


if __name__ == "__main__":
    main()
