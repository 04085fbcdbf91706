"""Layout of what the kernel of path planning is given, and of what it fills in."""

from __future__ import annotations

SLIDES, LOWER, UPPER, WEIGHT = range(4)
"""Rows of the joints' table, (4, n): 1 for a slide; limits, rad or m; rad per unit of motion."""
NODE, COST, PARENT, NEXT, VALUES = 0, 1, 2, 3, 4
"""A state: which solution of its pose it is, the motion until there, the state before it, another state of the same
solution (−1 for none), its joint values (n,).
"""
ALIVE, ENDED, LIMITED, NUMBERS = 0, 1, 2, 3
"""Of each pose: how many states it has; how many of them no solution of the next pose continues; how many of these a
solution would continue beyond limits.
"""
