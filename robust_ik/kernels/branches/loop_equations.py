"""Equations of a closed loop of six joints: what the joints outside a group do must lie in the span of the group.

Motors of two neighbouring joints, or of three that meet, are parallel or slide, span four of eight dimensions.
N, (4, 8), is zero there, so that N (product of the other motors) = 0: four equations, linear in u = (c, s) of each
other joint.
With a group of two joints these are all equations, unless its axes meet or are parallel.
Source of the idea, with other equations: Raghavan and Roth 1993; Husty, Pfurner and Schröcker 2007.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from robust_ik.kernels.branches.branches_layout import FIRST, GROUP, JOINTS, MOTOR, TRIPLE
from robust_ik.kernels.branches.circle_roots import CIRCLE_8, MOST_DEGREE
from robust_ik.kernels.branches.motors import multiply
from robust_ik.kernels.branches.pencils import FOUR, determinant
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, further, sizes, stack
from robust_ik.kernels.matrices.small_products import dot

ORDER = sizes(JOINTS)
SQUARE, THIRTY_SIX = sizes(64), sizes(36)


@called
def others(plan: Pointer, order: Pointer) -> tuple[int, int]:
    """Fills in the joints outside the group, as they follow each other; how many stand left of g, and how many in all.

    E_a … E_b = E_{a−1}⁻¹ … E_0⁻¹ g E_5⁻¹ … E_{b+1}⁻¹ for the group a to b, and E_5 g⁻¹ E_0 = E_4⁻¹ … E_1⁻¹.
    """
    first, size = int(plan[FIRST]), 3 if plan[TRIPLE] > 0.0 else 2
    if first + size > JOINTS:
        for i in range(GROUP):
            order[i] = float(4 - i)
        return 0, GROUP
    for i in range(first):
        order[i] = float(first - 1 - i)
    for i in range(JOINTS - first - size):
        order[first + i] = float(JOINTS - 1 - i)
    return first, JOINTS - size


@called
def products(axes: Pointer, seed: Pointer, order: Pointer, left: int, count: int, to: Pointer) -> None:
    """Fills in the motors of Π (1, −A) with `seed` between, (2^count, 8); the first variable is the slowest index."""
    opposite, done = stack(0.0, ONE, W8), 0
    for i in range(MOTOR):
        to[i] = seed[i]
    for turn in range(count):
        place = left - 1 - turn if turn < left else turn
        bit = 1 << (count - 1 - place)
        axis = further(axes, MOTOR * int(order[place]))
        for i in range(MOTOR):
            opposite[i] = -axis[i]
        for t in range(1 << count):
            if t & done == t:
                if turn < left:
                    multiply(opposite, further(to, MOTOR * t), further(to, MOTOR * (t | bit)))
                else:
                    multiply(further(to, MOTOR * t), opposite, further(to, MOTOR * (t | bit)))
        done |= bit


@called
def equations(N: Pointer, motors: Pointer, many: int, to: Pointer) -> None:
    """Fills in N times each of `many` motors, (4, many)."""
    for r in range(GROUP):
        for t in range(many):
            to[many * r + t] = dot(further(N, MOTOR * r), further(motors, MOTOR * t), MOTOR)


@called
def span_of_pair(first: Pointer, middle: Pointer, second: Pointer, N: Pointer, parts: Pointer) -> None:
    """Fills in N and S⁺, (4, 8) each, of the group A · middle · B; S = [m, m B, A m, A m B].

    Source: Householder 1958; S = Q R, N is the rest of Qᵀ, S⁺ = R⁻¹ times its beginning.
    """
    S, Q, column = stack(0.0, FOUR, W8), stack(0.0, W8, W8), stack(0.0, ONE, W8)
    for i in range(MOTOR):
        S[i] = middle[i]
    multiply(middle, second, further(S, MOTOR))
    multiply(first, middle, further(S, 2 * MOTOR))
    multiply(further(S, 2 * MOTOR), second, further(S, 3 * MOTOR))
    for i in range(MOTOR * MOTOR):
        Q[i] = 0.0
    for i in range(MOTOR):
        Q[MOTOR * i + i] = 1.0
    for k in range(GROUP):
        length = 0.0
        for i in range(k, MOTOR):
            length += S[MOTOR * k + i] ** 2
        length = math.copysign(math.sqrt(length), S[MOTOR * k + k])
        for i in range(MOTOR):
            column[i] = 0.0 if i < k else S[MOTOR * k + i]
        column[k] += length
        square = 0.0
        for i in range(k, MOTOR):
            square += column[i] ** 2
        if not square > 0.0:
            continue
        for j in range(k, GROUP):
            total = 0.0
            for i in range(k, MOTOR):
                total += column[i] * S[MOTOR * j + i]
            for i in range(k, MOTOR):
                S[MOTOR * j + i] -= 2.0 * total / square * column[i]
        for j in range(MOTOR):  # Q holds Qᵀ
            total = 0.0
            for i in range(k, MOTOR):
                total += column[i] * Q[MOTOR * i + j]
            for i in range(k, MOTOR):
                Q[MOTOR * i + j] -= 2.0 * total / square * column[i]
    for r in range(GROUP):
        for j in range(MOTOR):
            N[MOTOR * r + j] = Q[MOTOR * (GROUP + r) + j]
    for j in range(MOTOR):
        for r in range(GROUP - 1, -1, -1):
            total = Q[MOTOR * r + j]
            for k in range(r + 1, GROUP):
                total -= S[MOTOR * k + r] * parts[MOTOR * k + j]
            parts[MOTOR * r + j] = total / S[MOTOR * r + r] if S[MOTOR * r + r] != 0.0 else 0.0


@called
def span_of_slides(first: Pointer, second: Pointer, N: Pointer, parts: Pointer) -> None:
    """`span_of_pair` of two slides across each other, whose motors are 1 + ε t: rotations vanish, and t across both."""
    for i in range(GROUP * MOTOR):
        N[i], parts[i] = 0.0, 0.0
    parts[0] = 1.0
    for i in range(3):
        N[MOTOR * i + 1 + i] = 1.0
        parts[MOTOR + 5 + i], parts[2 * MOTOR + 5 + i] = second[5 + i], first[5 + i]
        a, b = 5 + (i + 1) % 3, 5 + (i + 2) % 3
        N[MOTOR * 3 + 5 + i] = first[a] * second[b] - first[b] * second[a]


def _terms() -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    """Columns (k, 4) of minors, ascending, and their places in the 6 × 6 matrix with signs (k, 2).

    Source: Dixon 1908. With f(u, v, w) of four equations linear in each, the determinant of f(u, v, w), f(u′, v, w),
    f(u′, v′, w), f(u′, v′, w′) over (u − u′)(v − v′)(w − w′) is a form in (v, w²) and (u′², v′); degrees above cancel.
    """
    columns, places = [], []
    for b, c, a2, c2, a3, b3, a4, b4 in itertools.product((0, 1), repeat=8):
        four = (4 + 2 * b + c, 4 * a2 + 2 + c2, 4 * a3 + 2 * b3 + 1, 4 * a4 + 2 * b4)
        if a2 + a3 + a4 < 3 and b3 + b4 < 2 and len(set(four)) == 4:
            order = np.argsort(four)
            sign = round(np.linalg.det(np.eye(4)[order]))
            columns.append(np.sort(four))
            places.append((6 * (3 * b + c + c2) + 2 * (a2 + a3 + a4) + b3 + b4, sign))
    return np.ascontiguousarray(columns, dtype=np.int8), np.ascontiguousarray(places, dtype=np.int8)


COLUMNS, PLACES = _terms()


@called
def resultant(C: Pointer) -> tuple[float, float]:
    """The determinant of Dixon's matrix of four equations in three variables, (4, 8), and a bound of its rounding.

    It is 0 where they have a solution.
    """
    upper, lower, D = stack(0.0, ONE, SQUARE), stack(0.0, ONE, SQUARE), stack(0.0, ONE, THIRTY_SIX)
    for i in range(8):
        for j in range(i + 1, 8):
            upper[8 * i + j] = C[i] * C[8 + j] - C[j] * C[8 + i]
            lower[8 * i + j] = C[16 + i] * C[24 + j] - C[16 + j] * C[24 + i]
    for i in range(36):
        D[i] = 0.0
    for t in range(len(COLUMNS)):
        i, j, k, n = COLUMNS[t, 0], COLUMNS[t, 1], COLUMNS[t, 2], COLUMNS[t, 3]
        minor = upper[8 * i + j] * lower[8 * k + n] - upper[8 * i + k] * lower[8 * j + n]
        minor += upper[8 * i + n] * lower[8 * j + k] + upper[8 * j + k] * lower[8 * i + n]
        minor += upper[8 * k + n] * lower[8 * i + j] - upper[8 * j + n] * lower[8 * i + k]
        D[PLACES[t, 0]] += PLACES[t, 1] * minor
    return determinant(D, 6)


@called
def without(M: Pointer, place: int, count: int, c: float, s: float, to: Pointer) -> None:
    """Fills in M with the variable at `place` given, (4, 2^(count − 1)), from (4, 2^count)."""
    many, low = 1 << (count - 1), count - 1 - place
    for r in range(GROUP):
        for t in range(many):
            at = ((t >> low) << (low + 1)) | (t & ((1 << low) - 1))
            base = 2 * many * r + at
            to[many * r + t] = c * M[base] + s * M[base + (1 << low)]


@called
def eliminant(M: Pointer, place: int, values: Pointer) -> float:
    """Fills in the resultant of M, (4, 16), at 17 angles of the variable at `place`, the first or the last one.

    Returns:
        The largest bound of its rounding.
    """
    noise = 0.0
    C, count = stack(0.0, FOUR, W8), 2 * MOST_DEGREE + 1
    for j in range(count):
        cosine = CIRCLE_8[j]
        # Half the angle, which is below π.
        c = math.sqrt(max(0.5 * (1.0 + cosine), 0.0)) * (1.0 if 2 * j < count else -1.0)
        s = math.sqrt(max(0.5 * (1.0 - cosine), 0.0))
        without(M, place, 4, c, s, C)
        values[j], bound = resultant(C)
        noise = max(noise, bound)
    return noise


@called
def motor_at(motors: Pointer, u: Pointer, count: int, to: Pointer) -> None:
    """Fills in Σ Πᵢ uᵢ · motors, (8,), for (count, 2) variables."""
    for i in range(MOTOR):
        to[i] = 0.0
    for t in range(1 << count):
        weight = 1.0
        for place in range(count):
            weight *= u[2 * place + ((t >> (count - 1 - place)) & 1)]
        for i in range(MOTOR):
            to[i] += weight * motors[MOTOR * t + i]


@called
def seed_of(plan: Pointer, g: Pointer, to: Pointer) -> None:
    """Fills in what stands between the left and the right joints: g, or 1 for the pair of joints 5 and 0."""
    wrapped = plan[FIRST] + (3 if plan[TRIPLE] > 0.0 else 2) > JOINTS
    for i in range(MOTOR):
        to[i] = 0.0 if wrapped else g[i]
    if wrapped:
        to[0] = 1.0
