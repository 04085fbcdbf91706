"""Says why an arm stands still short of its target, and goes on with a task that goes round."""

import numpy as np

import robust_ik as rik

robot = rik.load("panda")
target = robot.pose(robot.configuration([0.8, -0.8, -2.7, -3.0, 1.8, 3.4, 0.6]))  # behind several joint limits


def run(task, seconds=20.0, dt=0.01):
    """The configuration in the end."""
    controller, q = rik.VelocityController(robot), robot.rest
    for _ in range(int(seconds / dt)):
        q = robot.integrate(q, dt * controller.step(q, task, dt).qdot)
    return controller, q


straight = rik.FrameTask(target, gain=5.0, max_linear=0.1, max_angular=0.4)
controller, q = run(straight)
print(f"straight: {1000 * np.linalg.norm(rik.pose_error(robot.pose(q), target)[:3]):.1f} mm away")
print(rik.why_stuck(controller, q, straight))

_, q = run(rik.Reach(target, gain=5.0, max_linear=0.1, max_angular=0.4))
print(f"with Reach: {1000 * np.linalg.norm(rik.pose_error(robot.pose(q), target)[:3]):.4f} mm away")
