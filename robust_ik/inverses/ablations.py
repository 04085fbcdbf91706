"""Ablations of J-PARSE: J-PARSE without some of its parts, each as a filter *and* its null-space projector.

The projector is what tells them apart. JacobianProjection, eq. (57), and JacobianSafetyProjection, eq. (59), are the
same filter: if the small singular values are raised and then their directions dropped, nothing is left of the raising.
The paper sees different motions because it pairs (57) with I − J_p⁺J_p, which lets a secondary motion turn the joints
along the singular directions, and (59) with I − J_s⁺J_s = I − V Vᵀ, which does not.

```python
inverse, null_projector = jacobian_projection(gamma=0.1)
qdot = inverse.solve(J, xdot) + null_projector(J) @ qdot0
```
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.inverses.base import SingularValueFilter
from robust_ik.inverses.duleba_clamp import DulebaClamp
from robust_ik.inverses.truncated_svd import TruncatedSVD
from robust_ik.kinematics.svd import null_projector, svd


class Ablation(NamedTuple):
    """A filter, and the projector for secondary motions that it is used with.

    Attributes:
        inverse: From ẋ to q̇.
        null_projector: From J, (..., m, n), to the projector, (..., n, n).
    """

    inverse: SingularValueFilter
    null_projector: Callable[[ArrayLike], Array]


def jacobian_projection(gamma: float = 0.1) -> Ablation:
    """J_p⁺ ẋ: singular directions are dropped; the secondary motion may use them.

    Watch for: the rank of the projector grows as σ falls below γσ₁, so a secondary motion begins with a jump along
    the joint direction that the singularity frees, and moves the task by up to γσ₁ times itself.

    Args:
        gamma: Threshold γ in (0, 1), relative to σ₁.

    Source: J-PARSE 2025, eq. (57).
    """
    inverse = TruncatedSVD(gamma=gamma)
    return Ablation(inverse, partial(kept_null_projector, gamma=gamma))


def jacobian_safety(gamma: float = 0.1) -> Ablation:
    """J_s⁺ ẋ: singular values are raised to γσ₁; secondary motions by I − V Vᵀ.

    Args:
        gamma: Threshold γ in (0, 1), relative to σ₁.

    Source: J-PARSE 2025, eq. (58).
    """
    return Ablation(DulebaClamp(gamma=gamma), null_projector)


def jacobian_safety_projection(gamma: float = 0.1) -> Ablation:
    """J_s⁺ J_p J_p⁺ ẋ, which equals J_p⁺ ẋ: the filter of `jacobian_projection`; secondary motions by I − V Vᵀ.

    Args:
        gamma: Threshold γ in (0, 1), relative to σ₁.

    Source: J-PARSE 2025, eq. (59).
    """
    return Ablation(TruncatedSVD(gamma=gamma), null_projector)


def kept_null_projector(J: ArrayLike, gamma: float) -> Array:
    """I − J_p⁺ J_p, (..., n, n): projects onto joint motions that leave all task directions with σ > γσ₁ at rest.

    Args:
        J: Jacobian, (..., m, n).
        gamma: γ.
    """
    decomposition = svd(J)
    kept = decomposition.Vt * (decomposition.s > gamma * decomposition.s[..., :1])[..., None]
    return np.asarray(np.eye(kept.shape[-1]) - np.swapaxes(kept, -1, -2) @ kept)
