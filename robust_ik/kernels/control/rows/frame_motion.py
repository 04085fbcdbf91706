"""Where the frames of a controller's tasks are, and how joints move them."""

from __future__ import annotations

import math

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX, TWELVE, place
from robust_ik.kernels.chain.joint_motion import LOCAL_WORLD_ALIGNED, joint_twists
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.step.step_task import CIRCLE

END = 12
"""Numbers of a frame's pose: rotation, row by row, and origin; its Jacobian follows, then the twists of its joints."""


@called
def map_of(program: Pointer, joint: int) -> Pointer:
    """What is known of a joint."""
    return further(program, int(program[slots.MAP]) + joint * slots.MAPPED)


LARGEST = 1e100
"""As `checks.LARGEST_PARAMETER`."""


@called
def is_measured(value: float) -> bool:
    """Whether a number is finite, and its square does not overflow."""
    return abs(value) <= LARGEST


@called
def check_configuration(program: Pointer, q: Pointer) -> int:
    """DONE if q is finite and every cosine and sine is of length 1; else the status."""
    for i in range(int(program[slots.CONFIGURATION])):
        if not is_measured(q[i]):
            return slots.NOT_FINITE
    for i in range(int(program[slots.JOINTS])):
        joint = map_of(program, i)
        if joint[slots.TURNS] > 0.0:
            c, s = q[int(joint[slots.FIRST])], q[int(joint[slots.FIRST]) + 1]
            if abs(c * c + s * s - 1.0) > CIRCLE:
                return slots.OFF_CIRCLE
    return slots.DONE


@called
def value_of(program: Pointer, q: Pointer, index: int) -> float:
    """The value of a joint, an angle in (−π, π] if q holds its cosine and sine."""
    joint = map_of(program, index)
    first = int(joint[slots.FIRST])
    return math.atan2(q[first + 1], q[first]) if joint[slots.TURNS] > 0.0 else q[first]


@called
def frame_place(program: Pointer, desk: Pointer, index: int) -> Pointer:
    """A frame's pose on the desk; its Jacobian is END further."""
    return further(desk, int(program[int(program[slots.FRAME]) + 2 * index + 1]))


@called
def move_frames(program: Pointer, desk: Pointer, q: Pointer) -> None:
    """Fills in pose, Jacobian and joint twists of every frame, world axes at the frame's point."""
    n = int(program[slots.JOINTS])
    axes, end = stack(0.0, MOST_JOINTS, SIX), stack(0.0, ONE, TWELVE)
    for index in range(int(program[slots.FRAMES])):
        chain = further(program, int(program[int(program[slots.FRAME]) + 2 * index]))
        pose = frame_place(program, desk, index)
        J = further(pose, END)
        twists, joints = further(J, 6 * n), int(chain[links.JOINTS])
        place(chain, q, 1, axes, end, 0.0)
        joint_twists(chain, axes, end, axes, LOCAL_WORLD_ALIGNED, 0.0)
        for i in range(END):
            pose[i] = end[i]
        for i in range(6 * n):
            J[i] = 0.0
        for i in range(joints):
            at = links.HEAD + i * links.STRIDE
            column, factor = int(chain[at + links.COLUMN]), chain[at + links.FACTOR]
            for r in range(6):
                twists[6 * i + r] = axes[6 * i + r]
                J[r * n + column] += factor * axes[6 * i + r]
