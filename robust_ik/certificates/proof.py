"""Proof: a case split of an arm's singular configurations, as plain values that go to JSON and back."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from robust_ik.certificates.cases import Form, Node


@dataclass(frozen=True)
class Arm:
    """The rational arm that the proof is about.

    Attributes:
        name: The robot's name.
        joints: Joint names.
        rows: Task rows.
        links: The n + 1 constant transforms: three rows of the rotation, then the translation, fractions as text.
        changes: How it differs from the robot it was made from, a sentence each.
        sliding: Indices of the prismatic joints, rising; the others turn about their z.
    """

    name: str
    joints: tuple[str, ...]
    rows: tuple[str, ...]
    links: tuple[tuple[tuple[str, ...], ...], ...]
    changes: tuple[str, ...] = ()
    sliding: tuple[int, ...] = ()


@dataclass(frozen=True)
class Proof:
    """A case split and what came of it.

    Attributes:
        arm: The arm in rational numbers, or None where it is not supported.
        corank: Rank deficiency that is treated: rank ≤ min(rows, joints) − corank.
        link: The link whose frame the minors are written in; 0 for the base.
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
        """One of "proved", "implicit" (closed, but a leaf only repeats the equations), "open" or "unsupported"."""
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
        """Whether a case is a leaf that only repeats the equations: its relations are whole minors, two or more."""
        forms = [node.state.generators[index] for index, _ in node.relations]
        return node.kind == "implicit" or (len(forms) > 1 and all(form in self._whole_minors for form in forms))

    @cached_property
    def _whole_minors(self) -> frozenset[Form]:
        """Relations that are all there is of a minor."""
        splits = (node for node in self.nodes if node.source is not None and node.source.kind == "minor")
        return frozenset(node.factors[0].form for node in splits if len(node.factors) == 1)

    def to_json(self) -> str:
        """The proof as JSON text."""
        from robust_ik.certificates.proof_json import to_json

        return to_json(self)

    @classmethod
    def from_json(cls, text: str) -> Proof:
        """A proof from JSON text.

        Raises:
            CertificateError: It is too long, no JSON, or no proof; nothing of it is run.
        """
        from robust_ik.certificates.proof_json import from_json

        return from_json(text)
