"""Writes the functions that Numba's library has in C for math.frexp and math.ldexp, so that that library is not needed.

They differ from C's where C leaves the result open: for numbers that are not finite.
"""

from __future__ import annotations

import math

from llvmlite import ir

DOUBLE, INT = ir.DoubleType(), ir.IntType(32)


def write_frexp(module: ir.Module) -> None:
    """numba_frexp(x, exponent): C's, but x and 0 if x is 0 or not finite."""
    made = ir.Function(module, ir.FunctionType(DOUBLE, [DOUBLE, INT.as_pointer()]), "numba_frexp")
    builder = ir.IRBuilder(made.append_basic_block())
    x, exponent = made.args
    found = builder.call(ir.Function(module, made.function_type, "frexp"), made.args)
    plain = _plain(builder, x)
    builder.store(builder.select(plain, builder.load(exponent), INT(0)), exponent)
    builder.ret(builder.select(plain, found, x))


def write_ldexp(module: ir.Module) -> None:
    """numba_ldexp(x, exponent): C's, but x if x is 0 or not finite."""
    made = ir.Function(module, ir.FunctionType(DOUBLE, [DOUBLE, INT]), "numba_ldexp")
    builder = ir.IRBuilder(made.append_basic_block())
    found = builder.call(ir.Function(module, made.function_type, "ldexp"), made.args)
    builder.ret(builder.select(_plain(builder, made.args[0]), found, made.args[0]))


def _plain(builder: ir.IRBuilder, x: ir.Value) -> ir.Value:
    """Whether a number is finite and not 0: |x| is neither 0, inf nor NaN."""
    size = builder.call(builder.module.declare_intrinsic("llvm.fabs", [DOUBLE]), [x])
    below = builder.fcmp_ordered("<", size, DOUBLE(math.inf))
    return builder.and_(below, builder.fcmp_ordered(">", size, DOUBLE(0.0)))
