"""The motion that is lost at a singular configuration: twists, wrenches, words, and a way out."""

from robust_ik.singularities.lost_motion.lost_motion import FLAT, LostMotion, lost_directions, lost_motion, sides
from robust_ik.singularities.lost_motion.sparse_basis import sparse_basis
from robust_ik.singularities.lost_motion.way_out import WayOut, way_out
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew

__all__ = [
    "FLAT",
    "LostMotion",
    "WayOut",
    "WrenchScrew",
    "lost_directions",
    "lost_motion",
    "sides",
    "sparse_basis",
    "way_out",
]
