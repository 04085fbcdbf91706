"""Finds all singular configurations of an arm, groups them in families, names them, and says what is lost there."""

from robust_ik.singularities.atlas.atlas import SingularityAtlas
from robust_ik.singularities.atlas.atlas_record import NoSingularitiesError
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.atlas.find_singularities import find_singularities
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.find.gradient_history import Descent, gradient_descent
from robust_ik.singularities.find.gradient_search import gradient_search
from robust_ik.singularities.find.projection_search import SearchEnds
from robust_ik.singularities.lost_motion.along_a_stratum import Lost
from robust_ik.singularities.lost_motion.lost_motion import LostMotion
from robust_ik.singularities.lost_motion.sparse_basis import sparse_basis
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew
from robust_ik.singularities.trace.coupled_curves import Curve, trace

__all__ = [
    "Completeness",
    "Curve",
    "Descent",
    "Evidence",
    "Lost",
    "LostMotion",
    "NoSingularitiesError",
    "SearchEnds",
    "SingularityAtlas",
    "Stratum",
    "WrenchScrew",
    "find_singularities",
    "gradient_descent",
    "gradient_search",
    "sparse_basis",
    "trace",
]
