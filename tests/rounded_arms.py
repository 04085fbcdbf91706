"""Arms as vendors make them, with rounded numbers: `python -m tests.rounded_arms` compares their atlases.

Their structures are drawn at random from what is met: axes that meet or are parallel, spherical wrists, offsets,
lengths that occur twice; with `--slides` there are rails, gantries, lifts and telescopes among them. Each is written as
a URDF with few decimals, in metres and rad, its frames turned about their axes by quarter turns, or by any angle, as
programs for design write them.
"""

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import robust_ik as rik
from robust_ik.description.dh import screw

RIGHT = float(np.pi / 2)
ARMS, DIGITS = 60, (3, 4, 5, 6)
MOVES = '<axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2" effort="1"/>'
SLIDES = '<axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5" velocity="2" effort="1"/>'
LONGEST, SHORTEST = 0.5, 0.08
"""Lengths of links, m."""


@dataclass(frozen=True)
class VendorArm:
    """An arm by Denavit and Hartenberg's (θ, d, a, α) of its joints, its tip beyond the last one, and what slides."""

    links: tuple[tuple[float, float, float, float], ...]
    tip: tuple[float, float, float]
    seed: int
    slides: tuple[int, ...] = ()

    @classmethod
    def sliding(cls, seed):
        """An arm of four to seven joints, of which one to three slide."""
        rng = np.random.default_rng([seed, 1])
        lengths = rng.uniform(SHORTEST, LONGEST, 5)

        def some(share=1.0):
            return float(rng.choice(lengths)) if rng.random() < share else 0.0

        links, slides = SLIDING[seed % len(SLIDING)](rng, some)
        return cls(tuple(links), (some(0.3), 0.0, some(0.5)), seed, slides)

    @classmethod
    def drawn(cls, seed):
        """An arm of six or seven joints."""
        rng = np.random.default_rng(seed)
        lengths = rng.uniform(SHORTEST, LONGEST, 5)

        def some(share=1.0):
            return float(rng.choice(lengths)) if rng.random() < share else 0.0

        draw = _seven if rng.random() < 0.4 else _six
        return cls(tuple(draw(rng, some)), (some(0.3), 0.0, some(0.5)), seed)

    def robot(self, digits=None, *, turned=False):
        """A robot, rounded to so many decimals, its frames turned about their axes by quarters or by any angles."""
        rng, n = np.random.default_rng(self.seed), len(self.links)
        spins = rng.uniform(-3, 3, n) if turned else RIGHT * rng.integers(-1, 3, n)
        around = [screw(2, spin, 0.0) for spin in spins]
        steps = [np.eye(4), *(screw(2, theta, d) @ screw(0, alpha, a) for theta, d, a, alpha in self.links)]
        steps[-1] = steps[-1] @ _shift(self.tip)
        before = [np.eye(4), *(np.linalg.inv(each) for each in around)]
        placed = [one @ step @ other for one, step, other in zip(before, steps, [*around, np.eye(4)])]
        return _loaded(placed, digits, self.slides)


def _six(rng, some):
    first = (0.0, some(0.8), some(0.5), RIGHT * rng.choice([-1, 1]))
    second = (0.0, some(0.3), some(), 0.0)
    back = -second[1] if rng.random() < 0.5 else 0.0
    if rng.random() < 1 / 3:  # three parallel axes, then two that cross
        return (
            first,
            second,
            (0.0, back, some(), 0.0),
            (0.0, some(0.7), 0.0, RIGHT),
            (0.0, some(0.7), 0.0, -RIGHT),
            LAST,
        )
    return first, second, (0.0, back, some(0.4), RIGHT), (0.0, some(), 0.0, -RIGHT), *_wrist(rng, some)


def _seven(rng, some):
    offset = some(0.4)
    back = offset * rng.choice([-1, 1]) if rng.random() < 0.5 else 0.0
    shoulder = (0.0, some(0.8), 0.0, RIGHT), (0.0, 0.0, 0.0, -RIGHT)
    elbow = (0.0, some(), offset, RIGHT * rng.choice([-1, 1])), (0.0, 0.0, back, -RIGHT), (0.0, some(), 0.0, RIGHT)
    return *shoulder, *elbow, *_wrist(rng, some)


def _wrist(rng, some):
    """A spherical wrist, in one of three arms with an offset."""
    return (0.0, 0.0, some() if rng.random() < 1 / 3 else 0.0, RIGHT), LAST


LAST = (0.0, 0.0, 0.0, 0.0)


def _scara(rng, some):
    """Parallel axes, a slide along them, in one of two the last axis off it."""
    off = some(0.5)
    return ((0.0, some(0.7), some(), 0.0), (0.0, some(0.3), some(), 2 * RIGHT * rng.integers(2)),
            (0.0, some(0.5), off, 0.0), LAST), (2,)  # fmt: skip


def _stanford(rng, some):
    """A shoulder, in one of two with an offset, a telescope, a wrist."""
    shoulder = (0.0, some(0.8), 0.0, -RIGHT), (0.0, some(0.5), 0.0, RIGHT)
    return (*shoulder, (0.0, some(0.5), some(0.3), 0.0), (0.0, some(0.3), 0.0, -RIGHT), *_wrist(rng, some)), (2,)


def _gantry(rng, some):
    """Three slides across each other, and a wrist."""
    slides = (0.0, some(0.5), some(0.3), -RIGHT), (-RIGHT, some(0.5), some(0.3), -RIGHT), (0.0, some(0.5), 0.0, 0.0)
    return (*slides, (0.0, some(0.3), 0.0, -RIGHT), *_wrist(rng, some)), (0, 1, 2)


def _rail(rng, some):
    """A rail along or across the first axis of an arm of five joints."""
    rail = (RIGHT * rng.integers(2), some(0.5), some(0.3), RIGHT * rng.choice([-1, 0, 1]))
    return (rail, *_six(rng, some)[:4], LAST), (0,)


def _lift(rng, some):
    """A turn, a slide along it or across, and a shoulder, an elbow and a wrist of two."""
    turn, slide = (0.0, some(0.5), some(0.3), RIGHT * rng.integers(2)), (0.0, some(0.5), some(0.3), RIGHT)
    return (turn, slide, (0.0, some(0.3), some(), 0.0), (0.0, 0.0, some(0.3), RIGHT), (0.0, some(), 0.0, -RIGHT),
            LAST), (1,)  # fmt: skip


def _cylindrical(rng, some):
    """A turn, a slide along it, a slide across, and a wrist."""
    return ((0.0, some(0.5), some(0.3), 0.0), (0.0, some(0.5), 0.0, -RIGHT), (0.0, some(0.5), some(0.3), 0.0),
            (0.0, some(0.3), 0.0, -RIGHT), *_wrist(rng, some)), (1, 2)  # fmt: skip


SLIDING = (_scara, _stanford, _gantry, _rail, _lift, _cylindrical)


def _shift(tip):
    moved = np.eye(4)
    moved[:3, 3] = tip
    return moved


def _loaded(placed, digits, slides):
    """The robot whose joints' origins are these, the last one fixed, written with so many decimals; some slide."""

    def words(numbers):
        return " ".join(repr(float(each) if digits is None else round(float(each), digits)) for each in numbers)

    parts = []
    for i, pose in enumerate(placed):
        roll, pitch, yaw = _angles(pose[:3, :3])
        origin = f'<origin xyz="{words(pose[:3, 3])}" rpy="{words((roll, pitch, yaw))}"/>'
        moves = (SLIDES if i in slides else MOVES) if i < len(placed) - 1 else ""
        kind = ("prismatic" if i in slides else "revolute") if moves else "fixed"
        parts.append(
            f'<joint name="q{i + 1}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>{origin}{moves}</joint>'
        )
    links = "".join(f'<link name="l{i}"/>' for i in range(len(placed) + 1))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(f'<robot name="arm">{links}{"".join(parts)}</robot>')
        return rik.load(path)


def _angles(R):
    """Roll, pitch and yaw of a rotation; roll is zero where they are not unique."""
    if abs(R[2, 0]) > 1 - 1e-12:
        return 0.0, float(-np.sign(R[2, 0]) * RIGHT), float(np.arctan2(-R[0, 1], R[1, 1]))
    return Rotation.from_matrix(R).as_euler("xyz")


def shape(atlas):
    """The rows of an atlas without their numbers, sorted: corank, dimension, conditions, how many equations, curves."""
    return sorted(
        (row.corank, row.dimension, tuple((each.angle.joints, len(each.values)) for each in row.conditions),
         len(row.relations), row.curve)
        for row in atlas
    )  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=ARMS)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--starts", type=int, default=500)
    parser.add_argument("--slides", action="store_true", help="arms of which some joints slide")
    given = parser.parse_args()
    same = dict.fromkeys(DIGITS, 0)
    for seed in range(given.first, given.first + given.arms):
        arm, turned = VendorArm.sliding(seed) if given.slides else VendorArm.drawn(seed), bool(seed % 2)
        wanted = rik.find_singularities(arm.robot(), starts=given.starts, certify=False)
        told = [f"{seed:3d}: {len(wanted):2d} rows"]
        for digits in DIGITS:
            found = rik.find_singularities(arm.robot(digits, turned=turned), starts=given.starts, certify=False)
            alike = shape(found) == shape(wanted)
            same[digits] += alike
            floor = max((row.floor for row in found), default=0.0)
            told.append(f"{digits} decimals: {'same' if alike else f'{len(found)} rows'}, σ to {floor:.0e}")
        print("; ".join(told), flush=True)
    for digits, count in same.items():
        print(f"{digits} decimals: {count} of {given.arms} arms have the rows of the exact one")


if __name__ == "__main__":
    main()
