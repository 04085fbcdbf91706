"""LineArm: the axes of an arm by the common normals between them, and lengths that are meant to be alike made equal.

Which configurations of an arm of turning joints are singular depends on these numbers alone: how far axes pass each
other, how far the feet of common normals lie apart on an axis, and the angles between them. A file with rounded lengths
has axes that miss each other by a micrometre where they were meant to meet. Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly

PARALLEL = 1e-9
"""Axes whose unit vectors have a smaller cross product are parallel."""
STEP = np.pi / 12
"""15°: nominal angles are multiples of it."""


@dataclass(frozen=True)
class NormalLink:
    """The way from one axis to the next along their common normal: Rz(angle) Tz(along) Tx(length) Rx(twist).

    Attributes:
        angle: From the normal before to this one, about the axis, with the joint at zero, rad.
        along: From the foot of the normal before to that of this one, along the axis, m.
        length: Of the normal, m; its sign is that of its direction.
        twist: From this axis to the next, about the normal, rad.
    """

    angle: float
    along: float
    length: float
    twist: float

    @property
    def transform(self) -> Array:
        """Rz(angle) Tz(along) Tx(length) Rx(twist), (4, 4)."""
        c, s, ca, sa = np.cos(self.angle), np.sin(self.angle), np.cos(self.twist), np.sin(self.twist)
        return np.array([
            [c, -s * ca, s * sa, self.length * c], [s, c * ca, -c * sa, self.length * s], [0.0, sa, ca, self.along],
            [0.0, 0.0, 0.0, 1.0],
        ])  # fmt: skip


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
    def of(cls, axes: Array, points: Array, tip: Array) -> LineArm:
        """The arm with given axes.

        Args:
            axes: Unit vectors along the axes with all joints at zero, world, (n, 3).
            points: A point on each, m, (n, 3).
            tip: The tip's point there, m, (3,).
        """
        across = float(np.hypot(*axes[0, :2]))
        heading = float(np.arctan2(axes[0, 1], axes[0, 0])) if across > PARALLEL else 0.0
        tilt = float(np.arctan2(across, axes[0, 2]))
        x, here, links = _first_frame(heading, tilt)[:, 0], points[0], []
        for z, other, beyond in zip(axes, axes[1:], points[1:]):
            normal, foot, length = _common_normal(z, here, other, beyond, x)
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

    def evened(self, length: float, angle: float) -> tuple[LineArm, list[tuple[float, float]]]:
        """The arm with lengths that are nearly zero or nearly alike made so, and angles made multiples of 15°.

        Args:
            length: Largest change of a length, m.
            angle: Largest change of an angle, rad.

        Returns:
            The arm, and for each link the largest changes of its lengths and of its angles.
        """
        sizes = np.abs([(link.along if i else 0.0, link.length) for i, link in enumerate(self.links)])
        even = _alike(sizes.ravel(), length).reshape(sizes.shape)
        links, changes = [], []
        for i, (link, (along, across)) in enumerate(zip(self.links, even)):
            new = NormalLink(
                _nominal(link.angle, angle) if i else link.angle,
                float(np.copysign(along, link.along)) if i else link.along,
                float(np.copysign(across, link.length)),
                _nominal(link.twist, angle),
            )
            links.append(new)
            moved = max(abs(new.along - link.along), abs(new.length - link.length))
            changes.append((moved, max(abs(new.angle - link.angle), abs(new.twist - link.twist))))
        return replace(self, links=tuple(links)), changes


def _first_frame(heading: float, tilt: float) -> Array:
    """Rz(heading) Ry(tilt), (3, 3)."""
    (ch, sh), (ct, st) = ((np.cos(each), np.sin(each)) for each in (heading, tilt))
    return np.array([[ch * ct, -sh, ch * st], [sh * ct, ch, sh * st], [-st, 0.0, ct]])


def _common_normal(z: Array, here: Array, other: Array, beyond: Array, x: Array) -> tuple[Array, Array, float]:
    """The common normal of two axes: its direction, its foot on the first one, and its length with a sign.

    Args:
        z: Direction of the first axis.
        here: A point on it, where the normal before ends.
        other: Direction of the second.
        beyond: A point on it.
        x: Direction of the normal before, for axes that coincide.
    """
    across, way = np.cross(z, other), beyond - here
    size = float(np.linalg.norm(across))
    if size > PARALLEL:
        normal = across / size
        return normal, here + z * float(np.cross(way, other) @ across) / size**2, float(way @ normal)
    flat = way - (way @ z) * z
    length = float(np.linalg.norm(flat))
    return (flat / length if length > 0 else x), here, length


def _nominal(value: float, tolerance: float) -> float:
    """An angle, or the multiple of 15° that it nearly is."""
    exact = round(value / STEP) * STEP
    return exact if abs(value - exact) <= tolerance else value


def _alike(sizes: Array, tolerance: float) -> Array:
    """Sizes with those near zero made zero, and those near each other their middle, (N,)."""
    result = np.where(sizes <= tolerance, 0.0, sizes)
    order = [int(i) for i in np.argsort(result) if result[i] > 0]
    while order:
        first = result[order[0]]
        group = [i for i in order if result[i] - first <= tolerance]
        result[group] = 0.5 * (first + result[group[-1]])
        order = order[len(group) :]
    return np.asarray(result)
