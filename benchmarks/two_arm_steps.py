"""Times one control step of two arms on one torso against Pink, mink and PlaCo: fourteen joints, 18 rows and a posture.

`python -m benchmarks.two_arm_steps` prints a table: Baxter's hands carry something along a circle, so that both poses
and the one relative to the other are asked for, within joint limits. All systems read one URDF of the joints alone,
and get the configurations and targets of one motion. See benchmarks/peers/README.md.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import robust_ik as rik
from benchmarks.environments import CACHE
from benchmarks.loop_runs import bare, loop_of
from benchmarks.peers.loops import Loop
from benchmarks.step_turns import Contender, rows_of, take_turns
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


def judged(robot: rik.Robot, loop: Loop, qdot: np.ndarray) -> list[str]:
    """The median distance of the worse hand from its target after a step, mm, and whether limits are kept.

    They are kept if speeds are to 1e-4 of their limits, and positions to 1e-4 rad.
    """
    ends = loop.q + DT * qdot
    after = np.stack([robot.pose(ends, tip)[:, :3, 3] for tip in loop.tips], axis=1)
    error = float(np.median(np.linalg.norm(after - loop.targets[:, :, :3, 3], axis=-1).max(axis=1)))
    over = np.maximum(ends - robot.upper, robot.lower - ends).max()
    kept = (np.abs(qdot) / robot.velocity_limit).max() < 1 + 1e-4 and over < 1e-4
    return [f"{1e3 * error:.2f}", "yes" if kept else "no"]


def main() -> None:
    options = parser(__doc__, "speed.md")
    options.add_argument("--steps", type=int, default=400)
    options.add_argument("--rounds", type=int, default=9, help="in which all systems take turns")
    arguments = options.parse_args()
    robot, loop = motion(arguments.steps)
    cells: dict[Contender, list[str]] = {}

    def judge(contender: Contender, qdot: np.ndarray) -> None:
        cells[contender] = judged(robot, loop, qdot)

    found = take_turns(CONTENDERS, "arms", loop.save(CACHE / "two_arms.npz"), arguments.rounds, judge)
    rows = rows_of(found, cells, 5)
    publish(markdown(COLUMNS, rows, text_last=True), "speed.md", "two_arm_steps", write=arguments.write)


if __name__ == "__main__":
    main()
