"""The kinematics of a screw chain in NumPy, any mixing and nothing compiled: what compiled ones are held against."""

from dataclasses import dataclass

import numpy as np

from robust_ik.kinematics.twist_rows import ROWS


@dataclass(frozen=True, eq=False)
class Screws:
    """What each joint of N chains does to the tip, world axes, per unit speed: both (3, N, c)."""

    linear: np.ndarray
    angular: np.ndarray


def screws(chain, values):
    """The c joint screws of N configurations, (N, n)."""
    count, moves = len(values), (values @ chain.mixing.T).T
    axes, points = np.empty((2, len(chain.sliding), 3, count))
    # Columns of the rotation so far come first: frame[i] is the image of unit vector i, (3, N).
    frame = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, count))
    point = np.zeros((3, count))
    for index, (slides, move) in enumerate(zip(chain.sliding, moves)):
        point = point + np.tensordot(chain.offsets[index], frame, 1)
        frame = (chain.rotations[index].T @ frame.reshape(3, -1)).reshape(3, 3, count)
        axes[index], points[index] = frame[2], point
        if slides:
            point = point + move * frame[2]
        else:
            c, s = np.cos(move), np.sin(move)
            frame = np.stack([c * frame[0] + s * frame[1], c * frame[1] - s * frame[0], frame[2]])
    tip = point + np.tensordot(chain.tip, frame, 1)
    axes, arms = axes.transpose(1, 2, 0), (tip - points).transpose(1, 2, 0)
    turning = ~np.array(chain.sliding)
    return Screws(np.where(turning, _cross(axes, arms), axes), axes * turning)


def jacobian(chain, values):
    """(N, n) → (N, m, n)."""
    found = screws(chain, values)
    twists = np.concatenate([found.linear / chain.length_scale, found.angular])
    return twists[[ROWS.index(row) for row in chain.rows]].transpose(1, 0, 2) @ chain.mixing


def contraction(chain, values, left, right):
    """Uᵀ (∂J/∂q_k) V: (N, n), (N, m, a), (N, n, b) → (N, a, b, n)."""
    found = screws(chain, values)
    U = np.zeros((6, len(left), 1, left.shape[-1]))
    U[[ROWS.index(row) for row in chain.rows], :, 0] = left.transpose(1, 0, 2)
    force, torque = U[:3] / chain.length_scale, U[3:]
    v, w = found.linear[..., None], found.angular[..., None]
    motion = (chain.mixing @ right)[None]
    after_v = np.cumsum((v * motion)[:, :, ::-1], axis=2)[:, :, ::-1]
    turn = w * motion
    before_w = np.cumsum(turn, axis=2) - turn
    after_w = np.cumsum(turn[:, :, ::-1], axis=2)[:, :, ::-1]
    one = np.concatenate([_cross(force, w), _cross(v, force), _cross(torque, w)])
    other = np.concatenate([after_v, before_w, after_w])
    contracted = one.transpose(1, 2, 3, 0) @ other.transpose(1, 2, 0, 3)
    return contracted.transpose(0, 2, 3, 1) @ chain.mixing


def _cross(a, b):
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
