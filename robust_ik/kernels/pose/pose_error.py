"""The error of a pose: difference of positions, and rotation vector from the frame to its target, world axes."""

from __future__ import annotations

import math

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.joint_motion import place_frame
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import Number, root, size, somewhere, where
from robust_ik.kernels.compiler.stack_memory import Pointer, each_lane, further, lanes_of
from robust_ik.kernels.pose import pose_layout as lay

OPPOSITE = -0.9999995
"""Cosine of π − 0.001 rad: of larger angles the axis is taken from the symmetric part of the rotation."""
LEAST = 1e-150
"""Least sine or cosine that is divided by. Of a rotation one of them is at least 0.7."""
CLOSE = 0.9995
"""Cosine of 0.0316 rad: up to this angle a series is exact to the last bits."""
C1, C2, C3, C4, C5 = 1 / 6, 3 / 40, 5 / 112, 35 / 1152, 63 / 2816
"""Taylor series of arcsin s / s in s²: up to s² = 1e-3 the terms left out are below 2e-20."""
P0, P1, P2 = -8.750608600031904122785e-1, -1.615753718733365076637e1, -7.500855792314704667340e1
P3, P4 = -1.228866684490136173410e2, -6.485021904942025371773e1
"""P0 to P4: numerator of (arctan x − x)/x³ in x², for x up to 0.66, a minimax rational function; Cephes, atan.c."""
Q0, Q1, Q2 = 2.485846490142306297962e1, 1.650270098316988542046e2, 4.328810604912902668951e2
Q3, Q4 = 4.853903996359136964868e2, 1.945506571482613964425e2
"""Q0 to Q4: its denominator, whose leading coefficient is 1."""
SPARE = 6.123233995736765886130e-17
"""Difference between π/2 and the nearest double; MOREBITS of Cephes, atan.c."""


@inlined
def angle(sine: Number, cosine: Number) -> Number:
    """The angle in [0, π] of a sine ≥ 0 and a cosine, by a rational function: the same bits for numbers and lanes.

    Source: Moshier, Cephes, atan.c.
    """
    length = size(cosine)
    steep = sine > length
    small, large = where(steep, length, sine), where(steep, sine, length)
    large = where(large > LEAST, large, small * 0.0 + 1.0)
    # atan(s/l) = π/4 + atan((s − l)/(s + l)) for a ratio above tan(π/8).
    middle = small > 0.4142135623730950488 * large
    x = where(middle, small - large, small) / where(middle, small + large, large)
    z = x * x
    p = z * ((((P0 * z + P1) * z + P2) * z + P3) * z + P4)
    q = ((((z + Q0) * z + Q1) * z + Q2) * z + Q3) * z + Q4
    found = x + x * (p / q)
    found = where(middle, found + 0.5 * SPARE + 0.25 * math.pi, found)
    found = where(steep, (0.5 * math.pi - found) + SPARE, found)
    return where(cosine < 0.0, (math.pi - found) + 2.0 * SPARE, found)


@called
def measure(
    problem: Pointer,
    values: Pointer,
    target: Pointer,
    motions: Pointer,
    cosines: Pointer,
    sines: Pointer,
    axes: Pointer,
    end: Pointer,
    error: Pointer,
    zero: Number,
) -> None:
    """Computes the pose of the frame and its error in the wanted rows.

    Args:
        problem: See `pose_layout`.
        values: Joint values.
        target: Rotation, row by row, and position, 12 numbers.
        motions: Room for the motions of the chain, a multiple of 8.
        cosines: The same.
        sines: The same.
        axes: Filled, see `move`.
        end: Filled, see `move`.
        error: Filled with 12 numbers: position and rotation vector, zero in other rows; the squared lengths of both;
            θ/2 cot θ/2 of the rotation's angle, or φ cot φ of a swing's; the whole rotation vector.
        zero: 0 as one number, or as eight lanes.
    """
    pack = further(problem, int(problem[lay.CHAIN]))
    for i in range(int(pack[links.JOINTS])):
        at = links.HEAD + i * links.STRIDE
        motions[i] = pack[at + links.FACTOR] * values[int(pack[at + links.COLUMN])] + pack[at + links.SHIFT]
    place_frame(pack, motions, cosines, sines, axes, end, zero)
    for r in range(3):
        error[r] = (target[9 + r] - end[9 + r]) * problem[lay.ROWS + r]
        error[3 + r] = zero
    error[8] = zero + 1.0
    kind = int(problem[lay.TURN])
    if kind == lay.SWING:
        _swing(target, end, error, int(problem[lay.FREE]), zero)
    elif kind != lay.NONE:
        _rotation(target, end, error, zero)
        for r in range(3, 6):
            error[6 + r] = error[r]
            error[r] = error[r] * problem[lay.ROWS + r]
    error[6] = error[0] * error[0] + error[1] * error[1] + error[2] * error[2]
    error[7] = error[3] * error[3] + error[4] * error[4] + error[5] * error[5]


@inlined
def _along(target: Pointer, end: Pointer, i: int, j: int) -> Number:
    """Entry (i, j) of the rotation from the frame to the target, world axes."""
    a, b = 3 * i, 3 * j
    return target[a] * end[b] + target[a + 1] * end[b + 1] + target[a + 2] * end[b + 2]


@inlined
def _rotation(target: Pointer, end: Pointer, error: Pointer, zero: Number) -> None:
    m00, m11, m22 = _along(target, end, 0, 0), _along(target, end, 1, 1), _along(target, end, 2, 2)
    x = 0.5 * (_along(target, end, 2, 1) - _along(target, end, 1, 2))
    y = 0.5 * (_along(target, end, 0, 2) - _along(target, end, 2, 0))
    z = 0.5 * (_along(target, end, 1, 0) - _along(target, end, 0, 1))
    square, cosine = x * x + y * y + z * z, 0.5 * (m00 + m11 + m22 - 1.0)
    # θ / sin θ, by its series in sin² θ; θ/2 cot θ/2 is half of that times 1 + cos θ.
    factor = ((((C5 * square + C4) * square + C3) * square + C2) * square + C1) * square + 1.0
    if somewhere(cosine <= CLOSE):
        sine = root(square)
        some = sine > 1e-12
        far = where(some, angle(sine, cosine) / where(some, sine, zero + 1.0), zero + 1.0)
        factor = where(cosine > CLOSE, factor, far)
    error[3], error[4], error[5] = factor * x, factor * y, factor * z
    half = 0.5 * factor * (1.0 + cosine)
    error[8] = where(half > 1.0, zero + 1.0, where(half > 0.0, half, zero))
    if somewhere(cosine < OPPOSITE):
        L = lanes_of(zero)
        for lane in range(L):
            _half_turn(each_lane(target), each_lane(end), each_lane(error), lane, L)


@called
def _half_turn(target: Pointer, end: Pointer, error: Pointer, lane: int, L: int) -> None:
    """The rotation vector of nearly half a turn, whose axis is the longest column of the symmetric part."""
    m = (0.0, 0.0, 0.0)
    trace, best, most = 0.0, 0, -2.0
    for i in range(3):
        entry = _entry(target, end, i, i, lane, L)
        trace += entry
        if entry > most:
            best, most = i, entry
    cosine = max(0.5 * (trace - 1.0), -1.0)
    if cosine < OPPOSITE:
        a0 = 0.5 * (_entry(target, end, 0, best, lane, L) + _entry(target, end, best, 0, lane, L))
        a1 = 0.5 * (_entry(target, end, 1, best, lane, L) + _entry(target, end, best, 1, lane, L))
        a2 = 0.5 * (_entry(target, end, 2, best, lane, L) + _entry(target, end, best, 2, lane, L))
        a0 -= cosine if best == 0 else 0.0
        a1 -= cosine if best == 1 else 0.0
        a2 -= cosine if best == 2 else 0.0
        x = _entry(target, end, 2, 1, lane, L) - _entry(target, end, 1, 2, lane, L)
        y = _entry(target, end, 0, 2, lane, L) - _entry(target, end, 2, 0, lane, L)
        z = _entry(target, end, 1, 0, lane, L) - _entry(target, end, 0, 1, lane, L)
        m = (a0, a1, a2)
        theta = math.atan2(0.5 * math.sqrt(x * x + y * y + z * z), cosine)
        factor = theta / math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
        if a0 * x + a1 * y + a2 * z < 0.0:
            factor = -factor
        for r in range(3):
            error[(3 + r) * L + lane] = factor * m[r]


@inlined
def _entry(target: Pointer, end: Pointer, i: int, j: int, lane: int, L: int) -> float:
    total = 0.0
    for k in range(3):
        total += target[(3 * i + k) * L + lane] * end[(3 * j + k) * L + lane]
    return total


@inlined
def _swing(target: Pointer, end: Pointer, error: Pointer, free: int, zero: Number) -> None:
    """The shortest rotation that aligns a world axis; rotation about that axis is free."""
    one, two = (free + 1) % 3, (free + 2) % 3
    # The world axis carried along with the target: row `free` of the rotation. It must become that axis again.
    now, first, second = (
        _along(target, end, free, free), _along(target, end, free, one), _along(target, end, free, two)
    )  # fmt: skip
    # now × axis, in the order (free, one, two): the cross product of (n, a, b) and (1, 0, 0) is (0, b, −a).
    sine = root(first * first + second * second)
    phi = angle(sine, now)
    some = sine > 1e-12
    divisor = where(some, sine, zero + 1.0)
    factor = where(some, phi / divisor, zero + 1.0)
    # If it points exactly the opposite way, every perpendicular axis is right.
    flipped = where(some, zero, where(now < 0.0, zero + math.pi, zero))
    error[3 + one] = factor * second + flipped
    error[3 + two] = 0.0 - factor * first
    error[8] = where(some, phi * now / divisor, zero + 1.0)
