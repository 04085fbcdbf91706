"""The second-order inverse of one equation J q̇ = ẋ with its Hessian."""

from robust_ik.kernels.loader.kernel import kernels

velocity_8, velocity_16 = kernels("robust_ik.kernels.second_order.second_order_entries", "velocity_8", "velocity_16")
