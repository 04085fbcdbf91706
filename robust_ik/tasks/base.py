"""What every task is, and how to write one's own."""

from __future__ import annotations

import abc
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import ArrayLike

from robust_ik.checks import checked_parameter
from robust_ik.problem import TaskEquation
from robust_ik.robot import Robot


@dataclass(frozen=True, eq=False)
class Task(abc.ABC):
    """Something wanted of a robot, as a linear equation J q̇ = ẋ in its joint velocities.

    A task of one's own is a frozen dataclass with one method:

    ```python
    @dataclass(frozen=True, eq=False)
    class HeightTask(Task):
        height: float
        gain: float = 1.0

        def equation(self, robot, q, *, hessian=False):
            error = np.array([self.height - robot.pose(q)[2, 3]])
            H = robot.hessian(q, rows=("z",)) if hessian else None
            return TaskEquation(robot.jacobian(q, rows=("z",)), self.gain * error, error, H, self.weight)
    ```

    Rows in metres may be named in `TaskEquation.lengths`, for robots that are much larger or smaller than one.
    Its Jacobian is the derivative of what is controlled, J = −∂error/∂q for a constant target; a row that is zero asks
    for nothing.

    Attributes:
        weight: Weight of its rows against those of other tasks of the same level, > 0.
    """

    weight: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        self._store(weight=checked_parameter("weight", self.weight, above=0))

    def _store(self, **values: Any) -> None:
        """Puts checked values in the place of what was given, while the task is made."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @abc.abstractmethod
    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            hessian: Whether ∂J/∂q is wanted too; a task that has none leaves it None.

        Raises:
            FrameNotFoundError: The robot has no frame or joint of that name.
            InputError: The task does not fit the robot.
        """
