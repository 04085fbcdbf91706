"""Holds the left hand of a Baxter in a pose seen from its right hand, while the right hand moves."""

import numpy as np

import robust_ik as rik

robot = rik.load("baxter", tip="left_gripper", whole_tree=True)
q, right, left = robot.rest, "right_gripper", "left_gripper"
held = np.linalg.inv(robot.pose(q, right)) @ robot.pose(q, left)  # as one box is held by both
target = robot.pose(q, right).copy()
target[:3, 3] += (0.05, 0.05, 0.05)
stack = [
    [rik.RelativeTask(left, right, held, gain=10.0)],  # first, that the box is not pulled apart
    [rik.FrameTask(target, gain=2.0, frame=right, max_linear=0.1, max_angular=0.5)],
]
controller, worst = rik.VelocityController(robot), 0.0
for _ in range(500):
    q = robot.integrate(q, 0.01 * controller.step(q, stack, 0.01).qdot)
    now = np.linalg.inv(robot.pose(q, right)) @ robot.pose(q, left)
    worst = max(worst, float(np.linalg.norm(rik.pose_error(now, held)[:3])))
missing = np.linalg.norm(rik.pose_error(robot.pose(q, right), target)[:3])
print(f"right hand {1000 * missing:.2f} mm from its target; hands never more than {1000 * worst:.2f} mm off each other")
