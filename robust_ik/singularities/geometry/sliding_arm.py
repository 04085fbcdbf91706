"""SlidingArm: an arm of joints that turn and slide, by the common normals of what turns and the directions of slides.

A slide has a direction but no line: where it is, and where its zero is, changes nothing of which configurations are
singular. So every slide is first moved to where lengths along it vanish: axes on both sides of it meet, or their feet
coincide. Then the axes that turn are measured, as those of an arm without slides. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.geometry.coincidence_tolerance import Tolerance
from robust_ik.singularities.geometry.line_arm import (
    PARALLEL,
    VAGUE,
    LineArm,
    Move,
    common_normal,
    nominal,
    shifted,
    transform,
    vagueness,
)

LEADS = 0.02
"""Least share of a slide's motion along a length that it may bring to zero. Chosen: ten times what rounding of
directions leaves where there is none, `COARSEST`.
"""


@dataclass(frozen=True)
class SlidePlace:
    """A slide beside the axis before it that turns, or beside the base.

    Attributes:
        about: From the x axis of that axis' frame to the direction from which headings are measured, about it, rad.
        heading: From there to the slide's direction, rad.
        tilt: From the axis to the slide's direction, rad.
        zero: How far it is from its own zero where lengths were measured, m.
    """

    about: float
    heading: float
    tilt: float
    zero: float

    @property
    def there(self) -> list[Move]:
        """The moves from the axis' frame to one with z along the slide."""
        return [("turn", 2, self.about), ("turn", 2, self.heading), ("turn", 1, self.tilt)]

    @property
    def back(self) -> list[Move]:
        """The moves from there to the axis' frame, beyond the slide."""
        turns: list[Move] = [(kind, axis, -value) for kind, axis, value in reversed(self.there)]
        return [("shift", 2, -self.zero), *turns]


@dataclass(frozen=True, eq=False)
class SlidingArm:
    """An arm of n joints, of which some slide and at least one turns.

    Attributes:
        sliding: Which of the joints slide, (n,).
        base: Angles about z, y and z of a frame in the world in which all else is, rad.
        origin: Its origin, m, (3,).
        lines: The axes that turn, in that frame, with all slides moved to their zeros.
        slides: The slides, in order.
    """

    sliding: tuple[bool, ...]
    base: tuple[float, float, float]
    origin: Array
    lines: LineArm
    slides: tuple[SlidePlace, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", readonly(self.origin))

    @classmethod
    def of(cls, axes: Array, points: Array, tip: Array, sliding: Sequence[bool], most: Tolerance) -> SlidingArm:
        """The arm with given axes, of which neighbours are not nearly parallel unless they are: see `made_parallel`.

        Args:
            axes: Unit vectors along the axes with all joints at zero, world, (n, 3).
            points: A point on each, m, (n, 3).
            tip: The tip's point there, m, (3,).
            sliding: Which joints slide, (n,).
            most: Largest changes: shorter normals between parallel axes have no direction.
        """
        turns = np.flatnonzero(~np.array(sliding))
        first = int(turns[0])
        base = _base(axes[: first + 1]) if first else (0.0, 0.0, 0.0)
        frame = _turned(base)
        origin = points[first] if first else np.zeros(3)
        axes, points, tip = axes @ frame, (points - origin) @ frame, (tip - origin) @ frame
        slider = _Slider(axes, points, tip, np.zeros(len(axes)))
        slider.run(turns.tolist())
        lines = LineArm.of(axes[turns], slider.points[turns], slider.tip, most.short)
        slides = [
            _place(lines, axes, sliding, int(joint), float(slider.zeros[joint])) for joint in np.flatnonzero(sliding)
        ]
        return cls(tuple(sliding), base, origin, lines, tuple(slides))

    @property
    def moves(self) -> list[list[Move]]:
        """The moves from the world to the first joint's frame, from each joint's to the next one's, and to the tip."""
        pending = [*shifted(self.origin), *(("turn", axis, angle) for axis, angle in zip((2, 1, 2), self.base))]
        lines, slides, found = iter(self.lines.moves), iter(self.slides), []
        for slides_here in self.sliding:
            if slides_here:
                slide = next(slides)
                found.append([*pending, *slide.there])
                pending = slide.back
            else:
                found.append([*pending, *next(lines)])
                pending = []
        return [*found, [*pending, *next(lines)]]

    def evened(self, most: Tolerance) -> tuple[SlidingArm, list[tuple[float, float]]]:
        """The arm with meant coincidences made exact, as by `LineArm.evened`, and directions of slides nominal.

        Args:
            most: Largest changes.

        Returns:
            The arm, and for each joint but the first the largest changes of its lengths and of its angles.
        """
        lines, changes = self.lines.evened(most)
        turned = 0.0
        if self.sliding[0]:
            lines, turned = _beside_slides(lines, most)
        told, slides, axis = iter([(0.0, turned), *changes]), [], -1
        found: list[tuple[float, float]] = []
        given = iter(self.slides)
        for slides_here in self.sliding:
            if not slides_here:
                axis += 1
                found.append(next(told))
                continue
            slide = next(given)
            vague = 0.0
            if 0 <= axis < len(lines.links) and lines.links[axis].has_normal:
                slide = replace(slide, about=lines.links[axis].theta)
                vague = min(vagueness(self.lines.links[axis], most), VAGUE)
            heading, tilt = nominal(slide.heading, most.angle + vague), nominal(slide.tilt, most.angle)
            found.append((0.0, max(abs(heading - slide.heading), abs(tilt - slide.tilt))))
            slides.append(replace(slide, heading=heading, tilt=tilt))
        return replace(self, lines=lines, slides=tuple(slides)), found[1:]


def _beside_slides(lines: LineArm, most: Tolerance) -> tuple[LineArm, float]:
    """The axes with the first one nominal beside the slides before it, and its first normal, and the largest turn.

    Of an arm without slides before it, nothing is beside it: its direction and zero are those of the mount.
    """
    heading, tilt, links = nominal(lines.heading, most.angle), nominal(lines.tilt, most.angle), list(lines.links)
    turned = max(abs(heading - lines.heading), abs(tilt - lines.tilt))
    if links:
        theta = nominal(links[0].theta, most.angle + min(vagueness(links[0], most), VAGUE))
        turned = max(turned, abs(theta - links[0].theta))
        links[0] = replace(links[0], theta=theta)
    return replace(lines, heading=heading, tilt=tilt, links=tuple(links)), turned


def _turned(angles: tuple[float, float, float]) -> Array:
    """Rz Ry Rz by these angles, (3, 3)."""
    return transform([("turn", axis, angle) for axis, angle in zip((2, 1, 2), angles)])[:3, :3]


def _base(axes: Array) -> tuple[float, float, float]:
    """Angles of a frame with z along the first of some directions, and x towards the first other one, rad."""
    heading, tilt = _polar(axes[0])
    across = axes - np.outer(axes @ axes[0], axes[0])
    others = np.flatnonzero(np.linalg.norm(across, axis=1) > PARALLEL)
    x = across[others[0]] @ _turned((heading, tilt, 0.0)) if len(others) else (1.0, 0.0)
    return heading, tilt, float(np.arctan2(x[1], x[0]))


def _polar(direction: Array) -> tuple[float, float]:
    """The angle of a unit vector about z from x, and its angle from z, rad."""
    across = float(np.hypot(*direction[:2]))
    heading = float(np.arctan2(direction[1], direction[0])) if across > PARALLEL else 0.0
    return heading, float(np.arctan2(across, direction[2]))


def _parallel(one: Array, other: Array) -> bool:
    return float(np.linalg.norm(np.cross(one, other))) <= PARALLEL


@dataclass
class _Slider:
    """An arm whose slides are moved to where lengths along them vanish.

    Attributes:
        axes: Unit vectors, (n, 3).
        points: A point on each, m, (n, 3).
        tip: The tip's point, m, (3,).
        zeros: How far each slide was moved, m, (n,).
    """

    axes: Array
    points: Array
    tip: Array
    zeros: Array

    def slide(self, joint: int, amount: float) -> None:
        """Moves all that comes after a slide."""
        way = amount * self.axes[joint]
        self.zeros[joint] += amount
        self.points[joint + 1 :] += way
        self.tip = self.tip + way

    def run(self, turns: Sequence[int]) -> None:
        """Moves every slide between axes that turn.

        A slide parallel to an axis beside it brings the distance of the feet on that axis to zero. Others bring to zero
        the way between axes that are parallel, else the length of the normal, then the distance of the feet on the
        first axis, unless nothing is before it.
        """
        here, free, matters = self.points[turns[0]], None, False
        for i, j in pairwise(turns):
            z, w = self.axes[i], self.axes[j]
            along, before, others = self._sorted(i, j)
            free = along[0] if along else free
            parallel = _parallel(z, w)
            if parallel:
                self._meet(here, z, j, others)
            else:
                self._close(here, i, j, others, feet=matters and free is None)
                if matters and free is not None:
                    foot = common_normal(z, here, w, self.points[j], z)[1]
                    self.slide(free, float((here - foot) @ z) * float(np.sign(self.axes[free] @ z)))
            normal, foot, length = common_normal(z, here, w, self.points[j], z)
            here = foot + length * normal
            if not parallel:
                free, matters = None, True
            free = before[0] if before and free is None else free

    def _sorted(self, i: int, j: int) -> tuple[list[int], list[int], list[int]]:
        """The slides between two axes: parallel to the first, to the second, and others."""
        between = range(i + 1, j)
        along = [k for k in between if _parallel(self.axes[k], self.axes[i])]
        before = [k for k in between if k not in along and _parallel(self.axes[k], self.axes[j])]
        return along, before, [k for k in between if k not in (*along, *before)]

    def _meet(self, here: Array, z: Array, j: int, slides: list[int]) -> None:
        """Brings parallel axes together, as far as slides across them do."""
        if not slides:
            return
        flat = np.eye(3) - np.outer(z, z)
        amounts = np.linalg.lstsq((self.axes[slides] @ flat).T, flat @ (here - self.points[j]), rcond=LEADS)[0]
        for joint, amount in zip(slides, amounts):
            self.slide(joint, float(amount))

    def _close(self, here: Array, i: int, j: int, slides: list[int], *, feet: bool) -> None:
        """Brings the normal of two axes to zero, and the distance of the feet on the first one, as far as slides do."""
        z, w = self.axes[i], self.axes[j]
        normal = np.cross(z, w)
        size = float(np.linalg.norm(normal))

        def lengths(way: Array) -> Array:
            return np.array([way @ normal / size, np.cross(way, w) @ normal / size**2])

        effects = np.array([lengths(self.axes[k]) for k in slides]).reshape(-1, 2).T
        left, rows, chosen = effects.copy(), [], []
        for row in (0, 1) if feet else (0,):
            best = int(np.argmax(np.abs(left[row]))) if slides else -1
            if best < 0 or abs(left[row, best]) <= LEADS:
                continue
            rows.append(row)
            chosen.append(best)
            left = left - np.outer(left[:, best], left[row] / left[row, best])
        amounts = np.linalg.solve(effects[np.ix_(rows, chosen)], -lengths(self.points[j] - here)[rows])
        for place, amount in zip(chosen, amounts):
            self.slide(slides[place], float(amount))


def _place(lines: LineArm, axes: Array, sliding: Sequence[bool], joint: int, zero: float) -> SlidePlace:
    """A slide beside the axis before it that turns.

    Headings are measured from the next normal, or from the first slide across where there is none.
    """
    axis = sum(not each for each in sliding[:joint]) - 1
    frame = lines.frames[axis][:3, :3] if axis >= 0 else np.eye(3)
    heading, tilt = _polar(axes[joint] @ frame)
    about = 0.0
    if 0 <= axis < len(lines.links) and lines.links[axis].has_normal:
        about = lines.links[axis].theta
    elif axis >= 0:
        first = joint
        while sliding[first - 1] and not _parallel(axes[first - 1], frame[:, 2]):
            first -= 1
        about = _polar(axes[first] @ frame)[0]
    away = heading - about if min(tilt, np.pi - tilt) > PARALLEL else 0.0
    return SlidePlace(about, float(np.arctan2(np.sin(away), np.cos(away))), tilt, zero)
