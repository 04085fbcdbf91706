"""Ways to spoil a proof. Every one of them must be refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from robust_ik.certificates.proof.case_tree import ExactPin, Form, FormFactor, Node
from robust_ik.certificates.proof.proof import Proof

P = 2**61 - 1


def spoiled(proof: Proof) -> Iterator[tuple[str, Proof]]:
    """Every mutation of every case, with its name."""
    for index, node in enumerate(proof.nodes):
        for name, other in [*_splits(node), *_others(proof, node)]:
            yield f"{name} in case {index}", _with(proof, index, other)
        for name, whole in _infinite(proof, index, node):
            yield f"{name} in case {index}", whole
    yield from _arms(proof)
    yield from _kinds(proof)


def _with(proof: Proof, index: int, node: Node) -> Proof:
    return replace(proof, nodes=(*proof.nodes[:index], node, *proof.nodes[index + 1 :]))


def _splits(node: Node) -> Iterator[tuple[str, Node]]:
    if node.kind not in ("split", "contradiction"):
        return
    for i, factor in enumerate(node.factors):
        rest = node.factors[:i] + node.factors[i + 1 :]
        joint, power = factor.form.joints[0], factor.power
        at_pi = factor.form.degrees == (1,) and factor.form.terms[0][0] == (0,) and len(factor.form.terms) == 1
        yield "a factor dropped" + (" (q = π)" if at_pi else ""), replace(node, factors=rest)
        if at_pi:
            degrees = tuple((j, d - power if j == joint else d) for j, d in node.degrees)
            yield "q = π dropped with its degree", replace(node, factors=rest, degrees=degrees)
        yield (
            "a power raised",
            replace(node, factors=(*node.factors[:i], replace(factor, power=power + 1), *node.factors[i + 1 :])),
        )
        for name, other in _factors(factor):
            yield name, replace(node, factors=(*node.factors[:i], other, *node.factors[i + 1 :]))
    if node.kind == "split":
        yield "a split called a leaf", replace(node, kind="leaf")
        yield "a split called a contradiction", replace(node, kind="contradiction")
        yield "a contradiction without factors", replace(node, kind="contradiction", factors=())
    yield "a constant zero", replace(node, constant=("0",))
    yield "another constant", replace(node, constant=(str(Fraction(node.constant[0]) + 1), *node.constant[1:]))
    if node.source is not None and node.source.kind == "minor":
        for i, (joint, degree) in enumerate(node.degrees):
            yield (
                "a degree lowered",
                replace(node, degrees=(*node.degrees[:i], (joint, degree - 2), *node.degrees[i + 1 :])),
            )
        smaller = replace(node.source, rows=node.source.rows[:-1], columns=node.source.columns[:-1])
        yield "a smaller minor", replace(node, source=smaller)
        if len(node.source.columns) > 1:
            twice = replace(node.source, columns=(*node.source.columns[:-1], node.source.columns[0]))
            yield "a column twice", replace(node, source=twice)
            same = replace(node.source, rows=(*node.source.rows[:-1], node.source.rows[0]))
            yield "a row twice", replace(node, source=same)


def _factors(factor: FormFactor) -> Iterator[tuple[str, FormFactor]]:
    if factor.child >= 0:
        yield "a child redirected", replace(factor, child=factor.child + 1)
        yield "a child redirected to the root", replace(factor, child=0)
        yield "a child lost", replace(factor, child=-1)
        yield "a factor called unreal", replace(factor, kind="unreal", child=-1)
    form = factor.form
    powers, coefficient = form.terms[0]
    shifted = (powers, (str(Fraction(coefficient[0]) + P), *coefficient[1:]))
    yield (
        "a coefficient moved by the first prime",
        replace(factor, form=replace(form, terms=(shifted, *form.terms[1:]))),
    )
    for i, branch in enumerate(factor.branches):
        rest = factor.branches[:i] + factor.branches[i + 1 :]
        yield "a branch dropped", replace(factor, branches=rest)
        if branch.child >= 0:
            lost = replace(branch, child=-1)
            yield (
                "a real branch lost",
                replace(factor, branches=(*factor.branches[:i], lost, *factor.branches[i + 1 :])),
            )
        moved = replace(branch, new=(str(Fraction(branch.new[0]) + 1), *branch.new[1:]))
        yield "a branch elsewhere", replace(factor, branches=(*factor.branches[:i], moved, *factor.branches[i + 1 :]))


def _others(proof: Proof, node: Node) -> Iterator[tuple[str, Node]]:
    if node.kind == "leaf":
        for i in range(len(node.state.pins)):
            pins = node.state.pins[:i] + node.state.pins[i + 1 :]
            yield "a leaf unpinned", replace(node, state=replace(node.state, pins=pins))
        if node.relations:
            yield "a leaf without a relation", replace(node, relations=node.relations[1:])
        yield "a leaf left open", replace(node, kind="open")
    if node.kind == "subsumed":
        pins = {(pin.joint, pin.x, pin.y) for pin in node.state.pins}
        for index, other in enumerate(proof.nodes):
            if other.kind == "leaf" and not {(p.joint, p.x, p.y) for p in other.state.pins} <= pins:
                yield "a case put into another leaf", replace(node, leaf=index)
                break
        yield "a case put into itself", replace(node, leaf=proof.nodes.index(node))
        yield "a case left open", replace(node, kind="open")


def _infinite(proof: Proof, index: int, node: Node) -> Iterator[tuple[str, Proof]]:
    """Sliding joints at d = ∞, which is no configuration."""
    assert proof.arm is not None
    for joint in proof.arm.sliding:
        if node.kind in ("split", "contradiction") and joint not in node.state.pinned:
            pins = sorted((*node.state.pins, ExactPin(joint, ("0",), ("1",))), key=lambda pin: pin.joint)
            leaf = Node(replace(node.state, pins=tuple(pins)), "leaf")
            form = Form((joint,), (1,), (((0,), ("1",)),))  # x, which is 1: the product stays what it is
            more = (*node.factors, FormFactor("pin", form, 1, len(proof.nodes)))
            grown = replace(proof, nodes=(*proof.nodes, leaf))
            yield "a leaf at infinity", _with(grown, index, replace(node, kind="split", factors=more))
            if node.source is not None and node.source.kind == "minor":
                yield "a degree of a length", _with(proof, index, replace(node, degrees=(*node.degrees, (joint, 2))))
        if node.kind == "leaf" and joint in node.state.pinned:
            pins = [replace(pin, x=("0",), y=("1",)) if pin.joint == joint else pin for pin in node.state.pins]
            away = replace(node, state=replace(node.state, pins=tuple(pins)))
            yield "a leaf moved to infinity", _with(proof, index, away)


def _kinds(proof: Proof) -> Iterator[tuple[str, Proof]]:
    """Joints that turn where they slid, and the other way round."""
    assert proof.arm is not None
    for joint in range(len(proof.arm.joints)):
        sliding = tuple(sorted(set(proof.arm.sliding) ^ {joint}))
        yield f"joint {joint + 1} of the other kind", replace(proof, arm=replace(proof.arm, sliding=sliding))


def _arms(proof: Proof) -> Iterator[tuple[str, Proof]]:
    assert proof.arm is not None
    for i in range(2, min(5, len(proof.arm.joints))):
        *rotation, offset = proof.arm.links[i]
        for axis in range(3):
            moved = tuple(str(Fraction(a) + (Fraction(1, 50) if j == axis else 0)) for j, a in enumerate(offset))
            links = (*proof.arm.links[:i], (*rotation, moved), *proof.arm.links[i + 1 :])
            yield f"joint {i + 1} moved along {'xyz'[axis]}", replace(proof, arm=replace(proof.arm, links=links))
    *rotation, offset = proof.arm.links[1]
    skew = (tuple(str(2 * Fraction(a)) for a in rotation[0]), *rotation[1:], offset)
    links = (proof.arm.links[0], skew, *proof.arm.links[2:])
    yield "a link that is no rotation", replace(proof, arm=replace(proof.arm, links=links))
