"""Options of inverse kinematics: checked, and packed for kernels."""

from __future__ import annotations

from typing import Literal, TypedDict

import numpy as np

from robust_ik.checks import Array, checked_parameter, readonly
from robust_ik.errors import InputError
from robust_ik.kernels.pose import pose_layout as lay

Prefer = Literal["nearest", "any", "limits", "singularity"]
Effort = Literal["normal", "thorough"]


class PoseOptions(TypedDict, total=False):
    """Options of `Robot.solve_pose`.

    Attributes:
        prefer: Which solution to return if there are several. "nearest" (default): the one found from q0, else the
            first found; with thorough effort or several solutions, the one nearest to q0 in joint values.
            "any": the first found without a start from q0. "limits": of 8 distinct ones or more, the
            one whose least distance to a limit, as a fraction of half the joint's range, is largest. "singularity": the
            one with the largest least singular value, rotations times the length scale.
        solutions: How many distinct ones to look for, 1 to 64; fewer may exist, or be found.
        effort: "normal", or "thorough", which gains the last percent of distance if the target is out of reach, or
            compares 32 solutions: a few milliseconds.
        position_tolerance: Of a solution, m; default 1e-8 times the robot's length scale, which is 1 m for usual ones.
        rotation_tolerance: Of a solution, rad; default 1e-8.
        length_scale: L, m per rad: the weight of rotations against distances; default the robot's, 1 for usual ones.
        apart: Least difference of two solutions in some joint, modulo full turns, rad, or times the robot's length
            scale for a joint that slides; default 0.1.
        rng: For random starts; by default the same ones for every call.
    """

    prefer: Prefer
    solutions: int
    effort: Effort
    position_tolerance: float | None
    rotation_tolerance: float
    length_scale: float | None
    apart: float
    rng: np.random.Generator | None


PREFERENCES = {
    "nearest": lay.NEAREST,
    "any": lay.ANY,
    "limits": lay.LIMITS,
    "singularity": lay.SINGULARITY,
}
EFFORTS = ("normal", "thorough")
POSITION_TOLERANCE = 1e-8
"""Tolerance of positions, in units of length. Chosen: far above rounding, far below what arms repeat."""
CANDIDATES, MORE_CANDIDATES = 8, 32
"""Solutions that are compared if the best one is asked for, with normal and with thorough effort."""
STARTS, STARTS_EACH = 24, 16
"""Starts after which no more solutions are looked for, and further starts for each solution wanted."""


def pack_options(
    prefer: str,
    solutions: int,
    effort: str,
    position: float | None,
    rotation: float,
    scale: float | None,
    apart: float,
    *,
    seed: int,
    unit: float = 1.0,
) -> Array:
    """The options as a vector for kernels, see `kernels.pose.pose_layout`; arguments as for `PoseSolver.solve`.

    Raises:
        InputError: One of them is not valid.
    """
    if not isinstance(prefer, str) or prefer not in PREFERENCES:
        raise InputError(f"prefer must be one of {', '.join(PREFERENCES)}, got {prefer!r}")
    if not isinstance(effort, str) or effort not in EFFORTS:
        raise InputError(f"effort must be one of {', '.join(EFFORTS)}, got {effort!r}")
    whole = isinstance(solutions, (int, np.integer)) and not isinstance(solutions, bool)
    if not whole or not 1 <= solutions <= lay.MOST_FOUND:
        raise InputError(f"solutions must be a whole number from 1 to {lay.MOST_FOUND}, got {solutions!r}")
    thorough = effort == "thorough"
    compared = prefer in ("limits", "singularity") or (thorough and prefer == "nearest")
    wanted = max(int(solutions), (MORE_CANDIDATES if thorough else CANDIDATES) if compared else 1)
    packed = np.zeros(lay.OPTIONS)
    packed[lay.POSITION_TOLERANCE] = POSITION_TOLERANCE
    if position is not None:
        packed[lay.POSITION_TOLERANCE] = checked_parameter("position_tolerance", position, above=0) / unit
    packed[lay.ROTATION_TOLERANCE] = checked_parameter("rotation_tolerance", rotation, above=0)
    packed[lay.SCALE] = 1.0 if scale is None else checked_parameter("length_scale", scale, above=0) / unit
    packed[lay.APART] = checked_parameter("apart", apart, above=0)
    packed[lay.PREFER], packed[lay.WANTED], packed[lay.RANDOM] = PREFERENCES[prefer], wanted, seed
    packed[lay.POLISHED], packed[lay.THOROUGH] = lay.MOST_POLISHED, thorough
    packed[lay.STARTS] = STARTS + STARTS_EACH * wanted
    return readonly(packed)
