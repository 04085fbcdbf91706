"""Pinocchio, wrapped in one place: builds models, computes kinematics, and extracts the constants for compiled kernels.

The only place that imports Pinocchio.
"""

from __future__ import annotations

import reprlib
import threading
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

from robust_ik.checks import Array
from robust_ik.description.joint_tree import Description
from robust_ik.description.notes import named
from robust_ik.description.urdf import fix_joints
from robust_ik.errors import FrameNotFoundError, InputError, TipError, UrdfError, listed, suggest
from robust_ik.kinematics.chain import REFERENCES, Chain, axis_frames, number_of
from robust_ik.robot.joint_map import JointMap

Model, Data = pin.Model, pin.Data

MAX_JOINTS = 200
"""Pinocchio's working memory grows with n³: 0.5 GB at 200 joints."""


def joints_to_keep(description: Description, tip: str | None) -> set[str]:
    """The joints to keep: those that move the tip (all for a whole tree), mimic joints with their sources.

    Raises:
        UrdfError: One of them cannot move as written.
        TipError: There is none.
    """
    joints = description.joints if tip is None else description.chain(tip)
    moving = [joint for joint in joints if joint.kind != "fixed"]
    if not moving:
        raise TipError(
            f"no joint moves {tip!r} of {description.name}; frames that move: "
            + listed([link for link in description.links if description.moving_joints(link)])
            if tip is not None
            else f"{description.name} has no joint that moves"
        )
    keep = {joint.name for joint in moving} | {description.driver[joint.name].source for joint in moving}
    for name in (*(joint.name for joint in joints), *keep):
        if problem := description.joint[name].problem:
            before = description.joint[name].parent
            other = f"; a tip that it does not move is {before!r}" if description.moving_joints(before) else ""
            needs = "" if tip is None else f" (the tip {tip!r} depends on it{other})"
            raise UrdfError(f"{description.source}: {named('joint', name)} {problem}{needs}")
    return keep


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


_REFERENCES = {name: getattr(pin.ReferenceFrame, name.upper()) for name in REFERENCES}


def frame_pose(model: pin.Model, data: pin.Data, q: Array, frame: int) -> Array:
    """The pose of a frame in the world, (4, 4), for any kind of Pinocchio's joints.

    Args:
        model: The model.
        data: Its working memory.
        q: Pinocchio's configuration, (model.nq,).
        frame: Index of the frame.
    """
    pin.forwardKinematics(model, data, q)
    return np.array(pin.updateFramePlacement(model, data, frame).homogeneous)


def frame_jacobian(model: pin.Model, data: pin.Data, q: Array, frame: int, reference: str) -> Array:
    """The geometric Jacobian of a frame, (6, model.nv), for any kind of Pinocchio's joints.

    Args:
        model: The model.
        data: Its working memory.
        q: Pinocchio's configuration, (model.nq,).
        frame: Index of the frame.
        reference: One of `kinematics.chain.REFERENCES`.
    """
    J: Array = pin.computeFrameJacobian(model, data, q, frame, _kind(reference)).copy()
    return J if J.ndim == 2 else J.reshape(6, 1)  # the bindings drop the axis of a single joint


def frame_hessian(model: pin.Model, data: pin.Data, q: Array, frame: int, reference: str) -> Array:
    """The derivative of `frame_jacobian`, [i, j, k] = ∂J_ij/∂v_k, (6, model.nv, model.nv).

    Every joint of a `Robot` has one degree of freedom. For joints with several (spherical, planar, free), Pinocchio's
    Hessian leaves out the derivatives of their columns with respect to the same joint.

    Args:
        model: The model.
        data: Its working memory.
        q: Pinocchio's configuration, (model.nq,).
        frame: Index of the frame.
        reference: One of `kinematics.chain.REFERENCES`.
    """
    pin.computeJointKinematicHessians(model, data, q)
    H: Array = pin.getFrameKinematicHessian(model, data, frame, _kind(reference))
    return H.reshape(H.shape[::-1]).T.copy() if _is_column_major() else H


def _kind(reference: str) -> Any:
    try:
        return _REFERENCES[reference]
    except (KeyError, TypeError):
        number_of(reference)  # raises for an unknown reference
        raise


@cache
def _is_column_major() -> bool:
    """Whether the bindings return kinematic Hessians as column-major memory labelled row-major, as version 4.1 does.

    The test is a planar arm with two links of 1 m: with both joints at zero, in world axes, ∂J_y/∂q and ∂J_z/∂q are 0
    and ∂J_x/∂q is −2, −1; −1, −1.
    """
    model = pin.Model()
    joint, link = 0, pin.SE3.Identity()
    for name in ("first", "second"):
        joint = model.addJoint(joint, pin.JointModelRZ(), link, name)
        link = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    frame = model.addFrame(pin.Frame("tip", joint, 0, link, pin.FrameType.OP_FRAME))
    data = model.createData()
    pin.computeJointKinematicHessians(model, data, np.zeros(2))
    H = pin.getFrameKinematicHessian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    return not np.allclose(H[0], [[-2.0, -1.0], [-1.0, -1.0]])


class PlacedSolids:
    """Solids on the joints of a model, at one configuration after another.

    It has working memory of its own, so that each thread needs one of its own.
    """

    def __init__(self, model: pin.Model, solids: Sequence[tuple[int, Array, Any]]) -> None:
        """Places solids nowhere yet.

        Args:
            model: The model.
            solids: For each its joint, its placement in the frame of that joint, (4, 4), and a shape of coal's.
        """
        self._model, self._data, self._geometry = model, model.createData(), pin.GeometryModel()
        for number, (joint, placement, shape) in enumerate(solids):
            self._geometry.addGeometryObject(pin.GeometryObject(str(number), joint, pin.SE3(placement), shape))
        self._placed = self._geometry.createData()
        # What the memory holds then: these change when it does.
        self._frames = [self._data.oMi[joint] for joint in range(model.njoints)]
        self._placements = [self._placed.oMg[solid] for solid in range(len(solids))]

    @property
    def count(self) -> int:
        """Number of solids."""
        return len(self._placements)

    def place(self, q: Array) -> None:
        """Moves all solids to where they are at Pinocchio's configuration, (model.nq,)."""
        pin.computeJointJacobians(self._model, self._data, q)
        pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._placed)

    def frames(self) -> Array:
        """The poses of the world and of the N joints, (1 + N, 4, 4)."""
        return np.array([each.homogeneous for each in self._frames])

    def twists(self) -> Array:
        """The unit twists of the N joints about the world's origin along its axes, linear then angular, (6, N)."""
        return np.array(self._data.J).reshape(6, -1)  # the bindings drop the axis of a single joint

    def placement(self, solid: int) -> tuple[Array, Array]:
        """The rotation, (3, 3), and the position, (3,), of a solid in the world; to be read before the next `place`."""
        there = self._placements[solid]
        return there.rotation, there.translation


class PinocchioModel:
    """A model, its frames, and their kinematics as functions of the robot's q.

    Attributes:
        model: The Pinocchio model; a mimic joint is a joint of its own there.
        joints: The map from independent joints to its joints.
        frames: Frame name → index; if a link and a joint share a name, that of the link.
    """

    def __init__(self, model: pin.Model, joints: JointMap) -> None:
        self.model, self.joints = model, joints
        frames = sorted(enumerate(model.frames), key=lambda pair: pair[1].type == pin.FrameType.BODY)
        self.frames: dict[str, int] = {frame.name: index for index, frame in frames}
        self._chains: dict[int, Chain] = {}
        self._of_thread = threading.local()

    def __reduce__(self) -> tuple[Any, ...]:
        return PinocchioModel, (self.model, self.joints)

    @property
    def _data(self) -> pin.Data:
        """Working memory of this thread, so that several threads may use one robot."""
        try:
            return self._of_thread.data
        except AttributeError:
            self._of_thread.data = self.model.createData()
            return self._of_thread.data

    def index(self, frame: str, robot: str, description: Description) -> int:
        """Index of a frame.

        Args:
            frame: Its name.
            robot: Whose it is, for the message.
            description: The description of that robot, for the message.

        Raises:
            FrameNotFoundError: There is no such frame.
            InputError: The name is no text.
        """
        if not isinstance(frame, str):
            raise InputError(f"a frame is named by a str, got {reprlib.repr(frame)}")
        if frame not in self.frames:
            hint = description.taken_as(frame) + suggest(frame, self.frames)
            raise FrameNotFoundError(f"{robot} has no frame {frame!r}; {hint}")
        return self.frames[frame]

    def pose(self, q: Array, frame: int) -> Array:
        """The pose of a frame, (nq,) → (4, 4)."""
        return frame_pose(self.model, self._data, self.joints.all_joints(q), frame)

    def jacobian(self, q: Array, frame: int, reference: str) -> Array:
        """The Jacobian of a frame, (nq,) → (6, n)."""
        J = frame_jacobian(self.model, self._data, self.joints.all_joints(q), frame, reference)
        return J if self.joints.independent else J @ self.joints.mixing

    def hessian(self, q: Array, frame: int, reference: str) -> Array:
        """The Hessian of a frame, (nq,) → (6, n, n)."""
        H = frame_hessian(self.model, self._data, self.joints.all_joints(q), frame, reference)
        return H if self.joints.independent else self.joints.mixing.T @ H @ self.joints.mixing

    def chain(self, frame: int) -> Chain:
        """The joints that move a frame, as constants."""
        if frame not in self._chains:
            self._chains[frame] = self._chain(frame)
        return self._chains[frame]

    def _chain(self, frame: int) -> Chain:
        model, data, joints = self.model, self.model.createData(), self.joints
        pin.computeJointJacobians(model, data, pin.neutral(model))
        pin.updateFramePlacement(model, data, frame)
        moving = [joint for joint in model.supports[model.frames[frame].parentJoint] if joint]
        J = np.array(data.J).reshape(6, model.nv)  # the bindings drop the axis of a single joint
        columns = [J[:, model.joints[joint].idx_v] for joint in moving]
        sliding = np.array([not column[3:].any() for column in columns], dtype=bool)
        axes = np.array([column[:3] if slides else column[3:] for column, slides in zip(columns, sliding)])
        points = np.array([data.oMi[joint].translation for joint in moving])
        rotations, origins, tip = axis_frames(axes.reshape(-1, 3), points, np.array(data.oMf[frame].homogeneous))
        rows = [joint - 1 for joint in moving]
        column = np.argmax(joints.mixing[rows] != 0, axis=1) if rows else np.zeros(0, dtype=int)
        return Chain(
            n=len(joints.names),
            nq=joints.nq,
            rotations=rotations,
            origins=origins,
            sliding=sliding,
            column=column,
            factor=joints.mixing[rows, column],
            shift=joints.offsets[rows],
            place=joints.first[column],
            circling=joints.continuous[column],
            tip=tip,
        )
