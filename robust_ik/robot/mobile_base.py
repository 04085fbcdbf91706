"""Any robot on a base that moves: in the plane, or freely."""

from __future__ import annotations

import reprlib
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from robust_ik.checks.public_arguments import checked
from robust_ik.description.urdf import PARTS, stand_on
from robust_ik.errors import InputError
from robust_ik.robot.joint_map import JointMap
from robust_ik.robot.pinocchio_model import PinocchioModel, build_model
from robust_ik.robot.robot import Robot
from robust_ik.runtime.warn_once import warn_once

Base = Literal["fixed", "planar", "floating"]


@checked
def on_base(robot: Robot, base: Base) -> Robot:
    """The robot on a base that moves, as Pinocchio's `root_joint` makes one; its own joints keep everything.

    The parts of the base are joints of one degree of freedom, in front of the others: `base_x` and `base_y`, m, in the
    axes of the world, and `base_yaw`, rad, about z (planar); or `base_x`, `base_y`, `base_z`, `base_yaw`, `base_pitch`
    and `base_roll` (floating: R = Rz(yaw) Ry(pitch) Rx(roll)). With all at zero the robot stands where it stood. They
    have no limits but that of pitch, which keeps 0.1 rad from ±π/2, where these coordinates are singular.

    Args:
        robot: Any robot, with a tip or whole.
        base: "planar", "floating", or "fixed" for the robot as it is.

    Raises:
        InputError: There is no such base.
        UrdfError: It has too many joints then.
    """
    check_base(base)
    if base == "fixed":
        return robot
    description = stand_on(robot.description, base)
    count = len(PARTS[base])
    own = [joint.name for joint in description.joints[:count]]
    model = build_model(description, {*own, *list(robot.model.names)[1:]})
    names = list(model.names)[1:]
    joints = JointMap.of(description, names)
    limits = joints.limits(description, names)
    # The other joints' limits and rest are not always those of the file: tables and the catalogue have their own.
    kept = [robot.joint_names.index(name) for name in joints.names[count:]]
    lower, upper, velocity = (
        np.append(whole[:count], each[kept])
        for whole, each in zip(limits, (robot.lower, robot.upper, robot.velocity_limit))
    )
    values = np.append(np.zeros(count), robot.joint_values(robot.rest)[kept])
    moved = replace(
        robot,
        description=description,
        lower=lower,
        upper=upper,
        velocity_limit=velocity,
        rest=joints.configuration(values),
        _pinocchio=PinocchioModel(model, joints),
        _joints=joints,
    )
    warn_once(description.source, moved.notes)
    return moved


def check_base(base: str) -> None:
    """Raises unless there is such a base.

    Raises:
        InputError: There is none.
    """
    if not isinstance(base, str) or base not in get_args(Base):
        raise InputError(f"base must be 'fixed', 'planar' or 'floating', got {reprlib.repr(base)}")
