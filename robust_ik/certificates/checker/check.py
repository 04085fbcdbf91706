"""Checks a proof without trusting the prover: other kinematics, no computer algebra, numbers modulo large primes.

Every split claims that a minor of the Jacobian, times Π (x² + y²)^(d/2), is a constant times its factors. If that is
false, both sides differ at a random point modulo a random prime, except with a chance below 1e-15. So a false proof
passes a round with less than that chance for each of its cases; a true one always passes. The condition that a child
adds to its parent, the number fields and the absence of real roots are checked exactly.
"""

from __future__ import annotations

import hashlib
import random
from dataclasses import dataclass
from fractions import Fraction

from robust_ik.certificates.checker.expected_children import (
    RefusedError,
    branch_child,
    check_branch,
    check_unreal,
    pin_child,
    relation_child,
    require,
)
from robust_ik.certificates.checker.largest_rank import check_rank
from robust_ik.certificates.checker.leaf_checks import check_inside, check_leaf
from robust_ik.certificates.checker.modular_arithmetic import UnluckyError, random_prime
from robust_ik.certificates.checker.modular_kinematics import ROW_NAMES, is_rigid
from robust_ik.certificates.checker.random_points import RandomPoint, source_value
from robust_ik.certificates.checker.root_counting import count_real_roots
from robust_ik.certificates.proof.case_tree import RATIONAL, FormFactor, Node, State
from robust_ik.certificates.proof.counted_steps import MOST, TooManyStepsError, at_most
from robust_ik.certificates.proof.proof import Proof, from_json
from robust_ik.certificates.proof.proof_arm import Arm
from robust_ik.certificates.proof.untrusted_json import CertificateError
from robust_ik.checks.public_arguments import checked

ATTEMPTS = 20
"""Most primes tried for a case. By chance one in about 2⁵⁰ divides by zero: if twenty do, the proof is wrong."""


@dataclass(frozen=True)
class Verdict:
    """The result of a check.

    Attributes:
        accepted: Whether the proof holds and no leaf only repeats the equations: "certified".
        reason: A sentence that says what holds, or what does not and where.
        implicit: Whether the proof holds, but some leaves only repeat the equations.
        cases: Number of cases that were checked.
        places: At how many real places of its field each leaf is, by the checker's own count.
    """

    accepted: bool
    reason: str
    implicit: bool = False
    cases: int = 0
    places: tuple[int, ...] = ()


@checked
def check(
    certificate: str | Proof,
    *,
    arm: Arm | None = None,
    seed: int | None = None,
    rounds: int = 2,
    steps: float = MOST,
) -> Verdict:
    """Checks whether a proof holds.

    Args:
        certificate: The proof, or its JSON.
        arm: The arm that the proof must be about; by default the arm in the proof.
        seed: Seed of the random points and primes; by default a hash of the proof's text, so that the same proof gets
            the same points, and no proof can be made to fit them.
        rounds: How often every identity is tested, at new points and modulo a new prime.
        steps: Most steps, counted as in `counted_steps`; a certificate that takes more is refused.
    """
    try:
        text = certificate.to_json() if isinstance(certificate, Proof) else certificate
        proof = from_json(text)
    except CertificateError as error:
        return Verdict(False, f"refused: {error}")
    if seed is None:
        seed = int.from_bytes(hashlib.sha256(text.encode()).digest(), "big")
    try:
        with at_most(steps):
            _check_frame(proof, arm)
            for turn in range(max(1, rounds)):
                _Round(proof, random.Random(f"{seed}:{turn}"), turn == 0).run()
            places = tuple(_real_places(node.state) for node in proof.leaves)
    except (RefusedError, TooManyStepsError) as error:
        return Verdict(False, f"refused: {error}")
    except (UnluckyError, ZeroDivisionError, OverflowError) as error:
        return Verdict(False, f"refused: the numbers do not allow a check: {error}")
    return _verdict(proof, places)


def _real_places(state: State) -> int:
    """The number of real places of the field of a leaf's conditions."""
    return 1 if state.field == RATIONAL else count_real_roots(state.field)


def _verdict(proof: Proof, places: tuple[int, ...]) -> Verdict:
    cases, leaves = len(proof.nodes), len(proof.leaves)
    implicit = sum(proof.is_implicit(node) for node in proof.nodes)
    if implicit:
        why = f"the cases hold, but {implicit} leaves only repeat the equations: implicit"
        return Verdict(False, why, implicit=True, cases=cases, places=places)
    why = f"{cases} cases hold: no singular configuration outside {leaves} leaves"
    return Verdict(True, why, cases=cases, places=places)


def _check_frame(proof: Proof, arm: Arm | None) -> None:
    """Checks what all cases share: the arm, the corank, the root."""
    require(proof.arm is not None and proof.nodes, f"there is no case split ({proof.reason or 'no cases'})")
    assert proof.arm is not None
    require(arm is None or _geometry(arm) == _geometry(proof.arm), "it is about another arm")
    require(is_rigid(proof.arm), "a link of the arm is no rigid motion")
    most = min(len(proof.arm.rows), len(proof.arm.joints))
    require(1 <= proof.arm.rank <= most, "the rank is larger than it can be")
    require(proof.corank <= proof.arm.rank, "the corank is larger than the rank can be")
    rows = set(proof.arm.rows)
    free = rows in (set(ROW_NAMES), set(ROW_NAMES[:3]), set(ROW_NAMES[3:]))
    link = proof.link <= len(proof.arm.motions) and (free or proof.link == 0)
    require(link, "the rank in that link's frame is not the rank in the base")
    require(proof.nodes[0].state == State(), "the first case has conditions")
    for index, node in enumerate(proof.nodes):
        require(node.kind != "open", f"case {index} is open ({node.reason or 'no reason given'})")
        _check_state(node.state, proof.arm, f"case {index}")


def _geometry(arm: Arm) -> tuple[object, ...]:
    return arm.rows, arm.links, arm.sliding, arm.rank, arm.motions


def _check_state(state: State, arm: Arm, where: str) -> None:
    """Checks that conditions are about the arm's joints, in a field."""
    joints, n = [pin.joint for pin in state.pins], len(arm.joints)
    require(joints == sorted(set(joints)) and all(joint < n for joint in joints), f"{where}: pins of no joint")
    for pin in state.pins:
        infinite = (pin.x, pin.y) == (("0",), ("1",))
        require(not infinite or pin.joint not in arm.sliding, f"{where}: a sliding joint is at infinity")
        require(infinite or pin.x == ("1",), f"{where}: a pin that is not (1 : t) or (0 : 1)")
    require(len(state.field) > 1 and Fraction(state.field[-1]), f"{where}: a field without a polynomial")
    for form in state.generators:
        require(all(joint < n for joint in form.joints), f"{where}: a form of no joint")


@dataclass
class _Round:
    proof: Proof
    rng: random.Random
    first: bool
    prime: int = 0

    def __post_init__(self) -> None:
        self.prime = random_prime(self.rng)

    def run(self) -> None:
        assert self.proof.arm is not None
        check_rank(self.proof.arm, self.rng)
        for index, node in enumerate(self.proof.nodes):
            try:
                self._retried(node)
            except RefusedError as error:
                raise RefusedError(f"case {index}: {error}") from None

    def _retried(self, node: Node) -> None:
        """Checks a node; after a division by zero, again modulo another prime."""
        for attempt in range(ATTEMPTS):
            if attempt:
                self.prime = random_prime(self.rng)
            try:
                self._node(node, self.prime)
            except UnluckyError:
                continue
            return
        raise RefusedError("divisions by zero at every prime that was tried")

    def _node(self, node: Node, prime: int) -> None:
        if node.kind in ("split", "contradiction"):
            if self.first:
                self._children(node)
            self._identity(node, prime)
        elif node.kind == "leaf":
            check_leaf(self.proof, node, self.rng)
        elif node.kind == "subsumed":
            require(0 <= node.leaf < len(self.proof.nodes), "there is no such leaf")
            check_inside(self.proof, node, self.proof.nodes[node.leaf], self.rng, prime)

    # ------------------------------------------------------------------------------------------ children
    def _children(self, node: Node) -> None:
        require(
            node.kind == "split" or all(factor.kind == "unreal" for factor in node.factors), "a contradiction leads on"
        )
        require(not node.norm or node.state.field != RATIONAL, "a norm over ℚ of what is in ℚ")
        for factor in node.factors:
            if factor.kind == "pin":
                self._same(factor.child, pin_child(node.state, factor))
            elif factor.kind == "relation":
                self._same(factor.child, relation_child(node.state, factor))
            elif factor.kind == "unreal":
                check_unreal(factor)
            else:
                require(len(factor.form.joints) == 1, "roots of what is not of one joint")
                self._branches(node, factor)

    def _branches(self, node: Node, factor: FormFactor) -> None:
        for branch in factor.branches:
            check_branch(node.state, factor, branch)
            if branch.child >= 0:
                self._same(branch.child, branch_child(node.state, factor.form.joints[0], branch))

    def _same(self, child: int, state: State) -> None:
        require(0 <= child < len(self.proof.nodes), "a factor has no child")
        require(self.proof.nodes[child].state == state, f"case {child} is not this case with its factor")

    # ------------------------------------------------------------------------------------------ identities
    def _identity(self, node: Node, prime: int) -> None:
        """Checks source · Π (x² + y²)^(d/2) = constant · Π factor^power, constant ≠ 0, at a random point."""
        require(node.source is not None and any(Fraction(a) for a in node.constant), "nothing that vanishes is given")
        assert node.source is not None
        place = RandomPoint.random(self.proof, node.state, self.rng, prime)
        ring, p = place.ring, prime
        value = source_value(place, self.proof, node)
        constant = ring.number(node.constant)
        if node.norm:
            require(len(node.constant) == 1, "the constant of a norm is not rational")
            value = ring.norm(value)
        else:
            ring.inverse(constant)  # refuses a constant with a root in common with the field's polynomial
        for factor in node.factors:
            require(not (node.norm and place.is_algebraic(factor.form)), "a factor of a norm is not rational")
            require(not set(factor.form.joints) & set(node.state.pinned), "a factor involves a pinned joint")
            form = place.value(factor.form)
            for _ in range(factor.power):
                constant = constant * form % p
            if factor.kind == "roots":
                place.check_components(factor)
        require((value - constant) % p == 0, "what vanishes is not the product of its factors")
