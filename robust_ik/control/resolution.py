"""The result of a resolver: joint velocities, what each level got, and which limits acted. Arrays only."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import listed

SLOWED = 0.1
"""A level that gets a smaller share of its motion than this is held by limits."""


class Status(enum.Enum):
    """Status of a step; the value is the explanation."""

    TRACKING = "The first level is met, and no limit slows any level."
    SCALED = "A level gets less than it asks for."
    STUCK = "The first level asks for motion and gets almost none."
    INFEASIBLE = "Limits contradict each other; the weaker ones yielded."


@dataclass(frozen=True, eq=False)
class LevelResult:
    """The result of one level.

    Attributes:
        scale: The share of its motion that limits allow, in [0, 1].
        residual: ẋ − J q̇, (m,), in the units of the task.
        sigma: Singular values of J in the freedom left by higher levels, (k,), descending, k = min(m, freedom left).
        corank: How many of these are zero.
        kinematic_corank: How many singular values of J itself are zero.
        algorithmic: Whether an algorithmic singularity is near: J is well conditioned, J in the freedom left is not.
    """

    scale: float
    residual: Array
    sigma: Array
    corank: int
    kinematic_corank: int
    algorithmic: bool

    @property
    def manipulability(self) -> float:
        """Π σ of the level in the freedom left by higher levels; 1 if nothing is left."""
        return float(np.prod(self.sigma))


@dataclass(frozen=True, eq=False)
class Resolution:
    """Joint velocities, and how far they meet the tasks.

    Attributes:
        qdot: Joint velocities, (n,), rad/s or m/s.
        levels: The result of each level, the most important first.
        active: Limits that q̇ lies on: "joint4 velocity", "link2 - table distance".
        contradictions: Limits that yielded to stronger ones.
        status: Status of the step.
        calmed: The share of their velocities for which all tasks were asked, in (0, 1]: less than 1 after joints have
            turned to and fro.
    """

    qdot: Array
    levels: tuple[LevelResult, ...]
    active: tuple[str, ...]
    contradictions: tuple[str, ...]
    status: Status
    calmed: float = field(default_factory=lambda: 1.0)  # as a class attribute it would hide a lazy one

    @property
    def scale(self) -> Array:
        """The share of its motion that limits allow each level, (levels,)."""
        return np.array([level.scale for level in self.levels])

    @property
    def residual(self) -> Array:
        """ẋ − J q̇ of the first level, (m,)."""
        return self.levels[0].residual

    @property
    def text(self) -> str:
        """The step in words: what the status means, which limits acted, what to do."""
        return " ".join([f"{self.status.name.lower()}: {self.status.value}", *self._facts(), self._advice()]).strip()

    def _facts(self) -> Iterator[str]:
        if self.contradictions:
            yield f"Yielded: {listed(self.contradictions, 6)}."
        slowed = [f"level {i} gets {level.scale:.0%}" for i, level in enumerate(self.levels, 1) if level.scale < 1]
        if slowed:
            yield f"Limits: {', '.join(slowed)}; q̇ lies on {listed(self.active, 6)}."
        if self.calmed < 1:
            yield (
                f"Joints turned to and fro: all levels ask for {self.calmed:.3g} of their speed until the arm is "
                "elsewhere or a target changes."
            )
        for i, level in enumerate(self.levels, 1):
            if level.kinematic_corank:
                yield f"Level {i} is singular, corank {level.kinematic_corank}."
            elif level.algorithmic:
                yield f"Level {i} is near an algorithmic singularity: levels above want the same joints."

    def _advice(self) -> str:
        if self.status is Status.TRACKING or not self.levels:
            return ""
        if self.status is Status.INFEASIBLE:
            return "Slow down earlier, allow more acceleration, or lead the robot out of collision."
        held = self.levels[0].scale < SLOWED
        if self.status is Status.SCALED:
            slowed = any(level.scale < 1 for level in self.levels)
            return "Ask for less speed to keep up." if slowed else "It is held back near a singularity, and catches up."
        if held:
            return (
                "Limits stand in its way: lead the target back inside them, or take Sliding(), which goes on along "
                "them where limiters that keep the direction stop; why_stuck() tells which, and if there is a way."
            )
        return (
            "It pulls along a direction that is lost: lead the target elsewhere, drop rows that are not needed, or "
            "bend the arm by a SingularValueTask or a PostureTask."
        )


LATER = ("levels", "active", "contradictions", "status", "calmed")
"""What of a lazy resolution is made when it is read."""


class LazyResolution(Resolution):
    """A resolution of which all but q̇ is made when it is first read: in a control loop hardly anybody does."""

    @classmethod
    def of(cls, qdot: Array, made: Callable[[], Resolution]) -> Resolution:
        """The resolution with these joint velocities, the rest from `made`."""
        found = object.__new__(cls)
        vars(found).update(qdot=qdot, _made=made)
        return found

    @property
    def unread(self) -> Callable[[], Resolution] | None:
        """What makes the rest, as long as nobody has read it."""
        made: Callable[[], Resolution] | None = vars(self).get("_made")
        return made

    def __getattr__(self, name: str) -> Any:
        made = vars(self).get("_made")
        if made is not None and name in LATER:
            full = made()
            vars(self).update({key: getattr(full, key) for key in LATER})
            vars(self).pop("_made", None)
        if name not in vars(self):  # another thread may have made it meanwhile
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        return vars(self)[name]

    def __reduce__(self) -> tuple[object, ...]:
        # As a plain one: what makes the rest holds a controller.
        return Resolution, (self.qdot, self.levels, self.active, self.contradictions, self.status, self.calmed)
