"""A figure of an arm in some configurations, as a skeleton, with the directions that its tool has lost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError, TipError
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.singularities.lost_motion import sparse_basis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BONE, KNUCKLE = "#7f8791", "#455c78"
LOST = ("#1f4fd8", "#d6202c", "#1f9d45", "#8a3fb5", "#c77a12", "#0f9aa8")
"""Colours of lost directions."""
SMALL = 0.05
"""Parts of a direction smaller than this are not drawn."""
ACROSS = 4
"""Arms in a row: at 2.9 inches each they fill the width of an A4 page in landscape, 11.7 inches."""


@checked
def stills_figure(
    robot: Robot, configurations: Mapping[str, ArrayLike], *, tolerance: float = 1e-2, sparse: bool = True
) -> Figure:
    """A figure of an arm in some configurations side by side, with the directions that are lost there.

    Each lost direction has one colour: its translation is a solid double arrow at the tip, its rotation a dotted ring
    about a dotted line; both are smaller for smaller parts.

    Args:
        robot: An arm with a tip.
        configurations: Configurations, (nq,), by name.
        tolerance: σ/σ₁ below which a direction counts as lost.
        sparse: Whether several directions are rotated to the sparse basis; else they are those of the SVD.

    Raises:
        TipError: The robot was loaded whole, without a tip.
        InputError: There is nothing to draw, or a configuration does not fit.
    """
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    if robot.tip is None:
        raise TipError("a robot without a tip has no directions to lose: load it with a tip")
    if not configurations:
        raise InputError("there is nothing to draw: give at least one configuration")
    tolerance = checked_parameter("tolerance", tolerance, above=0, below=1)
    over = min(ACROSS, len(configurations))
    down = -(-len(configurations) // over)
    figure = Figure(figsize=(2.9 * over, 3.4 * down), layout="constrained")
    for index, (label, q) in enumerate(configurations.items()):
        axes: Any = figure.add_subplot(down, over, index + 1, projection="3d")
        q = as_array(q, "configuration", (robot.nq,))
        _draw(axes, robot, q, lost_basis(robot, q, tolerance, sparse=sparse))
        axes.set_title(label, fontsize="medium")
    return figure


def lost_basis(robot: Robot, q: ArrayLike, tolerance: float = 1e-2, *, sparse: bool = True) -> Array:
    """The directions that are lost at a configuration (nq,), as columns of six rows, (6, k)."""
    J = robot.jacobian(q)
    found = svd(J)
    lost = found.U[:, found.s <= tolerance * found.s[0]]
    basis = np.zeros((6, lost.shape[1]))
    basis[[ROWS.index(row) for row in robot.rows]] = lost
    return sparse_basis(basis) if sparse and basis.shape[1] else basis


def _draw(axes: Any, robot: Robot, q: Array, lost: Array) -> None:
    bones, pivots = _bones(robot, q), _axes(robot, q)
    tip = robot.pose(q)[:3, 3]
    corners = np.concatenate([bones.reshape(-1, 3), tip[None]])
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    size = size if size > 0 else 1.0
    for bone in bones:
        axes.plot(*bone.T, color=BONE, linewidth=5, solid_capstyle="round")
    for point, axis in pivots:
        axes.plot(*(point + 0.06 * size * np.outer([-1, 1], axis)).T, color=KNUCKLE, linewidth=2.5)
    axes.plot(*tip[:, None], "o", color="black", markersize=4)
    for twist, color in zip(lost.T, LOST):
        _draw_lost(axes, tip, 0.3 * size * twist[:3], 0.3 * size * twist[3:], color)
    _frame(axes, corners, tip, 0.3 * size)


def _bones(robot: Robot, q: Array) -> Array:
    """Segments from each link's origin to the next one's, and to the tip, (B, 2, 3)."""
    joints = robot.description.joints
    ends = [[robot.pose(q, joint.parent)[:3, 3], robot.pose(q, joint.child)[:3, 3]] for joint in joints]
    return np.array(ends)


def _axes(robot: Robot, q: Array) -> list[tuple[Array, Array]]:
    """Position and unit axis of each joint that turns or slides."""
    found = []
    for index, name in enumerate(robot.joint_names):
        joint = robot.description.joint[name]
        motion = robot.jacobian(q, joint.child, rows=ROWS)[:, index]
        axis = motion[:3] if joint.kind == "prismatic" else motion[3:]
        found.append((robot.pose(q, joint.child)[:3, 3], axis / np.linalg.norm(axis)))
    return found


def _draw_lost(axes: Any, tip: Array, shift: Array, turn: Array, color: str) -> None:
    largest = max(float(np.linalg.norm(shift)), float(np.linalg.norm(turn)))
    if np.linalg.norm(shift) > SMALL * largest:
        for way in (shift, -shift):
            axes.quiver(*tip, *way, color=color, linewidth=1.8, arrow_length_ratio=0.25)
    if np.linalg.norm(turn) > SMALL * largest:
        axes.plot(*(tip + np.outer([-1, 1], turn)).T, ":", color=color, linewidth=1.6)
        axes.plot(*(tip + _ring(0.55 * turn)).T, ":", color=color, linewidth=1.8)


def _ring(turn: Array) -> Array:
    """A circle about a vector, with the vector's length as radius, (N, 3)."""
    across = np.cross(turn, np.eye(3)[np.abs(turn).argmin()])
    across *= np.linalg.norm(turn) / np.linalg.norm(across)
    up = np.cross(turn, across) / np.linalg.norm(turn)
    angle = np.linspace(0, 2 * np.pi, 49)[:, None]
    return np.asarray(np.cos(angle) * across + np.sin(angle) * up)


def _frame(axes: Any, corners: Array, tip: Array, reach: float) -> None:
    """Sets the view so that all is in it, with one scale for all axes."""
    corners = np.concatenate([corners, tip + 1.1 * reach * np.array([[-1.0], [1.0]])])
    low, high = corners.min(axis=0), corners.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.05)
    axes.set_xlabel("x [m]", labelpad=-8, fontsize=7)
    axes.set_ylabel("y [m]", labelpad=-8, fontsize=7)
    axes.set_zlabel("z [m]", labelpad=-8, fontsize=7)
    axes.tick_params(labelsize=6, pad=-3)
    axes.locator_params(nbins=4)
    axes.view_init(elev=18, azim=-58)
