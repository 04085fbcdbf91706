"""The shortest motion through the solutions of the poses of a path, in compiled code."""

from robust_ik.kernels.loader.kernel import kernels

(ladder,) = kernels("robust_ik.kernels.paths.solution_ladder", "ladder")
