"""One velocity step with everything prepared: the stepper and its compiled program."""

from robust_ik.control.compiled_step.kernel_warmup import warmup

__all__ = [
    "warmup",
]
