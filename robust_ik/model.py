"""Pinocchio, wrapped once: builds models, computes at a given q, undoes what its bindings scramble.

The only place that imports Pinocchio.
"""

from __future__ import annotations

import threading
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

from robust_ik.checks import Array
from robust_ik.description import Description
from robust_ik.errors import InputError, TipError, UrdfError, listed
from robust_ik.urdf import fix_joints

REFERENCES = {
    "local": pin.ReferenceFrame.LOCAL,
    "world": pin.ReferenceFrame.WORLD,
    "local_world_aligned": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
}

MAX_JOINTS = 200
"""Pinocchio's working memory grows with n³: 0.5 GB at 200 joints."""


def joints_to_keep(description: Description, tip: str | None) -> set[str]:
    """The joints that stay: those that move the tip (all for a whole tree), mimics with their sources."""
    joints = description.joints if tip is None else description.chain(tip)
    moving = [joint for joint in joints if joint.kind != "fixed"]
    for joint in moving:
        if joint.kind in ("floating", "planar"):
            raise UrdfError(
                f"{description.source}: joint {joint.name!r} is {joint.kind}; robust_ik moves fixed-base robots: "
                f"make that joint fixed, or choose a tip that it does not move"
            )
    if not moving:
        raise TipError(
            f"no joint moves {tip!r} of {description.name}; frames that move: "
            + listed([link for link in description.links if description.moving_joints(link)])
            if tip is not None
            else f"{description.name} has no joint that moves"
        )
    return {joint.name for joint in moving} | {description.driver[joint.name].source for joint in moving}


def build_model(description: Description, keep: set[str]) -> pin.Model:
    """The Pinocchio model of the joints in `keep`; the others are fixed at zero.

    They are fixed in the URDF rather than by buildReducedModel, which fails where a link and a joint share a name.

    Raises:
        UrdfError: Pinocchio cannot build it.
    """
    if len(keep) > MAX_JOINTS:
        raise UrdfError(f"{description.source} has {len(keep)} joints that move; more than {MAX_JOINTS} are refused")
    try:
        return pin.buildModelFromXML(fix_joints(description.xml, keep=keep))
    except (ValueError, RuntimeError) as error:
        raise UrdfError(f"{description.source}: Pinocchio cannot build it: {error}") from error


class _Scratch(threading.local):
    """Pinocchio's working memory, one per thread, so that a model can be shared between threads."""

    def __init__(self, model: pin.Model) -> None:
        self.data = model.createData()


class Kinematics:
    """Poses, Jacobians and Hessians of a model's frames as functions of one q of all its joints.

    Attributes:
        model: The Pinocchio model.
        frames: Frame name → index; where a link and a joint share a name, the link's frame is meant.
    """

    def __init__(self, model: pin.Model) -> None:
        self.model = model
        frames = sorted(enumerate(model.frames), key=lambda pair: pair[1].type == pin.FrameType.BODY)
        self.frames: dict[str, int] = {frame.name: index for index, frame in frames}
        self._scratch = _Scratch(model)

    def __reduce__(self) -> tuple[Any, ...]:
        return Kinematics, (self.model,)

    def pose(self, q: Array, frame: int) -> Array:
        """(4, 4)."""
        data = self._scratch.data
        pin.forwardKinematics(self.model, data, q)
        return np.array(pin.updateFramePlacement(self.model, data, frame).homogeneous)

    def jacobian(self, q: Array, frame: int, reference: str) -> Array:
        """(6, nv); Pinocchio's bindings drop the axis of a single joint."""
        J = pin.computeFrameJacobian(self.model, self._scratch.data, q, frame, reference_frame(reference))
        return np.array(J).reshape(6, self.model.nv)

    def hessian(self, q: Array, frame: int, reference: str) -> Array:
        """(6, nv, nv) with [i, j, k] = ∂J_ij/∂q_k."""
        data = self._scratch.data
        pin.computeJointJacobians(self.model, data, q)
        pin.computeJointKinematicHessians(self.model, data)
        H = np.asarray(pin.getFrameKinematicHessian(self.model, data, frame, reference_frame(reference)))
        return _as_written(H.reshape(6, self.model.nv, self.model.nv))


def reference_frame(name: str) -> pin.ReferenceFrame:
    """Pinocchio's name for a reference.

    Raises:
        InputError: There is no such reference.
    """
    try:
        return REFERENCES[name]
    except (KeyError, TypeError):
        raise InputError(f"reference must be one of {', '.join(REFERENCES)}, got {name!r}") from None


def _as_written(hessian: Array) -> Array:
    """Pinocchio's Hessian with [i, j, k] = ∂J_ij/∂q_k.

    Pinocchio 4.1.0 hands out column-major memory that is labelled row-major. A fixed Pinocchio is left alone.
    """
    hessian = np.asarray(hessian)
    return hessian.ravel().reshape(hessian.shape, order="F") if _hessian_is_scrambled() else hessian


@cache
def _hessian_is_scrambled() -> bool:
    """Whether a 2R arm's Hessian comes back wrong: ∂J_x1/∂q₂ = −cos(q₁+q₂) is put elsewhere when scrambled."""
    model = pin.Model()
    first = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "first")
    second = model.addJoint(first, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([1.0, 0, 0])), "second")
    tip = model.addFrame(pin.Frame("tip", second, 0, pin.SE3(np.eye(3), np.array([1.0, 0, 0])), pin.OP_FRAME))
    data, q = model.createData(), np.array([0.3, 0.4])
    pin.computeJointJacobians(model, data, q)
    pin.computeJointKinematicHessians(model, data)
    H = pin.getFrameKinematicHessian(model, data, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    c1, c12 = np.cos(q[0]), np.cos(q.sum())
    expected = np.array([[-c1 - c12, -c12], [-c12, -c12]])
    return not np.allclose(H[0], expected, atol=1e-12)
