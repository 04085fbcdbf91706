"""A task that brings a frame to a pose: straight if possible, else round by another path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from robust_ik.control.limits import Limit
from robust_ik.control.reaching.reach_drive import ReachDrive, Told
from robust_ik.control.tasks.frame import FrameTask
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class Reach(FrameTask):
    """Bring a frame to a target pose, also if limits or branches block the straight way.

    It is a `FrameTask` as long as the servo makes progress. If the straight way ends, at joint limits, at an obstacle,
    or in a branch that does not contain the target, the controller stops the arm and looks for a path through joint
    space to one of the target's solutions, within the joint limits, the caps on the tool's speed and the collision
    limits of the controller. It follows the path, and servoes again. For a target out of reach it waits at the closest
    pose.

    Its memory is in the controller: it begins anew with `VelocityController.reset`, and continues if a later step has
    another target at the same place of the stack. Without a controller it is a `FrameTask`.

    While it follows a path, the joints that move its frame are not free for lower levels.

    Attributes:
        target: See `FrameTask`, as for all others. The tool moves no faster than gain · max_linear and
            gain · max_angular, also on a path.

    Example:
        >>> import numpy as np
        >>> import robust_ik as rik
        >>> robot = rik.load("ur5")
        >>> target = robot.pose(robot.configuration([0.5, -2.2, -1.9, -0.9, 1.2, 0.3]))
        >>> reach = rik.Reach(target, gain=5.0, max_linear=0.1, max_angular=0.3)
        >>> controller, q = rik.VelocityController(robot), robot.rest
        >>> for _ in range(2000):
        ...     q = robot.integrate(q, 0.01 * controller.step(q, reach, 0.01).qdot)
        >>> reach.state
        'arrived'
    """

    _told: Told = field(default_factory=Told, init=False, repr=False)

    @property
    def state(self) -> str:
        """What it is doing, at the last step that it was part of.

        "not begun", "servoing", "planning", "going round: elbow (joint3)", "arrived", "out of reach by 12 mm: waiting
        there", "out of reach: waiting" or "no way there is free: waiting".
        """
        return self._told.text

    def tell(self, state: str) -> None:
        """Sets `state`; called at every step by the drive of a run."""
        self._told.text = state

    def begin(self, robot: Robot, limits: Sequence[Limit]) -> ReachDrive | None:
        """See `Task.begin`.

        Raises:
            InputError: More joints move the frame than `Robot.solve_pose` can take.
        """
        if not robot.chain(self.frame).factor.any():
            return None  # no joint moves the frame
        return ReachDrive(robot, limits, self)
