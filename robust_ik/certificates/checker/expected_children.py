"""The child that each factor must have, by exact arithmetic with fractions: the checker's version of `child_cases`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from robust_ik.certificates.checker.root_counting import count_real_roots
from robust_ik.certificates.proof.case_tree import Coefficients, ExactPin, FieldBranch, Form, FormFactor, State
from robust_ik.certificates.proof.counted_steps import spend
from robust_ik.certificates.proof.field_elements import reduced


class RefusedError(Exception):
    """A proof that does not hold; the message says where."""


def require(condition: object, why: str) -> None:
    """Refuses a proof unless a condition holds."""
    if not condition:
        raise RefusedError(why)


def univariate(form: Form) -> list[Fraction]:
    """A form in one joint with rational coefficients, as a polynomial in t = y/x without a root at t = ∞."""
    require(len(form.joints) == 1, "a factor of one joint involves several, or none")
    values = [Fraction(0)] * (form.degrees[0] + 1)
    for powers, coefficient in form.terms:
        require(len(coefficient) == 1, "a factor of one joint is not rational")
        values[powers[0]] += Fraction(coefficient[0])
    return values


def pin_child(state: State, factor: FormFactor) -> State:
    """The parent with the joint fixed at the only root of the factor."""
    require(factor.form.degrees == (1,), "a pin is not of degree one")
    low, high = univariate(factor.form)
    require(low or high, "a pin at a factor that is zero")
    x, y = (("0",), ("1",)) if not high else (("1",), (str(-low / high),))
    return _with_pin(state, ExactPin(factor.form.joints[0], x, y))


def relation_child(state: State, factor: FormFactor) -> State:
    """The parent with the factor among its generators."""
    return replace(state, generators=(*state.generators, factor.form))


def branch_child(state: State, joint: int, branch: FieldBranch) -> State:
    """The parent in the field of a branch, with the joint fixed at its root."""
    pins = tuple(ExactPin(p.joint, moved(p.x, branch), moved(p.y, branch)) for p in state.pins)
    generators = tuple(
        replace(form, terms=tuple((powers, moved(value, branch)) for powers, value in form.terms))
        for form in state.generators
    )
    return _with_pin(State(pins, generators, branch.field), ExactPin(joint, ("1",), branch.new))


def check_branch(state: State, factor: FormFactor, branch: FieldBranch) -> None:
    """Checks that a branch is in both fields: θ and t are roots, ζ = θ + λ t; without child it has no real place."""
    modulus = [Fraction(value) for value in branch.field]
    require(len(modulus) >= 2 and modulus[-1] == 1, "a field is not given by a monic polynomial")
    old, new = ([Fraction(value) for value in values] for values in (branch.old, branch.new))
    require(max(len(old), len(new)) < len(modulus) or len(modulus) == 2, "an element of a field is not reduced")
    minimal = tuple(str(value) for value in univariate(factor.form))
    require(not any(_image(state.field, old, modulus)), "θ of a branch is no root of its polynomial")
    require(not any(_image(minimal, new, modulus)), "a branch is at no root of its factor")
    size = max(len(old), len(new), 2)
    total = [_at(old, i) + factor.multiple * _at(new, i) - (i == 1) for i in range(size)]
    require(not any(reduced(total, modulus)), "the new field's element is not θ + λ t")
    require(branch.child >= 0 or not count_real_roots(branch.field), "a branch with a real place was dropped")


def check_unreal(factor: FormFactor) -> None:
    """Checks that a factor has no real root, t = ∞ included."""
    values = univariate(factor.form)
    require(values[-1] and not count_real_roots(values), "a factor with a real root was dropped")


def moved(value: Coefficients, branch: FieldBranch) -> Coefficients:
    """An element of the parent's field, as an element of the branch's field."""
    return value if len(value) == 1 else image(value, branch.old, branch.field)


def image(value: Coefficients, theta: Coefficients, field: Coefficients) -> Coefficients:
    """The element with θ replaced by another element."""
    if len(value) == 1:  # θ does not occur
        return (str(Fraction(value[0])),)
    result = _image(value, [Fraction(a) for a in theta], [Fraction(a) for a in field])
    while len(result) > 1 and not result[-1]:
        result.pop()
    return tuple(str(a) for a in result) or ("0",)


def _with_pin(state: State, pin: ExactPin) -> State:
    require(pin.joint not in state.pinned, "a joint is pinned twice")
    return replace(state, pins=tuple(sorted((*state.pins, pin), key=lambda each: each.joint)))


def _at(values: Sequence[Fraction], index: int) -> Fraction:
    return values[index] if index < len(values) else Fraction(0)


def _image(value: Coefficients, theta: list[Fraction], modulus: list[Fraction]) -> list[Fraction]:
    result = [Fraction(0)]
    for coefficient in reversed(value):
        spend(30 * len(result) * len(theta))
        product = [Fraction(0)] * (len(result) + len(theta) - 1)
        for i, a in enumerate(result):
            for j, b in enumerate(theta):
                product[i + j] += a * b
        product[0] += Fraction(coefficient)
        result = reduced(product, modulus)
    return result
