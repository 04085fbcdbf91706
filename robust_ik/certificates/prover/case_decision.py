"""Decides what to do with a case: which minor to branch on, or whether it is a leaf."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from robust_ik.certificates.effort import Effort, TooLargeError, height
from robust_ik.certificates.proof.case_tree import Source, State
from robust_ik.certificates.prover.exact_arm import ExactArm
from robust_ik.certificates.prover.factoring import Factored, factor
from robust_ik.certificates.prover.half_angle_forms import HalfAngles, Homogeneous
from robust_ik.certificates.prover.jacobian_columns import Columns
from robust_ik.certificates.prover.minors import Minor, reduced
from robust_ik.certificates.prover.number_fields import Field
from robust_ik.certificates.prover.remembered import Memory
from robust_ik.certificates.prover.trig_polynomials import Trig
from robust_ik.certificates.prover.vanishing import divides, triangular, vanishes

TRIALS = 30
"""Most minors that are factored, the shortest first, to find the one to branch on. Chosen: more make fewer cases, but
take longer."""

MAX_LIVE = 6
"""Most relations of a case; with more it is given up as implicit. Chosen: more may resolve it, but take long."""
MAX_RELATIONS = 3
"""Most relations that describe a leaf. Chosen: all sets of this size are tried, and their number grows fast."""


@dataclass(frozen=True)
class Decision:
    """The decision on a case.

    Attributes:
        kind: "split", "leaf", "implicit" or "open".
        source: The vanishing polynomial that was factored.
        factored: Its factors; none for a contradiction.
        degrees: Its formal degrees by joint.
        relations: For a leaf, the generators that describe it, each with the joint for which it is solved.
        reason: Why it is open.
    """

    kind: str
    source: Source | None = None
    factored: Factored | None = None
    degrees: tuple[tuple[int, int], ...] = ()
    relations: tuple[tuple[int, int], ...] = ()
    reason: str = ""


@dataclass(frozen=True)
class Case:
    """One case: a set of conditions on an arm, for one corank.

    Attributes:
        columns: Columns of the arm's Jacobian in the frame of a link.
        corank: Rank deficiency.
        state: The conditions.
        effort: The effort that is left.
        memory: Results of the case split so far.
    """

    columns: Columns
    corank: int
    state: State
    effort: Effort
    memory: Memory

    @property
    def arm(self) -> ExactArm:
        """The arm."""
        return self.columns.arm

    @cached_property
    def half(self) -> HalfAngles:
        """The forms over the state's field."""
        return HalfAngles(self.arm.n, Field(self.state.field), self.effort, self.arm.sliding, self.memory)

    def decide(self) -> Decision:
        """The decision: a leaf, a contradiction, or a polynomial to branch on."""
        return self._reducible or self._overdetermined or self._branch()

    @cached_property
    def _overdetermined(self) -> Decision | None:
        """A split on a resultant, if the relations cannot each be solved for a joint of its own."""
        relations = [factor.value for _, factor in self.live]
        if len(relations) < 2 or next(triangular(relations), None) is not None:
            return None
        return self._eliminate()

    # ------------------------------------------------------------------------------------------ generators
    @cached_property
    def _generators(self) -> list[tuple[int, Homogeneous, Factored]]:
        """Generators that do not vanish with the pins inserted."""
        found = []
        for index, form in enumerate(self.state.generators):
            value = self.half.restrict(self.half.parse(form), self.state)
            if value.value:
                found.append((index, value, factor(self.half, value)))
        return found

    @cached_property
    def live(self) -> list[tuple[int, Homogeneous]]:
        """Relations of the case: generators that, with pins inserted, are one irreducible form in several joints."""
        found: dict[str, tuple[int, Homogeneous]] = {}
        for index, value, factored in self._generators:
            if factored.cost == (1, 0, 1) and factored.factors[0][1] == 1 and not factored.norm:
                found.setdefault(factored.factors[0][0].key[0], (index, value))
        return sorted(found.values(), key=lambda pair: (len(pair[1].joints), len(pair[1].value)))

    @cached_property
    def _reducible(self) -> Decision | None:
        """A split on a generator that the pins made reducible."""
        for index, value, factored in self._generators:
            if not self.vanishes(value):
                return self._split(Source("generator", first=index), factored, value)
        return None

    def vanishes(self, value: Homogeneous) -> bool:
        """Whether a form is zero at generic points of the relations."""
        return self._zero_on(value, [relation for _, relation in self.live])

    def _zero_on(self, value: Homogeneous, relations: list[Homogeneous]) -> bool:
        if not value.value:
            return True
        key = ("vanishes", value.key[0], tuple(each.key[0] for each in relations), self.state.field)
        forms = [each.value for each in relations]
        return self.memory.recall(key, self.effort, lambda: vanishes(self.half, value.value, forms))

    def follows(self, value: Homogeneous) -> bool:
        """Whether a form is zero everywhere on the relations: zero, or a multiple of one of them."""
        if not value.value:
            return True
        return any(divides(self.half, relation.value, value.value) for _, relation in self.live)

    # ------------------------------------------------------------------------------------------ minors
    def _branch(self) -> Decision:
        trig = Trig(self.arm.n, self.half.field, self.arm.sliding)
        matrix = reduced(trig, self.columns.jacobian(trig, self.state))
        size = self.arm.rank - self.corank + 1
        if size <= len(matrix.pivots):
            return self._constant(matrix.constant(size), matrix.determinant(size))
        factor = trig.element(matrix.determinant(size))
        minors = [(each, self.half.of(trig.reduce(each.value * factor))) for each in matrix.minors(size, self.effort)]
        leaf = self._leaf([value for _, value in minors])
        if leaf:
            return leaf
        candidates = [(minor, value) for minor, value in minors if not self.vanishes(value)]
        if not candidates:
            return Decision("implicit", reason="the relations cannot be solved one after another")
        return self._cheapest(sorted(candidates, key=lambda pair: len(pair[1].value)))

    def _leaf(self, minors: list[Homogeneous]) -> Decision | None:
        """A leaf with the fewest relations that make all minors vanish, if they can be solved one after another."""
        for size in range(min(len(self.live), MAX_RELATIONS) + 1):
            for chosen in itertools.combinations(self.live, size):
                relations = [relation for _, relation in chosen]
                order = next(triangular([relation.value for relation in relations]), None)
                if order is not None and all(self._zero_on(minor, relations) for minor in minors):
                    indices = {relation.key[0]: index for index, relation in chosen}
                    return Decision("leaf", relations=tuple((indices[str(f)], joint) for f, joint in order))
        return None

    def _constant(self, minor: Minor, value: Any) -> Decision:
        return Decision("split", Source("minor", minor.rows, minor.columns), Factored(value, ()))

    def _cheapest(self, candidates: list[tuple[Minor, Homogeneous]]) -> Decision:
        best: tuple[Factored, Minor, Homogeneous] | None = None
        for minor, value in candidates[:TRIALS]:
            try:
                factored = factor(self.half, value)
            except TooLargeError:
                continue
            if best is None or factored.cost < best[0].cost:
                best = (factored, minor, value)
            if best[0].cost <= (0, 0, 1):
                break
        if best is None:
            return Decision("open", reason="every minor is too large to be factored")
        if best[0].cost[0]:
            return self._relations(best)
        return self._split(Source("minor", best[1].rows, best[1].columns), best[0], best[2])

    def _split(self, source: Source, factored: Factored, value: Homogeneous) -> Decision:
        turning = [i for i in value.joints if i not in self.arm.sliding]
        return Decision("split", source, factored, tuple((i, int(value.degrees[i])) for i in turning))

    def _relations(self, best: tuple[Factored, Minor, Homogeneous]) -> Decision:
        """Branches on a resultant of the relations, else on a minor that gives a further relation."""
        eliminated = self._eliminate()
        if eliminated is not None:
            return eliminated
        factored, minor, value = best
        if len(self.live) >= MAX_LIVE:
            return Decision("implicit", reason="the relations could not be resolved further")
        return self._split(Source("minor", minor.rows, minor.columns), factored, value)

    def _eliminate(self) -> Decision | None:
        """A split on the cheapest resultant of two relations that is not zero on the relations."""
        best: Decision | None = None
        for (i, f), (j, g) in itertools.combinations(self.live, 2):
            for joint in sorted(set(f.joints) & set(g.joints)):
                resultant = self._resultant(f, g, joint)
                if resultant is None or self.vanishes(resultant):
                    continue
                factored = factor(self.half, resultant)
                source = Source("resultant", first=i, second=j, joint=joint)
                found = self._split(source, factored, resultant)
                if best is None or (best.factored and factored.cost < best.factored.cost):
                    best = found
        return best

    def _resultant(self, f: Homogeneous, g: Homogeneous, joint: int) -> Homogeneous | None:
        key = ("resultant", f.key, g.key, joint, self.state.field)
        return self.memory.recall(key, self.effort, lambda: self._new_resultant(f, g, joint))

    def _new_resultant(self, f: Homogeneous, g: Homogeneous, joint: int) -> Homogeneous | None:
        a, b = f.degrees[joint], g.degrees[joint]
        degrees = [b * m + a * n for m, n in zip(f.degrees, g.degrees)]
        degrees[joint] = 0
        bits = b * height(f.value.coeffs()) + a * height(g.value.coeffs())
        work = len(f.value) * len(g.value)
        if not self.half.field.is_rational or work > 10 * self.effort.terms or bits > self.effort.bits:
            return None
        self.effort.spend(min(work, math.prod(d + 1 for d in degrees)) * (1 + bits // 256))
        value = f.value.resultant(g.value, f"t{joint}")
        if not value:
            return None
        return self.half.homogeneous(value, degrees)
