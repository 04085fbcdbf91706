"""Pinocchio, wrapped once: builds models, and reads off them what moves each frame.

The only place that imports Pinocchio.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from robust_ik.description.joint_tree import Description
from robust_ik.description.notes import named
from robust_ik.description.urdf.urdf_reader import fix_joints
from robust_ik.errors import TipError, UrdfError, listed
from robust_ik.kinematics.chain import Chain, axis_frames
from robust_ik.robot.joint_map import JointMap

MAX_JOINTS = 200
"""Pinocchio's working memory grows with n³: 0.5 GB at 200 joints."""


def joints_to_keep(description: Description, tip: str | None) -> set[str]:
    """The joints that stay: those that move the tip (all for a whole tree), mimics with their sources.

    Raises:
        UrdfError: One of them cannot move as it is written, or moves freely.
        TipError: There is none.
    """
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


class Kinematics:
    """A model and the chains to its frames.

    Attributes:
        model: The Pinocchio model.
        frames: Frame name → index; where a link and a joint share a name, the link's frame is meant.
    """

    def __init__(self, model: pin.Model) -> None:
        self.model = model
        frames = sorted(enumerate(model.frames), key=lambda pair: pair[1].type == pin.FrameType.BODY)
        self.frames: dict[str, int] = {frame.name: index for index, frame in frames}
        self._chains: dict[int, Chain] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return Kinematics, (self.model,)

    def chain(self, frame: int, joints: JointMap) -> Chain:
        """What moves a frame, as constants.

        Args:
            frame: Its index.
            joints: How the joints follow the independent ones; always the same.
        """
        if frame not in self._chains:
            self._chains[frame] = self._chain(frame, joints)
        return self._chains[frame]

    def _chain(self, frame: int, joints: JointMap) -> Chain:
        model, data = self.model, self.model.createData()
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
