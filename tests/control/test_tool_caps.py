"""How fast a tool is whose task has caps, whatever limiter fits it into the limits."""

import math

import numpy as np
import pytest

import robust_ik as rik
from tests import closed_loop
from tests.cases_resolvers import LIMITERS
from tests.conftest import moved_start


@pytest.mark.parametrize("limiter", LIMITERS, ids=repr)
def test_the_twist_of_a_capped_frame_is_never_longer_than_its_caps_allow_together(limiter):
    """Without acceleration limits; near singularities and at limits its linear part may be faster than its cap."""
    rng, fastest = np.random.default_rng(11), []
    for name in ("panda", "ur5", "z1", "puma560"):
        robot, (lower, upper, _) = closed_loop.arm(name), closed_loop.ends(name)
        for _ in range(3):
            q, there = rng.uniform(lower, upper, (2, robot.n))
            task = rik.FrameTask(robot.pose(there), gain=5.0, max_linear=0.04, max_angular=0.2)
            resolver = rik.TaskPriority(rik.JParse(0.01), limiter, steady=True)
            loop = rik.ControlLoop(
                rik.VelocityController(robot, resolver, closed_loop.limits(name, "joints")), task, 0.01
            )
            found = loop.runs(moved_start(robot, q)[None], 600)
            starts = np.concatenate([q[None], found.q[0][:-1]])
            twists = np.einsum("kij,kj->ki", robot.jacobian(starts), found.qdot[0])
            fastest.append(np.linalg.norm(twists, axis=1).max())
    assert max(fastest) <= 1.005 * math.hypot(0.2, 1.0)
    assert max(fastest) > 0.9 * math.hypot(0.2, 1.0)
