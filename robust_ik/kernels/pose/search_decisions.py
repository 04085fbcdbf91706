"""Decides after each measurement in a search for a pose: another step, another start, or the end.

A start is given up when E has not fallen to 0.4 of its value five steps ago (for the first start, 0.5 of three steps
ago). If it is given up close to the target, or began on the boundary of the reachable poses, a solution on the boundary
is looked for. When no start reaches the target, the best few are polished: they give the closest pose, and decide
whether to go on.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose import search_memory as mem
from robust_ik.kernels.pose.boundary_solutions import pressable
from robust_ik.kernels.pose.newton_polish import ROOM, SIX, TWELVE, look
from robust_ik.kernels.pose.search_memory import keep, launch, polish_kept, polish_one, press_one, record, tighten
from robust_ik.kernels.pose.solution_ranking import arrange, unwind, write_configuration
from robust_ik.kernels.pose.target_checks import unreachable

WINDOW, RATIO = 5, 0.4
"""Number of steps, and the fraction of E that may be left after them.

Chosen: less misses slow solutions, more wastes steps.
"""
FIRST_WINDOW, FIRST_RATIO, SLOW_RATIO = 3, 0.5, 0.9
"""The same for the first start, at q0; and RATIO where E < NEARLY, since steps creep towards singular solutions."""
LONGEST = 100
"""Most steps of one start. Chosen: where more are needed, another start is better."""
NEARLY = 1e-4
"""E below which a given-up start may be near a solution on the boundary; after EARLY starts it is polished."""
EARLY, LATER, LAST, THOROUGH = 12, 128, 400, 120
"""Numbers of starts after which the best are polished. Without a solution the search ends after LAST starts, or after
THOROUGH if each is polished.
"""
AGAIN, AWAY = 22, 32
"""The same if the target is proved to be out of reach: the best are polished twice more, after AGAIN and AWAY starts,
then the search ends.
"""
DOUBTFUL = 0.02
"""E of the closest pose above which a search ends after LATER starts."""


@called
def given_up(memory: Pointer, E: float) -> bool:
    """Whether a start is given up; if not, its E is remembered."""
    n = int(memory[mem.STEP])
    first = memory[mem.START] == 0.0
    window, ratio = (FIRST_WINDOW, FIRST_RATIO) if first else (WINDOW, RATIO)
    if E < NEARLY:
        window, ratio = WINDOW, SLOW_RATIO
    if n >= LONGEST or (n >= window and ratio * memory[mem.HISTORY + (n - window) % 6] < E):
        return True
    memory[mem.HISTORY + n % 6] = E
    memory[mem.STEP] = n + 1.0
    return False


@called
def over(problem: Pointer, options: Pointer, memory: Pointer, found: Pointer) -> bool:
    """Whether the search ends after the start that has just ended."""
    start = int(memory[mem.START])
    if memory[mem.SOLUTIONS] > 0.0:
        return bool(memory[mem.SOLUTIONS] >= options[lay.WANTED] or start >= options[lay.STARTS])
    if options[lay.THOROUGH] > 0.0:
        return start >= THOROUGH
    if start != EARLY and start != AGAIN and start != AWAY and start != LATER and start < LAST:
        return False
    proved = unreachable(problem, further(memory, mem.AIM))
    if EARLY < start <= AWAY and not proved:
        return False
    polish_kept(problem, options, memory, found)
    if memory[mem.SOLUTIONS] > 0.0:
        return bool(memory[mem.SOLUTIONS] >= options[lay.WANTED])
    hopeless = start == LATER and memory[mem.BEST] > DOUBTFUL
    return bool(start >= LAST or hopeless or (proved and start >= AWAY))


@called
def decide(
    problem: Pointer, options: Pointer, memory: Pointer, values: Pointer, p: float, r: float, found: Pointer
) -> int:
    """Decides what follows a measurement; p and r are the squared errors of position and rotation.

    Returns:
        1 for another step, 0 for another start, −1 for the end.
    """
    E = p + options[lay.SCALE] * options[lay.SCALE] * r
    memory[mem.TOTAL] += 1.0
    there = p <= options[lay.POSITION_TOLERANCE] ** 2 and r <= options[lay.ROTATION_TOLERANCE] ** 2
    edge = memory[mem.EDGE] > 0.0
    if not there and not edge and not given_up(memory, E):
        return 1
    thorough, loose = options[lay.THOROUGH] > 0.0, memory[mem.LOOSE] > 0.0
    if loose and (there or thorough):
        tighten(problem, options, memory, values)
        return 0
    if there:
        record(problem, options, memory, values, p, r, found)
    elif not loose and (edge or thorough or E < NEARLY):
        there = press_one(problem, options, memory, values, edge, found)
    if edge:
        memory[mem.EDGED] += 1.0
    if not there and not loose:
        if thorough or (E < NEARLY and (memory[mem.START] >= EARLY or not pressable(problem))):
            polish_one(problem, options, memory, values, found)
        elif memory[mem.SOLUTIONS] == 0.0 and not edge:
            keep(problem, options, memory, values, E)
    if not edge:
        memory[mem.START] += 1.0
    if (there or not edge) and over(problem, options, memory, found):
        return -1
    launch(problem, options, memory, values)
    return 0


@called
def finish(problem: Pointer, options: Pointer, memory: Pointer, q0: Pointer, found: Pointer, numbers: Pointer) -> None:
    """Writes the results of a search."""
    length, count, own = int(problem[lay.LENGTH]), int(memory[mem.SOLUTIONS]), further(memory, mem.OWN)
    numbers[lay.STATUS] = lay.SOLVED
    if count == 0:
        numbers[lay.STATUS] = lay.OUT_OF_REACH if unreachable(problem, further(memory, mem.AIM)) else lay.CLOSEST
        for j in range(int(problem[lay.COUNT])):
            found[j] = memory[mem.CLOSEST_VALUES + j]
        unwind(problem, options, found, own)
    elif count > 1:
        arrange(problem, options, found, count, own, further(memory, mem.AIM))
        axes, end, error = stack(0.0, ROOM, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
        look(problem, found, further(memory, mem.AIM), axes, end, error)
        memory[mem.CLOSEST_ERROR], memory[mem.CLOSEST_ERROR + 1] = error[6], error[7]
    for s in range(max(count, 1)):
        write_configuration(problem, q0, further(found, s * length))
    numbers[lay.POSITION_ERROR] = math.sqrt(memory[mem.CLOSEST_ERROR])
    numbers[lay.ROTATION_ERROR] = math.sqrt(memory[mem.CLOSEST_ERROR + 1])
    skipped = 1.0 if options[lay.PREFER] == lay.ANY else 0.0
    numbers[lay.ITERATIONS], numbers[lay.TRIED], numbers[lay.FOUND] = (
        memory[mem.TOTAL],
        memory[mem.START] + memory[mem.EDGED] - skipped,
        count,
    )
