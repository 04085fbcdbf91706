"""The search for the joint values of a pose, in compiled code."""

from robust_ik.kernels.loader.kernel import kernels

(fill_table,) = kernels("robust_ik.kernels.pose.start_table", "fill_table")
solve_one, solve_many = kernels("robust_ik.kernels.pose.pose_search", "solve_one", "solve_many")
