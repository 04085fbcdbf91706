"""Motors: rigid displacements as unit dual quaternions r + ε d, eight numbers w x y z and their dual parts.

A joint's motor is linear in two numbers u: c + s A for a revolute joint, with c = cos(θ/2) and s = sin(θ/2), and
1 + d A for a slide, with d half its length. A = a + ε m holds the axis a and its moment m about the origin.
Source: Selig 2005, Geometric Fundamentals of Robotics, chapter 9.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, sizes, stack

NINE, THREE = sizes(9), sizes(3)
RIGID, FARTHEST = 1e-6, 1e9
"""Largest entry of R Rᵀ − 1; largest position, in units of length."""


@inlined
def quaternion_product(a: Pointer, i: int, b: Pointer, j: int, to: Pointer, k: int, before: float) -> None:
    """Writes before · to[k:k + 4] + a[i:i + 4] b[j:j + 4] to to[k:k + 4]."""
    aw, ax, ay, az = a[i], a[i + 1], a[i + 2], a[i + 3]
    bw, bx, by, bz = b[j], b[j + 1], b[j + 2], b[j + 3]
    to[k] = before * to[k] + (aw * bw - ax * bx - ay * by - az * bz)
    to[k + 1] = before * to[k + 1] + (aw * bx + ax * bw + ay * bz - az * by)
    to[k + 2] = before * to[k + 2] + (aw * by - ax * bz + ay * bw + az * bx)
    to[k + 3] = before * to[k + 3] + (aw * bz + ax * by - ay * bx + az * bw)


@called
def multiply(a: Pointer, b: Pointer, to: Pointer) -> None:
    """Fills in the product a b, (8,); `to` is neither of them."""
    to[0] = to[1] = to[2] = to[3] = to[4] = to[5] = to[6] = to[7] = 0.0
    quaternion_product(a, 0, b, 0, to, 0, 0.0)
    quaternion_product(a, 0, b, 4, to, 4, 0.0)
    quaternion_product(a, 4, b, 0, to, 4, 1.0)


@inlined
def conjugate(a: Pointer, to: Pointer) -> None:
    """Fills in the inverse of a unit motor, (8,)."""
    for half in range(2):
        to[4 * half] = a[4 * half]
        for i in range(1, 4):
            to[4 * half + i] = -a[4 * half + i]


@inlined
def joint_motor(axis: Pointer, c: float, s: float, to: Pointer) -> None:
    """Fills in c + s A, (8,)."""
    for i in range(8):
        to[i] = s * axis[i]
    to[0] += c


@called
def carried(M: Pointer, axis: Pointer, to: Pointer) -> None:
    """Fills in M A M⁻¹, (8,): the axis A carried along by the displacement M."""
    w, x, y, z = M[0], M[1], M[2], M[3]
    xx, yy, zz = x * x, y * y, z * z
    r00, r01, r02 = 1.0 - 2.0 * (yy + zz), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    r10, r11, r12 = 2.0 * (x * y + w * z), 1.0 - 2.0 * (xx + zz), 2.0 * (y * z - w * x)
    r20, r21, r22 = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (xx + yy)
    # The translation t of M is 2 d r*, its vector part.
    t0 = 2.0 * (w * M[5] - M[4] * x + (M[7] * y - M[6] * z))
    t1 = 2.0 * (w * M[6] - M[4] * y + (M[5] * z - M[7] * x))
    t2 = 2.0 * (w * M[7] - M[4] * z + (M[6] * x - M[5] * y))
    a0 = r00 * axis[1] + r01 * axis[2] + r02 * axis[3]
    a1 = r10 * axis[1] + r11 * axis[2] + r12 * axis[3]
    a2 = r20 * axis[1] + r21 * axis[2] + r22 * axis[3]
    m0 = r00 * axis[5] + r01 * axis[6] + r02 * axis[7]
    m1 = r10 * axis[5] + r11 * axis[6] + r12 * axis[7]
    m2 = r20 * axis[5] + r21 * axis[6] + r22 * axis[7]
    to[0], to[4] = 0.0, 0.0
    to[1], to[2], to[3] = a0, a1, a2
    to[5] = m0 + (t1 * a2 - t2 * a1)
    to[6] = m1 + (t2 * a0 - t0 * a2)
    to[7] = m2 + (t0 * a1 - t1 * a0)


@called
def motor_between(T: Pointer, R0: Pointer, p0: Pointer, scale: float, to: Pointer) -> bool:
    """Fills in the unit motor of T T₀⁻¹, lengths in units of `scale`; False if T, (4, 4), is no rigid pose.

    Source: Shepperd 1978: the largest of four candidates, so that nothing cancels.
    """
    R, off = stack(0.0, ONE, NINE), 0.0
    for i in range(3):
        for j in range(3):
            dot, total = 0.0, 0.0
            for k in range(3):
                dot += T[4 * i + k] * T[4 * j + k]
                total += T[4 * i + k] * R0[3 * j + k]
            R[3 * i + j] = total
            off = max(off, abs(dot - (1.0 if i == j else 0.0)))
    size = abs(T[3]) + abs(T[7]) + abs(T[11])
    last = abs(T[12]) + abs(T[13]) + abs(T[14]) + abs(T[15] - 1.0)
    if not (off <= RIGID and last <= RIGID and size <= FARTHEST * scale):
        return False
    xx, yy, zz = R[0], R[4], R[8]
    a, b, c = R[7] - R[5], R[2] - R[6], R[3] - R[1]
    if xx + yy + zz >= 0.0:
        w, x, y, z = 1.0 + xx + yy + zz, a, b, c
    elif xx >= yy and xx >= zz:
        w, x, y, z = a, 1.0 + xx - yy - zz, R[1] + R[3], R[2] + R[6]
    elif yy >= zz:
        w, x, y, z = b, R[1] + R[3], 1.0 - xx + yy - zz, R[5] + R[7]
    else:
        w, x, y, z = c, R[2] + R[6], R[5] + R[7], 1.0 - xx - yy + zz
    length = math.sqrt(w * w + x * x + y * y + z * z)
    handed = R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6])
    handed += R[2] * (R[3] * R[7] - R[4] * R[6])
    if not (length > 0.0 and handed > 0.0):
        return False
    w, x, y, z = w / length, x / length, y / length, z / length
    to[0], to[1], to[2], to[3] = w, x, y, z
    # What the motor's own rotation leaves of the point at zero.
    t = stack(0.0, ONE, THREE)
    for i in range(3):
        t[i] = T[4 * i + 3]
    xx, yy, zz = x * x, y * y, z * z
    t[0] -= (1.0 - 2.0 * (yy + zz)) * p0[0] + 2.0 * (x * y - w * z) * p0[1] + 2.0 * (x * z + w * y) * p0[2]
    t[1] -= 2.0 * (x * y + w * z) * p0[0] + (1.0 - 2.0 * (xx + zz)) * p0[1] + 2.0 * (y * z - w * x) * p0[2]
    t[2] -= 2.0 * (x * z - w * y) * p0[0] + 2.0 * (y * z + w * x) * p0[1] + (1.0 - 2.0 * (xx + yy)) * p0[2]
    h = 0.5 / scale
    to[4] = -h * (t[0] * x + t[1] * y + t[2] * z)
    to[5] = h * (t[0] * w + t[1] * z - t[2] * y)
    to[6] = h * (t[1] * w + t[2] * x - t[0] * z)
    to[7] = h * (t[2] * w + t[0] * y - t[1] * x)
    return True
