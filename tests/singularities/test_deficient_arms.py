"""Arms that never have full rank in six rows: what they lose besides does not hang on mounts, tips, units and zeros."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import robust_ik as rik
from robust_ik import certificates
from robust_ik.singularities.atlas.evidence import Completeness
from robust_ik.singularities.families.leaf_survey import accounts
from robust_ik.singularities.find.find_points import find_points
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from tests.deficient_arms import KINDS, DeficientArm
from tests.rounded_arms import shape

DATA = Path(__file__).parents[1] / "data"
STARTS = 200
ARMS = [(kind, seed) for seed in (0, 1) for kind in KINDS]


@cache
def atlas_of(kind, seed, certify=True):
    return rik.find_singularities(DeficientArm.drawn(kind, seed).robot(), starts=STARTS, certify=certify)


# ----------------------------------------------------------------------------------------------- what is analysed
@pytest.mark.parametrize(("kind", "seed"), ARMS)
def test_all_six_rows_are_analysed_and_the_corank_is_what_is_missing_of_the_largest_rank(kind, seed):
    arm, atlas = DeficientArm.drawn(kind, seed), atlas_of(kind, seed)
    chain = atlas.robot.chain
    assert chain.m == 6
    assert chain.full_rank == arm.rank() < min(6, arm.n)
    assert f"its {arm.n} joints never move the tip in more than" in atlas.explanation
    for row in atlas:
        s = np.array([np.linalg.svd(arm.jacobian(each), compute_uv=False) for each in row.samples])
        assert (s[:, arm.rank() - row.corank] < 1e-9).all()
        assert np.median(s[:, arm.rank() - row.corank - 1]) > 1e-6


@pytest.mark.parametrize(("kind", "seed"), ARMS)
def test_a_search_of_another_kind_finds_nothing_else(kind, seed):
    arm, atlas, rng = DeficientArm.drawn(kind, seed), atlas_of(kind, seed), np.random.default_rng(seed)
    units = atlas.robot.units
    for corank in (1, 2):
        found = arm.singular_points(corank, rng, 8)
        leaves = [
            leaf for row in atlas if row.corank >= corank for leaf in row.measured_in(units, atlas.robot.symbols).leaves
        ]
        assert accounts(atlas.robot.measured_in(units).chain, corank, leaves, found / units).all()
        assert len(found) == 0 or len(atlas.of_corank(corank)) > 0 or len(atlas.of_corank(corank + 1)) > 0
        if atlas.of_corank(1) and corank == 1:
            assert len(found) > 0


@pytest.mark.parametrize("change", ["mount", "tip", "size", "zeros", "all"])
@pytest.mark.parametrize(("kind", "seed"), ARMS)
def test_rows_are_the_same_on_any_mount_with_any_tip_of_any_size_and_with_any_zeros(kind, seed, change):
    arm = DeficientArm.drawn(kind, seed).changed(np.random.default_rng([seed, 7]))[change]
    found = rik.find_singularities(arm.robot(), starts=STARTS, certify=False)
    assert found.robot.chain.full_rank == arm.rank()
    assert shape(found) == shape(atlas_of(kind, seed))


# ----------------------------------------------------------------------------------------------- the residual
@pytest.mark.parametrize(("kind", "seed"), ARMS[: len(KINDS)])
def test_points_have_the_corank_and_dimension_that_entries_which_are_always_zero_do_not_change(kind, seed):
    robot = DeficientArm.drawn(kind, seed).robot()
    chain, atlas = ScrewChain.of(robot, length_scale=robot.length_scale), atlas_of(kind, seed)
    points = find_points(chain, 1, 100)
    rows = {(row.corank, row.dimension) for row in atlas}
    found = set(zip(points.coranks[~points.folded].tolist(), points.dimensions[~points.folded].tolist()))
    assert found <= rows
    if atlas.of_corank(1):
        assert len(points) > 30
        assert (1, max(row.dimension for row in atlas.of_corank(1))) in found


def test_rows_that_are_asked_for_have_a_largest_rank_of_their_own():
    arm = DeficientArm.drawn("parallel", 0)
    atlas = rik.find_singularities(arm.robot(), rows=("x", "y", "wz"), starts=STARTS, certify=False)
    assert atlas.robot.chain.rows == ("x", "y", "wz")
    assert atlas.robot.chain.full_rank == 3
    turns = rik.find_singularities(arm.robot(), rows=("wx", "wy", "wz"), starts=STARTS)
    assert [row.words for row in turns] == ["q5 = ±π/2"]
    still = rik.find_singularities(DeficientArm.drawn("lift", 0).robot(), rows=("wx", "wy"), starts=STARTS)
    assert len(still) == 0
    assert "never moves its tip in the rows wx wy at all" in still.explanation


@pytest.mark.parametrize("method", ["projection", "gradient"])
def test_both_methods_find_what_is_lost_besides(method):
    robot = DeficientArm.drawn("parallel", 0).robot()
    atlas = rik.find_singularities(robot, 1, starts=STARTS, method=method, certify=False)
    assert "q5 = ±π/2" in [row.words for row in atlas]


# ----------------------------------------------------------------------------------------------- what is lost
@pytest.mark.parametrize(("kind", "seed"), ARMS[: len(KINDS)])
def test_what_an_arm_never_does_is_not_told_as_lost(kind, seed):
    """A lost direction does no work in any motion there, but does in some motion nearby."""
    arm, atlas = DeficientArm.drawn(kind, seed), atlas_of(kind, seed)
    rng = np.random.default_rng(0)
    for row in atlas:
        lost = row.lost.example
        here = row.lost.values
        J = arm.jacobian(here)
        scale = np.array([1.0 / arm.size] * 3 + [1.0] * 3)
        np.testing.assert_allclose(lost.twists.T @ J, 0, atol=1e-8)
        assert lost.self_motions.shape[1] == arm.n - arm.rank() + row.corank
        assert 1 <= lost.twists.shape[1] <= 6 - arm.rank() + row.corank
        near = [arm.jacobian(here + 1e-3 * rng.standard_normal(arm.n)) for _ in range(8)]
        work = np.abs(np.stack([lost.twists.T @ each for each in near])).max(axis=(0, 2))
        assert (work > 1e-5 * scale.max()).all()
    told = {row.words: row.lost.example.twists.shape[1] for row in atlas}
    assert kind != "planar" or set(told.values()) == {1}


# ----------------------------------------------------------------------------------------------- proofs
@pytest.mark.parametrize(("kind", "seed"), ARMS[: len(KINDS)])
def test_proofs_are_about_what_is_missing_of_the_largest_rank(kind, seed):
    arm, atlas = DeficientArm.drawn(kind, seed), atlas_of(kind, seed)
    assert atlas.certificate is not None
    for proof in atlas.certificate:
        assert proof.arm.rank == arm.rank()
    assert all(each.status is Completeness.CERTIFIED for each in atlas.evidence)


def test_a_proof_about_another_rank_is_refused():
    proof = next(iter(atlas_of("planar", 0).certificate))
    assert certificates.check(proof).accepted
    assert certificates.Proof.from_json(proof.to_json()) == proof
    rank = proof.arm.rank
    for other in (rank - 1, rank + 1):
        verdict = certificates.check(replace(proof, arm=replace(proof.arm, rank=other)))
        assert not verdict.accepted
        assert f"nearly everywhere, not {other}" in verdict.reason
    for nonsense in (0, -1, 7, True, "3", None):
        data = json.loads(proof.to_json())
        data["arm"]["rank"] = nonsense
        assert not certificates.check(json.dumps(data)).accepted
    data = json.loads(proof.to_json())
    data["version"] = 2
    assert "what its rank is" in certificates.check(json.dumps(data)).reason
    del data["arm"]["rank"], data["arm"]["motions"]
    assert "nearly everywhere, not 4" in certificates.check(json.dumps(data)).reason


def test_certify_takes_coranks_of_the_largest_rank():
    robot = DeficientArm.drawn("planar", 0).robot()
    assert certificates.certify(robot, 3, time_limit=1).status == "proved"
    with pytest.raises(rik.InputError, match="corank must be from 1 to 3"):
        certificates.certify(robot, 4)


# ----------------------------------------------------------------------------------------------- files
@pytest.mark.parametrize(("kind", "seed"), ARMS[: len(KINDS)])
def test_atlases_come_back_from_files(kind, seed, tmp_path):
    atlas = atlas_of(kind, seed)
    back = rik.SingularityAtlas.load(atlas.save(tmp_path / "atlas.json"))
    assert back.markdown() == atlas.markdown()
    assert back.robot.chain.rank == atlas.robot.chain.rank


def test_an_atlas_of_the_version_before_is_read_as_of_the_rows_that_it_kept():
    atlas = rik.SingularityAtlas.load(DATA / "atlas_version_3.json")
    assert atlas.robot.chain.m == atlas.robot.chain.full_rank < 6
    assert "cannot all move: analysed in" in atlas.explanation
    assert all(each.status is Completeness.CERTIFIED for each in atlas.evidence)
    assert len(atlas) > 0
    more = atlas.extended(20)
    assert [row.words for row in more] == [row.words for row in atlas]


@pytest.mark.parametrize("rank", [0, 2, 4, None, True, "3", 3.0, -1, 1e300])
def test_an_atlas_about_another_rank_does_not_load(rank, tmp_path):
    path = atlas_of("planar", 0).save(tmp_path / "atlas.json")
    data = json.loads(path.read_text())
    assert data["robot"]["chain"]["rank"] == 3
    for each in ("chain", "given", "near"):
        if data["robot"][each] is not None:
            data["robot"][each]["rank"] = rank
    path.write_text(json.dumps(data))
    with pytest.raises(rik.LoadError):
        rik.SingularityAtlas.load(path)
