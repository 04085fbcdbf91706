"""Robust inverses, one file each. See `base` for what they share and how to add one."""

from robust_ik.inverses.base import Card, Jump, RobustInverse, SingularValueFilter
from robust_ik.inverses.damped_least_squares import DampedLeastSquares
from robust_ik.inverses.jparse import JParse
from robust_ik.inverses.moore_penrose import MoorePenrose

__all__ = ["Card", "DampedLeastSquares", "JParse", "Jump", "MoorePenrose", "RobustInverse", "SingularValueFilter"]
