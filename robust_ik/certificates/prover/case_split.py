"""The case split: from the case without conditions to leaves; equal cases share a node."""

from __future__ import annotations

import heapq
import itertools
import math
import time
from collections.abc import Container
from dataclasses import dataclass, field, replace
from typing import Any

from robust_ik.certificates.effort import Effort, OutOfStepsError, TooLargeError
from robust_ik.certificates.proof.case_tree import ExactPin, Node, State
from robust_ik.certificates.prover.case_decision import Case, Decision
from robust_ik.certificates.prover.child_cases import factors, image
from robust_ik.certificates.prover.exact_arm import ExactArm
from robust_ik.certificates.prover.jacobian_columns import Columns
from robust_ik.certificates.prover.number_fields import Field, coefficients, poly
from robust_ik.certificates.prover.remembered import Memory

MAX_NODES = 5000
"""Most cases before the prover gives up. Chosen: nine times the Panda's for corank 2 (565); a split may never end."""

HOPELESS, FEW = 2.0, 20
"""A split is given up, once FEW cases were treated, where those that wait need more steps than are left though each
takes the mean of the others divided by HOPELESS. Chosen: the hardest proof that closes, corank 3 of the srs_10r,
comes to 1.3 on its way.
"""

OUT_OF_TIME = "out of time"
"""Why a case was not looked at: the time was up, or there were too many of them."""
OUT_OF_STEPS = f"too large: {OutOfStepsError.text}"
"""The same: the steps that are left are fewer than the cases that wait take at least."""
NOT_LOOKED_AT = "another case is open or implicit"
"""The same: it cannot make the proof complete any more."""


def split(
    arm: ExactArm, corank: int, link: int, deadline: float, effort: Effort, spoilt: Container[str] = ()
) -> tuple[Node, ...]:
    """The cases, the root first.

    Args:
        arm: The arm.
        corank: Rank deficiency.
        link: The link whose frame is used.
        deadline: When to stop, in the time of `time.monotonic`; undecided cases then stay open.
        effort: The effort that is allowed.
        spoilt: Kinds of cases after which no other one is worth looking at: all that wait stay open.
    """
    return _Splitter(Columns(arm, link), corank, deadline, effort, spoilt).run()


@dataclass
class _Splitter:
    columns: Columns
    corank: int
    deadline: float
    effort: Effort
    spoilt: Container[str]
    nodes: list[Node] = field(default_factory=list)
    ids: dict[State, int] = field(default_factory=dict)
    waiting: list[tuple[int, int]] = field(default_factory=list)
    leaves: list[int] = field(default_factory=list)
    memory: Memory = field(default_factory=Memory)
    allowed: float = 0.0
    treated: int = 0

    def run(self) -> tuple[Node, ...]:
        self._node(State())
        self.allowed = self.effort.steps
        while self.waiting and not self._given_up():
            _, index = heapq.heappop(self.waiting)
            self.nodes[index] = self._treat(self.nodes[index].state)
            self.treated += 1
            if self.nodes[index].kind == "leaf":
                self.leaves.append(index)
            if self.nodes[index].kind in self.spoilt:
                self._leave(NOT_LOOKED_AT)
        self._drop_contained()
        return tuple(self.nodes)

    def _given_up(self) -> bool:
        """Whether the cases that wait were left open, as they cannot all be treated."""
        if time.monotonic() > self.deadline or len(self.nodes) > MAX_NODES:
            self._leave(OUT_OF_TIME)
        elif len(self.waiting) * max(self._least, self._expected) > self.effort.steps:
            self.effort.steps = -1
            self._leave(OUT_OF_STEPS)
        return not self.waiting

    @property
    def _expected(self) -> float:
        """Steps below which no case that waits is hoped to stay: a part of the mean of those that were treated."""
        if self.effort.whole or self.treated < FEW:
            return 0.0
        return (self.allowed - self.effort.steps) / self.treated / HOPELESS

    def _leave(self, reason: str) -> None:
        """Leaves all cases that wait open."""
        for _, index in self.waiting:
            self.nodes[index] = replace(self.nodes[index], reason=reason)
        self.waiting.clear()

    @property
    def _least(self) -> int:
        """The steps that each case takes at least: for its Jacobian, and for work not counted elsewhere."""
        return 2 * self.columns.arm.n**2

    def _node(self, state: State) -> int:
        """The node of a state; nodes with few conditions are treated first, so that a leaf precedes its parts."""
        if state not in self.ids:
            self.ids[state] = len(self.nodes)
            self.nodes.append(Node(state))
            heapq.heappush(self.waiting, (len(state.pins) + len(state.generators), self.ids[state]))
        return self.ids[state]

    def _case(self, state: State) -> Case:
        return Case(self.columns, self.corank, state, self.effort, self.memory)

    def _treat(self, state: State) -> Node:
        case = self._case(state)
        try:
            self.effort.spend(self._least)
            inside = self._inside(case, self.leaves)
            return inside or self._decided(case, case.decide())
        except TooLargeError as error:
            return Node(state, "open", reason=f"too large: {error}")

    def _decided(self, case: Case, decision: Decision) -> Node:
        if decision.factored is None:
            return Node(case.state, decision.kind, relations=decision.relations, reason=decision.reason)
        children = factors(case.state, case.half, decision.factored, self._node)
        return Node(
            case.state,
            "split" if any(factor.kind != "unreal" for factor in children) else "contradiction",
            decision.source,
            decision.factored.norm,
            coefficients(decision.factored.constant),
            decision.degrees,
            children,
        )

    def _drop_contained(self) -> None:
        """Marks leaves that lie inside another leaf as subsumed."""
        if self.effort.steps < 0:
            return
        self.effort = replace(self.effort, steps=math.inf)  # each of these cases was treated within its limits before
        for index in list(self.leaves):
            others = [other for other in self.leaves if other != index]
            inside = self._inside(self._case(self.nodes[index].state), others)
            if inside:
                self.leaves.remove(index)
                self.nodes[index] = inside
        for index, node in enumerate(self.nodes):
            if node.kind == "subsumed" and self.nodes[node.leaf].kind != "leaf":
                target = node
                while target.kind == "subsumed":
                    target = self.nodes[target.leaf]
                inside = self._inside(self._case(node.state), [self.nodes.index(target)])
                assert inside is not None
                self.nodes[index] = inside

    def _inside(self, case: Case, leaves: list[int]) -> Node | None:
        pins = case.state.pinned
        for index in leaves:
            theta = _embedding(pins, case.half.field, self.nodes[index].state)
            if theta is not None and self._relations_hold(case, self.nodes[index], theta):
                return Node(case.state, "subsumed", leaf=index, image=coefficients(theta))
        return None

    def _relations_hold(self, case: Case, leaf: Node, theta: Any) -> bool:
        for index, _ in leaf.relations:
            form = leaf.state.generators[index]
            terms = tuple((powers, image(value, theta, case.half.field)) for powers, value in form.terms)
            moved = case.half.parse(replace(form, terms=terms))
            if not case.follows(case.half.restrict(moved, case.state)):
                return False
        return True


def _embedding(pins: dict[int, ExactPin], field: Field, leaf: State) -> Any | None:
    """θ of a leaf's field, in a state's field, for which the leaf's pins hold; None without one."""
    for pin in leaf.pins:
        mine = pins.get(pin.joint)
        if mine is None or mine.x != pin.x or (len(pin.y) == 1 and mine.y != pin.y):
            return None
    algebraic = [pin for pin in leaf.pins if len(pin.y) > 1]
    for theta in [poly(("0",))] if not algebraic else _thetas(field, [pins[pin.joint].y for pin in algebraic]):
        pairs = ((pins[pin.joint], pin) for pin in leaf.pins)
        same = all(mine.x == pin.x and mine.y == image(pin.y, theta, field) for mine, pin in pairs)
        if same and image(leaf.field, theta, field) == ("0",):
            return theta
    return None


def _thetas(field: Field, values: list[Any]) -> list[Any]:
    """Candidates of the primitive element: θ itself and small combinations of the joints' t."""
    combinations = itertools.product(range(1, 4), repeat=len(values) - 1)
    sums = [
        field.reduce(sum((poly(v) * m for m, v in zip(multiples, values[1:])), start=poly(values[0])))
        for multiples in combinations
    ]
    return [poly(("0", "1")), *sums]
