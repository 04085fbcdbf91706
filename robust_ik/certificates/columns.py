"""The Jacobian in a link's frame, as polynomials in the cosines and sines of the joints, and the lengths of slides.

Column i is (p × w, w) for the axis w through p, both in the frame of link k, and (w, 0) for a slide along w. There the
columns k and k + 1 are constant and every other one depends only on the joints between; the rank is that in any other
frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx

from robust_ik.certificates.cases import State
from robust_ik.certificates.exact_model import ExactArm, is_frame_free
from robust_ik.certificates.fields import Field, poly
from robust_ik.certificates.rational import Matrix, Vector, cross, minus, plus, times, transpose, turn
from robust_ik.certificates.rational import apply as rotate
from robust_ik.rows import ROWS

Pins = Mapping[int, tuple[Any, Any]]
"""Joint index → (x, y), elements of a field: (cos q/2 : sin q/2), or (1, d), of a joint that stands still."""


@dataclass(frozen=True)
class Trig:
    """ℚ(θ)[cᵢ, sᵢ] with sᵢ² = 1 − cᵢ²: variables s₁ … sₙ, c₁ … cₙ, z for θ.

    For a sliding joint sᵢ is its length dᵢ, which satisfies no equation, and cᵢ does not occur.

    Attributes:
        n: Number of joints.
        field: ℚ(θ).
        sliding: The prismatic joints.
    """

    n: int
    field: Field
    sliding: frozenset[int] = frozenset()

    @cached_property
    def context(self) -> Any:
        """The polynomials that stand for the elements."""
        names = [f"s{i}" for i in range(self.n)] + [f"c{i}" for i in range(self.n)] + ["z"]
        return fmpq_mpoly_ctx.get(names, Ordering.lex)

    @cached_property
    def _relations(self) -> list[Any]:
        gens = self.context.gens()
        return [gens[i] ** 2 + gens[self.n + i] ** 2 - 1 for i in range(self.n)]

    @cached_property
    def _modulus(self) -> Any:
        return self.element(self.field.polynomial)

    def element(self, value: Any) -> Any:
        """An element of ℚ(θ) as a polynomial."""
        z = self.context.gens()[-1]
        result = self.context.constant(0)
        for coefficient in reversed(value.coeffs()):
            result = result * z + coefficient
        return result

    def constant(self, value: Any) -> Any:
        """A fraction as a polynomial."""
        return self.context.constant(fmpq(value.numerator, value.denominator))

    def reduce(self, value: Any) -> Any:
        """The normal form: no sᵢ², θ below the degree of its modulus."""
        degrees = value.degrees()
        for i, relation in enumerate(self._relations):
            if degrees[i] > 1 and i not in self.sliding:
                value = divmod(value, relation)[1]
        if value.degrees()[-1] >= self.field.degree:
            value = divmod(value, self._modulus)[1]
        return value

    def length(self, joint: int, pins: Pins) -> Any:
        """How far a joint slides: a variable, or a constant where it is pinned."""
        return self.element(pins[joint][1]) if joint in pins else self.context.gens()[joint]

    def angle(self, joint: int, pins: Pins) -> tuple[Any, Any]:
        """Cosine and sine of a joint: variables, or constants where it is pinned."""
        if joint not in pins:
            gens = self.context.gens()
            return gens[self.n + joint], gens[joint]
        x, y = pins[joint]
        scale = self.field.inverse(self.field.reduce(x * x + y * y))
        cosine, sine = (self.field.reduce(self.field.reduce(value) * scale) for value in (x * x - y * y, 2 * x * y))
        return self.element(cosine), self.element(sine)


def middle_links(arm: ExactArm) -> list[int]:
    """Links to try, the middle first; the base alone where the rank depends on the frame."""
    if not is_frame_free(arm.rows):
        return [0]
    return sorted(range(1, arm.n), key=lambda k: (abs(2 * k - arm.n), k)) or [0]


Placed = tuple[Matrix, Vector]
"""The axes of a joint's frame as columns, and its origin."""


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of the Jacobian in the frame of a link, remembered: each depends on the pins between alone.

    Attributes:
        arm: The arm.
        link: Which link, from 1 to n; 0 for the base.
    """

    arm: ExactArm
    link: int
    _known: dict[tuple[object, ...], Any] = field(default_factory=dict, repr=False)

    def jacobian(self, trig: Trig, state: State) -> list[list[Any]]:
        """The task rows, entries reduced.

        Args:
            trig: Where the entries live.
            state: Which joints stand still, and where.
        """
        now = _Now(self, trig, state, {pin.joint: (poly(pin.x), poly(pin.y)) for pin in state.pins})
        return [list(row) for row in zip(*(now.column(joint) for joint in range(self.arm.n)))]


@dataclass(frozen=True, eq=False)
class _Now:
    """The frames of an arm in one state.

    Attributes:
        columns: What is known already.
        trig: Where the entries live.
        state: The conditions.
        pins: Its pins.
    """

    columns: Columns
    trig: Trig
    state: State
    pins: Pins

    def _remembered(self, what: str, index: int, first: int, last: int, made: Callable[[int], Any]) -> Any:
        """What depends on the pins of joints from the first to before the last alone."""
        between = tuple(pin for pin in self.state.pins if first <= pin.joint < last)
        # An element of the field is its polynomial in θ: without a pin there is none.
        key = (what, index, between, self.state.field if between else None)
        if key not in self.columns._known:
            self.columns._known[key] = made(index)
        return self.columns._known[key]

    def column(self, joint: int) -> list[Any]:
        """The task rows of one column."""
        whole, link = set(self.columns.arm.rows) == set(ROWS), self.columns.link
        last = max(joint, link) if whole else self.columns.arm.n
        column: list[Any] = self._remembered("column", joint, min(joint + 1, link), last, self._column)
        return column

    def _column(self, joint: int) -> list[Any]:
        arm, zero = self.columns.arm, self.trig.context.constant(0)
        origin = (zero, zero, zero)
        reference = origin if set(arm.rows) == set(ROWS) else self.outwards(arm.n)[1]
        rotation, point = self.outwards(joint) if joint >= self.columns.link else self.inwards(joint)
        axis = tuple(row[2] for row in rotation)
        twist = (*axis, *origin) if joint in arm.sliding else (*cross(axis, minus(reference, point)), *axis)
        both = [self.trig.reduce(value) for value in twist]
        return [both[ROWS.index(name)] for name in arm.rows]

    def outwards(self, joint: int) -> Placed:
        """The frame of a joint after the link, before it moves; the tip's for n."""
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
        """The frame of a joint before the link, after it has moved."""
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


def _motion(arm: ExactArm, joint: int, trig: Trig, pins: Pins) -> tuple[Matrix, Vector]:
    """What a joint does to its frame: a turn about z and a translation along z, one of them none."""
    zero, one = trig.context.constant(0), trig.context.constant(1)
    if joint in arm.sliding:
        return turn(2, one, zero), (zero, zero, trig.length(joint, pins))
    return turn(2, *trig.angle(joint, pins)), (zero, zero, zero)


def _reduced(trig: Trig, values: Vector) -> Vector:
    return tuple(trig.reduce(value) for value in values)
