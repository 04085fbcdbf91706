"""All solutions of a pose in compiled code: elimination in dual quaternions."""

from robust_ik.kernels.loader.kernel import kernels

(branches,) = kernels("robust_ik.kernels.branches.branch_search", "branches")
(state_of_loop,) = kernels("robust_ik.kernels.branches.loop_state", "state_of_loop")
(follow_curve,) = kernels("robust_ik.kernels.branches.curve_tracing", "follow_curve")
