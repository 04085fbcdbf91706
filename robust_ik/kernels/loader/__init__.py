"""How compiled kernels are found on disk and called; none of it needs Numba, but what is not found is compiled."""
