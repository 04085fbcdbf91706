"""The Jacobian in a link's frame, as polynomials in cosines and sines of joints and in lengths of slides.

Column i is (p × w, w) for the axis w through p, both in the frame of link k, and (w, 0) for a slide along w. In this
frame columns k and k + 1 are constant, and every other column depends only on the joints in between; the rank is the
same as in any other frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from robust_ik.certificates.proof.case_tree import State
from robust_ik.certificates.prover.exact_arm import ExactArm, is_frame_free
from robust_ik.certificates.prover.number_fields import poly
from robust_ik.certificates.prover.rational_matrices import Matrix, Vector, cross, minus, plus, times, transpose, turn
from robust_ik.certificates.prover.rational_matrices import apply as rotate
from robust_ik.certificates.prover.trig_polynomials import Pins, Trig
from robust_ik.kinematics.twist_rows import ROWS


def middle_links(arm: ExactArm) -> list[int]:
    """Links to try, the middle one first; only the base if the rank depends on the frame."""
    if not is_frame_free(arm.rows):
        return [0]
    count = len(arm.motions)
    return sorted(range(1, count), key=lambda k: (abs(2 * k - count), k)) or [0]


Placed = tuple[Matrix, Vector]
"""The axes of a joint's frame as columns, and its origin."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of the Jacobian in the frame of a link, cached: each depends only on the pins in between.

    Attributes:
        arm: The arm.
        link: The link, from 1 to n; 0 for the base.
        known: Results worked out so far, by what they depend on.
    """

    arm: ExactArm
    link: int
    known: dict[tuple[object, ...], Any] = field(default_factory=dict, repr=False)

    def jacobian(self, trig: Trig, state: State) -> list[list[Any]]:
        """The task rows, entries reduced.

        Args:
            trig: The ring of the entries.
            state: The conditions, whose pins fix joints.
        """
        now = _Now(self, trig, state, {pin.joint: (poly(pin.x), poly(pin.y)) for pin in state.pins})
        columns: list[list[Any]] = [[] for _ in range(self.arm.n)]
        for place, (joint, factor) in enumerate(self.arm.motions):
            column, rate = now.column(place), trig.constant(factor)
            moved = column if factor == 1 else [rate * value for value in column]
            columns[joint] = [a + b for a, b in zip(columns[joint], moved)] if columns[joint] else moved
        return [list(row) for row in zip(*columns)]


@dataclass(frozen=True, eq=False)
class _Now:
    """The frames of an arm in one state.

    Attributes:
        columns: The cached columns.
        trig: The ring of the entries.
        state: The conditions.
        pins: Its pins.
    """

    columns: Columns
    trig: Trig
    state: State
    pins: Pins

    def _remembered(self, what: str, index: int, first: int, last: int, made: Callable[[int], Any]) -> Any:
        """A value that depends only on the pins of what moves from first to last − 1, computed once."""
        moving = {joint for joint, _ in self.columns.arm.motions[first:last]}
        between = tuple(pin for pin in self.state.pins if pin.joint in moving)
        # An element of the field is a polynomial in its θ: without a pin there is no θ.
        key = (what, index, between, self.state.field if between else None)
        if key not in self.columns.known:
            self.columns.known[key] = made(index)
        return self.columns.known[key]

    def column(self, joint: int) -> list[Any]:
        """The task rows of the column of one motion."""
        whole, link = set(self.columns.arm.rows) == set(ROWS), self.columns.link
        last = max(joint, link) if whole else len(self.columns.arm.motions)
        column: list[Any] = self._remembered("column", joint, min(joint + 1, link), last, self._column)
        return column

    def _column(self, joint: int) -> list[Any]:
        arm, zero = self.columns.arm, self.trig.context.constant(0)
        origin = (zero, zero, zero)
        reference = origin if set(arm.rows) == set(ROWS) else self.outwards(len(arm.motions))[1]
        rotation, point = self.outwards(joint) if joint >= self.columns.link else self.inwards(joint)
        axis = tuple(row[2] for row in rotation)
        twist = (
            (*axis, *origin) if arm.motions[joint][0] in arm.sliding else (*cross(axis, minus(reference, point)), *axis)
        )
        both = [self.trig.reduce(value) for value in twist]
        return [both[ROWS.index(name)] for name in arm.rows]

    def outwards(self, joint: int) -> Placed:
        """The frame of a motion after the link, before it moves; the tip's for the number of motions."""
        placed: Placed = self._remembered("outwards", joint, self.columns.link, joint, self._outwards)
        return placed

    def _outwards(self, joint: int) -> Placed:
        trig, (R, p) = self.trig, self._placement(joint)
        rotation, point = self._start
        if joint > self.columns.link:
            rotation, point = self.outwards(joint - 1)
            motion, slide = _motion(self.columns.arm, joint - 1, trig, self.pins)
            point = plus(point, rotate(rotation, slide))
            rotation = tuple(_reduced(trig, row) for row in times(rotation, motion))
        return times(rotation, R), _reduced(trig, plus(point, rotate(rotation, p)))

    def inwards(self, joint: int) -> Placed:
        """The frame of a motion before the link, after it has moved."""
        placed: Placed = self._remembered("inwards", joint, joint + 1, self.columns.link, self._inwards)
        return placed

    def _inwards(self, joint: int) -> Placed:
        if joint == self.columns.link - 1:
            return self._start
        trig, after = self.trig, joint + 1
        (rotation, point), (R, p) = self.inwards(after), self._placement(after)
        motion, slide = _motion(self.columns.arm, after, trig, self.pins)
        point = minus(point, rotate(rotation, slide))
        rotation = tuple(_reduced(trig, row) for row in times(rotation, transpose(times(R, motion))))
        return rotation, _reduced(trig, minus(point, rotate(rotation, p)))

    @property
    def _start(self) -> Placed:
        zero, one = self.trig.context.constant(0), self.trig.context.constant(1)
        return ((one, zero, zero), (zero, one, zero), (zero, zero, one)), (zero, zero, zero)

    def _placement(self, joint: int) -> Placed:
        """The constant transform before a joint."""
        R, p = self.columns.arm.placements[joint]
        constant = self.trig.constant
        return tuple(tuple(constant(a) for a in row) for row in R), tuple(constant(a) for a in p)


def _motion(arm: ExactArm, place: int, trig: Trig, pins: Pins) -> tuple[Matrix, Vector]:
    """The motion of a frame: a rotation about z and a translation along z, one of them trivial."""
    zero, one = trig.context.constant(0), trig.context.constant(1)
    joint, factor = arm.motions[place]
    if joint in arm.sliding:
        return turn(2, one, zero), (zero, zero, trig.constant(factor) * trig.length(joint, pins))
    c, s = trig.angle(joint, pins)
    for _ in range(1, abs(int(factor))):  # twice as fast at most
        c, s = trig.reduce(c * c - s * s), trig.reduce(2 * c * s)
    return turn(2, c, s if factor > 0 else -s), (zero, zero, zero)


def _reduced(trig: Trig, values: Vector) -> Vector:
    return tuple(trig.reduce(value) for value in values)
