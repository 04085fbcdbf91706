"""DHTable: an arm as Denavit-Hartenberg rows, with its pose and its Jacobian.

With Rx, Rz rotations about and Tx, Tz translations along an axis, row i stands for

* standard (distal): Aᵢ = Rz(θᵢ) Tz(dᵢ) Tx(aᵢ) Rx(αᵢ),
* modified (Craig):  Aᵢ = Rx(αᵢ₋₁) Tx(aᵢ₋₁) Rz(θᵢ) Tz(dᵢ), where row i holds αᵢ₋₁ and aᵢ₋₁,

and the tip is at base · A₁ ⋯ Aₙ · tool. Joint value qᵢ is added to θᵢ (revolute) or to dᵢ (prismatic).
"""

from __future__ import annotations

import math
import reprlib
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, readonly
from robust_ik.errors import DHError, InputError
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS, checked_rows

CONVENTIONS = ("standard", "modified")
KINDS = ("revolute", "prismatic")
RESERVED = ("tool", "universe")
MAX_JOINTS = 100  # Pinocchio's working memory grows with n³: 66 MB at 100 joints, 0.5 GB at 200

LARGEST = 1e6  # of lengths and angles as written; products overflow far above it
KEPT, SNAPPED = 1e-14, 1e-6  # a rotation this near to an exact one is kept, or replaced by it


@dataclass(frozen=True, kw_only=True)
class DHJoint:
    """One row: lengths in metres, angles in radians. A limit of None is not stated.

    Attributes:
        a: Link length; in a modified table that of the previous link.
        d: Link offset; for a prismatic joint its constant part.
        alpha: Link twist; in a modified table that of the previous link.
        theta: Joint angle; for a revolute joint its constant part.
        kind: "revolute" or "prismatic".
        lower: Lower limit of q, rad or m; a prismatic joint must state it.
        upper: Upper limit of q, rad or m; a prismatic joint must state it.
        velocity: Speed limit, rad/s or m/s.
        name: Joint name; empty for "joint1", "joint2", ... by its index in the table.

    Raises:
        DHError: A value is not valid; the message quotes it.
    """

    a: float
    d: float
    alpha: float
    theta: float = 0.0
    kind: str = "revolute"
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        label = (
            f"joint {checked_name(self.name, 'a joint name')!r}: "
            if not isinstance(self.name, str) or self.name
            else ""
        )
        if not isinstance(self.kind, str) or self.kind not in KINDS:
            raise DHError(f"{label}type must be {' or '.join(KINDS)}, got {shown(self.kind)}")
        for key in ("a", "d", "alpha", "theta"):
            object.__setattr__(self, key, checked_number(getattr(self, key), label + key))
        for key, unstated in (("lower", -math.inf), ("upper", math.inf), ("velocity", math.inf)):
            given = getattr(self, key)
            stated = given is not None and not (isinstance(given, float) and given == unstated)
            object.__setattr__(self, key, checked_number(given, label + key) if stated else None)
        self._check_limits(label)

    def _check_limits(self, label: str) -> None:
        if self.kind == "prismatic" and (self.lower is None or self.upper is None):
            given = f"{self.lower} and {self.upper}"
            raise DHError(f"{label}a prismatic joint must state lower and upper, got {given}")
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise DHError(f"{label}lower must be less than upper, got {self.lower} and {self.upper}")
        if self.velocity is not None and self.velocity <= 0:
            raise DHError(f"{label}velocity must be positive, got {self.velocity}")

    def screws(self, convention: str) -> tuple[Array, Array]:
        """The constant transforms before and after the joint's motion about or along its z axis, (4, 4) each.

        The constant parts of θ and d commute with the motion, so they are in one of the two, with a and α.
        """
        along_x, along_z = screw(0, self.alpha, self.a), screw(2, self.theta, self.d)
        return (np.eye(4), along_z @ along_x) if convention == "standard" else (along_x @ along_z, np.eye(4))


@dataclass(frozen=True, eq=False)
class DHTable:
    """A serial arm: its DH rows, base, tool, and what else a table states.

    Attributes:
        joints: Rows from the base to the tip; names are filled in.
        convention: "standard" or "modified", see the module.
        name: Name of the arm.
        rows: Task rows that matter for the arm, of x y z wx wy wz.
        base: Pose of frame 0 in the world, (4, 4), read-only.
        tool: Pose of the tip in frame n, (4, 4), read-only.
        rest: A start configuration, (n,), rad or m, read-only; or None.

    A rotation in `base` or `tool` that is written with six digits is replaced by the nearest exact one.

    Raises:
        DHError: A value in the table is not valid; the message quotes it.
    """

    joints: tuple[DHJoint, ...]
    convention: str
    name: str = field(default="robot", kw_only=True)
    rows: tuple[str, ...] = field(default=ROWS, kw_only=True)
    base: Array = field(default_factory=lambda: np.eye(4), kw_only=True)
    tool: Array = field(default_factory=lambda: np.eye(4), kw_only=True)
    rest: Array | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        checked_name(self.name, "the name of the arm")
        if not isinstance(self.convention, str) or self.convention not in CONVENTIONS:
            raise DHError(f"convention must be {' or '.join(CONVENTIONS)}, got {shown(self.convention)}")
        object.__setattr__(self, "joints", _checked_joints(self.joints))
        object.__setattr__(self, "rows", _checked_rows(self.rows))
        object.__setattr__(self, "base", checked_rigid(self.base, "base"))
        object.__setattr__(self, "tool", checked_rigid(self.tool, "tool"))
        if self.rest is not None:
            object.__setattr__(self, "rest", self._checked_rest(self.rest))

    def _checked_rest(self, rest: ArrayLike) -> Array:
        rest = checked_numbers(rest, "rest", (self.n,))
        for joint, value, lower, upper in zip(self.joints, rest, self.lower, self.upper):
            if not lower <= value <= upper:
                limits = f"[{lower:g}, {upper:g}]"
                raise DHError(f"rest is {value:g} at joint {joint.name!r}, outside its limits {limits}")
        return readonly(rest)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names from the base to the tip."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def lower(self) -> Array:
        """Lower limits, (n,), rad or m; −∞ where none is stated."""
        return readonly([-math.inf if joint.lower is None else joint.lower for joint in self.joints])

    @cached_property
    def upper(self) -> Array:
        """Upper limits, (n,), rad or m; +∞ where none is stated."""
        return readonly([math.inf if joint.upper is None else joint.upper for joint in self.joints])

    @cached_property
    def velocity(self) -> Array:
        """Speed limits, (n,), rad/s or m/s; +∞ where none is stated."""
        return readonly([math.inf if joint.velocity is None else joint.velocity for joint in self.joints])

    @cached_property
    def revolute(self) -> Array:
        """Which joints turn, (n,), bool."""
        return readonly([joint.kind == "revolute" for joint in self.joints], bool)

    @cached_property
    def placements(self) -> Array:
        """The constant transforms between the motions, (n + 1, 4, 4), base and tool included.

        With Z(q) the rotation about z or the translation along z, the tip is at P₁ Z(q₁) P₂ Z(q₂) ⋯ Z(qₙ) Pₙ₊₁.
        """
        before, after = zip(*(joint.screws(self.convention) for joint in self.joints))
        return readonly(np.stack([self.base, *after]) @ np.stack([*before, self.tool]))

    def frames(self, q: ArrayLike) -> Array:
        """The frames of the links and of the tip in the world.

        Args:
            q: Joint values, (..., n), rad or m.

        Returns:
            (..., n + 1, 4, 4): frame i lies on joint i's axis, z along it, and moves with the joint (in a
            modified table it is Craig's frame {i}); the last one is the tip.
        """
        q = as_array(q, "q", (self.n,))
        motions = screw(2, np.where(self.revolute, q, 0.0), np.where(self.revolute, 0.0, q))
        result = np.empty((*q.shape[:-1], self.n + 1, 4, 4))
        result[..., 0, :, :] = self.placements[0]
        for i in range(self.n):
            result[..., i, :, :] = result[..., i, :, :] @ motions[..., i, :, :]
            result[..., i + 1, :, :] = result[..., i, :, :] @ self.placements[i + 1]
        return result

    def pose(self, q: ArrayLike) -> Array:
        """The pose of the tip in the world: (..., n) in rad or m → (..., 4, 4)."""
        return self.frames(q)[..., -1, :, :].copy()

    def jacobian(self, q: ArrayLike) -> Array:
        """The geometric Jacobian of the tip: twist = J q̇.

        Column i is (zᵢ × (p − oᵢ), zᵢ) for a revolute and (zᵢ, 0) for a prismatic joint.

        Args:
            q: Joint values, (..., n), rad or m.

        Returns:
            (..., 6, n), all six rows whatever `rows` says: linear then angular, world axes, at the tip.
        """
        frames = self.frames(q)
        axes, origins = frames[..., :-1, :3, 2], frames[..., :-1, :3, 3]
        turns = self.revolute[:, None]
        linear = np.where(turns, np.cross(axes, frames[..., -1:, :3, 3] - origins), axes)
        columns = np.concatenate([linear, np.where(turns, axes, 0.0)], axis=-1)
        return np.ascontiguousarray(np.swapaxes(columns, -1, -2))


def screw(axis: int, angle: ArrayLike, length: ArrayLike) -> Array:
    """Rotation about and translation along one axis, (..., 4, 4).

    Args:
        axis: 0, 1 or 2 for x, y or z.
        angle: (...), rad.
        length: (...), m.
    """
    angle, length = np.broadcast_arrays(np.asarray(angle, dtype=float), np.asarray(length, dtype=float))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result = np.zeros((*angle.shape, 4, 4))
    result[..., axis, axis] = result[..., 3, 3] = 1.0
    result[..., i, i] = result[..., j, j] = np.cos(angle)
    result[..., j, i] = np.sin(angle)
    result[..., i, j] = -np.sin(angle)
    result[..., axis, 3] = length
    return result


def _checked_joints(joints: Iterable[DHJoint]) -> tuple[DHJoint, ...]:
    if not isinstance(joints, (list, tuple)) or not all(isinstance(joint, DHJoint) for joint in joints):
        raise DHError(f"joints must be a sequence of DHJoint, got {shown(joints)}")
    if not 1 <= len(joints) <= MAX_JOINTS:
        raise DHError(f"a DH table needs from 1 to {MAX_JOINTS} joints, got {len(joints)}")
    named = tuple(replace(joint, name=joint.name or f"joint{i}") for i, joint in enumerate(joints, start=1))
    for name, count in Counter(joint.name for joint in named).items():
        if count > 1:
            raise DHError(f"two joints are called {name!r}")
        if name in RESERVED:
            raise DHError(f"a joint cannot be called {name!r}: the arm has a frame of that name already")
    return named


def _checked_rows(rows: Iterable[str]) -> tuple[str, ...]:
    try:
        return checked_rows(rows)  # type: ignore[arg-type]
    except InputError as error:
        raise DHError(str(error)) from None


def shown(value: object) -> str:
    """The value, as a message quotes it."""
    return reprlib.repr(value)


def checked_number(value: object, what: str) -> float:
    """The value as a finite float, or a DHError."""
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    except OverflowError:
        number = math.inf
    if not abs(number) <= LARGEST:
        raise DHError(f"{what} must be a finite number of at most {LARGEST:g}, got {shown(value)}")
    return number


def checked_numbers(value: ArrayLike, what: str, shape: tuple[int, ...]) -> Array:
    """Finite numbers of exactly this shape, or a DHError."""
    try:
        array = as_array(value, what, shape)
    except InputError as error:
        raise DHError(str(error)) from None
    if array.ndim != len(shape):
        raise DHError(f"{what} must have shape {shape}, got {array.shape}")
    if any(isinstance(item, bool) or not isinstance(item, Real) for item in np.asarray(value, dtype=object).flat):
        raise DHError(f"{what} must hold numbers, got {shown(value)}")
    if not (np.abs(array) <= LARGEST).all():
        raise DHError(f"{what} must hold numbers of at most {LARGEST:g}, got {shown(array.tolist())}")
    return array


def checked_name(value: object, what: str) -> str:
    """Printable text, or a DHError."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise DHError(f"{what} must be printable text, got {shown(value)}")
    return value


def checked_rigid(value: ArrayLike, what: str) -> Array:
    """A read-only pose, or a DHError; a rotation off by rounding is replaced by the nearest exact one."""
    pose = checked_numbers(value, what, (4, 4)).copy()
    rotation = pose[:3, :3]
    error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if error > SNAPPED or np.linalg.det(rotation) < 0 or not np.array_equal(pose[3], [0, 0, 0, 1]):
        given = shown(pose.tolist())
        raise DHError(f"{what} must be a rotation and a translation with last row 0 0 0 1, got {given}")
    if error > KEPT:
        nearest = svd(rotation)
        pose[:3, :3] = nearest.U @ nearest.Vt
    return readonly(pose)
