"""Layout of the vectors of doubles that describe a pose problem, its options and its results to kernels."""

from __future__ import annotations

MOST = 16
"""Most independent joints that move the frame. As many as kernels have room for, W16."""
MOST_CHAIN = 64
"""Most joints of the chain, including those that follow others."""

# The problem, the same for every target: a head, then joints, chain and table, in one vector.
COUNT, LENGTH = 0, 1
"""How many joints move the frame, k, and the length of q."""
TURN, FREE = 2, 3
"""Wanted rotations (NONE, SINGLE, SWING or FULL), and the world axis about which a swing may turn freely."""
NONE, SINGLE, SWING, FULL = 0, 1, 2, 3
"""Codes of TURN: how many of the rotations wx, wy, wz are wanted."""
ROWS = 4
"""Six numbers: 1 for a row that is wanted, else 0."""
SYMMETRIC, SEEDS = 10, 11
"""Whether the first joint turns the arm and the last one the tool, and how many random configurations the table has."""
BOUND, CENTRE, CARRIED = 12, 13, 16
"""The point CARRIED of the tool, (3,), is never farther than BOUND from CENTRE, (3,); BOUND is infinite if unknown."""
CHAIN, TABLE = 19, 20
"""Where the packed chain and the table begin."""
EDGES = 21
"""Number of configurations on the boundary of the reachable poses; in the table they come after the SEEDS."""
HEAD = 24
"""Numbers before the first joint: these 22, rounded up to a multiple of eight."""

STRIDE = 8
"""Then, for each of the k joints: its limits; its place in q, and whether q holds cosine and sine; whether a full turn
changes nothing; the finite range for random configurations.
"""
LOWER, UPPER, PLACE, CIRCLE, PERIODIC, FROM, TO = 0, 1, 2, 3, 4, 5, 6
"""Places of these in the numbers of a joint."""

# The table has a row of ENTRIES numbers for every feature of a pose, then for every joint, then for the tool's x axis.
FEATURES = 12
"""If symmetric, the first 5 are radius, height and tool axis; else position and rotation."""

NORMAL = 5
"""If symmetric, the first feature of the outward normal, for configurations on the boundary."""

# Options.
POSITION_TOLERANCE, ROTATION_TOLERANCE, SCALE, PREFER, WANTED, STARTS, POLISHED, RANDOM, APART, THOROUGH = range(10)
OPTIONS = 10
"""Number of options."""
NEAREST, ANY, LIMITS, SINGULARITY = 0, 1, 2, 3
"""Codes of PREFER: `pose_ik.options.PREFERENCES` names them."""
MOST_FOUND, MOST_POLISHED = 64, 8
"""Most solutions of a target, and most starts that are polished.

Six joints have up to 16; `search_memory` has room for 8.
"""
MOST_SEEDS, MOST_EDGES = 256, 128
"""Most configurations of the table, and on the boundary.

Chosen: more are nearer to targets, but take longer to rate.
"""
ENTRIES = MOST_SEEDS + MOST_EDGES
"""Numbers in a row of the table."""

# Results.
STATUS, POSITION_ERROR, ROTATION_ERROR, ITERATIONS, TRIED, FOUND = range(6)
NUMBERS = 6
"""How many numbers there are."""
SOLVED, CLOSEST, OUT_OF_REACH = 0, 1, 2
"""Codes of STATUS: places in `pose_ik.result.STATUSES`."""
