"""The program and the desk of a resolver, for problems of one shape.

`Resolver.resolve` in NumPy is the reference; tests compare the two.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeGuard

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers import (
    DecoupledPriority,
    PriorityResolver,
    Resolver,
    TaskPriority,
    TaskReconstruction,
    WeightedPriority,
)
from robust_ik.control.resolvers.priority_resolver import Settled
from robust_ik.control.resolvers.task_reconstruction import smooth
from robust_ik.control.within_bounds.limiters import Eased, Limiter, QuadraticProgram, Saturation, Scaling, Sliding
from robust_ik.control.within_bounds.null_space import Freedom, Reduced
from robust_ik.inverses import GainFormula, RobustInverse, SingularValueFilter
from robust_ik.inverses.second_order import SecondOrder, SecondOrderRun
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.second_order.second_order_layout import MEMORY_HEAD, memory_size
from robust_ik.kernels.within_bounds.bounds_layout import scratch_of


def limiter_code(limiter: Limiter) -> int | None:
    """The code of a limiter in kernels; None for one of the user's own."""
    if type(limiter) is QuadraticProgram:
        return slots.KEEPING if limiter.keep_direction else slots.NEAREST
    codes = {Sliding: slots.SLIDING, Saturation: slots.SATURATION, Scaling: slots.SCALING}
    return codes.get(type(limiter))


Compilable = PriorityResolver | WeightedPriority
"""Resolvers of which some have a compiled form, see `is_compilable`."""

WAYS = {
    TaskPriority: slots.IN_FREEDOM,
    DecoupledPriority: slots.DECOUPLED,
    TaskReconstruction: slots.RECONSTRUCTED,
    WeightedPriority: slots.IN_FREEDOM,
}
"""How compiled code finds the motions of a resolver's levels."""


def is_compilable(resolver: Resolver) -> TypeGuard[Compilable]:
    """Whether a resolver has a compiled form; motions of its levels may still come from Python."""
    kind = type(resolver)
    if kind is WeightedPriority or kind is TaskReconstruction:
        if isinstance(resolver, TaskReconstruction) and resolver.shape is not smooth:
            return False
        curved = (SecondOrder, SecondOrderRun) if kind is WeightedPriority else ()
        inverses: tuple[RobustInverse, ...] = resolver.inverses  # type: ignore[attr-defined]
        if any(type(each) not in curved and gain_address(each) is None for each in inverses):
            return False
    if kind is WeightedPriority:
        return True
    if not isinstance(resolver, PriorityResolver) or kind.resolve is not PriorityResolver.resolve:
        return False
    return limiter_code(resolver.limiter) is not None


def eased_of(resolver: Compilable) -> tuple[Eased, ...]:
    """The limiters of a resolver's levels with their memory, if it has any."""
    return resolver.eased if isinstance(resolver, PriorityResolver) else ()


def gain_address(inverse: RobustInverse) -> int | None:
    """The address of the compiled gain formula of an inverse that is nothing but that formula; else None."""
    if not isinstance(inverse, GainFormula):
        return None
    kind = type(inverse)
    plain = kind.velocity is SingularValueFilter.velocity and kind.solve is SingularValueFilter.solve
    if not plain or kind.gains is not GainFormula.gains:
        return None
    from robust_ik.kernels.compiler.gain_callbacks import address_of

    return address_of(kind.formula)


def second_order_of(inverse: RobustInverse) -> SecondOrderRun | None:
    """The inverse, if it is a run of the second-order inverse itself: that is compiled in controllers' programs."""
    return inverse if type(inverse) is SecondOrderRun and type(inverse.inverse) is SecondOrder else None


def parameters_of(inverse: RobustInverse) -> Array:
    """The parameters that compiled code needs of an inverse."""
    told = inverse.parameters if isinstance(inverse, (GainFormula, SecondOrderRun)) else ()
    return np.array(told, dtype=float)


@dataclass(frozen=True, eq=False)
class LevelDesk:
    """A level's place on the desk: views of its numbers.

    Attributes:
        J: (m, n).
        xdot: (m,).
        missing: (m,).
        residual: (m,).
        U: m · min(m, n) numbers: (m, k) at a step.
        s: (min(m, n),).
        own: (min(m, n),).
        Vt: (n, n).
        aim: (n,).
        found: Numbers found, see `control_layout.FREE`.
        error: (m,).
    """

    J: Array
    xdot: Array
    missing: Array
    residual: Array
    U: Array
    s: Array
    own: Array
    Vt: Array
    aim: Array
    found: Array
    error: Array

    @classmethod
    def of(cls, program: Array, desk: Array, level: int) -> LevelDesk:
        """The place of a level on a desk, or on a copy of it."""
        record, n = program[slots.HEAD + level * slots.RECORD :], int(program[slots.JOINTS])
        m = int(record[slots.M])
        k = min(m, n)

        def view(slot: int, *shape: int) -> Array:
            at = int(record[slot])
            return desk[at : at + math.prod(shape)].reshape(shape)

        return cls(
            J=view(slots.JACOBIAN, m, n), xdot=view(slots.X, m), missing=view(slots.MISSING, m),
            residual=view(slots.RESIDUAL, m), U=view(slots.LEFT, m * k), s=view(slots.SIGMA, k),
            own=view(slots.OWN, k), Vt=view(slots.RIGHT, n, n), aim=view(slots.AIM, n),
            found=view(slots.FOUND, slots.NUMBERS), error=view(slots.ERROR, m),
        )  # fmt: skip

    @property
    def equation(self) -> TaskEquation:
        """The level's equation, in a controller's units, as copies."""
        return self.equation_at(1.0)

    def equation_at(self, share: float) -> TaskEquation:
        """The equation of a level that asks for a share of its velocity."""
        return TaskEquation(self.J.copy(), share * self.xdot, self.error.copy())

    @property
    def reduced(self) -> Reduced:
        """The level's Jacobian in the freedom left to it, as copies."""
        free, rank, closed, count = (int(each) for each in self.found[:4])
        return Reduced(
            U=self.U[: len(self.xdot) * count].reshape(len(self.xdot), count).copy(),
            s=self.s[:count].copy(),
            Vt=self.Vt[:count].copy(),
            own=self.own.copy(),
            below=self.Vt[closed:free].T.copy(),
            idle=self.Vt[rank:free].T.copy(),
            rank=rank,
        )


class ResolverProgram:
    """The program and the desk of a resolver, and what runs them.

    Attributes:
        resolver: The resolver, begun for a run.
        shape: The number of joints, and the number of rows of each level.
        program: See `control_layout`.
        desk: The same.
        levels: The levels' places on the desk.
        run: The compiled step, see `control_entries.step`.
        setup: Its first argument.
    """

    def __init__(self, resolver: Compilable, n: int, rows: Sequence[int], dt: float, room: int = 0) -> None:
        """Makes a program.

        Args:
            resolver: A resolver for which `is_compilable` holds, begun for a run.
            n: Number of joints.
            rows: Number of rows of each level.
            dt: Length of a step, s; 0 if unknown.
            room: Room for this many rows of bounds.
        """
        self.resolver, self.shape, self.room = resolver, (n, tuple(rows)), room
        parts = self._written(resolver, n, rows, dt)
        more = self._further(sum(map(len, parts)), parts[0])
        self.program = np.concatenate([*parts, *more])
        self.desk = np.zeros(self._placed(n, rows, room))
        self.calmed[[slots.CALM_SHARE, slots.CALM_NOW]] = 1.0
        self.levels = tuple(LevelDesk.of(self.program, self.desk, level) for level in range(len(rows)))
        self._addresses = np.array([id(np.ndarray), self.program.ctypes.data, self.desk.ctypes.data])
        self.setup, self.run = int(self._addresses.ctypes.data), kernel_for(self.widest)

    @property
    def widest(self) -> int:
        """The largest number of joints, or of rows of a level; of all levels, for measures of them together."""
        return max(self.shape[0], rows_together(self.resolver, self.shape[1]))

    def _further(self, size: int, head: Array) -> list[Array]:  # noqa: ARG002
        """Further parts of the program, after `size` numbers; their places are written into the head."""
        return []

    @staticmethod
    def _written(resolver: Compilable, n: int, rows: Sequence[int], dt: float) -> list[Array]:
        """The program without places, and without what it has for more than resolving levels."""
        head = np.zeros(slots.HEAD + slots.RECORD * len(rows))
        head[slots.JOINTS], head[slots.LEVELS], head[slots.DT] = n, len(rows), dt
        head[slots.STEADY] = resolver.steady
        if isinstance(resolver, PriorityResolver):
            head[slots.LIMITER], head[slots.RELEASE] = limiter_code(resolver.limiter) or 0, resolver.release
            head[slots.RISE] = resolver.eased[0].rise if resolver.eased else 0.0
        else:
            head[slots.RESOLVER] = slots.WEIGHTED
        if isinstance(resolver, TaskReconstruction):
            head[slots.WAY_BACK] = -resolver.recovery if resolver.printed_sign else resolver.recovery
            head[slots.COMPENSATED] = resolver.compensate
        parts = [head]
        way = WAYS.get(type(resolver), slots.OUTSIDE)
        for level, m in enumerate(rows):
            record = head[slots.HEAD + level * slots.RECORD :]
            inverse = resolver.inverse_of(level)
            address = None if way == slots.OUTSIDE else gain_address(inverse)
            record[slots.M], record[slots.WAY] = m, slots.OUTSIDE if address is None else way
            record[slots.GAIN], record[slots.RELATIVE] = address or 0, inverse.relative
            record[slots.PARAMETERS] = sum(map(len, parts))
            if isinstance(resolver, WeightedPriority):
                record[slots.LEVEL_WEIGHT] = resolver.weight_of(level)
            if isinstance(resolver, TaskReconstruction):
                record[slots.BOUND] = resolver.bounds[min(level, len(resolver.bounds) - 1)]
            parts.append(parameters_of(inverse))
        return parts

    def _placed(self, n: int, rows: Sequence[int], room: int) -> int:
        """Writes the places on the desk into the program; returns its size."""
        size = 1  # place 0 stands for none

        def take(at: int, count: int) -> None:
            nonlocal size
            self.program[at] = size
            size += count

        for at in (slots.LOWER, slots.UPPER, slots.SPEEDS, slots.LAST, slots.LONG_LOWER, slots.LONG_UPPER):
            take(at, n)
        take(slots.QDOT, n)
        take(slots.MOTION, n)
        take(slots.EASED, max(len(rows), 1))
        first = size
        take(slots.CALM, slots.CALMING + slots.REMEMBERED * n)
        for level, m in enumerate(rows):
            at = slots.HEAD + level * slots.RECORD
            if self.program[at + slots.WAY] >= slots.CURVED:
                take(at + slots.MEMORY, MEMORY_HEAD + memory_size(m, n))
        self.program[slots.NOTED] = size - first
        take(slots.EARLIER, size - first)
        take(slots.BOUND_ROWS, room * n)
        take(slots.FLOOR, 3 * room)
        for at, count in self._more_room():
            take(at, count)
        for level, m in enumerate(rows):
            k, at = min(m, n), slots.HEAD + level * slots.RECORD
            sizes = {
                slots.X: m, slots.JACOBIAN: m * n, slots.MISSING: m, slots.RESIDUAL: m, slots.LEFT: m * k,
                slots.SIGMA: k, slots.OWN: k, slots.RIGHT: n * n, slots.AIM: n, slots.FOUND: slots.NUMBERS,
                slots.ERROR: m, slots.SLOPE: n,
            }  # fmt: skip
            for place, count in sizes.items():
                take(at + place, count)
        take(slots.SCRATCH, max((n + 1 + room) * (n + 1) + 2 * (n + 1) + room, scratch_of(n, room)))
        return size

    def _more_room(self) -> list[tuple[int, int]]:
        """Further rooms on the desk: where in the program their places are written, and their sizes."""
        return []

    def view(self, slot: int, *shape: int) -> Array:
        """A view of numbers of the desk whose place is in the head of the program."""
        at = int(self.program[slot])
        return self.desk[at : at + math.prod(shape)].reshape(shape)

    @cached_property
    def qdot(self) -> Array:
        """The joint velocities on the desk, (n,)."""
        return self.view(slots.QDOT, self.shape[0])

    @cached_property
    def motion(self) -> Array:
        """A level's motion on the desk, (n,)."""
        return self.view(slots.MOTION, self.shape[0])

    @cached_property
    def eased(self) -> Array:
        """The last speeds of stopped levels, (levels,)."""
        return self.view(slots.EASED, max(len(self.shape[1]), 1))

    @cached_property
    def calmed(self) -> Array:
        """What is remembered of joints that turn back, see `control_layout.CALM_SHARE`."""
        return self.view(slots.CALM, slots.CALMING + slots.REMEMBERED * self.shape[0])

    @cached_property
    def noted(self) -> Array:
        """All that is remembered from step to step, see `control_layout.NOTED`."""
        return self.view(slots.CALM, int(self.program[slots.NOTED]))

    def put_bounds(self, bounds: Bounds) -> None:
        """Puts bounds on the desk."""
        n, put = self.shape[0], self.view
        put(slots.LOWER, n)[:], put(slots.UPPER, n)[:] = bounds.lower, bounds.upper
        long = (bounds.lower, bounds.upper) if bounds.unhurried is None else bounds.unhurried
        put(slots.LONG_LOWER, n)[:], put(slots.LONG_UPPER, n)[:] = long
        self.program[slots.HAS_SPEEDS] = bounds.fastest is not None
        if bounds.fastest is not None:
            put(slots.SPEEDS, n)[:] = bounds.fastest
        self.program[slots.HURRIED] = bounds.last is not None
        if bounds.last is not None:
            put(slots.LAST, n)[:] = bounds.last
        self.program[slots.ROWS] = count = len(bounds.floor)
        put(slots.BOUND_ROWS, count, n)[:], put(slots.FLOOR, count)[:] = bounds.rows, bounds.floor

    def outside(self, problem: VelocityProblem, level: int) -> Array:
        """The motion of a level by the resolver itself, from what is on the desk."""
        start = self.qdot.copy()
        reduced = tuple(each.reduced for each in self.levels[: level + 1])
        freedom = Freedom.whole(len(start)) if level == 0 else Freedom(reduced[-2].below)
        if not isinstance(self.resolver, PriorityResolver):
            raise TypeError(f"{type(self.resolver).__name__} resolves all levels at once")  # and asks for no motions
        settled = Settled(problem, level, self.resolver.inverse_of(level), start, freedom, reduced)
        return self.resolver.motion(settled)


def rows_together(resolver: Compilable, rows: Sequence[int]) -> int:
    """The most rows that are decomposed together."""
    return sum(rows) if isinstance(resolver, TaskReconstruction) else max(rows, default=1)


def kernel_for(most: int) -> Callable[..., int]:
    """The compiled step for at most so many joints and rows of a level."""
    from robust_ik.kernels import control

    size = next(each for each in SIZES if most <= each)
    compiled: Callable[..., int] = getattr(control, f"control_{size}").compiled
    return compiled


SIZES = (8, 16, 32)
"""Sizes of kernels: most joints, and most rows of a level. Chosen: for single arms, two arms, humanoids."""
