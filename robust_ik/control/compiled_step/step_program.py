"""The program of a step for compiled code, and functions that replace it if an inverse is not compiled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, is_plain, readonly
from robust_ik.inverses import EDLS, DampedLeastSquares, RobustInverse, SecondOrder, SingularValueFilter, Weighted
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.step import step_layout as slots
from robust_ik.kernels.step.step_layout import DONE, TOO_LARGE, UNLIKE
from robust_ik.kinematics.chain import Chain, number_of
from robust_ik.kinematics.svd import null_projector
from robust_ik.kinematics.twist_rows import ROWS

MOST_JOINTS = 16
"""Most joints of a compiled step; robots with more are stepped in Python. As many as the largest kernel,
`compiled.step_16`, has room for."""

EXTREME = 1e30
"""Weights beyond this, or below its inverse, are left to Python, which avoids overflow."""

Step = Callable[..., int]
"""(address, q, twist, out) or (address, q, twist, secondary, out) → status."""


@dataclass(frozen=True, eq=False)
class Program:
    """The functions that make a step; their first argument is an address, and they return a status, 0 for success.

    Compiled functions, and those with Python gains only, return UNLIKE for arguments that are not contiguous doubles of
    the right number.

    Attributes:
        n: Number of joints.
        nq: Length of q.
        m: Number of task rows.
        compiled: Whether a step is one compiled call.
        careful: Whether `step` and `step_beside` check their arguments themselves.
        written: The program for compiled code.
        step: (setup, q, twist, out).
        step_beside: (setup, q, twist, secondary, out).
        steps: (address, q, twists, secondary or no rows of it, out), one step a row.
    """

    n: int
    nq: int
    m: int
    compiled: bool
    careful: bool
    written: Array
    step: Step
    step_beside: Step
    steps: Step

    @classmethod
    def of(cls, chain: Chain, inverse: RobustInverse, reference: str, rows: Sequence[str]) -> Program:
        """The program of a chain and an inverse."""
        size = chain.n, chain.nq, len(rows)
        number_of(reference)  # raises for an unknown reference
        inner, task, joints = _unwrapped(inverse, len(rows), chain.n)
        if chain.n <= MOST_JOINTS and type(inner) is SecondOrder:
            written = _written(chain, inner, inner.parameters(0.0), reference, rows, task, joints)
            return cls(*size, True, True, written, *_curved(chain.n))
        if chain.n > MOST_JOINTS or not _rewrites_only_sigma(inner):
            return cls(*size, False, False, np.empty(0), *_in_python(chain, inverse, reference, rows))
        address = _address(inner)
        parameters = np.array(inner.parameters if isinstance(inner, GainFormula) else (), dtype=float)
        written = _written(chain, inner, parameters, reference, rows, task, joints, address or 0)
        if address is not None:
            return cls(*size, True, True, written, *_compiled(chain.n))
        many = _in_python(chain, inverse, reference, rows)[-1]
        return cls(*size, False, True, written, *_half_compiled(inner, size, joints), many)

    @property
    def address(self) -> int:
        """Address of the program; it stays valid as long as this object exists."""
        return int(self.written.ctypes.data)

    @cached_property
    def addresses(self) -> NDArray[np.int64]:
        """Addresses of NumPy's array class, of the program and of None: `step` gets the address of this array."""
        return np.array([id(np.ndarray), self.address, id(None)])


def _unwrapped(inverse: RobustInverse, m: int, n: int) -> tuple[RobustInverse, Array | None, Array | None]:
    """The inverse inside Weighted, and the factors of task and joints; None for factors that are not there."""
    if not isinstance(inverse, Weighted):
        return inverse, None, None
    task, joints = inverse.factors(m, n)
    sizes = np.abs(np.concatenate([np.linalg.eigvalsh(task), np.linalg.eigvalsh(joints)]))
    if sizes.max() > EXTREME or sizes.min() < 1 / EXTREME:
        return inverse, None, None
    scaled = inverse.task_weights is not None or inverse.length_scale is not None
    return inverse.inverse, task if scaled else None, joints if inverse.joint_weights is not None else None


def _rewrites_only_sigma(inverse: RobustInverse) -> TypeGuard[SingularValueFilter]:
    """Whether an inverse is fully described by its `gains`."""
    if not isinstance(inverse, SingularValueFilter) or inverse.needs_hessian:
        return False
    kind = type(inverse)
    plain = kind.velocity is RobustInverse.velocity or isinstance(inverse, EDLS)
    return plain and kind.solve is SingularValueFilter.solve and kind.begin is RobustInverse.begin


def _address(inverse: SingularValueFilter) -> int | None:
    """The address of the compiled formula; None if there is none or it cannot be compiled."""
    if not isinstance(inverse, GainFormula) or type(inverse).gains is not GainFormula.gains:
        return None
    from robust_ik.kernels.compiler.gain_callbacks import address_of

    return address_of(type(inverse).formula)


def _written(
    chain: Chain,
    inverse: RobustInverse,
    parameters: Array,
    reference: str,
    rows: Sequence[str],
    task: Array | None,
    joints: Array | None,
    address: int = 0,
) -> Array:
    """The program for the kernel; see `kernels.step.step_layout`."""
    head = np.zeros(slots.HEAD)
    head[slots.ROWS] = len(rows)
    head[slots.ROW : slots.ROW + len(rows)] = [ROWS.index(row) for row in rows]
    head[slots.METHOD], head[slots.ADDRESS], head[slots.REFERENCE] = slots.FORMULA, address, number_of(reference)
    if type(inverse) is DampedLeastSquares:
        head[slots.METHOD], head[slots.DAMPING] = slots.DAMPED, inverse.squared_damping
    parts: list[Array] = [head]

    def add(place: int, part: Array) -> None:
        head[place] = sum(map(len, parts))
        parts.append(part)

    add(slots.PARAMETERS, parameters)
    if task is not None:
        add(slots.TASK, task.ravel())
    if joints is not None:
        add(slots.JOINTS, np.concatenate([joints.ravel(), np.linalg.inv(joints).ravel()]))
    add(slots.CHAIN, chain.packed)
    return readonly(np.concatenate(parts))


def _compiled(n: int) -> tuple[Step, Step, Step]:
    from robust_ik.kernels.step import beside_8, beside_16, step_8, step_16, steps_8, steps_16

    step, beside, steps = (step_8, beside_8, steps_8) if n <= 8 else (step_16, beside_16, steps_16)
    return step.compiled, beside, steps  # the last two are compiled when they are first called


def _curved(n: int) -> tuple[Step, Step, Step]:
    """The compiled step of the second-order inverse; many are made one after another."""
    from robust_ik.kernels.step import curved_8, curved_16

    step = (curved_8 if n <= 8 else curved_16).compiled

    def steps(address: int, q: Array, twists: Array, secondary: Array, out: Array) -> int:
        setup = np.array([id(np.ndarray), address, id(None)])
        for e in range(len(q)):
            status = step(setup.ctypes.data, q[e], twists[e], secondary[e] if len(secondary) else None, out[e])
            if status:
                return int(status)
        return DONE

    return lambda setup, q, twist, out: step(setup, q, twist, None, out), step, steps


def _half_compiled(inverse: SingularValueFilter, size: tuple[int, int, int], joints: Array | None) -> tuple[Step, Step]:
    """Functions of which all but the gains is compiled."""
    from robust_ik.kernels.step import factor_8, factor_16

    n, _, m = size
    k = min(m, n)
    factor = (factor_8 if n <= 8 else factor_16).compiled
    back = None if joints is None else np.linalg.inv(joints)

    def beside(address: int, q: Array, twist: Array, secondary: Array | None, out: Array) -> int:
        if not is_plain(out, n) or not out.flags.writeable or not (secondary is None or is_plain(secondary, n)):
            return UNLIKE
        s, x, Vt = np.empty(k), np.empty(k), np.empty((k, n))
        status = factor(address, q, twist, s, x, Vt)
        if status:
            return int(status)
        found = (inverse.gains(s) * x) @ Vt
        if secondary is not None:
            rest = secondary if back is None else back @ secondary
            for v in Vt:
                rest = rest - (v @ rest) * v
            found = found + rest
        out[:] = found if joints is None else joints @ found
        return DONE if np.isfinite(out).all() else TOO_LARGE

    return lambda address, q, twist, out: beside(address, q, twist, None, out), beside


def _in_python(chain: Chain, inverse: RobustInverse, reference: str, rows: Sequence[str]) -> tuple[Step, Step, Step]:
    """Functions for any inverse: J is compiled, the inverse is called in Python."""
    chosen = [ROWS.index(row) for row in rows]

    def steps(_: int, q: Array, twist: Array, secondary: Array | None, out: Array) -> int:
        J = chain.jacobians(np.asarray(q, dtype=float), reference)[..., chosen, :]
        if inverse.needs_hessian:
            H = chain.hessians(np.asarray(q, dtype=float), reference)[..., chosen, :, :]
            found = inverse.velocity(TaskEquation(J, np.asarray(twist), np.zeros(np.shape(twist)), H))
        else:
            found = inverse.solve(J, twist)
        if secondary is not None and len(secondary):
            found = found + _beside(J, np.asarray(secondary, dtype=float))
        out[...] = found
        return DONE if np.isfinite(out).all() else TOO_LARGE

    def _beside(J: Array, secondary: Array) -> Array:
        if not isinstance(inverse, Weighted):
            return np.asarray((null_projector(J) @ secondary[..., None])[..., 0])
        task, joints = inverse.factors(*J.shape[-2:])
        scaled = null_projector(task @ J @ joints) @ (np.linalg.inv(joints) @ secondary[..., None])
        return np.asarray((joints @ scaled)[..., 0])

    return lambda address, q, twist, out: steps(address, q, twist, None, out), steps, steps
