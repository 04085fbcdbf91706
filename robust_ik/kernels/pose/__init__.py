"""The search for joint values of a pose in compiled code."""
