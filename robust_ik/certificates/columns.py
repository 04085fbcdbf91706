"""The Jacobian in a link's frame, as polynomials in the cosines and sines of the joints, and the lengths of slides.

Column i is (p × w, w) for the axis w through p, both in the frame of link k, and (w, 0) for a slide along w. There the
columns k and k + 1 are constant and every other one depends only on the joints between; the rank is that in any other
frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx

from robust_ik.certificates.exact_model import ExactArm, is_frame_free
from robust_ik.certificates.fields import Field
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


def jacobian(arm: ExactArm, link: int, trig: Trig, pins: Pins) -> list[list[Any]]:
    """The task rows of the Jacobian in the frame of a link, entries reduced.

    Args:
        arm: The arm.
        link: Which link, from 1 to n; 0 for the base.
        trig: Where the entries live.
        pins: Joints that stand still.
    """
    axes, points, tool = _axes(arm, link, trig, pins)
    origin = (trig.context.constant(0),) * 3
    reference = origin if set(arm.rows) == set(ROWS) else tool
    columns = []
    for i, (axis, point) in enumerate(zip(axes, points)):
        twist = (*axis, *origin) if i in arm.sliding else (*cross(axis, minus(reference, point)), *axis)
        both = [trig.reduce(value) for value in twist]
        columns.append([both[ROWS.index(name)] for name in arm.rows])
    return [list(row) for row in zip(*columns)]


def middle_links(arm: ExactArm) -> list[int]:
    """Links to try, the middle first; the base alone where the rank depends on the frame."""
    if not is_frame_free(arm.rows):
        return [0]
    return sorted(range(1, arm.n), key=lambda k: (abs(2 * k - arm.n), k)) or [0]


def _axes(arm: ExactArm, link: int, trig: Trig, pins: Pins) -> tuple[list[Vector], list[Vector], Vector]:
    """Every joint's axis and a point on it, and the tool point, in the frame of the link."""
    placements = [
        (tuple(tuple(trig.constant(a) for a in row) for row in R), tuple(trig.constant(a) for a in p))
        for R, p in arm.placements
    ]
    zero, one = trig.context.constant(0), trig.context.constant(1)
    start: Matrix = ((one, zero, zero), (zero, one, zero), (zero, zero, one))
    axes: dict[int, Vector] = {}
    points: dict[int, Vector] = {}
    rotation, point = start, (zero, zero, zero)
    for i in range(link, arm.n + 1):
        point = _reduced(trig, plus(point, rotate(rotation, placements[i][1])))
        rotation = times(rotation, placements[i][0])
        if i < arm.n:
            axes[i], points[i] = tuple(row[2] for row in rotation), point
            motion, slide = _motion(arm, i, trig, pins)
            point = plus(point, rotate(rotation, slide))
            rotation = tuple(_reduced(trig, row) for row in times(rotation, motion))
    tool = point
    rotation, point = start, (zero, zero, zero)
    for i in range(link - 1, -1, -1):
        axes[i], points[i] = tuple(row[2] for row in rotation), point
        motion, slide = _motion(arm, i, trig, pins)
        point = minus(point, rotate(rotation, slide))
        back = transpose(times(placements[i][0], motion))
        rotation = tuple(_reduced(trig, row) for row in times(rotation, back))
        point = _reduced(trig, minus(point, rotate(rotation, placements[i][1])))
    return [axes[i] for i in range(arm.n)], [points[i] for i in range(arm.n)], tool


def _motion(arm: ExactArm, joint: int, trig: Trig, pins: Pins) -> tuple[Matrix, Vector]:
    """What a joint does to its frame: a turn about z and a translation along z, one of them none."""
    zero, one = trig.context.constant(0), trig.context.constant(1)
    if joint in arm.sliding:
        return turn(2, one, zero), (zero, zero, trig.length(joint, pins))
    return turn(2, *trig.angle(joint, pins)), (zero, zero, zero)


def _reduced(trig: Trig, values: Vector) -> Vector:
    return tuple(trig.reduce(value) for value in values)
