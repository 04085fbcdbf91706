"""What Python calls to make steps: one from vectors, or many, a row each. The program is given by its address."""

from __future__ import annotations

from typing import Any

from robust_ik.checks import Array
from robust_ik.kernels.compiling import WHOLE, filled, given, inlined, kernel
from robust_ik.kernels.packing import CONFIGURATION, INDEPENDENT
from robust_ik.kernels.program import CHAIN, ROWS
from robust_ik.kernels.stack import W8, W16, Sizes, at_address, pointer
from robust_ik.kernels.step_task import WRONG_LENGTH
from robust_ik.kernels.stepping import factor_one, many, step_one

ONE_STEP = WHOLE, given(1), given(1), filled(1)
BESIDE = WHOLE, given(1), given(1), given(1), filled(1)
FACTOR = WHOLE, given(1), given(1), filled(1), filled(1), filled(2)
MANY_STEPS = WHOLE, given(2), given(2), given(2), filled(2)


@inlined
def fit(program: int, q: Array, twist: Array, n: int) -> Any:
    """Whether vectors are as long as they have to be."""
    read = at_address(program)
    chain = int(read[CHAIN])
    lengths = len(q) == read[chain + CONFIGURATION] and n == read[chain + INDEPENDENT]
    return lengths and len(twist) == read[ROWS]


@inlined
def step(program: int, q: Array, twist: Array, out: Array, width: Sizes) -> int:
    """A step, if the vectors fit."""
    if not fit(program, q, twist, len(out)):
        return WRONG_LENGTH
    return step_one(at_address(program), pointer(q), pointer(twist), pointer(q), False, pointer(out), width)


@inlined
def step_beside(program: int, q: Array, twist: Array, beside: Array, out: Array, width: Sizes) -> int:
    """A step that does something beside its task, if the vectors fit."""
    if not fit(program, q, twist, len(out)) or len(beside) != len(out):
        return WRONG_LENGTH
    return step_one(at_address(program), pointer(q), pointer(twist), pointer(beside), True, pointer(out), width)


@inlined
def factor(program: int, q: Array, twist: Array, s: Array, x: Array, Vt: Array, width: Sizes) -> int:
    """What a filter in Python needs, if the vectors fit."""
    if not fit(program, q, twist, Vt.shape[1]):
        return WRONG_LENGTH
    return factor_one(at_address(program), pointer(q), pointer(twist), pointer(s), pointer(x), pointer(Vt), width)


@kernel(*ONE_STEP)
def step_8(program: int, q: Array, twist: Array, out: Array) -> int:
    """A step of a robot of at most 8 joints; its status."""
    return step(program, q, twist, out, W8)


@kernel(*ONE_STEP)
def step_16(program: int, q: Array, twist: Array, out: Array) -> int:
    """Of at most 16 joints."""
    return step(program, q, twist, out, W16)


@kernel(*BESIDE)
def beside_8(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """A step of a robot of at most 8 joints that does something beside its task; its status."""
    return step_beside(program, q, twist, beside, out, W8)


@kernel(*BESIDE)
def beside_16(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Of at most 16 joints."""
    return step_beside(program, q, twist, beside, out, W16)


@kernel(*FACTOR)
def factor_8(program: int, q: Array, twist: Array, s: Array, x: Array, Vt: Array) -> int:
    """What a filter in Python needs, of at most 8 joints; a status."""
    return factor(program, q, twist, s, x, Vt, W8)


@kernel(*FACTOR)
def factor_16(program: int, q: Array, twist: Array, s: Array, x: Array, Vt: Array) -> int:
    """Of at most 16 joints."""
    return factor(program, q, twist, s, x, Vt, W16)


@kernel(*MANY_STEPS)
def steps_8(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Many steps of a robot of at most 8 joints; a status that is not DONE if there is one. Rows must fit."""
    return many(at_address(program), q, twist, beside, out, W8)


@kernel(*MANY_STEPS)
def steps_16(program: int, q: Array, twist: Array, beside: Array, out: Array) -> int:
    """Of at most 16 joints."""
    return many(at_address(program), q, twist, beside, out, W16)
