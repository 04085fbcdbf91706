"""The interface of resolvers.

To add one: derive from `PriorityResolver` in `priority_resolver.py` and compute the motion that a level wants in
addition to what is settled, or derive from `InverseResolver` or `Resolver` and resolve all levels at once; the other
steps are in CONTRIBUTING.md.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Self

from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.errors import InputError
from robust_ik.inverses import JParse, RobustInverse

MAX_MEMORIES = 16
"""Most levels with a memory of their own for their inverse; further levels share the last one."""


class Resolver(abc.ABC):
    """Computes joint velocities from levels of tasks and bounds.

    Attributes:
        source: Author, year and equation numbers.
    """

    source: ClassVar[str]

    @property
    def needs_hessian(self) -> bool:
        """Whether `resolve` reads the Hessians of the equations."""
        return False

    @abc.abstractmethod
    def resolve(self, problem: VelocityProblem) -> Resolution:
        """Joint velocities within the bounds: the first level as far as possible, the next ones in the freedom left.

        Args:
            problem: Levels and bounds.

        Returns:
            The joint velocities and how far they meet the levels. Bounds that contradict each other are a status.
        """

    @abc.abstractmethod
    def begin(self, dt: float) -> Self:
        """A resolver for one run of control steps dt seconds apart: inverses with a memory begin anew."""


@dataclass(frozen=True)
class InverseResolver(Resolver):
    """A resolver whose levels each have a robust inverse.

    Attributes:
        inverse: The robust inverse of every level, or a sequence of them, the last one for all further levels.
    """

    inverse: RobustInverse | Sequence[RobustInverse] = field(default_factory=JParse)

    def __post_init__(self) -> None:
        if not isinstance(self.inverse, RobustInverse):
            object.__setattr__(self, "inverse", _checked_sequence(self.inverse))

    @property
    def inverses(self) -> tuple[RobustInverse, ...]:
        """The inverses of the levels, the last one for all further ones."""
        return (self.inverse,) if isinstance(self.inverse, RobustInverse) else tuple(self.inverse)

    def inverse_of(self, level: int) -> RobustInverse:
        """The inverse of a level, from 0."""
        return self.inverses[min(level, len(self.inverses) - 1)]

    @property
    def needs_hessian(self) -> bool:
        """Whether one of the inverses reads Hessians."""
        return any(inverse.needs_hessian for inverse in self.inverses)

    def begin(self, dt: float) -> Self:
        """See `Resolver.begin`."""
        begun = tuple(self.inverse_of(level).begin(dt) for level in range(MAX_MEMORIES))
        return self if all(inverse in self.inverses for inverse in begun) else replace(self, inverse=begun)


def _checked_sequence(given: object) -> tuple[RobustInverse, ...]:
    inverses = tuple(given) if isinstance(given, (list, tuple)) else ()
    if not inverses or not all(isinstance(each, RobustInverse) for each in inverses):
        raise InputError(f"inverse must be a robust inverse such as JParse(), or a sequence of them, got {given!r}")
    return inverses
