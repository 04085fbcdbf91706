"""Kinematics of a chain of joints in compiled code."""
