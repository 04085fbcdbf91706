"""Rows of tasks of single joints, and the bounds of joint limits.

The compiled form of `tasks.joint`, `tasks.posture`, `tasks.joint_range`, `tasks.damping` and `limits.joint_limits`.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import Pointer, further
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.rows.frame_motion import is_measured, map_of, value_of


@called
def joint_rows(program: Pointer, q: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer) -> int:
    """Fills in the rows of a task of joints; a status."""
    n, source, most = int(program[slots.JOINTS]), task[slots.SOURCE], task[slots.FASTEST]
    weight, good = task[slots.WEIGHT], True
    for r in range(int(task[slots.HEIGHT])):
        row = further(task, slots.ENTRIES + r * slots.ENTRY)
        index = int(row[slots.JOINT])
        joint, off = map_of(program, index), 0.0
        if source != slots.AT_REST:
            value = value_of(program, q, index)
            off = row[slots.FROM] - value
            if source == slots.TO_RANGE:
                off = min(max(value, row[slots.FROM]), row[slots.TO]) - value
            elif joint[slots.TURNS] > 0.0:
                off = math.atan2(math.sin(off), math.cos(off))
        for c in range(n):
            J[r * n + c] = 0.0
        J[r * n + index] = weight
        scale = weight / joint[slots.UNIT]
        error[r] = off * scale
        x[r] = min(max(task[slots.GAIN_OF] * off, -most), most) * scale
        good &= is_measured(row[slots.FROM]) or source == slots.TO_RANGE
    return slots.DONE if good else slots.NOT_FINITE


@called
def braking_speed(room: float, acceleration: float, dt: float, gain: float) -> float:
    """The largest speed from which a joint can still stop within `room` ≥ 0, see `joint_limits.braking_speed`."""
    if not (math.isfinite(acceleration) and math.isfinite(room)):
        return gain * room
    drop = acceleration * dt
    soft = drop / (dt * gain)
    linear = 0.5 + soft / drop
    steps = math.ceil(math.sqrt(linear * linear + max(2 * (room - soft / gain) / (drop * dt), 0.0)) - linear)
    return (room - drop * dt * steps * (steps + 1) / 2) / (steps * dt + 1 / gain) + steps * drop


@called
def ceiling(room: float, last: float, acceleration: float, recovery: float, gain: float, dt: float) -> float:
    """The largest speed towards an end at distance `room`; negative if the joint is beyond it."""
    if room < 0.0:
        return max(-min(recovery, -gain * room), min(last - acceleration * dt, 0.0))
    return braking_speed(room, acceleration, dt, gain)


@called
def joint_bounds(program: Pointer, desk: Pointer, q: Pointer) -> None:
    """Fills in the boxes that joint limits leave, in the units of the joints; see `JointLimits.bounds`."""
    n, dt, limits = int(program[slots.JOINTS]), program[slots.DT], further(program, int(program[slots.LIMITS]))
    lower, upper = further(desk, int(program[slots.LOWER])), further(desk, int(program[slots.UPPER]))
    long_lower = further(desk, int(program[slots.LONG_LOWER]))
    long_upper = further(desk, int(program[slots.LONG_UPPER]))
    last, gain = further(desk, int(program[slots.LAST])), min(limits[4 * n + slots.RATE], 1 / dt)
    recovery = limits[4 * n + slots.RECOVERY]
    for i in range(n):
        acceleration, speed = limits[slots.ACCELERATION * n + i], limits[slots.SPEED * n + i]
        value, unit = value_of(program, q, i), map_of(program, i)[slots.UNIT]
        above, below = limits[slots.MOST_VALUE * n + i] - value, value - limits[slots.LEAST * n + i]
        before = last[i] * unit
        high = ceiling(above, before, acceleration, recovery, gain, dt)
        low = -ceiling(below, -before, acceleration, recovery, gain, dt)
        if above < 0.0:
            high = max(high, low)
        if below < 0.0:
            low = min(high, low)
        low, high = min(max(low, -speed), speed) / unit, min(max(high, -speed), speed) / unit
        long_lower[i], long_upper[i] = low, high
        change = acceleration * dt / unit
        lower[i] = min(max(last[i] - change, low), high)
        upper[i] = min(max(last[i] + change, low), high)
