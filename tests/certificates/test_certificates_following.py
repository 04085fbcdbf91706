"""Proofs about arms in which joints follow others: palletisers, telescopes, turns that are doubled."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import least_squares

import robust_ik as rik
from robust_ik.certificates import Proof, certify, check, leaves
from robust_ik.certificates.certify import exact_from_plain, plain_arm
from robust_ik.certificates.proof import float_jacobian
from robust_ik.certificates.prover import UnsupportedError, exact_arm
from robust_ik.description.urdf import parse_urdf
from robust_ik.singularities.atlas.evidence import Completeness

Y, Z = "0 1 0", "0 0 1"
RIGHT = float(np.pi / 2)
SLIDE, TURN = "prismatic", "revolute"


def follows(source, factor, offset=0.0):
    return f'<mimic joint="j{source}" multiplier="{factor!r}" offset="{offset!r}"/>'


def arm(*lines):
    """A robot from lines of (origin, axis), a kind if it slides, and what it follows."""
    links = "".join(f'<link name="l{i}"/>' for i in range(len(lines) + 1))
    joints = []
    for i, (origin, axis, *rest) in enumerate(lines):
        kind = SLIDE if SLIDE in rest else TURN
        mimic = next((each for each in rest if each != SLIDE), "")
        joints.append(
            f'<joint name="j{i}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/><origin xyz="{origin}"/>'
            f'<axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="1" effort="1"/>{mimic}</joint>'
        )
    return rik.Robot.from_description(parse_urdf(f'<robot name="r">{links}{"".join(joints)}</robot>'), f"l{len(lines)}")


ARMS = {
    "palletiser": lambda: arm(("0 0 0.5", Z), ("0.15 0 0.2", Y), ("0 0 0.8", Y, follows(1, -1.0)), ("0 0 0", Y),
                              ("0.7 0 0", Y, follows(3, -1.0)), ("0.1 0 -0.1", Z)),
    "lift": lambda: arm(("0 0 0.5", Z), ("0.15 0 0.2", Z, SLIDE), ("0 0 0.3", Z, SLIDE, follows(1, 0.5, 0.1)),
                        ("0.3 0 0", Y), ("0.1 0 0.2", Y, follows(3, -1.0, RIGHT)), ("0.2 0.1 0", Y)),
    "doubled": lambda: arm(("0 0 0.5", Z), ("0.15 0 0.2", Y), ("0 0 0.4", Y, follows(1, 2.0, RIGHT)), ("0.3 0 0", Z)),
    "scissors": lambda: arm(("0 0 0.2", Y), ("0.3 0 0", Y, follows(0, -2.0)), ("0.3 0 0", Y, follows(0, 2.0)),
                            ("0.1 0 0.1", Z), ("0 0.2 0", Y)),
    "leader last": lambda: arm(("0 0 0.2", Z), ("0.2 0 0", Y, follows(3, -1.0)), ("0.3 0 0", Z), ("0.1 0 0.3", Y)),
}  # fmt: skip


@cache
def case(name):
    robot = ARMS[name]()
    return robot, {corank: certify(robot, corank, time_limit=20) for corank in (1, 2)}


@pytest.mark.parametrize("name", ARMS)
def test_the_exact_arm_moves_as_the_robot_does(name):
    robot, _ = case(name)
    exact = exact_arm(robot)
    plain = plain_arm(exact)
    values = np.random.default_rng(0).uniform(-2, 2, (5, robot.n))
    for each in values:
        expected = robot.jacobian(robot.configuration(each), rows=plain.rows)
        np.testing.assert_allclose(float_jacobian(plain, each), expected, atol=1e-9)
    s = np.linalg.svd(robot.jacobian(robot.configuration(values)), compute_uv=False)
    assert exact.rank == (s > 1e-6).sum(axis=1).max()
    assert exact_from_plain(plain).motions == exact.motions


@pytest.mark.parametrize("name", ARMS)
def test_proofs_are_accepted_and_their_leaves_singular(name):
    robot, proofs = case(name)
    for corank, proof in proofs.items():
        assert proof.status in ("proved", "implicit")
        verdict = check(proof.to_json())
        assert verdict.accepted or verdict.implicit, verdict.reason
        assert Proof.from_json(proof.to_json()) == proof
        rng = np.random.default_rng(corank)
        for leaf in leaves(proof):
            for place in leaf.places:
                fixed = place.angles | place.lengths
                if place.relations:
                    continue
                values = rng.uniform(-3, 3, (5, robot.n))
                values[:, list(fixed)] = list(fixed.values())
                s = np.linalg.svd(robot.jacobian(robot.configuration(values)), compute_uv=False)
                assert s[:, proof.arm.rank - corank].max() < 1e-9


@pytest.mark.parametrize("name", ["palletiser", "lift", "scissors", "leader last"])
def test_what_another_search_finds_is_on_a_leaf(name):
    """Singular configurations by `scipy.optimize.least_squares` on J(q) w = 0, |w| = 1, with Pinocchio's J."""
    robot, proofs = case(name)
    rng, met = np.random.default_rng(0), 0
    places = [place for leaf in leaves(proofs[1]) for place in leaf.places]

    def errors(x):
        J = robot.jacobian(robot.configuration(x[: robot.n]))
        return np.r_[J @ x[robot.n :], x[robot.n :] @ x[robot.n :] - 1]

    assert proofs[1].arm.rank == robot.n
    for _ in range(40):
        ends = least_squares(errors, rng.uniform(-2, 2, 2 * robot.n), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=80)
        if np.abs(ends.fun).max() < 1e-9:
            met += 1
            assert min(float(place.residual(ends.x[: robot.n])) for place in places) < 1e-4
    assert met == 0 if not places else met > 5


def test_a_palletiser_is_certified_with_its_elbow_and_its_wrist_over_the_first_axis(tmp_path):
    atlas = rik.find_singularities(ARMS["palletiser"](), starts=300)
    words = [row.words for row in atlas.of_corank(1)]
    assert "q2 − q3 = ±π/2" in words
    assert "0.3125 + s2 + 0.875 c3 = 0" in words
    assert {each.status for each in atlas.evidence} == {Completeness.CERTIFIED}
    back = rik.SingularityAtlas.load(atlas.save(tmp_path / "atlas.json"))
    assert back.markdown() == atlas.markdown()
    assert {each.status for each in back.evidence} == {Completeness.CERTIFIED}


@pytest.mark.parametrize("factor", [0.5, -3.0, 1.01, 2.0000001])
def test_other_rates_of_turns_are_not_supported(factor):
    robot = arm(("0 0 0.5", Z), ("0.15 0 0.2", Y), ("0 0 0.8", Y, follows(1, factor)))
    with pytest.raises(UnsupportedError, match=f"joint 'j2' follows 'j1' {factor:g}-fold: not supported"):
        exact_arm(robot)


def test_a_turn_that_follows_a_slide_is_not_supported():
    with pytest.raises(UnsupportedError, match="not supported"):
        exact_arm(arm(("0 0 0.5", Z, SLIDE), ("0.15 0 0.2", Y, follows(0, 1.0)), ("0 0 0.8", Y)))


# ------------------------------------------------------------------------------------------------ what is refused
@pytest.mark.parametrize(
    ("place", "motion"),
    [(2, [1, "1"]), (2, [1, "-2"]), (4, [1, "-1"]), (1, [2, "1"]), (2, [1, "3"]), (2, [1, "-1/2"]), (2, [9, "1"]),
     (2, [1]), (2, [1, "1", 1]), (2, None), (2, [1, -1]), (2, [True, "-1"]), (2, [1, "0"]), (2, [1, "-01"])],
)  # fmt: skip
def test_a_proof_with_other_motions_is_refused(place, motion):
    _, proofs = case("palletiser")
    data = json.loads(proofs[1].to_json())
    assert data["arm"]["motions"] == [[0, "1"], [1, "1"], [1, "-1"], [2, "1"], [2, "-1"], [3, "1"]]
    data["arm"]["motions"][place] = motion
    verdict = check(json.dumps(data))
    assert not verdict.accepted
    assert not verdict.implicit
    assert verdict.reason.startswith("refused")


def test_a_proof_with_too_few_motions_or_of_another_arm_is_refused():
    _, proofs = case("palletiser")
    data = json.loads(proofs[1].to_json())
    del data["arm"]["motions"][4]
    assert "5 motions need 6 links, got 7" in check(json.dumps(data)).reason
    del data["arm"]["motions"]
    assert "what follows what" in check(json.dumps(data)).reason
    data["version"] = 2
    del data["arm"]["rank"]
    assert "4 motions need 5 links, got 7" in check(json.dumps(data)).reason
    own = proofs[1].arm
    other = replace(own, motions=tuple((joint, factor.removeprefix("-")) for joint, factor in own.motions))
    assert check(proofs[1], arm=other).reason == "refused: it is about another arm"


def test_coranks_and_parts_of_proofs_are_not_taken_for_others():
    _, proofs = case("palletiser")
    proof = proofs[1]
    for index, node in enumerate(proof.nodes):
        if node.kind == "split":
            fewer = replace(node, factors=node.factors[1:])
            spoilt = replace(proof, nodes=(*proof.nodes[:index], fewer, *proof.nodes[index + 1 :]))
            assert not check(spoilt).accepted
    assert not check(replace(proof, corank=2)).accepted
