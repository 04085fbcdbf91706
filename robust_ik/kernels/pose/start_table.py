"""A table of configurations and their poses: a search begins at the configuration whose pose is closest to the target.

If the first joint turns the arm and the last one turns the tool, both rotations are left out of the comparison; the
closest configuration is then turned to the target. So few configurations cover all poses.
"""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.joint_motion import place_frame
from robust_ik.kernels.compiler.compiling import called, filled, kernel
from robust_ik.kernels.compiler.simd_lanes import spread, where
from robust_ik.kernels.compiler.stack_memory import (
    ONE,
    W8,
    W16,
    Pointer,
    by_eights,
    each_lane,
    further,
    pointer,
    sizes,
    stack,
)
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.starts.boundary_starts import onto_boundary
from robust_ik.kernels.pose.starts.random_values import random_values, within
from robust_ik.kernels.pose.symmetric_pose import describe

WEIGHT = 3.0
"""Weight of squared metres against squared radians in the choice of a start. Chosen: for arms of about a metre."""
TRIED = 2000
"""Most tries to find configurations on the boundary. Chosen: more fill the table, but take longer."""
FAVOUR = 0.7
"""Factor on the squared distances of configurations on the boundary.

Chosen: less takes them sooner, which costs some steps for targets inside.
"""
BULGE, HOLLOW = 1.3, 0.7
"""How far inside or outside a tangent plane of the boundary a target may lie, divided by the squared distance."""
ROOM, SIX, TWELVE = sizes(lay.MOST_CHAIN), sizes(6), sizes(12)


@called
def fill(problem: Pointer) -> None:
    """Fills the table with random configurations, then with some on the boundary."""
    values, normal = stack(0.0, ONE, W16), stack(0.0, ONE, W8)
    table, first = further(problem, int(problem[lay.TABLE])), int(problem[lay.SEEDS])
    for seed in range(first):
        random_values(problem, 0, seed, 0.0, values)
        enter(problem, values, seed)
    if problem[lay.SYMMETRIC] > 0.0 and problem[lay.COUNT] > 6 and problem[lay.BOUND] < math.inf:
        edges, tried = 0, 0
        while edges < lay.MOST_EDGES and tried < TRIED:
            if onto_boundary(problem, tried, values, normal):
                enter(problem, values, first + edges)
                for f in range(5):
                    table[(lay.NORMAL + f) * lay.ENTRIES + first + edges] = normal[f]
                edges += 1
            tried += 1
        problem[lay.EDGES] = edges


@called
def enter(problem: Pointer, values: Pointer, entry: int) -> None:
    """Writes a configuration and its pose into the table."""
    pack = further(problem, int(problem[lay.CHAIN]))
    table, k = further(problem, int(problem[lay.TABLE]) + entry), int(problem[lay.COUNT])
    end, found = stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
    motions, cosines, sines = stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM)
    axes, chained = stack(0.0, ROOM, SIX), int(pack[links.JOINTS])
    symmetric = problem[lay.SYMMETRIC] > 0.0
    for i in range(len(ROOM)):
        motions[i] = 0.0
    for i in range(chained):
        at = links.HEAD + i * links.STRIDE
        motions[i] = pack[at + links.FACTOR] * values[int(pack[at + links.COLUMN])] + pack[at + links.SHIFT]
    if symmetric:
        motions[0], motions[chained - 1] = 0.0, 0.0
    place_frame(pack, motions, cosines, sines, axes, end, 0.0)
    for j in range(k):
        table[(lay.FEATURES + j) * lay.ENTRIES] = values[j]
    if symmetric:
        azimuth = describe(problem, end, found)
        table[(lay.FEATURES + int(pack[links.HEAD + links.COLUMN])) * lay.ENTRIES] = azimuth
        for r in range(3):
            table[(lay.FEATURES + k + r) * lay.ENTRIES] = found[5 + r]
    for f in range(lay.FEATURES):
        table[f * lay.ENTRIES] = found[f] if symmetric else end[f]


@called
def rate(problem: Pointer, target: Pointer, distances: Pointer) -> None:
    """Fills the squared distance of each configuration of the table from a target."""
    table, count = further(problem, int(problem[lay.TABLE])), int(problem[lay.SEEDS]) + int(problem[lay.EDGES])
    kind = int(problem[lay.TURN])
    for s in range(count, 8 * ((count + 7) // 8)):
        distances[s] = math.inf
    if problem[lay.SYMMETRIC] > 0.0:
        found = stack(0.0, ONE, TWELVE)
        describe(problem, target, found)
        radius, height, x, y, z = found[0], found[1], found[2], found[3], found[4]
        for s in range(count):
            a, b = table[s] - radius, table[lay.ENTRIES + s] - height
            c, d, e = table[2 * lay.ENTRIES + s] - x, table[3 * lay.ENTRIES + s] - y, table[4 * lay.ENTRIES + s] - z
            distances[s] = WEIGHT * (a * a) + WEIGHT * (b * b) + c * c + d * d + e * e
        for s in range(int(problem[lay.SEEDS]), count):
            distances[s] *= FAVOUR
        return
    for s in range(count):
        distances[s] = 0.0
    for r in range(3):
        weight, wanted = WEIGHT * problem[lay.ROWS + r], target[9 + r]
        for s in range(count):
            d = table[(9 + r) * lay.ENTRIES + s] - wanted
            distances[s] += weight * d * d
    if kind == lay.SWING:
        # The world axis carried along with the target, in the tool: turned by R_c it should give the axis itself.
        free = 3 * int(problem[lay.FREE])
        for i in range(3):
            wanted = 1.0 if 3 * i == free else 0.0
            for s in range(count):
                d = -wanted
                for k in range(3):
                    d += table[(3 * i + k) * lay.ENTRIES + s] * target[free + k]
                distances[s] += d * d
    elif kind == lay.FULL:
        for x in range(9):
            wanted = target[x]
            for s in range(count):
                d = table[x * lay.ENTRIES + s] - wanted
                distances[s] += 0.5 * d * d


@called
def nearest(problem: Pointer, distances: Pointer, edges: bool) -> int:
    """Removes the closest configuration from the table and returns it; `edges`: also among those on the boundary."""
    count, rows = int(problem[lay.SEEDS]) + (int(problem[lay.EDGES]) if edges else 0), by_eights(distances)
    nearest_ones, least_ones = stack(spread(0.0), ONE, ONE), stack(spread(0.0), ONE, ONE)
    near, least = spread(0.0), spread(math.inf)
    for i in range((count + 7) // 8):
        closer = rows[i] < least
        near, least = where(closer, spread(8.0 * i), near), where(closer, rows[i], least)
    nearest_ones[0], least_ones[0] = near, least
    best, lowest = 0, math.inf
    for lane in range(8):
        if each_lane(least_ones)[lane] < lowest:
            best, lowest = int(each_lane(nearest_ones)[lane]) + lane, each_lane(least_ones)[lane]
    distances[best] = math.inf
    return best


@called
def bring(problem: Pointer, target: Pointer, q0: Pointer, seed: int, values: Pointer) -> bool:
    """Fills a configuration of the table, turned to the target.

    False for one on the boundary if the target lies too far from the tangent plane there.
    """
    table, k = further(problem, int(problem[lay.TABLE])), int(problem[lay.COUNT])
    for j in range(k):
        values[j] = table[(lay.FEATURES + j) * lay.ENTRIES + seed]
    if problem[lay.SYMMETRIC] > 0.0:
        pack = further(problem, int(problem[lay.CHAIN]))
        found = stack(0.0, ONE, TWELVE)
        azimuth = describe(problem, target, found)
        if seed >= int(problem[lay.SEEDS]):
            height, square = 0.0, 0.0
            for f in range(5):
                d = found[f] - table[f * lay.ENTRIES + seed]
                height += table[(lay.NORMAL + f) * lay.ENTRIES + seed] * d
                square += d * d
            if height < -BULGE * square or height > HOLLOW * square:
                return False
        first, last = links.HEAD, links.HEAD + (int(pack[links.JOINTS]) - 1) * links.STRIDE
        a, b = int(pack[first + links.COLUMN]), int(pack[last + links.COLUMN])
        turn = azimuth - values[a]
        values[a] = within(problem, a, (turn - pack[first + links.SHIFT]) / pack[first + links.FACTOR], q0[a])
        # The tool's x axis in the seed's axis frame: x₀ is its zero, axis × x₀ its quarter turn.
        x0, x1, x2 = (
            table[(lay.FEATURES + k) * lay.ENTRIES + seed],
            table[(lay.FEATURES + k + 1) * lay.ENTRIES + seed],
            table[(lay.FEATURES + k + 2) * lay.ENTRIES + seed],
        )
        a0, a1, a2 = table[2 * lay.ENTRIES + seed], table[3 * lay.ENTRIES + seed], table[4 * lay.ENTRIES + seed]
        along = x0 * found[5] + x1 * found[6] + x2 * found[7]
        across = (a1 * x2 - a2 * x1) * found[5] + (a2 * x0 - a0 * x2) * found[6] + (a0 * x1 - a1 * x0) * found[7]
        turn = math.atan2(across, along)
        values[b] = within(problem, b, (turn - pack[last + links.SHIFT]) / pack[last + links.FACTOR], q0[b])
    return True


@kernel(filled(1))
def fill_table(problem: Array) -> None:
    """Fills the table of a problem."""
    fill(pointer(problem))
