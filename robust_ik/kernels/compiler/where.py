"""The function `where` for gain formulas, on arrays and in compiled code alike; it needs no Numba."""

from __future__ import annotations

from typing import Any

import numpy as np


def where(condition: Any, x: Any, y: Any) -> Any:
    """The entries of x where the condition holds, else those of y; `gain_callbacks` defines it for compiled code."""
    return np.where(condition, x, y)
