"""RobustnessScenario: one motion of the benchmark, with everything that a method is told and judged by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.control.tasks import pose_error
from robust_ik.errors import InputError
from robust_ik.kinematics.twist_rows import ROWS

KINDS = ("cross", "start", "beyond", "corank", "line", "noise", "speed", "sampling")
"""The classes of scenarios; each counts as much as any other."""
NOISE_OF_TWIST = 10.0
"""Noise of the command, 1/s of each scaled row, for each radian of noise of a joint."""
ARRAYS = ("start", "targets", "lost", "speed", "acceleration")


@dataclass(frozen=True, eq=False)
class RobustnessScenario:
    """A motion near singular configurations: a start, the pose that is wanted at every step, and limits.

    A row is "scaled" where it is divided by `length`, if it is in metres: errors and commands are then in rad and
    rad/s, and a method that moves the tool by `length` counts as one that turns it by a radian.

    Attributes:
        name: What it is called, different for each scenario of a robot.
        kind: One of KINDS.
        exit: What becomes of its command to second order, the name of a `rik.Exit` in small letters; "" if it has none.
        place: The family of singular configurations, in words.
        robot: The robot's name.
        rows: Task rows, m of them.
        start: Joint values at the beginning, rad or m, (n,).
        targets: The pose that is wanted at each of S + 1 times, dt apart, (S + 1, 4, 4).
        lost: Directions of motion that are lost at the singular configuration, orthonormal in scaled rows, (m, k);
            none, (m, 0), where a scenario is about no single one.
        length: Metres that count as much as a radian.
        dt: Time step, s.
        gain: Feedback, 1/s.
        cap: The longest command, rad/s, in scaled rows.
        speed: Joint speed limits, rad/s or m/s, (n,).
        acceleration: Joint acceleration limits, (n,), per second of these.
        drive: Whether a drive executes commands within the limits only; else they are executed as they are.
        noise: Standard deviation of measured joint values, rad.
        seed: Of the noise.
        leavable: Whether the arm has to get away from a singular configuration, can to second order, and can reach the
            target at all.
        shown: Whether its curves are kept, for a page.
    """

    name: str
    kind: str
    exit: str
    place: str
    robot: str
    rows: tuple[str, ...]
    start: Array
    targets: Array
    lost: Array
    length: float
    dt: float
    gain: float
    cap: float
    speed: Array
    acceleration: Array
    drive: bool = False
    noise: float = 0.0
    seed: int = 0
    leavable: bool = False
    shown: bool = False

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"kind must be one of {', '.join(KINDS)}, got {self.kind!r}")
        for name in ARRAYS:
            object.__setattr__(self, name, readonly(getattr(self, name)))
        object.__setattr__(self, "rows", tuple(self.rows))

    @property
    def steps(self) -> int:
        """S, the number of time steps."""
        return len(self.targets) - 1

    @property
    def units(self) -> Array:
        """What each row is divided by, (m,)."""
        return np.array([self.length if row in ("x", "y", "z") else 1.0 for row in self.rows])

    @cached_property
    def feedforward(self) -> Array:
        """How fast the target moves, (S, m), m/s and rad/s: central differences."""
        ends = np.concatenate([self.targets[:1], self.targets, self.targets[-1:]])
        moved = pose_error(ends[:-2], ends[2:])[:-1] / (2 * self.dt)
        moved[0] *= 2  # of one side only
        return np.asarray(moved[:, [ROWS.index(row) for row in self.rows]])

    def disturbances(self) -> tuple[Array, Array]:
        """Noise of measured joint values, (S, n), and of the scaled command, (S, m): the same for every method."""
        rng = np.random.default_rng(self.seed)
        joints, rows = (rng.normal(size=(self.steps, count)) for count in (len(self.start), len(self.rows)))
        return self.noise * joints, NOISE_OF_TWIST * self.noise * rows

    def to_json(self) -> dict[str, Any]:
        """Plain values, from which `from_json` makes it again."""
        made = {each.name: getattr(self, each.name) for each in fields(self)}
        return made | {name: made[name].tolist() for name in ARRAYS} | {"rows": list(self.rows)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> RobustnessScenario:
        """What `to_json` gave.

        Raises:
            InputError: A value is missing or of no use.
        """
        try:
            lost = np.reshape(data["lost"], (len(data["rows"]), -1))
            return cls(**{**data, "lost": lost})
        except (KeyError, TypeError) as error:
            raise InputError(f"this is no scenario of the benchmark: {error}") from error
