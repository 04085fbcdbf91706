"""Singular configurations of an arm: found, told apart, named; and what is lost there."""

from robust_ik.singularities.atlas import NoSingularitiesError, SingularityAtlas
from robust_ik.singularities.confidence import Evidence, Status
from robust_ik.singularities.directions import LostMotion
from robust_ik.singularities.lost import Lost
from robust_ik.singularities.search import find_singularities
from robust_ik.singularities.strata import Stratum
from robust_ik.singularities.tracing import Curve, trace
from robust_ik.singularities.wrench import WrenchScrew

__all__ = [
    "Curve",
    "Evidence",
    "Lost",
    "LostMotion",
    "NoSingularitiesError",
    "SingularityAtlas",
    "Status",
    "Stratum",
    "WrenchScrew",
    "find_singularities",
    "trace",
]
