"""Obstacles around a robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_parameter, checked_rigid, readonly
from robust_ik.description.joint_tree import Box, Cylinder, Sphere
from robust_ik.errors import InputError

LARGEST = 1e6
"""Largest coordinate, m: beyond it distances are lost in rounding."""


@dataclass(frozen=True)
class HalfSpace:
    """Everything below a plane: the points x with normal · x ≤ offset. A table top, a floor, a wall.

    Attributes:
        normal: The direction out of it, of any length but 0; it is stored with length 1.
        offset: Height of the plane along the normal of length 1, m.
    """

    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    offset: float = 0.0

    def __post_init__(self) -> None:
        normal = as_measures(self.normal, "normal", (3,))
        length = float(np.linalg.norm(normal)) if normal.shape == (3,) else 0.0
        if not 1e-9 < length < 1e9:
            raise InputError(f"normal must be three numbers of a length between 1e-9 and 1e9, got {self.normal!r}")
        x, y, z = (normal / length).tolist()
        object.__setattr__(self, "normal", (x, y, z))
        object.__setattr__(self, "offset", checked_parameter("offset", self.offset, above=-LARGEST, below=LARGEST))


ObstacleShape = Box | Sphere | Cylinder | HalfSpace


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A solid that does not move.

    Attributes:
        name: Its name; no link of the robot may have it.
        shape: `Box`, `Sphere` or `Cylinder`, about the origin of its placement, or a `HalfSpace`.
        placement: Its pose in the world, (4, 4), m.
    """

    name: str
    shape: ObstacleShape
    placement: Array = field(default_factory=lambda: np.eye(4))

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"an obstacle needs a name, got {self.name!r}")
        _check_shape(self.name, self.shape)
        object.__setattr__(self, "placement", _checked_placement(self.name, self.placement))

    def __reduce__(self) -> tuple[object, ...]:
        # Through the constructor, since copies must be read-only too.
        return Obstacle, (self.name, self.shape, self.placement)


def _check_shape(name: str, shape: object) -> None:
    match shape:
        case Box(size):
            lengths: tuple[object, ...] = tuple(size) if isinstance(size, (tuple, list)) and len(size) == 3 else (None,)
        case Sphere(radius):
            lengths = (radius,)
        case Cylinder(radius, length):
            lengths = (radius, length)
        case HalfSpace():
            return
        case _:
            raise InputError(f"obstacle {name!r} must be a Box, Sphere, Cylinder or HalfSpace, got {shape!r}")
    if not all(isinstance(each, Real) and 0 < float(each) <= LARGEST for each in lengths):
        raise InputError(f"the sizes of obstacle {name!r} must be over 0 and at most {LARGEST:g} m, got {shape!r}")


def _checked_placement(name: str, placement: ArrayLike) -> Array:
    T = checked_rigid(placement, f"the placement of obstacle {name!r}")
    if T.shape != (4, 4) or (np.abs(T) > LARGEST).any():
        raise InputError(f"the placement of obstacle {name!r} must be one (4, 4) pose within {LARGEST:g} m")
    return readonly(T)
