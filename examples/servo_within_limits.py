"""Brings a UR5's tool to a pose within the arm's limits, step by step, as a robot's control loop does."""

import robust_ik as rik

robot = rik.load("ur5")
q = robot.configuration([0.3, -1.2, 1.5, -0.8, -1.4, 0.2])
target = robot.pose(q).copy()
target[:3, 3] += (-0.2, 0.1, 0.15)  # m, in the base's axes

controller = rik.VelocityController(robot)  # joint positions and speeds of the URDF are its limits
task = rik.FrameTask(target, gain=5.0, max_linear=0.04, max_angular=0.2)  # at most 5 · 0.04 = 0.2 m/s
dt, seconds = 0.01, 0.0
while seconds < 10.0:
    step = controller.step(q, task, dt)
    q = robot.integrate(q, dt * step.qdot)  # a robot would be sent step.qdot, and q measured
    seconds += dt
    if abs(rik.pose_error(robot.pose(q), target)).max() < 1e-4:
        break
print(f"{step.status.name.lower()} after {seconds:.2f} s, error {abs(rik.pose_error(robot.pose(q), target)).max():.1e}")
