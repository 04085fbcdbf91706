"""Joints and frames of a robot: a Pinocchio model with a tip and limits, whose kinematics are functions of q.

Default reference of Jacobians and Hessians: LOCAL_WORLD_ALIGNED (the tip's point, the world's axes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, alone, as_array, check_leading_axes, readonly
from robust_ik.description.joint_tree import Description
from robust_ik.errors import TipError, listed
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.pose_ik.arm_size import find_size, is_usual, offsets_of, unit_of
from robust_ik.robot.joint_map import JointMap
from robust_ik.robot.pinocchio_model import Data, Model, PinocchioModel

Reference = Literal["local", "world", "local_world_aligned"]


@dataclass(frozen=True, eq=False)
class RobotKinematics:
    """The joints and frames of an arm or a tree, as functions of q; all of it is part of `Robot`.

    It has two parts: a Pinocchio model, and a map from its independent joints to the joints of the model. Pinocchio
    computes single configurations. For many at once, compiled kernels work with constants of the model (`chain`); their
    results are Pinocchio's up to rounding.

    `Robot` says what its fields are.
    """

    name: str
    tip: str | None
    rows: tuple[str, ...]
    description: Description
    lower: Array
    upper: Array
    velocity_limit: Array
    rest: Array
    _pinocchio: PinocchioModel = field(repr=False)
    _joints: JointMap = field(repr=False)
    guess: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "velocity_limit", "rest"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, since copies must be read-only too.
        return type(self), tuple(getattr(self, each.name) for each in fields(self))

    # -------------------------------------------------------------------------------------------------------- joints
    @property
    def n(self) -> int:
        """Number of independent joints, the length of q̇."""
        return len(self._joints.names)

    @property
    def nq(self) -> int:
        """Length of q: n plus the number of continuous joints, each of which is stored as (cos, sin)."""
        return self._joints.nq

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The independent joints, in the order of q̇."""
        return self._joints.names

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """Which of the independent joints slide, (n,)."""
        return self._joints.prismatic

    @property
    def neutral(self) -> Array:
        """The configuration of all joints at zero, (nq,); it may lie outside the limits."""
        return self._joints.configuration(np.zeros(self.n))

    def configuration(self, values: ArrayLike) -> Array:
        """Joint values (..., n) in rad or m → q (..., nq)."""
        return self._joints.configuration(as_array(values, "values", (self.n,)))

    def joint_values(self, q: ArrayLike) -> Array:
        """Configurations q (..., nq) → joint values (..., n) in rad or m; continuous joints in (−π, π]."""
        return self._joints.values(self._checked(q))

    def random(self, rng: np.random.Generator, size: int | tuple[int, ...] = ()) -> Array:
        """Uniform random configurations inside the limits, (*size, nq).

        Without stated limits: a full turn for a revolute joint, twice `length_scale` for a prismatic one.
        """
        return self._joints.random(rng, size, self.lower, self.upper, self.length_scale)

    def integrate(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """Q ⊕ dq on the manifold: (..., nq) and (..., n) → (..., nq), leading axes broadcast."""
        q, dq = self._checked(q), as_array(dq, "dq", (self.n,))
        check_leading_axes("q", q.shape[:-1], "dq", dq.shape[:-1])
        return self._joints.integrate(q, dq)

    def difference(self, q_from: ArrayLike, q_to: ArrayLike) -> Array:
        """The dq with q_from ⊕ dq = q_to, (..., n); the short way round for continuous joints."""
        q_from, q_to = self._checked(q_from), self._checked(q_to)
        check_leading_axes("q_from", q_from.shape[:-1], "q_to", q_to.shape[:-1])
        return self._joints.difference(q_from, q_to)

    def _checked(self, q: ArrayLike) -> Array:
        return self._joints.checked(q, self.name)

    # -------------------------------------------------------------------------------------------------------- frames
    @property
    def model(self) -> Model:
        """The Pinocchio model, with a joint of its own for each mimic joint. It must not be changed."""
        return self._pinocchio.model

    def create_data(self) -> Data:
        """New working memory for `model`, for direct calls of Pinocchio."""
        return self.model.createData()

    def pinocchio_q(self, q: ArrayLike) -> Array:
        """Pinocchio's configuration (model.nq,), mimic joints included, of one configuration (nq,)."""
        return self._joints.all_joints(alone(self._checked(q), "q", 1)).copy()

    @property
    def mixing(self) -> Array:
        """Velocities of the N joints of `model`, mimic joints included, are `mixing` @ q̇, (N, n)."""
        return self._joints.mixing

    @property
    def frames(self) -> tuple[str, ...]:
        """Every frame name: links and joints."""
        return tuple(self._pinocchio.frames)

    def chain(self, frame: str | None = None) -> Chain:
        """The joints that move a frame, as constants for compiled code.

        Args:
            frame: Link or joint; default the tip.
        """
        return self._pinocchio.chain(self._frame_index(frame))

    def pose(self, q: ArrayLike, frame: str | None = None) -> Array:
        """The pose of a frame in the world.

        Args:
            q: Configurations, (..., nq).
            frame: Link or joint; default the tip.

        Returns:
            Homogeneous transforms, (..., 4, 4).
        """
        q = self._checked(q)
        if q.ndim == 1:
            return self._pinocchio.pose(q, self._frame_index(frame))
        return self.chain(frame).poses(q)

    def jacobian(
        self,
        q: ArrayLike,
        frame: str | None = None,
        reference: Reference = "local_world_aligned",
        *,
        rows: Sequence[str] | None = None,
    ) -> Array:
        """The geometric Jacobian of a frame: twist = J q̇.

        Args:
            q: Configurations, (..., nq).
            frame: Link or joint; default the tip.
            reference: "local_world_aligned" (the frame's point, world axes), "local" (the frame's point and
                axes) or "world" (the world's origin and axes).
            rows: Task rows, of x y z wx wy wz; default `self.rows`.

        Returns:
            (..., len(rows), n), rows linear then angular, in m and rad per rad or m.
        """
        q = self._checked(q)
        if q.ndim == 1:
            return self._select(self._pinocchio.jacobian(q, self._frame_index(frame), reference), rows, axis=-2)
        return self._select(self.chain(frame).jacobians(q, reference), rows, axis=-2)

    def hessian(
        self,
        q: ArrayLike,
        frame: str | None = None,
        reference: Reference = "local_world_aligned",
        *,
        rows: Sequence[str] | None = None,
    ) -> Array:
        """The derivative of the Jacobian: [i, j, k] = ∂J_ij/∂q_k.

        Args:
            q: Configurations, (..., nq).
            frame: As for `jacobian`.
            reference: As for `jacobian`.
            rows: As for `jacobian`.

        Returns:
            (..., len(rows), n, n).
        """
        q = self._checked(q)
        if q.ndim == 1:
            return self._select(self._pinocchio.hessian(q, self._frame_index(frame), reference), rows, axis=-3)
        return self._select(self.chain(frame).hessians(q, reference), rows, axis=-3)

    def singular_value_gradients(
        self, q: ArrayLike, frame: str | None = None, *, rows: Sequence[str] | None = None
    ) -> Array:
        """∂σᵢ/∂q_k of the Jacobian, world axes at the frame's point, without its Hessian.

        It equals `robust_ik.singular_value_gradients` of `jacobian` and `hessian`; see there for σ = 0 and for equal
        singular values.

        Args:
            q: Configurations, (..., nq).
            frame: As for `jacobian`.
            rows: As for `jacobian`.

        Returns:
            (..., k, n) with k = min(len(rows), n); row i belongs to σᵢ.
        """
        q, names = self._checked(q), self.rows if rows is None else checked_rows(rows)
        gradients = self.chain(frame).singular_value_gradients(q.reshape(-1, self.nq), names)
        return gradients.reshape(*q.shape[:-1], *gradients.shape[1:])

    def _select(self, array: Array, rows: Sequence[str] | None, axis: int) -> Array:
        names = self.rows if rows is None else checked_rows(rows)
        if names == ROWS:
            return array
        return np.take(array, [ROWS.index(name) for name in names], axis=axis)

    def _frame_index(self, name: str | None) -> int:
        name = self.tip if name is None else name
        if name is None:
            raise TipError(
                f"{self.name} was loaded whole, without a tip: name a frame; its leaves are "
                + listed(self.description.leaves)
            )
        return self._pinocchio.index(name, self.name, self.description)

    # ---------------------------------------------------------------------------------------------------------- size
    @cached_property
    def size(self) -> float:
        """The distance that the links from the first axis to the tip span, m; 0 if no joint moves the tip's point.

        Slides are taken as close to zero as their limits allow; their travel counts only if the links are short of a
        metre, that of mobile bases never. For a whole tree it is the size of the limb with the longest offsets.
        """
        held = [self.description.joint[name].part_of != "" for name in self.joint_names]
        return find_size(self._longest_chain, np.where(held, 0.0, self.lower), np.where(held, 0.0, self.upper))

    @cached_property
    def length_scale(self) -> float:
        """The length that stands for one metre in comparisons of lengths with angles or tolerances, m per rad.

        It is 1 m for robots of 0.2 to 10 m, else the power of two closest to their `size`. So a robot behaves alike in
        any unit of length.
        """
        return 1.0 if is_usual(self._longest_chain) else unit_of(self.size)

    @cached_property
    def _longest_chain(self) -> Chain:
        if self.tip is not None:
            return self.chain()
        return max(map(self.chain, self.description.leaves), key=lambda chain: float(offsets_of(chain)[1:].sum()))
