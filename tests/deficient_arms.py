"""Arms that never have full rank, whatever their configuration, drawn at random, with kinematics of their own.

Two joints turn about one axis, two slide along parallel lines, four axes are parallel or meet in a point: some motion
of the joints never moves the tip. Nothing here is of the library but the robot that it loads.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.arms import arm_of

X, Y, Z = "1 0 0", "0 1 0", "0 0 1"
KINDS = ("coaxial", "planar", "parallel", "spherical", "lift", "rails")
SMALL = 1e-9
"""Entries of J W below which a search of `singular_points` has come to its end."""


@dataclass(frozen=True)
class DeficientArm:
    """An arm as a list of joints.

    Attributes:
        joints: Origin, m; axis; whether it slides, of each.
        tip: The tip's point in the last joint's frame, m.
        size: Factor of all lengths.
        mount: Roll, pitch and yaw of the base, rad.
        zeros: Added to every joint's value, rad or m (times size).
    """

    joints: tuple[tuple[tuple[float, float, float], str, bool], ...]
    tip: tuple[float, float, float]
    size: float = 1.0
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    zeros: tuple[float, ...] = ()

    @classmethod
    def drawn(cls, kind, seed):
        """An arm of one kind."""
        rng = np.random.default_rng([KINDS.index(kind), seed])
        place = lambda *which: tuple(round(float(rng.uniform(0.1, 0.4)), 3) if each else 0.0 for each in which)  # noqa: E731
        turn = lambda axis, *which: (place(*(which or (0, 0, 0))), axis, False)  # noqa: E731
        slide = lambda axis, *which: (place(*which), axis, True)  # noqa: E731
        match kind:
            case "coaxial":  # axes 3 and 4 are one line
                joints = [turn(Z, 0, 0, 1), turn(Y, 1, 0, 1), turn(X, 0, 0, 1), turn(X, 1, 0, 0), turn(Y, 1, 0, 0)]
            case "planar":
                joints = [turn(Z, 0, 0, 1), *(turn(Z, 1, 0, 0) for _ in range(3 + seed % 2))]
            case "parallel":
                joints = [turn(Z, 0, 0, 1), *(turn(Z, 1, 0, 0) for _ in range(3)), turn(X, 0, 0, 1), turn(Y, 1, 0, 0)]
            case "spherical":
                joints = [turn(Z, 0, 0, 1), turn(Y), turn(X), turn(Z), *([turn(Y)] if seed % 2 else [])]
            case "lift":
                joints = [slide(Z, 0, 0, 1), turn(Z, 1, 0, 0), slide(Z, 0, 0, 1), slide(X, 0, 1, 0), turn(Z, 1, 0, 0)]
            case "rails":
                joints = [slide(X, 0, 0, 1), turn(Z, 0, 0, 1), turn(Z, 1, 0, 0), turn(Z, 1, 0, 0), turn(X, 0, 0, 1)]
        return cls(tuple(joints), place(1, 0, 1))

    @property
    def n(self):
        return len(self.joints)

    @property
    def slides(self):
        return np.array([slides for *_, slides in self.joints])

    def robot(self):
        """The robot, from a URDF."""
        shifts = self.zeros or (0.0,) * self.n
        lines = []
        for place, axis, slides in self.joints:
            before = len(lines)
            origin, turned = np.array(place), (0.0, 0.0, 0.0)
            if before:
                R, moved = self._moved(before - 1, shifts[before - 1])
                origin, turned = moved + R.as_matrix() @ origin, R.as_euler("xyz")
            else:
                turned = self.mount
                origin = Rotation.from_euler("xyz", turned).as_matrix() @ origin
            text = tuple(" ".join(repr(float(each)) for each in numbers) for numbers in (origin, turned))
            lines.append((*text, axis, *((-0.5, 0.5, "slide") if slides else (-3, 3))))
        R, moved = self._moved(self.n - 1, shifts[-1])
        tip = moved + R.as_matrix() @ np.array(self.tip)
        return arm_of(lines, " ".join(repr(float(each)) for each in tip), self.size)

    def _moved(self, joint, value):
        """The rotation and translation of a joint at a value."""
        _, axis, slides = self.joints[joint]
        along = np.array([float(each) for each in axis.split()])
        turned, moved = (0.0, value) if slides else (value, 0.0)
        return Rotation.from_rotvec(turned * along), moved * along

    def jacobian(self, values):
        """Twists of the tip's point in units of `size`, world axes, columns per rad or `size`, (6, n)."""
        R, at = Rotation.from_euler("xyz", self.mount).as_matrix(), np.zeros(3)
        J = np.zeros((6, self.n))
        for joint, (place, axis, slides) in enumerate(self.joints):
            at = at + R @ place
            i = (X, Y, Z).index(axis)
            value = values[joint] + (self.zeros[joint] if self.zeros else 0.0)
            if slides:
                J[:3, joint] = R[:, i]
                at = at + value * R[:, i]
                continue
            J[:3, joint], J[3:, joint] = at, R[:, i]
            c, s, (u, v) = np.cos(value), np.sin(value), (R[:, i - 2], R[:, i - 1])
            R = R.copy()
            R[:, i - 2], R[:, i - 1] = c * u + s * v, c * v - s * u
        arms = (at + R @ self.tip)[:, None] - J[:3]
        turned = np.cross(J[3:], arms, axis=0)
        J[:3] = np.where(self.slides, J[:3], turned)
        return J

    def rank(self):
        """The largest rank at random configurations."""
        rng = np.random.default_rng(0)
        return max(np.linalg.matrix_rank(self.jacobian(rng.uniform(-2, 2, self.n)), tol=1e-8) for _ in range(5))

    def singular_points(self, corank, rng, starts):
        """Joint values at which n − g + k independent motions W do not move the tip: J(q) W = 0, CᵀW = 1, for random C.

        By `scipy.optimize.least_squares` in q and W at once, from random starts; those that get there, (N, n).
        """
        count, found = self.n - self.rank() + corank, []
        for _ in range(starts):
            C = np.linalg.qr(rng.standard_normal((self.n, count)))[0]
            q = np.where(self.slides, rng.uniform(-0.5, 0.5, self.n), rng.uniform(-3, 3, self.n))

            def errors(x, C=C):
                W = x[self.n :].reshape(self.n, count)
                return np.r_[(self.jacobian(x[: self.n]) @ W).ravel(), (C.T @ W - np.eye(count)).ravel()]

            ends = least_squares(errors, np.r_[q, C.ravel()], xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=60)
            if np.abs(ends.fun).max() < SMALL:
                found.append(ends.x[: self.n])
        return np.array(found).reshape(-1, self.n)

    def changed(self, rng):
        """The same arm at another size, on another mount, with another tip and other zeros of its joints."""
        zeros = tuple(rng.uniform(-1, 1, self.n) * np.where(self.slides, 0.1, 1.0))
        mount, tip = tuple(rng.uniform(-1, 1, 3)), tuple(rng.uniform(-0.3, 0.3, 3))
        size = float(10.0 ** rng.uniform(-6, 6))
        return {
            "mount": replace(self, mount=mount),
            "tip": replace(self, tip=tip),
            "size": replace(self, size=size),
            "zeros": replace(self, zeros=zeros),
            "all": replace(self, mount=mount, tip=tip, size=size, zeros=zeros),
        }
