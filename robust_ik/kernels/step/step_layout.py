"""Layout of the program, the vector of numbers that describes a control step to the kernel."""

from __future__ import annotations

ROWS, ROW = 0, 1
"""Number m of task rows, and from ROW on the index of each among the six."""
METHOD, DAMPING = 7, 8
"""How J is inverted; λ² if the method is DAMPED."""
DAMPED, FORMULA = 0.0, 1.0
"""Codes of METHOD."""
ADDRESS, PARAMETERS = 9, 10
"""Address of the compiled gain formula, and place in the vector of its parameters, or of those of the second order."""
TASK, JOINTS = 11, 12
"""Places of the weights' factors of task and joints, m·m and n·n numbers row by row; 0 for no weights."""
REFERENCE, CHAIN = 13, 14
"""The reference of twists, and the place of the chain."""
HEAD = 16
"""Numbers before PARAMETERS, factors and chain; 15 are used."""

DONE, NOT_FINITE, OFF_CIRCLE, TOO_LARGE, UNLIKE = 0, 1, 2, 3, 4
"""Statuses of a step; UNLIKE: its arguments are not vectors of doubles of the right lengths."""
