"""Tolerance: how far the numbers of an arm may be from the coincidences that they were meant to have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from robust_ik.description.urdf import last_places

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

ANGLE = 1e-4
"""Angles this close to a multiple of π/12 are replaced by it, rad."""
SHORT = 2e-5
"""Lengths this close to zero or to each other are made so, m, for an arm of usual size.

Chosen: what five decimals of a metre leave of a length that was added up from a few; no arm of the catalogue is offset
by so little on purpose.
"""
GRAINS = 1.5
"""Numbers that are written to the millimetre are added up from a few, each off by half of it: three of them."""
COARSEST = 2e-3
"""Largest change of an angle, rad, or of a length of an arm of usual size, m, however coarsely it is written.

Chosen: three decimals are the fewest of files that are met; lengths in whole centimetres are meant so.
"""
TILTED, OFFSET = 1e-2, 1e-3
"""Angles, rad, and lengths, m for an arm of usual size, that designs leave of coincidences: tilts of half a degree and
offsets below a millimetre. An arm that lacks so little is nearly singular where the other one is singular.
"""


@dataclass(frozen=True)
class Tolerance:
    """How far numbers may be from what they are meant to be.

    Attributes:
        angle: Largest change of an angle, rad.
        short: Largest length that is meant to be zero, m.
        alike: Largest difference of lengths that are meant to be alike, m.
        place: Place of the last digit of lengths, m: those that are written as they are differ by it on purpose; 0 if
            lengths are written so finely that they do not.
    """

    angle: float
    short: float
    alike: float
    place: float = 0.0

    @classmethod
    def of(cls, robot: Robot) -> Tolerance:
        """What rounding leaves at all, or what the digits leave with which the robot's file is written."""
        joints = {joint.name for joint in robot.description.chain(str(robot.tip))}
        length, angle = last_places(robot.description.xml, joints)
        unit = robot.length_scale
        place = length if SHORT * unit < length <= COARSEST * unit else 0.0
        short = max(SHORT * unit, GRAINS * place + angle * min(robot.size, unit))
        return cls(
            angle=min(max(ANGLE, GRAINS * angle), COARSEST),
            short=min(short, COARSEST * unit),
            alike=max(SHORT * unit, GRAINS * place),
            place=place,
        )

    def widened(self, unit: float) -> Tolerance:
        """That of an arm whose coincidences are not exact by design.

        Args:
            unit: The arm's unit of length, m.
        """
        short, alike = max(self.short, OFFSET * unit), max(self.alike, OFFSET * unit)
        return Tolerance(max(self.angle, TILTED), short, alike)
