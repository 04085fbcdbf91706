"""One prepared velocity step: the stepper and its compiled program."""

from robust_ik.control.compiled_step.kernel_warmup import warmup

__all__ = [
    "warmup",
]
