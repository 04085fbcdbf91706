"""Groups singular configurations in families: conditions on joints, leaves, strata."""

from robust_ik.singularities.families.stratum import Stratum

__all__ = [
    "Stratum",
]
