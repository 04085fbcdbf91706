"""Compiled kinematics of searches: Jacobians and contractions of screw chains, the residual, and its steps."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.kinematics.svd import full_svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.singularities.find.projection_search import LONGEST_STEP, step
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.geometry.screw_chain import ScrewChain, axes_at_zero
from tests import screw_chain_reference as reference
from tests.robot.test_robot import chains

ROBOTS = ("pa10", "panda", "ur5", "tiago", "talos_arm", "kinova", "puma560", "planar_3r", "duleba_3r", "srs_10r")
MANY = 19
"""Two times eight that are done side by side, and three alone."""


@cache
def chain(name):
    return ScrewChain.of(rik.load(name))


@cache
def any_chain(seed):
    """A chain of no robot: joints that slide, that follow others by any factor, that do not move; some of the rows."""
    rng = np.random.default_rng(seed)
    count, n = int(rng.integers(2, 21)), int(rng.integers(1, 9))
    rows = tuple(rng.permutation(ROWS)[: rng.integers(1, 7)])
    mixing = np.zeros((count, n))
    mixing[np.arange(count), rng.integers(0, n, count)] = rng.choice([1.0, 1.0, -0.5, 2.0, 0.0], count)
    rotations, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    return ScrewChain(
        joint_names=tuple(f"q{i}" for i in range(n)),
        rows=rows,
        length_scale=float(rng.uniform(0.2, 3)),
        rotations=rotations * np.linalg.det(rotations)[:, None, None],
        offsets=rng.normal(size=(count, 3)),
        sliding=tuple(bool(each) for each in rng.random(count) < 0.3),
        tip=rng.normal(size=3),
        mixing=mixing,
        lower=np.full(n, -np.pi),
        upper=np.full(n, np.pi),
        period=np.full(n, 2 * np.pi),
        slides=(False,) * n,
    )


EVERY = [*(pytest.param(chain, name, id=name) for name in ROBOTS), *((any_chain, seed) for seed in range(25))]


# ------------------------------------------------------------------------------------------ kinematics
@pytest.mark.parametrize("made, name", EVERY)
def test_jacobians_and_contractions_are_those_of_numpy(made, name, rng):
    its = made(name)
    values = its.random(rng, MANY)
    U, V = rng.normal(size=(MANY, its.m, 2)), rng.normal(size=(MANY, its.n, 3))
    assert_allclose(its.jacobian(values), reference.jacobian(its, values), rtol=1e-12, atol=1e-12)
    assert_allclose(its.contraction(values, U, V), reference.contraction(its, values, U, V), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("made, name", EVERY)
def test_a_contraction_is_the_hessian_between_vectors(made, name, rng):
    its = made(name)
    values = its.random(rng, 3)
    U, V = rng.normal(size=(3, its.m, 2)), rng.normal(size=(3, its.n, 1))
    expected = np.einsum("nia,nijk,njb->nabk", U, its.hessian(values), V)
    assert_allclose(its.contraction(values, U, V), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", ["pa10", "tiago", "srs_10r"])
def test_a_batch_has_the_bits_of_each_alone(name):
    its, rng = chain(name), np.random.default_rng(5)
    values = its.random(rng, MANY)
    whole = Residual.at(its, values, 2)
    moved = step(whole, 0.1 * whole.norm)
    for index in range(MANY):
        alone = Residual.at(its, values[index : index + 1], 2)
        assert_array_equal(alone.s[0], whole.s[index])
        assert_array_equal(alone.derivative[0], whole.derivative[index])
        assert_array_equal(step(alone, 0.1 * alone.norm)[0], moved[index])


def test_no_configurations_have_no_contractions():
    its = chain("pa10")
    assert its.contraction(np.empty((0, 7)), np.empty((0, 6, 2)), np.empty((0, 7, 3))).shape == (0, 2, 3, 7)
    assert Residual.at(its, np.empty((0, 7)), 1).derivative.shape == (0, 2, 7)


def test_long_chains_need_no_compiled_decomposition(rng):
    n = 20
    its = replace(
        any_chain(0), joint_names=tuple(f"q{i}" for i in range(n)), rows=ROWS, rotations=np.tile(np.eye(3), (n, 1, 1)),
        offsets=rng.normal(size=(n, 3)), sliding=(False, True) * (n // 2), mixing=np.eye(n), lower=np.full(n, -1.0),
        upper=np.full(n, 1.0), period=np.full(n, np.inf),
    )  # fmt: skip
    values = its.random(rng, 3)
    found = full_svd(its.jacobian(values))
    expected = reference.contraction(its, values, found.U[..., -1:], np.swapaxes(found.Vt[:, 5:], 1, 2))
    assert_allclose(Residual.at(its, values, 1).derivative, expected[:, 0], atol=1e-12)


def test_a_joint_follows_one_other_at_the_most():
    with pytest.raises(rik.InputError, match="must follow one independent joint"):
        replace(chain("pa10"), mixing=np.ones((7, 7)))


@pytest.mark.parametrize("name", ["panda", "tiago", "pr2", "baxter", "pa10"])
def test_axes_at_zero_are_where_the_jacobian_has_them(name):
    for robot in chains(name) if name != "pa10" else [rik.load("pa10")]:
        its = ScrewChain.of(robot)
        axes, points = axes_at_zero(its.rotations, its.offsets)
        turning = ~np.array(its.sliding)
        tip = robot.pose(robot.neutral)[:3, 3]
        linear = np.where(turning[:, None], np.cross(axes, tip - points), axes)
        J = np.concatenate([linear, axes * turning[:, None]], axis=1).T @ its.mixing
        assert_allclose(J, robot.jacobian(robot.neutral, rows=ROWS), atol=1e-12, err_msg=str(robot))


# ------------------------------------------------------------------------------------------ the residual
@pytest.mark.parametrize("name, corank", [("pa10", 1), ("pa10", 3), ("tiago", 2), ("planar_3r", 1), ("srs_10r", 2)])
def test_a_residual_is_that_of_numpy_for_the_same_vectors(name, corank, rng):
    its = chain(name)
    values = its.random(rng, MANY)
    J = reference.jacobian(its, values)
    found, at = full_svd(its.jacobian(values)), Residual.at(its, values, corank)
    first = its.m - corank
    left, right = found.U[..., first:], np.swapaxes(found.Vt[:, first:], 1, 2)
    expected = reference.contraction(its, values, left, right)
    assert_allclose(at.s, np.linalg.svd(J, compute_uv=False), rtol=1e-10, atol=1e-12)
    assert_allclose(at.derivative, expected.reshape(at.derivative.shape), rtol=1e-12, atol=1e-12)
    assert_allclose(at.vector, (np.swapaxes(left, 1, 2) @ J @ right).reshape(at.vector.shape), atol=1e-12)


# ------------------------------------------------------------------------------------------ its steps
def plain_step(at, mu):
    """By normal equations in NumPy."""
    A, n = at.derivative, at.derivative.shape[2]
    gram = np.swapaxes(A, 1, 2) @ A
    mu = mu + 1e-15 * np.trace(gram, axis1=1, axis2=2)
    move = -np.linalg.solve(gram + mu[:, None, None] * np.eye(n), np.swapaxes(A, 1, 2) @ at.vector[..., None])[..., 0]
    longest = np.abs(move).max(axis=1, keepdims=True)
    return move * (LONGEST_STEP / np.maximum(longest, LONGEST_STEP))


@pytest.mark.parametrize("corank", [1, 2, 3, 4, 6])
def test_steps_solve_the_damped_normal_equations(corank, rng):
    its = chain("pa10")
    at = Residual.at(its, its.random(rng, MANY), corank)
    large, small = (damping * at.norm * at.scale for damping in (0.1, 1e-4))
    assert_allclose(step(at, large), plain_step(at, large), rtol=1e-9, atol=1e-9)
    assert_allclose(step(at, small), plain_step(at, small), rtol=1e-6, atol=1e-6)


def test_steps_are_cut_as_a_whole_and_there_are_none_without_a_slope(rng):
    derivative = np.zeros((3, 2, 4))
    derivative[0, 0, :2], derivative[1, 0] = 1e-3, 1.0
    s = np.column_stack([np.ones(3), np.full(3, 0.1)])
    moved = step(Residual(1, s, derivative, np.ones(3), 2), np.full(3, 1e-13))
    assert_allclose(moved[0], [-LONGEST_STEP, -LONGEST_STEP, 0, 0], atol=1e-6)
    assert_allclose(moved[1], np.full(4, -0.025), atol=1e-6)
    assert_array_equal(moved[2], np.zeros(4))


def test_a_slope_in_one_direction_alone_moves_in_no_other(rng):
    A = rng.normal(size=(1, 12, 1)) * rng.normal(size=7)
    at = Residual(3, np.array([[1.0, 1e-6, 1e-9, 1e-9]]), A, np.ones(1), 4)
    moved = step(at, np.array([1e-12]))
    along = A[0, 0] / np.linalg.norm(A[0, 0])
    assert_allclose(moved[0] - (moved[0] @ along) * along, 0, atol=1e-6)


# ------------------------------------------------------------------------------------------ gradients of σ
@pytest.mark.parametrize("name", ROBOTS)
def test_gradients_of_singular_values_need_no_hessian(name, rng):
    robot = rik.load(name)
    q = robot.random(rng, (2, 5))
    expected = rik.singular_value_gradients(robot.jacobian(q), robot.hessian(q))
    assert_allclose(robot.singular_value_gradients(q), expected, rtol=1e-9, atol=1e-9)
    assert robot.singular_value_gradients(q[0, 0]).shape == expected.shape[2:]


@pytest.mark.parametrize("rows", [ROWS, ("z", "wx", "x")])
def test_gradients_of_singular_values_are_differences(rows, rng):
    robot, h = rik.load("panda"), 1e-6
    q = robot.random(rng)
    around = [np.linalg.svd(robot.jacobian(q + h * u, rows=rows), compute_uv=False) for u in (*np.eye(7), *-np.eye(7))]
    slope = (np.array(around[:7]) - np.array(around[7:])) / (2 * h)
    assert_allclose(robot.singular_value_gradients(q, rows=rows), slope.T, atol=1e-7)


def test_gradients_take_any_frame_and_continuous_joints(rng):
    robot = rik.load("kinova")
    q = robot.random(rng, 3)
    frame = robot.description.chain(robot.tip)[3].child
    expected = rik.singular_value_gradients(
        robot.jacobian(q, frame, rows=("x", "y")), robot.hessian(q, frame, rows=("x", "y"))
    )
    assert_allclose(robot.singular_value_gradients(q, frame, rows=("x", "y")), expected, atol=1e-10)
