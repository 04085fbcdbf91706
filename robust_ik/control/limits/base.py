"""What every limit is."""

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
    """Something that bounds joint velocities."""

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

        Bounds are of first order; this sees the step itself. A controller resolves anew with what it gives.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            qdot: The joint velocities of the step, (n,).
            dt: Length of the step, s.
            bounds: What q̇ was found in: those of this limit among them.
        """
        return None

    def spare(self, robot: Robot, q: Array, within: float) -> Mapping[Any, float]:  # noqa: ARG002
        """How far q is from what this limit forbids, for plans: m by name, negative for what is forbidden.

        Only of limits that forbid configurations otherwise than by the positions of joints.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            within: m; what is further away is left out.
        """
        return {}


def checked_limits(limits: Sequence[Limit] | Limit) -> tuple[Limit, ...]:
    """One limit or several, as several.

    Raises:
        InputError: They are none.
    """
    given = (limits,) if isinstance(limits, Limit) else limits
    if not isinstance(given, (list, tuple)) or not all(isinstance(each, Limit) for each in given):
        shown = reprlib.repr(limits)
        raise InputError(f"limits must be limits such as JointLimits.of(robot), () for none, got {shown}")
    return tuple(given)
