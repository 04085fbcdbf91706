"""Arithmetic on lanes: in each lane what a number gets alone, also where comparisons are delicate."""

import math

import numba
import numpy as np

from robust_ik.kernels.compiler.simd_lanes import COUNT, somewhere, where
from robust_ik.kernels.compiler.stack_memory import ONE, by_eights, pointer, sizes, stack

RESULTS = sizes(8)
DELICATE = (0.0, -0.0, 1.5, -2.5, math.inf, -math.inf, math.nan, 1e-310)


@numba.njit(error_model="numpy")
def arithmetic(a, b, found):
    total, largest = 0.0, 0.0
    for i in range(COUNT):
        total += a[i] * b[i]
        largest = max(largest, abs(a[i]))
    found[0], found[1] = total, largest
    found[2], found[3] = min(a[0], b[0]), max(a[0], b[0])
    found[4], found[5] = math.sqrt(abs(a[1])), 1.0
    found[5] -= a[1] / b[2]
    found[6] = where((a[0] < b[0]) & (b[0] > 1.0), -a[0], 2.0)
    found[7] = 0.0
    if somewhere(a[3] < b[3]):
        found[7] = where(a[3] < b[3], a[3], found[7])


@numba.njit
def side_by_side(a, b, found):
    arithmetic(by_eights(pointer(a)), by_eights(pointer(b)), by_eights(pointer(found)))


@numba.njit
def one_by_one(a, b, found):
    x, y, z = stack(0.0, ONE, RESULTS), stack(0.0, ONE, RESULTS), stack(0.0, ONE, RESULTS)
    for lane in range(COUNT):
        for i in range(COUNT):
            x[i], y[i] = a[i, lane], b[i, lane]
        arithmetic(x, y, z)
        for i in range(COUNT):
            found[i, lane] = z[i]


@numba.njit
def whole(a, found):
    lanes = by_eights(pointer(a))
    found[0] = float(int(lanes[0]))


def aligned(values):
    room = np.zeros(values.size + COUNT)
    skipped = -room.ctypes.data % 64 // room.itemsize
    room[skipped : skipped + values.size] = values.ravel()
    return room[skipped : skipped + values.size].reshape(values.shape)


def test_each_lane_gets_what_it_would_get_alone():
    rng = np.random.default_rng(0)
    for _ in range(100):
        a, b = (aligned(np.where(rng.random((8, 8)) < 0.5, rng.choice(DELICATE, (8, 8)), rng.normal(size=(8, 8))))
                for _ in range(2))  # fmt: skip
        found, wanted = aligned(np.zeros((8, 8))), np.zeros((8, 8))
        side_by_side(a, b, found)
        one_by_one(a, b, wanted)
        np.testing.assert_array_equal(found, wanted)
        plain = ~np.isnan(wanted)
        np.testing.assert_array_equal(np.signbit(found)[plain], np.signbit(wanted)[plain])


def test_a_whole_number_that_lanes_share_is_one_number():
    found = np.zeros(1)
    whole(aligned(np.full((1, 8), 7.0)), found)
    assert found[0] == 7.0
