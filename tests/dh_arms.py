"""Arms of six revolute joints by their Denavit-Hartenberg parameters: industrial ones and random ones of many kinds."""

import numpy as np

import robust_ik as rik

HALF, THIRD = np.pi / 2, np.pi / 3

ARMS = {
    # Three parallel axes. Source: Universal Robots, "DH Parameters for calculations of kinematics and dynamics".
    "ur3": [
        (0, 0.1519, HALF), (-0.24365, 0, 0), (-0.21325, 0, 0), (0, 0.11235, HALF), (0, 0.08535, -HALF), (0, 0.0819, 0)
    ],
    "ur5": [
        (0, 0.089159, HALF), (-0.425, 0, 0), (-0.39225, 0, 0), (0, 0.10915, HALF), (0, 0.09465, -HALF), (0, 0.0823, 0)
    ],
    "ur10": [
        (0, 0.1273, HALF), (-0.612, 0, 0), (-0.5723, 0, 0), (0, 0.163941, HALF), (0, 0.1157, -HALF), (0, 0.0922, 0)
    ],
    # Spherical wrists, after the makers' drawings of the KUKA KR 16, ABB IRB 120 and Yaskawa GP7.
    "kr16_like": [
        (0.26, 0.675, -HALF), (0.68, 0, 0), (-0.035, 0, -HALF), (0, 0.67, HALF), (0, 0, -HALF), (0, 0.158, 0)
    ],
    "irb120_like": [
        (0, 0.29, -HALF), (0.27, 0, 0), (0.07, 0, -HALF), (0, 0.302, HALF), (0, 0, -HALF), (0, 0.072, 0)
    ],
    "gp7_like": [
        (0.04, 0.33, -HALF), (0.445, 0, 0), (0.04, 0, -HALF), (0, 0.44, HALF), (0, 0, -HALF), (0, 0.08, 0)
    ],
    # No three neighbours meet or are parallel: FANUC CRX-10iA, Kinova Gen3 (six joints), Kinova JACO 2 (60° wrist).
    "crx_like": [
        (0, 0.245, -HALF), (0.54, 0, 0), (0, 0, -HALF), (0, 0.54, HALF), (0, 0.15, -HALF), (0, 0.16, 0)
    ],
    "gen3_6_like": [
        (0, 0.2433, HALF), (0.28, 0.03, np.pi), (0, 0.02, HALF), (0, 0.245, HALF), (0, 0.057, HALF), (0, 0.235, 0)
    ],
    "jaco_like": [
        (0, 0.2755, HALF), (0.41, 0, np.pi), (0, -0.0098, HALF), (0, -0.2502, THIRD), (0, -0.0858, THIRD),
        (0, -0.2116, np.pi),
    ],
}  # fmt: skip
"""Rows (a, d, α), m and rad, standard; their sources above."""


def robot_of(rows, name="arm", limits=None, kinds=None):
    """A robot from rows (a, d, α), with limits (lower, upper) of every joint, and with some that slide."""
    joints = []
    for i, (a, d, alpha) in enumerate(rows):
        slides = kinds is not None and kinds[i] == "P"
        low, high = (-0.5, 0.5) if slides else limits or (None, None)
        kind = "prismatic" if slides else "revolute"
        joints.append(rik.DHJoint(a=float(a), d=float(d), alpha=float(alpha), kind=kind, lower=low, upper=high))
    return rik.Robot.from_dh(rik.DHTable(joints=tuple(joints), convention="standard", name=name))


def arm(name, limits=None):
    return robot_of(ARMS[name], name, limits)


def random_rows(rng, kind):
    """Rows of a random arm: general; with zero offsets; with right angles; with parallel and meeting axes; rounded."""
    a, d, alpha = rng.uniform(-0.5, 0.5, 6), rng.uniform(-0.5, 0.5, 6), rng.uniform(-np.pi, np.pi, 6)
    if kind == "zero offsets":
        a, d = a * (rng.random(6) < 0.5), d * (rng.random(6) < 0.5)
    if kind == "right angles":
        alpha = rng.choice([0, HALF, -HALF, np.pi], 6)
        a, d = a * (rng.random(6) < 0.6), d * (rng.random(6) < 0.6)
    if kind == "meeting axes":
        alpha = rng.choice([0, HALF, -HALF, HALF, -HALF], 6)
        a, d = a * (rng.random(6) < 0.4), d * (rng.random(6) < 0.7)
    if kind == "rounded":
        a, d, alpha = np.round(a, 1), np.round(d, 1), np.round(alpha / THIRD) * THIRD
    return list(zip(a, d, alpha))


KINDS = ("general", "zero offsets", "right angles", "meeting axes", "rounded")
