"""A pose problem in the arm's own unit of length instead of the metre. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kinematics.chain import Chain


@dataclass(frozen=True, eq=False)
class PoseUnits:
    """Units by which lengths are divided for kernels, and multiplied in their results.

    Attributes:
        length: The unit, m; for a power of two nothing is rounded.
        joints: Units of the robot's n joints: `length` for those that slide, else 1, (n,).
        q: The same for the entries of q, (nq,).
    """

    length: float
    joints: Array
    q: Array

    @classmethod
    def of(cls, chain: Chain, length: float) -> PoseUnits:
        """The units of a chain's joints: a joint slides if all that follow it do."""
        joints, q = np.ones(chain.n), np.ones(chain.nq)
        for column, place in zip(chain.column, chain.place):
            if chain.sliding[chain.column == column].all():
                joints[column], q[place] = length, length
        return cls(length, joints, q)

    def chain(self, chain: Chain) -> Chain:
        """The chain with its lengths in these units."""
        own = np.where(chain.sliding, self.length, 1.0)
        tip = chain.tip.copy()
        tip[:3, 3] /= self.length
        factor, shift = chain.factor * self.joints[chain.column] / own, chain.shift / own
        return replace(chain, origins=chain.origins / self.length, factor=factor, shift=shift, tip=tip)

    def targets(self, T: Array) -> Array:
        """Poses (..., 4, 4) with positions in these units."""
        scaled = T.copy()
        scaled[..., :3, 3] /= self.length
        return scaled

    def restore(self, q: Array, numbers: Array) -> None:
        """Converts configurations and results of kernels to metres, in place."""
        q *= self.q
        numbers[..., lay.POSITION_ERROR] *= self.length
