"""One velocity step in compiled code."""

from robust_ik.kernels.loader.kernel import kernels

step_8, step_16, beside_8, beside_16, factor_8, factor_16, steps_8, steps_16 = kernels(
    "robust_ik.kernels.step.step_entries",
    "step_8",
    "step_16",
    "beside_8",
    "beside_16",
    "factor_8",
    "factor_16",
    "steps_8",
    "steps_16",
)
curved_8, curved_16 = kernels("robust_ik.kernels.step.curved_step", "curved_8", "curved_16")
