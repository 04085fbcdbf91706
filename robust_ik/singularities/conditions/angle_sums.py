"""Angle: one joint value, or a sum of several joints with parallel axes. Arrays only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.geometry.screw_chain import REFERENCE, ScrewChain

KEPT = 500
"""Most sets of angles whose joints are kept. Chosen: an atlas has some 30; a few hundred bytes each."""
PARALLEL = 1e-9
"""Axes are parallel if 1 − |cos| of their angle is less than this."""

ROUNDING = 1e-9
"""Part of a period by which a difference may be over half of it. Chosen: a few radians carry rounding of some 1e-15."""


@dataclass(frozen=True, order=True)
class Angle:
    """Σ sign · q_joint: a joint's value, or an integer combination of several.

    Attributes:
        joints: Indices from 0, ascending.
        signs: 1 or −1 for each.
        period: Change after which the pose is the same again; infinite for a joint that slides.
    """

    joints: tuple[int, ...]
    signs: tuple[int, ...]
    period: float

    def of(self, values: Array) -> Array:
        """Its value at joint values (..., n), (...); not wrapped."""
        return np.asarray(sum(sign * values[..., joint] for joint, sign in zip(self.joints, self.signs)))

    def row(self, n: int) -> Array:
        """Its derivatives with respect to the n joint values, (n,)."""
        row = np.zeros(n)
        row[list(self.joints)] = self.signs
        return row

    def wrapped(self, difference: Array | float) -> Array:
        """A difference of two of its values, the short way round: an angle in (−π, π]."""
        return wrapped(difference, self.period)

    @property
    def circular(self) -> bool:
        """Whether it is an angle, not a length."""
        return bool(np.isfinite(self.period))

    def __str__(self) -> str:
        first, *others = (f"{'−' if sign < 0 else '+'} q{joint + 1}" for joint, sign in zip(self.joints, self.signs))
        return " ".join([first.removeprefix("+ ").replace("− ", "−"), *others])

    @property
    def suffix(self) -> str:
        """Its name after c and s: "3" in c3, "23" in c23, "(2−3)" in c(2−3)."""
        names = [str(joint + 1) for joint in self.joints]
        if all(sign > 0 for sign in self.signs) and all(len(name) == 1 for name in names):
            return "".join(names)
        first, *others = (f"{'−' if sign < 0 else '+'}{name}" for name, sign in zip(names, self.signs))
        text = "".join([first.removeprefix("+"), *others])
        return text if len(names) == 1 and first[0] == "+" else f"({text})"


def wrapped(difference: Array | float, period: Array | float) -> Array:
    """Differences the short way round, in (−period/2, period/2]; unchanged if the period is infinite."""
    if isinstance(difference, float) and isinstance(period, float) and math.isfinite(difference):  # quicker than arrays
        turns = math.ceil(difference / period - 0.5 - ROUNDING) if math.isfinite(period) else 0
        return np.asarray(difference - turns * period if turns else difference)
    finite = np.isfinite(period)
    if not finite.all():
        return np.where(finite, wrapped(difference, np.where(finite, period, 1.0)), difference)
    return np.asarray(difference - np.ceil(np.asarray(difference) / period - 0.5 - ROUNDING) * period)


def brought(values: Array, angles: Sequence[Angle], to: Array) -> Array:
    """Joint values (N, n) changed so that all the angles have given values, by a joint for each of them.

    Angles may share joints, as q2 − q4 and q2 + q3 + q4 do: then all are changed together. An angle that the others
    determine is left as it is.

    Args:
        values: Joint values, (N, n).
        angles: The angles.
        to: What they should be, (angles,) or (N, angles).
    """
    values = np.array(values, dtype=float)
    kept, joints, rows, periods = _by_joint(tuple(angles), values.shape[-1])
    if not kept:
        return values
    errors = wrapped(np.asarray(to)[..., kept] - values @ rows.T, periods)
    square = rows[:, joints]
    alone = np.array_equal(square, np.eye(len(kept)))
    values[..., joints] += errors if alone else np.linalg.solve(square, errors[..., None])[..., 0]
    return values


@lru_cache(maxsize=KEPT)
def _by_joint(angles: tuple[Angle, ...], n: int) -> tuple[list[int], list[int], Array, Array]:
    """Which angles are independent, a joint for each of them, their rows, (kept, n), and their periods, (kept,)."""
    rows = np.array([angle.row(n) for angle in angles]).reshape(-1, n)
    kept, joints, left = [], [], rows.copy()
    for index in range(len(angles)):
        able = np.flatnonzero(np.abs(left[index]) > 0.5)
        if not able.size:
            continue
        joint = int(able[-1])
        kept.append(index)
        joints.append(joint)
        left[index + 1 :] -= np.outer(left[index + 1 :, joint] / left[index, joint], left[index])
    return kept, joints, readonly(rows[kept]), readonly([angles[index].period for index in kept])


def single(chain: ScrewChain, joint: int) -> Angle:
    """The value of one joint."""
    return Angle((joint,), (1,), float(chain.period[joint]))


def candidates(chain: ScrewChain, joints: Sequence[int], values: Array) -> list[Angle]:
    """The angles in which a relation of some joints may be written: each joint, and sums over runs of parallel axes.

    Args:
        chain: What moves the tip.
        joints: Indices of the joints, ascending.
        values: Configurations of one stratum, (N, n): axes count as parallel if they are at all of them.
    """
    found = [single(chain, joint) for joint in joints]
    if not chain.is_serial:
        return found
    axes = chain.joints.jacobians(values, REFERENCE)[:, 3:].transpose(2, 0, 1)
    for i, j in combinations(range(len(joints)), 2):
        run = list(joints[i : j + 1])
        cosines = np.einsum("jni,ni->jn", axes[run], axes[run[0]])
        signs = np.sign(cosines[:, 0])
        if np.all(np.abs(cosines - signs[:, None]) < PARALLEL) and np.all(signs != 0):
            found.append(Angle(tuple(run), tuple(int(sign) for sign in signs), float(chain.period[run[0]])))
    return found
