"""A table of configurations and their poses: a search for a pose begins where the pose is nearest.

Where the first joint turns the arm and the last one turns the tool, both are taken out: the nearest configuration in
what is left is then turned to where the target is, so that few configurations cover all poses.
"""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels import packing as links
from robust_ik.kernels import pose_layout as lay
from robust_ik.kernels.compiling import called, filled, kernel
from robust_ik.kernels.motion import place_frame
from robust_ik.kernels.pose_reduced import describe
from robust_ik.kernels.pose_seeds import random_values, within
from robust_ik.kernels.stack import ONE, W16, Pointer, further, pointer, sizes, stack

WEIGHT = 3.0
"""Of squared metres against squared radians in the choice of a start."""
NEAR = 1e-9
ROOM, SIX, TWELVE = sizes(lay.MOST_CHAIN), sizes(6), sizes(12)


@called
def fill(problem: Pointer) -> None:
    """Fills the table by random configurations."""
    pack = further(problem, int(problem[lay.CHAIN]))
    table = further(problem, int(problem[lay.TABLE]))
    count, k, chained = int(problem[lay.SEEDS]), int(problem[lay.COUNT]), int(pack[links.JOINTS])
    values, end, found = stack(0.0, ONE, W16), stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
    motions, cosines, sines = stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM)
    axes = stack(0.0, ROOM, SIX)
    for i in range(len(ROOM)):
        motions[i] = 0.0
    symmetric = problem[lay.SYMMETRIC] > 0.0
    for seed in range(count):
        random_values(problem, 0, seed, values)
        for i in range(chained):
            at = links.HEAD + i * links.STRIDE
            motions[i] = pack[at + links.FACTOR] * values[int(pack[at + links.COLUMN])] + pack[at + links.SHIFT]
        if symmetric:
            motions[0], motions[chained - 1] = 0.0, 0.0
        place_frame(pack, motions, cosines, sines, axes, end, 0.0)
        if symmetric:
            azimuth = describe(problem, end, found)
            values[int(pack[links.HEAD + links.COLUMN])] = azimuth
            for r in range(3):
                table[(lay.FEATURES + k + r) * count + seed] = found[5 + r]
        for f in range(lay.FEATURES):
            table[f * count + seed] = found[f] if symmetric else end[f]
        for j in range(k):
            table[(lay.FEATURES + j) * count + seed] = values[j]


@called
def rate(problem: Pointer, target: Pointer, distances: Pointer) -> None:
    """How far each configuration of the table is from a target, squared."""
    table, count = further(problem, int(problem[lay.TABLE])), int(problem[lay.SEEDS])
    kind = int(problem[lay.TURN])
    for s in range(count):
        distances[s] = 0.0
    if problem[lay.SYMMETRIC] > 0.0:
        found = stack(0.0, ONE, TWELVE)
        describe(problem, target, found)
        for f in range(5):
            weight, wanted = WEIGHT if f < 2 else 1.0, found[f]
            for s in range(count):
                d = table[f * count + s] - wanted
                distances[s] += weight * d * d
        return
    for r in range(3):
        weight, wanted = WEIGHT * problem[lay.ROWS + r], target[9 + r]
        for s in range(count):
            d = table[(9 + r) * count + s] - wanted
            distances[s] += weight * d * d
    if kind == lay.SWING:
        # The world axis as the target carries it, in the tool: R_cᵀ's image of it is to be the axis itself.
        free = 3 * int(problem[lay.FREE])
        for i in range(3):
            wanted = 1.0 if 3 * i == free else 0.0
            for s in range(count):
                d = -wanted
                for k in range(3):
                    d += table[(3 * i + k) * count + s] * target[free + k]
                distances[s] += d * d
    elif kind == lay.FULL:
        for x in range(9):
            wanted = target[x]
            for s in range(count):
                d = table[x * count + s] - wanted
                distances[s] += 0.5 * d * d


@called
def nearest(problem: Pointer, distances: Pointer) -> int:
    """The configuration of the table with the least distance, which is taken out."""
    best, least = 0, math.inf
    for s in range(int(problem[lay.SEEDS])):
        if distances[s] < least:
            best, least = s, distances[s]
    distances[best] = math.inf
    return best


@called
def bring(problem: Pointer, target: Pointer, q0: Pointer, seed: int, values: Pointer) -> None:
    """A configuration of the table, turned to where the target is."""
    table, count, k = further(problem, int(problem[lay.TABLE])), int(problem[lay.SEEDS]), int(problem[lay.COUNT])
    for j in range(k):
        values[j] = table[(lay.FEATURES + j) * count + seed]
    if problem[lay.SYMMETRIC] > 0.0:
        pack = further(problem, int(problem[lay.CHAIN]))
        found = stack(0.0, ONE, TWELVE)
        azimuth = describe(problem, target, found)
        first, last = links.HEAD, links.HEAD + (int(pack[links.JOINTS]) - 1) * links.STRIDE
        a, b = int(pack[first + links.COLUMN]), int(pack[last + links.COLUMN])
        turn = azimuth - values[a]
        values[a] = within(problem, a, (turn - pack[first + links.SHIFT]) / pack[first + links.FACTOR], q0[a])
        # The tool's x axis in the seed's axis frame: x₀ is its zero, axis × x₀ its quarter turn.
        x0, x1, x2 = (
            table[(lay.FEATURES + k) * count + seed],
            table[(lay.FEATURES + k + 1) * count + seed],
            table[(lay.FEATURES + k + 2) * count + seed],
        )
        a0, a1, a2 = table[2 * count + seed], table[3 * count + seed], table[4 * count + seed]
        along = x0 * found[5] + x1 * found[6] + x2 * found[7]
        across = (a1 * x2 - a2 * x1) * found[5] + (a2 * x0 - a0 * x2) * found[6] + (a0 * x1 - a1 * x0) * found[7]
        turn = math.atan2(across, along)
        values[b] = within(problem, b, (turn - pack[last + links.SHIFT]) / pack[last + links.FACTOR], q0[b])


@kernel(filled(1))
def fill_table(problem: Array) -> None:
    """Fills the table of a problem."""
    fill(pointer(problem))
