"""Serial arms made of lines, at any size."""

import tempfile
from pathlib import Path

import numpy as np

import robust_ik as rik

UR5 = [(0, 0.089159, np.pi / 2), (-0.425, 0, 0), (-0.39225, 0, 0), (0, 0.10915, np.pi / 2), (0, 0.09465, -np.pi / 2)]

LIFT = [
    ("0 0 0.1", "0 0 0", "0 0 1", -3, 3), ("0.15 0.2 0.3", "0 0 0", "1 0 0", -0.5, 0.5, "slide"),
    ("0 0 0.2", "0 0 0", "0 1 0", -3, 3), ("0.4 0 0", "0 0 0", "0 1 0", -3, 3), ("0.35 0 0", "0 0 0", "1 0 0", -3, 3),
    ("0 0 0", "0 0 0", "0 1 0", -3, 3), ("0 0 0", "0 0 0", "1 0 0", -3, 3),
]  # fmt: skip
"""A turn, a slide across it, and an arm of five joints."""


def arm_of(joints, tool, size=1.0):
    """A robot from lines of (origin, rpy, axis, lower, upper), and "slide" of those that do; lengths times size."""
    links, parts = ["l0"], []
    for i, (origin, rpy, axis, low, high, *slide) in enumerate(joints, 1):
        links.append(f"l{i}")
        kind, unit = ("prismatic", size) if slide else ("revolute", 1.0)
        parts.append(
            f'<joint name="q{i}" type="{kind}"><parent link="l{i - 1}"/><child link="l{i}"/>'
            f'<origin xyz="{times(origin, size)}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="{low * unit!r}" upper="{high * unit!r}" velocity="{3 * unit!r}" effort="1"/></joint>'
        )
    fixed = (
        f'<joint name="fixed" type="fixed"><parent link="{links[-1]}"/><child link="tool"/>'
        f'<origin xyz="{times(tool, size)}"/></joint>'
    )
    named = "".join(f'<link name="{link}"/>' for link in [*links, "tool"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(f'<robot name="arm">{named}{"".join(parts)}{fixed}</robot>')
        return rik.load(path)


def times(numbers, size):
    return " ".join(repr(float(x) * size) for x in numbers.split())


def ur5(size=1.0):
    """A UR5, its lengths times size."""
    joints, origin, rpy = [], "0 0 0", "0 0 0"
    for a, d, alpha in UR5:
        joints.append((origin, rpy, "0 0 1", -2 * np.pi, 2 * np.pi))
        origin, rpy = f"{a!r} 0 {d!r}", f"{float(alpha)!r} 0 0"
    joints.append((origin, rpy, "0 0 1", -2 * np.pi, 2 * np.pi))
    return arm_of(joints, "0 0 0.0823", size)
