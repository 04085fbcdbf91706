"""The mathematics of all solutions: motors against matrices, roots against NumPy's, resultants against solutions."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik.branches import dual_quaternions as dual
from tests.screws import rotation


def pose(rng):
    T = np.eye(4)
    v = rng.normal(size=3)
    T[:3, :3], T[:3, 3] = rotation(v / np.linalg.norm(v), rng.uniform(0, np.pi)), rng.normal(size=3)
    return T


def test_products_of_motors_are_products_of_poses(rng):
    for _ in range(50):
        A, B = pose(rng), pose(rng)
        assert_allclose(dual.pose_of(dual.product(dual.motor_of(A), dual.motor_of(B))), A @ B, atol=1e-12)
        assert_allclose(dual.pose_of(dual.conjugate(dual.motor_of(A))), np.linalg.inv(A), atol=1e-12)


@pytest.mark.parametrize("axis", np.eye(3).tolist())
def test_half_turns_have_motors(axis):
    T = np.eye(4)
    T[:3, :3] = rotation(axis, np.pi)
    assert_allclose(dual.pose_of(dual.motor_of(T)), T, atol=1e-12)


def test_a_joint_turns_about_its_line(rng):
    a = rng.normal(size=3)
    a /= np.linalg.norm(a)
    p, angle = rng.normal(size=3), 0.7
    T = dual.pose_of(dual.joint_motor(dual.line(a, p), angle, slides=False))
    assert_allclose(T[:3, :3], rotation(a, angle), atol=1e-12)
    assert_allclose(T[:3, :3] @ p + T[:3, 3], p, atol=1e-12)
    assert_allclose(dual.pose_of(dual.joint_motor(dual.slide(a), 0.3, slides=True))[:3, 3], 0.3 * a, atol=1e-12)


def test_axes_are_carried_along_as_lines(rng):
    T, a, p = pose(rng), np.array([0.6, 0.8, 0.0]), rng.normal(size=3)
    carried = dual.moved(dual.motor_of(T), dual.line(a, p))
    assert_allclose(carried, dual.line(T[:3, :3] @ a, T[:3, :3] @ p + T[:3, 3]), atol=1e-12)
