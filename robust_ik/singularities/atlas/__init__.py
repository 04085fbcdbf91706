"""The atlas of all families of an arm: the search, its state, the table and its file."""

from robust_ik.singularities.atlas.atlas import SingularityAtlas
from robust_ik.singularities.atlas.atlas_tables import cells

__all__ = [
    "SingularityAtlas",
    "cells",
]
