"""Exact second derivatives of the squared error E of a pose.

For a twist (v, w) of each joint along the chain and the error (p, r), −∂E/∂q_j / 2 = v_j·p + w_j·r, and half the second
derivative is v_j·v_k − (w_min × v_max)·p − ½ (w_min × w_max)·r + w_j·S w_k, where S is the symmetric part of the matrix
that takes w to the rate at which r shrinks.

Source: Murray, Li, Sastry 1994, section 3.4, for the derivatives of twists.
"""

from __future__ import annotations

import math

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.joint_motion import LOCAL_WORLD_ALIGNED, joint_twists
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.damped_step import slope

THREE = sizes(3)


@inlined
def triple(a: Pointer, i: int, b: Pointer, j: int, c: Pointer, k: int) -> float:
    """(a × b) · c of three vectors that begin at entries i, j and k."""
    return float(
        (a[i + 1] * b[j + 2] - a[i + 2] * b[j + 1]) * c[k]
        + (a[i + 2] * b[j] - a[i] * b[j + 2]) * c[k + 1]
        + (a[i] * b[j + 1] - a[i + 1] * b[j]) * c[k + 2]
    )


@inlined
def dot(a: Pointer, i: int, b: Pointer, j: int) -> float:
    """Dot product of two vectors of three that begin at entries i and j."""
    return float(a[i] * b[j] + a[i + 1] * b[j + 1] + a[i + 2] * b[j + 2])


@called
def curvature(
    problem: Pointer,
    twists: Pointer,
    end: Pointer,
    target: Pointer,
    error: Pointer,
    scale: float,
    H: Pointer,
    g: Pointer,
) -> None:
    """Fills H with half the second derivative of E, in rows of 16, and g with minus half its gradient."""
    pack = further(problem, int(problem[lay.CHAIN]))
    k, kind, free = int(problem[lay.COUNT]), int(problem[lay.TURN]), int(problem[lay.FREE])
    joint_twists(pack, twists, end, twists, LOCAL_WORLD_ALIGNED, 0.0)
    for x in range(16 * k):
        H[x] = 0.0
    for j in range(k):
        g[j] = 0.0
    square, half, weight = error[7], error[8], scale * scale
    kappa = (1.0 - half) / square if square > 1e-8 else (1.0 / 12 if kind == lay.FULL else 1.0 / 3)
    u = stack(0.0, ONE, THREE)
    for c in range(3):
        u[c] = 0.0
        for r in range(3):
            u[c] += end[3 * c + r] * target[3 * free + r]
    sine = math.sqrt(error[3] ** 2 + error[4] ** 2 + error[5] ** 2)
    psi = math.sqrt(square) / max(math.sin(math.sqrt(square)), 1e-9) if sine > 1e-8 else 1.0
    wanted = further(problem, lay.ROWS)
    for i in range(int(pack[links.JOINTS])):
        at = links.HEAD + i * links.STRIDE
        row, own = int(pack[at + links.COLUMN]), pack[at + links.FACTOR]
        a0, a1, a2 = slope(error, twists[6 * i + 3], twists[6 * i + 4], twists[6 * i + 5])
        along = dot(twists, 6 * i + 3, error, 3)
        if kind == lay.SINGLE:
            along = a0 * error[3] + a1 * error[4] + a2 * error[5]
        g[row] += own * (dot(twists, 6 * i, error, 0) + weight * along)
        for j in range(i + 1):
            to = links.HEAD + j * links.STRIDE
            column, factor = int(pack[to + links.COLUMN]), own * pack[to + links.FACTOR]
            value = 0.0
            for r in range(3):
                value += wanted[r] * twists[6 * i + r] * twists[6 * j + r]
            value -= triple(twists, 6 * j + 3, twists, 6 * i, error, 0)
            turned, other = 0.0, dot(twists, 6 * j + 3, error, 3)
            if kind == lay.FULL:
                turned = half * dot(twists, 6 * i + 3, twists, 6 * j + 3) + kappa * along * other
            elif kind == lay.SWING:
                turned = half * dot(twists, 6 * i + 3, twists, 6 * j + 3) + kappa * along * other
                mixed = dot(twists, 6 * i + 3, u, 0) * twists[6 * j + 3 + free]
                mixed += dot(twists, 6 * j + 3, u, 0) * twists[6 * i + 3 + free]
                turned -= 0.5 * psi * mixed
            elif kind == lay.SINGLE:
                b0, b1, b2 = slope(error, twists[6 * j + 3], twists[6 * j + 4], twists[6 * j + 5])
                turned = wanted[3] * a0 * b0 + wanted[4] * a1 * b1 + wanted[5] * a2 * b2
            if kind == lay.FULL or kind == lay.SWING:
                turned -= 0.5 * triple(twists, 6 * j + 3, twists, 6 * i + 3, error, 3)
            value = factor * (value + weight * turned)
            H[16 * row + column] += value
            if i != j:
                H[16 * column + row] += value
