"""The twelve arms of the benchmark, in two halves, and their scenarios: the same for everyone, from a bare URDF."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

import robust_ik as rik
from benchmarks import chains
from benchmarks.chains import Chain
from benchmarks.environments import CACHE
from robust_ik.simulation.robustness import RobustnessScenario, robustness_scenarios

TRAINING = ("puma560", "ur5", "pa10", "panda", "xarm7", "duleba_3r")
"""Parameters are chosen on these. `SecondOrder` was made on them too, so that nothing is told of it there."""
HELD_OUT = ("kinova_gen3", "z1", "ur10", "srs_7r", "so101", "planar_3r")
"""What is told is about these."""
SEEDS = {**dict.fromkeys(TRAINING, 1), **dict.fromkeys(HELD_OUT, 2)}
"""Seeds of scenarios: each half has its own."""
STARTS = 200
"""Random starts of an atlas: enough for the families that a scenario may be about."""
FREE = 12.0
"""Position limits of the URDF, rad: out of the way, since the benchmark is about speeds and accelerations."""
EVERY = 5
"""Tuning runs every so many scenarios, with the usual time step only."""


@cache
def arm(name: str) -> tuple[rik.Robot, Chain, Path]:
    """An arm, read from a URDF of its joints and nothing else, which everyone reads; its chain and that file."""
    known = rik.load(name)
    limits = np.full(known.n, FREE)
    chain = replace(Chain.of(known), name=name, lower=-limits, upper=limits)
    path = CACHE / "robustness" / f"{name}.urdf"
    chains.write(path.with_suffix(f".{os.getpid()}"), name, (chain,)).replace(path)  # others may be reading it
    return rik.load(str(path), tip=chain.tip).with_rows(known.rows), chain, path


@cache
def scenarios(name: str) -> tuple[RobustnessScenario, ...]:
    """All scenarios of an arm."""
    robot = arm(name)[0]
    atlas = rik.find_singularities(robot, starts=STARTS, certify=False)
    return robustness_scenarios(robot, atlas, seed=SEEDS[name])


def for_tuning(name: str) -> tuple[RobustnessScenario, ...]:
    """The scenarios of an arm of the training half on which parameters are tried.

    Raises:
        ValueError: The arm is held out.
    """
    if name not in TRAINING:
        raise ValueError(f"{name} is held out: nothing may be tuned on it")
    return tuple(each for each in scenarios(name) if each.dt == 0.01)[::EVERY]
