"""Reports of many steps of one program at once: what a `Resolution` says of each, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.bounds import ACTIVE, CONTRADICTION
from robust_ik.control.compiled_loop.step_snapshot import Snapshot
from robust_ik.control.limits import JointLimits
from robust_ik.control.resolution import Status
from robust_ik.control.resolvers.step_status import MET, NEAR, NOTHING, STUCK, ZERO
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kinematics.svd import norms
from robust_ik.robot.robot import Robot

Names = list[tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class StepReports:
    """What the reports of K steps say; L levels. Entries are those of `Resolution` and `LevelResult`.

    Attributes:
        scale: (K, L).
        residual: ‖ẋ − J q̇‖, (K, L).
        manipulability: (K, L).
        smallest_level_sigma: (K, L), NaN where nothing is left to a level.
        corank: (K, L).
        algorithmic: (K, L).
        calmed: (K,).
        status: K of `Status`.
        active: K tuples of names.
        contradictions: K tuples of names.
    """

    scale: Array
    residual: Array
    manipulability: Array
    smallest_level_sigma: Array
    corank: Array
    algorithmic: Array
    calmed: Array
    status: list[Status]
    active: Names
    contradictions: Names


def reports_of(robot: Robot, limits: JointLimits | None, left: Sequence[Snapshot]) -> StepReports:
    """The reports of steps of one program whose bounds are those of joint limits alone, or none.

    Args:
        robot: The robot.
        limits: The limits.
        left: What the steps have left on the program's desk.
    """
    program, desks = left[0].program, np.array([each.desk for each in left])
    levels = [_level(program, desks, index, units) for index, units in enumerate(left[0].row_units)]
    active, contradictions = _names(robot, limits, left, desks)
    first = program[slots.HEAD :]
    m = int(first[slots.M])
    wanted, missing = (desks[:, int(first[at]) : int(first[at]) + m] for at in (slots.X, slots.RESIDUAL))
    slowed = np.any([level["scale"] < 1 for level in levels], axis=0)
    status = _status(wanted, missing, slowed, np.array([bool(each) for each in contradictions]))
    columns = {name: np.column_stack([level[name] for level in levels]) for name in levels[0]}
    calmed = desks[:, int(program[slots.CALM]) + slots.CALM_NOW]
    return StepReports(**columns, calmed=calmed, status=status, active=active, contradictions=contradictions)


def _level(program: Array, desks: Array, index: int, units: Array) -> dict[str, Array]:
    """What is said of one level; see `step_status`."""
    record, n = program[slots.HEAD + index * slots.RECORD :], int(program[slots.JOINTS])
    m = int(record[slots.M])
    k = min(m, n)

    def part(slot: int, size: int) -> Array:
        at = int(record[slot])
        return desks[:, at : at + size]

    found, s, own = part(slots.FOUND, slots.NUMBERS), part(slots.SIGMA, k), part(slots.OWN, k)
    count = found[:, slots.COUNT].astype(int)
    there = np.arange(k) < count[:, None]
    last = np.where(count > 0, s[np.arange(len(s)), count - 1], np.nan)
    lost = (count > 0) & (last <= NEAR * own[:, 0])
    return {
        "scale": found[:, slots.SHARE],
        "residual": norms(part(slots.RESIDUAL, m) * units),
        "manipulability": np.where(there, s, 1.0).prod(axis=1),
        "smallest_level_sigma": last,
        "corank": (there & (s <= ZERO * own[:, :1])).sum(axis=1),
        "algorithmic": (own[:, -1] > NEAR * own[:, 0]) & lost,
    }


def _status(wanted: Array, missing: Array, slowed: NDArray[np.bool_], infeasible: NDArray[np.bool_]) -> list[Status]:
    """The statuses; see `step_status`."""
    size, rest = norms(wanted), norms(missing)
    asks = size > NOTHING
    unit = wanted / np.where(asks, size, 1.0)[:, None]
    stuck = asks & ((unit * (wanted - missing)).sum(axis=1) < STUCK * size)
    scaled = slowed | (rest > np.maximum(MET * size, NOTHING))
    codes = np.select([infeasible, stuck, scaled], [3, 2, 1], 0)
    names = (Status.TRACKING, Status.SCALED, Status.STUCK, Status.INFEASIBLE)
    return [names[code] for code in codes.tolist()]


def _names(robot: Robot, limits: JointLimits | None, left: Sequence[Snapshot], desks: Array) -> tuple[Names, Names]:
    """The limits on which the velocities of each step lie, and those that yielded; see `JointLimits.bounds`."""
    active: Names = [()] * len(desks)
    contradictions: Names = [()] * len(desks)
    if limits is None:
        return active, contradictions
    n, program = robot.n, left[0].program

    def part(slot: int) -> Array:
        at = int(program[slot])
        return desks[:, at : at + n]

    qdot, lower, upper, low, high, speeds = map(part, BOX)
    at_lower = qdot <= lower + ACTIVE
    at_upper = (qdot >= upper - ACTIVE) & ~at_lower
    if not (at_lower | at_upper).any() and not program[slots.HURRIED]:
        return active, contradictions
    change = limits.acceleration * left[0].dt / left[0].units.joints
    slower, faster = part(slots.BEFORE) - change, part(slots.BEFORE) + change
    below = np.where(low > -speeds, POSITION, VELOCITY)
    above = np.where(high < speeds, POSITION, VELOCITY)
    kinds = (
        np.where(slower > high, above, np.where(slower > low, ACCELERATION, below)),
        np.where(faster < low, below, np.where(faster < high, ACCELERATION, above)),
    )
    for k in np.flatnonzero((at_lower | at_upper).any(axis=1)).tolist():
        active[k] = tuple(
            f"{robot.joint_names[i]} {KINDS[kind[k, i]]}"
            for there, kind in zip((at_lower, at_upper), kinds)
            for i in np.flatnonzero(there[k]).tolist()
        )
    crossed = (slower > high + CONTRADICTION) | (faster < low - CONTRADICTION)
    for k in np.flatnonzero(crossed.any(axis=1)).tolist():
        contradictions[k] = tuple(f"{robot.joint_names[i]} acceleration" for i in np.flatnonzero(crossed[k]).tolist())
    return active, contradictions


BOX = (slots.QDOT, slots.LOWER, slots.UPPER, slots.LONG_LOWER, slots.LONG_UPPER, slots.SPEEDS)
"""Places of the velocities and of their bounds."""
POSITION, VELOCITY, ACCELERATION = 0, 1, 2
"""Kinds of limits behind a bound: places in KINDS."""
KINDS = ("position", "velocity", "acceleration")
"""Their names."""
