"""A lost direction as a wrench screw, independent of units and frames: the wrench that the structure bears by itself.

A direction u in which the tool cannot move, uᵀJ = 0, is also a wrench that loads no joint: the lost twist and the
wrench that is borne have the same six numbers. As a wrench it is a screw: an axis in space and a pitch, for any
reference point and unit of length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array, as_array, readonly
from robust_ik.errors import InputError

COUPLE = 1e-9
"""A force below this fraction of the moment, per metre, counts as zero: the wrench is a pure couple."""


@dataclass(frozen=True, eq=False)
class WrenchScrew:
    """A wrench up to its size.

    Attributes:
        axis: Unit direction of the force, or of the couple, world axes, (3,).
        pitch: Moment along the axis over force, m/rad; 0 for a pure force, infinite for a couple.
        point: The point of the axis that is nearest to the world's origin, (3,), m; NaN for a couple, which has none.
    """

    axis: Array
    pitch: float
    point: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", readonly(self.axis))
        object.__setattr__(self, "point", readonly(self.point))

    @classmethod
    def of(cls, wrench: Array, reference: Array) -> WrenchScrew:
        """The screw of a wrench.

        Args:
            wrench: Force, then moment about `reference`, world axes, (6,); not zero.
            reference: The point about which the moment is taken, the tool's for example, (3,), m.

        Source: Ball 1900.
        """
        wrench, reference = as_array(wrench, "wrench", (6,)), as_array(reference, "reference", (3,))
        force, moment = wrench[:3], wrench[3:]
        size, turn = float(np.linalg.norm(force)), float(np.linalg.norm(moment))
        if size == turn == 0:
            raise InputError("wrench must not be zero")
        if size <= COUPLE * turn:
            return cls(_positive(moment / turn), np.inf, np.full(3, np.nan))
        axis = force / size
        point = reference + np.cross(force, moment) / size**2
        return cls(_positive(axis), float(force @ moment) / size**2, point - (point @ axis) * axis)

    @property
    def is_force(self) -> bool:
        """Whether it is a pure force along a line."""
        return abs(self.pitch) < 1e-6

    @property
    def is_couple(self) -> bool:
        """Whether it is a pure couple, which has a direction and no line."""
        return bool(np.isinf(self.pitch))

    def distance(self, point: Array) -> float:
        """The distance of a point from the axis, m; NaN for a couple."""
        return float(np.linalg.norm(np.cross(self.axis, np.asarray(point) - self.point)))


def _positive(axis: Array) -> Array:
    """The axis with its largest entry positive: a screw and its opposite are the same."""
    return np.asarray(axis if axis[np.abs(axis).argmax()] > 0 else -axis)
