"""The checker's own kinematics: the Jacobian of a proof's arm at a point, modulo a prime."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

from robust_ik.certificates.checker.modular_arithmetic import UnluckyError, fraction_steps, residue
from robust_ik.certificates.checker.modular_rings import Ring
from robust_ik.certificates.proof.case_tree import Form
from robust_ik.certificates.proof.counted_steps import spend
from robust_ik.certificates.proof.proof_arm import Arm

ROW_NAMES = ("x", "y", "z", "wx", "wy", "wz")

Links = tuple[tuple[tuple[str, ...], ...], ...]
"""Constant transforms as an arm states them: three rows of a rotation, then a translation, fractions as text."""
Point = dict[int, tuple[Any, Any]]
"""Joint → (x, y); (1, d) for a sliding joint at length d."""


def is_rigid(arm: Arm) -> bool:
    """Whether every link is an exact rotation and a translation."""
    for *rows, _ in arm.links:
        a, b, c = ([Fraction(value) for value in row] for row in rows)
        dots = [sum(x * y for x, y in zip(u, v)) for u, v in ((a, a), (b, b), (c, c), (a, b), (b, c), (a, c))]
        volume = sum(x * y for x, y in zip(_cross(a, b), c))
        if dots != [1, 1, 1, 0, 0, 0] or volume != 1:
            return False
    return True


@dataclass(frozen=True, eq=False)
class ModularReplay:
    """The kinematics of an arm in one ring.

    Attributes:
        arm: The arm.
        link: The link whose frame the Jacobian is written in; 0 for the base.
        ring: The ring of its numbers.
    """

    arm: Arm
    link: int
    ring: Ring

    def jacobian(self, point: Point) -> list[list[Any]]:
        """The arm's task rows, (rows, n), at a point.

        Frames are computed from the base outwards, then transformed to the link.
        """
        spend(500 * len(self.arm.links))
        p, frames = self.ring.prime, self._frames(point)
        origin, turned = ([0, 0, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) if not self.link else frames[self.link - 1]
        whole = len(self.arm.rows) == len(ROW_NAMES)
        reference = origin if whole else frames[-1][0]
        columns, directions = [[0] * len(self.arm.rows) for _ in self.arm.joints], list(zip(*turned))
        for (joint, factor), (place, axes) in zip(self._motions, frames[:-1]):
            axis = [row[2] for row in axes]
            lever = [(a - b) % p for a, b in zip(reference, place)]
            twist = (axis, [0, 0, 0]) if joint in self.arm.sliding else (_cross(axis, lever), axis)
            both = [dot(direction, vector) % p for vector in twist for direction in directions]
            moved = (factor * both[ROW_NAMES.index(name)] for name in self.arm.rows)
            columns[joint] = [(a + b) % p for a, b in zip(moved, columns[joint])]
        return [list(row) for row in zip(*columns)]

    @cached_property
    def _links(self) -> list[list[list[int]]]:
        """The constant transforms modulo the prime."""
        found, steps = _modular(self.arm.links, self.ring.prime)
        spend(steps)
        return found

    @cached_property
    def _motions(self) -> list[tuple[int, int]]:
        """The joint of each motion, and its factor modulo the prime."""
        spend(sum(fraction_steps(factor) for _, factor in self.arm.motions))
        return [(joint, residue(factor, self.ring.prime)) for joint, factor in self.arm.motions]

    def _frames(self, point: Point) -> list[tuple[list[Any], list[list[Any]]]]:
        """Origin and axes of every moved frame, and of the tip, in the base."""
        p = self.ring.prime
        place: list[Any] = [0, 0, 0]
        axes: list[list[Any]] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        result = []
        for i, numbers in enumerate(self._links):
            *rotation, offset = numbers
            columns = list(zip(*rotation))
            place = [(at + dot(row, offset)) % p for at, row in zip(place, axes)]
            axes = [[dot(row, column) % p for column in columns] for row in axes]
            joint, factor = self._motions[i] if i < len(self._motions) else (-1, 0)
            if joint in self.arm.sliding:
                way = factor * self._length(*point[joint])
                place = [(a + row[2] * way) % p for a, row in zip(place, axes)]
            elif joint >= 0:
                c, s = self._multiple(*self._angle(*point[joint]), self.arm.motions[i][1])
                axes = [[(a * c + b * s) % p, (b * c - a * s) % p, d] for a, b, d in axes]
            result.append((place, axes))
        return result

    def _length(self, x: Any, y: Any) -> Any:
        """The length of a slide at (1, d)."""
        if x != 1:
            raise UnluckyError("a sliding joint is not at (1 : d)")
        return y

    def _multiple(self, c: Any, s: Any, factor: str) -> tuple[Any, Any]:
        """Cosine and sine of ±1 or ±2 times an angle, by its own cosine and sine."""
        p = self.ring.prime
        if factor.endswith("2"):
            c, s = (1 - 2 * s * s) % p, 2 * s * c % p
        return c, -s if factor.startswith("-") else s

    def _angle(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Cosine and sine of the angle, from those of the half angle up to their common factor."""
        p = self.ring.prime
        scale = self.ring.inverse((x * x + y * y) % p)
        return (x * x - y * y) * scale % p, 2 * x * y * scale % p


@lru_cache(maxsize=8)
def _modular(links: Links, prime: int) -> tuple[list[list[list[int]]], float]:
    """Constant transforms modulo a prime, and the steps that this takes; most cases of a proof share their prime."""
    found = [[[residue(value, prime) for value in row] for row in link] for link in links]
    return found, sum(fraction_steps(value) for link in links for row in link for value in row)


def dot(u: Sequence[Any], v: Sequence[Any]) -> Any:
    """Σ uᵢ vᵢ, not reduced; zeros, which are most entries of links, are skipped."""
    result: Any = 0
    for a, b in zip(u, v):
        if a and b:
            result = a * b + result
    return result


def random_point(joint: int, arm: Arm, rng: random.Random, prime: int) -> tuple[int, int]:
    """A random (x, y) of a joint: any two numbers for an angle, (1, d) for a length."""
    x = 1 if joint in arm.sliding else rng.randrange(prime)
    return x, rng.randrange(prime)


def evaluate(form: Form, point: Point, ring: Ring) -> Any:
    """A form's value at a point."""
    p = ring.prime
    spend(10 * sum(form.degrees) + 3 * len(form.terms) * (1 + len(form.joints)))
    tables = [_monomials(*point[joint], degree, p) for joint, degree in zip(form.joints, form.degrees, strict=True)]
    total: Any = 0
    for powers, coefficient in form.terms:
        term = ring.number(coefficient)
        for table, power in zip(tables, powers, strict=True):
            term = term * table[power] % p
        total = total + term
    return total % p


def collect(form: Form, joint: int, point: Point, ring: Ring) -> list[Any]:
    """A form as a polynomial in y of one joint, lowest coefficient first, with the other joints at a point."""
    degree = dict(zip(form.joints, form.degrees)).get(joint, 0)
    result: list[Any] = [0] * (degree + 1)
    one: Point = {**point, joint: (1, 1)}
    spend((degree + 1) * 5 * len(form.terms) * (1 + len(form.joints)))
    for power in range(degree + 1):
        terms = tuple(term for term in form.terms if dict(zip(form.joints, term[0])).get(joint, 0) == power)
        if terms:
            result[power] = evaluate(Form(form.joints, form.degrees, terms), one, ring)
    return result


def _monomials(x: Any, y: Any, degree: int, p: int) -> list[Any]:
    """x^(degree − i) y^i for i from 0 to the degree."""
    left, right = [1], [1]
    for _ in range(degree):
        left.append(left[-1] * x % p)
        right.append(right[-1] * y % p)
    return [left[degree - i] * right[i] % p for i in range(degree + 1)]


def _cross(u: Sequence[Any], v: Sequence[Any]) -> list[Any]:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
