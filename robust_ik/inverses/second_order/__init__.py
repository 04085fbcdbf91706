"""An inverse that sees where the lost directions come back: the second-order way through and out of singularities."""

from robust_ik.inverses.second_order.exit_verdict import Exit, exit_verdict
from robust_ik.inverses.second_order.second_order import SecondOrder, SecondOrderRun
from robust_ik.inverses.second_order.weak_rows import upright, weak_rows

__all__ = ["Exit", "SecondOrder", "SecondOrderRun", "exit_verdict", "upright", "weak_rows"]
