"""A chain as one vector of numbers, which kernels read: its layout."""

from __future__ import annotations

HEAD = 4
"""First come: how many joints move the frame, c; how many independent joints the robot has, n; the length of q."""
JOINTS, INDEPENDENT, CONFIGURATION = 0, 1, 2
"""Places of these three."""

STRIDE = 17
"""Then for each of the c joints: the rotation (row by row) and the origin of its axis frame, z being the axis, in the
frame that the joint before has moved; its kind; where in q it is read; its column of J; its motion is
q · factor + shift."""
ROTATION, ORIGIN, KIND, PLACE, COLUMN, FACTOR, SHIFT = 0, 9, 12, 13, 14, 15, 16
"""Places of these in a joint's numbers."""

TAIL = 12
"""At the end: the rotation and the origin of the frame that is moved, in that of the last joint."""

TURNING, CIRCLING, SLIDING, FOLLOWING = 0.0, 1.0, 2.0, 4.0
"""An angle in q; a cosine and a sine in q; a length. FOLLOWING is added to TURNING or SLIDING where what is in q is a
cosine and a sine, of another joint."""
