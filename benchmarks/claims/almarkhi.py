"""What Almarkhi and Maciejewski 2019 print, and the measurements that it is held against."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import robust_ik as rik
from robust_ik.description.catalog import find
from robust_ik.kinematics.singular_value_gradients import closed_form_hessian, singular_value_gradient
from robust_ik.singularities.geometry.screw_chain import ScrewChain

FIG_1, FIG_2, FIG_3 = (91, 0.01), (239, 0.02), 229
"""Stand-ins: number of a start and α for the plain descents, a start for the rotated one.

They were picked out of the 300 because they look like the figures: they show that such runs exist, not how often.
"""
SUBSPACE = np.array(
    [
        [0, 0, 0],
        [-0.27, 0.62, -0.61],
        [0.74, -0.17, -0.50],
        [-0.50, -0.71, -0.50],
        [-0.33, 0.08, 0.23],
        [-0.12, 0.28, -0.27],
    ]
)
"""u4, u5, u6 as the SVD gave them, section 2.3."""
ROTATED = np.array([[0, 0, 0], [0, -0.91, 0], [0, 0, 0.91], [-1, 0, 0], [0, 0, -0.41], [0, -0.41, 0]])
"""The same subspace as the paper rotates it."""
FIG_6 = (([-3.11, 3.02, -1.53, 0.15], [0, 1, 0]), ([-1.76, -1.85, -1.39, 0.02], [-1, 0, 0]))
"""Configurations of the 4-DoF arm and the u3 that is printed for them."""
FIG_9 = ([0] * 7, [np.pi, 0, np.pi, np.pi, np.pi, np.pi, np.pi])
TABLE_3 = {
    "q2 ∈ {0, π} and q3 = ±π/2",
    "q2 ∈ {0, π} and q6 ∈ {0, π}",
    "q4 ∈ {0, π}",
    "q5 = ±π/2 and q6 ∈ {0, π}",
}
TABLE_4 = {
    "q2 ∈ {0, π} and q3 ∈ {0, π} and q4 ∈ {0, π}",
    "q2 ∈ {0, π} and q4 ∈ {0, π} and q6 ∈ {0, π}",
    "q4 ∈ {0, π} and q5 ∈ {0, π} and q6 ∈ {0, π}",
    "q2 ∈ {0, π} and q3 = ±π/2 and q5 = ±π/2 and q6 ∈ {0, π}",
}


@cache
def chain() -> ScrewChain:
    """The PA-10's."""
    return ScrewChain.of(rik.load("pa10"))


@cache
def starts(count: int = 300) -> np.ndarray:
    """The random starts of every search below, (count, 7)."""
    return chain().random(np.random.default_rng(1), count)


@cache
def atlas(name: str) -> rik.SingularityAtlas:
    return rik.find_singularities(rik.load(name), starts=500)


def example_arm() -> rik.Robot:
    """The arm of section 2.3 and Figure 4: Table 2 with a₇ = 0.45, d₇ = 0."""
    table = rik.read_dh(find("pa10").path)
    hand = replace(table.joints[6], a=0.45, d=0.0)
    return rik.Robot.from_dh(replace(table, joints=(*table.joints[:6], hand), rest=None))


def derivatives(count: int, seed: int = 0) -> tuple[np.ndarray, ...]:
    """Jacobians of the PA-10 at random configurations, ∂J/∂q by differences, and by (9) with p_i and as printed."""
    robot, table = rik.load("pa10"), rik.read_dh(find("pa10").path)
    q = robot.random(np.random.default_rng(seed), count)
    frames, h = table.frames(q), 1e-6 * np.eye(7)
    z, arms = frames[:, :-1, :3, 2], frames[:, -1:, :3, 3] - frames[:, :-1, :3, 3]
    ahead, behind = robot.jacobian(q[:, None] + h), robot.jacobian(q[:, None] - h)
    difference = np.moveaxis((ahead - behind) / 2e-6, 1, -1)
    return robot.jacobian(q), difference, closed_form_hessian(z, arms), closed_form_hessian(z, arms, printed=True)


def cosines(J: np.ndarray, difference: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Between ∇σ6 of one ∂J/∂q and of another."""
    a, b = singular_value_gradient(J, difference), singular_value_gradient(J, other)
    return np.sum(a * b, axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)


def lost_by_figure_6(index: int) -> tuple[float, float, np.ndarray, float]:
    """σ3 there, how far the next singular configuration is, its u3, and degrees between that and the printed one."""
    robot, (q, u) = rik.load("almarkhi_4dof"), FIG_6[index]
    near = atlas("almarkhi_4dof").distance(q)
    lost = rik.lost_directions(robot.jacobian(near.values))[:, 0]
    lost = lost * np.sign(lost @ u)
    return float(rik.svd(robot.jacobian(q)).s[2]), near.distance, lost, float(np.degrees(np.arccos(lost @ u)))
