"""The parts of a proof as plain values: forms, conditions, factors, cases.

Angles are points (x : y) = (cos q/2 : sin q/2), so that q = π is a point like any other. A sliding joint at length d is
at (1 : d): its x is 1, and a point with x = 0 is no configuration. A node is a set of conditions: pins (fixed joints),
generators (forms that vanish) and the number field of the pins. It states that its real singular configurations lie in
its children, or that it is a leaf: singular throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

Coefficients = tuple[str, ...]
"""An element of the field: coefficients of a polynomial in θ, lowest first, each like "3/2"."""
RATIONAL: Coefficients = ("0", "1")
"""The field ℚ, whose modulus is θ."""


@dataclass(frozen=True)
class Form:
    """A polynomial, homogeneous in every joint's (x : y): Σ coefficient Π x^(degree − power) y^power.

    Attributes:
        joints: Indices of the joints it involves, ascending.
        degrees: Its formal degree in each joint; the difference to the largest power is the multiplicity of q = π. It
            has no meaning for a sliding joint, whose x is 1.
        terms: Powers of the joints' y, and the coefficient.
    """

    joints: tuple[int, ...]
    degrees: tuple[int, ...]
    terms: tuple[tuple[tuple[int, ...], Coefficients], ...]


@dataclass(frozen=True)
class ExactPin:
    """A joint that is fixed at (x : y).

    Attributes:
        joint: Its index.
        x: cos q/2 up to a common factor; 1 for a sliding joint.
        y: sin q/2 up to a common factor; the length in metres for a sliding joint.
    """

    joint: int
    x: Coefficients
    y: Coefficients


@dataclass(frozen=True)
class State:
    """The conditions of a node.

    Attributes:
        pins: Fixed joints, ascending.
        generators: Forms that vanish.
        field: Coefficients of the polynomial that θ is a root of; (0, 1) for ℚ.
    """

    pins: tuple[ExactPin, ...] = ()
    generators: tuple[Form, ...] = ()
    field: Coefficients = RATIONAL

    @property
    def pinned(self) -> dict[int, ExactPin]:
        """Pins by joint."""
        return {pin.joint: pin for pin in self.pins}


@dataclass(frozen=True)
class Source:
    """A polynomial that vanishes at every singular configuration of a node.

    Attributes:
        kind: "minor", "generator" or "resultant".
        rows: Of a minor: weights of the Jacobian's rows, one tuple for each row of the minor.
        columns: Of a minor: its joints.
        first: Of a generator: its index. Of a resultant: the index of the first generator.
        second: Of a resultant: the index of the second generator.
        joint: Of a resultant: the joint that is eliminated.
    """

    kind: str
    rows: tuple[tuple[Coefficients, ...], ...] = ()
    columns: tuple[int, ...] = ()
    first: int = -1
    second: int = -1
    joint: int = -1


@dataclass(frozen=True)
class FieldBranch:
    """A root of a factor in one joint, over a number field, with the new field that contains it.

    Attributes:
        field: The new field, of ζ = θ + λ t.
        old: θ in it.
        new: t = y/x of the joint in it.
        child: The child node, or −1 if the field has no real place.
    """

    field: Coefficients
    old: Coefficients
    new: Coefficients
    child: int


@dataclass(frozen=True)
class FormFactor:
    """A factor of a node's source, with the child where it vanishes.

    Attributes:
        kind: "pin" (of degree one in one joint), "relation", "roots" (of one joint, adjoined to the field) or
            "unreal" (of one joint, without real root).
        form: The factor.
        power: Its multiplicity.
        child: The node with this condition added; −1 for "roots" and "unreal".
        multiple: λ of "roots".
        branches: The components of "roots".
    """

    kind: str
    form: Form
    power: int
    child: int = -1
    multiple: int = 1
    branches: tuple[FieldBranch, ...] = ()


@dataclass(frozen=True)
class Node:
    """A case.

    Attributes:
        state: Its conditions.
        kind: "split", "contradiction" (no configuration), "leaf", "implicit" (a leaf that repeats the equations),
            "subsumed" (inside a leaf) or "open".
        source: The polynomial that was factored, for a split or a contradiction.
        norm: Whether the norm over ℚ of the source was factored.
        constant: The constant in front of the factors.
        degrees: Formal degrees of the source in the turning joints that are not pinned.
        factors: The factors, each with its child.
        relations: Of a leaf: generators that describe it (with the pins inserted), each with the joint for which it is
            solved, which the later ones do not involve.
        leaf: The leaf in which a subsumed node lies.
        image: θ of that leaf's field, in this node's field.
        reason: Why a node is open.
    """

    state: State
    kind: str = "open"
    source: Source | None = None
    norm: bool = False
    constant: Coefficients = ("1",)
    degrees: tuple[tuple[int, int], ...] = ()
    factors: tuple[FormFactor, ...] = ()
    relations: tuple[tuple[int, int], ...] = ()
    leaf: int = -1
    image: Coefficients = ("0",)
    reason: str = ""
