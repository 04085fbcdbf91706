"""Which inverse a controller should take that is told nothing: who gets there, and who is calm with noise and lag.

`python -m benchmarks.default_inverse` runs pairs of `benchmarks.closed_loop` with inverses of several thresholds and
dampings, within joint limits: exact ones to see who arrives, and others with noise of what is measured and actuators
that lag behind, within limits and without, to see who shakes. A stiffer inverse arrives more often and shakes sooner.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks.closed_loop import judge_of, judged
from benchmarks.loop_contenders import Answer
from benchmarks.loop_runs import ARMS, random_runs
from benchmarks.loop_verdicts import Run, short, summary
from benchmarks.peers.loops import Loop, Servo, driven
from benchmarks.peers.ours import parts, robot_of
from benchmarks.tables import markdown, parser, publish

PAGE, MARK = "closed_loop.md", "default_inverse"
INVERSES: tuple[rik.RobustInverse, ...] = (
    rik.JParse(0.1), rik.JParse(0.05), rik.JParse(0.02), rik.JParse(0.01),
    rik.DampedLeastSquares(0.1), rik.DampedLeastSquares(0.05), rik.DampedLeastSquares(0.02),
)  # fmt: skip
NOISE, LAG = 1e-4, 0.02
"""Standard deviation of what is measured, rad; time constant of the actuators, s."""
DT, SECONDS = 0.02, 8.0
"""Of the runs with noise: the longer the step, the sooner they shake."""
AWAY = 2.0
"""How much further off targets are that are out of reach, m."""
SHAKING, HELD = 20.0, 20.0
"""A joint shakes whose acceleration changes by over so many times what noise makes of one held by such a gain, 1/s."""
COLUMNS = (
    "inverse", "reached", "stuck", "still moving", "chattering", "error [mm]: median", "p90",
    "noise and lag: shaking within limits", "without limits",
)  # fmt: skip


def servo(inverse: rik.RobustInverse, loop: Loop, *, limited: bool = True) -> Servo:
    """A controller as `benchmarks.closed_loop` runs it."""
    robot = robot_of(loop)
    return Servo(*parts(robot, inverse, [rik.JointLimits.of(robot)] if limited else (), loop))


def shakes(qdot: np.ndarray, dt: float) -> bool:
    """Whether a joint does, in a series of joint velocities, (steps, n), however fast it goes somewhere meanwhile."""
    made = math.sqrt(6) * NOISE * min(HELD, 1 / dt)
    return bool(np.std(np.diff(qdot, n=2, axis=0), axis=0).max() > SHAKING * made)


def beyond(loop: Loop) -> Loop:
    """The same runs, but every other target out of reach, straight away from the base."""
    targets = loop.targets.copy()
    at = targets[1::2, :, :3, 3]
    targets[1::2, :, :3, 3] += AWAY * at / np.linalg.norm(at, axis=-1, keepdims=True)
    return replace(loop, targets=targets)


def noisy(servo: Servo, loop: Loop, pair: int) -> bool:
    """Whether a run with noise and lag shakes in its last half second."""
    rng, q = np.random.default_rng(pair), loop.q[pair]
    moving, asked = np.zeros_like(q), []
    servo.begin()
    for _ in range(round(SECONDS / loop.dt)):
        asked.append(servo.step(q + NOISE * rng.normal(size=q.shape), loop.targets[pair]))
        moving = moving + (1 - math.exp(-loop.dt / LAG)) * (asked[-1] - moving)
        q = q + loop.dt * moving
    return shakes(np.array(asked[-round(0.5 / loop.dt) :]), loop.dt)


def measured(task: tuple[rik.RobustInverse, str, int, float]) -> tuple[list[Run], np.ndarray]:
    """One inverse on one arm: its exact runs, and how many noisy ones shake within limits and without, of how many."""
    inverse, arm, pairs, seconds = task
    loop, place = random_runs(arm, pairs, seconds), judge_of(arm)
    exact = servo(inverse, loop)
    runs = [driven(exact, loop, q, targets) for q, targets in zip(loop.q, loop.targets)]
    coarse, counts = replace(beyond(loop), dt=DT), np.array([0, 0, pairs])
    for column, limited in enumerate((True, False)):
        driver = servo(inverse, coarse, limited=limited)
        counts[column] = sum(noisy(driver, coarse, pair) for pair in range(pairs))
    return judged(arm, loop, place, Answer(rik.__version__, runs)), counts


def row(inverse: rik.RobustInverse, made: Sequence[tuple[list[Run], np.ndarray]]) -> tuple[str, ...]:
    """A line of the table."""
    found = summary([run for runs, _ in made for run in runs])
    within, without, of = np.sum([counts for _, counts in made], axis=0)
    shares = (f"{found[name] / found['runs']:.0%}" for name in ("reached", "stuck", "moving", "chatters"))
    errors = (short(1e3 * found["position_m"][which]) for which in ("median", "p90"))
    named = f"`{shown(repr(inverse))}`" + (", the default" if inverse == default() else "")
    return (named, *shares, *errors, f"{within / of:.0%}", f"{without / of:.0%}")


def words(rows: Sequence[Sequence[str]]) -> str:
    """Which inverses shake in no run, which of these arrives most often, and whether it is the default."""
    calm = [each for each in rows if each[-2] == each[-1] == "0%"]
    if not calm:
        return "Every inverse shakes with noise and lag."
    most = max(int(each[1].rstrip("%")) for each in calm)
    best = [each[0] for each in calm if each[1] == f"{most}%"]
    shaking = [each[0] for each in rows if each not in calm]
    lines = [f"Of those that shake in no run {' and '.join(best)} arrives most often, in {most} % of the runs."]
    lines += [f"With noise and lag {' and '.join(shaking)} shake." if shaking else "None shakes."]
    if not any("the default" in each for each in best):
        lines.append("The default of a controller is another one.")
    return " ".join(lines)


def shown(text: str) -> str:
    """Without the parameters that are all the same."""
    for same in (", gain=1.0, exponent=1.0", "gamma=", "damping=", ", squared=True"):
        text = text.replace(same, "")
    return text


def default() -> rik.RobustInverse:
    """What a controller takes that is told nothing."""
    return rik.VelocityController(rik.load("planar_2r")).resolver.inverse  # type: ignore[attr-defined,no-any-return]


def main(run: Callable[..., tuple[list[Run], np.ndarray]] = measured) -> None:
    options = parser(__doc__, PAGE)
    options.add_argument("--pairs", type=int, default=4, help="starts and targets for each arm")
    options.add_argument("--seconds", type=float, default=15.0, help="how long an exact run takes at the most")
    options.add_argument("--arms", nargs="+", choices=tuple(ARMS), default=tuple(ARMS), metavar="ARM")
    options.add_argument("--jobs", type=int, default=1, help="processes")
    arguments: argparse.Namespace = options.parse_args()
    tasks = [(each, arm, arguments.pairs, arguments.seconds) for each in INVERSES for arm in arguments.arms]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        bar = track(pool.map(run, tasks), "running", len(tasks), console=Console(stderr=True))
        made = list(bar)
    many = len(arguments.arms)
    rows = [row(each, made[many * place : many * (place + 1)]) for place, each in enumerate(INVERSES)]
    publish(markdown(COLUMNS, rows), PAGE, MARK, write=arguments.write)
    publish(words(rows), PAGE, f"{MARK}_words", write=arguments.write)


if __name__ == "__main__":
    main()
