"""Results of `plan_path`: motions, and where and why none goes on. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array


class PathStatus(Enum):
    """How far a path is followed; its value is the explanation."""

    FOLLOWED = "One motion follows the whole path."
    INTERRUPTED = "No motion that was found follows the whole path: see the pieces, and why each one ends."


class Hindrance(Enum):
    """Why no motion goes on; its value is the explanation."""

    OUT_OF_REACH = "No configuration reaches the next poses, or none was found: see what is said."
    BEYOND_LIMITS = "The next poses are reached beyond joint limits alone."
    LIMIT = "The way on of the shortest motion passes a joint limit."
    SINGULAR = "Solutions meet in a singular configuration and end there; the next pose has others."
    FAR = "The next pose has solutions, but none that a continuous motion along the path leads to."


@dataclass(frozen=True, eq=False)
class PathStop:
    """Where a motion ends.

    Attributes:
        at: The place, in numbers of poses: 137.5 is halfway from pose 137 to pose 138, counted from 0.
        until: The place where the path is reached again, or its last one; `at` if it is reached all along.
        hindrance: Why.
        joints: Names of the joints concerned: those at limits, or that would move most.
        said: What was measured, in words.
    """

    at: float
    until: float
    hindrance: Hindrance
    joints: tuple[str, ...]
    said: str

    def __str__(self) -> str:
        until = f" until {self.until:.5g}" if self.until > self.at else ""
        return f"from place {self.at:.5g}{until}: {self.said}"


@dataclass(frozen=True, eq=False)
class PathPiece:
    """A continuous motion along a part of the path.

    Attributes:
        s: Places on the path, increasing, (m,), in numbers of poses.
        q: Configurations there, (m, nq). Between neighbours joints move in proportion, and the frame stays as near the
            path as was asked for.
        values: The same as joint values, with turns, (m, n), rad and m.
        travel: How far joints move in all, rad, with slides over the length scale.
        margin: The least singular value of the Jacobian over the largest one, the least along the piece.
    """

    s: Array
    q: Array
    values: Array
    travel: float
    margin: float

    def __len__(self) -> int:
        return len(self.q)

    def at(self, s: float) -> Array:
        """Joint values at a place, (n,)."""
        return np.array([np.interp(s, self.s, column) for column in self.values.T])

    def __repr__(self) -> str:
        return f"PathPiece(s = {self.s[0]:.5g} to {self.s[-1]:.5g}, {len(self.q)} configurations)"


@dataclass(frozen=True, eq=False)
class PathPlan:
    """A joint motion along a path, or the fewest motions that follow as much of it as was found.

    Attributes:
        status: How far the path is followed.
        pieces: Continuous motions, in order; between two the arm has to change its posture while the tool leaves the
            path.
        stops: Why each piece ends, but for one that ends with the path; and why poses are in no piece.
        poses: The path, (p, 4, 4).
        complete: For each pose whether all its solutions are known, (p,): where not, a motion may have been missed.
    """

    status: PathStatus
    pieces: tuple[PathPiece, ...]
    stops: tuple[PathStop, ...]
    poses: Array
    complete: NDArray[np.bool_]

    @property
    def followed(self) -> bool:
        """Whether one motion follows the whole path."""
        return self.status is PathStatus.FOLLOWED

    @property
    def q(self) -> Array:
        """Configurations of the first piece, (m, nq): of the whole path if it is followed; (0, 0) if there is none."""
        return self.pieces[0].q if self.pieces else np.zeros((0, 0))

    @property
    def s(self) -> Array:
        """Places of `q`, (m,)."""
        return self.pieces[0].s if self.pieces else np.zeros(0)

    @property
    def reasons(self) -> str:
        """What was measured at each stop, in words, one a line."""
        return "\n".join(str(each) for each in self.stops)

    def __repr__(self) -> str:
        if self.followed:
            return f"PathPlan({len(self.poses)} poses followed in one motion of {len(self.q)} configurations)"
        return f"PathPlan({len(self.poses)} poses, {len(self.pieces)} pieces; {self.reasons})"
