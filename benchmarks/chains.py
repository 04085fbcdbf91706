"""A serial arm of turning joints as bare numbers, and as a URDF of nothing else: the same robot for everyone."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

import robust_ik as rik

BASE = "base"


@dataclass(frozen=True, eq=False)
class Chain:
    """Frame i turns about its z by q_i: the tool is at A_1 Rz(q_1) A_2 Rz(q_2) … A_n Rz(q_n) T.

    Attributes:
        name: Of the robot.
        tip: The tool frame.
        joints: Joint names.
        placements: A, (n, 4, 4).
        tool: T, (4, 4).
        lower: Lower limits, rad, (n,), finite.
        upper: Upper limits.
        speeds: Speed limits, rad/s, (n,), finite.
    """

    name: str
    tip: str
    joints: tuple[str, ...]
    placements: np.ndarray
    tool: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    speeds: np.ndarray

    @classmethod
    def of(cls, robot: rik.Robot) -> Chain:
        """The chain of an arm; joints without limits get ±π and 3 rad/s."""
        twists = robot.jacobian(robot.neutral, reference="world", rows=("x", "y", "z", "wx", "wy", "wz")).T
        axes, moments = twists[:, 3:], twists[:, :3]
        if not np.allclose(np.linalg.norm(axes, axis=1), 1):
            raise ValueError(f"{robot.name} has joints that do not turn")
        frames = [_frame(axis, np.cross(axis, moment)) for axis, moment in zip(axes, moments)]
        before = [np.eye(4), *frames]
        placements = np.array([np.linalg.solve(a, b) for a, b in zip(before, frames)])
        tool = np.linalg.solve(frames[-1], robot.pose(robot.neutral))
        return cls(
            robot.name, str(robot.tip), robot.joint_names, placements, tool,
            np.where(np.isfinite(robot.lower), robot.lower, -np.pi),
            np.where(np.isfinite(robot.upper), robot.upper, np.pi),
            np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, 3.0),
        )  # fmt: skip

    @classmethod
    def zigzag(cls, n: int) -> Chain:
        """An arm of n links of 0.3 m whose axes take turns: for cost against joints."""
        quarter = np.array([[1.0, 0, 0, 0.05], [0, 0, -1, 0], [0, 1, 0, 0.3], [0, 0, 0, 1]])
        placements = np.tile(quarter, (n, 1, 1))
        placements[::2, :3, :3] = quarter[:3, :3].T
        limit = np.full(n, np.pi)
        names = tuple(f"joint_{i + 1}" for i in range(n))
        return cls(f"zigzag_{n}", "tool", names, placements, placements[0], -limit, limit, limit)

    def write(self, path: Path) -> Path:
        """Writes the URDF: no shapes, and a token inertia, which MuJoCo demands of links that move."""
        return write(path, self.name, [self])


def write(path: Path, name: str, chains: Sequence[Chain]) -> Path:
    """Writes the URDF of chains that share a base; joints and tips must have different names."""
    root = ET.Element("robot", name=name)
    ET.SubElement(root, "link", name=BASE)  # no inertia: KDL wants none there
    for number, chain in enumerate(chains):
        _hang(root, chain, f"_{number}" if number else "")
    path.parent.mkdir(parents=True, exist_ok=True)
    ET.ElementTree(root).write(path)
    return path


def _hang(root: ET.Element, chain: Chain, suffix: str) -> None:
    """Adds the links and joints of a chain to the base; a suffix keeps their names apart from another chain's."""
    links = [BASE, *(f"link_{i + 1}{suffix}" for i in range(len(chain.joints))), chain.tip]
    for link in links[1:]:
        inertial = ET.SubElement(ET.SubElement(root, "link", name=link), "inertial")
        ET.SubElement(inertial, "mass", value="1")
        ET.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")
    for name, placement, parent, child, lower, upper, speed in zip(
        chain.joints, chain.placements, links, links[1:], chain.lower, chain.upper, chain.speeds
    ):
        joint = _joint(root, name, "revolute", placement, parent, child)
        ET.SubElement(joint, "axis", xyz="0 0 1")
        values = {"lower": lower, "upper": upper, "velocity": speed, "effort": 1.0}
        ET.SubElement(joint, "limit", {key: repr(float(value)) for key, value in values.items()})
    _joint(root, f"tool_joint{suffix}", "fixed", chain.tool, links[-2], links[-1])


def _frame(axis: np.ndarray, point: np.ndarray) -> np.ndarray:
    """A frame at a point whose z is the axis."""
    aside = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(aside, axis) / np.linalg.norm(np.cross(aside, axis))
    frame = np.eye(4)
    frame[:3] = np.stack((x, np.cross(axis, x), axis, point), axis=1)
    return frame


def _joint(root: ET.Element, name: str, kind: str, placement: np.ndarray, parent: str, child: str) -> ET.Element:
    joint = ET.SubElement(root, "joint", name=name, type=kind)
    rpy = pin.rpy.matrixToRpy(placement[:3, :3])
    ET.SubElement(joint, "origin", xyz=_text(placement[:3, 3]), rpy=_text(rpy))
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    return joint


def _text(vector: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in vector)
