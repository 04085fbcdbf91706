"""A URDF chain in closed screw form, written without Pinocchio: what the library is checked against.

Source of the derivatives: Almarkhi-Maciejewski, eq. (9), its misprint corrected: p_i, not p_k, where k < i.
"""

from dataclasses import dataclass

import numpy as np
from lxml import etree


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def transform(R=None, p=(0, 0, 0)):
    T = np.eye(4)
    T[:3, :3] = np.eye(3) if R is None else R
    T[:3, 3] = p
    return T


def _numbers(element, attribute, default):
    return np.array([float(w) for w in (element.get(attribute, default) if element is not None else default).split()])


def _origin(joint):
    element = joint.find("origin")
    r, p, y = _numbers(element, "rpy", "0 0 0")
    R = rotation((0, 0, 1), y) @ rotation((0, 1, 0), p) @ rotation((1, 0, 0), r)
    return transform(R, _numbers(element, "xyz", "0 0 0"))


@dataclass
class Chain:
    """Axes z, origins o and kinds of the joints that move the tip at one configuration, and the tip's pose."""

    names: list
    sliding: np.ndarray
    z: np.ndarray
    o: np.ndarray
    T: np.ndarray

    @classmethod
    def at(cls, xml, tip, values):
        """`values`: joint name → rad or m, for every moving joint of the chain."""
        joints = {j.find("child").get("link"): j for j in etree.fromstring(xml.encode()).findall("joint")}
        path, link = [], tip
        while link in joints:
            path.insert(0, joints[link])
            link = joints[link].find("parent").get("link")
        T, names, sliding, z, o = np.eye(4), [], [], [], []
        for joint in path:
            T = T @ _origin(joint)
            if joint.get("type") == "fixed":
                continue
            axis = _numbers(joint.find("axis"), "xyz", "1 0 0")
            axis = axis / np.linalg.norm(axis)
            names.append(joint.get("name"))
            sliding.append(joint.get("type") == "prismatic")
            z.append(T[:3, :3] @ axis)
            o.append(T[:3, 3])
            value = values[names[-1]]
            T = T @ (transform(p=axis * value) if sliding[-1] else transform(rotation(axis, value)))
        return cls(names, np.array(sliding), np.array(z), np.array(o), T)

    def jacobian(self, reference):
        """(6, n) in one of the three references."""
        point = np.zeros(3) if reference == "world" else self.T[:3, 3]
        columns = [
            np.concatenate([z, np.zeros(3)] if slides else [np.cross(z, point - o), z])
            for slides, z, o in zip(self.sliding, self.z, self.o)
        ]
        J = np.array(columns).T
        if reference == "local":
            J = np.kron(np.eye(2), self.T[:3, :3].T) @ J
        return J

    def hessian(self, reference):
        """(6, n, n) with [:, i, k] = ∂J_i/∂q_k."""
        n, J = len(self.z), self.jacobian(reference)
        H = np.zeros((6, n, n))
        for i in range(n):
            for k in range(n):
                if reference == "world" and k < i:
                    H[:, i, k] = bracket(J[:, k], J[:, i])
                elif reference == "local" and k > i:
                    H[:, i, k] = bracket(J[:, i], J[:, k])
                elif reference == "local_world_aligned":
                    H[:, i, k] = self._aligned(i, k)
        return H

    def _aligned(self, i, k):
        p = self.T[:3, 3] - self.o
        zi, zk = self.z[i], self.z[k]
        if self.sliding[i]:
            turned = np.cross(zk, zi) if k < i and not self.sliding[k] else np.zeros(3)
            return np.concatenate([turned, np.zeros(3)])
        if self.sliding[k]:
            moved = np.cross(zi, zk) if k >= i else np.zeros(3)
            return np.concatenate([moved, np.zeros(3)])
        if k < i:
            return np.concatenate([np.cross(zk, np.cross(zi, p[i])), np.cross(zk, zi)])
        return np.concatenate([np.cross(zi, np.cross(zk, p[k])), np.zeros(3)])


def bracket(a, b):
    """The Lie bracket of two twists (linear, angular)."""
    return np.concatenate([np.cross(a[3:], b[:3]) + np.cross(a[:3], b[3:]), np.cross(a[3:], b[3:])])
