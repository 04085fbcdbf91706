"""Conditions on joint values that make an arm singular: sums of angles, relations fitted to points, their notation."""
