"""Many runs of one program, side by side on threads; steps that compiled code cannot make come from outside."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.calming import Calming
from robust_ik.control.compiled_loop.control_program import ControlProgram
from robust_ik.control.compiled_loop.resolver_program import SIZES

MOST_SEED = 2**53
"""Seeds of runs are below this: they travel as doubles."""


@dataclass(frozen=True, eq=False)
class LoopRuns:
    """N runs of K records each.

    Attributes:
        time: Times of the records, (K,), s after the start.
        q: Configurations then, (N, K, nq).
        qdot: Velocities that the controller asked for in the step that led there, (N, K, n).
        final_q: Configurations after the last step, (N, nq).
    """

    time: Array
    q: Array
    qdot: Array
    final_q: Array


@dataclass(frozen=True, eq=False)
class RunPlan:
    """What is asked of many runs.

    Attributes:
        q: Starts, (N, nq).
        qdot: Velocities at the starts, (N, n).
        steps: Number of steps.
        every: Every how many steps are recorded.
        noise: Standard deviation of what is measured of joint values, rad or m.
        share: The share of a change of velocity that drives make in a step.
        seeds: Of the runs' random numbers, (N,).
        places: Places in the program of numbers that differ from run to run, (P,).
        numbers: These numbers, (N, P).
    """

    q: Array
    qdot: Array
    steps: int
    every: int
    noise: float
    share: float
    seeds: Array
    places: Array
    numbers: Array


Outside = Callable[[int, Array, Array, Array, Array], Array]
"""(run, measured q, last velocities, speeds of stopped levels, what is noted, see `control_layout.NOTED`) → velocities;
what is remembered is moved on."""


def make_runs(program: ControlProgram, plan: RunPlan, threads: int, outside: Outside) -> LoopRuns:
    """Makes runs of a program.

    Args:
        program: The program; its numbers are read, and nothing of it is changed.
        plan: What is asked.
        threads: Number of threads.
        outside: What makes the steps that compiled code cannot make.
    """
    count, nq, levels, n = len(plan.q), plan.q.shape[1], len(program.levels), program.shape[0]
    stopped = np.full((count, levels), math.inf)
    noted = np.zeros((count, len(program.noted)))
    calmed = Calming(np.zeros(n), np.zeros(n)).memory
    noted[:, : len(calmed)] = calmed
    state = np.concatenate([plan.q, plan.qdot, plan.qdot, stopped, noted, np.zeros((count, nq))], axis=1)
    done, records = np.zeros((count, 2)), plan.steps // plan.every
    q, qdot = np.empty((count, records, nq)), np.empty((count, records, n))
    kernel = _kernel(program.widest)
    shares = [slice(begin, begin + -(-count // threads)) for begin in range(0, count, -(-count // threads))]

    def some(part: slice) -> None:
        own, desk = program.program.copy(), program.desk.copy()
        kernel(
            own.ctypes.data, desk, _lanes(len(desk)), state[part], done[part], plan.steps, plan.every, plan.noise,
            plan.share, plan.seeds[part], plan.places, plan.numbers[part], q[part], qdot[part],
        )  # fmt: skip

    with ThreadPoolExecutor(max(len(shares), 1)) as pool:
        while (done[:, 0] < plan.steps).any():
            list(pool.map(some, shares))
            for run in np.flatnonzero(done[:, 0] < plan.steps).tolist():
                _step_outside(program, plan, run, state[run], outside)
                done[run, 0] += 1
                _record(plan, program, run, int(done[run, 0]), state[run], q, qdot)
    time: Array = np.arange(1.0, records + 1) * (plan.every * program.dt)
    return LoopRuns(time, q, qdot, state[:, :nq].copy())


def _step_outside(program: ControlProgram, plan: RunPlan, run: int, state: Array, outside: Outside) -> None:
    """Makes one step of a run outside of compiled code, and moves its state on."""
    n, nq, levels = program.shape[0], plan.q.shape[1], len(program.levels)
    count = len(program.noted)
    q, asked, moving, stopped, noted, measured = np.split(state, np.cumsum([nq, n, n, levels, count]))  # views
    asked[:] = outside(run, measured, asked.copy(), stopped, noted)
    moving += plan.share * (asked - moving)
    q[:] = program.robot.integrate(q, program.dt * moving)


def _record(plan: RunPlan, program: ControlProgram, run: int, done: int, state: Array, q: Array, qdot: Array) -> None:
    """Records a step that has been made outside, if it is one that is recorded."""
    if done % plan.every == 0:
        n, nq = program.shape[0], plan.q.shape[1]
        q[run, done // plan.every - 1], qdot[run, done // plan.every - 1] = state[:nq], state[nq : nq + n]


def _lanes(size: int) -> Array:
    """Room for `size` times eight numbers side by side, at a multiple of their bytes."""
    room = np.zeros(COUNT * (size + 1))
    skipped = -room.ctypes.data % ALIGNMENT // room.itemsize
    return room[skipped : skipped + COUNT * size]


COUNT, ALIGNMENT = 8, 64
"""As `simd_lanes.COUNT` and `stack_memory.ALIGNMENT`, whose modules load Numba."""


def _kernel(most: int) -> Callable[..., None]:
    from robust_ik.kernels import runs

    size = next(each for each in SIZES if most <= each)
    compiled: Callable[..., None] = getattr(runs, f"runs_{size}").compiled
    return compiled


def places_of(view: Array, program: Array) -> Array:
    """The places in a program of the numbers of a view of it, in the order of `ravel`."""
    offset = (view.ctypes.data - program.ctypes.data) // program.itemsize
    steps = [stride // program.itemsize for stride in view.strides]
    places = np.full(view.shape, offset)
    for axis, step in enumerate(steps):
        shape = [1] * view.ndim
        shape[axis] = -1
        places = places + step * np.arange(view.shape[axis]).reshape(shape)
    return places.ravel().astype(float)
