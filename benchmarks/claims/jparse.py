"""Runs of the J-PARSE paper's scenarios, each also from starts that differ by rounding, and what is read off them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import robust_ik as rik
from benchmarks.claims.many import TINY, Runs, hair_apart, loaded, run_many
from benchmarks.claims.spread import Spread
from robust_ik.checks import Array
from robust_ik.simulation.scenario import Scenario

AT_KEYPOINTS = np.arange(1, 5) * 1000 - 1
GEN3_STARTS = (
    (0.6575, 0.4901, -1.2455, 1.2233, -1.4069, -0.4924, 0.3430),
    (-2.9194, -0.2862, -0.2391, -1.2580, 0.2193, -0.0346, 1.4185),
    (0.0119, 0.2856, 3.1288, -1.2488, 0.0090, -0.0364, 1.5654),
    (0.5390, 0.3963, -0.9519, 1.2273, -1.5235, -0.3548, 0.2914),
    (-0.2088, 0.2856, 0.2219, 1.2578, 3.0134, -0.0340, 1.6368),
)
"""Of the same pose as the scenario's own, joint values."""


@cache
def many(name: str, label: str, seconds: float | None = None, posture: bool = True) -> Runs:
    """From the scenario's start and from five others a hair's breadth away, each step off by as much."""
    scenario = loaded(name)
    shown = scenario if posture else replace(scenario, motion=replace(scenario.motion, below=()))  # type: ignore[type-var]
    return run_many(shown if seconds is None else replace(shown, duration=seconds), label, hair_apart(scenario), TINY)


@cache
def single(name: str, label: str) -> tuple[rik.Trajectory, ...]:
    """Likewise of what does not run from many starts at once, and from two others only."""
    scenario = loaded(name)
    return tuple(rik.simulate(replace(scenario, q0=q), label) for q in hair_apart(scenario, count=2))


def peak(runs: Runs) -> Spread:
    """Largest |q̇| of any joint."""
    return spread_of(runs.speed.max(axis=0))


def usual(runs: Runs) -> Spread:
    """What the largest |q̇| stays below for 99 % of the time."""
    return spread_of(np.percentile(runs.speed, 99, axis=0))


def at_keypoint(runs: Runs, index: int) -> Spread:
    """Distance from a keypoint at the end of its 20 s, m."""
    return spread_of(runs.position_error[AT_KEYPOINTS[index]])


def spread_of(values: Array) -> Spread:
    """Of one value for each start."""
    return Spread(tuple(np.asarray(values, float)))


def farthest(runs: Runs, *indices: int) -> float:
    """The largest distance from some keypoints at their ends, from any start, m."""
    return float(runs.position_error[AT_KEYPOINTS[list(indices)]].max())


def seconds_until_near(runs: Runs) -> Spread:
    """After the jump back from A: until B is 1 cm away for good."""
    far = runs.position_error[1000:2000] > 0.01
    return spread_of([0.02 * (np.flatnonzero(each)[-1] + 1) for each in far.T])


@cache
def out_of_reach(label: str) -> tuple[Array, Array]:
    """Gen3 with the null-space term, while its target is out of reach: median and least Π σ, from six starts each."""
    scenario = replace(loaded("gen3_line_posture"), duration=48.0)
    starts = np.stack([scenario.q0, *(scenario.robot.configuration(np.array(each)) for each in GEN3_STARTS)])
    runs = run_many(scenario, label, starts)
    far = 0.6 + 0.5 * np.sin(2 * np.pi * runs.time / 100) > 0.8
    return np.median(runs.manipulability[far], axis=0), runs.manipulability[far].min(axis=0)


def near_its_target(label: str, product: float) -> float:
    """By how much 2 s multiply the error of the arm near its target, with k Δt = product."""
    scenario: Scenario = loaded("jparse_gain")
    motion = replace(scenario.motion, gain=product / scenario.dt)  # type: ignore[type-var]
    runs = run_many(replace(scenario, motion=motion), label, scenario.q0[None])
    return float(runs.position_error[40, 0] / runs.position_error[0, 0])
