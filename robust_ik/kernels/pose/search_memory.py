"""Memory of a search for a pose: its target, the solutions found, the best failed starts."""

from __future__ import annotations

import math

from robust_ik.kernels.chain.full_turns import WHOLE, unwound
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.boundary_solutions import press, pressable
from robust_ik.kernels.pose.newton_polish import TWELVE, polish, reached
from robust_ik.kernels.pose.solution_ranking import apart, is_new, read_configuration, unwind
from robust_ik.kernels.pose.start_table import bring, nearest, rate
from robust_ik.kernels.pose.starts.random_values import random_values
from robust_ik.kernels.pose.target_checks import unreachable

TARGET, START, STEP, TOTAL, SOLUTIONS, RATED, KEPT, BEST, HISTORY = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Places: target, counters, whether the table is rated, number of kept starts, least E, E of the last six steps."""
EDGE, EDGED = 14, 15
"""Whether the present start is from the boundary, and how many were: START does not count them."""
OWN, AIM = 16, 32
"""Joint values of q0; rotation and position of the target."""
KEPT_E, KEPT_VALUES = 48, 56
"""E of the failed starts that are kept, and their joint values, 16 each."""
CLOSEST_VALUES, CLOSEST_ERROR, LOOSE, DISTANCES = 184, 200, 202, 208
"""LOOSE: how far the present start may go beyond the limits of periodic joints, rad."""
SIZE = 208 + lay.ENTRIES
"""How many numbers there are: DISTANCES come last, one for each entry of the table."""
MEMORY = sizes(SIZE)
CLOSE = 0.05
"""Least difference between two failed starts that are kept, rad or m. Chosen: nearer ones are polished to the same."""
FEW_EDGES, HARD, MANY_EDGES = 1, 5, 12
"""Most starts from the boundary before HARD other starts, and after."""
FROM_TABLE = 24
"""Most starts from the table, before random ones. Chosen: the nearest help most; random ones find what it misses."""
FIRM, AROUND = 12, math.pi
"""After FIRM starts every other one begins without limits: periodic joints may exceed them by AROUND."""


@called
def begin(problem: Pointer, options: Pointer, memory: Pointer, q0: Pointer, values: Pointer) -> None:
    """Clears the memory for a new target and begins at q0."""
    own = further(memory, OWN)
    read_configuration(problem, q0, own)
    memory[START], memory[STEP], memory[TOTAL], memory[SOLUTIONS] = 0.0, 0.0, 0.0, 0.0
    memory[RATED], memory[KEPT], memory[BEST], memory[EDGE], memory[EDGED] = 0.0, 0.0, math.inf, 0.0, 0.0
    memory[LOOSE] = 0.0
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        low, high, value = problem[at + lay.LOWER], problem[at + lay.UPPER], own[j]
        if problem[at + lay.PERIODIC] > 0.0 and high - low == math.inf and abs(value) > WHOLE:
            value = unwound(value)
        values[j] = min(max(value, low), high)
    if options[lay.PREFER] == lay.ANY:
        memory[START] = 1.0
        launch(problem, options, memory, values)


@called
def launch(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer) -> None:
    """Sets the joint values for the next start.

    A solution with many joints at their limits can be reached within limits only from a small neighbourhood. So as long
    as nothing was found, every other start searches without limits first, and continues within them from where it ends.
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
    """Brings a start that searched without limits back within them, for it to continue there."""
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
    """Polishes the failed starts that were kept, or finds a solution on the boundary from there."""
    for i in range(int(memory[KEPT])):
        values = further(memory, KEPT_VALUES + 16 * i)
        if not press_one(problem, options, memory, values, False, found):
            polish_one(problem, options, memory, values, found)
    memory[KEPT] = 0.0


@called
def press_one(problem: Pointer, options: Pointer, memory: Pointer, values: Pointer, edge: bool, found: Pointer) -> bool:
    """Looks for a solution on the boundary from one configuration and records it; False if there is none."""
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
    """Polishes one configuration; records it if it is a solution, remembers it if it is the closest."""
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
    """Adds a solution if it is new; p and r are its squared errors of position and rotation."""
    length, count = int(problem[lay.LENGTH]), int(memory[SOLUTIONS])
    unwind(problem, options, values, further(memory, OWN))
    if count < int(options[lay.WANTED]) and is_new(problem, options, values, found, count, length):
        for j in range(int(problem[lay.COUNT])):
            found[count * length + j] = values[j]
        memory[SOLUTIONS] = count + 1.0
        if count == 0:
            memory[CLOSEST_ERROR], memory[CLOSEST_ERROR + 1] = p, r
