"""LineArm: the axes of an arm by the common normals between them, and lengths that are meant to be alike made equal.

Which configurations of an arm of turning joints are singular depends on these numbers alone: how far axes pass each
other, how far the feet of common normals lie apart on an axis, and the angles between them. A file with rounded lengths
has axes that miss each other by a micrometre where they were meant to meet. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.description.dh import screw
from robust_ik.singularities.geometry.coincidence_tolerance import Tolerance

PARALLEL = 1e-9
"""Axes whose unit vectors have a smaller cross product are parallel."""
VAGUE = 5e-3
"""Largest change of an angle between two normals, rad: 0.3°, a fiftieth of STEP, so that few are changed by chance."""
WRITTEN = 1e-6
"""Distance of a length from whole numbers of the last digit's place, in that place, if it is written as it is."""
STEP = np.pi / 12
"""15°: the angles of nominal geometry, 30°, 45°, 60° and 90°, are multiples of it."""
Move = tuple[str, int, float]
"""A "turn" about an axis, or a "shift" along it: 0, 1, 2 for x, y, z; and by how much, rad or m."""


@dataclass(frozen=True)
class NormalLink:
    """The way from one axis to the next along their common normal, by Denavit and Hartenberg's standard parameters.

    Attributes:
        theta: θ, from the normal before to this one, about the axis, with the joint at zero, rad.
        d: From the foot of the normal before to that of this one, along the axis, m.
        a: Length of the normal, m; its sign is that of its direction.
        alpha: α, from this axis to the next, about the normal, rad.
    """

    theta: float
    d: float
    a: float
    alpha: float

    @property
    def transform(self) -> Array:
        """Rz(θ) Tz(d) Tx(a) Rx(α), (4, 4)."""
        return screw(2, self.theta, self.d) @ screw(0, self.alpha, self.a)

    @property
    def has_normal(self) -> bool:
        """Whether the normal has a direction of its own: not between axes in one line."""
        return abs(float(np.sin(self.alpha))) > PARALLEL or self.a != 0

    @property
    def moves(self) -> list[Move]:
        """The same, one after another."""
        return [("turn", 2, self.theta), ("shift", 2, self.d), ("shift", 0, self.a), ("turn", 0, self.alpha)]


@dataclass(frozen=True, eq=False)
class LineArm:
    """An arm of n turning joints.

    Attributes:
        heading: Direction of the first axis: the angle of its projection in the x-y plane of the world, rad.
        tilt: Its angle from the world's z axis, rad.
        origin: A point on the first axis, m, (3,).
        links: The ways between the axes, n − 1.
        tip: The tip's point in the last axis' frame, m, (3,).
    """

    heading: float
    tilt: float
    origin: Array
    links: tuple[NormalLink, ...]
    tip: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", readonly(self.origin))
        object.__setattr__(self, "tip", readonly(self.tip))

    @classmethod
    def of(cls, axes: Array, points: Array, tip: Array, least: float = 0.0) -> LineArm:
        """The arm with given axes.

        Args:
            axes: Unit vectors along the axes with all joints at zero, world, (n, 3).
            points: A point on each, m, (n, 3).
            tip: The tip's point there, m, (3,).
            least: Parallel axes at most so far apart are in one line, and have the direction of the normal before, m.
        """
        across = float(np.hypot(*axes[0, :2]))
        heading = float(np.arctan2(axes[0, 1], axes[0, 0])) if across > PARALLEL else 0.0
        tilt = float(np.arctan2(across, axes[0, 2]))
        x, here, links = _first_frame(heading, tilt)[:, 0], points[0], []
        for z, other, beyond in zip(axes, axes[1:], points[1:]):
            normal, foot, length = common_normal(z, here, other, beyond, x, least)
            twist = float(np.arctan2(normal @ np.cross(z, other), z @ other))
            angle = float(np.arctan2(z @ np.cross(x, normal), x @ normal))
            links.append(NormalLink(angle, float((foot - here) @ z), length, twist))
            x, here = normal, foot + length * normal
        frame = np.stack([x, np.cross(axes[-1], x), axes[-1]], axis=-1)
        return cls(heading, tilt, points[0], tuple(links), frame.T @ (tip - here))

    @property
    def frames(self) -> Array:
        """The frames of the axes with all joints at zero, z along the axis, (n, 4, 4)."""
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = _first_frame(self.heading, self.tilt), self.origin
        frames = [frame]
        for link in self.links:
            frames.append(frames[-1] @ link.transform)
        return np.stack(frames)

    @property
    def moves(self) -> list[list[Move]]:
        """The moves from the world to the first axis' frame, from each to the next one, and to the tip."""
        first: list[Move] = [*shifted(self.origin), ("turn", 2, self.heading), ("turn", 1, self.tilt)]
        return [first, *(link.moves for link in self.links), shifted(self.tip)]

    def evened(self, most: Tolerance) -> tuple[LineArm, list[tuple[float, float]]]:
        """The arm with lengths that are nearly zero or nearly alike made so, and angles made multiples of 15°.

        How the normals turn about an axis, θ, is known as well as their directions are: a normal of 0.1 m between
        parallel axes turns by 0.01 rad with an error of a millimetre.

        Args:
            most: Largest changes. Those of θ are up to VAGUE, where the normals are short.

        Returns:
            The arm, and for each link the largest changes of its lengths and of its angles.
        """
        sizes = np.abs([(link.d if i else 0.0, link.a) for i, link in enumerate(self.links)])
        even = _alike(sizes.ravel(), most).reshape(sizes.shape)
        vague = [vagueness(link, most) for link in self.links]
        links, changes = [], []
        for i, (link, (along, across)) in enumerate(zip(self.links, even)):
            turn = most.angle + min(vague[i - 1] + vague[i], VAGUE)
            new = NormalLink(
                nominal(link.theta, turn) if i else link.theta,
                float(np.copysign(along, link.d)) if i else link.d,
                float(np.copysign(across, link.a)),
                nominal(link.alpha, most.angle),
            )
            links.append(new)
            moved = max(abs(new.d - link.d), abs(new.a - link.a))
            changes.append((moved, max(abs(new.theta - link.theta), abs(new.alpha - link.alpha))))
        return replace(self, links=tuple(links)), changes


def made_parallel(
    axes: Array, points: Array, tip: Array, tolerance: float, sliding: Sequence[bool] = ()
) -> tuple[Array, Array, Array, list[float]]:
    """Lines with nearly parallel neighbours made parallel, by turning all that comes after, and each turn, rad.

    The common normal of nearly parallel axes is far away, and says nothing of how far they are apart. What slides is
    made parallel, by turning it alone, to what is before it, back to the last axis that turns; axes that turn, also to
    the slides in between.

    Args:
        axes: Unit vectors with all joints at zero, world, (n, 3).
        points: A point on each, m, (n, 3).
        tip: The tip's point, m, (3,).
        tolerance: Largest turn, rad.
        sliding: Which of the joints slide, (n,); by default none.
    """
    from scipy.spatial.transform import Rotation  # slow to import: only if it is needed

    axes, points, tip, turns = axes.copy(), points.copy(), tip.copy(), []
    for i in range(1, len(axes)):
        turn, before = min(
            (_turn_between(axes[i], axes[j]) for j in _neighbours(i, sliding)), key=lambda found: found[0]
        )
        across = np.cross(axes[i], before)
        if not 0 < turn <= tolerance:
            turns.append(0.0)
            continue
        turns.append(turn)
        if sliding and sliding[i]:
            axes[i] = before
            continue
        R = Rotation.from_rotvec(turn * across / np.linalg.norm(across)).as_matrix()
        axes[i:] = axes[i:] @ R.T
        axes[i] = before
        points[i + 1 :] = points[i] + (points[i + 1 :] - points[i]) @ R.T
        tip = points[i] + R @ (tip - points[i])
    return axes, points, tip, turns


def _neighbours(joint: int, sliding: Sequence[bool]) -> range:
    """The joints before one, back to the last that turns; only that one if nothing slides."""
    first = joint - 1
    while sliding and first > 0 and sliding[first]:
        first -= 1
    return range(first, joint)


def _turn_between(axis: Array, other: Array) -> tuple[float, Array]:
    """The least angle between two axes, rad, and the other one in the direction of the first."""
    before = other if float(axis @ other) > 0 else -other
    return float(np.arcsin(min(1.0, float(np.linalg.norm(np.cross(axis, before)))))), before


def shifted(by: Array) -> list[Move]:
    """The moves along x, y and z, by a vector in m, (3,)."""
    return [("shift", axis, float(amount)) for axis, amount in enumerate(by)]


def transform(moves: Sequence[Move]) -> Array:
    """The transform of moves, one after another, each in the frame that the ones before lead to, (4, 4)."""
    result = np.eye(4)
    for kind, axis, value in moves:
        result = result @ (screw(axis, value, 0.0) if kind == "turn" else screw(axis, 0.0, value))
    return result


def _first_frame(heading: float, tilt: float) -> Array:
    """Rz(heading) Ry(tilt), (3, 3)."""
    return (screw(2, heading, 0.0) @ screw(1, tilt, 0.0))[:3, :3]


def common_normal(
    z: Array, here: Array, other: Array, beyond: Array, x: Array, least: float = 0.0
) -> tuple[Array, Array, float]:
    """The common normal of two axes: its direction, its foot on the first one, and its length with a sign.

    Args:
        z: Direction of the first axis.
        here: A point on it, where the normal before ends.
        other: Direction of the second.
        beyond: A point on it.
        x: Direction of the normal before, for axes that coincide.
        least: Parallel axes at most so far apart coincide, m.
    """
    across, way = np.cross(z, other), beyond - here
    size = float(np.linalg.norm(across))
    if size > PARALLEL:
        normal = across / size
        return normal, here + z * float(np.cross(way, other) @ across) / size**2, float(way @ normal)
    flat = way - (way @ z) * z
    length = float(np.linalg.norm(flat))
    return (flat / length, here, length) if length > least else (x, here, 0.0)


def vagueness(link: NormalLink, most: Tolerance) -> float:
    """How far the direction of a link's normal may be off, rad."""
    across = abs(np.sin(link.alpha))
    if across > most.angle:
        return float(most.angle / across)
    return float(most.short / abs(link.a)) if link.a else 0.0


def nominal(value: float, tolerance: float) -> float:
    """An angle, or the multiple of 15° that it nearly is."""
    exact = round(value / STEP) * STEP
    return exact if abs(value - exact) <= tolerance else value


def _alike(sizes: Array, most: Tolerance) -> Array:
    """Sizes with those near zero made zero, and those near each other their middle, (N,)."""
    result = np.where(sizes <= most.short, 0.0, sizes)
    written = np.zeros(len(sizes), dtype=bool)
    if most.place > 0:
        written = np.abs(sizes / most.place - np.round(sizes / most.place)) <= WRITTEN
    order = [int(i) for i in np.argsort(result) if result[i] > 0]
    while order:
        first = result[order[0]]
        group = [i for i in order if result[i] - first <= most.alike]
        own = [i for i in group if written[i]]
        others = {i for i in own if result[i] - result[own[0]] > 0.5 * most.place}
        group = [i for i in group if i not in others]
        result[group] = 0.5 * (first + result[group[-1]])
        order = [i for i in order if i not in group]
    return np.asarray(result)
