"""Motion along families: curves, the nearest singular configuration, paths within limits."""

from robust_ik.singularities.trace.coupled_curves import Curve, trace
from robust_ik.singularities.trace.family_tour import stroll, within_limits
from robust_ik.singularities.trace.torus_curves import Axis, pairs, strokes

__all__ = [
    "Axis",
    "Curve",
    "pairs",
    "strokes",
    "stroll",
    "trace",
    "within_limits",
]
