"""Reaching a pose even if the straight way ends: a task that servoes, and goes round when the servo stalls."""

from robust_ik.control.reaching.reach_task import Reach

__all__ = ["Reach"]
