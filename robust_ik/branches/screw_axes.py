"""Screw axes of a chain at zero: its pose is exp(A_1 q_1) … exp(A_c q_c) times the pose at zero. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import about_z, joint_motor, line, motor_of, moved, pose_of, slide, unit
from robust_ik.checks import Array
from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kinematics.chain import Chain


@dataclass(frozen=True, eq=False)
class ScrewAxes:
    """The joints that move a frame, in the order of the chain, lengths in units of `scale`.

    Attributes:
        axes: Axis and moment of each joint as dual quaternions, (c, 8).
        slides: Which of them slide, (c,).
        columns: Index of each joint among the robot's, (c,).
        home: Pose of the frame at zero, (4, 4), m.
        scale: The unit of length, m.
    """

    axes: Array
    slides: NDArray[np.bool_]
    columns: NDArray[np.int_]
    home: Array
    scale: float

    @classmethod
    def of(cls, chain: Chain) -> Self | None:
        """The axes; None if a joint follows another one, since then the loop has no joint of its own there."""
        if len(set(chain.column.tolist())) < len(chain) or not len(chain) or not (chain.factor == 1).all():
            return None
        T, frames = np.eye(4), []
        for i in range(len(chain)):
            link = np.eye(4)
            link[:3, :3], link[:3, 3] = chain.rotations[i], chain.origins[i]
            T = T @ link
            frames.append(T)
            T = T @ about_z(float(chain.shift[i]), bool(chain.sliding[i]))
        home = T @ chain.tip
        points = np.array([each[:3, 3] for each in [*frames, home]])
        scale = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) or 1.0
        axes = [
            slide(unit(each[:3, 2])) if slides else line(unit(each[:3, 2]), each[:3, 3] / scale)
            for each, slides in zip(frames, chain.sliding)
        ]
        return cls(np.array(axes), chain.sliding.copy(), chain.column.copy(), home, scale)

    @property
    def point(self) -> Array:
        """The frame's origin at zero, (3,), in units of `scale`."""
        return np.asarray(self.home[:3, 3] / self.scale)

    def motors(self, targets: Array) -> Array:
        """The displacement from the pose at zero to each target, (..., 4, 4) → (..., 8)."""
        inverse = np.eye(4)
        inverse[:3, :3] = self.home[:3, :3].T
        inverse[:3, 3] = -inverse[:3, :3] @ self.home[:3, 3]
        return motor_of(targets @ inverse, self.scale)

    def packed(self, n: int) -> Array:
        """The arm for kernels, see `kernels.branches.branches_layout`; n is the number of the robot's joints."""
        packed = np.zeros(lay.ARM)
        packed[lay.SCALE], packed[lay.COUNT_OF_VALUES] = self.scale, n
        packed[lay.HOME_ROTATION : lay.HOME_ROTATION + 9] = self.home[:3, :3].ravel()
        packed[lay.HOME_POINT : lay.HOME_POINT + 3] = self.home[:3, 3]
        packed[lay.COLUMNS : lay.COLUMNS + len(self.columns)] = self.columns
        return packed

    @property
    def units(self) -> Array:
        """Rad or m per unit of each joint, (c,)."""
        return np.where(self.slides, self.scale, 1.0)

    def locked(self, joint: int, value: float) -> ScrewAxes:
        """The same chain without a joint, which stays at a value, rad or m; its joints are numbered anew."""
        amount = value / self.scale if self.slides[joint] else value
        M = joint_motor(self.axes[joint], amount, bool(self.slides[joint]))
        keep = np.arange(len(self.axes)) != joint
        axes = self.axes.copy()
        axes[joint + 1 :] = moved(M, axes[joint + 1 :])
        pose = pose_of(M, self.scale)
        return ScrewAxes(axes[keep], self.slides[keep], np.arange(keep.sum()), pose @ self.home, self.scale)
