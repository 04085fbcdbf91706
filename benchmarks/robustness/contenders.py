"""Who takes part in the benchmark, with which parameters, and in which range each may be tuned."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

import robust_ik as rik
from robust_ik.inverses import CLASSES
from robust_ik.inverses.baselines import SlowDown
from robust_ik.simulation.robustness import BenchmarkMethod, ControllerMethod, InverseMethod

TRIES = 3
"""Random settings that each method gets, beside its defaults. Chosen: as many as an evening on one core allows."""
SPREAD = 10.0
"""A parameter is drawn between its default over this and its default times this, log-uniformly."""
FROM_LIMITS = ("speed", "acceleration")
"""Parameters of `SecondOrder` that the joint limits set."""
MORE = {
    "TruncatedSVD": (("threshold", 0.005, 0.5),), "DulebaClamp": (("floor", 0.005, 0.5),),
    "Halley": (("horizon", 0.01, 1.0),),
}  # fmt: skip
"""Ranges of parameters whose defaults are no plain numbers."""
TUNED = ", tuned"
"""What the label of a tuned row ends in."""
NAMES = {"SlowDown": "SlowDown (MoveIt Servo's rule)"}
"""What rows are called where the class says it not well enough."""


@dataclass(frozen=True)
class Contender:
    """A method with its parameters.

    Attributes:
        name: What its row says.
        script: Script in benchmarks/peers, without `_track.py`; "" for this package.
        kind: Class of this package, or "VelocityController".
        parameters: Other than the defaults, by name.
        ranges: Of the parameters that may be tuned: least and largest, log-uniform.
        tuned: Whether the parameters have been tuned.
    """

    name: str
    script: str = ""
    kind: str = ""
    parameters: tuple[tuple[str, float], ...] = ()
    ranges: tuple[tuple[str, float, float], ...] = field(default=(), compare=False)
    tuned: bool = False

    @property
    def label(self) -> str:
        """Name with the mark of a tuned setting."""
        return self.name + TUNED if self.tuned else self.name

    def set_to(self, parameters: Mapping[str, float]) -> Contender:
        """The same method, tuned."""
        return dataclasses.replace(self, parameters=tuple(sorted(parameters.items())), tuned=True)

    def method(self) -> BenchmarkMethod:
        """The method, for one of this package."""
        given = dict(self.parameters)
        if self.kind == "VelocityController":
            return ControllerMethod(lambda _: rik.JParse(**given) if given else None)
        if self.kind == "SecondOrder":
            return InverseMethod(
                lambda each: dataclasses.replace(rik.SecondOrder.from_limits(each.speed, each.acceleration), **given)
            )
        return InverseMethod.of(kinds()[self.kind](**given))


def kinds() -> dict[str, type[rik.RobustInverse]]:
    """Inverses of this package by name."""
    return {each.__name__: each for each in (*CLASSES, SlowDown) if each is not rik.Weighted}


def ours() -> tuple[Contender, ...]:
    """Every inverse of this package with its defaults, MoveIt Servo's rule, and a controller with its own."""
    found = [Contender(NAMES.get(name, name), kind=name, ranges=ranges_of(kind)) for name, kind in kinds().items()]
    controller = Contender("VelocityController", kind="VelocityController", ranges=(("gamma", 1e-3, 0.1),))
    return (*found, controller)


def ranges_of(kind: type[rik.RobustInverse]) -> tuple[tuple[str, float, float], ...]:
    """Ranges of the positive numbers that an inverse has as parameters."""
    found = []
    for each in dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ():
        value, fixed = each.default, kind is rik.SecondOrder and each.name in FROM_LIMITS
        if isinstance(value, float) and 0 < value < np.inf and not fixed:
            found.append((each.name, value / SPREAD, value * SPREAD))
    return MORE.get(kind.__name__, tuple(found))


PEERS = (
    Contender("Pink", "pink", ranges=(("damping", 1e-8, 1e-1), ("lm_damping", 1e-4, 10.0))),
    Contender("mink", "mink", ranges=(("damping", 1e-8, 1e-1), ("lm_damping", 1e-4, 10.0))),
    Contender("PlaCo", "placo", ranges=(("regularisation", 1e-8, 1e-2),)),
    Contender("RoboPlan", "roboplan", ranges=(("regularization", 1e-8, 1e-1), ("lm_damping", 1e-4, 10.0))),
    Contender("jparse-robotics", "jparse", ranges=(("gamma", 0.01, 0.9),)),
    Contender("PyKDL wdls", "pykdl", ranges=(("lambda", 1e-3, 1.0), ("eps", 1e-4, 1.0))),
    Contender("EmbodiK", "embodik", ranges=(("damping", 1e-3, 1.0), ("tolerance", 1e-3, 1.0))),
)
"""Other packages with their defaults."""


def drawn(contender: Contender, tries: int = TRIES) -> list[dict[str, float]]:
    """The settings that are tried, the same in every run; more begin with the same ones; none without parameters."""
    if not contender.ranges:
        return []
    rng = np.random.default_rng(0)
    found: list[dict[str, float]] = []
    while len(found) < tries:
        setting = {
            name: float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.3g}") for name, low, high in contender.ranges
        }
        if contender.script or _allowed(contender, setting):
            found.append(setting)
    return found


def _allowed(contender: Contender, setting: Mapping[str, float]) -> bool:
    try:
        if contender.kind != "SecondOrder":
            contender.set_to(setting).method()
        else:
            rik.SecondOrder(**setting)
    except rik.InputError:
        return False
    return True
