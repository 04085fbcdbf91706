"""Solves a thousand poses at once, within joint limits."""

import time

import numpy as np

import robust_ik as rik

robot = rik.load("panda")
targets = robot.pose(robot.random(np.random.default_rng(0), 1000))
robot.solve_poses(targets[:1])  # compiles once on this machine
began = time.perf_counter()
found = robot.solve_poses(targets)
seconds = time.perf_counter() - began
missed = np.linalg.norm(rik.pose_error(robot.pose(found.q), targets), axis=-1)
print(f"{(missed < 1e-6).sum()} of {len(targets)} solved in {1000 * seconds:.0f} ms, worst error {missed.max():.1e}")
