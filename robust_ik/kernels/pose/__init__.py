"""The search for the joint values of a pose, in compiled code."""
