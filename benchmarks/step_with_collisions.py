"""Times one control step that keeps links and an obstacle apart, against Pink, mink and PlaCo with theirs.

`python -m benchmarks.step_with_collisions` prints a table: a Panda's hand first, its posture second, the robot's own
limits, its pairs of links that can meet, and a post beside which the hand moves. All systems read one URDF with convex
shapes, and the same pairs, distances, configurations and targets: those of a motion, one after the other. A step
includes kinematics and distances. See benchmarks/peers/README.md.
"""

from __future__ import annotations

import numpy as np

import robust_ik as rik
from benchmarks import solid_arm
from benchmarks.environments import CACHE
from benchmarks.peers.collision_pairs import KeptApart
from benchmarks.peers.timing import Work
from benchmarks.step_turns import Contender, rows_of, take_turns
from benchmarks.tables import markdown, parser, publish

DT, AHEAD = 0.01, 0.05
"""A step, s, and the share of the way to the moving place that targets are ahead of the hand."""
DISTANCE, INFLUENCE, DAMPER = 0.02, 0.1, 10.0
"""Least distance and influence, m, and the gain of the damper, 1/s: the defaults of `CollisionLimit`."""
POST = rik.Obstacle(
    "post", rik.Box((0.1, 0.1, 0.4)), np.array([[1.0, 0, 0, 0.55], [0, 1, 0, 0.25], [0, 0, 1, 0.4], [0, 0, 0, 1]])
)
"""Beside the way of the hand."""
COLUMNS = ("system", "a step [µs]", "ratio to ours", "p99 [µs]", "nearest after [mm]", "what it does")


CONTENDERS = (
    Contender(
        "robust_ik, `ControlLoop`",
        "robust_ik",
        "strict; `CollisionLimit`: a damper, and a look at where the step ends",
        ("--collisions", "yes", "--form", "prepared"),
    ),
    Contender("robust_ik, `controller.step`", "robust_ik", "the same, with new tasks", ("--collisions", "yes")),
    Contender("Pink, all pairs", "pink", "`SelfCollisionBarrier` of all pairs", ("--collisions", "all")),
    Contender("Pink, 8 pairs", "pink", "`SelfCollisionBarrier` of the nearest 8 pairs", ("--collisions", "8")),
    Contender("mink", "mink", "`CollisionAvoidanceLimit`, gain 0.85 a step", ("--collisions", "yes")),
    Contender("PlaCo", "placo", "its constraint; meshes as triangles", ("--collisions", "yes")),
)


def motion(steps: int) -> tuple[rik.Robot, rik.CollisionLimit, Work]:
    """A Panda's way around a post and past its own links, by our controller: what all systems are asked for."""
    path = CACHE / "panda_solid.urdf"
    panda = rik.load("panda")
    apart = {"distance": DISTANCE, "influence": INFLUENCE, "gain": DAMPER}
    told = rik.CollisionLimit.of(panda, obstacles=[POST], **apart)
    chain = solid_arm.write(panda, path, [POST])
    KeptApart(told.pairs, (POST.name,), DISTANCE, INFLUENCE, DAMPER).save(str(path))
    robot = rik.load(str(path), tip=chain.tip)
    limit = rik.CollisionLimit.of(robot, pairs=told.pairs, **apart)
    controller = rik.VelocityController(robot, rik.TaskPriority(rik.JParse()), [rik.JointLimits.of(robot), limit])
    posture, q = rik.PostureTask(panda.rest), panda.rest.copy()
    qs, targets = np.empty((steps, robot.n)), np.tile(robot.pose(q), (steps, 1, 1))
    angle = 2 * np.pi * np.arange(steps) / 400
    way = np.stack([0.5 + 0.12 * np.cos(angle), 0.35 * np.sin(angle), 0.45 + 0.1 * np.sin(2 * angle)], axis=-1)
    for index, target in enumerate(targets):
        here = robot.pose(q)[:3, 3]
        qs[index], target[:3, 3] = q, here + AHEAD * (way[index] - here)
        stack = [[rik.FrameTask(target, gain=1 / DT)], [posture]]
        q = robot.integrate(q, DT * controller.step(q, stack, DT).qdot)
    work = Work(
        q=qs, targets=targets, poses=robot.pose(qs), posture=panda.rest, lower=chain.lower, upper=chain.upper,
        speeds=chain.speeds, placements=chain.placements, tool=chain.tool, tolerance=np.zeros(2), joints=chain.joints,
        tip=chain.tip, urdf=str(path), dt=DT,
    )  # fmt: skip
    return robot, limit, work


def nearest(robot: rik.Robot, limit: rik.CollisionLimit, q: np.ndarray, qdot: np.ndarray) -> float:
    """The least distance of any pair after any of the steps, m."""
    ends = robot.integrate(q, DT * qdot)
    return min(limit.distances(robot, end)[0].distance for end in ends)


def main() -> None:
    options = parser(__doc__, "speed.md")
    options.add_argument("--steps", type=int, default=400)
    options.add_argument("--rounds", type=int, default=9, help="in which all systems take turns")
    arguments = options.parse_args()
    robot, limit, work = motion(arguments.steps)
    cells: dict[Contender, list[str]] = {}

    def judge(contender: Contender, qdot: np.ndarray) -> None:
        cells[contender] = [f"{1e3 * nearest(robot, limit, work.q, qdot):.1f}"]

    found = take_turns(CONTENDERS, "step", work.save(CACHE / "collisions.npz"), arguments.rounds, judge)
    rows = rows_of(found, cells, 4)
    publish(markdown(COLUMNS, rows, text_last=True), "speed.md", "step_with_collisions", write=arguments.write)


if __name__ == "__main__":
    main()
