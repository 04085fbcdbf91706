"""One step of a velocity controller in compiled code: levels of tasks within bounds."""

from robust_ik.kernels.loader.kernel import kernels

control_8, control_16, control_32 = kernels(
    "robust_ik.kernels.control.control_entries", "control_8", "control_16", "control_32"
)
