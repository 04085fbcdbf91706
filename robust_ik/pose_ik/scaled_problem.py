"""A problem in an arm's own unit of length in the place of the metre. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kinematics.chain import Chain


@dataclass(frozen=True, eq=False)
class PoseUnits:
    """What lengths are divided by on their way to kernels, and multiplied by on their way back.

    Attributes:
        length: The unit, m; a power of two rounds nothing.
        joints: Units of the robot's n joints: `length` of those that slide, else 1, (n,).
        q: The same of the entries of q, (nq,).
    """

    length: float
    joints: Array
    q: Array

    @classmethod
    def of(cls, chain: Chain, length: float) -> PoseUnits:
        """Of a chain: a joint slides if all that follows it does."""
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
        """Poses (..., 4, 4)."""
        scaled = T.copy()
        scaled[..., :3, 3] /= self.length
        return scaled

    def restore(self, q: Array, numbers: Array) -> None:
        """Configurations and results of kernels in metres, in their place."""
        q *= self.q
        numbers[..., lay.POSITION_ERROR] *= self.length
