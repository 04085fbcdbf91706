"""The motion that is lost at a singular configuration: twists, wrenches, words, and a way out."""

from robust_ik.singularities.lost_motion.lost_motion import FLAT, LostMotion, lost_directions, lost_motion, sides
from robust_ik.singularities.lost_motion.self_motion_way import SelfMotionWay, self_motion_way
from robust_ik.singularities.lost_motion.sparse_basis import sparse_basis
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew

__all__ = [
    "FLAT",
    "LostMotion",
    "SelfMotionWay",
    "WrenchScrew",
    "lost_directions",
    "lost_motion",
    "self_motion_way",
    "sides",
    "sparse_basis",
]
