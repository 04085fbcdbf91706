"""Entry points of the control step for Python: one step from vectors, or many, one a row.

The program, see `step_layout`, is given by its address.
"""

from __future__ import annotations

from typing import Any

from robust_ik.checks import Array
from robust_ik.kernels.chain.chain_layout import CONFIGURATION, INDEPENDENT
from robust_ik.kernels.compiler.array_handles import int64_at, is_vector, numbers_of
from robust_ik.kernels.compiler.compiling import HANDLE, WHOLE, filled, given, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import W8, W16, Pointer, Sizes, at_address
from robust_ik.kernels.loader.array_layout import ALIGNED, CONTIGUOUS, WRITEABLE
from robust_ik.kernels.step.step import factor_one, many, step_one
from robust_ik.kernels.step.step_layout import CHAIN, ROWS, UNLIKE

ONE_STEP = WHOLE, HANDLE, HANDLE, HANDLE
BESIDE = WHOLE, HANDLE, HANDLE, HANDLE, HANDLE
FACTOR = WHOLE, HANDLE, HANDLE, HANDLE, HANDLE, HANDLE
MANY_STEPS = WHOLE, given(2), given(2), given(2), filled(2)
PLAIN = CONTIGUOUS | ALIGNED


@inlined
def program_of(setup: int) -> Pointer:
    """The program, from the address of two addresses: of NumPy's array class and of the program."""
    return at_address(int64_at(setup + 8))


@inlined
def fit(setup: int, q: Any, twist: Any) -> bool:
    """Whether q and twist are vectors of doubles of the right lengths."""
    program, array_class = program_of(setup), int64_at(setup)
    length = int(program[int(program[CHAIN]) + CONFIGURATION])
    return bool(is_vector(q, array_class, length, PLAIN) and is_vector(twist, array_class, int(program[ROWS]), PLAIN))


@inlined
def fits(setup: int, speeds: Any, flags: int) -> bool:
    """Whether `speeds` has one double for each joint."""
    program = program_of(setup)
    return bool(is_vector(speeds, int64_at(setup), int(program[int(program[CHAIN]) + INDEPENDENT]), flags))


@inlined
def step(setup: int, q: Any, twist: Any, out: Any, width: Sizes) -> int:
    """A step, if the vectors have the right lengths, else UNLIKE."""
    if not (fit(setup, q, twist) and fits(setup, out, PLAIN | WRITEABLE)):
        return UNLIKE
    start = numbers_of(q)
    return step_one(program_of(setup), start, numbers_of(twist), start, False, numbers_of(out), width)


@inlined
def step_beside(setup: int, q: Any, twist: Any, beside: Any, out: Any, width: Sizes) -> int:
    """A step with a secondary joint velocity, if the vectors have the right lengths, else UNLIKE."""
    if not (fit(setup, q, twist) and fits(setup, out, PLAIN | WRITEABLE) and fits(setup, beside, PLAIN)):
        return UNLIKE
    return step_one(
        program_of(setup), numbers_of(q), numbers_of(twist), numbers_of(beside), True, numbers_of(out), width
    )


@inlined
def factor(setup: int, q: Any, twist: Any, s: Any, x: Any, Vt: Any, width: Sizes) -> int:
    """σᵢ, uᵢᵀẋ and vᵢ for a filter in Python, if q and twist fit; s, x and Vt are not checked."""
    if not fit(setup, q, twist):
        return UNLIKE
    return factor_one(
        program_of(setup), numbers_of(q), numbers_of(twist), numbers_of(s), numbers_of(x), numbers_of(Vt), width
    )


@kernel(*ONE_STEP)
def step_8(setup: int, q: Any, twist: Any, out: Any) -> int:
    """A step of a robot of at most 8 joints; its status."""
    return step(setup, q, twist, out, W8)


@kernel(*ONE_STEP)
def step_16(setup: int, q: Any, twist: Any, out: Any) -> int:
    """A step of a robot of at most 16 joints; its status."""
    return step(setup, q, twist, out, W16)


@kernel(*BESIDE)
def beside_8(setup: int, q: Any, twist: Any, beside: Any, out: Any) -> int:
    """A step with a secondary joint velocity, of a robot of at most 8 joints; its status."""
    return step_beside(setup, q, twist, beside, out, W8)


@kernel(*BESIDE)
def beside_16(setup: int, q: Any, twist: Any, beside: Any, out: Any) -> int:
    """A step with a secondary joint velocity, of a robot of at most 16 joints; its status."""
    return step_beside(setup, q, twist, beside, out, W16)


@kernel(*FACTOR)
def factor_8(setup: int, q: Any, twist: Any, s: Any, x: Any, Vt: Any) -> int:
    """σᵢ, uᵢᵀẋ and vᵢ for a filter in Python, of a robot of at most 8 joints; returns a status."""
    return factor(setup, q, twist, s, x, Vt, W8)


@kernel(*FACTOR)
def factor_16(setup: int, q: Any, twist: Any, s: Any, x: Any, Vt: Any) -> int:
    """σᵢ, uᵢᵀẋ and vᵢ for a filter in Python, of a robot of at most 16 joints; returns a status."""
    return factor(setup, q, twist, s, x, Vt, W16)


@kernel(*MANY_STEPS)
def steps_8(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Many steps of a robot of at most 8 joints; the first status that is not DONE. Shapes are not checked."""
    return many(at_address(program), q, twist, beside, out, W8)


@kernel(*MANY_STEPS)
def steps_16(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Many steps of a robot of at most 16 joints; the first status that is not DONE. Shapes are not checked."""
    return many(at_address(program), q, twist, beside, out, W16)
