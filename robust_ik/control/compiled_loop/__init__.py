"""A controller's step in compiled code: rows of tasks, bounds of limits, and the walk down the levels."""
