"""Entry points of many runs for Python; the program, see `control_layout`, comes as an address."""

from __future__ import annotations

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import FLOAT, WHOLE, filled, given, kernel
from robust_ik.kernels.compiler.stack_memory import W8, W16, at_address, sizes
from robust_ik.kernels.runs.many_runs import many_runs

W32 = sizes(32)

RUNS = (
    WHOLE, filled(1), filled(1), filled(2), filled(2), WHOLE, WHOLE, FLOAT, FLOAT, given(1), given(1), given(2),
    filled(3), filled(3),
)  # fmt: skip


@kernel(*RUNS)
def runs_8(
    program: int, desk: Array, room: Array, state: Array, done: Array, steps: int, every: int, noise: float,
    share: float, seeds: Array, places: Array, numbers: Array, q: Array, qdot: Array,
) -> None:  # fmt: skip
    """`many_runs` with at most 8 joints, and rows of a level."""
    many_runs(
        at_address(program), desk, room, state, done, steps, every, noise, share, seeds, places, numbers, q, qdot, W8
    )


@kernel(*RUNS)
def runs_16(
    program: int, desk: Array, room: Array, state: Array, done: Array, steps: int, every: int, noise: float,
    share: float, seeds: Array, places: Array, numbers: Array, q: Array, qdot: Array,
) -> None:  # fmt: skip
    """`many_runs` with at most 16 joints, and rows of a level."""
    many_runs(
        at_address(program), desk, room, state, done, steps, every, noise, share, seeds, places, numbers, q, qdot, W16
    )


@kernel(*RUNS)
def runs_32(
    program: int, desk: Array, room: Array, state: Array, done: Array, steps: int, every: int, noise: float,
    share: float, seeds: Array, places: Array, numbers: Array, q: Array, qdot: Array,
) -> None:  # fmt: skip
    """`many_runs` with at most 32 joints, and rows of a level."""
    many_runs(
        at_address(program), desk, room, state, done, steps, every, noise, share, seeds, places, numbers, q, qdot, W32
    )
