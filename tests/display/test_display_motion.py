import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik.display.drawings.marks import Ellipsoids, LostDirections
from robust_ik.display.scene.smooth_motion import carried_frames, follow, full_basis, quaternions, right_handed

ROWS = ("x", "y", "z", "wx", "wy", "wz")


def rotation(axis, angle):
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def test_full_basis_completes_the_directions_of_a_tall_jacobian_with_lost_ones():
    U, s = full_basis(np.diag([3.0, 2.0, 1.0])[:, :2])
    assert_allclose(U.T @ U, np.eye(3), atol=1e-12)
    assert_allclose(s, [3, 2, 0])
    assert_allclose(np.abs(U[:, 2]), [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize("shape", [(6, 7), (6, 6), (6, 3), (2, 3), (1, 4)])
def test_followed_directions_stay_singular_vectors(shape):
    rng = np.random.default_rng(1)
    A, B = rng.normal(size=(2, *shape))
    J = np.array([A + 0.05 * t * B for t in range(40)])
    U, s = follow(J)
    assert_allclose(np.swapaxes(U, 1, 2) @ U, np.broadcast_to(np.eye(shape[0]), U.shape), atol=1e-10)
    assert_allclose(U * s[:, None, :] ** 2 @ np.swapaxes(U, 1, 2), J @ np.swapaxes(J, 1, 2), atol=0.05)


def test_directions_keep_their_place_when_singular_values_change_order():
    t = np.linspace(-1, 1, 41)
    J = np.array([np.diag([1 + x, 1 - x, 0.5]) for x in t])
    U, s = follow(J)
    assert (np.einsum("nij,nij->nj", U[1:], U[:-1]) > 0.99).all()
    assert_allclose(np.sort(s[:, 0])[[0, -1]], [0, 2], atol=1e-9)


def test_directions_of_equal_singular_values_do_not_turn_on_their_own():
    rng = np.random.default_rng(2)
    base = np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    J = np.array([base @ np.linalg.qr(rng.normal(size=(6, 6)))[0] for _ in range(30)])
    U, _ = follow(J)
    assert_allclose(U, np.broadcast_to(U[0], U.shape), atol=1e-8)


def test_following_a_zero_jacobian_gives_constant_directions():
    U, s = follow(np.zeros((5, 3, 4)))
    assert_allclose(s, 0)
    assert_allclose(U, np.broadcast_to(U[0], U.shape), atol=1e-12)


def test_carried_frames_point_along_the_directions_and_stay_rotations():
    directions = np.random.default_rng(3).normal(size=(2000, 3))
    R = carried_frames(directions)
    assert_allclose(R[:, :, 2], directions / np.linalg.norm(directions, axis=1, keepdims=True), atol=1e-12)
    assert_allclose(np.swapaxes(R, 1, 2) @ R, np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
    assert_allclose(np.linalg.det(R), 1, atol=1e-12)


def test_carried_frames_do_not_turn_more_than_the_direction():
    angles = np.linspace(0, 3, 200)
    R = carried_frames(np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=1))
    assert_allclose(R[:, :, 1], np.broadcast_to([0, 1, 0], (200, 3)), atol=1e-9)


@pytest.mark.parametrize("turned", [[0, 0, -1.0], [0, 1e-9, -1.0], [1e-4, 0, -1.0]])
def test_carried_frames_survive_a_reversal_and_hold_through_nothing(turned):
    R = carried_frames(np.array([[0, 0, 1.0], turned, [0, 0, 0], [0, 0, 1.0]]))
    assert_allclose(np.linalg.det(R), 1, atol=1e-9)
    assert_allclose(R[2], R[1])
    assert_allclose(R[:, :, 2] @ [0, 0, 1], [1, -1, -1, 1], atol=1e-6)


def test_quaternions_turn_as_the_rotations_and_never_jump():
    axes, angles = np.random.default_rng(4).normal(size=(50, 3)), np.linspace(0, 4 * np.pi, 50)
    R = np.array([rotation([1, 2, 3], angle) for angle in angles] + [rotation(axis, np.pi) for axis in axes])
    q = quaternions(R)
    x, y, z, w = q.T
    back = np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=-1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=-1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=1,
    )
    assert_allclose(back, R, atol=1e-12)
    assert (np.einsum("ni,ni->n", q[1:], q[:-1]) >= 0).all()


def test_right_handed_frames_keep_their_axes():
    frames = np.stack([np.eye(3), np.diag([1.0, 1, -1]), np.diag([-1.0, 1, 1])])
    fixed = right_handed(frames)
    assert_allclose(np.linalg.det(fixed), 1)
    assert_allclose(np.abs(fixed), np.abs(frames))


# ---------------------------------------------------------------------------------------- what is lost
def test_a_stretched_planar_arm_loses_the_direction_along_itself():
    q2 = np.linspace(0.5, 0.0, 30)
    J = np.array([[[-np.sin(q), -np.sin(q)], [1 + np.cos(q), np.cos(q)]] for q in q2])
    lost = LostDirections.of(J, ("x", "z"))
    assert lost.count == 1
    assert_allclose(np.abs(lost.linear[-1, 0]), [1, 0, 0], atol=1e-12)
    assert_allclose(lost.angular, 0)
    assert lost.nearness[0, 0] == 0
    assert lost.nearness[-1, 0] == 1
    assert (np.diff(lost.nearness[:, 0]) >= 0).all()
    assert_allclose(lost.spread, np.diag([1.0, 0, 0]), atol=0.1)


def test_threshold_is_relative_to_the_largest_singular_value():
    J = np.array([np.diag([5.0, 1.0])])
    assert LostDirections.of(J, ("x", "y"), gamma=0.1).count == 0
    assert_allclose(LostDirections.of(J, ("x", "y"), gamma=0.4).nearness, 0.5)


def test_a_rotation_is_lost_as_a_rotation():
    J = np.diag([1.0, 1, 1, 1, 1, 0])[None]
    lost = LostDirections.of(J, ROWS)
    assert_allclose(np.abs(lost.angular[0, 0]), [0, 0, 1], atol=1e-12)
    assert_allclose(lost.linear, 0, atol=1e-12)
    assert_allclose(lost.spread, 0)


def test_an_arm_with_too_few_joints_has_always_lost_the_rest():
    J = np.random.default_rng(5).normal(size=(6, 4))
    assert LostDirections.of(np.stack([J, 1.01 * J]), ROWS, gamma=1e-3).count == 2


def test_everything_is_lost_where_nothing_moves():
    lost = LostDirections.of(np.zeros((2, 6, 7)), ROWS)
    assert lost.count == 6
    assert_allclose(lost.nearness, 1)


def test_ellipsoids_have_the_singular_values_of_translation_for_axes():
    J = np.random.default_rng(6).normal(size=(1, 6, 7))
    shape = Ellipsoids.of(J, ROWS)
    A = shape.axes[0] * shape.lengths[0]
    assert_allclose(A @ A.T, J[0, :3] @ J[0, :3].T, atol=1e-12)
    assert_allclose(np.linalg.det(shape.axes), 1)


def test_the_ellipsoid_of_a_planar_arm_is_flat_and_of_pure_rotation_there_is_none():
    J = np.random.default_rng(7).normal(size=(5, 3, 3))
    shape = Ellipsoids.of(J, ("x", "z", "wy"))
    flat = np.argmin(shape.lengths[0])
    assert_allclose(shape.lengths[:, flat], 0, atol=1e-12)
    assert_allclose(np.abs(shape.axes[:, 1, flat]), 1)
    assert Ellipsoids.of(J, ("wx", "wy", "wz")) is None


def test_the_ellipsoid_turns_smoothly():
    angles = np.linspace(0, 2, 100)
    J = np.array([rotation([0, 0, 1], a) @ np.diag([2, 1 + 0.5 * np.sin(5 * a), 1.0]) for a in angles])
    axes = Ellipsoids.of(J, ("x", "y", "z")).axes
    assert (np.einsum("nij,nij->nj", axes[1:], axes[:-1]) > 0.95).all()
