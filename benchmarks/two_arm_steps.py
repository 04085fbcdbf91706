"""Times one control step of two arms on one torso against Pink, mink and PlaCo: fourteen joints, 18 rows and a posture.

`python -m benchmarks.two_arm_steps` prints a table: Baxter's hands carry something along a circle, so that both poses
and the one relative to the other are asked for, within joint limits. All systems read one URDF of the joints alone,
and get the configurations and targets of one motion. See benchmarks/peers/README.md.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np

import robust_ik as rik
from benchmarks.environments import CACHE, Peer, UnavailableError, progress
from benchmarks.loop_runs import bare, loop_of
from benchmarks.peers.loops import Loop
from benchmarks.tables import markdown, parser, publish

DT, AHEAD = 0.01, 0.05
"""A step, s, and the share of the way to the moving place that targets are ahead of the hands."""
RADIUS, ROUND = 0.08, 400
"""The circle, m, and its steps."""
START = {"s0": 0.08, "s1": -1.0, "e0": 1.19, "e1": 1.94, "w0": -0.67, "w1": 1.03, "w2": 0.5}
"""Joints of the right arm where the motion begins, rad: Rethink's neutral position; the left arm mirrors it."""
MIRRORED = ("s0", "e0", "w0", "w2")
"""Joints that turn the other way on the left."""
COLUMNS = ("system", "a step [µs]", "ratio to ours", "p99 [µs]", "hands after [mm]", "limits kept", "what it does")


@dataclass(frozen=True)
class Contender:
    """A row of the table.

    Attributes:
        name: What the row says.
        script: File in benchmarks/peers, without `_arms.py`; also the environment and its requirements.
        what: How it resolves priorities and limits.
        options: Of the script.
    """

    name: str
    script: str
    what: str
    options: tuple[str, ...] = ()


CONTENDERS = (
    Contender(
        "robust_ik, `ControlLoop`", "robust_ik", "strict: relative, both, posture; the default", ("--form", "prepared")
    ),
    Contender("robust_ik, `controller.step`", "robust_ik", "the same, with new tasks"),
    Contender("Pink", "pink", "weighted, one QP (DAQP); damped"),
    Contender("mink", "mink", "weighted, one QP (DAQP); MuJoCo"),
    Contender("PlaCo", "placo", "weighted, one QP in C++"),
)


def motion(steps: int) -> tuple[rik.Robot, Loop]:
    """What all systems are asked for: configurations along a motion by our controller, and targets just ahead."""
    robot, chains, path = bare("baxter")
    tips = tuple(chain.tip for chain in chains)
    values = []
    for side, joint in (name.split("_", 1) for name in robot.joint_names):
        values.append(START[joint] * (-1.0 if side == "left" and joint in MIRRORED else 1.0))
    q = start = np.array(values)
    begun = np.array([robot.pose(start, tip) for tip in tips])
    controller = rik.VelocityController(robot)
    posture, qs, targets = rik.PostureTask(start), np.empty((steps, robot.n)), np.tile(begun, (steps, 1, 1, 1))
    angle = 2 * np.pi * np.arange(steps) / ROUND
    way = RADIUS * np.stack([0 * angle, np.sin(angle), 1 - np.cos(angle)], axis=-1)
    for index, wanted in enumerate(targets):
        here = np.array([robot.pose(q, tip)[:3, 3] for tip in tips])
        qs[index], wanted[:, :3, 3] = q, here + AHEAD * (begun[:, :3, 3] + way[index] - here)
        hands: list[rik.Task] = [rik.FrameTask(T, 1 / DT, frame=tip) for T, tip in zip(wanted, tips)]
        relative = rik.RelativeTask(tips[1], tips[0], np.linalg.solve(*wanted), 1 / DT)
        q = robot.integrate(q, DT * controller.step(q, [[relative], hands, [posture]], DT).qdot)
    return robot, replace(loop_of(robot, tips, str(path), qs, targets, DT * steps), dt=DT)


@dataclass
class Result:
    """What one contender made of the work.

    Attributes:
        times: CPU time of a step, µs, once a round.
        tails: The 99 % quantiles of the wall time, µs.
        error: The median distance of the worse hand from its target after a step, m.
        kept: Whether speed and position limits are kept, to 1e-4 of a limit and 1e-4 rad.
    """

    times: list[float] = field(default_factory=list)
    tails: list[float] = field(default_factory=list)
    error: float = 0.0
    kept: bool = True

    def ratio(self, other: Result) -> float:
        """The median of the ratios to another's times in the same rounds."""
        return float(np.median(np.divide(self.times, other.times)))

    def judge(self, robot: rik.Robot, loop: Loop, qdot: np.ndarray) -> None:
        """Looks at the joint velocities of one round."""
        ends = loop.q + DT * qdot
        after = np.stack([robot.pose(ends, tip)[:, :3, 3] for tip in loop.tips], axis=1)
        self.error = float(np.median(np.linalg.norm(after - loop.targets[:, :, :3, 3], axis=-1).max(axis=1)))
        over = np.maximum(ends - robot.upper, robot.lower - ends).max()
        self.kept &= bool((np.abs(qdot) / robot.velocity_limit).max() < 1 + 1e-4 and over < 1e-4)


def row(contender: Contender, version: str, result: Result, ours: Result | None) -> tuple[str, ...]:
    cells = [
        f"{np.median(result.times):.0f}",
        f"{result.ratio(ours):.2g}" if ours else "–",
        f"{np.median(result.tails):.0f}",
    ]
    kept = "yes" if result.kept else "no"
    return (f"{contender.name} {version}", *cells, f"{1e3 * result.error:.2f}", kept, contender.what)


def main() -> None:
    options = parser(__doc__, "speed.md")
    options.add_argument("--steps", type=int, default=400)
    options.add_argument("--rounds", type=int, default=9, help="in which all systems take turns")
    arguments = options.parse_args()
    robot, loop = motion(arguments.steps)
    file = loop.save(CACHE / "two_arms.npz")
    results = {contender: Result() for contender in CONTENDERS}
    failures: dict[Contender, tuple[str, ...]] = {}
    running: dict[Contender, Peer] = {}
    with ExitStack() as stack:
        for contender in CONTENDERS:
            try:
                running[contender] = stack.enter_context(Peer(contender.script, "arms", file, contender.options))
            except UnavailableError as error:
                failures[contender] = (contender.name, *("–",) * 5, str(error))
        for number in range(arguments.rounds):
            progress.print(f"round {number + 1} of {arguments.rounds}")
            for contender in (each for each in CONTENDERS if each not in failures):
                try:
                    done, result = running[contender].round(), results[contender]
                except UnavailableError as error:
                    failures[contender] = (contender.name, *("–",) * 5, str(error))
                    continue
                result.times.append(done.cpu_us)
                result.tails.append(float(np.quantile(done.us, 0.99)))
                if number == 0:
                    result.judge(robot, loop, np.asarray(done.answers))
        versions = {
            contender: peer.hello["version"] for contender, peer in running.items() if contender not in failures
        }
    ours = None if CONTENDERS[0] in failures else results[CONTENDERS[0]]
    rows = [failures.get(each) or row(each, versions[each], results[each], ours) for each in CONTENDERS]
    publish(markdown(COLUMNS, rows, text_last=True), "speed.md", "two_arm_steps", write=arguments.write)


if __name__ == "__main__":
    main()
