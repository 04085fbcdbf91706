"""A scenario from many starts at once: where a run ends up may hang on its start by a hair's breadth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import robust_ik as rik
from robust_ik.checks import Array
from robust_ik.control.resolvers.classical_projections import LeakingPriority
from robust_ik.control.tasks import FrameTask, PostureTask, Task
from robust_ik.inverses import RobustInverse
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.simulation.scenario import Motion, Scenario
from robust_ik.simulation.scenarios import load_scenario

CORRECTIONS = 4
TINY, COUNT = 1e-12, 5
loaded = cache(load_scenario)
"""Scenarios, each read once, so that their paths are walked once."""


@dataclass(frozen=True, eq=False)
class Runs:
    """N runs of T steps.

    Attributes:
        time: (T,), s.
        q: (T, N, nq).
        qdot: (T, N, n).
        error: Target minus pose, (T, N, 6): m, then rad.
        sigma: Singular values of the Jacobian, (T, N, k).
        place: Where the tip is, (T, N, 3), m.
    """

    time: Array
    q: Array
    qdot: Array
    error: Array
    sigma: Array
    place: Array

    @property
    def position_error(self) -> Array:
        """(T, N), m."""
        return np.asarray(np.linalg.norm(self.error[..., :3], axis=-1))

    @property
    def rotation_error(self) -> Array:
        """(T, N), rad."""
        return np.asarray(np.linalg.norm(self.error[..., 3:], axis=-1))

    @property
    def speed(self) -> Array:
        """Largest |q̇| of any joint, (T, N)."""
        return np.asarray(np.abs(self.qdot).max(axis=-1))

    @property
    def manipulability(self) -> Array:
        """Π σ, (T, N)."""
        return np.asarray(np.prod(self.sigma, axis=-1))


def run_many(scenario: Scenario, label: str, starts: Array, jitter: float = 0.0) -> Runs:
    """What `simulate` does, for all starts (N, nq) at once; without limits.

    The scenario's motion is a frame's, with at most a posture below it; the method is an inverse, which stands for
    `TaskPriority`, or a `LeakingPriority`. With jitter each step of all runs but the first is off by at most so much:
    where runs come to rest they forget their starts, but not what rounding does to them later.
    """
    if scenario.limits != ():
        raise TypeError(f"{scenario.name} has limits")
    robot, method, q = scenario.robot, scenario.method(label), np.asarray(starts)
    found: dict[str, list[Array]] = {name: [] for name in ("q", "qdot", "error", "sigma", "place")}
    rows, rng = [ROWS.index(row) for row in robot.rows], np.random.default_rng(0)
    time = scenario.dt * np.arange(round(scenario.duration / scenario.dt))
    for stack in _stacks(scenario.motion, scenario.dt, len(time)):
        J, pose = robot.jacobian(q), robot.pose(q)
        error = np.zeros((len(q), 6))
        error[:, rows] = rik.pose_error(pose, stack[0].target)[:, rows]
        qdot = _velocity(scenario, method, J, _feedback(stack[0], error)[:, rows], q, stack[1:])
        for name, each in zip(found, (q, qdot, error, rik.svd(J).s, pose[:, :3, 3])):
            found[name].append(each)
        off = rng.uniform(-jitter, jitter, qdot.shape)
        off[0] = 0.0
        q = robot.integrate(q, scenario.dt * qdot + off)
    return Runs(time, **{name: np.array(each) for name, each in found.items()})


@cache
def _stacks(motion: Motion, dt: float, steps: int) -> list[list[Any]]:
    """The tasks at each step, those of all levels in a row; paths take longer than all else."""
    found = []
    for i in range(steps):
        levels = motion(i * dt) if callable(motion) else motion
        found.append([task for level in levels for task in level])
    if not isinstance(found[0][0], FrameTask):
        raise TypeError("the motion has no target pose")
    return found


def _feedback(task: FrameTask, error: Array) -> Array:
    caps = np.repeat([task.max_linear, task.max_angular], 3)
    norms = np.repeat([np.linalg.norm(part, axis=-1) for part in (error[:, :3], error[:, 3:])], 3, axis=0).T
    capped = error * np.minimum(1.0, caps / np.maximum(norms, 1e-300))
    return np.asarray(task.gain * capped + task.feedforward)


def _velocity(scenario: Scenario, method: object, J: Array, xdot: Array, q: Array, below: Sequence[Task]) -> Array:
    inverse = method.inverses[0] if isinstance(method, LeakingPriority) else method
    if not isinstance(inverse, RobustInverse) or len(below) > 1:
        raise TypeError(f"{method} does not run from many starts at once")
    qdot = inverse.solve(J, xdot)
    for posture in below:
        if not isinstance(posture, PostureTask):
            raise TypeError(f"{posture} does not run from many starts at once")
        off = scenario.robot.difference(q, np.broadcast_to(posture.target, q.shape))
        wish = np.clip(posture.gain * off, -posture.max_speed, posture.max_speed)
        if isinstance(method, LeakingPriority):
            given = np.stack([inverse.solve(J, J[..., k]) for k in range(J.shape[-1])], axis=-1)
            qdot = qdot + wish - (given @ wish[..., None])[..., 0]
        else:
            free = rik.null_projector(J)
            qdot = qdot + (free @ inverse.solve(free, wish - qdot)[..., None])[..., 0]
    return qdot


def along_self_motion(scenario: Scenario, distances: Sequence[float] | Array, seed: int = 0) -> Array:
    """Configurations of the start's pose, so far away along its self-motion, (N, nq).

    With one joint to spare the sign of the distance is the direction; with more the direction is random.
    """
    robot, rng, distances = scenario.robot, np.random.default_rng(seed), np.asarray(distances)
    wanted, J = robot.pose(scenario.q0), robot.jacobian(scenario.q0)
    free = np.linalg.svd(J)[2][len(J) :]
    free = free * np.sign(free[np.arange(len(free)), np.abs(free).argmax(axis=1)])[:, None]
    mixed = np.ones((len(distances), 1)) if len(free) == 1 else rng.normal(size=(len(distances), len(free)))
    directions = mixed / np.linalg.norm(mixed, axis=1, keepdims=True) @ free
    q = robot.integrate(scenario.q0, distances[:, None] * directions)
    for _ in range(CORRECTIONS):
        q = robot.integrate(q, rik.MoorePenrose().solve(robot.jacobian(q), rik.pose_error(robot.pose(q), wanted)))
    return np.asarray(q)


def hair_apart(scenario: Scenario, amount: float = TINY, count: int = COUNT, seed: int = 0) -> Array:
    """The start, and others that differ from it by rounding, (1 + count, nq)."""
    moves = np.random.default_rng(seed).uniform(-amount, amount, (count, scenario.robot.n))
    begin = scenario.robot.integrate(scenario.q0, np.zeros_like(moves))
    return np.concatenate([scenario.q0[None], scenario.robot.integrate(begin, moves)])
