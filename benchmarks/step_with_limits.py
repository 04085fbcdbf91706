"""Times one control step with limits against Pink, mink and PlaCo: a Panda's hand first, its posture second.

`python -m benchmarks.step_with_limits` gives every peer an environment of its own below out/peers, from the versions
pinned in benchmarks/peers, and prints a table. Every system gets the same URDF, configurations and targets, and is
asked for the whole way to the target in one step; a step includes kinematics. See benchmarks/peers/README.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

import robust_ik as rik
from benchmarks.chains import Chain
from benchmarks.environments import CACHE, Peer, UnavailableError, progress
from benchmarks.peers.timing import Work
from benchmarks.step_turns import Contender
from benchmarks.tables import markdown, parser, publish
from benchmarks.works import arm, work_of

DT, SEED = 0.01, 1
REST = np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
FAR, NEAR = (0.05, 0.1), (0.002, 0.004)
"""How far targets are, m and rad: beyond the speed limits in one step; or at 0.2 m/s and 0.4 rad/s."""
TOLERANCE = 1e-4  # of a speed limit, and rad: DAQP's own is 1e-6 of the step
COLUMNS = (
    "system", "far [µs]", "ratio to ours", "at a limit", "near [µs]", "ratio to ours", "at a limit", "limits kept",
    "what it does",
)  # fmt: skip


CONTENDERS = (
    Contender("robust_ik, `ControlLoop`", "robust_ik", "strict; the default", ("--form", "prepared")),
    Contender("robust_ik, `controller.step`", "robust_ik", "the same, with new tasks"),
    Contender(
        "robust_ik, `ControlLoop`, `Saturation`",
        "robust_ik",
        "strict; keeps the direction",
        ("--form", "prepared", "--limiter", "saturation"),
    ),
    Contender(
        "robust_ik, `ControlLoop`, `QuadraticProgram`",
        "robust_ik",
        "strict; a QP a level",
        ("--form", "prepared", "--limiter", "quadratic_program"),
    ),
    Contender("Pink", "pink", "weighted, one QP (DAQP); damped"),
    Contender("mink", "mink", "weighted, one QP (DAQP); MuJoCo"),
    Contender("PlaCo, soft", "placo", "weighted, one QP in C++"),
    Contender("PlaCo, scaled", "placo", "hand strict, keeps the direction; one QP in C++", ("--priority", "scaled")),
)


def moves(robot: rik.Robot, chain: Chain, steps: int, distance: float, angle: float) -> Work:
    """Configurations anywhere within the limits, and targets that far away in any direction; always the same ones."""
    rng = np.random.default_rng(SEED)
    q = robot.random(rng, steps)
    poses = robot.pose(q)
    aside, axis = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in rng.normal(size=(2, steps, 3)))
    targets = poses.copy()
    targets[:, :3, 3] += distance * aside
    cross = np.cross(axis[:, None, :], np.eye(3)).swapaxes(-1, -2)  # cross @ v = axis × v
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    targets[:, :3, :3] = turn @ targets[:, :3, :3]
    return work_of(robot, chain, q, targets, posture=REST, dt=DT)


@dataclass
class Result:
    """What one contender made of one kind of work.

    Attributes:
        medians: µs per step, one median a round.
        at_limit: Share of the steps with a joint at one of its limits.
        kept: Whether all limits are kept.
    """

    medians: list[float] = field(default_factory=list)
    at_limit: float = 0.0
    kept: bool = True

    @property
    def us(self) -> float:
        """The median of the medians."""
        return float(np.median(self.medians))

    def judge(self, robot: rik.Robot, q: np.ndarray, qdot: np.ndarray) -> None:
        """Looks at the joint velocities of one round."""
        speed = np.abs(qdot) / robot.velocity_limit
        after = q + DT * qdot
        over = np.maximum(after - robot.upper, robot.lower - after)
        self.at_limit = float(((speed > 0.999) | (over > -1e-4)).any(axis=-1).mean())
        self.kept &= bool(speed.max() < 1 + TOLERANCE and over.max() < TOLERANCE)


def row(contender: Contender, version: str, results: list[Result], ours: list[Result] | None) -> tuple[str, ...]:
    cells = [f"{contender.name} {version}"]
    for result, own in zip(results, ours or (None, None)):
        cells += [f"{result.us:.1f}", f"{result.us / own.us:.2g}" if own else "–", f"{result.at_limit:.0%}"]
    return (*cells, "yes" if all(result.kept for result in results) else "no", contender.what)


def main() -> None:
    options = parser(__doc__, "task_stacks.md")
    options.add_argument("--steps", type=int, default=2000)
    options.add_argument("--rounds", type=int, default=3, help="interleaved: all systems, then all again")
    arguments = options.parse_args()
    robot, chain = arm("panda")
    kinds = {"far": FAR, "near": NEAR}
    works = {kind: moves(robot, chain, arguments.steps, *apart) for kind, apart in kinds.items()}
    files = {kind: made.save(CACHE / f"{kind}.npz") for kind, made in works.items()}
    results = {contender: [Result(), Result()] for contender in CONTENDERS}
    failures, versions = {}, {}
    for number in range(arguments.rounds):
        for contender in (each for each in CONTENDERS if each not in failures):
            progress.print(f"round {number + 1} of {arguments.rounds}: {contender.name}")
            try:
                for kind, result in zip(kinds, results[contender]):
                    with Peer(contender.script, "step", files[kind], contender.options) as running:
                        done = running.round()
                    versions[contender] = running.hello["version"]
                    result.medians.append(float(np.median(done.us)))
                    result.judge(robot, works[kind].q, np.asarray(done.answers))
            except UnavailableError as error:
                failures[contender] = (contender.name, *("–",) * 7, str(error))
    ours = None if CONTENDERS[0] in failures else results[CONTENDERS[0]]
    rows = [failures.get(each) or row(each, versions[each], results[each], ours) for each in CONTENDERS]
    table = markdown(COLUMNS, rows, text_last=True)
    publish(table, "task_stacks.md", "step", write=arguments.write)


if __name__ == "__main__":
    main()
