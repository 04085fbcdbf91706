"""Singular values in 60 digits: reads matrices (N, m, n) from a file, writes two arrays (N, k) that add up to them.

A double holds 16 digits; the second array holds the next 16, so that errors below the last bit can be told.
"""

from __future__ import annotations

import sys

import mpmath
import numpy as np

mpmath.mp.dps = 60


def values(A: np.ndarray) -> list[mpmath.mpf]:
    """σ of one matrix, descending."""
    wide = A if A.shape[0] <= A.shape[1] else A.T
    return sorted(mpmath.svd_r(mpmath.matrix(wide.tolist()), compute_uv=False), reverse=True)


if __name__ == "__main__":
    exact = [values(A) for A in np.load(sys.argv[1])]
    near = np.array([[float(s) for s in each] for each in exact])
    rest = np.array([[float(s - mpmath.mpf(n)) for s, n in zip(each, row)] for each, row in zip(exact, near)])
    np.savez(sys.argv[2], near=near, rest=rest)
