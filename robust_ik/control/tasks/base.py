"""What every task is, and how to write one's own."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.control.bounds import Bounds
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.robot.robot import Robot

if TYPE_CHECKING:
    from robust_ik.control.limits import Limit


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

    def begin(self, robot: Robot, limits: Sequence[Limit]) -> Drive | None:  # noqa: ARG002
        """What drives this task in one run of a controller; None, as of most tasks, where nothing is remembered.

        Args:
            robot: The robot.
            limits: What the controller respects.
        """
        return None

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


@dataclass(frozen=True, eq=False)
class Moment:
    """What a controller knows at a step besides the configuration.

    Attributes:
        bounds: What q̇ must respect.
        previous: The joint velocities of the step before, (n,).
        dt: Length of the step, s.
    """

    bounds: Bounds
    previous: Array
    dt: float


class Drive(abc.ABC):
    """A task that remembers, in one run of a controller. Tasks that stand in its place later on go on with it."""

    @abc.abstractmethod
    def continues(self, task: Task) -> bool:
        """Whether a task that stands in the place now is this one, with another target perhaps."""

    @abc.abstractmethod
    def equation(self, task: Any, q: Array, moment: Moment, *, hessian: bool) -> TaskEquation:
        """J q̇ = ẋ of the next step, in the place of `Task.equation`.

        Args:
            task: The task as it is now.
            q: Configuration, (nq,).
            moment: What else is known.
            hessian: As for `Task.equation`.
        """

    def share(self, q: Array, qdot: Array) -> float:  # noqa: ARG002
        """The share of a step's motion, in [0, 1], that the task allows; by default all of it.

        Args:
            q: Configuration, (nq,).
            qdot: The joint velocities of the step, (n,).
        """
        return 1.0
