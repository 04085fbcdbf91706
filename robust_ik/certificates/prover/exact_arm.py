"""ExactArm: a robot with rational lengths and directions, and a list of what was changed.

Theorems about singularities are theorems about this arm. Lengths are the decimals of the description. Angles close to
a multiple of a quarter turn are replaced by it, all others by a rational tan(α/2), so that every rotation is exactly
orthogonal. Nothing is changed silently: `ExactArm.changes` lists it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from lxml import etree

from robust_ik.certificates.prover.generic_rank import generic_rank
from robust_ik.certificates.prover.rational_matrices import (
    IDENTITY,
    ORIGIN,
    ZERO,
    Matrix,
    Vector,
    apply,
    plus,
    times,
    transpose,
    turn,
)
from robust_ik.description.joint_tree import MOVING_TYPES
from robust_ik.kinematics.twist_rows import ROWS

if TYPE_CHECKING:
    from robust_ik.description.joint_tree import Joint
    from robust_ik.kinematics.chain import Chain
    from robust_ik.robot.robot import Robot

LENGTH_DIGITS = 12
"""Decimals of a length in metres that are kept: further ones are rounding of floats."""
DENOMINATOR = 10**9
"""Largest denominator of tan(α/2) for other angles than multiples of a quarter turn. Chosen: errors are about 1e-18."""
NOISE = 1e-14
"""Smaller changes are rounding of the floats that were read, and are not reported."""
MULTIPLES = (1, 2)
"""How many times faster a joint may turn than the one that it follows, to and fro: cos 2q and sin 2q are polynomials in
cos q and sin q.
"""
Motions = tuple[tuple[int, Fraction], ...]
"""For each motion from the base to the tip, the index of its joint and the factor."""
QUARTERS = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""Cosine and sine of zero, one, two and three quarter turns."""


class UnsupportedError(Exception):
    """An arm that exact certificates cannot treat; the message says why."""


@dataclass(frozen=True)
class Change:
    """One number of the exact arm that differs from the description.

    Attributes:
        where: Joint whose origin or axis it is.
        what: "x", "y", "z", "roll", "pitch", "yaw" or "axis".
        given: The number in the description, m or rad.
        used: The number in the exact arm, m or rad.
    """

    where: str
    what: str
    given: float
    used: float

    @property
    def amount(self) -> float:
        """The change, m or rad."""
        return self.used - self.given

    def __str__(self) -> str:
        return f"{self.where} {self.what}: {self.given!r} → {self.used!r} (by {self.amount:.2e})"


@dataclass(frozen=True)
class ExactArm:
    """A serial arm in rational numbers, its tip at P₁ Z(p₁) P₂ Z(p₂) ⋯ Z(p_c) P_c₊₁; Z is a turn about z or a slide.

    Each p is the value of one of n joints, or follows one: p = factor · q.

    Attributes:
        name: The robot's name.
        joints: Names of the n joints.
        placements: The c + 1 constant transforms (rotation, translation), fractions.
        rows: Task rows, of x y z wx wy wz.
        changes: Differences from the description.
        sliding: Indices of the prismatic joints.
        motions: For each of the c motions from the base to the tip, the index of its joint and the factor; by default
            each joint moves once, by its value.
    """

    name: str
    joints: tuple[str, ...]
    placements: tuple[tuple[Matrix, Vector], ...]
    rows: tuple[str, ...]
    changes: tuple[Change, ...] = ()
    sliding: frozenset[int] = frozenset()
    motions: Motions = ()

    def __post_init__(self) -> None:
        if not self.motions:
            object.__setattr__(self, "motions", tuple((joint, Fraction(1)) for joint in range(len(self.joints))))

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @cached_property
    def rank(self) -> int:
        """g, the rank of its Jacobian nearly everywhere."""
        return generic_rank(self.placements, self.motions, self.sliding, self.rows)

    def shifted(self, tangents: tuple[Fraction, ...]) -> ExactArm:
        """The same arm with joint zeros moved: by 2 atan(tangents[i]) rad, or tangents[i] m for a sliding joint."""
        placements = list(self.placements)
        for (i, (joint, _)), u in zip(enumerate(self.motions), tangents):
            rotation, offset = placements[i]
            if joint in self.sliding:
                placements[i] = (rotation, plus(offset, apply(rotation, (ZERO, ZERO, u))))
            else:
                placements[i] = (times(rotation, turn(2, *half_angle(u))), offset)
        return replace(self, placements=tuple(placements))


def exact_arm(robot: Robot, snap: float = 1e-4) -> ExactArm:
    """The exact arm of a robot's chain to its tip.

    Args:
        robot: A chain of revolute, continuous and prismatic joints.
        snap: Angles this close to a multiple of a quarter turn are replaced by it, rad; 0 for none.

    Raises:
        UnsupportedError: There is no tip, or a joint of the chain follows another or has several degrees of freedom.
    """
    if robot.tip is None:
        raise UnsupportedError("the robot was loaded whole, without a tip")
    chain = robot.description.chain(robot.tip)
    for joint in chain:
        if joint.kind not in (*MOVING_TYPES, "fixed"):
            raise UnsupportedError(f"joint {joint.name!r} is {joint.kind}: not supported")
    moving, moves = [joint for joint in chain if joint.kind != "fixed"], robot.chain()
    if len(moving) != len(moves) or set(moves.column.tolist()) != set(range(robot.n)):
        raise UnsupportedError("joints that do not move the tip are not supported: load the chain to the tip")
    sliding = frozenset(np.flatnonzero(robot.sliding).tolist())
    motions = tuple(_motions(moving, moves, sliding))
    changes: list[Change] = []
    elements = {
        element.get("name"): element for element in etree.fromstring(robot.description.xml.encode()).findall("joint")
    }
    digits = _digits(robot.length_scale)
    steps = [(joint.name, _Reading(elements[joint.name], snap, digits, changes)) for joint in chain]
    zeros = {joint.name: float(shift) for joint, shift in zip(moving, moves.shift)}
    placements = tuple(_placements(steps, zeros))
    return ExactArm(robot.name, robot.joint_names, placements, robot.rows, tuple(changes), sliding, motions)


def _motions(moving: Sequence[Joint], moves: Chain, sliding: frozenset[int]) -> Iterator[tuple[int, Fraction]]:
    """For each joint that moves the tip, the joint that it follows, and how fast.

    Raises:
        UnsupportedError: No polynomial in the cosine and sine of that joint, or in its length, says so.
    """
    for joint, source, slides, factor in zip(moving, moves.column.tolist(), moves.sliding, moves.factor.tolist()):
        alike = bool(slides) == (source in sliding)
        if not alike or not (factor != 0 if slides else abs(factor) in MULTIPLES):
            leader = "another" if joint.mimic is None else repr(joint.mimic.source)
            raise UnsupportedError(f"joint {joint.name!r} follows {leader} {factor:g}-fold: not supported")
        yield source, Fraction(repr(factor))


def _placements(steps: list[tuple[str, _Reading]], zeros: Mapping[str, float]) -> Iterator[tuple[Matrix, Vector]]:
    """The constant transforms between the motions, with z along every joint's axis.

    Args:
        steps: All joints of the chain.
        zeros: For each joint that moves the tip, its motion with what it follows at zero, rad or m.
    """
    rotation, offset = IDENTITY, ORIGIN
    for name, reading in steps:
        offset = plus(offset, apply(rotation, reading.offset()))
        rotation = times(rotation, reading.rotation())
        if name in zeros:
            aligned = reading.alignment()
            yield times(rotation, aligned), offset
            turned, offset = reading.zero(zeros[name])
            rotation = times(turned, transpose(aligned))
    yield rotation, offset


@dataclass(frozen=True)
class _Reading:
    """Reads one joint element into exact numbers, and notes changes."""

    element: Any
    snap: float
    digits: int
    changes: list[Change]

    def offset(self) -> Vector:
        """The origin's translation."""
        return tuple(self._length(name, value) for name, value in zip("xyz", self._numbers("origin", "xyz", 0.0)))

    def rotation(self) -> Matrix:
        """The origin's rotation, Rz(yaw) Ry(pitch) Rx(roll)."""
        angles = zip(("roll", "pitch", "yaw"), self._numbers("origin", "rpy", 0.0))
        roll, pitch, yaw = (self._angle(name, value) for name, value in angles)
        return times(times(turn(2, *yaw), turn(1, *pitch)), turn(0, *roll))

    def alignment(self) -> Matrix:
        """A rotation that takes z to the joint's axis."""
        x, y, z = self._numbers("axis", "xyz", 1.0)
        tilt = math.atan2(math.hypot(x, y), z)
        heading = math.atan2(y, x) if math.hypot(x, y) > 1e-15 else 0.0
        if not min(tilt, math.pi - tilt) > self.snap:
            heading = 0.0
        return times(turn(2, *self._angle("axis", heading)), turn(1, *self._angle("axis", tilt)))

    def zero(self, shift: float) -> tuple[Matrix, Vector]:
        """The turn about z, or the shift along it, of a joint with what it follows at zero, rad or m."""
        if shift == 0:
            return IDENTITY, ORIGIN
        if self.element.get("type") == "prismatic":
            return IDENTITY, (ZERO, ZERO, self._length("offset", shift))
        return turn(2, *self._angle("offset", shift)), ORIGIN

    def _numbers(self, tag: str, attribute: str, default: float) -> tuple[float, ...]:
        child = self.element.find(tag)
        written = None if child is None else child.get(attribute)
        return (default, 0.0, 0.0) if written is None else tuple(float(word) for word in written.split())

    def _note(self, what: str, given: float, used: float) -> None:
        if abs(used - given) > NOISE:
            self.changes.append(Change(self.element.get("name"), what, given, used))

    def _length(self, what: str, value: float) -> Fraction:
        exact = round(Fraction(repr(value)), self.digits)
        self._note(what, value, float(exact))
        return exact

    def _angle(self, what: str, value: float) -> tuple[Fraction, Fraction]:
        quarter = round(value / (math.pi / 2))
        if abs(value - quarter * (math.pi / 2)) <= max(self.snap, NOISE):
            self._note(what, value, quarter * (math.pi / 2))
            c, s = QUARTERS[quarter % 4]
            return Fraction(c), Fraction(s)
        tangent = Fraction(math.tan(value / 2)).limit_denominator(DENOMINATOR)
        used = 2 * math.atan(tangent)
        self._note(what, value, used + 2 * math.pi * round((value - used) / (2 * math.pi)))
        return half_angle(tangent)


def arm_of_moves(
    name: str,
    joints: tuple[str, ...],
    rows: tuple[str, ...],
    moves: Sequence[Sequence[tuple[str, int, float]]],
    unit: float,
    sliding: frozenset[int] = frozenset(),
) -> ExactArm:
    """The exact arm from turns and shifts between its joints.

    Args:
        name: The robot's name.
        joints: Its joints.
        rows: Task rows.
        moves: Those from the base to the first joint's frame, from each joint's to the next one's, and to the tip: a
            "turn" about x, y or z (0, 1 or 2), or a "shift" along it, rad or m.
        unit: The arm's unit of length, m.
        sliding: Indices of the prismatic joints.
    """
    digits, placements = _digits(unit), []
    for each in moves:
        rotation, offset = IDENTITY, ORIGIN
        for kind, axis, value in each:
            if kind == "turn":
                rotation = times(rotation, turn(axis, *rational(value)))
            else:
                along = round(Fraction(value), digits)
                offset = plus(offset, tuple(row[axis] * along for row in rotation))
        placements.append((rotation, offset))
    return ExactArm(name, joints, tuple(placements), rows, sliding=sliding)


def rational(angle: float, snap: float = NOISE) -> tuple[Fraction, Fraction]:
    """Rational cosine and sine of an angle, with an error of about 1e-18; exact within `snap` of quarter turns."""
    quarter = round(angle / (math.pi / 2))
    if abs(angle - quarter * (math.pi / 2)) <= snap:
        c, s = QUARTERS[quarter % 4]
        return Fraction(c), Fraction(s)
    return half_angle(Fraction(math.tan(angle / 2)).limit_denominator(DENOMINATOR))


def _digits(unit: float) -> int:
    """How many decimals of a metre are kept of lengths of an arm with this unit of length."""
    return LENGTH_DIGITS - math.floor(math.log10(unit))


def half_angle(tangent: Fraction) -> tuple[Fraction, Fraction]:
    """Cosine and sine of the angle with this tan(α/2)."""
    square = tangent * tangent
    return (1 - square) / (1 + square), 2 * tangent / (1 + square)


def is_frame_free(rows: tuple[str, ...]) -> bool:
    """Whether the rank of those task rows is the same in every frame: all six, the position or the orientation."""
    return set(rows) in (set(ROWS), set(ROWS[:3]), set(ROWS[3:]))
