"""The motion that is lost along a whole stratum, in words: what is the same at every sample."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values
from robust_ik.singularities.lost_motion.axis_landmarks import SAME, Axes, Landmark
from robust_ik.singularities.lost_motion.lost_motion import LostMotion
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew

ROW_NAMES = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")


def in_words(lost: Sequence[LostMotion], axes: Sequence[Axes], named: Sequence[Landmark], unit: float = 1.0) -> str:
    """The wrenches that the structure bears by itself at every sample, and so the motions that the tool cannot make.

    Args:
        lost: The lost motion at each sample of a stratum, all of one corank.
        axes: The joint axes there.
        named: The arm's landmarks.
        unit: The unit of length of all these, m.
    """
    if not lost:
        return "nothing is known: no samples"
    if lost[0].corank == 1:
        return _one([each.screws[0] for each in lost], axes, named, unit)
    return _several(lost, axes, named)


def _one(screws: Sequence[WrenchScrew], axes: Sequence[Axes], named: Sequence[Landmark], unit: float) -> str:
    place = _place(screws, axes, named)
    if all(screw.is_couple for screw in screws):
        return f"pure couple{_along(screws, axes)}"
    if all(screw.is_force for screw in screws):
        return f"pure force {place}".rstrip()
    pitches = np.array([screw.pitch for screw in screws])
    if np.isfinite(pitches).all() and np.ptp(pitches) < SAME:
        return f"wrench of pitch {unit * pitches[0]:.4g} m/rad {place}".rstrip()
    return f"screw of varying pitch {place}".rstrip()


def _place(screws: Sequence[WrenchScrew], axes: Sequence[Axes], named: Sequence[Landmark]) -> str:
    """The place of the line at every sample, in words."""
    on = [mark for mark in named if _always(screw.distance(mark.at(each)) < SAME for screw, each in zip(screws, axes))]
    if len(on) > 1:
        return f"along the line through {' and '.join(str(mark) for mark in on)}"
    own = _same_line(screws, axes)
    if own:
        return f"along axis {own[0]}"
    parallel = _along(screws, axes)
    if on:
        return f"through {on[0]}{',' if parallel else ''}{parallel}"
    return parallel.strip()


def _along(screws: Sequence[WrenchScrew], axes: Sequence[Axes]) -> str:
    """The joint axes to which the screw is parallel at every sample."""
    count = len(axes[0].directions)
    parallel = [
        str(i + 1)
        for i in range(count)
        if _always(np.linalg.norm(np.cross(screw.axis, each.directions[i])) < SAME for screw, each in zip(screws, axes))
    ]
    if not parallel:
        return ""
    return f" parallel to {'axis' if len(parallel) == 1 else 'axes'} {' and '.join(parallel)}"


def _same_line(screws: Sequence[WrenchScrew], axes: Sequence[Axes]) -> list[int]:
    """Joints, from 1, on whose axis the screw lies at every sample."""
    return [
        i + 1
        for i in range(len(axes[0].directions))
        if axes[0].turning[i]
        and _always(
            screw.distance(each.points[i]) < SAME and np.linalg.norm(np.cross(screw.axis, each.directions[i])) < SAME
            for screw, each in zip(screws, axes)
        )
    ]


def _several(lost: Sequence[LostMotion], axes: Sequence[Axes], named: Sequence[Landmark]) -> str:
    """The words for more than one lost direction: what is the same throughout."""
    k = lost[0].corank
    first = lost[0].tool_twists
    same = _always(_spans(first, each.tool_twists) for each in lost)
    if same and ((np.abs(first) > 1 - SAME).sum(axis=0) == 1).all():
        names = [ROW_NAMES[int(np.abs(column).argmax())] for column in first.T]
        return f"{', '.join(names)} along the tool's axes"
    parts = []
    for mark in named:
        sizes = {_forces_through(each, mark.at(a)) for each, a in zip(lost, axes)}
        if len(sizes) == 1 and (size := sizes.pop()):
            parts.append(f"{AMOUNTS[size]} through {mark}{' in a plane' if size == 2 else ''}")
    couples = {_dimension_without(each.twists[:3]) for each in lost}
    if len(couples) == 1 and (size := couples.pop()):
        parts.append("a couple" if size == 1 else f"couples of {size} directions")
    return f"a space of {k} wrenches{': ' if parts else ''}{', '.join(parts)}"


AMOUNTS = {1: "a force", 2: "every force", 3: "every force"}


def _spans(a: Array, b: Array) -> bool:
    """Whether orthonormal columns span the same space."""
    return bool(np.linalg.norm(a - b @ (b.T @ a)) < SAME)


def _forces_through(lost: LostMotion, point: Array) -> int:
    """The dimension of the lost wrenches that are pure forces through a point."""
    screws = lost.twists
    about = screws[3:] - np.cross(point - lost.origin, screws[:3].T).T
    return _dimension_without(about)


def _dimension_without(part: Array) -> int:
    """The dimension of the combinations of columns whose sum is zero."""
    return int(np.count_nonzero(singular_values(part) < SAME) + max(part.shape[1] - part.shape[0], 0))


def _always(conditions: Iterable[object]) -> bool:
    return all(bool(each) for each in conditions)
