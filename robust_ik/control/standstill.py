"""Explains why an arm stands still although its task asks for motion, and how it could go on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, readonly
from robust_ik.checks.public_arguments import checked
from robust_ik.control.tasks import FrameTask, PositionTask, Stack, Task, checked_stack
from robust_ik.control.velocity_controller import VelocityController
from robust_ik.errors import InputError, listed
from robust_ik.kinematics.svd import RANK_TOLERANCE, full_svd, svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.pose_ik import PoseResult

LOST = 0.05
"""A direction is lost if, without the held motions, its σ is below this fraction of σ₁."""

HELD = 1e-3
"""A joint closer to an end than this, rad or m, is held by it if it is asked to go on."""


@dataclass(frozen=True, eq=False)
class Standstill:
    """What holds an arm, and how it could go on; `print` shows it in words.

    Attributes:
        held: The limits that hold it: "panda_joint4 position", "hand - table distance".
        sigma: Singular values of the first level's Jacobian, (k,), descending.
        saturated: Singular values without the motions that the limits hold, (k',).
        lost: The lost task direction (σ ≤ LOST σ₁ without the held motions) along which most is asked, (m,), a unit
            vector along the axes of the task's rows; None if there is none.
        asked: The part of ẋ along it, as a fraction in [0, 1].
        rows: Names of the task rows, m strings.
        reachable: Whether `solve_pose` reaches the target within joint limits; None if the first level is not a single
            FrameTask or PositionTask.
        nearest: Its result: a configuration at the target, or at the nearest pose; None as above.
    """

    held: tuple[str, ...]
    sigma: Array
    saturated: Array
    lost: Array | None
    asked: float
    rows: tuple[str, ...]
    reachable: bool | None
    nearest: PoseResult | None

    def __str__(self) -> str:
        return " ".join([self._holding(), self._losing(), self._way_on()]).strip()

    def _holding(self) -> str:
        return f"Held by {listed(self.held, 6)}." if self.held else "No limit holds it."

    def _losing(self) -> str:
        if self.lost is None:
            return ""
        largest = np.argsort(-np.abs(self.lost))[:3]
        words = ", ".join(f"{self.rows[i]} {self.lost[i]:+.2f}" for i in largest if abs(self.lost[i]) > LOST)
        what = "the other joints" if self.held else "the joints"
        return f"There {what} can hardly move the tool along ({words}): {self.asked:.0%} of the wish."

    def _way_on(self) -> str:
        if self.nearest is None:
            return ""
        if self.reachable:
            return "The target can be reached, from another side: `nearest.q` is there, and `Reach` leads to it."
        position, rotation = self.nearest.error
        return f"The target is out of reach by {1e3 * position:.3g} mm and {rotation:.3g} rad: `nearest.q` is nearest."


@checked
def why_stuck(controller: VelocityController, q: ArrayLike, stack: Stack | Task) -> Standstill:
    """Explains why a controller's arm stands still at q, or nearly so, and how it could go on.

    Args:
        controller: The controller; it is not changed.
        q: Configuration, (nq,).
        stack: The stack of tasks.

    Raises:
        InputError: Arguments are not valid.
        FrameNotFoundError: A task names a frame that the robot does not have.

    Example:
        >>> step = controller.step(q, stack, 0.01)
        >>> if step.status is rik.Status.STUCK:
        ...     print(rik.why_stuck(controller, q, stack))
    """
    if not isinstance(controller, VelocityController):
        raise InputError(f"controller must be a VelocityController, got {controller!r}")
    robot = controller.robot
    q = as_array(q, "q", (robot.nq,))
    if q.ndim != 1:
        raise InputError(f"q must be one configuration of shape ({robot.nq},), got {q.shape}")
    level = checked_stack(stack)[0]
    first = level[0].equation(robot, q)
    wish = np.asarray(np.linalg.lstsq(first.J, first.xdot, rcond=RANK_TOLERANCE)[0], dtype=float)
    held, rows = _holding(controller, q, wish)
    lost, asked, saturated = _lost(first.J, first.xdot, rows)
    nearest = _nearest(controller, q, level[0]) if len(level) == 1 else None
    return Standstill(
        held=held,
        sigma=readonly(svd(first.J).s),
        saturated=readonly(saturated),
        lost=None if lost is None else readonly(lost),
        asked=asked,
        rows=_names(level[0], robot.rows, len(first.xdot)),
        reachable=None if nearest is None else nearest.solved,
        nearest=nearest,
    )


def _holding(controller: VelocityController, q: Array, wish: Array) -> tuple[tuple[str, ...], Array]:
    """Names of the limits that stop the wished motion, and the joint motions that they hold, (r, n)."""
    robot = controller.robot
    names: list[str] = []
    rows: list[Array] = [np.zeros((0, robot.n))]
    for limit in controller.limits:
        bounds = limit.bounds(robot, q, np.zeros(robot.n), 1.0)
        ahead = np.where(wish > 0, bounds.upper, -bounds.lower)
        causes = np.where(wish > 0, bounds.upper_cause, bounds.lower_cause)
        stopped = (ahead < HELD) & (np.abs(wish) > 0)
        names += [str(each) for each in causes[stopped]]
        rows.append(np.eye(robot.n)[stopped])
        near = (bounds.floor > -HELD) & (bounds.rows @ wish < 0)
        names += [cause for cause, there in zip(bounds.row_cause, near) if there]
        rows.append(bounds.rows[near])
    return tuple(dict.fromkeys(names)), np.concatenate(rows)


def _lost(J: Array, xdot: Array, rows: Array) -> tuple[Array | None, float, Array]:
    """The lost direction along which most is asked, its part of the wish, and σ without the held motions."""
    free = np.eye(J.shape[1])
    if len(rows):
        found = full_svd(rows)
        free = found.Vt[int(np.count_nonzero(found.s > RANK_TOLERANCE * found.s[0])) :].T
    size, largest = float(np.linalg.norm(xdot)), float(svd(J).s[0])
    U, s = np.eye(len(J)), np.zeros(0)
    if free.shape[1]:
        turned = full_svd((J @ free).T)  # transposed, so that it has all task directions
        U, s = turned.Vt.T, turned.s
    weak = np.r_[s, np.zeros(len(J) - len(s))] <= LOST * largest
    if not weak.any() or size == 0.0:
        return None, 0.0, s
    inside = U[:, weak] @ (U[:, weak].T @ xdot)
    part = float(np.linalg.norm(inside))
    return (inside / part if part > 0 else U[:, weak][:, 0]), part / size, s


def _nearest(controller: VelocityController, q: Array, task: Task) -> PoseResult | None:
    """The result of `solve_pose` for the task's target, from q."""
    if not isinstance(task, FrameTask | PositionTask):
        return None
    return controller.robot.solve_pose(task.target, q, frame=task.frame, effort="thorough")


def _names(task: Task, own: tuple[str, ...], count: int) -> tuple[str, ...]:
    """Names of a task's rows."""
    told = getattr(task, "rows", None) or own
    if len(told) == count:
        return tuple(told)
    return ROWS if count == len(ROWS) else tuple(str(i) for i in range(1, count + 1))
