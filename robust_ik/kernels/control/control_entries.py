"""Entry points of a controller's step for Python; program and desk, see `control_layout`, come as addresses."""

from __future__ import annotations

from typing import Any

from robust_ik.kernels.compiler.array_handles import int64_at, is_vector, numbers_of
from robust_ik.kernels.compiler.compiling import HANDLE, WHOLE, called, kernel
from robust_ik.kernels.compiler.stack_memory import W8, W16, Sizes, at_address, sizes
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_step import control_step
from robust_ik.kernels.control.resolve_levels import resolve
from robust_ik.kernels.loader.array_layout import ALIGNED, CONTIGUOUS, WRITEABLE

STEP = WHOLE, HANDLE, HANDLE, WHOLE, WHOLE
PLAIN = CONTIGUOUS | ALIGNED
W32 = sizes(32)


@called
def step(setup: int, q: Any, out: Any, first: int, given: int, width: Sizes) -> int:
    """A step, or what is left of one; a status.

    Args:
        setup: Address of three addresses: of NumPy's array class, of the program, and of the desk.
        q: The configuration, (nq,).
        out: Room for the velocities, (n,).
        first: BEGIN for a whole step, if q and `out` are vectors of doubles of the right lengths; else the level from
            which to resolve what is on the desk.
        given: Whether the motion of that level is on the desk.
        width: At least the number of joints, and of rows of every level.
    """
    program, desk, array_class = at_address(int64_at(setup + 8)), at_address(int64_at(setup + 16)), int64_at(setup)
    if first != slots.BEGIN:
        return resolve(program, desk, first, given > 0, width)
    good = is_vector(q, array_class, int(program[slots.CONFIGURATION]), PLAIN)
    if not (good and is_vector(out, array_class, int(program[slots.JOINTS]), PLAIN | WRITEABLE)):
        return slots.UNLIKE
    return control_step(program, desk, numbers_of(q), numbers_of(out), width)


@kernel(*STEP)
def control_8(setup: int, q: Any, out: Any, first: int, given: int) -> int:
    """A step with at most 8 joints, and rows of a level; its status."""
    return step(setup, q, out, first, given, W8)


@kernel(*STEP)
def control_16(setup: int, q: Any, out: Any, first: int, given: int) -> int:
    """A step with at most 16 joints, and rows of a level; its status."""
    return step(setup, q, out, first, given, W16)


@kernel(*STEP)
def control_32(setup: int, q: Any, out: Any, first: int, given: int) -> int:
    """A step with at most 32 joints, and rows of a level; its status."""
    return step(setup, q, out, first, given, W32)
