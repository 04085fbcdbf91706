"""Checks arguments of tasks: frames, rows, joints."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_measures, readonly
from robust_ik.errors import FrameNotFoundError, InputError, suggest
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.robot.robot import Robot


def one_vector(name: str, value: ArrayLike, length: int | None) -> Array:
    """A read-only copy of one finite vector.

    Raises:
        InputError: It is not a finite vector, or has another length.
    """
    vector = as_measures(value, name, (length,))
    if vector.ndim != 1 or vector.size == 0:
        raise InputError(f"{name} must be one vector, ({length or 'any'},), got shape {vector.shape}")
    return readonly(vector)


def one_configuration(q: ArrayLike) -> ArrayLike:
    """One configuration, unchanged; the robot checks the rest.

    Raises:
        InputError: There are several, or none.
    """
    if np.ndim(q) != 1:
        raise InputError(f"a task takes one configuration, (nq,), got shape {np.shape(q)}")
    return q


def checked_choice(name: str, value: object, choices: Sequence[str]) -> str:
    """The value, which must be one of the choices.

    Raises:
        InputError: It is none of them.
    """
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} must be {' or '.join(map(repr, choices))}, got {reprlib.repr(value)}")
    return value


def checked_frame(name: str, value: str | None, *, needed: bool = False) -> None:
    """Raises if this cannot be a frame's name; whether a robot has the frame is checked with the equation."""
    if not (isinstance(value, str) or (value is None and not needed)):
        raise InputError(f"{name} must be the name of a link or joint, got {reprlib.repr(value)}")


def checked_selection(rows: Sequence[str] | None, among: tuple[str, ...] = ROWS) -> tuple[str, ...] | None:
    """The rows that a task names, in order; None if it leaves them to the robot."""
    if rows is None:
        return None
    names = checked_rows(rows)
    if not set(names) <= set(among):
        raise InputError(f"rows must be some of {' '.join(among)}, each at most once, got {reprlib.repr(rows)}")
    return names


def task_rows(
    robot: Robot,
    frame: str | None,
    rows: tuple[str, ...] | None,
    *,
    among: tuple[str, ...] = ROWS,
    world_axes: bool = True,
) -> tuple[str, ...]:
    """The rows of a task: those it names, else for the robot's tip the rows of the robot, else all.

    Args:
        robot: The robot.
        frame: The task's frame, None for the tip.
        rows: The rows it names, if any.
        among: The rows that a task of its kind can have.
        world_axes: Whether its rows are along the world's axes, like those of the robot.

    Raises:
        InputError: The rows of the robot do not determine those of the task.
    """
    if rows is not None:
        return rows
    if frame is not None and frame != robot.tip:
        return among
    own = tuple(row for row in robot.rows if row in among)
    if not own or (not world_axes and len(own) < len(among)):
        raise InputError(
            f"{robot.name} has the task rows {' '.join(robot.rows)} in world axes, which do not say what this task is "
            f"to control: give it rows, some of {' '.join(among)}"
        )
    return own


def indices(rows: tuple[str, ...]) -> list[int]:
    """Indices of rows in a twist."""
    return [ROWS.index(row) for row in rows]


def checked_joints(joints: str | Sequence[str] | None) -> tuple[str, ...] | None:
    """Joint names, each at most once; None for all joints.

    Raises:
        InputError: They are not valid names.
    """
    if joints is None:
        return None
    names = (joints,) if isinstance(joints, str) else tuple(joints) if isinstance(joints, (list, tuple)) else ()
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise InputError(f"joints must be names, each at most once, got {reprlib.repr(joints)}")
    return names


def joint_indices(robot: Robot, joints: tuple[str, ...] | None) -> NDArray[np.intp]:
    """Indices of joints in q̇.

    Raises:
        FrameNotFoundError: The robot has no such independent joint.
    """
    if joints is None:
        return np.arange(robot.n)
    names = robot.joint_names
    for name in joints:
        if name not in names:
            driver = robot.description.driver.get(name)
            hint = f"{name!r} follows {driver.source!r}; " if driver and driver.source in names else ""
            hint += robot.description.taken_as(name) + suggest(name, names)
            raise FrameNotFoundError(f"{robot.name} has no independent joint {name!r}; {hint}")
    return np.array([names.index(name) for name in joints], dtype=np.intp)


def lengths(rows: tuple[str, ...]) -> NDArray[np.bool_]:
    """Which of the rows are in metres, (m,)."""
    return np.array([row in ROWS[:3] for row in rows])
