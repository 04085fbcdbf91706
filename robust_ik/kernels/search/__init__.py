"""Searches for singular configurations in compiled code."""

from robust_ik.kernels.loader.kernel import kernels

searches_8, searches_16 = kernels("robust_ik.kernels.search.corank_search", "searches_8", "searches_16")
