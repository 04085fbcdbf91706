"""Speed of a tool while its joints brake: acceleration limits do not let them stop at once when a cap is met."""

from __future__ import annotations

import math

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.reaching.path import FINE, Caps
from robust_ik.control.reaching.search_space import Space

MOST_SAMPLES = 40
"""Most samples of one braking motion. Chosen: two metres or radians at FINE; more see more, but slow every step."""
LATER = 0.99
"""Fraction of a cap that is allowed while braking: between samples, and one step later, it may be a little more."""


def braking_ratio(space: Space, caps: Caps, q: Array, qdot: Array, dt: float) -> float:
    """The largest ratio of the tool's speed to its cap, in this step and while its joints brake from it to rest.

    From a velocity with a ratio of at most 1, the braking of `braked` keeps the caps.

    Args:
        space: The robot, its frame and its limits.
        caps: Caps on the tool's speed.
        q: Configuration, (nq,).
        qdot: Joint velocities of this step, (n,).
        dt: Length of a step, s.

    Returns:
        At most 1 if the caps are kept; sampled every FINE rad or m of the joint that goes furthest.
    """
    moving = np.zeros_like(qdot)
    moving[space.joints] = qdot[space.joints]
    x = space.values(q)
    gone, speeds = braked(space, x, moving, dt)
    J = space.robot.chain(space.frame).jacobians(space.robot.configuration(x + gone), "local_world_aligned")
    twists = (J @ speeds[..., None])[..., 0]
    with np.errstate(divide="ignore"):
        ratios = 1.0 / caps.share(twists)
    return max(float(ratios[0]), float(ratios[1:].max(initial=0.0)) / LATER)


def braked(space: Space, x: Array, qdot: Array, dt: float) -> tuple[Array, Array]:
    """Joint motions of braking together in constant ratios, but for joints that must brake harder before their limits.

    Together they continue along a straight line and come to rest as quickly as the joint that needs longest. A joint
    whose limit is nearer than that continues likewise until only its full acceleration stops it in time.

    Args:
        space: Limits of positions and accelerations.
        x: Joint values, (n,).
        qdot: Joint velocities, (n,), which last for one more step; zero for joints that do not move the frame.
        dt: Length of a step, s.

    Returns:
        The distances gone by the joints, (k, n), and their velocities there, (k, n); the first row is now.
    """
    gain = min(space.gain, 1.0 / dt)
    speed, hardest = np.abs(qdot), np.where(np.isfinite(space.acceleration), space.acceleration, 1e9)
    whole = max(float((speed / hardest).max()), 1e-9)  # time to rest, s
    rate = speed / whole
    count = min(MOST_SAMPLES, 2 + math.ceil(0.5 * whole * float(speed.max()) / FINE))
    share = 1.0 - np.sqrt(1.0 - np.linspace(0.0, 1.0, count)[:-1])  # fractions of that time, with equal ways in between
    time = share[:, None] * whole
    whole_room = np.where(qdot > 0, space.upper - x, x - space.lower)
    slow = np.minimum(speed, hardest / gain)  # below this speed its gain brings it to rest, which takes longer
    room = whole_room - (slow / gain - 0.5 * slow**2 / hardest) - dt * speed
    stop = 0.5 * speed * whole
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = (hardest * np.maximum(room, 0.0) - rate * stop) / (hardest - rate)  # where both curves meet
    turn = np.where(room < stop, np.clip(turn, 0.0, stop), np.inf)
    fast = np.sqrt(np.maximum(speed**2 - 2 * rate * np.where(np.isfinite(turn), turn, 0.0), 0.0))
    met = np.where(np.isfinite(turn), (speed - fast) / np.maximum(rate, 1e-300), np.inf)
    after = np.clip(time - np.where(np.isfinite(met), met, 0.0), 0.0, fast / hardest)
    late = time > met
    velocity = np.where(late, fast - hardest * after, speed - rate * time)
    way = np.where(
        late,
        np.where(np.isfinite(turn), turn, 0.0) + fast * after - 0.5 * hardest * after**2,
        speed * time - 0.5 * rate * time**2,
    )
    way = np.minimum(way + 0.5 * dt * speed * share[:, None], np.maximum(whole_room, 0.0))  # in steps it is longer
    velocity[1:] = np.minimum(velocity, gain * (whole_room - way))[1:]  # slower at the very end
    return np.sign(qdot) * way, np.sign(qdot) * np.maximum(velocity, 0.0)
