"""Keeps a posture where the tool's task leaves freedom; or only keeps joints off the ends of their ranges."""

import numpy as np

import robust_ik as rik

robot = rik.load("panda")
start = robot.configuration([0.2, -0.4, 2.5, -2.0, 0.3, 2.0, 0.5])
target = robot.pose(start).copy()
target[:3, 3] += (0.1, -0.1, 0.05)
tool = rik.FrameTask(target, gain=5.0, max_linear=0.05, max_angular=0.4)

for name, below in (
    ("nothing below", []),
    ("a posture below", [rik.PostureTask(robot.rest)]),
    ("joint ranges below", [rik.JointRangeTask()]),
):
    controller, q = rik.VelocityController(robot), start
    for _ in range(2000):
        q = robot.integrate(q, 0.01 * controller.step(q, [[tool], below] if below else [tool], 0.01).qdot)
    error = np.linalg.norm(rik.pose_error(robot.pose(q), target))
    print(f"{name:<20} tool error {error:.0e}, elbow turned by {q[2] - start[2]:+.2f} rad")
