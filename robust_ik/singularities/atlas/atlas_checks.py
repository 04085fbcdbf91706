"""Checks an atlas read from a file against its own geometry: nothing that can be checked is taken from the file."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.description.joint_tree import FREEDOM
from robust_ik.errors import LoadError
from robust_ik.kinematics.twist_rows import DEFICIENT, checked_rows
from robust_ik.singularities.atlas.atlas_record import AtlasRecord, Settings
from robust_ik.singularities.atlas.evidence import Evidence
from robust_ik.singularities.conditions.condition_words import condition, equation
from robust_ik.singularities.conditions.relation_bases import DEGREES
from robust_ik.singularities.conditions.robot_facts import SAME, RobotFacts, jacobians_apart
from robust_ik.singularities.families.leaf import is_singular
from robust_ik.singularities.find.find_points import Method
from robust_ik.singularities.geometry.screw_chain import largest_rank

if TYPE_CHECKING:
    from robust_ik.singularities.conditions.angle_sums import Angle
    from robust_ik.singularities.conditions.trig_relations import Relation
    from robust_ik.singularities.families.stratum import Stratum
    from robust_ik.singularities.geometry.screw_chain import ScrewChain

KINDS: dict[object, tuple[type, ...]] = {
    "int": (int,), "int | None": (int, type(None)), "float": (int, float), "bool": (bool,), "str": (str,),
}  # fmt: skip
UNBOUNDED = ("margin", "lower", "upper")
"""Values that may be infinite."""
LARGEST = 1e18
"""Largest length or joint value: as large as a limit in a URDF may be, and far below overflow."""


def reread(atlas: AtlasRecord) -> AtlasRecord:
    """The atlas, checked, with its words made anew from its conditions.

    Raises:
        LoadError: A value is not of its type or size, the proofs are about another arm than the rows, or a row is not
            singular.
    """
    _check_robot(atlas.robot)
    records: list[Settings | Evidence | Stratum] = [atlas.settings, *atlas.evidence, *atlas.strata, *atlas.nearly]
    for record in records:
        _check_values(record)
    if atlas.settings.method not in get_args(Method):
        raise LoadError(f"there is no method {atlas.settings.method!r}")
    looked_for = [each.corank for each in atlas.evidence]
    if len(set(looked_for)) < len(looked_for):
        raise LoadError("a corank is judged twice")
    for row in atlas.strata:
        if row.corank not in looked_for:
            raise LoadError(f"a row is of corank {row.corank}, of which nothing is said")
    even = atlas.robot.measured_in(atlas.robot.units)
    for chain, rows in ((even.chain, atlas.strata), (even.near, atlas.nearly)):
        if chain is None and rows:
            raise LoadError("it has rows of nearly the same arm, but not that arm")
        for row in rows:
            _check_angles(even.chain, row)
            _check_row(chain or even.chain, row.measured_in(even.units, even.symbols))
    strata, nearly = (tuple(_in_words(atlas.robot, row) for row in rows) for rows in (atlas.strata, atlas.nearly))
    return replace(atlas, strata=strata, nearly=nearly)


def _check_values(record: Settings | Evidence | Stratum) -> None:
    """Checks that numbers and words have their types, counts are not negative, and only UNBOUNDED ones infinite."""
    for each in fields(record):
        value, kinds = getattr(record, each.name), KINDS.get(each.type)
        if kinds is None:
            continue
        fits = isinstance(value, kinds) and (not isinstance(value, bool) or bool in kinds)
        if fits and isinstance(value, (int, float)):
            fits = value >= 0 if int in kinds and float not in kinds else not math.isnan(value)
            fits = fits and (each.name in UNBOUNDED or math.isfinite(value))
        if not fits:
            raise LoadError(f"{each.name} cannot be {str(value)[:40]!r}")


def _check_robot(facts: RobotFacts) -> None:
    """Checks that names are text, arrays have a number for each joint, and the exact arm is the analysed one."""
    names = (facts.name, facts.tip, facts.inexact, *facts.chain.joint_names, *facts.floating, *facts.symbols)
    names = (*names, *facts.changes, *facts.near_changes)
    if not all(isinstance(name, str) for name in names):
        raise LoadError("a name is no text")
    if not all(isinstance(value, float) and math.isfinite(value) for value in facts.symbols.values()):
        raise LoadError("a length is no number")
    chains = (facts.chain, facts.given) if facts.near is None else (facts.chain, facts.given, facts.near)
    for chain in chains:
        _check_chain(chain)
        if _kind(chain) != _kind(facts.chain):
            raise LoadError("the geometry that was given is of other joints than the one that was analysed")
    scale: object = facts.length_scale
    if isinstance(scale, bool) or not isinstance(scale, (int, float)) or not 0 < scale <= LARGEST:
        raise LoadError(f"length_scale cannot be {str(scale)[:40]!r}")
    _check_rank(facts)
    if not isinstance(facts.snapped, bool):
        raise LoadError(f"snapped cannot be {str(facts.snapped)[:40]!r}")
    n = facts.chain.n
    if not (facts.lower.shape == facts.upper.shape == (n,) and len(facts.continuous) == n):
        raise LoadError(f"limits are not of {n} joints")
    known = set(facts.floating) <= set(facts.chain.joint_names)
    if facts.floating and not (known and len(set(facts.floating)) == len(facts.floating) == FREEDOM):
        raise LoadError(f"its floating joint cannot be {', '.join(facts.floating)[:200]}")
    if any((facts.chain.joint_names, facts.chain.rows) != (each.joint_names, each.rows) for each in chains):
        raise LoadError("the geometry that was given is of other joints or rows than the one that was analysed")
    if facts.exact is None:
        return
    same = (facts.exact.joints, facts.exact.rows) == (facts.chain.joint_names, facts.chain.rows)
    if not same or jacobians_apart(facts.chain, facts.exact) > SAME:
        raise LoadError("its proofs are about another arm than its rows")


def _kind(chain: ScrewChain) -> object:
    """What chains of the same joints share: which slide, what follows what, periods, unit of length, largest rank."""
    return chain.sliding, chain.slides, chain.mixing.tolist(), chain.period.tolist(), chain.length_scale, chain.rank


def _check_rank(facts: RobotFacts) -> None:
    """Checks that the arm has the rank of which its coranks are what is missing, and no larger one.

    Where rows were left out, it has full rank in the others.
    """
    chain, rank = facts.chain, facts.chain.rank
    if rank is not None and (isinstance(rank, bool) or not isinstance(rank, int)):
        raise LoadError(f"rank cannot be {str(rank)[:40]!r}")
    most, least = (largest_rank(chain, DEFICIENT * (1 + sign * SAME)) for sign in (-1, 1))
    if not least <= chain.full_rank <= most:
        raise LoadError(f"the rank of its arm is {least} nearly everywhere, not {chain.full_rank}")


def _check_chain(chain: ScrewChain) -> None:
    checked_rows(chain.rows)
    n, c = chain.n, len(chain.sliding)
    shapes = {
        "rotations": (c, 3, 3), "offsets": (c, 3), "tip": (3,), "mixing": (c, n),
        "lower": (n,), "upper": (n,), "period": (n,),
    }  # fmt: skip
    for name, shape in shapes.items():
        array = getattr(chain, name)
        if array.shape != shape or not (name == "period" or _usual(array)):
            raise LoadError(f"{name} must be {' by '.join(map(str, shape))} finite numbers of at most {LARGEST:g}")
    if len(chain.slides) != n or not all(isinstance(each, bool) for each in (*chain.slides, *chain.sliding)):
        raise LoadError("which joints slide is not said of every joint")
    turns = chain.period[np.isfinite(chain.period)]
    if not np.array_equal(turns, np.full(len(turns), 2 * np.pi)):
        raise LoadError("a joint comes back to the same pose after another angle than a whole turn")
    if not (np.isfinite(chain.length_scale) and chain.length_scale > 0):
        raise LoadError(f"length_scale cannot be {chain.length_scale!r}")


def _check_angles(chain: ScrewChain, row: Stratum) -> None:
    """Checks that its conditions are about the chain's joints."""
    for angle in (*(each.angle for each in row.conditions), *(a for each in row.relations for a in each.angles)):
        _check_angle(chain, angle)
    for relation in row.relations:
        _check_relation(relation)


def _check_row(chain: ScrewChain, row: Stratum) -> None:
    """Checks that its conditions leave its dimension, and its members are singular."""
    bound = {joint for each in row.conditions for joint in each.angle.joints} | set(row.curve)
    bound |= {joint for each in row.relations for joint in each.joints}
    if sorted((*row.free, *bound)) != list(range(chain.n)):
        raise LoadError(f"the joints of a row of corank {row.corank} are not the robot's")
    if any(len(values) != len(row.conditions) for values in row.inside):
        raise LoadError(f"a row of corank {row.corank} has combinations of values of other conditions")
    left = chain.n - len(row.conditions) - len(row.relations)
    if row.samples.shape[1:] != (chain.n,) or not (row.dimension < left if row.curve else row.dimension == left):
        raise LoadError(f"a row of corank {row.corank} has not the dimension {row.dimension}")
    if not (_usual(row.samples) and all(_usual(each.values) for each in row.conditions)):
        raise LoadError(f"joint values of a row of corank {row.corank} must be finite numbers of at most {LARGEST:g}")
    rng = np.random.default_rng(0)
    with np.errstate(over="ignore", invalid="ignore"):  # of relations that are not valid
        members = np.concatenate([row.samples, *(leaf.filled(chain, rng) for leaf in row.leaves)])
    if not (_usual(members) and is_singular(chain, members, row.corank).all()):
        raise LoadError(f"members of a row of corank {row.corank} are not singular")


def _usual(values: ArrayLike) -> bool:
    """Whether all values are finite and none is larger than LARGEST."""
    return bool((np.abs(np.asarray(values, dtype=float)) <= LARGEST).all())


def _check_angle(chain: ScrewChain, angle: Angle) -> None:
    joints: tuple[Any, ...] = angle.joints
    good = joints and sorted(set(joints)) == list(joints) and joints[0] >= 0 and joints[-1] < chain.n
    if not good or len(angle.signs) != len(joints) or not set(angle.signs) <= {1, -1}:
        raise LoadError(f"an angle cannot be of joints {joints} with signs {angle.signs}")
    if angle.period != chain.period[joints[0]]:
        raise LoadError("an angle comes back to the same pose after another value than its joint")


def _check_relation(relation: Relation) -> None:
    factors = [factor for term in relation.terms for factor in term]
    known = all(each.kind in ("cos", "sin", "power") and 0 < each.order <= max(DEGREES) for each in factors)
    sizes = np.abs(relation.coefficients)
    if not known or sizes.shape != (len(relation.terms),) or not (0 < sizes.max() < np.inf):
        raise LoadError("a relation is no sum of products with coefficients")


def _in_words(facts: RobotFacts, row: Stratum) -> Stratum:
    """The row with words made from its conditions; the words of the file are ignored."""
    conditions = (replace(c, words=condition(c.angle, c.values, facts.symbols)) for c in row.conditions)
    equations = tuple(equation(relation, facts.symbols) for relation in row.relations)
    return replace(row, conditions=tuple(conditions), equations=equations)
