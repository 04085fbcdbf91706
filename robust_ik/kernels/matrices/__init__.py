"""Small matrices in compiled code: singular values, least squares, reflections."""

from robust_ik.kernels.loader.kernel import kernels

vectors_8, vectors_16, values_8, values_16 = kernels(
    "robust_ik.kernels.matrices.small_svd", "vectors_8", "vectors_16", "values_8", "values_16"
)
(steps,) = kernels("robust_ik.kernels.matrices.levenberg_marquardt", "steps")
