"""Which inverse a controller should take that is told nothing: who gets there, and who is calm with noise and lag.

`python -m benchmarks.default_inverse` runs pairs of `benchmarks.closed_loop` with inverses of several thresholds and
dampings, within joint limits: exact ones to see who arrives, and others with noise of what is measured and actuators
that lag behind, within limits and without, to see who shakes. A stiffer inverse arrives more often and shakes sooner.
All are steady, as the default is (`TaskPriority(steady=True)`), and none is calmed, as the default would be.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks.closed_loop import judge_of, judged
from benchmarks.loop_contenders import Answer
from benchmarks.loop_runs import ARMS, random_runs
from benchmarks.loop_verdicts import Run, listed, short, summary
from benchmarks.peers.loops import Loop, Servo, driven, rotation_vector
from benchmarks.peers.ours import parts, robot_of
from benchmarks.tables import markdown, parser, publish

PAGE, MARK = "closed_loop.md", "default_inverse"
INVERSES: tuple[rik.RobustInverse, ...] = (
    rik.JParse(0.1), rik.JParse(0.05), rik.JParse(0.02), rik.JParse(0.01), rik.JParse(0.005),
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
ACCELERATION = 5.0
"""Limits of the runs that look how much too fast a tool gets, rad/s²."""
COLUMNS = (
    "inverse", "reached", "stuck", "still moving", "chattering", "error [mm]: median", "p90",
    "acceleration limits: fastest tool, of its cap: p90", "noise and lag: shaking within limits", "without limits",
)  # fmt: skip


def servo(inverse: rik.RobustInverse, loop: Loop, *, limited: bool = True, acceleration: float = math.inf) -> Servo:
    """A controller as `benchmarks.closed_loop` runs it."""
    robot = robot_of(loop)
    limits = [rik.JointLimits.of(robot, acceleration=acceleration)] if limited else ()
    return Servo(*parts(robot, rik.TaskPriority(inverse, steady=True), limits, loop, calm=False))


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


def fastest(servo: Servo, loop: Loop, pair: int) -> float:
    """How fast a tool ever is, of what its task allows: acceleration limits do not let joints slow down at once."""
    q, before, most = loop.q[pair], servo.poses(loop.q[pair]), 0.0
    servo.begin()
    for _ in range(round(SECONDS / loop.dt)):
        q = q + loop.dt * servo.step(q, loop.targets[pair])
        now = servo.poses(q)
        for old, new in zip(before, now):
            turn = rotation_vector(new[:3, :3] @ old[:3, :3].T)
            speeds = np.array([np.linalg.norm(new[:3, 3] - old[:3, 3]), np.linalg.norm(turn)]) / loop.dt
            most = max(most, float((speeds / loop.caps).max()))
        before = now
    return most


@dataclass(frozen=True, eq=False)
class Measured:
    """One inverse on one arm.

    Attributes:
        runs: The exact ones.
        fastest: Of the tool in runs with acceleration limits, as shares of its cap, (pairs,).
        shaking: In how many noisy runs a joint shakes, within limits and without, (2,).
    """

    runs: list[Run]
    fastest: np.ndarray
    shaking: np.ndarray


def measured(task: tuple[rik.RobustInverse, str, int, float]) -> Measured:
    """An inverse, an arm, how many pairs, and seconds at the most."""
    inverse, arm, pairs, seconds = task
    loop, place = random_runs(arm, pairs, seconds), judge_of(arm)
    exact, slow = servo(inverse, loop), servo(inverse, loop, acceleration=ACCELERATION)
    runs = [driven(exact, loop, q, targets) for q, targets in zip(loop.q, loop.targets)]
    coarse, shaking = replace(beyond(loop), dt=DT), []
    for limited in (True, False):
        driver = servo(inverse, coarse, limited=limited)
        shaking.append(sum(noisy(driver, coarse, pair) for pair in range(pairs)))
    speeds = np.array([fastest(slow, loop, pair) for pair in range(pairs)])
    return Measured(judged(arm, loop, place, Answer(rik.__version__, runs)), speeds, np.array(shaking))


def row(inverse: rik.RobustInverse, made: Sequence[Measured]) -> tuple[str, ...]:
    """A line of the table."""
    found = summary([run for each in made for run in each.runs])
    shares = (f"{found[name] / found['runs']:.0%}" for name in ("reached", "stuck", "moving", "chatters"))
    errors = (short(1e3 * found["position_m"][which]) for which in ("median", "p90"))
    speed = f"{np.quantile(np.concatenate([each.fastest for each in made]), 0.9):.1f}"
    shaking = (f"{count / found['runs']:.0%}" for count in np.sum([each.shaking for each in made], axis=0))
    named = f"`{shown(repr(inverse))}`" + (", the default" if inverse == default() else "")
    return (named, *shares, *errors, speed, *shaking)


def words(rows: Sequence[Sequence[str]]) -> str:
    """Which inverses shake in no run, which of these arrives most often, and what the default does beside it."""
    calm = [each for each in rows if each[-2] == each[-1] == "0%"]
    if not calm:
        return "Every inverse shakes with noise and lag."
    shaking = [each[0] for each in rows if each not in calm]
    best = max(calm, key=lambda each: int(each[1].rstrip("%")))
    other = f", in some of {listed(shaking)} one does." if shaking else "."
    lines = [f"In no run of {listed([each[0] for each in calm])} a joint shakes{other}"]
    lines.append(f"Of these {best[0]} arrives most often: in {best[1]} of the runs.")
    for each in rows:
        if "the default" in each[0] and each is not best:
            is_calm = "calm" if each in calm else "not calm"
            lines.append(f"The default arrives in {each[1]}; it is {is_calm}.")
    return " ".join(lines)


def shown(text: str) -> str:
    """Without the parameters that are all the same."""
    for same in (", gain=1.0, exponent=1.0", "gamma=", "damping=", ", squared=True"):
        text = text.replace(same, "")
    return text


def default() -> rik.RobustInverse:
    """What a controller takes that is told nothing."""
    return rik.VelocityController(rik.load("planar_2r")).resolver.inverse  # type: ignore[attr-defined,no-any-return]


def main(run: Callable[..., Measured] = measured) -> None:
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
