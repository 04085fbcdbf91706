"""What a search for a pose remembers of its target: where it is, what it has found, the best of what failed."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.boundary_solutions import press, pressable
from robust_ik.kernels.pose.newton_polish import TWELVE, polish, reached
from robust_ik.kernels.pose.random_values import random_values
from robust_ik.kernels.pose.solution_ranking import WHOLE, apart, is_new, read_configuration, unwind
from robust_ik.kernels.pose.start_table import bring, nearest, rate
from robust_ik.kernels.pose.target_checks import unreachable

TARGET, START, STEP, TOTAL, SOLUTIONS, RATED, KEPT, BEST, HISTORY = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Places: target and counters, whether the table is rated, how many are kept, the least E, E of the last six steps."""
EDGE, EDGED = 14, 15
"""Whether a start is on the boundary of what is reachable, and how many were, which START does not count."""
OWN, AIM = 16, 32
"""q0's joint values; rotation and position of the target."""
KEPT_E, KEPT_VALUES = 48, 56
"""E of what is kept, and its joint values, 16 each."""
CLOSEST_VALUES, CLOSEST_ERROR, LOOSE, DISTANCES = 184, 200, 202, 208
"""LOOSE: how far a start may go beyond the limits of joints that come round again, rad."""
SIZE = 208 + lay.ENTRIES
"""Numbers in all: DISTANCES come last, one for each entry of the table."""
MEMORY = sizes(SIZE)
CLOSE = 0.05
"""What is kept differs by so much, rad or m. Chosen: nearer ones would be polished to the same."""
FEW_EDGES, HARD, MANY_EDGES = 1, 5, 12
"""Starts on the boundary at the most, before and from a number of other starts on."""
FROM_TABLE = 24
"""Starts from the table, before random ones. Chosen: the nearest help most; random ones find what it misses."""
FIRM, AROUND = 12, math.pi
"""Starts after which every other one leaves limits aside at first, and by how much."""


@called
def begin(problem: Pointer, options: Pointer, memory: Pointer, q0: Pointer, values: Pointer) -> None:
    """Forgets the last target and begins at q0."""
    own = further(memory, OWN)
    read_configuration(problem, q0, own)
    memory[START], memory[STEP], memory[TOTAL], memory[SOLUTIONS] = 0.0, 0.0, 0.0, 0.0
    memory[RATED], memory[KEPT], memory[BEST], memory[EDGE], memory[EDGED] = 0.0, 0.0, math.inf, 0.0, 0.0
    memory[LOOSE] = 0.0
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        low, high, value = problem[at + lay.LOWER], problem[at + lay.UPPER], own[j]
        if problem[at + lay.PERIODIC] > 0.0 and high - low == math.inf and abs(value) > WHOLE:
            value -= WHOLE * math.floor(value / WHOLE + 0.5)
        values[j] = min(max(value, low), high)
    if options[lay.PREFER] == lay.ANY:
        memory[START] = 1.0
        launch(problem, options, memory, values)


@called
def launch(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer) -> None:
    """The joint values that the next start begins at.

    Solutions with many joints at limits have small neighbourhoods inside these, from which a search leads there. So
    where nothing was found, every other start searches without limits, and goes on inside them from where it ends.
    """
    start, distances, aim = int(memory[START]), further(memory, DISTANCES), further(memory, AIM)
    memory[STEP], memory[EDGE], memory[LOOSE] = 0.0, 0.0, 0.0
    if start > FIRM and start % 2 == 0 and memory[SOLUTIONS] == 0.0 and not unreachable(problem, aim):
        memory[LOOSE] = AROUND
    if start > FROM_TABLE or memory[LOOSE] > 0.0:
        random_values(problem, int(options[lay.RANDOM]), start, memory[LOOSE], values)
        return
    if memory[RATED] == 0.0:
        rate(problem, aim, distances)
        memory[RATED] = 1.0
    most = FEW_EDGES if start < HARD else MANY_EDGES
    entry = nearest(problem, distances, memory[RATED] == 1.0 and memory[EDGED] < most)
    memory[EDGE] = 1.0 if entry >= int(problem[lay.SEEDS]) else 0.0
    if not bring(problem, aim, further(memory, OWN), entry, values):
        memory[RATED], memory[EDGE] = 2.0, 0.0
        bring(problem, aim, further(memory, OWN), nearest(problem, distances, False), values)


@called
def tighten(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer) -> None:
    """Brings a start that left limits aside inside them, from where it goes on."""
    unwind(problem, options, values, further(memory, OWN))
    memory[STEP], memory[LOOSE] = 0.0, 0.0


@called
def keep(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer, E: float) -> None:
    """Remembers where a start was given up, if it is among the best."""
    kept = int(memory[KEPT])
    place = kept
    for i in range(kept):
        if apart(problem, values, further(memory, KEPT_VALUES + 16 * i)) < CLOSE:
            place = i
    if place == kept and kept == int(options[lay.POLISHED]):
        place = 0
        for i in range(kept):
            if memory[KEPT_E + i] > memory[KEPT_E + place]:
                place = i
    if place == kept:
        memory[KEPT] = kept + 1.0
    elif memory[KEPT_E + place] <= E:
        return
    memory[KEPT_E + place] = E
    for j in range(int(problem[lay.COUNT])):
        memory[KEPT_VALUES + 16 * place + j] = values[j]


@called
def polish_kept(problem: Pointer, options: Pointer, memory: Pointer, found: Pointer) -> None:
    """Polishes what was kept, or finds a solution on the boundary from there."""
    for i in range(int(memory[KEPT])):
        values = further(memory, KEPT_VALUES + 16 * i)
        if not press_one(problem, options, memory, values, False, found):
            polish_one(problem, options, memory, values, found)
    memory[KEPT] = 0.0


@called
def press_one(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer, edge: bool, found: Pointer) -> bool:
    """Looks for a solution on the boundary from one configuration, and remembers it; whether there is one."""
    if not pressable(problem):
        return False
    error = stack(0.0, ONE, TWELVE)
    memory[TOTAL] += press(problem, options, values, further(memory, AIM), edge, error)
    if reached(options, error):
        record(problem, options, memory, values, error[6], error[7], found)
        return True
    return False


@called
def polish_one(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer, found: Pointer) -> None:
    """Polishes one configuration and remembers it if it is the closest, or a solution."""
    error, scale = stack(0.0, ONE, TWELVE), options[lay.SCALE]
    memory[TOTAL] += polish(problem, options, values, further(memory, AIM), error)
    E = error[6] + scale * scale * error[7]
    if reached(options, error):
        record(problem, options, memory, values, error[6], error[7], found)
    elif memory[BEST] > E and memory[SOLUTIONS] == 0.0:
        memory[BEST], memory[CLOSEST_ERROR], memory[CLOSEST_ERROR + 1] = E, error[6], error[7]
        for j in range(int(problem[lay.COUNT])):
            memory[CLOSEST_VALUES + j] = values[j]


@called
def record(
    problem: Pointer, options: Pointer, memory: Pointer, values: Pointer, p: float, r: float, found: Pointer
) -> None:
    """Adds a solution, if it is a new one; p and r are its squared errors."""
    length, count = int(problem[lay.LENGTH]), int(memory[SOLUTIONS])
    unwind(problem, options, values, further(memory, OWN))
    if count < int(options[lay.WANTED]) and is_new(problem, options, values, found, count, length):
        for j in range(int(problem[lay.COUNT])):
            found[count * length + j] = values[j]
        memory[SOLUTIONS] = count + 1.0
        if count == 0:
            memory[CLOSEST_ERROR], memory[CLOSEST_ERROR + 1] = p, r
