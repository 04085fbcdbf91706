"""Notes how joints turn back, and the share of their velocities that tasks ask for: the compiled `control.calming`."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import Number
from robust_ik.kernels.compiler.stack_memory import Pointer, further
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_layout import (
    AGAIN,
    AWAY,
    EVEN,
    FORGETTING,
    GROWTH,
    IN_A_ROW,
    KICK,
    LEAST_SHARE,
    LESS,
    LESS_AGAIN,
    PATIENCE,
    QUIET,
    QUIET_MOST,
    QUIET_STILL,
    SHAKES,
    SMALL,
    STILL,
)


@called
def asked_share(program: Pointer, desk: Pointer) -> Number:
    """The share of their velocities that tasks ask for."""
    return desk[int(program[slots.CALM]) + slots.CALM_SHARE]


@called
def calm(program: Pointer, desk: Pointer) -> None:
    """Takes note of the velocities of a step; see `Calming.watch`."""
    if program[slots.TURNING] == 0.0:
        return
    n, dt, qdot = int(program[slots.JOINTS]), program[slots.DT], further(desk, int(program[slots.QDOT]))
    peaks, memory = further(program, int(program[slots.TURNING])), further(desk, int(program[slots.CALM]))
    extremes, counts = further(memory, slots.CALMING), further(memory, slots.CALMING + n)
    before, way = further(memory, slots.CALMING + 2 * n), further(memory, slots.CALMING + 3 * n)
    last, earlier = further(memory, slots.CALMING + 4 * n), further(memory, slots.CALMING + 5 * n)
    since, share = memory[slots.CALM_STILL], memory[slots.CALM_SHARE]
    still = since > STILL
    quiet = max(QUIET_STILL, min(QUIET_MOST, since / PATIENCE)) if still else QUIET
    enough, shakes, most, gone = SHAKES if share == 1.0 else AGAIN, False, 0.0, 0.0
    for i in range(n):
        speed, extreme = math.fabs(qdot[i]), math.fabs(extremes[i])
        if counts[i] > 0.0:
            counts[i] /= 1.0 + dt / (quiet + peaks[n + i] * before[i])
        if qdot[i] * extremes[i] < 0.0:
            small = even_turn(earlier, i, n, extremes[i])
            if extreme >= (SMALL * peaks[i] if still and small else peaks[i]):
                kicks = still and math.fabs(qdot[i] - last[i]) >= KICK * peaks[i]
                counts[i] += SHAKES if kicks else 1.0
                before[i] = extreme
                shakes |= counts[i] >= enough
            extremes[i] = qdot[i]
        elif speed > extreme:
            extremes[i] = qdot[i]
        way[i] += dt * qdot[i]
        last[i] = qdot[i]
        most, gone = max(most, counts[i]), max(gone, math.fabs(way[i]))
    memory[slots.CALM_NOW] = share
    if shakes:
        memory[slots.CALM_SHARE] = max(LEAST_SHARE, (LESS if share == 1.0 else LESS_AGAIN) * share)
        memory[slots.CALM_FREE], memory[slots.CALM_GONE] = 0.0, 0.0
        for i in range(n):
            way[i] = 0.0
    elif share < 1.0 and most < FORGETTING:
        further_away = max(0.0, gone - memory[slots.CALM_GONE])
        growth = dt / GROWTH if memory[slots.CALM_FREE] > 0.0 else further_away / AWAY
        memory[slots.CALM_SHARE] = min(1.0, share + share * growth)
        memory[slots.CALM_GONE] += further_away


@called
def even_turn(earlier: Pointer, i: int, n: int, extreme: float) -> bool:
    """Notes the largest velocity before joint i turned back; whether it has turned back evenly for long."""
    before = earlier[n + i]
    earlier[n + i], earlier[i] = earlier[i], extreme
    even = math.fabs(extreme - before) <= EVEN * math.fabs(extreme)
    earlier[2 * n + i] = earlier[2 * n + i] + 1.0 if even else 0.0
    return bool(earlier[2 * n + i] >= IN_A_ROW)
