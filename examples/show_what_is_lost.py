"""Draws the motion that an arm has lost at a configuration, and says it in words and numbers."""

import numpy as np

import robust_ik as rik
from robust_ik.display import Scene, draw_configuration

robot = rik.load("ur5")
q = robot.configuration([0.4, -1.0, 0.0, -0.7, 0.9, 0.0])  # the elbow is straight
s = rik.svd(robot.jacobian(q)).s
print(f"singular values {np.array2string(s, precision=3)}, corank {(s < 1e-9 * s[0]).sum()}")
print(rik.explain(robot.jacobian(q), [0.1, 0, 0, 0, 0, 0], rik.JParse()))
scene = Scene()
draw_configuration(scene, robot, q)
print(scene.save("lost.html"))
