"""Layout of what the kernels of `all_solutions` are given, and of what they fill in."""

from __future__ import annotations

JOINTS = 6
"""Joints of the closed loop: those of the arm, and stand-ins for rows that are free or that the arm does not have."""
MOTOR, GROUP = 8, 4
"""Numbers of a motor; dimensions of the space that a group's motors span."""

TRIPLE, FIRST, PIVOT, OWN, FLOATING = range(5)
"""Places in the head of a plan.

TRIPLE: 1 if three neighbours meet, are parallel or slide, 0 if two neighbours are the group.
FIRST: The first joint of the group, 0 to 5; 5 stands for the pair of joints 5 and 0.
PIVOT: Place of the variable whose values are found first, among the others in the order of the loop.
OWN: How many joints are the arm's own: the first ones; the others stand in.
FLOATING: How many of the stand-ins, the last ones, are not locked at 0.
"""
POINT, AXES, SLIDES = 5, 8, 56
"""The tool's point at zero (3,), axes (6, 8), and which of them slide (6,)."""
SPANS, PARTS = 62, 94
"""N, (4, 8), is zero on the motors of the group; S⁺, (4, 8), gives the coordinates of its motors in the basis S."""
LOWER, UPPER, TURNED = 126, 132, 138
"""Limits (6,), and for each joint 1 if its axis is given in world axes and passes the tool's point at the target."""
SIZE = 144
"""How many numbers a plan has."""

SCALE, COUNT_OF_VALUES, HOME_ROTATION, HOME_POINT, COLUMNS, ARM = 0, 1, 2, 11, 14, 20
"""An arm: its unit of length, m; number n of the robot's joints; its pose at zero, rotation (3, 3) row by row and point
(3,), m; for each joint of the loop its index among the robot's joints (6,).
"""

SOLUTIONS = 32
"""Room for solutions of one pose. A general arm of six revolute joints has at most 16; families add samples."""
VALUE, SIGMA, MISS, INSIDE, ROW = 0, 6, 7, 8, 9
"""A solution: joint values (6,), the least pivot of its Jacobian over the largest, its error, 1 if within limits."""

COUNT, VERDICT, WIDTH, ALLOWED, WORK, BESIDE, CONTINUA, NUMBERS = 0, 1, 2, 3, 4, 5, 6, 7
"""How many solutions, what is known of them, the largest coefficient of the eliminant, how many are within limits, how
many steps of Newton's method it took, how far the pose that was searched is beside the wanted one,
how many roots leave two variables a continuum of values.
"""
EVERY, DOUBTFUL, DEGENERATE, NEARBY = 0.0, 1.0, 2.0, 3.0
"""Verdicts: every root is accounted for; some are not; the eliminant vanishes; every root is accounted for, but some
leave a continuum of which samples were tried, or the eliminant vanishes and the roots are those of two poses close by.
"""
