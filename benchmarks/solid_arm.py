"""An arm with its collision shapes as a URDF that every system reads alike: convex meshes and boxes, nothing else."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import trimesh

import robust_ik as rik
from benchmarks.chains import BASE, Chain
from robust_ik.description.joint_tree import Box, Mesh
from robust_ik.description.meshes import read_vertices


def write(robot: rik.Robot, path: Path, obstacles: list[rik.Obstacle]) -> Chain:
    """Writes the URDF of an arm's chain, its links with shapes fixed to it, and boxes that stand around it.

    Args:
        robot: The arm.
        path: Where; meshes go beside it, as the convex hulls that every system makes of them or is given.
        obstacles: Boxes: links fixed to the base.
    """
    chain = Chain.of(robot)
    chain.write(path)
    tree = ET.parse(path)
    root, frames = tree.getroot(), _frames(chain)
    made: dict[str, ET.Element] = {}
    for number, solid in enumerate(robot.description.solids):
        pose = robot.pose(robot.neutral, solid.link)
        if solid.link not in made:
            moving = [joint for joint in robot.description.moving_joints(solid.link) if joint in robot.joint_names]
            carrier = robot.joint_names.index(moving[-1]) + 1 if moving else 0
            parent = f"link_{carrier}" if carrier else BASE
            made[solid.link] = _fixed(root, parent, solid.link, np.linalg.solve(frames[carrier], pose))
        _shape(made[solid.link], solid.shape, solid.placement, path.with_name(f"{path.stem}_{number}.stl"))
    for obstacle in obstacles:
        _shape(_fixed(root, BASE, obstacle.name, obstacle.placement), obstacle.shape, np.eye(4), path)
    tree.write(path)
    return chain


def _frames(chain: Chain) -> list[np.ndarray]:
    """The frames of the base and of the chain's links, all joints at zero."""
    frames = [np.eye(4)]
    for placement in chain.placements:
        frames.append(frames[-1] @ placement)
    return frames


def _fixed(root: ET.Element, parent: str, name: str, placement: np.ndarray) -> ET.Element:
    """A link of that name fixed to another one."""
    link = ET.SubElement(root, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "mass", value="1")
    ET.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")
    joint = ET.SubElement(root, "joint", name=f"{name}_fixed", type="fixed")
    _origin(joint, placement)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=name)
    return link


def _shape(link: ET.Element, shape: object, placement: np.ndarray, file: Path) -> None:
    collision = ET.SubElement(link, "collision")
    _origin(collision, placement)
    geometry = ET.SubElement(collision, "geometry")
    match shape:
        case Box(size):
            ET.SubElement(geometry, "box", size=" ".join(repr(float(side)) for side in size))
        case Mesh():
            trimesh.PointCloud(read_vertices(shape)).convex_hull.export(file)
            ET.SubElement(geometry, "mesh", filename=str(file))
        case _:
            raise ValueError(f"no shape for every system: {shape}")


def _origin(element: ET.Element, placement: np.ndarray) -> None:
    angles = pin.rpy.matrixToRpy(placement[:3, :3])
    xyz, rpy = (" ".join(repr(float(value)) for value in vector) for vector in (placement[:3, 3], angles))
    ET.SubElement(element, "origin", xyz=xyz, rpy=rpy)
