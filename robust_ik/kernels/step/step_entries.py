"""What Python calls to make steps: one from vectors, or many, a row each. The program is given by its address."""

from __future__ import annotations

from typing import Any

from robust_ik.checks import Array
from robust_ik.kernels.chain.chain_layout import CONFIGURATION, INDEPENDENT
from robust_ik.kernels.compiler.array_handles import ALIGNED, CONTIGUOUS, WRITEABLE, is_vector, numbers_of, whole_at
from robust_ik.kernels.compiler.compiling import HANDLE, WHOLE, filled, given, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import W8, W16, Pointer, Sizes, at_address
from robust_ik.kernels.step.step import factor_one, many, step_one
from robust_ik.kernels.step.step_layout import CHAIN, ROWS, UNLIKE

ONE_STEP = WHOLE, HANDLE, HANDLE, HANDLE
BESIDE = WHOLE, HANDLE, HANDLE, HANDLE, HANDLE
FACTOR = WHOLE, HANDLE, HANDLE, HANDLE, HANDLE, HANDLE
MANY_STEPS = WHOLE, given(2), given(2), given(2), filled(2)
PLAIN = CONTIGUOUS | ALIGNED


@inlined
def program_of(setup: int) -> Pointer:
    """The program, from the address of two: of the class of arrays and of the program."""
    return at_address(whole_at(setup + 8))


@inlined
def fit(setup: int, q: Any, twist: Any) -> bool:
    """Whether q and twist are vectors of doubles, as long as they have to be."""
    program, array_class = program_of(setup), whole_at(setup)
    length = int(program[int(program[CHAIN]) + CONFIGURATION])
    return bool(is_vector(q, array_class, length, PLAIN) and is_vector(twist, array_class, int(program[ROWS]), PLAIN))


@inlined
def fits(setup: int, speeds: Any, flags: int) -> bool:
    """Whether these are as many doubles as there are joints."""
    program = program_of(setup)
    return bool(is_vector(speeds, whole_at(setup), int(program[int(program[CHAIN]) + INDEPENDENT]), flags))


@inlined
def step(setup: int, q: Any, twist: Any, out: Any, width: Sizes) -> int:
    """A step, if the vectors fit."""
    if not (fit(setup, q, twist) and fits(setup, out, PLAIN | WRITEABLE)):
        return UNLIKE
    start = numbers_of(q)
    return step_one(program_of(setup), start, numbers_of(twist), start, False, numbers_of(out), width)


@inlined
def step_beside(setup: int, q: Any, twist: Any, beside: Any, out: Any, width: Sizes) -> int:
    """A step that does something beside its task, if the vectors fit."""
    if not (fit(setup, q, twist) and fits(setup, out, PLAIN | WRITEABLE) and fits(setup, beside, PLAIN)):
        return UNLIKE
    return step_one(
        program_of(setup), numbers_of(q), numbers_of(twist), numbers_of(beside), True, numbers_of(out), width
    )


@inlined
def factor(setup: int, q: Any, twist: Any, s: Any, x: Any, Vt: Any, width: Sizes) -> int:
    """What a filter in Python needs, if the vectors fit; s, x and Vt are trusted to."""
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
    """Of at most 16 joints."""
    return step(setup, q, twist, out, W16)


@kernel(*BESIDE)
def beside_8(setup: int, q: Any, twist: Any, beside: Any, out: Any) -> int:
    """A step of a robot of at most 8 joints that does something beside its task; its status."""
    return step_beside(setup, q, twist, beside, out, W8)


@kernel(*BESIDE)
def beside_16(setup: int, q: Any, twist: Any, beside: Any, out: Any) -> int:
    """Of at most 16 joints."""
    return step_beside(setup, q, twist, beside, out, W16)


@kernel(*FACTOR)
def factor_8(setup: int, q: Any, twist: Any, s: Any, x: Any, Vt: Any) -> int:
    """What a filter in Python needs, of at most 8 joints; a status."""
    return factor(setup, q, twist, s, x, Vt, W8)


@kernel(*FACTOR)
def factor_16(setup: int, q: Any, twist: Any, s: Any, x: Any, Vt: Any) -> int:
    """Of at most 16 joints."""
    return factor(setup, q, twist, s, x, Vt, W16)


@kernel(*MANY_STEPS)
def steps_8(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Many steps of a robot of at most 8 joints; a status that is not DONE if there is one. Rows must fit."""
    return many(at_address(program), q, twist, beside, out, W8)


@kernel(*MANY_STEPS)
def steps_16(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Of at most 16 joints."""
    return many(at_address(program), q, twist, beside, out, W16)
