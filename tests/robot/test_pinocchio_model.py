"""Kinematics of one configuration: Pinocchio's own, for every kind of joint it has, and what its bindings need."""

import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.errors import InputError
from robust_ik.kinematics.chain import REFERENCES
from robust_ik.robot import pinocchio_model
from robust_ik.robot.pinocchio_model import frame_hessian, frame_jacobian, frame_pose

AXIS = np.array([1.0, 2.0, 2.0]) / 3
JOINTS = {
    "revolute": lambda: pin.JointModelRX(),
    "revolute about any axis": lambda: pin.JointModelRevoluteUnaligned(AXIS),
    "continuous": lambda: pin.JointModelRUBZ(),
    "prismatic": lambda: pin.JointModelPY(),
    "prismatic along any axis": lambda: pin.JointModelPrismaticUnaligned(AXIS),
    "helical": lambda: pin.JointModelHX(0.1),
    "helical about any axis": lambda: pin.JointModelHelicalUnaligned(AXIS, 0.1),
    "universal": lambda: pin.JointModelUniversal(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])),
    "spherical": lambda: pin.JointModelSpherical(),
    "spherical by three angles": lambda: pin.JointModelSphericalZYX(),
    "planar": lambda: pin.JointModelPlanar(),
    "translation": lambda: pin.JointModelTranslation(),
    "free": lambda: pin.JointModelFreeFlyer(),
}


def model_of(kind):
    """A turning joint, one of this kind, a turning joint, and a frame off the last one's origin."""
    rng = np.random.default_rng(0)
    model, joint = pin.Model(), 0
    for name, made in (("first", pin.JointModelRY()), ("second", JOINTS[kind]()), ("third", pin.JointModelRX())):
        joint = model.addJoint(joint, made, somewhere(rng), name)
    model.addFrame(pin.Frame("tip", joint, 0, somewhere(rng), pin.FrameType.OP_FRAME))
    return model


def somewhere(rng):
    return pin.SE3(pin.Quaternion(*(each := rng.normal(size=4)) / np.linalg.norm(each)).matrix(), rng.normal(size=3))


# That Pinocchio leaves out how the columns of one joint change with that joint itself, where it has several, is said in
# `frame_hessian`; no joint of a Robot has.
@pytest.mark.parametrize("kind", JOINTS)
def test_every_kind_of_joint_has_pose_jacobian_and_hessian(kind):
    model = model_of(kind)
    data, tip, h = model.createData(), model.getFrameId("tip"), 1e-5
    q = pin.integrate(model, pin.neutral(model), np.random.default_rng(1).normal(size=model.nv))
    around = [pin.integrate(model, q, step) for step in h * np.concatenate([np.eye(model.nv), -np.eye(model.nv)])]
    ahead, behind = np.split(np.array([frame_pose(model, data, each, tip) for each in around]), 2)
    turn = (ahead[:, :3, :3] @ np.swapaxes(behind[:, :3, :3], 1, 2)) / (2 * h)
    angular = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]])
    linear = (ahead[:, :3, 3] - behind[:, :3, 3]).T / (2 * h)
    J = frame_jacobian(model, data, q, tip, "local_world_aligned")
    assert_allclose(J, np.concatenate([linear, angular / 2]), atol=1e-8)
    joint = np.array([0, *[1] * (model.nv - 2), 2])
    within = (joint[:, None] == joint) & (model.nv > 3)
    for reference in REFERENCES:
        H = frame_hessian(model, data, q, tip, reference)
        there = np.array([frame_jacobian(model, data, each, tip, reference) for each in around])
        differences = np.moveaxis(there[: model.nv] - there[model.nv :], 0, -1) / (2 * h)
        assert H.flags.c_contiguous
        assert H.flags.owndata
        assert_allclose(H[:, ~within], differences[:, ~within], atol=1e-8, err_msg=reference)


@pytest.mark.parametrize("mended", [False, True])
def test_hessians_are_right_whichever_way_the_bindings_lay_them_out(monkeypatch, mended, rng):
    panda = rik.load("panda")
    q = panda.random(rng)
    expected = panda.hessian(q[None])[0]
    original = pin.getFrameKinematicHessian
    scrambled = pinocchio_model._is_column_major()

    def laid_out(model, data, frame, reference):
        H = original(model, data, frame, reference)
        right = H.reshape(H.shape[::-1]).T if scrambled else H
        return right.copy() if mended else right.T.reshape(right.shape)

    monkeypatch.setattr(pin, "getFrameKinematicHessian", laid_out)
    pinocchio_model._is_column_major.cache_clear()
    try:
        assert pinocchio_model._is_column_major() is not mended
        assert_allclose(panda.hessian(q), expected, atol=1e-12)
    finally:
        pinocchio_model._is_column_major.cache_clear()


def test_one_configuration_needs_no_compiled_code():
    script = (
        "import sys, robust_ik as rik; r = rik.load('panda'); r.pose(r.rest); r.jacobian(r.rest); r.hessian(r.rest);"
        "print('numba' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"


@pytest.mark.parametrize("name", ["kinova", "tiago", "pr2"])
def test_one_can_go_on_in_pinocchio(name, rng):
    robot = rik.load(name, "r_gripper_tool_frame" if name == "pr2" else None)
    q, data = robot.random(rng), robot.create_data()
    assert data is not robot.create_data()
    pin.framesForwardKinematics(robot.model, data, robot.pinocchio_q(q))
    placement = data.oMf[robot.model.getFrameId(robot.tip, pin.FrameType.BODY)]
    assert_allclose(robot.pose(q), placement.homogeneous, atol=1e-12)


def test_what_is_handed_to_pinocchio_is_the_callers_own_and_holds_followers(rng):
    robot = rik.load("tiago", whole_tree=True)
    q = robot.random(rng)
    whole = robot.pinocchio_q(q)
    assert whole.shape == (robot.model.nq,)
    whole[:] = 7
    arm = rik.load("panda")
    q = arm.random(rng)
    arm.pinocchio_q(q)[:] = 7
    assert abs(q).max() < 7
    with pytest.raises(InputError, match="one vector"):
        arm.pinocchio_q(arm.random(rng, 2))


@pytest.mark.parametrize("change", [np.asfortranarray, lambda q: np.repeat(q, 2)[::2], lambda q: q.astype(">f8"), list])
def test_any_vector_of_numbers_gives_the_same(change, rng):
    robot = rik.load("panda")
    q = robot.random(rng)
    for function in (robot.pose, robot.jacobian, robot.hessian):
        assert_array_equal(function(change(q)), function(q))


@pytest.mark.parametrize("name", ["panda", "kinova"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_one_number_that_is_not_finite_is_refused_wherever_it_stands(name, value):
    robot = rik.load(name)
    for place in range(robot.nq):
        q = robot.rest.copy()
        q[place] = value
        with pytest.raises(InputError, match="finite"):
            robot.jacobian(q)


def test_numbers_whose_squares_overflow_are_numbers():
    planar = rik.load("planar_2r")
    assert np.isfinite(planar.jacobian(np.array([1e200, 1.0]))).all()
