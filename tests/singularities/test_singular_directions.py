"""What is lost at singular configurations: twists, screws, self-motions, words."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import robust_ik as rik
from robust_ik.singularities.lost_motion.axis_landmarks import Axes, landmarks
from robust_ik.singularities.lost_motion.lost_motion import lost_motion
from robust_ik.singularities.lost_motion.lost_motion_words import in_words
from robust_ik.singularities.lost_motion.sparse_basis import _best_angles, sparse_basis
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew

PI = np.pi
FOREARM = "the line through the point where axes 3, 4 and 5 meet and the point where axes 5, 6 and 7 meet"
UPPER_ARM = "the line through the point where axes 1, 2 and 3 meet and the point where axes 3, 4 and 5 meet"


def somewhere(robot, pinned, rng):
    """A configuration with some joints, from 1, at given angles and the others anywhere."""
    values = rng.uniform(-3, 3, robot.n)
    for joint, angle in pinned.items():
        values[joint - 1] = angle
    return robot.configuration(values)


def lost_at(robot, q, corank):
    return lost_motion(robot.jacobian(q), robot.hessian(q), robot.pose(q), corank)


def words(robot, pinned, corank, rng, samples=6):
    configurations = [somewhere(robot, pinned, rng) for _ in range(samples)]
    axes = [Axes.of(robot.jacobian(q), robot.pose(q)[:3, 3]) for q in configurations]
    return in_words([lost_at(robot, q, corank) for q in configurations], axes, landmarks(axes[0]))


@pytest.mark.parametrize("pinned, said", [
    ({2: 0, 3: PI / 2}, f"pure force along {FOREARM}"),
    ({2: 0, 6: PI}, "pure force through the point where axes 3, 4 and 5 meet"),
    ({4: 0}, f"pure force along {UPPER_ARM} and the point where axes 5, 6 and 7 meet"),
    ({5: -PI / 2, 6: 0}, f"pure force along {UPPER_ARM}"),
])  # fmt: skip
def test_the_pa10s_lost_wrenches_in_words(pinned, said, rng):
    """All of zero pitch: along the forearm, through the elbow, along both, along the upper arm."""
    assert words(rik.load("pa10"), pinned, 1, rng) == said


def test_a_wrist_of_a_ur5_bears_a_force_parallel_to_its_parallel_axes(rng):
    assert words(rik.load("ur5"), {5: 0}, 1, rng).startswith("pure force parallel to axes 2 and 3 and 4")


@pytest.mark.parametrize("name, pinned, corank", [
    ("pa10", {4: 0}, 1), ("pa10", {2: 0, 4: 0, 6: 0}, 2), ("pa10", {2: 0, 3: 0, 4: 0, 5: 0, 6: 0}, 3),
    ("ur5", {3: 0}, 1), ("puma560", {5: PI}, 1), ("panda", {2: 0, 4: 0}, 1),
])  # fmt: skip
def test_lost_twists_do_no_work_and_self_motions_move_nothing(name, pinned, corank, rng):
    robot = rik.load(name)
    for _ in range(5):
        q = somewhere(robot, pinned, rng)
        J, lost = robot.jacobian(q), lost_at(robot, q, corank)
        assert lost.corank == corank
        assert_allclose(lost.twists.T @ J, 0, atol=1e-9)
        assert_allclose(lost.twists.T @ lost.twists, np.eye(corank), atol=1e-9)
        assert lost.self_motions.shape == (robot.n, robot.n - 6 + corank)
        assert_allclose(J @ lost.self_motions, 0, atol=1e-9)
        turn = np.kron(np.eye(2), robot.pose(q)[:3, :3])
        outside = turn @ lost.tool_twists - lost.twists @ (lost.twists.T @ turn @ lost.tool_twists)
        assert_allclose(outside, 0, atol=1e-9)


def test_the_curvature_is_the_second_derivative_along_a_self_motion(rng):
    robot = rik.load("ur5")
    q = somewhere(robot, {3: 0}, rng)
    lost = lost_at(robot, q, 1)
    u, v, h = lost.twists[:, 0], lost.self_motions[:, 0], 1e-4
    velocity = [robot.jacobian(q + step * h * v) @ v for step in (1, -1)]
    assert_allclose(lost.curvature[0], (u @ (velocity[0] - velocity[1])) / (2 * h), atol=1e-6)


def test_an_elbow_is_the_end_of_reach_and_a_wrist_is_not(rng):
    """A stretched elbow is left to one side only: curvature of one sign; a UR5's wrist not to second order."""
    robot = rik.load("ur5")
    low, high = lost_at(robot, somewhere(robot, {3: 0}, rng), 1).curvature[0]
    assert low * high > 0
    assert_allclose(lost_at(robot, somewhere(robot, {5: 0}, rng), 1).curvature, 0, atol=1e-9)


def test_the_screw_does_not_hang_on_frame_reference_point_or_units(rng):
    robot = rik.load("pa10")
    q = somewhere(robot, {2: 0, 3: PI / 2}, rng)
    J, tool = robot.jacobian(q), robot.pose(q)[:3, 3]
    screw = WrenchScrew.of(rik.lost_directions(J)[:, 0], tool)
    for _ in range(10):
        other, scale = rng.normal(size=3), float(rng.uniform(0.1, 1e3))
        R = Rotation.random(random_state=rng).as_matrix()
        moved = J.copy()
        moved[:3] += np.cross(J[3:].T, other - tool).T  # the Jacobian of another point of the tool
        moved[:3] *= scale  # other units of length
        again = WrenchScrew.of(rik.lost_directions(np.kron(np.eye(2), R) @ moved)[:, 0], R @ other * scale)
        assert_allclose(abs(again.axis @ R @ screw.axis), 1, atol=1e-9)
        assert_allclose(again.pitch / scale, screw.pitch, atol=1e-9)
        assert_allclose(again.point, scale * R @ screw.point, atol=1e-8 * scale)


def test_the_screw_of_a_couple_has_no_point_and_that_of_nothing_is_refused():
    screw = WrenchScrew.of([0, 0, 0, 0, 0, -2.0], [1, 2, 3])
    assert screw.is_couple
    assert not screw.is_force
    assert_allclose(screw.axis, [0, 0, 1])
    assert np.isnan(screw.point).all()
    with pytest.raises(rik.InputError, match="must not be zero"):
        WrenchScrew.of(np.zeros(6), np.zeros(3))


def test_a_wrench_of_known_pitch():
    screw = WrenchScrew.of([0, 0, 2.0, 0.2 * 3, 0, 2 * 0.5], [0, 0, 0])
    assert_allclose(screw.pitch, 0.5)
    assert_allclose(screw.point, [0, 0.3, 0], atol=1e-12)


# ------------------------------------------------------------------------------------------------ sparse bases
@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_a_sparse_basis_spans_the_same_space_and_does_not_hang_on_the_basis_given(k, rng):
    for _ in range(10):
        basis = np.linalg.qr(rng.normal(size=(6, k)))[0]
        sparse = sparse_basis(basis)
        assert_allclose(sparse @ sparse.T, basis @ basis.T, atol=1e-9)
        turned = sparse_basis(basis @ np.linalg.qr(rng.normal(size=(k, k)))[0])
        assert_allclose((turned**4).sum(), (sparse**4).sum(), atol=1e-8)
        assert (sparse**4).sum() >= (basis**4).sum() - 1e-12


def test_no_turn_of_two_columns_has_a_larger_sum_of_fourth_powers_than_the_best_one(rng):
    x, y = rng.normal(size=(2, 20, 6))
    every = np.linspace(0, np.pi / 2, 2001)[:, None, None]

    def powers(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.sum((c * x + s * y) ** 4 + (c * y - s * x) ** 4, axis=-1)

    assert (powers(_best_angles(x, y)[:, None]) >= powers(every).max(axis=0) - 1e-9).all()


def test_a_turned_set_of_unit_vectors_is_found_again(rng):
    for _ in range(10):
        rows = np.sort(rng.choice(6, 3, replace=False))
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        assert_allclose(sparse_basis(np.eye(6)[:, rows] @ turn), np.eye(6)[:, rows], atol=1e-9)


@pytest.mark.parametrize("basis", [2 * np.eye(6)[:, :2], np.ones((6, 2)) / np.sqrt(6), np.eye(3)[:2], np.zeros((0, 2))])
def test_a_basis_whose_columns_are_not_orthonormal_is_refused(basis):
    with pytest.raises(rik.InputError, match="basis must"):
        rik.sparse_basis(basis)


def test_almarkhis_example_of_a_subspace_of_three():
    """Section 2.3: (.912 v_y, .410 w_z), (.912 v_z, −.410 w_y), w_x; the arm of Table 2 with a₇ = .45, d₇ = 0."""
    base = rik.load("pa10")
    q = base.configuration([0, 0, 0, 0, 0, 0, PI])
    T = base.pose(q)
    J = base.jacobian(q)
    offset = T[:3, :3] @ [0.45, 0, -0.45]  # from the tool of d₇ = .45 to that of a₇ = .45
    J[:3] += np.cross(J[3:].T, offset).T
    found = sparse_basis(rik.svd(J).U[:, 3:])
    a, b = 1 / np.hypot(1, 0.45), 0.45 / np.hypot(1, 0.45)
    expected = np.zeros((6, 3))
    expected[[1, 5], 0], expected[[2, 4], 1], expected[3, 2] = (a, b), (a, -b), 1
    assert_allclose(np.abs(found), np.abs(expected), atol=1e-9)
    assert_allclose(found @ found.T, expected @ expected.T, atol=1e-9)
