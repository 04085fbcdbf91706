import json
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from rich.console import Console

import robust_ik as rik
from robust_ik.errors import InputError, LoadError, TipError
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.atlas.atlas import SingularityAtlas
from robust_ik.singularities.atlas.atlas_json import to_plain
from robust_ik.singularities.atlas.atlas_record import NoSingularitiesError
from robust_ik.singularities.atlas.evidence import Completeness, missing_mass
from robust_ik.singularities.atlas.find_singularities import find_singularities

PA10 = {
    1: {
        "q4 ∈ {0, π}": (6, 2),
        "q2 ∈ {0, π} and q3 = ±π/2": (5, 4),
        "q2 ∈ {0, π} and q6 ∈ {0, π}": (5, 4),
        "q5 = ±π/2 and q6 ∈ {0, π}": (5, 4),
    },
    2: {
        "q2 ∈ {0, π} and q3 ∈ {0, π} and q4 ∈ {0, π}": (4, 8),
        "q2 ∈ {0, π} and q4 ∈ {0, π} and q6 ∈ {0, π}": (4, 8),
        "q4 ∈ {0, π} and q5 ∈ {0, π} and q6 ∈ {0, π}": (4, 8),
        "q2 ∈ {0, π} and q3 = ±π/2 and q5 = ±π/2 and q6 ∈ {0, π}": (3, 16),
    },
    3: {"q2 ∈ {0, π} and q3 ∈ {0, π} and q4 ∈ {0, π} and q5 ∈ {0, π} and q6 ∈ {0, π}": (2, 32)},
}


def atlas_of(name, seed=0):
    return _cached(name, seed)


@cache
def _cached(name, seed):
    return find_singularities(rik.load(name), starts=400, rng=seed)


def words(atlas, corank):
    return {row.words for row in atlas.of_corank(corank)}


def last_sigma(robot, rows, values, corank):
    """σ_{m−k+1}/σ₁ by Pinocchio, not by the chain that the atlas was made with."""
    s = svd(robot.jacobian(robot.configuration(values), rows=rows)).s
    return s[:, len(rows) - corank] / s[:, 0]


def check_no_spurious_row(name):
    """Random fills of the free joints stay singular; pinned joints moved away are not."""
    robot, atlas, rng = rik.load(name), atlas_of(name), np.random.default_rng(7)
    rows = atlas.robot.chain.rows
    assert atlas.strata
    for row in atlas:
        for leaf in row.leaves:
            members = leaf.filled(atlas.robot.chain, rng, 20)
            assert last_sigma(robot, rows, members, row.corank).max() < max(1e-9, 50 * row.off), row.words
            for condition in row.conditions:
                for joint in condition.angle.joints:
                    away = members + rng.uniform(0.3, 1.0) * np.eye(robot.n)[joint]
                    assert np.median(last_sigma(robot, rows, away, row.corank)) > 1e-5, (row.words, joint)


# ------------------------------------------------------------------------------------------------ known answers
@pytest.mark.parametrize("seed", range(20))
def test_pa10_has_the_rows_of_the_paper_and_no_other(seed):
    atlas = find_singularities(rik.load("pa10"), starts=200, rng=seed, certify=False)
    assert atlas.highest == 3
    for corank, expected in PA10.items():
        assert {row.words: (row.dimension, row.components) for row in atlas.of_corank(corank)} == expected
    assert [sum(row.components for row in atlas.of_corank(k)) for k in (1, 2, 3)] == [14, 40, 32]
    assert all(row.counted for row in atlas)
    assert all(each.unmatched == each.unexplained == 0 for each in atlas.evidence)


def test_the_rows_of_pa10_are_certified():
    atlas = atlas_of("pa10")
    assert [each.status for each in atlas.evidence] == [Completeness.CERTIFIED] * 4
    assert [each.leaves for each in atlas.evidence] == [14, 40, 32, 0]


def test_puma_elbow_wrist_and_shoulder_are_named_by_the_dh_lengths():
    atlas = atlas_of("puma560")
    assert words(atlas, 1) == {"q5 ∈ {0, π}", "tan q3 = d4/a3", "a2 c2 + a3 c23 + d4 s23 = 0"}
    (shoulder,) = [row for row in atlas.of_corank(1) if row.relations]
    found = {
        str(term[0]): value for term, value in zip(shoulder.relations[0].terms, shoulder.relations[0].coefficients)
    }
    a2, a3, d4 = 0.4318, -0.0203, 0.4331
    assert_allclose([found["c2"] / found["s23"], found["c23"] / found["s23"]], [a2 / d4, a3 / d4], rtol=1e-6)
    (elbow,) = [row for row in atlas.of_corank(1) if "tan" in row.words]
    assert_allclose(np.tan(elbow.conditions[0].values), d4 / a3, rtol=1e-6)
    assert shoulder.components == 2
    assert {row.dimension for row in atlas.of_corank(1)} == {5}
    assert sorted((row.dimension, row.components) for row in atlas.of_corank(2)) == [(3, 8), (3, 8), (4, 4)]
    assert atlas.highest == 2


@pytest.mark.slow
def test_ur5_shoulder_couples_three_parallel_joints_with_the_ratios_of_its_lengths():
    atlas = atlas_of("ur5")
    a2, a3, d5 = 0.425, 0.39225, 0.09465
    assert {"q3 ∈ {0, π}", "q5 ∈ {0, π}"} < words(atlas, 1)
    assert len(atlas.of_corank(1)) == 3
    (shoulder,) = [row for row in atlas.of_corank(1) if row.relations]
    found = {
        str(term[0]): value for term, value in zip(shoulder.relations[0].terms, shoulder.relations[0].coefficients)
    }
    assert set(found) == {"c2", "c23", "s234"}
    assert_allclose(np.abs([found["c23"], found["s234"]]) / abs(found["c2"]), [a3 / a2, d5 / a2], rtol=1e-6)
    assert atlas.highest == 3


def test_dulebas_3r_arm():
    atlas = atlas_of("duleba_3r")
    assert words(atlas, 1) == {"q3 ∈ {0, π}", "a1 + a2 c2 + a3 c23 = 0"}
    (point,) = atlas.of_corank(2)
    assert [str(each.angle) for each in point.conditions] == ["q2", "q3"]
    assert point.conditions[1].values == (0.0,)
    # At q3 = 0 the relation says (a2 + a3) cos q2 = −a1.
    assert_allclose(np.cos(point.conditions[0].values), -0.3 / 0.5, atol=1e-9)
    assert (point.dimension, point.components) == (1, 2)


def test_the_4dof_arm_is_singular_along_curves_of_corank_1_only():
    atlas = atlas_of("almarkhi_4dof")
    (row,) = atlas.strata
    assert (row.corank, row.dimension, row.free, row.curve) == (1, 2, (0,), (1, 2, 3))
    assert "no short relation, see the curve" in row.words
    assert atlas.evidence[0].unmatched == 0


def test_panda_has_the_five_families_and_three_of_them_within_its_limits():
    atlas = atlas_of("panda")
    rows = atlas.of_corank(1)
    shapes = {(tuple(str(each.angle) for each in row.conditions), row.curve, bool(row.relations)) for row in rows}
    assert shapes == {
        (("q2", "q4"), (), False),
        (("q4", "q5"), (), False),
        (("q4", "q6"), (), False),
        (("q5",), (), True),
        (("q2",), (2, 3, 4, 5), False),
    }
    assert {row.dimension for row in rows} == {5}
    assert sum(row.within_limits for row in rows) == 3
    (related,) = [row for row in rows if row.relations]
    assert related.relations[0].joints == (3, 5)
    assert related.words.startswith("q5 = ±π/2")
    assert related.components == 4
    elbow = next(row for row in rows if row.words == "q2 ∈ {0, π} and q4 = 0")
    assert_allclose(elbow.margin, -0.0698, atol=1e-6)  # the upper limit of q4
    assert atlas.highest == 2


@pytest.mark.parametrize("name", ["pa10", "panda", "puma560", "ur5", "duleba_3r", "kinova", "z1", "talos_arm"])
def test_no_row_is_spurious(name):
    check_no_spurious_row(name)


@pytest.mark.slow
def test_a_rounded_urdf_is_straightened_and_its_floor_told():
    atlas = atlas_of("xarm7")
    assert len(atlas.robot.changes) > 3
    assert all(1e-8 < row.off < 1e-5 and row.residual < 1e-9 for row in atlas)
    assert "q5 = ±π/2" in " ".join(words(atlas, 1))
    assert "angles are rounded" in atlas.explanation
    check_no_spurious_row("xarm7")


def test_a_stratum_where_two_factors_meet_is_found_by_deed():
    atlas = find_singularities(rik.load("finger_edu"), rows=("x", "y", "z"), starts=400)
    assert "q3 ∈ {0, π}" in words(atlas, 1)
    assert atlas.evidence[0].unmatched == 0


# ------------------------------------------------------------------------------------------------ what is answered
def test_rows_that_an_arm_cannot_all_move_are_explained_and_it_is_analysed_on_what_it_can_do():
    atlas = find_singularities(rik.load("planar_2r"), rows=("x", "y", "z"), starts=100)
    assert atlas.robot.chain.rows == ("x", "y", "z")
    assert "has 2 joints for the rows x y z: its corank is 2 − rank" in atlas.explanation
    assert words(atlas, 1) == {"q2 ∈ {0, π}"}


def test_an_empty_answer_is_explained():
    atlas = find_singularities(rik.load("planar_2r"), 2, starts=200, certify=False)
    assert len(atlas) == 0
    assert atlas.evidence[0].status is Completeness.NONE_FOUND
    assert "none found by 200 starts" in atlas.explanation
    assert "probability below 1.5 % (0 of 200)" in atlas.explanation
    with pytest.raises(NoSingularitiesError, match="corank 2"):
        atlas.raise_for_status()
    with pytest.raises(NoSingularitiesError):
        atlas.distance([0.0, 0.0])


def test_sliding_joints_are_pinned_by_lengths_and_searched_within_limits():
    table = rik.DHTable(
        (
            rik.DHJoint(a=0, d=0, alpha=-np.pi / 2),
            rik.DHJoint(a=0, d=0, alpha=np.pi / 2),
            rik.DHJoint(a=0, d=0, alpha=0, kind="prismatic", lower=-1, upper=1),
        ),
        "standard",
        rows=("x", "y", "z"),
    )
    atlas = find_singularities(rik.Robot.from_dh(table), starts=300)
    assert words(atlas, 1) == {"q2 ∈ {0, π}"} or words(atlas, 1) == {"q2 ∈ {0, π}", "q3 = 0 m"}
    assert words(atlas, 2) == {"q3 = 0 m"}


def test_the_estimate_is_worded_as_a_hold_out():
    atlas = find_singularities(rik.load("pa10"), starts=400, certify=False)
    assert {each.status for each in atlas.evidence} == {Completeness.ESTIMATE, Completeness.NONE_FOUND}
    assert atlas.certificate is None
    assert (
        "with 95 % confidence a further random start of this finder meets an unlisted stratum with probability below "
        "0.75 % (0 of 400)" in atlas.explanation
    )
    assert missing_mass(0, 3000) == pytest.approx(1 - 0.05 ** (1 / 3000))
    assert missing_mass(2, 3000) == pytest.approx(0.002097, abs=1e-6)
    assert missing_mass(5, 5) == 1.0


def test_the_same_seed_gives_the_same_atlas_and_a_generator_gives_a_seed():
    robot = rik.load("duleba_3r")
    one, other = (find_singularities(robot, starts=300, rng=5) for _ in range(2))
    assert json.dumps(to_plain(one)) == json.dumps(to_plain(other))
    assert find_singularities(robot, 2, starts=20, rng=np.random.default_rng(1)).settings.seed > 0


@pytest.mark.parametrize("name", ["puma560", "panda", "xarm7"])
def test_an_atlas_comes_back_from_its_file_unchanged(tmp_path, name):
    atlas = atlas_of(name)
    back = SingularityAtlas.load(atlas.save(tmp_path / "atlas.json"))
    assert to_plain(back) == to_plain(atlas)
    assert str(back) == str(atlas)
    q = np.full(len(atlas.robot.lower), 0.3)
    assert back.distance(q).distance == atlas.distance(q).distance


@pytest.mark.parametrize(
    "text, message",
    [
        ("{}", "is no singularity atlas"),
        ("[1]", "is no singularity atlas"),
        ("nonsense", "is a broken atlas"),
        ('{"format": "robust_ik singularity atlas", "version": 99}', "reads versions 3 and 4"),
        ('{"format": "robust_ik singularity atlas", "version": 4}', "is a broken atlas"),
    ],
)
def test_what_is_no_atlas_is_refused_in_a_sentence(tmp_path, text, message):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(LoadError, match=message):
        SingularityAtlas.load(path)


@pytest.mark.parametrize("value", [1e308, -1e19, float("nan")])
@pytest.mark.parametrize("place", ["samples", "values", "offsets", "order"])
def test_an_atlas_of_enormous_numbers_is_refused_without_a_warning(tmp_path, place, value):
    atlas = atlas_of("puma560")
    plain = json.loads(json.dumps(to_plain(atlas)))
    row = next(each for each in plain["strata"] if each["relations" if place == "order" else "conditions"])
    match place:
        case "samples":
            row["samples"][0][0] = value
        case "values":
            row["conditions"][0]["values"][0] = value
        case "offsets":
            plain["robot"]["chain"]["offsets"][0][0] = value
        case _:
            factor = next(factor for term in row["relations"][0]["terms"] for factor in term)
            factor.update(kind="power", order=abs(value))
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(plain))
    with pytest.raises(LoadError):
        SingularityAtlas.load(path)


def test_an_interrupted_search_gives_what_it_had_found():
    def stop(done, total):
        if done / total > 0.3:
            raise KeyboardInterrupt

    atlas = find_singularities(rik.load("pa10"), starts=300, progress=stop)
    assert atlas.interrupted
    assert words(atlas, 1) == set(PA10[1])
    assert not atlas.of_corank(3)
    assert "interrupted" in atlas.explanation
    with pytest.raises(NoSingularitiesError, match="interrupted"):
        atlas.raise_for_status()


def test_an_atlas_is_resumed_with_more_starts():
    atlas = find_singularities(rik.load("pa10"), 2, starts=20)
    more = atlas.extended(500)
    assert more.settings.starts == 520
    assert more.evidence[0].starts == 520
    assert {row.words: (row.dimension, row.components) for row in more} == PA10[2]


def test_a_corank_may_be_any_whole_number_and_the_atlas_still_be_saved(tmp_path):
    atlas = find_singularities(rik.load("duleba_3r"), np.int64(2), starts=20)
    assert SingularityAtlas.load(atlas.save(tmp_path / "atlas.json")).settings.corank == 2


@pytest.mark.parametrize("length", [1e-9, 1e9])
def test_no_length_scale_hides_what_is_singular(length):
    found = find_singularities(rik.load("puma560"), 1, starts=20, length_scale=length)
    assert words(found, 1) == words(find_singularities(rik.load("puma560"), 1, starts=20), 1)


def test_which_rows_are_analysed_does_not_depend_on_the_length_scale():
    atlas = find_singularities(rik.load("puma560"), 1, starts=20, length_scale=1e3)
    assert not atlas.robot.reduced
    assert len(atlas) == 3


def test_the_papers_own_method_finds_the_same_rows():
    atlas = find_singularities(rik.load("pa10"), 1, starts=150, method="gradient")
    assert words(atlas, 1) == set(PA10[1])


# ------------------------------------------------------------------------------------------------ distances, limits
def test_the_distance_to_pinned_strata_is_that_of_the_pinned_joints():
    atlas = atlas_of("pa10")
    q = np.array([0.3, 0.8, 0.6, 0.5, 1.0, 0.9, 0.2])
    found = atlas.distance(q)
    assert found.stratum.words == "q4 ∈ {0, π}"
    assert_allclose(found.distance, 0.5, atol=1e-12)
    assert_allclose(found.sigma[-1], 0, atol=1e-12)
    assert (np.diff(found.sigma) < 0).all()
    distances = [each.distance for each in atlas.distances(q)]
    assert distances == sorted(distances)
    assert len(distances) == 9


def test_the_distance_to_a_relation_is_no_longer_than_to_any_sample():
    atlas = atlas_of("puma560")
    q = np.array([0.1, 0.4, 0.7, 0.2, 1.2, 0.3])
    for found in atlas.distances(q):
        samples = np.concatenate([leaf.samples for leaf in found.stratum.leaves])
        away = np.linalg.norm((samples - q + np.pi) % (2 * np.pi) - np.pi, axis=1)
        assert found.distance <= away.min() + 1e-9
        s = svd(rik.load("puma560").jacobian(found.values)).s
        assert s[-1] < 1e-9


def test_continuous_joints_may_be_given_as_in_q():
    robot, atlas = rik.load("kinova"), atlas_of("kinova")
    values = np.array([0.1, 2.0, 1.0, 0.5, 0.4, 0.3])
    assert atlas.distance(robot.configuration(values)).distance == pytest.approx(atlas.distance(values).distance)
    with pytest.raises(InputError, match="q must have shape"):
        atlas.distance([0.0])


def test_margins_say_how_far_the_limits_exclude_a_row():
    atlas = atlas_of("talos_arm")
    robot = rik.load("talos_arm")
    wrist = next(row for row in atlas.of_corank(1) if row.words == "q5 = ±π/2")
    assert not wrist.within_limits
    assert_allclose(wrist.margin, robot.upper[4] - np.pi / 2, atol=1e-9)
    elbow = next(row for row in atlas.of_corank(1) if row.words.startswith("q3"))
    assert all(robot.lower[2] - 1e-9 <= value[0] <= robot.upper[2] for value in elbow.inside)
    assert len(elbow.inside) < len(elbow.leaves)


# ------------------------------------------------------------------------------------------------ tables, errors
def test_tables_hold_every_row():
    atlas = atlas_of("panda")
    console = Console(record=True, width=200)
    console.print(atlas.table())
    shown = console.export_text()
    assert all(text in shown for text in ("q2 ∈ {0, π} and q4 = 0", "corank", "−0.070"))
    assert atlas.markdown().count("\n| ") == len(atlas)
    assert str(atlas) == atlas.markdown()
    latex = atlas.latex()
    assert latex.count(r"\\") == len(atlas) + 1
    assert r"$q_{2} \in \{0, \pi \}$" in latex
    assert [row["corank"] for row in atlas.records()] == [row.corank for row in atlas]


def test_settings_that_cannot_be_meant_are_refused():
    robot = rik.load("duleba_3r")
    with pytest.raises(InputError, match="starts must be"):
        find_singularities(robot, starts=0)
    with pytest.raises(InputError, match="corank must be 1 to 3"):
        find_singularities(robot, 4)
    with pytest.raises(InputError, match="rng must be"):
        find_singularities(robot, rng="today")
    with pytest.raises(InputError, match="method must be"):
        find_singularities(robot, method="magic")
    with pytest.raises(TipError):
        find_singularities(rik.load("anymal_b", whole_tree=True))
