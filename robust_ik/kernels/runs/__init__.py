"""Many runs of a controller's steps, eight side by side."""

from robust_ik.kernels.loader.kernel import kernels

runs_8, runs_16, runs_32 = kernels("robust_ik.kernels.runs.run_entries", "runs_8", "runs_16", "runs_32")
