"""All solutions of a pose: closed forms, elimination, self-motions. Arrays only."""

from robust_ik.branches.result import AllSolutions, ManySolutions, SelfMotion, SolutionsStatus
from robust_ik.branches.solver import BranchSolver

__all__ = ["AllSolutions", "BranchSolver", "ManySolutions", "SelfMotion", "SolutionsStatus"]
