"""How the Jacobian, its singular values and the manipulability change with the joints. Arrays only.

`hessian` is ∂J/∂q, shape (..., m, n, n) with [i, j, k] = ∂J_ij/∂q_k, as `Robot.hessian` returns it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, check_leading_axes
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import ThinSVD, svd


def _checked(J: ArrayLike, hessian: ArrayLike) -> tuple[ThinSVD, Array]:
    J = as_array(J, "J", (None, None))
    m, n = J.shape[-2:]
    hessian = as_array(hessian, "hessian", (m, n, n))
    check_leading_axes("J", J.shape[:-2], "hessian", hessian.shape[:-3])
    return svd(J), hessian


def closed_form_hessian(axes: ArrayLike, arms: ArrayLike, *, printed: bool = False) -> Array:
    """∂J/∂q of a chain of turning joints, from its axes alone, reference LOCAL_WORLD_ALIGNED.

    Args:
        axes: Unit axes z_i of the joints, world axes, (..., n, 3).
        arms: p_i, from the origin of the frame on axis i to the tool's point, m, (..., n, 3).
        printed: The equation as printed in the paper, p_k in place of p_i where k < i: wrong by (z_k·z_i)(o_k − o_i),
            for comparison.

    Returns:
        (..., 6, n, n): [i, j, k] = ∂J_ij/∂q_k.

    Source: Almarkhi-Maciejewski, eq. (9).
    """
    z, p = as_array(axes, "axes", (None, 3)), as_array(arms, "arms", (None, 3))
    if z.shape != p.shape:
        raise InputError(f"axes and arms must have the same shape, got {z.shape} and {p.shape}")
    n = z.shape[-2]
    before = np.arange(n)[None, :] < np.arange(n)[:, None]  # k < i, [i, k]
    z_i, z_k, p_i, p_k = z[..., :, None, :], z[..., None, :, :], p[..., :, None, :], p[..., None, :, :]
    cosine = np.sum(z_i * z_k, axis=-1, keepdims=True)
    early = np.sum(z_k * p_i, axis=-1, keepdims=True) * z_i - cosine * (p_k if printed else p_i)
    late = np.sum(z_i * p_k, axis=-1, keepdims=True) * z_k - cosine * p_k
    linear = np.where(before[..., None], early, late)
    angular = np.where(before[..., None], np.cross(z_k, z_i), 0.0)
    return np.ascontiguousarray(np.moveaxis(np.concatenate([linear, angular], axis=-1), -1, -3))


@computed
def singular_value_gradients(J: ArrayLike, hessian: ArrayLike) -> Array:
    """∂σᵢ/∂q_k = uᵢᵀ (∂J/∂q_k) vᵢ for every i.

    At σᵢ = 0 it is the derivative of the *signed* singular value, its sign being that of the pair (uᵢ, vᵢ). Where
    singular values coincide, single rows depend on the arbitrary basis; their sum over the cluster does not.

    Args:
        J: Jacobian, (..., m, n).
        hessian: Its derivative, (..., m, n, n).

    Returns:
        Gradients, (..., k, n) with k = min(m, n); row i belongs to σᵢ.

    Source: Almarkhi-Maciejewski, eq. (7).
    """
    decomposition, hessian = _checked(J, hessian)
    return np.asarray(np.einsum("...mi,...mjk,...ij->...ik", decomposition.U, hessian, decomposition.Vt, optimize=True))


@computed
def singular_value_gradient(J: ArrayLike, hessian: ArrayLike, index: int = -1) -> Array:
    """The gradient of one singular value, (..., n); by default of the smallest.

    Source: as for all of them.
    """
    gradients = singular_value_gradients(J, hessian)
    count = gradients.shape[-2]
    if not -count <= index < count:
        raise InputError(f"index must lie in [{-count}, {count - 1}] for {count} singular values, got {index}")
    return np.asarray(gradients[..., index, :])


@computed
def manipulability_gradient(J: ArrayLike, hessian: ArrayLike) -> Array:
    """∂(Πσ)/∂q_k = Σᵢ (Π_{j≠i} σⱼ) uᵢᵀ (∂J/∂q_k) vᵢ, shape (..., n).

    This form needs no inverse and holds at a singularity, where it is the derivative of the signed product: the
    manipulability itself has a kink there, |·|.

    Args:
        J: Jacobian, (..., m, n).
        hessian: Its derivative, (..., m, n, n).

    Source: Kim, Marani, Chung, Yuh, eq. (30), in the form without J⁺.
    """
    s = svd(J).s
    gradients = singular_value_gradients(J, hessian)
    return np.asarray(np.einsum("...i,...ik->...k", _products_of_the_others(s), gradients))


def _products_of_the_others(s: Array) -> Array:
    """Π_{j≠i} sⱼ for every i without division, by products from the left and from the right."""
    ones = np.ones((*s.shape[:-1], 1))
    left = np.cumprod(np.concatenate([ones, s[..., :-1]], axis=-1), axis=-1)
    right = np.cumprod(np.concatenate([ones, s[..., :0:-1]], axis=-1), axis=-1)[..., ::-1]
    return np.asarray(left * right)
