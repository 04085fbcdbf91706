"""What a step does, as one vector of numbers, which the kernel reads: its layout."""

from __future__ import annotations

ROWS, ROW = 0, 1
"""How many task rows, m, and which of the six each is."""
METHOD, DAMPING = 7, 8
"""How J is inverted; λ² of DAMPED."""
DAMPED, FORMULA = 0.0, 1.0
"""Codes of METHOD."""
ADDRESS, PARAMETERS = 9, 10
"""Where the compiled formula is, and where its parameters begin in the vector."""
TASK, JOINTS = 11, 12
"""Where the factors of the task and of the joints begin, m·m and n·n numbers row by row; 0 where there are none."""
REFERENCE, CHAIN = 13, 14
"""The reference of twists, and where the chain begins."""
HEAD = 16
"""Numbers before PARAMETERS, factors and chain, of which 15 are used."""

DONE, NOT_FINITE, OFF_CIRCLE, TOO_LARGE, UNLIKE = 0, 1, 2, 3, 4
"""What a step returns: UNLIKE where it was not given vectors of doubles as long as they have to be."""
