"""Proof: a case split of an arm's singular configurations, as plain values with a JSON form."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from functools import cache, cached_property
from typing import Any

from robust_ik.certificates.proof.case_tree import (
    Coefficients,
    ExactPin,
    FieldBranch,
    Form,
    FormFactor,
    Node,
    Source,
    State,
)
from robust_ik.certificates.proof.proof_arm import (
    FULL_RANK,
    MAX_JOINTS,
    TURNING_ONLY,
    VERSION,
    Arm,
    always_said,
    read_arm,
)
from robust_ik.certificates.proof.untrusted_json import (
    CertificateError,
    a_list,
    a_text,
    an_integer,
    an_object,
    coefficients,
    pairs,
    read_json,
)

FORMAT = "robust_ik certificate"
MAX_LENGTH = 20_000_000
"""Most characters of a proof. Chosen: thirty times the Panda's for corank 2 (0.6 MB), which is read in seconds."""
MAX_NODES = 20_000
"""Most cases of a proof. Chosen: four times as many as the prover makes before it gives up (`case_split.MAX_NODES`)."""
MAX_DEGREE = 128
"""Largest power in a form, or of a form. Chosen: ten times the 12 of a joint in a minor of six columns, 2 in each."""


@dataclass(frozen=True)
class Proof:
    """A case split for one corank of an arm.

    Attributes:
        arm: The arm in rational numbers, or None if it is not supported.
        corank: The rank deficiency: rank ≤ g − corank, g being the arm's `rank`.
        link: The link in whose frame the minors are written; 0 for the base.
        nodes: The cases; the first is the root.
        reason: Why the status is "unsupported", or empty.
    """

    arm: Arm | None
    corank: int
    link: int = 0
    nodes: tuple[Node, ...] = field(default=(), repr=False)
    reason: str = ""

    @property
    def status(self) -> str:
        """One of "proved", "implicit" (complete, but a leaf only repeats the equations), "open", "unsupported"."""
        if self.arm is None:
            return "unsupported"
        if not self.nodes or any(node.kind == "open" for node in self.nodes):
            return "open"
        return "implicit" if any(self.is_implicit(node) for node in self.nodes) else "proved"

    @property
    def leaves(self) -> tuple[Node, ...]:
        """The leaves, implicit ones included."""
        return tuple(node for node in self.nodes if node.kind in ("leaf", "implicit"))

    def is_implicit(self, node: Node) -> bool:
        """Whether a case is a leaf that only repeats the equations.

        That is so if its relations are whole minors, and they are several, or nothing else is known there: a
        determinant that was not split says again that the determinant is zero.
        """
        if node.kind != "leaf":
            return node.kind == "implicit"
        forms = [node.state.generators[index] for index, _ in node.relations]
        alone = len(forms) > 1 or (len(forms) == 1 and not node.state.pins)
        return alone and all(form in self._whole_minors for form in forms)

    @cached_property
    def _whole_minors(self) -> frozenset[Form]:
        """Relations that are equal to a whole minor, without further factors."""
        splits = (node for node in self.nodes if node.source is not None and node.source.kind == "minor")
        return frozenset(node.factors[0].form for node in splits if len(node.factors) == 1)

    def to_json(self) -> str:
        """The proof as JSON text."""
        return to_json(self)

    @classmethod
    def from_json(cls, text: str) -> Proof:
        """A proof from JSON text.

        Raises:
            CertificateError: It is too long, no JSON, or no proof; nothing of it is run.
        """
        return from_json(text)


def to_json(proof: Proof) -> str:
    """A proof as JSON text."""
    data: dict[str, Any] = {"format": FORMAT, "version": VERSION, "status": proof.status}
    data |= {"corank": proof.corank, "link": proof.link, "reason": proof.reason}
    data["arm"] = None if proof.arm is None else _plain(proof.arm, {}) | always_said(proof.arm)
    known: dict[int, Any] = {}
    data["nodes"] = [_plain(node, known) for node in proof.nodes]
    return json.dumps(data, separators=(",", ":"), ensure_ascii=True)


def _plain(value: Any, known: dict[int, Any]) -> Any:
    """Dataclasses as objects without default values, tuples as lists.

    Args:
        value: A part of a proof.
        known: Forms that were converted before, by identity: most are in many cases of a proof.
    """
    if isinstance(value, tuple):
        return [_plain(item, known) for item in value]
    if value is None or isinstance(value, (str, int)):
        return value
    if id(value) in known:
        return known[id(value)]
    given = ((name, getattr(value, name), default) for name, default in _defaults(value.__class__))
    plain = {name: _plain(item, known) for name, item, default in given if item != default}
    if isinstance(value, Form):
        known[id(value)] = plain
    return plain


@cache
def _defaults(kind: Any) -> list[tuple[str, Any]]:
    return [(each.name, each.default) for each in fields(kind)]


def from_json(text: str) -> Proof:
    """A proof from JSON text; see `Proof.from_json`."""
    if not isinstance(text, str):
        raise CertificateError(f"a certificate is text, got {type(text).__name__}")
    if len(text) > MAX_LENGTH:
        raise CertificateError(f"a certificate of {len(text)} characters; more than {MAX_LENGTH} are refused")
    try:
        data = read_json(text)
    except (ValueError, RecursionError) as error:
        raise CertificateError(f"no JSON: {str(error)[:200]}") from error
    data = an_object(
        data, "the certificate", {"format", "version", "status", "corank", "link", "reason", "arm", "nodes"}
    )
    if data.get("format") != FORMAT or data.get("version") not in (TURNING_ONLY, FULL_RANK, VERSION):
        raise CertificateError(f"not a {FORMAT!r} of version {TURNING_ONLY} to {VERSION}")
    arm = None if data.get("arm") is None else read_arm(data["arm"], data["version"])
    nodes = a_list(data.get("nodes"), "nodes", MAX_NODES)
    corank, link = an_integer(data.get("corank"), "corank", 1, 6), an_integer(data.get("link"), "link", 0, MAX_JOINTS)
    known: Forms = {}
    read = tuple(_node(node, known) for node in nodes)
    return Proof(arm, corank, link, read, a_text(data.get("reason", ""), "reason"))


# ---------------------------------------------------------------------------------------------------- the parts
Forms = dict[str, Form]
"""The forms of a proof that were read before, by their text: most are in many cases."""


def _node(data: Any, known: Forms) -> Node:
    data = an_object(data, "a node", {each.name for each in fields(Node)})
    kind = data.get("kind", "open")
    if kind not in ("split", "contradiction", "leaf", "implicit", "subsumed", "open"):
        raise CertificateError(f"a node cannot be {str(kind)[:40]!r}")
    norm = data.get("norm", False)
    if not isinstance(norm, bool):
        raise CertificateError("norm is true or false")
    return Node(
        _state(data.get("state", {}), known),
        kind,
        None if data.get("source") is None else _source(data["source"]),
        norm,
        coefficients(data.get("constant", ["1"])),
        pairs(data.get("degrees", []), "degrees"),
        tuple(_factor(factor, known) for factor in a_list(data.get("factors", []), "factors", 200)),
        pairs(data.get("relations", []), "relations"),
        an_integer(data.get("leaf", -1), "leaf", -1, MAX_NODES),
        coefficients(data.get("image", ["0"])),
        a_text(data.get("reason", ""), "reason"),
    )


def _state(data: Any, known: Forms) -> State:
    data = an_object(data, "state", {"pins", "generators", "field"})
    pins = tuple(_pin(pin) for pin in a_list(data.get("pins", []), "pins", MAX_JOINTS))
    generators = tuple(_form(form, known) for form in a_list(data.get("generators", []), "generators", 100))
    return State(pins, generators, coefficients(data.get("field", ["0", "1"])))


def _pin(data: Any) -> ExactPin:
    data = an_object(data, "a pin", {"joint", "x", "y"})
    joint = an_integer(data.get("joint"), "joint", 0, MAX_JOINTS - 1)
    return ExactPin(joint, coefficients(data.get("x")), coefficients(data.get("y")))


def _form(data: Any, known: Forms) -> Form:
    text = str(data)  # of what JSON gives: the same only for the same values of the same types
    if text not in known:
        known[text] = _new_form(data)
    return known[text]


def _new_form(data: Any) -> Form:
    data = an_object(data, "a form", {"joints", "degrees", "terms"})
    joints = tuple(an_integer(j, "joint", 0, MAX_JOINTS - 1) for j in a_list(data.get("joints"), "joints", MAX_JOINTS))
    degrees = tuple(an_integer(d, "degree", 0, MAX_DEGREE) for d in a_list(data.get("degrees"), "degrees", MAX_JOINTS))
    if list(joints) != sorted(set(joints)) or len(joints) != len(degrees):
        raise CertificateError("a form names its joints once each, rising, with a degree for each")
    terms = tuple(_term(term, degrees) for term in a_list(data.get("terms"), "terms", 20_000))
    if not terms:
        raise CertificateError("a form has a term")
    return Form(joints, degrees, terms)


def _term(data: Any, degrees: tuple[int, ...]) -> tuple[tuple[int, ...], Coefficients]:
    pair = a_list(data, "a term", 2)
    if len(pair) != 2 or len(a_list(pair[0], "powers", MAX_JOINTS)) != len(degrees):
        raise CertificateError("a term is its powers and a coefficient")
    powers = tuple(an_integer(power, "power", 0, degree) for power, degree in zip(pair[0], degrees, strict=True))
    return powers, coefficients(pair[1])


def _source(data: Any) -> Source:
    data = an_object(data, "source", {each.name for each in fields(Source)})
    kind = data.get("kind")
    if kind not in ("minor", "generator", "resultant"):
        raise CertificateError(f"a source cannot be {str(kind)[:40]!r}")
    rows = tuple(
        tuple(coefficients(weight) for weight in a_list(row, "weights", 6))
        for row in a_list(data.get("rows", []), "rows", 6)
    )
    columns = tuple(an_integer(j, "column", 0, MAX_JOINTS - 1) for j in a_list(data.get("columns", []), "columns", 6))
    first, second, joint = (an_integer(data.get(key, -1), key, -1, 100) for key in ("first", "second", "joint"))
    return Source(kind, rows, columns, first, second, joint)


def _factor(data: Any, known: Forms) -> FormFactor:
    data = an_object(data, "a factor", {each.name for each in fields(FormFactor)})
    kind = data.get("kind")
    if kind not in ("pin", "relation", "roots", "unreal"):
        raise CertificateError(f"a factor cannot be {str(kind)[:40]!r}")
    return FormFactor(
        kind,
        _form(data.get("form"), known),
        an_integer(data.get("power"), "power", 1, MAX_DEGREE),
        an_integer(data.get("child", -1), "child", -1, MAX_NODES),
        an_integer(data.get("multiple", 1), "multiple", 1, 1000),
        tuple(_branch(branch) for branch in a_list(data.get("branches", []), "branches", 100)),
    )


def _branch(data: Any) -> FieldBranch:
    data = an_object(data, "a branch", {"field", "old", "new", "child"})
    field, old, new = (coefficients(data.get(key)) for key in ("field", "old", "new"))
    return FieldBranch(field, old, new, an_integer(data.get("child"), "child", -1, MAX_NODES))
