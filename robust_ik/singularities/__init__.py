"""Finds all singular configurations of an arm, groups them in families, names them, and says what is lost there."""

from robust_ik.singularities.atlas.atlas import SingularityAtlas
from robust_ik.singularities.atlas.atlas_record import NoSingularitiesError
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.atlas.find_singularities import find_singularities
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.lost_motion.along_a_stratum import Lost
from robust_ik.singularities.lost_motion.lost_motion import LostMotion
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew
from robust_ik.singularities.trace.coupled_curves import Curve, trace

__all__ = [
    "Completeness",
    "Curve",
    "Evidence",
    "Lost",
    "LostMotion",
    "NoSingularitiesError",
    "SingularityAtlas",
    "Stratum",
    "WrenchScrew",
    "find_singularities",
    "trace",
]
