"""What kernels read to invert the pose of a frame: its layout, in doubles."""

from __future__ import annotations

MOST = 16
"""Joints that may move the frame independently."""
MOST_CHAIN = 64
"""Joints of the chain, those that follow others included."""

# One vector holds what stays the same from target to target: a head, then joints, chain and table one after another.
COUNT, LENGTH = 0, 1
"""How many joints move the frame, k, and the length of q."""
TURN, FREE = 2, 3
"""Which rotations are wanted: NONE, SINGLE, SWING or FULL, and the world axis that a swing leaves free."""
NONE, SINGLE, SWING, FULL = 0, 1, 2, 3
ROWS = 4
"""Six numbers: 1 for a row that is wanted, else 0."""
SYMMETRIC, SEEDS = 10, 11
"""Whether the first joint turns the arm and the last the tool, and how many configurations the table has."""
BOUND, CENTRE, CARRIED = 12, 13, 16
"""A point of the tool, (3,), is never farther than BOUND from CENTRE, (3,); infinite where that is not known."""
CHAIN, TABLE = 19, 20
"""Where the packed chain and the table begin."""
EDGES = 21
"""How many configurations on the boundary of what is reachable the table has after its first SEEDS."""
HEAD = 24

STRIDE = 8
"""Then for each of the k joints: its limits; where q has it and whether as cosine and sine; whether a full turn changes
nothing; the finite range that random configurations come from."""
LOWER, UPPER, PLACE, CIRCLE, PERIODIC, FROM, TO = 0, 1, 2, 3, 4, 5, 6

# The table has a row of ENTRIES numbers for every feature of a pose, then for every joint, then for the tool's x axis.
FEATURES = 12
"""Symmetric: radius, height and tool axis, 5 of them; else position and rotation."""

NORMAL = 5
"""Symmetric: where the direction outwards begins for what is on the boundary."""

# Options.
POSITION_TOLERANCE, ROTATION_TOLERANCE, SCALE, PREFER, WANTED, STARTS, POLISHED, RANDOM, APART, THOROUGH = range(10)
OPTIONS = 10
NEAREST, ANY, LIMITS, SINGULARITY = 0, 1, 2, 3
MOST_FOUND, MOST_POLISHED = 64, 8
MOST_SEEDS, MOST_EDGES = 256, 128
ENTRIES = MOST_SEEDS + MOST_EDGES

# Results.
STATUS, POSITION_ERROR, ROTATION_ERROR, ITERATIONS, TRIED, FOUND = range(6)
NUMBERS = 6
SOLVED, CLOSEST, OUT_OF_REACH = 0, 1, 2
