"""The shortest joint motion through the solutions of a path's poses, with full turns counted.

A state is a solution with its turns. Of states with the same joint values the one with the least motion until there is
kept, so that the best way to each solution of the last pose is found. Source: Bellman 1957, dynamic programming.
"""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.chain.full_turns import WHOLE
from robust_ik.kernels.compiler.compiling import FLOAT, called, filled, given, kernel
from robust_ik.kernels.compiler.stack_memory import Pointer, further, pointer
from robust_ik.kernels.paths import ladder_layout as lay

SAME = 1.0
"""Joint values of one solution that differ by less have the same turns, rad."""
AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad or m; it is put on the limit."""


@called
def step_to(joints: Pointer, n: int, start: Pointer, solution: Pointer, to: Pointer) -> tuple[float, float, bool]:
    """Fills in the solution with the turns next to `start`; its largest and whole motion, and whether limits hold."""
    largest, square, within = 0.0, 0.0, True
    for k in range(n):
        value = solution[k]
        if joints[lay.SLIDES * n + k] == 0.0:
            value += WHOLE * math.floor((start[k] - value) / WHOLE + 0.5)
        low, high = joints[lay.LOWER * n + k], joints[lay.UPPER * n + k]
        within = within and low - AT_LIMIT <= value <= high + AT_LIMIT
        to[k] = min(max(value, low), high)
        motion = joints[lay.WEIGHT * n + k] * (value - start[k])
        square += motion * motion
        largest = max(largest, abs(motion))
    return largest, math.sqrt(square), within


@called
def is_banned(banned: Pointer, many: int, layer: int, a: float, b: float) -> bool:
    """Whether the step from solution a of a pose to solution b of the next one is banned."""
    for i in range(many):
        one = further(banned, 3 * i)
        if one[0] == layer and one[1] == a and one[2] == b:
            return True
    return False


@called
def place_of(states: Pointer, size: int, first: int, values: Pointer, n: int) -> int:
    """The state with the same turns, of those of one solution that begin with `first`; −1 if there is none."""
    i = first
    while i >= 0:
        state, same = further(states, size * i), True
        for k in range(n):
            same = same and abs(state[lay.VALUES + k] - values[k]) < SAME
        if same:
            return i
        i = int(state[lay.NEXT])
    return -1


@kernel(given(3), given(1), given(2), given(2), FLOAT, filled(3), filled(2), filled(1))
def ladder(
    solutions: Array, counts: Array, joints: Array, banned: Array, longest: float, states: Array, numbers: Array,
    heads: Array,
) -> int:  # fmt: skip
    """The states of each pose that steps from those of the first pose lead to; the last pose that has any.

    Shapes are unchecked.

    Args:
        solutions: Joint values, any turns, (p, s, n).
        counts: How many solutions each pose has, (p,).
        joints: See `ladder_layout`, (4, n).
        banned: Steps that are not taken: pose, solution there, solution of the next pose, (b, 3).
        longest: The longest step of a joint that is taken, rad.
        states: Filled, (p, most, VALUES + n); those of the first pose are given, `numbers` says how many. If there are
            more than `most`, the cheapest do not always stay.
        numbers: Filled, (p, NUMBERS).
        heads: Room for the first state of each solution, (s,).
    """
    n, most, size = solutions.shape[2], states.shape[1], states.shape[2]
    table, bans, many_bans = pointer(joints), pointer(banned), banned.shape[0]
    for layer in range(solutions.shape[0]):
        row = further(pointer(numbers), lay.NUMBERS * layer)
        row[lay.ENDED], row[lay.LIMITED] = 0.0, 0.0
        if not row[lay.ALIVE] > 0.0:
            return layer - 1
        if layer + 1 == solutions.shape[0]:
            return layer
        here = further(pointer(states), size * most * layer)
        there = further(here, size * most)
        nodes, filled_in = further(pointer(solutions), n * solutions.shape[1] * (layer + 1)), 0
        for b in range(int(counts[layer + 1])):
            heads[b] = -1.0
        for a in range(int(row[lay.ALIVE])):
            state, goes_on, limited = further(here, size * a), False, False
            for b in range(int(counts[layer + 1])):
                if filled_in == most:
                    break
                new = further(there, size * filled_in)
                largest, length, within = step_to(
                    table, n, further(state, lay.VALUES), further(nodes, n * b), further(new, lay.VALUES)
                )
                if largest > longest or (many_bans > 0 and is_banned(bans, many_bans, layer, state[lay.NODE], b)):
                    continue
                limited = limited or not within
                if not within:
                    continue
                goes_on = True
                new[lay.NODE], new[lay.COST], new[lay.PARENT] = float(b), state[lay.COST] + length, float(a)
                known = place_of(there, size, int(heads[b]), further(new, lay.VALUES), n)
                if known < 0:
                    new[lay.NEXT], heads[b] = heads[b], float(filled_in)
                    filled_in += 1
                elif further(there, size * known)[lay.COST] > new[lay.COST]:
                    new[lay.NEXT] = there[size * known + lay.NEXT]
                    for i in range(size):
                        there[size * known + i] = new[i]
            row[lay.ENDED] += 0.0 if goes_on else 1.0
            row[lay.LIMITED] += 1.0 if limited and not goes_on else 0.0
        numbers[layer + 1, lay.ALIVE] = float(filled_in)
    return int(solutions.shape[0]) - 1
