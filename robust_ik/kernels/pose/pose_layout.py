"""What kernels read to invert the pose of a frame: its layout, in doubles."""

from __future__ import annotations

MOST = 16
"""Joints that may move the frame independently. As many as kernels have room for, W16."""
MOST_CHAIN = 64
"""Joints of the chain, those that follow others included."""

# One vector holds what stays the same from target to target: a head, then joints, chain and table one after another.
COUNT, LENGTH = 0, 1
"""How many joints move the frame, k, and the length of q."""
TURN, FREE = 2, 3
"""Which rotations are wanted: NONE, SINGLE, SWING or FULL, and the world axis that a swing leaves free."""
NONE, SINGLE, SWING, FULL = 0, 1, 2, 3
"""Codes of TURN: how many of the rotations wx, wy, wz are wanted."""
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
"""Numbers before the first joint: these 22, rounded up to a multiple of eight."""

STRIDE = 8
"""Then for each of the k joints: its limits; where q has it and whether as cosine and sine; whether a full turn changes
nothing; the finite range that random configurations come from."""
LOWER, UPPER, PLACE, CIRCLE, PERIODIC, FROM, TO = 0, 1, 2, 3, 4, 5, 6
"""Places of these in a joint's numbers."""

# The table has a row of ENTRIES numbers for every feature of a pose, then for every joint, then for the tool's x axis.
FEATURES = 12
"""Symmetric: radius, height and tool axis, 5 of them; else position and rotation."""

NORMAL = 5
"""Symmetric: where the direction outwards begins for what is on the boundary."""

# Options.
POSITION_TOLERANCE, ROTATION_TOLERANCE, SCALE, PREFER, WANTED, STARTS, POLISHED, RANDOM, APART, THOROUGH = range(10)
OPTIONS = 10
"""How many there are."""
NEAREST, ANY, LIMITS, SINGULARITY = 0, 1, 2, 3
"""Codes of PREFER: `pose_ik.options.PREFERENCES` names them."""
MOST_FOUND, MOST_POLISHED = 64, 8
"""Solutions of a target, and starts that are polished. Six joints have up to 16; `search_memory` has room for 8."""
MOST_SEEDS, MOST_EDGES = 256, 128
"""Configurations of the table, and on the boundary. Chosen: more are nearer to targets, and take longer to rate."""
ENTRIES = MOST_SEEDS + MOST_EDGES
"""Numbers of a row of the table."""

# Results.
STATUS, POSITION_ERROR, ROTATION_ERROR, ITERATIONS, TRIED, FOUND = range(6)
NUMBERS = 6
"""How many there are."""
SOLVED, CLOSEST, OUT_OF_REACH = 0, 1, 2
"""Codes of STATUS: places in `pose_ik.result.STATUSES`."""
