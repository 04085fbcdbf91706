"""How a task is written down for compiled code: its record in a controller's program.

A task without such a form takes part all the same: its rows then come from its `equation`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.tasks.task_arguments import indices
from robust_ik.errors import InputError
from robust_ik.kernels.control import control_layout as slots


@dataclass(frozen=True, eq=False)
class CompiledForm:
    """What of a task's record stays as it is while its targets and gains change.

    Attributes:
        height: Number of its rows.
        record: The record; see `kernels.control.control_layout`.
        frame: The frame of which it needs the motion, if any; None for the tip.
        root: A second one, if any.
        framed: Whether it needs the motion of a frame.
    """

    height: int
    record: Array
    frame: str | None = None
    root: str | None = None
    framed: bool = True


@dataclass(frozen=True)
class Numbers:
    """The place of an attribute's numbers in a record.

    Attributes:
        begin: The first place.
        shape: Their shape; None for one number for each row of a task of joints.
        steps: Steps along the axes; default one number after the other.
    """

    begin: int
    shape: tuple[int, ...] | None = ()
    steps: tuple[int, ...] | None = None

    def view(self, record: Array) -> Array:
        """The numbers in a record, as a view."""
        if self.shape is None:
            return record[self.begin :: slots.ENTRY]
        steps = self.steps or (1,) * len(self.shape)
        strides = tuple(step * record.itemsize for step in steps)
        return np.lib.stride_tricks.as_strided(record[self.begin :], self.shape, strides)


POSE_NUMBERS: dict[str, Numbers] = {
    "weight": Numbers(slots.WEIGHT),
    "gain": Numbers(slots.GAIN_OF),
    "max_linear": Numbers(slots.LINEAR),
    "max_angular": Numbers(slots.ANGULAR),
    "feedforward": Numbers(slots.FORWARD, (6,)),
    "target": Numbers(slots.GOAL, (4, 4), (4, 1)),
}
"""Numbers of tasks that bring a frame to a pose."""

JOINT_NUMBERS: dict[str, Numbers] = {
    "weight": Numbers(slots.WEIGHT),
    "gain": Numbers(slots.GAIN_OF),
    "max_speed": Numbers(slots.FASTEST),
    "target": Numbers(slots.ENTRIES + slots.FROM, None),
}
"""Numbers of tasks that bring joints to values."""


def head(kind: int, height: int, length: int) -> Array:
    """The beginning of a record, and room for the rest."""
    record = np.zeros(length)
    record[slots.KIND], record[slots.LONG], record[slots.HEIGHT] = kind, length, height
    record[slots.WEIGHT] = record[slots.GAIN_OF] = 1.0
    return record


def pose_form(
    rows: tuple[str, ...], frame: str | None, root: str | None = None, *, along_target: bool = False
) -> CompiledForm:
    """The form of a task that brings a frame to a pose.

    Args:
        rows: The rows that it controls.
        frame: The frame.
        root: The frame to which the pose is relative, if any.
        along_target: Whether its rows are along the axes of the target.
    """
    record = head(slots.POSE, len(rows), slots.POSED)
    chosen = indices(rows)
    record[slots.CHOSEN : slots.CHOSEN + len(rows)] = chosen
    record[slots.AXES] = slots.TARGET_AXES if along_target else slots.WORLD_AXES
    turning = [row - 3 for row in chosen if row > 2]
    free = [axis for axis in range(3) if axis not in turning]
    record[slots.ROTATION] = (
        slots.NO_ROTATION if not turning else slots.SWING + free[0] if len(free) == 1 else slots.WHOLE_ROTATION
    )
    record[slots.LINEAR] = record[slots.ANGULAR] = math.inf
    record[slots.GOAL : slots.GOAL + 16] = np.eye(4).ravel()
    return CompiledForm(len(rows), record, frame, root)


def joint_form(joints: NDArray[np.intp], source: int) -> CompiledForm:
    """The form of a task of some joints, given by their indices; see `control_layout.SOURCE`."""
    count = len(joints)
    record = head(slots.JOINT_VALUES, count, slots.ENTRIES + slots.ENTRY * count)
    record[slots.SOURCE], record[slots.FASTEST] = source, math.inf
    entries_of(record)[:, slots.JOINT] = joints
    return CompiledForm(count, record, framed=False)


def entries_of(record: Array) -> Array:
    """The rows of the record of a task of joints, (k, 3), as a view."""
    count = int(record[slots.HEIGHT])
    return record[slots.ENTRIES : slots.ENTRIES + slots.ENTRY * count].reshape(count, slots.ENTRY)


def climbing_form(
    rows: tuple[str, ...], frame: str | None, measure: int, index: int, scale: float, n: int
) -> CompiledForm:
    """The form of a task that climbs a measure.

    Args:
        rows: The rows of the measure.
        frame: The frame.
        measure: See `control_layout.MEASURE`.
        index: Which singular value, negative from the last on.
        scale: The factor of angular rows.
        n: Number of joints.

    Raises:
        InputError: There is no such singular value.
    """
    record, count = head(slots.CLIMB, 1, slots.CLIMBING), min(len(rows), n)
    if not -count <= index < count:
        raise InputError(f"index must lie in [{-count}, {count - 1}] for {count} singular values, got {index}")
    record[slots.MEASURE], record[slots.INDEX], record[slots.SCALE] = measure, index % count, scale
    record[slots.COUNT_OF_ROWS] = len(rows)
    record[slots.CHOSEN_ROWS : slots.CHOSEN_ROWS + len(rows)] = indices(rows)
    record[slots.THRESHOLD] = math.inf
    return CompiledForm(1, record, frame)


def twist_form(rows: tuple[str, ...], frame: str | None, *, along_frame: bool) -> CompiledForm:
    """The form of a task that moves a frame with a twist."""
    record = head(slots.TWIST, len(rows), slots.POSED)
    record[slots.CHOSEN : slots.CHOSEN + len(rows)] = indices(rows)
    record[slots.AXES] = slots.FRAME_AXES if along_frame else slots.WORLD_AXES
    return CompiledForm(len(rows), record, frame)


def direction_form(frame: str | None) -> CompiledForm:
    """The form of a task that points an axis along a direction."""
    return CompiledForm(2, head(slots.DIRECTION, 2, slots.DIRECTED), frame)


def given_form(height: int) -> CompiledForm:
    """The form of a task whose rows come from its `equation`."""
    return CompiledForm(height, head(slots.GIVEN, height, slots.PLACE + 1), framed=False)
