"""Whether our first-order inverses and other packages' own code move an arm alike: the same motions, run by both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.robustness.arms import arm, scenarios
from benchmarks.robustness.contenders import Contender
from benchmarks.robustness.measuring import peer_traces
from robust_ik.simulation.robustness import RobustnessScenario, RunTrace, run_scenarios

ARMS = ("z1", "ur10", "planar_3r")
ALIKE = 1e-6
"""Joint values agree up to this, rad. Chosen: rounding grows by some orders of magnitude where arms are singular."""
PAIRS = (
    (
        Contender("JParse", kind="JParse", parameters=(("gamma", 0.1),)),
        Contender("jparse-robotics", "jparse", parameters=(("gamma", 0.1),)),
    ),
    (
        Contender("DampedLeastSquares", kind="DampedLeastSquares", parameters=(("damping", 0.05),)),
        Contender("PyKDL wdls", "pykdl", parameters=(("eps", 1e6), ("lambda", 0.05))),
    ),
)
"""One of ours and another package's with the same parameters. PyKDL damps fully where all σ are far below its ε."""


@dataclass(frozen=True)
class Agreement:
    """How far two go apart.

    Attributes:
        ours: Name of ours.
        peer: Name of the other.
        runs: How many motions both ran.
        alike: In how many all joint values agree up to ALIKE.
        furthest: The largest difference of joint values in those that do, rad.
        apart: Names of the others.
    """

    ours: str
    peer: str
    runs: int
    alike: int
    furthest: float
    apart: tuple[str, ...]

    @property
    def words(self) -> str:
        """The verdict, one sentence."""
        if self.alike == self.runs:
            return f"{self.ours} and {self.peer} agree in all of {self.runs} motions, up to {self.furthest:.0e} rad"
        return (
            f"{self.ours} and {self.peer} agree in {self.alike} of {self.runs} motions, up to {self.furthest:.0e} rad; "
            f"not in {', '.join(self.apart)}"
        )


def agreements() -> list[Agreement]:
    """All pairs, on motions of ARMS without noise that start regular.

    Raises:
        UnavailableError: A package cannot be run here.
    """
    found = []
    for ours, peer in PAIRS:
        named, mine, others = [], [], []
        for name in ARMS:
            chosen = motions(name)
            named += [f"{name}: {each.name}" for each in chosen]
            mine += run_scenarios(arm(name)[0], chosen, ours.method())
            others += peer_traces(peer, name, chosen)
        found.append(compared(ours.name, peer.name, named, mine, others))
    return found


def motions(name: str) -> tuple[RobustnessScenario, ...]:
    """Motions of an arm that do not hang on the last bit: at an exactly singular start a rule may go either way."""
    return tuple(each for each in scenarios(name) if each.kind in ("cross", "beyond", "speed"))


def compared(
    ours: str, peer: str, named: Sequence[str], mine: Sequence[RunTrace], others: Sequence[RunTrace]
) -> Agreement:
    """How far runs of two go apart."""
    gaps = np.array([np.abs(a.q - b.q).max() for a, b in zip(mine, others)])
    alike = gaps <= ALIKE
    apart = tuple(name for name, good in zip(named, alike) if not good)
    return Agreement(ours, peer, len(gaps), int(alike.sum()), float(gaps[alike].max(initial=0.0)), apart)
