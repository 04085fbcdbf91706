"""Times one control step with limits against Pink, mink and PlaCo: a Panda's hand first, its posture second.

`python -m benchmarks.step_with_limits` gives every peer an environment of its own below out/peers, from the versions
pinned in benchmarks/peers, and prints a table. Every system gets the same URDF, configurations and targets, and is
asked for the whole way to the target in one step; a step includes kinematics. See benchmarks/peers/README.md.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console

import robust_ik as rik
from benchmarks.peers.timing import Work
from benchmarks.tables import markdown, parser, publish
from robust_ik.catalog import find

SCRIPTS = Path(__file__).parent / "peers"
CACHE = Path(__file__).parents[1] / "out" / "peers"
TIP, DT, SEED = "panda_hand_tcp", 0.01, 1
REST = np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
FAR, NEAR = (0.05, 0.1), (0.002, 0.004)
"""How far targets are, m and rad: beyond the speed limits in one step; or at 0.2 m/s and 0.4 rad/s."""
TOLERANCE = 1e-4  # of a speed limit, and rad: DAQP's own is 1e-6 of the step
COLUMNS = (
    "system", "far [µs]", "ratio to ours", "at a limit", "near [µs]", "ratio to ours", "at a limit", "limits kept",
    "what it does",
)  # fmt: skip
progress = Console(stderr=True)


class FailedError(Exception):
    """A system cannot be installed or does not run."""


@dataclass(frozen=True)
class Contender:
    """A row of the table.

    Attributes:
        name: What the row says.
        script: File in benchmarks/peers, without `_step.py`; also the environment and its requirements.
        what: How it resolves priorities and limits.
        options: Of the script.
    """

    name: str
    script: str
    what: str
    options: tuple[str, ...] = ()

    @property
    def python(self) -> str:
        """Its interpreter; made first where it is not there yet."""
        if self.script == "robust_ik":
            return sys.executable
        home, requirements = CACHE / self.script, SCRIPTS / f"requirements-{self.script}.txt"
        python, done = home / "bin" / "python", home / "installed.txt"
        wanted = requirements.read_text(encoding="utf-8")
        if not done.is_file() or done.read_text(encoding="utf-8") != wanted:
            progress.print(f"installing {self.script} …")
            call([sys.executable, "-m", "venv", "--clear", str(home)])
            call([str(python), "-m", "pip", "install", "--quiet", "--requirement", str(requirements)])
            done.write_text(wanted, encoding="utf-8")
        return str(python)

    def measure(self, work: Path, velocities: Path) -> dict:
        """What the script prints; joint velocities go to a file."""
        command = [self.python, str(SCRIPTS / f"{self.script}_step.py"), str(work), "--velocities", str(velocities)]
        return json.loads(call([*command, *self.options]).splitlines()[-1])


CONTENDERS = (
    Contender("robust_ik, `Saturation`", "robust_ik", "strict; keeps the direction"),
    Contender("robust_ik, `QuadraticProgram`", "robust_ik", "strict; a QP a level", ("--limiter", "quadratic_program")),
    Contender("Pink", "pink", "weighted, one QP (DAQP); damped"),
    Contender("mink", "mink", "weighted, one QP (DAQP); MuJoCo"),
    Contender("PlaCo, soft", "placo", "weighted, one QP in C++"),
    Contender("PlaCo, scaled", "placo", "hand strict, keeps the direction; one QP in C++", ("--priority", "scaled")),
)


def call(command: list[str]) -> str:
    """Standard output of a command, which gets one thread of BLAS.

    Raises:
        FailedError: It fails.
    """
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run(command, env={**os.environ, **one}, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise FailedError(lines[-1][:120].replace("|", "/"))
    return done.stdout


def plain_urdf(path: Path) -> Path:
    """Writes the Panda without shapes and with its fingers fixed: seven joints for everyone."""
    tree = ET.parse(find("panda").path)
    for link in tree.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    for joint in tree.findall("joint[@type='prismatic']"):
        joint.set("type", "fixed")
        for name in ("axis", "limit", "mimic"):
            for element in joint.findall(name):
                joint.remove(element)
    path.parent.mkdir(parents=True, exist_ok=True)
    tree.write(path)
    return path


def work(robot: rik.Robot, urdf: Path, steps: int, distance: float, angle: float) -> Work:
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
    return Work(q, targets, poses, REST, robot.velocity_limit, robot.joint_names, TIP, str(urdf), DT)


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
        cells += [f"{result.us:.0f}", f"{result.us / own.us:.2g}" if own else "–", f"{result.at_limit:.0%}"]
    return (*cells, "yes" if all(result.kept for result in results) else "no", contender.what)


def main() -> None:
    options = parser(__doc__, "task_stacks.md")
    options.add_argument("--steps", type=int, default=2000)
    options.add_argument("--rounds", type=int, default=3, help="interleaved: all systems, then all again")
    arguments = options.parse_args()
    urdf = plain_urdf(CACHE / "panda.urdf")
    robot = rik.load(str(urdf), tip=TIP)
    works = (CACHE / "far.npz", CACHE / "near.npz")
    for path, (distance, angle) in zip(works, (FAR, NEAR)):
        work(robot, urdf, arguments.steps, distance, angle).save(path)
    q, velocities = Work.read(works[0]).q, CACHE / "velocities.npy"
    results = {contender: [Result(), Result()] for contender in CONTENDERS}
    failures, versions = {}, {}
    for number in range(arguments.rounds):
        for contender in (each for each in CONTENDERS if each not in failures):
            progress.print(f"round {number + 1} of {arguments.rounds}: {contender.name}")
            try:
                for path, result in zip(works, results[contender]):
                    line = contender.measure(path, velocities)
                    versions[contender] = line["version"]
                    result.medians.append(line["us_per_step"]["median"])
                    result.judge(robot, q, np.load(velocities))
            except FailedError as error:
                failures[contender] = (contender.name, *("–",) * 7, f"failed: {error}")
    ours = None if CONTENDERS[0] in failures else results[CONTENDERS[0]]
    rows = [failures.get(each) or row(each, versions[each], results[each], ours) for each in CONTENDERS]
    table = markdown(COLUMNS, rows, text_last=True)
    publish(table, "task_stacks.md", "step", write=arguments.write)


if __name__ == "__main__":
    main()
