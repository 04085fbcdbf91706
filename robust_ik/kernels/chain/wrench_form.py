"""A wrench by ∂J/∂q, as a quadratic form in joint motions: its curvature along them."""

from __future__ import annotations

from robust_ik.kernels.chain.chain_kinematics import SIX, slope_of
from robust_ik.kernels.chain.chain_layout import COLUMN, FACTOR, HEAD, INDEPENDENT, JOINTS, STRIDE
from robust_ik.kernels.chain.joint_motion import LOCAL_WORLD_ALIGNED
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, stack


@called
def add_wrench_form(chain: Pointer, twists: Pointer, wrench: Pointer, reference: int, form: Pointer) -> None:
    """Adds a matrix, (n, n), whose symmetric part is that of Σ_r wrench_r ∂J_rj/∂q_k.

    Args:
        chain: The chain.
        twists: Of its joints, in the reference.
        wrench: Along the axes of the reference, (6,).
        reference: See `joint_motion`.
        form: (n, n).
    """
    count, n, slope = int(chain[JOINTS]), int(chain[INDEPENDENT]), stack(0.0, ONE, SIX)
    if reference == LOCAL_WORLD_ALIGNED:
        add_aligned_form(chain, twists, wrench, form)
        return
    for i in range(count):
        for k in range(count):
            slope_of(twists, i, k, reference, slope)
            row, column, total = HEAD + i * STRIDE, HEAD + k * STRIDE, 0.0
            for r in range(6):
                total += wrench[r] * slope[r]
            at = int(chain[row + COLUMN]) * n + int(chain[column + COLUMN])
            form[at] += chain[row + FACTOR] * chain[column + FACTOR] * total


@called
def add_aligned_form(chain: Pointer, twists: Pointer, wrench: Pointer, form: Pointer) -> None:
    """`add_wrench_form` along the axes of the world, at the frame's point.

    For joints k ≤ i, the symmetric part is w_k · (v_i × f + ½ w_i × t), with the wrench (f, t), see `slope_of`.
    """
    count, n = int(chain[JOINTS]), int(chain[INDEPENDENT])
    f0, f1, f2 = wrench[0], wrench[1], wrench[2]
    t0, t1, t2 = 0.5 * wrench[3], 0.5 * wrench[4], 0.5 * wrench[5]
    for i in range(count):
        a, row = 6 * i, HEAD + i * STRIDE
        v0, v1, v2, w0, w1, w2 = (
            twists[a], twists[a + 1], twists[a + 2], twists[a + 3], twists[a + 4], twists[a + 5]
        )  # fmt: skip
        x = v1 * f2 - v2 * f1 + (w1 * t2 - w2 * t1)
        y = v2 * f0 - v0 * f2 + (w2 * t0 - w0 * t2)
        z = v0 * f1 - v1 * f0 + (w0 * t1 - w1 * t0)
        column, factor = int(chain[row + COLUMN]), chain[row + FACTOR]
        for k in range(i + 1):
            b, other = 6 * k + 3, HEAD + k * STRIDE
            value = factor * chain[other + FACTOR] * (twists[b] * x + twists[b + 1] * y + twists[b + 2] * z)
            to = int(chain[other + COLUMN])
            form[column * n + to] += value
            if k < i:
                form[to * n + column] += value
