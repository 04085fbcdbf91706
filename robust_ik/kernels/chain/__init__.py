"""Kinematics of a chain of joints in compiled code."""

from robust_ik.kernels.loader.kernel import kernels

poses, jacobians, hessians = kernels("robust_ik.kernels.chain.chain_kinematics", "poses", "jacobians", "hessians")
(contractions,) = kernels("robust_ik.kernels.chain.hessian_contraction", "contractions")
