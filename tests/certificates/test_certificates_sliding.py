"""Certificates of arms with sliding joints: by hand, by floats that know nothing of the proof, and spoiled."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.certificates import Proof, certify, check, leaves
from robust_ik.certificates.certify import certify_exact, exact_from_plain, plain_arm
from robust_ik.certificates.checker.expected_children import RefusedError, check_unreal
from robust_ik.certificates.proof.case_tree import Form, FormFactor
from robust_ik.certificates.proof.joint_relations import shown_length
from robust_ik.certificates.proof.proof_leaves import LeafPlace
from robust_ik.certificates.prover.exact_arm import ExactArm, exact_arm
from robust_ik.certificates.prover.rational_matrices import turn
from tests.cases_mutations import spoiled
from tests.certificates.test_certificates import fill

RIGHT = np.pi / 2
XYZ = ("x", "y", "z")


def turning(a: float = 0.0, d: float = 0.0, alpha: float = 0.0, theta: float = 0.0) -> rik.DHJoint:
    return rik.DHJoint(a=a, d=d, alpha=alpha, theta=theta)


def sliding(a: float = 0.0, d: float = 0.0, alpha: float = 0.0, theta: float = 0.0) -> rik.DHJoint:
    return rik.DHJoint(a=a, d=d, alpha=alpha, theta=theta, kind="prismatic", lower=-2.0, upper=2.0)


WRIST = (turning(alpha=-RIGHT), turning(alpha=RIGHT), turning(d=0.263))
POLAR = (turning(alpha=-RIGHT), turning(d=0.154, alpha=RIGHT), sliding())
ELBOW = (turning(a=0.1, alpha=-RIGHT), turning(a=0.2, alpha=RIGHT), sliding())
TABLES = {
    "scara": ((turning(a=0.4, d=0.3), turning(a=0.3), sliding(), turning(d=0.1)), (*XYZ, "wz")),
    "polar": (POLAR, XYZ),
    "elbow": (ELBOW, XYZ),
    "stanford": ((turning(d=0.412, alpha=-RIGHT), *POLAR[1:], *WRIST), None),
    "offsets": (
        (turning(a=0.1, d=0.412, alpha=-RIGHT), turning(a=0.05, d=0.154, alpha=RIGHT), sliding(), *WRIST),
        None,
    ),
    "cylinder": ((turning(), sliding(alpha=-RIGHT), sliding()), XYZ),
    "gantry": ((sliding(alpha=-RIGHT), sliding(alpha=-RIGHT, theta=-RIGHT), sliding(), *WRIST), None),
    "planar": ((sliding(alpha=RIGHT), turning(a=0.3), turning(a=0.2)), ("x", "z")),
    "planar_turn": ((turning(alpha=-RIGHT), sliding(alpha=RIGHT), turning(a=0.2)), ("x", "y", "wz")),
    "rail": ((sliding(d=0.2, alpha=-RIGHT), turning(d=0.4, alpha=-RIGHT), *POLAR[1:], *WRIST), None),
}
"""Arms and their task rows, all six where none are given."""

BY_HAND = {
    ("scara", 1): {"joint2 = 0°", "joint2 = 180°"},  # det = −0.12 s2
    ("scara", 2): set(),
    ("polar", 1): {"joint2 = 0°", "joint2 = 180°", "joint3 = 0 m"},  # det = d3² s2
    ("polar", 2): {"joint2 = -90° and joint3 = 0 m", "joint2 = 90° and joint3 = 0 m"},
    ("elbow", 1): {"joint3 = 0 m", "−s2 d3 − 0.2 c2 − 0.1 = 0"},  # det = d3 (0.1 + 0.2 c2 + d3 s2)
    ("elbow", 2): {"joint2 = -120° and joint3 = 0 m or joint2 = 120° and joint3 = 0 m"},  # one field, two places
    ("stanford", 1): {"joint2 = 0°", "joint2 = 180°", "joint3 = 0 m", "joint5 = 0°", "joint5 = 180°"},
    ("stanford", 3): set(),
    ("cylinder", 1): {"joint3 = 0 m"},  # det = d3
    ("cylinder", 2): set(),
    ("gantry", 1): {"joint5 = 0°", "joint5 = 180°"},  # the slides span space: the wrist alone
    ("gantry", 2): set(),
    ("planar", 1): {f"joint2 = {a}° and joint3 = {b}°" for a in (0, 180) for b in (0, 180)},  # x: s2 = s23 = 0
    ("planar_turn", 1): {"joint2 = 0 m"},  # det = −d2
}


@cache
def robot(name: str) -> rik.Robot:
    joints, rows = TABLES[name]
    return rik.Robot.from_dh(rik.DHTable(joints, "standard", **({} if rows is None else {"rows": rows})))


@cache
def proof(name: str, corank: int) -> Proof:
    return certify(robot(name), corank, thorough=False, time_limit=3600.0)


def places(name: str, corank: int) -> list[LeafPlace]:
    return [place for leaf in leaves(proof(name, corank)) for place in leaf.places]


# ---------------------------------------------------------------------------------------------------- what is proved
@pytest.mark.parametrize("name, corank", BY_HAND)
def test_the_leaves_are_those_found_by_hand(name, corank):
    found = proof(name, corank)
    verdict = check(found, arm=plain_arm(exact_arm(robot(name))))
    assert verdict.accepted, verdict.reason
    assert {str(leaf) for leaf in leaves(found)} == BY_HAND[name, corank]


def test_the_dimensions_count_lengths_like_angles():
    assert [place.dimension for place in places("stanford", 1)] == [5] * 5
    assert sorted(place.dimension for place in places("stanford", 2)) == [3] * 12 + [4] * 2
    assert all(leaf.is_real for leaf in leaves(proof("offsets", 1)))


def test_a_pinned_length_is_in_metres():
    place = next(place for place in places("polar", 1) if place.lengths)
    assert (place.angles, place.lengths) == ({}, {2: 0.0})
    np.testing.assert_allclose(place.residual([[1.0, 2.0, 0.25], [3.0, 4.0, 0.0]]), [0.25, 0.0], atol=0)


@pytest.mark.parametrize(
    "metres, text", [(0.25, "0.25 m"), (0.0, "0 m"), (-0.0, "0 m"), (-0.1, "−0.1 m"), (2**0.5, "1.414213562 m")]
)
def test_lengths_are_written_without_needless_digits(metres, text):
    assert shown_length(metres) == text


def test_a_length_may_be_algebraic():
    """A planar chain of five joints whose second slides: one leaf has it at an irrational length."""
    quarters = {0: (1, 0), 1: (0, 1), 3: (0, -1)}
    rows = [(1, 0, 0, 0), (1, 2, 0, 0), (0, 1, 1, 3), (3, 1, 0, 2), (1, 3, 2, 0), (1, 0, 0, 2)]
    links = tuple((turn(0, *map(Fraction, quarters[k])), tuple(Fraction(a, 10) for a in offset)) for k, *offset in rows)
    names = tuple(f"joint{i}" for i in range(1, 6))
    arm = ExactArm("tilted", names, links, ("x", "y"), sliding=frozenset({1}))
    found = certify_exact(arm, 1, thorough=False)
    assert check(found).accepted
    lengths = {round(length, 9) for leaf in leaves(found) for place in leaf.places for length in place.lengths.values()}
    assert any(abs(length * 10 - round(length * 10)) > 1e-3 for length in lengths)


def test_moving_the_joint_zeros_moves_the_leaves():
    arm = exact_arm(robot("polar"))
    moved = certify_exact(arm.shifted((Fraction(1, 3), Fraction(0), Fraction(1, 4))), 1)
    assert check(moved).accepted
    assert "joint3 = −0.25 m" in {str(leaf) for leaf in leaves(moved)}


def test_a_factor_without_real_roots_leads_nowhere_for_a_length_too():
    square = Form((2,), (2,), (((0,), ("1",)), ((1,), ("1",)), ((2,), ("1",))))
    check_unreal(FormFactor("unreal", square, 1))
    with pytest.raises(RefusedError, match="real root"):
        check_unreal(FormFactor("unreal", replace(square, terms=(((0,), ("-1",)), *square.terms[1:])), 1))


def test_arms_with_slides_survive_json():
    for name in ("elbow", "stanford"):
        assert Proof.from_json(proof(name, 2).to_json()) == proof(name, 2)


@pytest.mark.parametrize("slides", [[2, 2], [2, 1], [3], [-1], ["2"], 2, None])
def test_sliding_joints_that_are_none_are_refused(slides):
    data = json.loads(proof("polar", 1).to_json())
    data["arm"]["sliding"] = slides
    verdict = check(json.dumps(data))
    assert not verdict.accepted
    assert verdict.reason.startswith("refused: ")


# ---------------------------------------------------------------------------------------------------- spoiled
@pytest.mark.parametrize("name, corank", [(name, k) for name in TABLES for k in (1, 2) if k <= robot(name).n - 1])
def test_the_checker_refuses_spoiled_proofs(name, corank):
    counts: dict[str, int] = {}
    for what, other in spoiled(proof(name, corank)):
        kind = what.split(" in case")[0]
        counts[kind] = counts.get(kind, 0) + 1
        if counts[kind] > 3:
            continue
        verdict = check(other, rounds=1)
        if verdict.accepted:
            assert other.arm != proof(name, corank).arm, what
            assert same_theorem(other), what
        assert not check(other, arm=proof(name, corank).arm, rounds=1).accepted, what
    assert "a leaf at infinity" in counts


def same_theorem(found: Proof) -> bool:
    """Whether a proof of an arm that was altered says what is proved of that arm from scratch."""
    fresh = certify_exact(exact_from_plain(found.arm), found.corank)
    return {node.state for node in fresh.leaves} == {node.state for node in found.leaves}


# ---------------------------------------------------------------------------------------------------- floats
CLOSED = [(name, k) for name in TABLES for k in (1, 2) if k < robot(name).n]


@pytest.mark.parametrize("name, corank", CLOSED)
def test_fills_of_every_leaf_are_singular_to_pinocchio_and_beside_it_they_are_not(name, corank):
    rng, arm = np.random.default_rng(1), robot(name)
    rank = min(len(arm.rows), arm.n)
    for place in places(name, corank):
        found = [q for q in (fill(place, rng) for _ in range(10)) if q is not None][:3]
        assert found, f"no real point of {place}"
        for q in found:
            assert place.residual(q) < 1e-12
            assert np.linalg.svd(arm.jacobian(q), compute_uv=False)[rank - corank] < 1e-10
            for joint in (*place.angles, *place.lengths):
                moved = q + 0.3 * (np.arange(arm.n) == joint)
                if min(other.residual(moved) for other in places(name, corank)) > 1e-3:
                    assert np.linalg.svd(arm.jacobian(moved), compute_uv=False)[rank - corank] > 1e-7


@pytest.mark.parametrize("name", TABLES)
def test_what_the_finder_finds_lies_on_the_leaves(name):
    atlas = rik.find_singularities(robot(name), starts=150)
    assert len(atlas)
    for corank in range(1, atlas.highest + 1):
        every = places(name, corank)
        found = [q for stratum in atlas if stratum.corank >= corank for q in stratum.samples]
        distance = np.array([place.residual(np.array(found)) for place in every])
        assert distance.min(axis=0).max() < 1e-5
        hit = distance.argmin(axis=0)[0]
        assert np.delete(distance, hit, axis=0).min(axis=0, initial=1.0).max() > 1e-3  # the test can fail
