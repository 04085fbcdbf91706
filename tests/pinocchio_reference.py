"""Poses, Jacobians and Hessians from Pinocchio itself, for one q at a time: what compiled ones are measured against.

Pinocchio 4.1.0 hands out kinematic Hessians as column-major memory labelled row-major; a fixed one is left alone.
"""

from functools import cache

import numpy as np
import pinocchio as pin

FRAMES = {
    "local": pin.ReferenceFrame.LOCAL,
    "world": pin.ReferenceFrame.WORLD,
    "local_world_aligned": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
}


def index_of(robot, frame):
    """Where a link and a joint share a name, the link is meant."""
    found = [i for i, each in enumerate(robot.model.frames) if each.name == frame]
    return max(found, key=lambda i: robot.model.frames[i].type == pin.FrameType.BODY)


def all_joints(robot, q):
    """Pinocchio's q and what mixes its joints' derivatives, mimic joints being joints of their own there."""
    values = dict(zip(robot.joint_names, robot.joint_values(q)))
    entries, mixing = [], np.zeros((robot.model.nv, robot.n))
    for row, name in enumerate(list(robot.model.names)[1:]):
        driver = robot.description.driver[name]
        value = driver.multiplier * values[driver.source] + driver.offset
        mixing[row, robot.joint_names.index(driver.source)] = driver.multiplier
        turns = robot.description.joint[name].kind == "continuous"
        entries += [np.cos(value), np.sin(value)] if turns else [value]
    return np.array(entries), mixing


def pose(robot, q, frame):
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, all_joints(robot, q)[0])
    return np.array(pin.updateFramePlacement(robot.model, data, index_of(robot, frame)).homogeneous)


def jacobian(robot, q, frame, reference):
    whole, mixing = all_joints(robot, q)
    data = robot.model.createData()
    J = pin.computeFrameJacobian(robot.model, data, whole, index_of(robot, frame), FRAMES[reference])
    return np.array(J).reshape(6, -1) @ mixing


def hessian(robot, q, frame, reference):
    whole, mixing = all_joints(robot, q)
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, whole)
    pin.computeJointKinematicHessians(robot.model, data)
    H = np.array(pin.getFrameKinematicHessian(robot.model, data, index_of(robot, frame), FRAMES[reference]))
    H = H.reshape(6, robot.model.nv, robot.model.nv)
    if scrambled():
        H = H.ravel().reshape(H.shape, order="F")
    return np.einsum("rij,ia,jb->rab", H, mixing, mixing)


@cache
def scrambled():
    """Whether a 2R arm's ∂J_x1/∂q₂ = −cos(q₁+q₂) is put elsewhere."""
    model = pin.Model()
    first = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "first")
    second = model.addJoint(first, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([1.0, 0, 0])), "second")
    tip = model.addFrame(pin.Frame("tip", second, 0, pin.SE3(np.eye(3), np.array([1.0, 0, 0])), pin.OP_FRAME))
    data, q = model.createData(), np.array([0.3, 0.4])
    pin.computeJointJacobians(model, data, q)
    pin.computeJointKinematicHessians(model, data)
    H = pin.getFrameKinematicHessian(model, data, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    c1, c12 = np.cos(q[0]), np.cos(q.sum())
    return not np.allclose(H[0], [[-c1 - c12, -c12], [-c12, -c12]], atol=1e-12)
