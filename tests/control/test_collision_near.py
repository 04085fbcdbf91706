"""Started too near, in fast and long steps: no pair ever comes nearer, unless the resolution says that it had to."""

from dataclasses import replace

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits import CollisionLimit, HalfSpace, Limit, Obstacle
from tests.control.test_collision import around, planar

RESOLVERS = [
    rik.TaskPriority(),
    rik.TaskPriority(rik.JParse(), rik.QuadraticProgram()),
    rik.TaskPriority(rik.FilteredInverse(), rik.Scaling()),
    rik.WeightedPriority(rik.DampedLeastSquares()),
]
NEARER = 1e-6


def in_the_plane():
    """A tip over a shelf that has no say about the links: circles about joints below the shelf bend into it."""
    robot = planar()
    return robot, CollisionLimit.of(robot, obstacles=[Obstacle("shelf", HalfSpace((0, 1, 0), 0.3))])


def arm(name):
    robot = rik.load(name)
    return robot, CollisionLimit.of(robot, obstacles=around())


@pytest.fixture(scope="module", params=["planar", "ur5"])
def watched(request):
    return in_the_plane() if request.param == "planar" else arm(request.param)


def distances(limit, robot, q):
    return {each.names: each.distance for each in limit.distances(robot, q)}


def too_near(robot, limit, rng):
    while True:
        q = robot.random(rng)
        if -0.03 < limit.distances(robot, q)[0].distance < limit.distance:
            return q


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_what_is_too_near_never_comes_nearer_without_a_word(watched, dt):
    robot, limit = watched
    rng, moving = np.random.default_rng(1), 0
    for index in range(6):
        q, joints = too_near(robot, limit, rng), rik.JointLimits.of(robot)
        task = rik.FrameTask(robot.pose(robot.random(rng)), gain=50.0)
        both = [joints, limit] if index % 2 else [limit, joints]
        controller = rik.VelocityController(robot, RESOLVERS[index % len(RESOLVERS)], both)
        for _ in range(5):
            before = distances(limit, robot, q)
            step = controller.step(q, [[task]], dt)
            q = robot.integrate(q, dt * step.qdot)
            for names, there in distances(limit, robot, q).items():
                kept = there >= min(before[names], limit.distance) - NEARER
                assert kept or f"{names[0]} - {names[1]} distance" in step.contradictions
            moving += step.qdot.any()
            assert (np.abs(step.qdot) <= joints.velocity + 1e-9).all()
    assert moving > 10


def test_a_step_that_would_bend_into_something_is_asked_for_more(rng):
    """Along a tangent at full speed: of first order the distance stays, of second it falls."""
    robot, limit = in_the_plane()
    bent = 0
    for _ in range(20):
        q = too_near(robot, limit, rng)
        bounds = limit.bounds(robot, q, np.zeros(2), 0.1)
        for row in bounds.rows:
            qdot = 2.0 * np.array([-row[1], row[0]]) / np.linalg.norm(row)
            after = distances(limit, robot, robot.integrate(q, 0.1 * qdot))
            nearer = any(
                after[names] < min(there, limit.distance) - NEARER
                for names, there in distances(limit, robot, q).items()
            )
            tighter = limit.tightened(robot, q, qdot, 0.1, bounds)
            assert (tighter is not None) == nearer
            bent += nearer
            if tighter is not None:
                assert (tighter.floor[: len(bounds.floor)] >= bounds.floor).all()
                assert (tighter.rows @ qdot < tighter.floor).any()
    assert bent > 5


class Refused(Limit):
    """A limit of a user's own that no step keeps but standing still."""

    def bounds(self, robot, q, previous, dt):
        return rik.JointLimits.of(robot).bounds(robot, q, previous, dt)

    def tightened(self, robot, q, qdot, dt, bounds):
        return bounds if qdot.any() else None


def test_where_nothing_else_keeps_a_limit_the_robot_stands_still():
    robot = planar()
    controller = rik.VelocityController(robot, limits=Refused())
    step = controller.step(np.array([0.3, 0.4]), rik.PostureTask([1.0, 1.0]), 0.01)
    assert not step.qdot.any()
    assert step.status is rik.Status.STUCK


class NeverKept(Limit):
    """A limit of a user's own that every step breaks, the less the slower it is."""

    def bounds(self, robot, q, previous, dt):
        return Bounds.of_rows(np.eye(2), np.full(2, -100.0), ("one", "two"))

    def tightened(self, robot, q, qdot, dt, bounds):
        return replace(bounds, floor=bounds.rows @ qdot + 0.01 + np.abs(qdot).max())


def test_where_nothing_keeps_a_limit_the_motion_that_breaks_it_least_is_made():
    controller = rik.VelocityController(planar(), rik.JParse(), limits=NeverKept())
    step = controller.step(np.array([0.3, 0.4]), rik.PostureTask([1.0, 1.0]), 0.01)
    assert np.abs(step.qdot).max() < 0.02
    assert step.status is rik.Status.INFEASIBLE
    assert set(step.contradictions) == {"one", "two"}


class AskedToMove(NeverKept):
    """One of its rows asks for motion, the other is broken the less the slower a step is."""

    def bounds(self, robot, q, previous, dt):
        return Bounds.of_rows(np.eye(2), np.array([0.5, -100.0]), ("one", "two"))

    def tightened(self, robot, q, qdot, dt, bounds):
        return replace(bounds, floor=np.array([bounds.floor[0], qdot[1] + 0.01 + np.abs(qdot).max()]))


def test_rows_that_a_slower_motion_misses_are_named():
    controller = rik.VelocityController(planar(), rik.JParse(), limits=AskedToMove())
    step = controller.step(np.array([0.3, 0.4]), rik.PostureTask([1.0, 1.0]), 0.01)
    assert step.qdot[0] < 0.4
    assert set(step.contradictions) == {"one", "two"}
