"""A choice that arrays and compiled numbers can make alike: no Numba here."""

from __future__ import annotations

from typing import Any

import numpy as np


def where(condition: Any, x: Any, y: Any) -> Any:
    """X where the condition holds, else y, entry by entry; `formulas` says what it is for a number in compiled code."""
    return np.where(condition, x, y)
