"""Position, velocity and acceleration limits of the joints.

One class, because they depend on each other: how fast a joint may go towards its end depends on how fast it can stop.
"""

from __future__ import annotations

import reprlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_array, checked_cap, checked_parameter, readonly
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits.base import Limit
from robust_ik.errors import InputError
from robust_ik.robot.robot import Robot

GAIN = 20.0
"""Largest rate at which a joint uses up the way to its end, 1/s: it slows down a twentieth of a second before."""
LEAST = 1e-9
"""Least acceleration limit, rad/s² or m/s²: with less, nothing moves."""


@dataclass(frozen=True, eq=False)
class JointLimits(Limit):
    """Limits of every joint; infinite entries are no limits. `JointLimits.of(robot)` takes them from the robot.

    With a finite acceleration a joint brakes in time: from rest, no sequence of steps of equal length needs more
    acceleration to stay inside. A joint outside its limits comes back at no more than `recovery_speed`, and never goes
    further out. Towards an end, and back to it, a joint uses up the way at a rate of at most `gain`, so that it comes
    to rest there and does not shake with measurement noise. If limits contradict each other (a joint too fast to stop),
    position wins over velocity, and both win over acceleration; the resolution then says so.

    Attributes:
        lower: Lower position limits, (n,), rad or m.
        upper: Upper position limits, (n,).
        velocity: Speed limits, (n,), rad/s or m/s.
        acceleration: Acceleration limits, (n,), rad/s² or m/s².
        recovery_speed: Speed at which a joint outside its limits comes back, rad/s or m/s.
        joint_names: Names for messages, n strings.
        gain: Largest rate at which the way to an end is used up, 1/s; at most 1/dt has effect.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    recovery_speed: float
    joint_names: tuple[str, ...]
    gain: float = GAIN

    @classmethod
    def of(
        cls,
        robot: Robot,
        *,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        margin: ArrayLike = 0.0,
        recovery_speed: float = 0.1,
        gain: float = GAIN,
    ) -> Self:
        """Limits of a robot: its own, or others in their place.

        Args:
            robot: The robot.
            lower: Lower position limits, (n,) or one for all, rad or m; default the robot's.
            upper: Upper position limits; default the robot's.
            velocity: Speed limits, rad/s or m/s; default the robot's.
            acceleration: Acceleration limits, rad/s² or m/s²; default none, as URDFs have none.
            margin: Distance to keep from position limits, rad or m.
            recovery_speed: Speed at which a joint outside its limits comes back, rad/s or m/s.
            gain: Largest rate at which the way to an end is used up, 1/s; infinite to go there in one step.

        Raises:
            InputError: A limit has another shape, is NaN or negative, or lower limits exceed upper ones.
        """
        check_type("robot", robot, "Robot")
        low = _per_joint(robot, "lower", robot.lower if lower is None else lower)
        high = _per_joint(robot, "upper", robot.upper if upper is None else upper)
        keep = _checked("margin", _per_joint(robot, "margin", margin), 0.0)
        return cls(
            lower=low + keep,
            upper=high - keep,
            velocity=_per_joint(robot, "velocity", robot.velocity_limit if velocity is None else velocity),
            acceleration=_per_joint(robot, "acceleration", np.inf if acceleration is None else acceleration),
            recovery_speed=recovery_speed,
            gain=gain,
            joint_names=robot.joint_names,
        )

    def __post_init__(self) -> None:
        for name, least in (("lower", -np.inf), ("upper", -np.inf), ("velocity", 0.0), ("acceleration", LEAST)):
            value = readonly(getattr(self, name))
            if value.shape != (len(self.joint_names),):
                raise InputError(f"{name} must be one for each of {len(self.joint_names)} joints, got {value.shape}")
            object.__setattr__(self, name, _checked(name, value, least))
        checked_parameter("recovery_speed", self.recovery_speed, above=0)
        object.__setattr__(self, "gain", checked_cap("gain", self.gain))
        for name, a, b in zip(self.joint_names, self.lower, self.upper):
            if a > b or a == np.inf or b == -np.inf:
                raise InputError(f"lower + margin ≤ upper − margin must hold, got {a:g} and {b:g} for {name}")

    def bounds(self, robot: Robot, q: Array, previous: Array, dt: float) -> Bounds:
        """The box for the next step; see `Limit.bounds`."""
        if self.joint_names != robot.joint_names:
            raise InputError(
                f"these limits are for {', '.join(self.joint_names)}, {robot.name} has {', '.join(robot.joint_names)}"
            )
        values = robot.joint_values(q)
        above, below = self.upper - values, values - self.lower
        upper, lower = self._ceiling(above, previous, dt), -self._ceiling(below, -previous, dt)
        # A joint outside comes back no faster than it can stop before its other end.
        upper, lower = (
            np.where(above < 0, np.maximum(upper, lower), upper),
            np.where(below < 0, np.minimum(upper, lower), lower),
        )
        box = Bounds(
            lower=np.clip(lower, -self.velocity, self.velocity),
            upper=np.clip(upper, -self.velocity, self.velocity),
            lower_cause=np.where(lower > -self.velocity, self._names["position"], self._names["velocity"]),
            upper_cause=np.where(upper < self.velocity, self._names["position"], self._names["velocity"]),
            fastest=self.velocity,
        )
        change, names = self.acceleration * dt, self._names["acceleration"]
        if not np.isfinite(change).any():
            return box
        hurried = Bounds(previous - change, previous + change, names, names).within(box)
        return replace(hurried, unhurried=(box.lower, box.upper), last=previous)

    def _ceiling(self, room: Array, previous: Array, dt: float) -> Array:
        """The largest speed towards an end at distance `room`; negative if the joint is beyond it."""
        gain = min(self.gain, 1 / dt)
        least = np.maximum(
            -np.minimum(self.recovery_speed, -gain * room), np.minimum(previous - self.acceleration * dt, 0.0)
        )
        return np.where(room < 0, least, braking_speed(np.maximum(room, 0.0), self.acceleration, dt, gain))

    @cached_property
    def _names(self) -> dict[str, NDArray[np.str_]]:
        return {
            kind: np.array([f"{name} {kind}" for name in self.joint_names])
            for kind in ("position", "velocity", "acceleration")
        }


def braking_speed(room: Array, acceleration: Array, dt: float, gain: float = np.inf) -> Array:
    """The largest speed in the next step from which a joint can still stop within `room`.

    From v on, a joint slows down in steps of dt, first by a dt a step to a/gain, then by the fraction gain·dt of its
    speed a step. It goes dt (v + (v − a dt) + …) + w/gain until it rests, w ≤ a/gain being the first speed of the
    second part. That is at most `room`. Without an acceleration limit it is v/gain.

    Args:
        room: Distances, (n,), rad or m, ≥ 0, possibly infinite.
        acceleration: (n,), rad/s² or m/s², > 0, possibly infinite.
        dt: Step, s.
        gain: Largest rate at which the remaining way is used up, 1/s; at most 1/dt has effect.
    """
    gain = min(gain, 1 / dt)
    limited = np.isfinite(acceleration) & np.isfinite(room)
    drop = np.where(limited, acceleration, 1.0) * dt
    left, soft = np.where(limited, room, 0.0), drop / (dt * gain)
    linear = 0.5 + soft / drop
    steps = np.ceil(np.sqrt(linear**2 + np.maximum(2 * (left - soft / gain) / (drop * dt), 0.0)) - linear)
    slow = (left - drop * dt * steps * (steps + 1) / 2) / (steps * dt + 1 / gain)
    return np.where(limited, slow + steps * drop, gain * room)


def _per_joint(robot: Robot, name: str, value: ArrayLike) -> Array:
    """One number for every joint."""
    try:
        return np.array(np.broadcast_to(as_array(value, name, (), finite=False), (robot.n,)))
    except (InputError, ValueError):
        raise InputError(f"{name} must be one number or {robot.n}, one per joint, got {reprlib.repr(value)}") from None


def _checked(name: str, array: Array, least: float) -> Array:
    """Numbers that are at least `least`, infinite for no limit."""
    if np.isnan(array).any() or (array < least).any():
        wanted = "a number" if least == -np.inf else "> 0" if least else "≥ 0"
        raise InputError(f"{name} must be {wanted} for every joint, infinite for no limit, got {array}")
    return array
