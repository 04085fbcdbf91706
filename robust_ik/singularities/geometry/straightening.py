"""Makes nominal geometry exact: 1.5708 in a file means π/2, and axes that miss each other by 1e-6 m meet. NumPy only.

A rounded number destroys strata: configurations that are singular by symmetry are then only nearly singular.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.chain import axis_frames
from robust_ik.singularities.geometry.coincidence_tolerance import ANGLE, Tolerance
from robust_ik.singularities.geometry.line_arm import STEP, LineArm, made_parallel, transform
from robust_ik.singularities.geometry.screw_chain import ScrewChain, axes_at_zero, largest_rank
from robust_ik.singularities.geometry.sliding_arm import SlidingArm

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

FAITHFUL, CONFIGURATIONS = 30.0, 8
"""Changes add up along an arm: a geometry whose Jacobian differs by more than so many times the largest single change,
at one of so many random configurations, is not the meant one, and nothing but directions is changed.
"""
APART = 1e-9
"""Jacobians that differ by less are of the same geometry, in its unit of length."""
UNCHANGED = 1e-11
"""Turns below this, rad, and lengths in m, are rounding of what was read; they are not reported as changes."""
ROUNDING = 1e-14
"""Turns below this, rad, are rounding of floats; π/2 as 1.57079632679 is more, and is made exact without a word."""
Lines = tuple[Array, Array, Array]
"""With all joints at zero, world: unit vectors along the axes, a point on each, (n, 3), and the tip's point, (3,)."""


def nearby(robot: Robot, given: ScrewChain, chain: ScrewChain) -> tuple[ScrewChain | None, tuple[str, ...]]:
    """The chain without small tilts and offsets that no rounding explains, and each change in words.

    Args:
        robot: The robot.
        given: The chain of the model.
        chain: The same, straightened: what rounding explains is done.

    Returns:
        None if there are none, or the chain would no longer have its rank anywhere.
    """
    meant, changes, _ = straightened(robot, given, Tolerance.of(robot).widened(robot.length_scale))
    if _apart(meant, chain) <= APART or largest_rank(meant) != chain.full_rank:
        return None, ()
    return meant, changes


def straightened(
    robot: Robot, chain: ScrewChain, tolerance: Tolerance | None = None
) -> tuple[ScrewChain, tuple[str, ...], LineArm | SlidingArm | None]:
    """The chain with nearly exact numbers made exact, and each change in words.

    Directions come first. Lengths between the axes that turn follow, and what angles are left: see `LineArm.evened` and
    `SlidingArm`. If that changes anything, the arm is returned by its common normals, too. Of arms in which joints
    follow others, or none turns, only directions are changed.

    Args:
        robot: The robot of the chain.
        chain: The chain of the model.
        tolerance: Largest changes; by default `Tolerance.of` the robot.
    """
    most = Tolerance.of(robot) if tolerance is None else tolerance
    lines, changes, turned = _with_exact_directions(robot, chain, most.angle)
    straight = _chain_of(chain, *lines) if turned else chain
    if all(chain.sliding) or not np.array_equal(chain.mixing, np.eye(chain.n)):
        return straight, changes, None
    if not turned:
        lines = (*axes_at_zero(chain.rotations, chain.offsets), robot.pose(robot.neutral)[:3, 3])
    even, more = _evened(robot, chain, lines, most)
    found = _chain_of(chain, *_lines_of(even))
    coarse = bool(changes) and most.angle > ANGLE
    if not (more or coarse) or _apart(found, straight) > FAITHFUL * (most.angle + most.short / chain.length_scale):
        return straight, changes, None
    return found, (*changes, *more), even


def _with_exact_directions(robot: Robot, chain: ScrewChain, tolerance: float) -> tuple[Lines, tuple[str, ...], bool]:
    """The lines of an arm whose frames are turned to nominal angles, link by link, each turn in words, if it is told.

    The last value tells whether any frame was turned at all: by more than the rounding of floats.
    """
    joints = [joint for joint in robot.description.chain(str(robot.tip)) if joint.kind != "fixed"]
    rotation, origin = np.eye(3), np.zeros(3)
    before = np.eye(4)
    axes, points, changes, most = [], [], [], 0.0
    frames = [robot.pose(robot.neutral, joint.child) for joint in joints]
    for joint, frame, axis in zip(joints, frames, axes_at_zero(chain.rotations, chain.offsets)[0]):
        step = np.linalg.inv(before) @ frame
        exact, change = nearest_exact(step[:3, :3], tolerance)
        own, tilt = nearest_direction(frame[:3, :3].T @ axis, tolerance)
        most = max(most, change, tilt)
        if max(change, tilt) > UNCHANGED:
            changes.append(f"{joint.name}: turned by {max(change, tilt):.2g} rad")
        origin = origin + rotation @ step[:3, 3]
        rotation = rotation @ exact
        axes.append(rotation @ own)
        points.append(origin)
        before = frame
    tip = origin + rotation @ (np.linalg.inv(before) @ robot.pose(robot.neutral)[:, 3])[:3]
    return (np.array(axes), np.array(points), tip), tuple(changes), most > ROUNDING


def _evened(robot: Robot, chain: ScrewChain, lines: Lines, most: Tolerance) -> tuple[LineArm | SlidingArm, list[str]]:
    """The arm with meant coincidences of its lines made exact, and each change in words."""
    names = chain.joint_names
    axes, points, tip, turns = made_parallel(*lines, most.angle, chain.sliding)
    arm: LineArm | SlidingArm
    if any(chain.sliding):
        arm, moved = SlidingArm.of(axes, points, tip, chain.sliding, most).evened(most)
    else:
        arm, moved = LineArm.of(axes, points, tip, most.short).evened(most)
    changes = [
        f"{name}: lengths changed by {length:.2g} m"
        for name, (length, _) in zip(names[1:], moved)
        if length > UNCHANGED * robot.length_scale
    ]
    changes += [
        f"{name}: turned by {max(angle, turn):.2g} rad"
        for name, (_, angle), turn in zip(names[1:], moved, turns)
        if max(angle, turn) > UNCHANGED
    ]
    return arm, changes


def _lines_of(arm: LineArm | SlidingArm) -> Lines:
    """The lines of an arm with all joints at zero."""
    if isinstance(arm, LineArm):
        placed = arm.frames
        return placed[:, :3, 2], placed[:, :3, 3], placed[-1, :3, :3] @ arm.tip + placed[-1, :3, 3]
    frames = np.stack(list(accumulate((transform(each) for each in arm.moves), np.matmul)))
    return frames[:-1, :3, 2], frames[:-1, :3, 3], frames[-1, :3, 3]


def _apart(one: ScrewChain, other: ScrewChain) -> float:
    """The largest difference of the Jacobians of two chains, in their unit of length, at a few configurations."""
    values = one.random(np.random.default_rng(0), CONFIGURATIONS)
    return float(np.abs(one.jacobian(values) - other.jacobian(values)).max())


def _chain_of(chain: ScrewChain, axes: Array, points: Array, tip: Array) -> ScrewChain:
    """The chain with other axes, (n, 3), through these points, (n, 3), and the tip's point there, (3,)."""
    pose = np.eye(4)
    pose[:3, 3] = tip
    rotations, offsets, last = axis_frames(axes, points, pose)
    return replace(chain, rotations=rotations, offsets=offsets, tip=last[:3, 3])


def nearest_exact(R: Array, tolerance: float) -> tuple[Array, float]:
    """The rotation with nearly exact roll, pitch and yaw replaced by multiples of π/12, and the change in rad."""
    whole = np.round(R)
    if np.abs(R - whole).max() < tolerance and np.isclose(np.linalg.det(whole), 1.0):
        exact = whole
    else:
        pitch = float(np.arcsin(np.clip(-R[2, 0], -1.0, 1.0)))
        angles = np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])
        snapped = np.round(angles / STEP) * STEP
        exact = _from_rpy(np.where(np.abs(angles - snapped) < tolerance, snapped, angles))
        if np.abs(exact - R).max() > 2 * tolerance:
            return R, 0.0
    return exact, float(np.linalg.norm(exact - R) / np.sqrt(2))


def _from_rpy(angles: Array) -> Array:
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(yaw @ pitch @ roll)


def nearest_direction(axis: Array, tolerance: float) -> tuple[Array, float]:
    """The coordinate axis that a unit vector nearly equals, else the vector itself, and the change in rad."""
    whole = np.round(axis)
    change = float(np.linalg.norm(axis - whole))
    return (whole, change) if change < tolerance and np.linalg.norm(whole) == 1.0 else (axis, 0.0)
