"""Layout of the vector of numbers that describes a chain to kernels."""

from __future__ import annotations

HEAD = 4
"""The first numbers: count c of joints that move the frame, count n of the robot's independent joints, length of q."""
JOINTS, INDEPENDENT, CONFIGURATION = 0, 1, 2
"""Places of these three numbers."""

STRIDE = 17
"""Then, for each of the c joints: rotation (row by row) and origin of its axis frame, whose z is the axis, in the frame
moved by the joint before; its kind; its place in q; its column of J; factor and shift of its motion q · factor + shift.
"""
ROTATION, ORIGIN, KIND, PLACE, COLUMN, FACTOR, SHIFT = 0, 9, 12, 13, 14, 15, 16
"""Places of these in the numbers of a joint."""

TAIL = 12
"""Last, the rotation and the origin of the moved frame in the axis frame of the last joint."""

TURNING, CIRCLING, SLIDING, FOLLOWING = 0.0, 1.0, 2.0, 4.0
"""Kinds of joints: q holds an angle; its cosine and sine; a length. FOLLOWING is added to TURNING or SLIDING for a
joint that follows one for which q holds cosine and sine.
"""
