"""Tells for a configuration and a commanded motion whether, and how, the arm can follow it from there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, readonly
from robust_ik.inverses.second_order import Exit, exit_verdict, weak_rows
from robust_ik.kinematics.svd import whole_svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot_kinematics import RobotKinematics

VANISHED = 1e-6
"""σ₁ of some rows below this fraction of σ₁ of all six counts as if it had vanished."""
LOST = 1e-9
"""Share of a command that counts as lost: what rounding leaves."""
SINGULAR = 0.01
"""σ/σ₁ up to which a direction counts as lost. Chosen: there a default controller begins to slow down."""
STEP, FURTHEST = 0.02, float(np.pi)
"""A self-motion is followed in steps of so much of its fastest joint, to so far on either side, rad."""
SERVED = 0.5
"""A turn has gone far enough where so much of the command can be followed."""
USABLE = 0.02
"""σ/σ₁ from which a direction can be used: below, joint speeds are fifty times those of the best direction."""


@runtime_checkable
class Families(Protocol):
    """An atlas of singular configurations, of the tip in the robot's rows."""

    def said_of(self, q: ArrayLike) -> str:
        """What it says of the family nearest to q, one clause."""
        ...


@dataclass(frozen=True, eq=False)
class WayOut:
    """Whether and how a commanded motion can be followed.

    Attributes:
        exit: What it is; its value is a sentence.
        lost: The direction of the command that is lost, (m,), of length 1 in rows divided by the length scale; zero if
            none is.
        share: Its share of the command, 0 to 1, by the same measure.
        motion: The joint motion that follows the command, or that turns first, (n,), rad or m: of length 1 with slides
            divided by the length scale.
        curvature: By how much the tool moves along what is lost: κ s²/2 for s of `motion`, in units of `lost` per rad².
        turn: How far the fastest joint must turn along `motion` until half of what is lost can be followed, rad, slides
            divided by the length scale; infinite if half a turn to either side was tried and is too little, else 0.
        joint_names: Of the n joints.
        family: What an atlas says of the nearest family, if one was given: found by another way, and not used here.
    """

    exit: Exit
    lost: Array
    share: float
    motion: Array
    curvature: float
    turn: float
    joint_names: tuple[str, ...]
    family: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "lost", readonly(self.lost))
        object.__setattr__(self, "motion", readonly(self.motion))

    @property
    def text(self) -> str:
        """The verdict with its numbers, one sentence, and another one of the atlas."""
        beside = f" Of the nearest family the atlas says: {self.family}." if self.family else ""
        return f"{self._said}.{beside}"

    @property
    def _said(self) -> str:
        if self.exit is Exit.FREE:
            return str(self.exit.value)
        said = f"{self.share:.0%} of the command is lost: {self.exit.value}"
        if self.motion.any():
            said += f"; {self._joints()}"
        if self.exit is Exit.TURN_FIRST:
            said += f", by {self.turn:.2g} rad of the fastest joint until half of what is lost can be followed"
        return said

    def __str__(self) -> str:
        return self.text

    def _joints(self) -> str:
        order = np.argsort(-np.abs(self.motion), kind="stable")
        shown = [j for j in order if abs(self.motion[j]) > 0.1 * np.abs(self.motion).max()]
        parts = [f"{self.motion[j] / np.abs(self.motion).max():+.2f} {self.joint_names[j]}" for j in sorted(shown)]
        return "joints move as " + " ".join(parts)


def way_out(
    robot: RobotKinematics, q: Array, twist: Array, frame: str | None, rows: tuple[str, ...], threshold: float
) -> WayOut:
    """The way out of q for a command; arguments are checked already.

    Args:
        robot: The robot.
        q: Configuration, (nq,).
        twist: The command in the rows, (m,).
        frame: As for `Robot.jacobian`.
        rows: Task rows.
        threshold: σ/σ₁ up to which a direction counts as lost.
    """
    looked = _Looked(robot, frame, rows, threshold)
    command = looked.weights * twist
    largest = float(np.abs(command).max())
    if largest == 0:
        return looked.nothing(Exit.FREE)
    command = command / largest / np.linalg.norm(command / largest)
    J, least = looked.jacobian(q), looked.least(q)
    if least == 0:  # no joint moves the frame
        return looked.nothing(Exit.STRUCTURAL, command)
    weak = weak_rows(J, command, looked.hessian(q), threshold, least=least, faded=False)
    beside = command - weak.span @ (weak.span.T @ command)  # an arm of fewer joints than rows never moves that way
    lost = weak.directions @ weak.command * weak.largest
    size, never = float(np.linalg.norm(lost)), float(np.linalg.norm(beside))
    if size <= LOST:
        return looked.nothing(Exit.FREE) if never <= LOST else looked.nothing(Exit.STRUCTURAL, beside)
    found = exit_verdict(weak)
    kind, side, turn = found.exit, 1.0, 0.0
    if kind is Exit.TURN_FIRST:
        side, turn = looked.turned(q, lost / size, found.motion)
        kind, side = (kind, side) if np.isfinite(turn) else (Exit.STRUCTURAL, 0.0)
    bent = {Exit.FOLD: found.curvature, Exit.BOTH_WAYS: found.curvature, Exit.END_OF_REACH: found.opposite}
    curvature, share = bent.get(kind, 0.0) * weak.largest, min(1.0, float(np.hypot(size, never)))
    motion = side * looked.units * found.motion
    return WayOut(kind, lost / size, share, motion, curvature, turn, robot.joint_names)


@dataclass(frozen=True, eq=False)
class _Looked:
    """A robot, as the way out looks at it: rows in metres, and joints that slide, are divided by its length scale."""

    robot: RobotKinematics
    frame: str | None
    rows: tuple[str, ...]
    threshold: float

    @property
    def weights(self) -> Array:
        return self._weights(self.rows)

    @property
    def units(self) -> Array:
        return np.where(self.robot.sliding, self.robot.length_scale, 1.0)

    def _weights(self, rows: tuple[str, ...]) -> Array:
        return np.array([1 / self.robot.length_scale if row in ("x", "y", "z") else 1.0 for row in rows])

    def jacobian(self, q: Array, rows: tuple[str, ...] | None = None) -> Array:
        rows = rows or self.rows
        return self._weights(rows)[:, None] * self.robot.jacobian(q, self.frame, rows=rows) * self.units

    def hessian(self, q: Array) -> Array:
        units = self.units[:, None] * self.units
        return self.weights[:, None, None] * self.robot.hessian(q, self.frame, rows=self.rows) * units

    def least(self, q: Array) -> float:
        """What σ of some rows is compared with if all of them vanish together."""
        return VANISHED * float(whole_svd(self.jacobian(q, ROWS)).s[0])

    def nothing(self, kind: Exit, lost: Array | None = None) -> WayOut:
        share = 0.0 if lost is None else float(np.linalg.norm(lost))
        along = np.zeros(len(self.rows)) if lost is None else lost / share
        return WayOut(kind, along, min(1.0, share), np.zeros(self.robot.n), 0.0, 0.0, self.robot.joint_names)

    def turned(self, q: Array, lost: Array, motion: Array) -> tuple[float, float]:
        """To which side a turn is shorter, ±1, and how far it must go, rad; infinite if none goes far enough."""
        forth, back = (self._angle(q, lost, side * motion) for side in (1.0, -1.0))
        return (1.0, forth) if forth <= back else (-1.0, back)

    def _angle(self, q: Array, lost: Array, motion: Array) -> float:
        for step in range(1, int(FURTHEST / STEP) + 1):
            q = self.robot.integrate(q, STEP / np.abs(motion).max() * self.units * motion)
            found = whole_svd(self.jacobian(q))
            s = found.s / max(float(found.s[0]), self.least(q))
            if np.linalg.norm(found.U[:, : len(s)][:, s >= USABLE].T @ lost) >= SERVED:
                return step * STEP
            kernel = found.Vt[int(np.sum(s > self.threshold)) :]
            along = kernel.T @ (kernel @ motion)
            if np.linalg.norm(along) < SERVED:
                return float(np.inf)  # the self-motion ends here
            motion = along / np.linalg.norm(along)
        return float(np.inf)
