"""PosePath: poses in a row, with straight ways between them. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kinematics.rotation_vectors import rotation_vector, rotations

HALF_TURN = np.pi - 1e-6
"""Rotations between neighbours from here on have no shortest way, rad."""


@dataclass(frozen=True, eq=False)
class PosePath:
    """Poses that follow each other; between them the point moves on a line and the rotation about a fixed axis.

    A place on it is a number s: pose i is at s = i.

    Attributes:
        poses: (p, 4, 4), at least one.
        length_scale: m per rad where a motion's size is measured.
        turns: Whether rotations matter.
    """

    poses: Array
    length_scale: float
    turns: bool

    def __post_init__(self) -> None:
        if self.turns and (far := np.flatnonzero(np.linalg.norm(self._vectors, axis=-1) > HALF_TURN)).size:
            i = int(far[0])
            raise InputError(
                f"poses {i} and {i + 1} are half a turn apart: which way round is not said; give a pose between them"
            )

    @cached_property
    def _vectors(self) -> Array:
        R = self.poses[:, :3, :3]
        return rotation_vector(np.asarray(R[1:] @ np.swapaxes(R[:-1], -1, -2)))

    def __len__(self) -> int:
        return len(self.poses)

    def at(self, s: Array) -> Array:
        """Poses at places, (m,) → (m, 4, 4)."""
        if len(self.poses) == 1:
            return np.repeat(self.poses, len(s), axis=0)
        i = np.clip(np.floor(s).astype(int), 0, len(self.poses) - 2)
        part = s - i
        T = self.poses[i + (part == 1.0)]
        between = (part > 0.0) & (part < 1.0)
        i, part = i[between], part[between, None]
        T[between, :3, 3] += part * (self.poses[i + 1, :3, 3] - self.poses[i, :3, 3])
        T[between, :3, :3] = rotations(part * self._vectors[i]) @ self.poses[i, :3, :3]
        return np.asarray(T)

    @cached_property
    def steps(self) -> Array:
        """Motions from each pose to the next one, (p − 1,), rad, with lengths over the length scale."""
        moved = np.linalg.norm(np.diff(self.poses[:, :3, 3], axis=0), axis=-1) / self.length_scale
        return np.asarray(np.maximum(moved, np.linalg.norm(self._vectors, axis=-1)) if self.turns else moved)

    def count(self, longest: float) -> int:
        """How many places `places` gives."""
        return int(np.maximum(1, np.ceil(self.steps / longest)).sum()) + 1

    def places(self, longest: float) -> Array:
        """Places of all poses and of as many between them that no step is longer, (m,)."""
        parts = np.maximum(1, np.ceil(self.steps / longest)).astype(int)
        pose = np.repeat(np.arange(len(parts)), parts)
        step = np.arange(len(pose)) - np.repeat(np.cumsum(parts) - parts, parts)
        return np.append(pose + step / parts[pose], len(self.poses) - 1.0)

    def size_of(self, s: Array, steps: Array) -> Array:
        """Motions from places by steps that pass no pose, (m,) and (m,) → (m,), as in `steps`."""
        if len(self.poses) == 1:
            return np.zeros_like(s)
        return np.asarray(steps * self.steps[np.clip(np.floor(s).astype(int), 0, len(self.poses) - 2)])
