"""The interface of limits."""

from __future__ import annotations

import abc
import reprlib
from collections.abc import Mapping, Sequence
from typing import Any

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.errors import InputError
from robust_ik.robot.robot import Robot


class Limit(abc.ABC):
    """A limit on joint velocities."""

    @abc.abstractmethod
    def bounds(self, robot: Robot, q: Array, previous: Array, dt: float) -> Bounds:
        """Bounds on the velocity of the step from q.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            previous: Joint velocities of the step before, (n,), rad/s or m/s.
            dt: Length of the step, s.
        """

    def tightened(self, robot: Robot, q: Array, qdot: Array, dt: float, bounds: Bounds) -> Bounds | None:  # noqa: ARG002
        """Higher floors, and rows after those that there are, where a step in full would break the limit; else None.

        Bounds are of first order; this method checks the step itself. A controller resolves again with the tighter
        bounds.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            qdot: The joint velocities of the step, (n,).
            dt: Length of the step, s.
            bounds: The bounds within which q̇ was found, including those of this limit.
        """
        return None

    def spare(self, robot: Robot, q: Array, within: float) -> Mapping[Any, float]:  # noqa: ARG002
        """Distances of q from what this limit forbids, for plans: m by name, negative if forbidden.

        Only for limits that forbid configurations otherwise than by joint positions.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            within: Larger distances, m, are left out.
        """
        return {}


def checked_limits(limits: Sequence[Limit] | Limit) -> tuple[Limit, ...]:
    """Limits as a tuple; a single one is a tuple of one.

    Raises:
        InputError: They are not limits.
    """
    given = (limits,) if isinstance(limits, Limit) else limits
    if not isinstance(given, (list, tuple)) or not all(isinstance(each, Limit) for each in given):
        shown = reprlib.repr(limits)
        raise InputError(f"limits must be limits such as JointLimits.of(robot), () for none, got {shown}")
    return tuple(given)
