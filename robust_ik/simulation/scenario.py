"""Scenario: a motion that can be run with any method, and the methods to compare on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.checks.public_arguments import check_type, checked
from robust_ik.control.limits import Limit, checked_limits
from robust_ik.control.resolvers import Resolver
from robust_ik.control.tasks import Stack, Task, checked_stack
from robust_ik.errors import InputError, suggest
from robust_ik.inverses import RobustInverse
from robust_ik.robot.robot import Robot

Motion = Stack | Task | Callable[[float], Stack | Task]
"""The wanted motion: a constant stack, or a function from time in seconds to one, such as `Follow(path)`."""

Method = Resolver | RobustInverse


@dataclass(frozen=True, eq=False)
class Scenario:
    """Everything that defines a run except the method. `rik.simulate(scenario, inverse)` runs it.

    Attributes:
        name: Its name.
        robot: The robot, with the task rows of the motion.
        q0: Start configuration, (nq,).
        motion: The wanted motion.
        duration: Duration of the run, s.
        dt: Time step, s.
        limits: As for `simulate`: None for the robot's own, () for none.
        title: A sentence that describes it.
        source: Its source, with what the source says.
        note: What was chosen in place of information that the source does not give; empty if nothing was.
        methods: Methods to compare, by label.
    """

    name: str
    robot: Robot
    q0: Array
    motion: Motion
    duration: float
    dt: float = 0.01
    limits: Sequence[Limit] | Limit | None = ()
    title: str = ""
    source: str = ""
    note: str = ""
    methods: Mapping[str, Method] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_type("name", self.name, "str")
        check_type("robot", self.robot, "Robot")
        if not callable(self.motion):
            checked_stack(self.motion)
        for each in (self.title, self.source, self.note):
            check_type("title, source and note", each, "str")
        if self.limits is not None:
            checked_limits(self.limits)
        check_type("methods", self.methods, "Mapping[str, Any]")
        q0: ArrayLike = as_array(self.q0, "q0", (self.robot.nq,))
        object.__setattr__(self, "q0", readonly(q0))
        checked_parameter("duration", self.duration, above=0)
        checked_parameter("dt", self.dt, above=0)
        for label, method in self.methods.items():
            if not isinstance(method, (Resolver, RobustInverse)):
                raise InputError(f"method {label!r} must be an inverse or a resolver, got {method!r}")
        object.__setattr__(self, "methods", MappingProxyType(dict(self.methods)))

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"methods": dict(self.methods)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.__post_init__()

    @checked
    def method(self, label: str) -> Method:
        """The method of that label.

        Raises:
            InputError: There is none; the message lists the labels.
        """
        if label not in self.methods:
            raise InputError(f"{self.name} has no method {label!r}; {suggest(label, self.methods)}")
        return self.methods[label]
