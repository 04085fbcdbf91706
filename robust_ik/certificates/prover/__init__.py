"""Finds a proof: exact kinematics, minors, factors and cases."""
