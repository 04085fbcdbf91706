"""The child cases of the factors of a vanishing polynomial."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from flint import fmpq_poly

from robust_ik.certificates.proof.case_tree import Coefficients, ExactPin, FieldBranch, Form, FormFactor, State
from robust_ik.certificates.proof.real_roots import has_real_root
from robust_ik.certificates.prover.factoring import Factored
from robust_ik.certificates.prover.half_angle_forms import HalfAngles, Homogeneous
from robust_ik.certificates.prover.number_fields import Component, Field, adjoin, coefficients, poly


def factors(state: State, half: HalfAngles, found: Factored, node: Callable[[State], int]) -> tuple[FormFactor, ...]:
    """The factors with their children.

    Args:
        state: The parent's conditions.
        half: The forms over its field.
        found: The factors of the vanishing polynomial.
        node: Returns the node of a state, a new one if there is none.
    """
    return tuple(_factor(state, half, factor, int(power), node) for factor, power in found.factors)


def _factor(
    state: State, half: HalfAngles, factor: Homogeneous, power: int, node: Callable[[State], int]
) -> FormFactor:
    form = half.form(factor)
    if len(form.joints) > 1:
        child = replace(state, generators=(*state.generators, form))
        return FormFactor("relation", form, power, node(child))
    joint, minimal = form.joints[0], _univariate(form)
    if form.degrees == (1,):
        return FormFactor("pin", form, power, node(_pinned(state, joint, *_root(minimal))))
    if not has_real_root(coefficients(minimal)):
        return FormFactor("unreal", form, power)
    multiple, components = adjoin(half.field, minimal, half.effort)
    branches = tuple(_branch(state, joint, component, node) for component in components)
    return FormFactor("roots", form, power, multiple=multiple, branches=branches)


def _univariate(form: Form) -> Any:
    values = {powers[0]: poly(value)[0] for powers, value in form.terms}
    return fmpq_poly([values.get(i, 0) for i in range(max(values) + 1)])


def _root(linear: Any) -> tuple[Coefficients, Coefficients]:
    """The point (x : y) at which a + b t vanishes; t = ∞ if b is 0."""
    if linear.degree() == 0:
        return ("0",), ("1",)
    return ("1",), (str(-linear[0] / linear[1]),)


def _pinned(state: State, joint: int, x: Coefficients, y: Coefficients) -> State:
    pins = sorted((*state.pins, ExactPin(joint, x, y)), key=lambda pin: pin.joint)
    return replace(state, pins=tuple(pins))


def _branch(state: State, joint: int, component: Component, node: Callable[[State], int]) -> FieldBranch:
    field, old, new = component.field.modulus, coefficients(component.old), coefficients(component.new)
    if not component.real:
        return FieldBranch(field, old, new, -1)
    pins = tuple(ExactPin(p.joint, moved(p.x, component), moved(p.y, component)) for p in state.pins)
    generators = tuple(
        replace(form, terms=tuple((powers, moved(value, component)) for powers, value in form.terms))
        for form in state.generators
    )
    return FieldBranch(field, old, new, node(_pinned(State(pins, generators, field), joint, ("1",), new)))


def moved(value: Coefficients, component: Component) -> Coefficients:
    """An element of the old field, as an element of the new one."""
    return value if len(value) == 1 else image(value, component.old, component.field)


def image(value: Coefficients, theta: Any, field: Field) -> Coefficients:
    """The element with θ replaced by `theta`."""
    result = fmpq_poly([0])
    for coefficient in reversed(poly(value).coeffs()):
        result = field.reduce(result * theta) + coefficient
    return coefficients(result)
