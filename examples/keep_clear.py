"""Goes to a pose, stays clear of a table and of itself, and says what stood in the way."""

import numpy as np

import robust_ik as rik

robot = rik.load("panda")
table = rik.Obstacle("table", rik.HalfSpace((0, 0, 1), 0.05))
clear = rik.CollisionLimit.of(robot, obstacles=[table], distance=0.02)
controller = rik.VelocityController(robot, limits=[rik.JointLimits.of(robot), clear])
q = robot.rest
target = robot.pose(q).copy()
target[2, 3] = 0.0  # in the table
task = rik.FrameTask(target, gain=5.0, max_linear=0.05, max_angular=0.4)
for _ in range(800):
    step = controller.step(q, task, 0.01)
    q = robot.integrate(q, 0.01 * step.qdot)
nearest = clear.distances(robot, q)[0]
print(step.text)
print(f"{' and '.join(nearest.names)} are {1000 * nearest.distance:.1f} mm apart")
print(f"{1000 * np.linalg.norm(rik.pose_error(robot.pose(q), target)[:3]):.0f} mm from the target")
