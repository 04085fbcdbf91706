"""Whole motions to a target that stands still, drawn at random, and whether they come to rest.

A draw is an arm, a start, a target (anywhere, out of reach, or beyond joints that are at their limits), a resolver, a
limiter, a step, exact or with noise and lag, and limits: of joints, with acceleration, with collisions. It runs until
it rests or time is up. `python -m tests.soak --loops` runs many.
"""

import functools
from dataclasses import dataclass

import numpy as np

import robust_ik as rik
from robust_ik.control.limits import HalfSpace, Obstacle
from robust_ik.description.joint_tree import Box
from tests.cases_resolvers import LIMITERS
from tests.conftest import moved_start

ARMS = {
    "xarm7": {},
    "panda": {},
    "kinova_gen3": {},
    "ur5": {},
    "ur10": {},
    "z1": {},
    "so101": {},
    "puma560": {},
    "pa10": {},
    "kinova": {},
    "srs_7r": {},  # as an iiwa
    "baxter": {"tip": "left_gripper", "whole_tree": True},  # two arms
}
WIDEST = 2.8
"""Limits of joints that have none, rad; and half their speed limit, rad/s."""
KINDS = ("anywhere", "out of reach", "at limits")
SURROUNDINGS = ("joints", "acceleration", "collision")
STEPS = (0.001, 0.005, 0.01, 0.02)
NOISE, LAG = 1e-4, 0.02
"""Standard deviation of what is measured, rad; time constant of what is driven, s."""
REST = 1e-3
"""Joint speeds below this are rest, rad/s or m/s."""
INVERSES = [rik.JParse(0.01), rik.JParse(), rik.DampedLeastSquares(0.1), rik.Chiaverini()]


@dataclass(frozen=True, eq=False)
class Draw:
    """One motion, as arguments of `run`."""

    arm: str
    kind: str
    resolver: rik.Resolver
    posture: bool
    dt: float
    noisy: bool
    surroundings: str
    seed: int

    def __str__(self):
        return (
            f"{self.arm}, target {self.kind}, {self.resolver}{', posture' if self.posture else ''}, dt {self.dt}"
            f"{', noise and lag' if self.noisy else ''}, {self.surroundings}, seed {self.seed}"
        )


@dataclass(frozen=True, eq=False)
class Ending:
    """How a motion ended: what was asked for in the last half second.

    Attributes:
        error: Distance of the tool from where it should be, m.
        speed: The largest joint speed.
        chatters: Whether a joint is faster than 1 % of its speed limit and changes its sign five times or more; with
            noise, whether one shakes by over 20 times what the noise makes of a joint that is held by its own gain.
        outside: How far a joint was outside its limits at most.
        seconds: How long it ran.
    """

    error: float
    speed: float
    chatters: bool
    outside: float
    seconds: float


@functools.cache
def arm(name):
    return rik.load(name, **ARMS[name])


@functools.cache
def ends(name):
    """Lower, upper and speed limits, all of them finite."""
    robot = arm(name)
    speeds = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, 2 * WIDEST)
    return np.maximum(robot.lower, -WIDEST), np.minimum(robot.upper, WIDEST), np.minimum(speeds, 2 * WIDEST)


@functools.cache
def limits(name, surroundings):
    if surroundings == "none":
        return ()
    robot, (lower, upper, speeds) = arm(name), ends(name)
    acceleration = 10.0 if surroundings == "acceleration" else np.inf
    joints = rik.JointLimits.of(robot, lower=lower, upper=upper, velocity=speeds, acceleration=acceleration)
    if surroundings != "collision":
        return (joints,)
    wall, board = np.eye(4), Box((0.4, 0.4, 0.02))
    wall[:3, 3] = 0.35 * robot.size, 0.35 * robot.size, 0.3 * robot.size
    standing = [Obstacle("table", HalfSpace((0.0, 0.0, 1.0), -0.1 * robot.size)), Obstacle("board", board, wall)]
    return joints, rik.CollisionLimit.of(robot, obstacles=standing)


def draw(rng, *, arms=tuple(ARMS), surroundings=SURROUNDINGS, steps=STEPS):
    limiter, inverse = LIMITERS[rng.integers(len(LIMITERS))], INVERSES[rng.integers(len(INVERSES))]
    kind = (rik.TaskPriority, rik.DecoupledPriority, rik.TaskReconstruction, rik.WeightedPriority)[rng.integers(4)]
    how = {"steady": bool(rng.random() < 0.5)}
    resolver = rik.WeightedPriority(inverse, **how) if kind is rik.WeightedPriority else kind(inverse, limiter, **how)
    return Draw(
        str(rng.choice(arms)), str(rng.choice(KINDS)), resolver, bool(rng.random() < 0.3), float(rng.choice(steps)),
        bool(rng.random() < 0.5), str(rng.choice(surroundings)), int(rng.integers(1 << 30)),
    )  # fmt: skip


def start_and_target(name, kind, seed):
    """Joint values inside the limits, and a pose."""
    rng, robot = np.random.default_rng(seed), arm(name)
    lower, upper, _ = ends(name)
    q, there = rng.uniform(lower, upper, (2, robot.n))
    if kind == "at limits":
        some = rng.random(robot.n) < 0.3
        q = np.where(some, np.where(rng.random(robot.n) < 0.5, lower, upper), q)
        there = np.where(some, q + np.sign(q - (lower + upper) / 2) * rng.uniform(0, 0.5, robot.n), there)
    target = robot.pose(robot.configuration(there)).copy()
    if kind == "out of reach":
        target[:3, 3] += rng.uniform(1.0, 2.0) * robot.size * target[:3, 3] / np.linalg.norm(target[:3, 3])
    return robot.configuration(q), target


def run(each, *, seconds=60.0, steps=12_000, start=None):
    """The motion until it has rested for half a second, or is cut off; from other joint values than it has drawn.

    What a prepared loop does in one compiled call runs until it is cut off, which takes less time than to look at it.
    """
    robot, (lower, upper, speeds) = arm(each.arm), ends(each.arm)
    q, target = start_and_target(each.arm, each.kind, each.seed)
    q = moved_start(robot, q if start is None else robot.configuration(start))
    stack = [[rik.FrameTask(target, gain=5.0, max_linear=0.2, max_angular=1.0)]]
    if each.posture:
        stack.append([rik.PostureTask(robot.rest, gain=2.0)])
    controller = rik.VelocityController(robot, each.resolver, limits(each.arm, each.surroundings))
    loop, count = rik.ControlLoop(controller, stack, each.dt), int(min(seconds / each.dt, steps))
    last = int(0.5 / each.dt)
    if loop.compiled:
        how = {"noise": NOISE, "lag": LAG, "seed": each.seed} if each.noisy else {}
        found = loop.runs(q[None], count, **how)
        asked, all_q = found.qdot[0], found.q[0]
    else:
        asked, all_q = _stepped(each, loop, q, count, last)
    values, tail = robot.joint_values(all_q), np.array(asked[-last:])
    outside = float(np.max(np.maximum(values - upper, lower - values)))
    shakes = noise_shakes(tail, each.dt) if each.noisy else shaking(tail, speeds)
    error = float(np.linalg.norm(robot.pose(all_q[-1])[:3, 3] - target[:3, 3]))
    return Ending(error, float(np.abs(tail).max()), shakes, outside, len(asked) * each.dt)


def _stepped(each, loop, q, count, last):
    """Velocities and configurations of a motion step by step, until it rests."""
    robot, rng = loop.controller.robot, np.random.default_rng(each.seed)
    moving, asked, all_q = np.zeros(robot.n), [], []
    for taken in range(count):
        measured = robot.integrate(q, NOISE * rng.normal(size=robot.n)) if each.noisy else q
        asked.append(loop.step(measured).copy())
        moving = moving + (1 - np.exp(-each.dt / LAG) if each.noisy else 1.0) * (asked[-1] - moving)
        q = robot.integrate(q, each.dt * moving)
        all_q.append(q)
        if taken % last == last - 1 and np.abs(asked[-last:]).max() < REST / 10:
            break
    return asked, np.array(all_q)


def shaking(qdot, speed_limit):
    """Whether a joint is faster than 1 % of its limit and changes the sign of its velocity five times or more.

    The signs of what rounding leaves at rest do not count.
    """
    turns = (np.diff(np.sign(np.where(np.abs(qdot) < REST / 1000, 0.0, qdot)), axis=0) != 0).sum(axis=0)
    return bool(((np.abs(qdot).max(axis=0) > 0.01 * speed_limit) & (turns >= 5)).any())


def noise_shakes(qdot, dt):
    """Whether steps of a joint's velocity are over 20 times as large as a gain of 20/s, or 1/dt, makes of the noise."""
    made = np.sqrt(2) * NOISE * min(20.0, 1 / dt)
    return bool(np.std(np.diff(qdot, axis=0), axis=0).max() > 20 * made)
