"""What is measured of a run: from joint values alone, the same way for every method."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.tasks import pose_error
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.simulation.robustness.benchmark_scenario import RobustnessScenario
from robust_ik.simulation.robustness.lockstep_runs import RunTrace

LEFT = 0.25
"""A singular configuration has been left where so much of the first error remains."""
SHAKE = 0.05
"""Accelerations below this share of their limit do not count for chatter."""
OVER = 1e-6
"""A speed or an acceleration is over its limit from this share of it on."""
POINTS = 60
"""Points of a curve that is kept."""


@dataclass(frozen=True)
class RunScore:
    """Numbers of one run; errors are in scaled rows, rad.

    Attributes:
        kept: Root mean square of the error in the directions that are kept at the singular configuration.
        kept_peak: Its largest.
        lost: Root mean square of the error in the lost directions.
        final: The whole error at the end.
        leave: Seconds until a quarter of the first error remains, the whole run if it never does; nan where the
            scenario asks for no leaving.
        left: Whether it does; nan likewise.
        speed: The largest commanded speed of a joint over its limit.
        chatter: How often joints change the sign of their acceleration, 1/s, mean of all joints.
        violations: Share of the steps that are executed beyond a speed or an acceleration limit.
        failed: Share of the steps in which the method gave no velocities.
        rest: The largest speed of a joint over its limit in the last tenth of the run.
        cost: Time of a step, μs.
        curves: Error kept, error lost and commanded speed over limit at POINTS times; empty if they are not kept.
    """

    kept: float
    kept_peak: float
    lost: float
    final: float
    leave: float
    left: float
    speed: float
    chatter: float
    violations: float
    failed: float
    rest: float
    cost: float
    curves: tuple[tuple[float, ...], ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain values; nan is None."""
        made = {each.name: getattr(self, each.name) for each in fields(self)}
        plain = {name: None if value != value else value for name, value in made.items() if name != "curves"}
        return plain | ({"curves": [list(curve) for curve in self.curves]} if self.curves else {})

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> RunScore:
        """What `to_json` gave."""
        plain = {name: math.nan if value is None else value for name, value in data.items()}
        return cls(**plain | {"curves": tuple(tuple(curve) for curve in data.get("curves", ()))})


def score(robot: Robot, scenario: RobustnessScenario, trace: RunTrace) -> RunScore:
    """The numbers of a run.

    Args:
        robot: The scenario's robot.
        scenario: What was asked for.
        trace: What was done.
    """
    errors = scaled_errors(robot, scenario, trace.q)
    lost = errors @ scenario.lost
    kept = np.linalg.norm(errors - lost @ scenario.lost.T, axis=1)
    lost, whole = np.linalg.norm(lost, axis=1), np.linalg.norm(errors, axis=1)
    executed = np.diff(trace.q, axis=0) / scenario.dt
    speeds = np.abs(trace.commanded).max(axis=0) / scenario.speed
    leave, left = _leaving(scenario, whole)
    done = RunScore(
        kept=_rms(kept), kept_peak=float(kept.max()), lost=_rms(lost), final=float(whole[-1]), leave=leave, left=left,
        speed=float(speeds.max()), chatter=chatter(executed, scenario.acceleration, scenario.dt),
        violations=_violations(scenario, executed), failed=trace.failed / scenario.steps,
        rest=float(np.max(np.abs(executed[-max(1, scenario.steps // 10) :]) / scenario.speed)),
        cost=1e6 * trace.seconds,
    )  # fmt: skip
    if not scenario.shown:
        return done
    commanded = np.max(np.abs(trace.commanded) / scenario.speed, axis=1)
    return replace(done, curves=tuple(_thinned(each) for each in (kept[1:], lost[1:], commanded)))


def scaled_errors(robot: Robot, scenario: RobustnessScenario, values: Array) -> Array:
    """Target minus pose in scaled rows, (S + 1, m), of joint values, (S + 1, n)."""
    poses = robot.pose(robot.configuration(values))
    rows = [ROWS.index(row) for row in scenario.rows]
    return np.asarray(pose_error(poses, scenario.targets)[:, rows] / scenario.units)


def chatter(executed: Array, acceleration: Array, dt: float) -> float:
    """Changes of the sign of acceleration per second and joint, small accelerations left out.

    Args:
        executed: Joint velocities, (S, n).
        acceleration: Limits, (n,).
        dt: s.
    """
    signs = np.diff(executed, axis=0, prepend=np.zeros((1, executed.shape[1]))) / dt / acceleration
    signs = np.where(np.abs(signs) > SHAKE, np.sign(signs), 0.0)
    changes = 0
    for joint in signs.T:
        told = joint[joint != 0]
        changes += int(np.sum(told[1:] != told[:-1]))
    return float(changes / (executed.shape[1] * dt * len(executed)))


def _leaving(scenario: RobustnessScenario, whole: Array) -> tuple[float, float]:
    if not scenario.leavable:
        return math.nan, math.nan
    there = np.flatnonzero(whole <= LEFT * whole[0])
    if there.size == 0:
        return scenario.dt * scenario.steps, 0.0
    return float(scenario.dt * there[0]), 1.0


def _violations(scenario: RobustnessScenario, executed: Array) -> float:
    changes = np.diff(executed, axis=0, prepend=np.zeros((1, executed.shape[1]))) / scenario.dt
    fast = (np.abs(executed) > scenario.speed * (1 + OVER)).any(axis=1)
    abrupt = (np.abs(changes) > scenario.acceleration * (1 + OVER) + 1e-9 / scenario.dt).any(axis=1)
    return float(np.mean(fast | abrupt))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _thinned(values: Array) -> tuple[float, ...]:
    """The largest value in each of POINTS intervals, to three digits."""
    edges = np.linspace(0, len(values), POINTS + 1).round().astype(int)[:-1]
    return tuple(float(f"{each:.3g}") for each in np.maximum.reduceat(values, edges))
