"""The interface of tasks, and how to write your own."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.control.bounds import Bounds
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.robot.robot import Robot

if TYPE_CHECKING:
    from robust_ik.control.limits import Limit
    from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers


@dataclass(frozen=True, eq=False)
class Task(abc.ABC):
    """A task: a linear equation J q̇ = ẋ in the joint velocities of a robot.

    A task of your own is a frozen dataclass with one method:

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

    Rows in metres may be marked in `TaskEquation.lengths`, for robots that are much larger or smaller than a metre.
    The Jacobian is the derivative of the controlled quantity, J = −∂error/∂q for a constant target; a zero row asks for
    nothing.

    Attributes:
        weight: Weight of its rows against the rows of other tasks of the same level, > 0.
    """

    weight: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        self._store(weight=checked_parameter("weight", self.weight, above=0))

    def _store(self, **values: Any) -> None:
        """Stores checked values in place of the given ones, while the task is made."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    structural: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that `form` depends on."""

    def form(self, robot: Robot) -> CompiledForm | None:  # noqa: ARG002
        """How the task is written down for compiled code; None, as for your own tasks, to take rows from `equation`.

        Compiled code takes a form only from the class that defines it, not from one that derives from that class.

        Args:
            robot: The robot.

        Raises:
            FrameNotFoundError: The robot has no frame or joint of that name.
            InputError: The task does not fit the robot.
        """
        return None

    numbers: ClassVar[dict[str, Numbers]] = {}
    """Attributes that may change from step to step, and where compiled code has them in the task's record."""

    def number(self, robot: Robot, name: str) -> Any:  # noqa: ARG002
        """The value of an attribute of `numbers` as compiled code takes it."""
        return getattr(self, name)

    def with_numbers(self, robot: Robot, given: dict[str, Any]) -> Task:  # noqa: ARG002
        """The task with other values of `numbers`, as compiled code has them."""
        return replace(self, **given)

    def begin(self, robot: Robot, limits: Sequence[Limit]) -> Drive | None:  # noqa: ARG002
        """The drive of this task for one run of a controller; None if nothing is remembered, as for most tasks.

        Args:
            robot: The robot.
            limits: The controller's limits.
        """
        return None

    @abc.abstractmethod
    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            hessian: Whether to compute ∂J/∂q too; it stays None for a task that has none.

        Raises:
            FrameNotFoundError: The robot has no frame or joint of that name.
            InputError: The task does not fit the robot.
        """


@dataclass(frozen=True, eq=False)
class Moment:
    """What a controller knows at a step besides the configuration: bounds and previous velocities.

    Attributes:
        bounds: Bounds on q̇.
        previous: The joint velocities of the step before, (n,).
        dt: Length of the step, s.
    """

    bounds: Bounds
    previous: Array
    dt: float


class Drive(abc.ABC):
    """The memory of a task in one run of a controller; later tasks at its place of the stack continue it."""

    @abc.abstractmethod
    def continues(self, task: Task) -> bool:
        """Whether a later task at this place is the same one, perhaps with another target."""

    @abc.abstractmethod
    def equation(self, task: Any, q: Array, moment: Moment, *, hessian: bool) -> TaskEquation:
        """J q̇ = ẋ for the next step, instead of `Task.equation`.

        Args:
            task: The present task.
            q: Configuration, (nq,).
            moment: Bounds and previous velocities.
            hessian: As for `Task.equation`.
        """

    def share(self, q: Array, qdot: Array) -> float:  # noqa: ARG002
        """The share of a step's motion, in [0, 1], that the task allows; by default all of it.

        Args:
            q: Configuration, (nq,).
            qdot: The joint velocities of the step, (n,).
        """
        return 1.0


def checked_equation(task: Task, equation: TaskEquation, robot: Robot) -> TaskEquation:
    """The equation of a task, checked since it may be the user's own.

    Raises:
        InputError: Shapes do not fit, or something is NaN or infinite.
    """
    m, n = len(equation.xdot), robot.n
    arrays = {"J": (equation.J, (m, n)), "xdot": (equation.xdot, (m,)), "error": (equation.error, (m,))}
    if equation.hessian is not None:
        arrays["hessian"] = equation.hessian, (m, n, n)
    for name, (array, shape) in arrays.items():
        if array.shape != shape or not np.isfinite(array).all():
            raise InputError(
                f"{name} of {type(task).__name__} must be finite and of shape {shape}, got shape {array.shape}"
                f"{'' if np.isfinite(array).all() else ' with NaN or infinity'}"
            )
    return equation
