"""Levels of a controller's program whose inverse is `SecondOrder`: their memory, and ∂J/∂q of rows from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.compiled_loop.resolver_program import Compilable, ResolverProgram, second_order_of
from robust_ik.control.resolvers import DecoupledPriority, WeightedPriority
from robust_ik.control.tasks.compiled_form import CompiledForm
from robust_ik.inverses.second_order import SecondOrderRun
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.second_order.second_order_layout import MEMORY_HEAD, memory_size

Forms = Sequence[Sequence[CompiledForm]]


@dataclass(eq=False)
class CurvedLevel:
    """A level of second order.

    Attributes:
        run: The run of its inverse, with its memory.
        shape: Numbers of its rows and of joints.
        record: Its record, a view of the program.
        memory: Its memory on the desk, see `second_order_layout.MEMORY_ROWS`.
        curvature: ∂J/∂q of rows from outside on the desk, (m, n, n), but for the units of the joints; empty without
            such rows.
        blind: Whether ∂J/∂q of some of its rows is never known.
    """

    run: SecondOrderRun
    shape: tuple[int, int]
    record: Array
    memory: Array
    curvature: Array
    blind: bool

    def begin(self) -> None:
        """Puts the memory of the steps before on the desk."""
        self.run.tell(*self.shape, self.memory)

    def keep(self) -> None:
        """Takes over the memory that a step has left."""
        self.run.remember(*self.shape, self.memory)

    def put_curvature(self, rows: slice, hessian: Array | None) -> None:
        """Puts ∂J/∂q of rows from outside on the desk; without it the level has none, see `see`."""
        if hessian is None:
            self.record[slots.BLIND] = 1.0
        else:
            self.curvature[rows] = hessian

    def see(self) -> None:
        """Forgets that rows from outside had no ∂J/∂q."""
        self.record[slots.BLIND] = self.blind


def mark_curved(head: Array, resolver: Compilable, forms: Forms) -> None:
    """Writes into the records which levels are of second order."""
    whole = isinstance(resolver, (DecoupledPriority, WeightedPriority))
    for level, tasks in enumerate(forms):
        if second_order_of(resolver.inverse_of(level)) is not None:
            record = head[slots.HEAD + level * slots.RECORD :]
            record[slots.WAY] = slots.CURVED_DECOUPLED if whole else slots.CURVED
            record[slots.BLIND] = _has(slots.CLIMB, tasks)


def curvature_room(program: Array, n: int, forms: Forms) -> list[tuple[int, int]]:
    """Room for ∂J/∂q of rows from outside: where in the program its place is written, and its size."""
    found = []
    for level, tasks in enumerate(forms):
        at = slots.HEAD + level * slots.RECORD
        if program[at + slots.WAY] >= slots.CURVED and _has(slots.GIVEN, tasks):
            found.append((at + slots.CURVATURE, sum(form.height for form in tasks) * n * n))
    return found


def curved_levels(made: ResolverProgram, forms: Forms) -> dict[int, CurvedLevel]:
    """The levels of second order of a program, by number."""
    found, n = {}, made.shape[0]
    for level, m in enumerate(made.shape[1]):
        run = second_order_of(made.resolver.inverse_of(level))
        at = slots.HEAD + level * slots.RECORD
        if run is None or made.program[at + slots.WAY] < slots.CURVED:
            continue
        there = made.program[at + slots.CURVATURE] > 0
        found[level] = CurvedLevel(
            run=run,
            shape=(m, n),
            record=made.program[at : at + slots.RECORD],
            memory=made.view(at + slots.MEMORY, MEMORY_HEAD + memory_size(m, n)),
            curvature=made.view(at + slots.CURVATURE, m, n, n) if there else np.zeros((0, n, n)),
            blind=_has(slots.CLIMB, forms[level]),
        )
    return found


def _has(kind: int, forms: Sequence[CompiledForm]) -> bool:
    """Whether a task of a level is of this kind."""
    return any(form.record[slots.KIND] == kind for form in forms)
