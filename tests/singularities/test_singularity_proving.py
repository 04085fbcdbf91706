"""What proofs say of an atlas: certified only where a checked proof and the list of random starts agree."""

import json
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.certificates import Certificate, Proof, Verdict, leaves
from robust_ik.certificates.proof.leaf_points import members
from robust_ik.description.urdf.urdf_reader import parse_urdf
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.atlas import proof_evidence
from robust_ik.singularities.atlas.atlas import SingularityAtlas
from robust_ik.singularities.atlas.corank_search import judged
from robust_ik.singularities.atlas.evidence import Completeness
from robust_ik.singularities.atlas.search_state import state_of

CERTIFIED = ("pa10", "panda", "puma560", "ur5", "duleba_3r", "planar_3r", "xarm7", "talos_arm", "kinova")


@cache
def atlas_of(name):
    return rik.find_singularities(rik.load(name), starts=300)


def statuses(atlas):
    return [each.status for each in judged(state_of(atlas))]


@pytest.mark.parametrize("name", CERTIFIED)
def test_every_corank_is_certified_up_to_the_first_that_cannot_be(name):
    atlas = atlas_of(name)
    assert {each.status for each in atlas.evidence} == {Completeness.CERTIFIED}
    assert not atlas.of_corank(atlas.evidence[-1].corank)
    assert "certified: there are none" in atlas.explanation
    assert all(verdict.accepted for verdict in atlas.certificate.check().values())


@pytest.mark.parametrize("name", CERTIFIED)
def test_points_on_the_leaves_of_proofs_are_singular(name):
    atlas, robot, rng = atlas_of(name), rik.load(name), np.random.default_rng(1)
    for proof in atlas.certificate:
        for place in (place for leaf in leaves(proof) for place in leaf.places):
            values = members(place, rng, 10)
            assert len(values) > 0
            assert place.residual(values).max() < 1e-9
            s = svd(robot.jacobian(robot.configuration(values), rows=atlas.robot.chain.rows)).s
            assert (s[:, -proof.corank] / s[:, 0]).max() < (1e-5 if atlas.robot.changes else 1e-9)


def test_a_proof_that_only_says_again_that_it_is_singular_is_implicit():
    atlas = atlas_of("almarkhi_4dof")
    assert [each.status for each in atlas.evidence] == [Completeness.IMPLICIT, Completeness.CERTIFIED]
    assert "implicit" in atlas.explanation
    assert "probability below" in atlas.explanation


# ------------------------------------------------------------------------------------------------ when not to certify
def test_what_the_checker_refuses_is_an_estimate(monkeypatch):
    monkeypatch.setattr(proof_evidence, "check", lambda *given, **options: Verdict(False, "refused: for a test"))
    atlas = rik.find_singularities(rik.load("duleba_3r"), starts=100)
    assert {each.status for each in atlas.evidence} == {Completeness.ESTIMATE, Completeness.NONE_FOUND}
    assert "a proof was not accepted: refused: for a test" in atlas.explanation


@pytest.mark.parametrize("name", ["pa10", "puma560"])
def test_a_list_that_lacks_any_one_family_is_not_certified(name):
    atlas, work = atlas_of(name), state_of(atlas_of(name))
    for missing in atlas.strata:
        work.leaves = [leaf for row in atlas if row is not missing for leaf in row.leaves]
        found = judged(work)[missing.corank - 1]
        assert found.status is Completeness.ESTIMATE
        assert "that the list lacks" in found.words


def test_a_list_with_a_family_that_the_proof_does_not_have_is_not_certified():
    atlas = atlas_of("pa10")
    row = atlas.strata[0]
    moved = replace(row, samples=row.samples + 0.3)
    assert statuses(replace(atlas, strata=(moved, *atlas.strata)))[0] is Completeness.ESTIMATE


@pytest.mark.slow
def test_a_curve_does_not_stand_for_another_family_of_its_dimension():
    """It has no equation, so it could account for points that only have as many freedoms."""
    atlas = atlas_of("panda")
    lacking = replace(atlas, strata=tuple(row for row in atlas if row.words != "q2 ∈ {0, π} and q4 = 0"))
    assert len(lacking) == len(atlas) - 1
    assert any(row.curve for row in lacking.of_corank(1))
    assert statuses(lacking)[0] is Completeness.ESTIMATE
    few = rik.find_singularities(rik.load("panda"), 1, starts=5, rng=3)
    assert len(few) == 5
    assert few.evidence[0].status is Completeness.CERTIFIED


def test_what_a_proof_adds_takes_the_place_of_curves_that_few_points_left():
    """The Stanford arm: few points leave q4 and q5 coupled where each stands still."""
    quarter = f"{np.pi / 2} 0 0"
    parts = [
        ("revolute", "0 0 0", "0 0 0"), ("revolute", "0 0.15 0.4", f"-{quarter}"), ("prismatic", "0 0 0", quarter),
        ("revolute", "0 0 0", "0 0 0"), ("revolute", "0 0 0", f"-{quarter}"), ("revolute", "0 0 0", quarter),
        ("fixed", "0 0 0.2", "0 0 0"),
    ]  # fmt: skip
    links = "".join(f'<link name="l{i}"/>' for i in range(8))
    joints = "".join(
        f'<joint name="j{i}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1.5" velocity="1" effort="1"/></joint>'
        for i, (kind, xyz, rpy) in enumerate(parts)
    )
    tree = parse_urdf(f'<robot name="stanford">{links}{joints}</robot>')
    atlas = rik.find_singularities(rik.Robot.from_description(tree, "l7"), starts=60)
    assert {each.status for each in atlas.evidence} == {Completeness.CERTIFIED}
    assert not any(row.curve for row in atlas)
    assert [len(atlas.of_corank(corank)) for corank in (1, 2, 3)] == [3, 3, 0]


@pytest.mark.slow
def test_a_file_of_an_arm_with_signed_relations_is_read(tmp_path):
    atlas = rik.find_singularities(rik.load("puma560_corke"), starts=20)
    assert str(SingularityAtlas.load(atlas.save(tmp_path / "atlas.json"))) == str(atlas)


@pytest.mark.slow
def test_a_family_whose_conditions_say_less_than_its_samples_is_not_certified():
    atlas = atlas_of("puma560")
    wrist = next(row for row in atlas if row.words == "q5 ∈ {0, π}")
    everywhere = replace(wrist, conditions=(), free=tuple(range(6)))
    rest = tuple(row for row in atlas if row.corank > 1)
    assert statuses(replace(atlas, strata=(everywhere, *rest)))[0] is Completeness.ESTIMATE
    more = replace(wrist.conditions[0], values=(0.0, 1.0, np.pi))
    added = tuple(replace(row, conditions=(more,)) if row is wrist else row for row in atlas)
    assert statuses(replace(atlas, strata=added))[0] is Completeness.ESTIMATE


def test_a_relation_that_holds_elsewhere_too_is_not_certified():
    atlas = atlas_of("puma560")
    elbow = atlas.strata[0]
    nothing = replace(elbow.relations[0], coefficients=0 * elbow.relations[0].coefficients)
    wider = replace(elbow, relations=(nothing,))
    assert statuses(replace(atlas, strata=(wider, *atlas.strata[1:])))[0] is Completeness.ESTIMATE


def test_proofs_find_what_random_starts_miss():
    atlas = rik.find_singularities(rik.load("pa10"), starts=1)
    assert [sum(row.components for row in atlas.of_corank(k)) for k in (1, 2, 3)] == [14, 40, 32]
    assert {each.status for each in atlas.evidence} == {Completeness.CERTIFIED}


def test_an_arm_that_no_exact_arm_stands_for_says_why():
    """One joint follows another: the finder takes it, proofs do not."""
    links = "".join(f'<link name="l{i}"/>' for i in range(5))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/><origin xyz="0.4 0 0"/>'
        f'<axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="1" effort="1"/>{mimic}</joint>'
        for i, (axis, mimic) in enumerate(
            [("0 0 1", ""), ("0 1 0", ""), ("0 1 0", '<mimic joint="j1" multiplier="0.5"/>'), ("0 1 0", "")]
        )
    )
    tree = parse_urdf(f'<robot name="r">{links}{joints}</robot>')
    atlas = rik.find_singularities(rik.Robot.from_description(tree, "l4", rows=("x", "y", "z")), 1, starts=100)
    assert atlas.evidence[0].status is Completeness.ESTIMATE
    assert "no proof was tried: joint 'j2' follows 'j1' 0.5-fold: not supported" in atlas.explanation


# ------------------------------------------------------------------------------------------------ files
def test_a_file_is_not_believed_but_checked_again(tmp_path):
    path = atlas_of("pa10").save(tmp_path / "atlas.json")
    data = json.loads(path.read_text())
    nodes = data["certificate"]["proofs"][0]["nodes"]
    leaf = next(index for index, node in enumerate(nodes) if node["kind"] == "leaf")
    nodes[leaf]["kind"] = "contradiction"
    path.write_text(json.dumps(data))
    atlas = SingularityAtlas.load(path)
    assert [each.status for each in atlas.evidence] == [Completeness.ESTIMATE, *[Completeness.CERTIFIED] * 3]
    data["certificate"] = None
    path.write_text(json.dumps(data))
    assert Completeness.CERTIFIED not in {each.status for each in SingularityAtlas.load(path).evidence}


@cache
def saved(name):
    """The text of a file of its atlas at corank 1."""
    with tempfile.TemporaryDirectory() as folder:
        return rik.find_singularities(rik.load(name), 1, starts=100).save(Path(folder) / "atlas.json").read_text()


def edited(name, tmp_path, edit):
    """The atlas that is read from a file in which something was changed."""
    data = json.loads(saved(name))
    edit(data)
    (tmp_path / "atlas.json").write_text(json.dumps(data))
    return SingularityAtlas.load(tmp_path / "atlas.json")


def wider(data):
    data["strata"][0] |= {"conditions": [], "relations": [], "free": list(range(6)), "dimension": 6}


def doubled(data):
    chain = data["robot"]["chain"]
    chain["offsets"] = [[2 * length for length in offset] for offset in chain["offsets"]]


def put(*path):
    """Puts the last of its arguments where the others lead to."""
    *way, key, value = path

    def edit(data):
        for each in way:
            data = data[each]
        data[key] = value

    return edit


@pytest.mark.parametrize(
    "edit, message",
    [
        (wider, "not singular"),
        (doubled, "about another arm"),
        (put("robot", "chain", "period", [1e-9] * 6), "a whole turn"),
        (put("robot", "chain", "joint_names", ["a"] * 6), "about another arm"),
        (put("robot", "name", 5), "no text"),
        (put("robot", "lower", [1, 2]), "limits are not of 6 joints"),
        (put("strata", 2, "dimension", 1), "has not the dimension 1"),
        (put("strata", 2, "free", []), "are not the robot's"),
        (put("strata", 2, "corank", 6), "of which nothing is said"),
        (put("strata", 2, "samples", 0, [9.0] * 6), "not singular"),
        (put("strata", 2, "components", "many"), "components cannot be 'many'"),
        (put("strata", 2, "conditions", 0, "values", [0.0, 1.0]), "not singular"),
        (put("strata", 2, "conditions", 0, "values", [10**400]), "too large"),
        (put("strata", 0, "relations", 0, "coefficients", [0.0] * 3), "no sum of products"),
        (put("strata", 0, "relations", 0, "points", float("inf")), "infinity"),
        (put("evidence", 0, "fresh", "abc"), "fresh cannot be 'abc'"),
        (put("evidence", 0, "fresh", -5), "fresh cannot be '-5'"),
        (put("evidence", []), "of which nothing is said"),
        (put("settings", "method", {}), "no method"),
    ],
)
def test_a_file_whose_rows_or_numbers_cannot_be_is_refused(tmp_path, edit, message):
    with pytest.raises(rik.LoadError, match=message):
        edited("puma560", tmp_path, edit)


def test_words_come_from_the_conditions_and_not_from_the_file(tmp_path):
    atlas = edited("puma560", tmp_path, put("strata", 2, "conditions", 0, "words", "q5 = 1"))
    assert atlas.strata[2].words == "q5 ∈ {0, π}"


@pytest.mark.slow
def test_a_proof_of_another_arm_certifies_nothing():
    atlas, other = atlas_of("pa10"), atlas_of("panda")
    assert set(statuses(replace(atlas, certificate=other.certificate))) == {
        Completeness.ESTIMATE,
        Completeness.NONE_FOUND,
    }


def test_certificates_come_back_from_their_file(tmp_path):
    certificate = atlas_of("puma560").certificate
    back = Certificate.load(certificate.save(tmp_path / "certificate.json"))
    assert back.to_json() == certificate.to_json()
    assert [proof.corank for proof in back] == [1, 2, 3]
    assert back.of_corank(2).corank == 2
    assert back.of_corank(6) is None
    alone = Certificate.from_json(next(iter(certificate)).to_json())
    assert len(alone) == 1
    twice = json.loads(certificate.to_json())
    twice["proofs"].append(twice["proofs"][0])
    with pytest.raises(rik.certificates.CertificateError, match="same corank"):
        Certificate.from_json(json.dumps(twice))


@pytest.mark.slow
def test_the_same_arm_gives_the_same_proofs():
    one, other = (rik.find_singularities(rik.load("puma560"), starts=50).certificate.to_json() for _ in range(2))
    assert one == other


def test_without_computer_algebra_the_atlas_is_an_estimate(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    atlas = rik.find_singularities(rik.load("duleba_3r"), 1, starts=100)
    assert atlas.evidence[0].status is Completeness.ESTIMATE
    assert "python-flint is not installed" in atlas.explanation
    assert isinstance(next(iter(atlas.certificate)), Proof)
