"""Reaching a pose whatever stands in the straight way: a task that servoes, and goes round where that ends."""

from robust_ik.control.reaching.task import Reach

__all__ = ["Reach"]
