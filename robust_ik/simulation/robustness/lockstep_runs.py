"""Runs scenarios of one robot side by side, by explicit Euler steps: kinematics of all of them are computed at once."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.tasks import pose_error
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.simulation.robustness.benchmark_methods import BenchmarkMethod, Commands
from robust_ik.simulation.robustness.benchmark_scenario import RobustnessScenario

WILD = 100.0
"""Commands are executed up to so many times a speed limit where there is no drive, so that numbers stay of use."""


@dataclass(frozen=True, eq=False)
class RunTrace:
    """What a method made of a scenario.

    Attributes:
        q: Joint values, (S + 1, n): at the start and after every step. Continuous joints are not wrapped.
        commanded: Joint velocities that the method gave, (S, n); zero where it failed.
        failed: In how many steps it raised an error or gave something that is not finite.
        seconds: Time of a step, s.
    """

    q: Array
    commanded: Array
    failed: int
    seconds: float


def run_scenarios(robot: Robot, scenarios: Sequence[RobustnessScenario], method: BenchmarkMethod) -> list[RunTrace]:
    """One run of each scenario; those with one time step go side by side.

    Args:
        robot: The scenarios' robot.
        scenarios: Any.
        method: Who computes joint velocities. It is told measured joint values, commands and errors.
    """
    found: dict[int, RunTrace] = {}
    for dt in dict.fromkeys(each.dt for each in scenarios):
        places = [place for place, each in enumerate(scenarios) if each.dt == dt]
        places.sort(key=lambda place: -scenarios[place].steps)
        found.update(zip(places, _lockstep(robot, [scenarios[place] for place in places], method)))
    return [found[place] for place in range(len(scenarios))]


class _Side:
    """The arrays of runs side by side, the longest first; a step is made for those that are not over yet."""

    def __init__(self, scenarios: Sequence[RobustnessScenario]) -> None:
        most, self.dt = scenarios[0].steps, scenarios[0].dt
        self.rows = [ROWS.index(row) for row in scenarios[0].rows]
        self.steps = np.array([each.steps for each in scenarios])
        self.targets = np.stack([_extended(each.targets, most + 1) for each in scenarios], axis=1)
        self.forward = np.stack([_extended(each.feedforward, most) for each in scenarios], axis=1)
        noise = [each.disturbances() for each in scenarios]
        self.of_joints, self.of_rows = (
            np.stack([_extended(pair[which], most) for pair in noise], axis=1) for which in range(2)
        )
        self.gain, self.cap = (np.array([[getattr(each, name)] for each in scenarios]) for name in ("gain", "cap"))
        self.units = np.array([each.units for each in scenarios])
        self.speed = np.array([each.speed for each in scenarios])
        self.reach = np.array([each.acceleration * each.dt for each in scenarios])
        self.drive = np.array([[each.drive] for each in scenarios])

    def command(self, k: int, pose: Array) -> tuple[Array, Array]:
        """What is asked for in step k at some poses, (N, 4, 4), and the errors there: (N, m) each."""
        N = len(pose)
        error = pose_error(pose, self.targets[k, :N])[:, self.rows]
        scaled = (self.forward[k, :N] + self.gain[:N] * error) / self.units[:N]
        size = np.linalg.norm(scaled, axis=1, keepdims=True)
        scaled *= np.minimum(1.0, self.cap[:N] / np.maximum(size, 1e-300))
        return np.asarray((scaled + self.of_rows[k, :N]) * self.units[:N]), error

    def executed(self, commanded: Array, last: Array) -> Array:
        """What the arm does of commands, (N, n): a drive slows them evenly into the speed limits, then cuts them."""
        N = len(commanded)
        speed, reach, drive = self.speed[:N], self.reach[:N], self.drive[:N]
        share = np.max(np.abs(commanded) / speed, axis=1, keepdims=True)
        slowed = commanded / np.maximum(share, 1.0)
        driven = np.clip(slowed, np.maximum(-speed, last - reach), np.minimum(speed, last + reach))
        return np.asarray(np.where(drive, driven, commanded * np.minimum(1.0, WILD / np.maximum(share, 1e-300))))


def _lockstep(robot: Robot, scenarios: Sequence[RobustnessScenario], method: BenchmarkMethod) -> list[RunTrace]:
    side, count, n = _Side(scenarios), len(scenarios), robot.n
    most = int(side.steps[0])
    values = np.empty((most + 1, count, n))
    commanded = np.zeros((most, count, n))
    failed = np.zeros(count, dtype=int)
    values[0] = [each.start for each in scenarios]
    q = robot.configuration(values[0])
    last = np.zeros((count, n))
    answer, spent, made = method.begin(robot, scenarios), 0.0, 0
    for k in range(most):
        N = int(np.sum(side.steps > k))
        q, last = q[:N], last[:N]
        measured = robot.integrate(q, side.of_joints[k, :N])
        xdot, error = side.command(k, robot.pose(measured))
        began = time.perf_counter()
        given, good = answered(answer, measured, xdot, error, n)
        spent, made = spent + time.perf_counter() - began, made + N
        failed[:N] += 1 - good
        commanded[k, :N] = given
        last = side.executed(given, last)
        q = robot.integrate(q, side.dt * last)
        values[k + 1, :N] = values[k, :N] + side.dt * last
    return [
        RunTrace(values[: each.steps + 1, i].copy(), commanded[: each.steps, i].copy(), int(failed[i]), spent / made)
        for i, each in enumerate(scenarios)
    ]


def answered(answer: Commands, q: Array, xdot: Array, error: Array, n: int) -> tuple[Array, NDArray[np.int_]]:
    """Joint velocities, (N, n), zero where there are none, and 1 where there are some, (N,).

    If a step of all runs together raises an error, all of them count as failed in it.
    """
    try:
        given = np.asarray(answer(q, xdot, error), dtype=float)
    except Exception:  # a method may raise anything
        given = np.full((len(q), n), np.nan)
    if given.shape != (len(q), n):
        given = np.full((len(q), n), np.nan)
    good = np.isfinite(given).all(axis=1)
    return np.where(good[:, None], given, 0.0), good.astype(int)


def _extended(array: Array, length: int) -> Array:
    """The array with its last row repeated."""
    return np.concatenate([array, np.repeat(array[-1:], length - len(array), axis=0)])
