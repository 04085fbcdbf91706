"""How a robot's frames move: poses, Jacobians and their derivatives as functions of q."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.description.joint_tree import Description
from robust_ik.errors import FrameNotFoundError, InputError, TipError, listed, suggest
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.robot.configurations import Configurations
from robust_ik.robot.pinocchio_model import Kinematics

if TYPE_CHECKING:
    import pinocchio as pin

Reference = Literal["local", "world", "local_world_aligned"]


class FrameKinematics(Configurations):
    """A part of `Robot`: what its frames do, whatever was asked before."""

    tip: str | None
    rows: tuple[str, ...]
    description: Description
    _kinematics: Kinematics

    @property
    def model(self) -> pin.Model:
        """The Pinocchio model; a mimic joint is a joint of its own there. Not to be changed."""
        return self._kinematics.model

    @property
    def frames(self) -> tuple[str, ...]:
        """Every frame name: links and joints."""
        return tuple(self._kinematics.frames)

    def chain(self, frame: str | None = None) -> Chain:
        """The joints that move a frame, as constants: what compiled code reads.

        Args:
            frame: Link or joint; default the tip.
        """
        return self._kinematics.chain(self._frame_index(frame), self._joints)

    def pose(self, q: ArrayLike, frame: str | None = None) -> Array:
        """The pose of a frame in the world.

        Args:
            q: Configurations, (..., nq).
            frame: Link or joint; default the tip.

        Returns:
            Homogeneous transforms, (..., 4, 4).
        """
        return self.chain(frame).poses(self._checked(q))

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
        return self._select(self.chain(frame).jacobians(self._checked(q), reference), rows, axis=-2)

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
        return self._select(self.chain(frame).hessians(self._checked(q), reference), rows, axis=-3)

    def singular_value_gradients(
        self, q: ArrayLike, frame: str | None = None, *, rows: Sequence[str] | None = None
    ) -> Array:
        """∂σᵢ/∂q_k of the Jacobian, world axes at the frame's point, without its Hessian.

        The same as `robust_ik.singular_value_gradients` of `jacobian` and `hessian`, whose words on σ = 0 and equal
        singular values hold here too.

        Args:
            q: Configurations, (..., nq).
            frame: As for `jacobian`.
            rows: As for `jacobian`.

        Returns:
            (..., k, n) with k = min(len(rows), n); row i belongs to σᵢ.
        """
        q, names = self._checked(q), self.rows if rows is None else checked_rows(rows)
        found = svd(self.jacobian(q, frame, rows=names).reshape(-1, len(names), self.n))
        wrenches = np.zeros((len(found.s), found.s.shape[1], len(ROWS)))
        wrenches[..., [ROWS.index(name) for name in names]] = np.swapaxes(found.U, 1, 2)
        gradients = self.chain(frame).contractions(q.reshape(-1, self.nq), wrenches, found.Vt, paired=True)
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
        if not isinstance(name, str):
            raise InputError(f"a frame is named by a str, got {reprlib.repr(name)}")
        if name in self._kinematics.frames:
            return self._kinematics.frames[name]
        raise FrameNotFoundError(f"{self.name} has no frame {name!r}; {suggest(str(name), self.frames)}")
