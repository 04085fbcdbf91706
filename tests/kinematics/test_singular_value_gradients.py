"""Gradients of singular values and of manipulability, against central differences on real robots."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.kinematics import singular_value_gradients, svd
from tests.screws import Chain

ROBOTS = ["panda", "ur5", "xarm7", "kinova", "tiago", "pa10", "duleba_3r", "planar_2r", "almarkhi_4dof"]


def differences(function, robot, q, h=1e-6):
    around = robot.integrate(q, h * np.concatenate([np.eye(robot.n), -np.eye(robot.n)]))
    values = function(robot.jacobian(around))
    return np.moveaxis(values[: robot.n] - values[robot.n :], 0, -1) / (2 * h)


@pytest.mark.parametrize("name", ROBOTS)
def test_singular_value_gradients_agree_with_differences(name, rng):
    robot = rik.load(name)
    q = robot.random(rng)
    J, H = robot.jacobian(q), robot.hessian(q)
    expected = differences(lambda J: svd.svd(J).s, robot, q)
    assert_allclose(singular_value_gradients.singular_value_gradients(J, H), expected, atol=1e-7)
    assert_allclose(singular_value_gradients.singular_value_gradient(J, H), expected[-1], atol=1e-7)
    assert_allclose(singular_value_gradients.singular_value_gradient(J, H, 0), expected[0], atol=1e-7)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_manipulability_gradient_agrees_with_differences_and_with_the_trace_form(name, rng):
    robot = rik.load(name)
    q = robot.random(rng, 3)
    J, H = robot.jacobian(q), robot.hessian(q)
    gradient = singular_value_gradients.manipulability_gradient(J, H)
    for i in range(3):
        assert_allclose(gradient[i], differences(svd.manipulability, robot, q[i]), atol=1e-7)
    # Kim et al., eq. (30): m tr((∂J/∂q_k) J⁺)
    trace = np.einsum("bijk,bji->bk", H, np.linalg.pinv(J))
    assert_allclose(gradient, svd.manipulability(J)[:, None] * trace, atol=1e-9)


def test_the_manipulability_gradient_at_a_singularity_is_the_slope_of_the_signed_product():
    # 2R with unit links: manipulability is |sin q2|, so the slope at q2 = 0 is ±1 and none along q1.
    robot = rik.load("planar_2r")
    q = np.array([0.4, 0.0])
    gradient = singular_value_gradients.manipulability_gradient(robot.jacobian(q), robot.hessian(q))
    assert_allclose(np.abs(gradient), [0, 1], atol=1e-12)
    ahead = svd.manipulability(robot.jacobian(q + [0, 1e-6]))
    assert_allclose(ahead / 1e-6, 1, rtol=1e-6)


def test_gradients_of_a_zero_jacobian_are_finite(rng):
    J, H = np.zeros((3, 4)), rng.normal(size=(3, 4, 4))
    assert np.isfinite(singular_value_gradients.singular_value_gradients(J, H)).all()
    assert not singular_value_gradients.manipulability_gradient(J, H).any()


def test_the_sum_over_a_cluster_does_not_depend_on_its_basis(rng):
    # σ = (1, 1): the two singular values' sum is smooth, its gradient tr(Uᵀ ∂J V).
    Q = np.linalg.qr(rng.normal(size=(2, 2)))[0]
    H = rng.normal(size=(2, 2, 3))[:, :, :2]
    total = singular_value_gradients.singular_value_gradients(Q, H).sum(axis=0)
    assert_allclose(total, np.einsum("ij,ijk->k", Q, H), atol=1e-12)


def test_one_row_and_one_joint_work():
    assert_allclose(singular_value_gradients.manipulability_gradient([[-2.0]], [[[3.0]]]), [-3.0])


def test_shapes_that_do_not_fit_are_refused(rng):
    with pytest.raises(rik.InputError, match=r"hessian must have shape \(\.\.\., 3, 4, 4\)"):
        singular_value_gradients.singular_value_gradients(np.ones((3, 4)), np.ones((3, 4, 3)))


def test_an_index_out_of_range_is_refused():
    with pytest.raises(rik.InputError, match="3 singular values"):
        singular_value_gradients.singular_value_gradient(np.ones((3, 4)), np.ones((3, 4, 4)), 3)


def test_the_printed_form_of_the_papers_equation_9_is_wrong(rng):
    """Almarkhi-Maciejewski print p_k where p_i is right (k < i): wrong by over 0.5 on their own PA-10."""
    robot, worst = rik.load("pa10"), 0.0
    names = [f"joint{i + 1}" for i in range(7)]
    for q in robot.random(rng, 20):
        chain = Chain.at(robot.description.xml, robot.tip, dict(zip(names, q)))
        p, z, H = chain.T[:3, 3] - chain.o, chain.z, robot.hessian(q)
        for i in range(7):
            for k in range(i):
                corrected = (z[k] @ p[i]) * z[i] - (z[k] @ z[i]) * p[i]
                printed = (z[k] @ p[i]) * z[i] - (z[k] @ z[i]) * p[k]
                assert_allclose(H[:3, i, k], corrected, atol=1e-12)
                worst = max(worst, np.abs(H[:3, i, k] - printed).max())
    assert worst > 0.5
