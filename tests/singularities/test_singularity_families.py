"""The atlas of whole families of arms: every row singular, every fresh start accounted for, the same again."""

import json
from functools import cache

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.atlas.atlas_json import to_plain
from robust_ik.singularities.atlas.evidence import Completeness
from robust_ik.singularities.atlas.find_singularities import find_singularities
from robust_ik.singularities.conditions import relation_bases
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.dependent_angles import Circuit
from robust_ik.singularities.conditions.trig_relations import Factor, Relation
from robust_ik.singularities.families import coupled_joints
from robust_ik.singularities.families.degenerate_leaves import degenerate_leaves
from robust_ik.singularities.families.leaf import sound
from robust_ik.singularities.families.leaf_guesses import completed
from robust_ik.singularities.families.leaf_merging import joined
from robust_ik.singularities.families.leaf_survey import accounts

QUARTER = np.pi / 2
POSITION, FULL = ("x", "y", "z"), ("x", "y", "z", "wx", "wy", "wz")
REGULAR = 1e-6


def turning(a=0.0, d=0.0, alpha=0.0, theta=0.0):
    return rik.DHJoint(a=a, d=d, alpha=alpha, theta=theta)


def sliding(lower, upper, alpha=0.0, theta=0.0):
    return rik.DHJoint(a=0, d=0, alpha=alpha, theta=theta, kind="prismatic", lower=lower, upper=upper)


def structured(n, seed, rows=FULL):
    """An arm as people build them: twists of 0 or ±90°, half of the lengths zero."""
    rng = np.random.default_rng([seed, n, 1])

    def length():
        return round(float(rng.uniform(0.1, 0.6)), 3) * int(rng.integers(2))

    twists = [0, QUARTER, -QUARTER]
    joints = [turning(a=length(), d=length(), alpha=float(rng.choice(twists, p=[0.2, 0.4, 0.4]))) for _ in range(n)]
    return rik.DHTable(tuple(joints), "standard", rows=rows)


def generic(n, seed, rows=FULL):
    """An arm without any symmetry."""
    rng = np.random.default_rng([seed, n, 2])
    joints = [turning(*(float(x) for x in rng.uniform([0.1, -0.4, -2], [0.6, 0.4, 2]))) for _ in range(n)]
    return rik.DHTable(tuple(joints), "standard", rows=rows)


def planar(n, rows):
    """Parallel axes along world z, or along world y for rows of the x-z plane."""
    lengths = np.random.default_rng([n, 3]).uniform(0.2, 0.6, n)
    tilt = -QUARTER if "z" in rows else 0.0
    joints = [turning(a=float(a) * (i > 0), alpha=0.0 if i else tilt) for i, a in enumerate(lengths)]
    tool = np.eye(4)
    tool[0, 3] = 0.25
    return rik.DHTable(tuple(joints), "modified", rows=rows, tool=tool)


WRIST = (turning(alpha=-QUARTER), turning(alpha=QUARTER), turning(d=0.1))
SLIDING = {
    "scara": ((turning(0.4, 0.3), turning(0.3, alpha=np.pi), sliding(0, 0.3), turning()), ("x", "y", "z", "wz")),
    "prr": ((sliding(0, 1, -QUARTER), turning(0.4), turning(0.3)), POSITION),
    "prrr": ((sliding(-0.5, 1, -QUARTER), turning(0.1, 0.2, QUARTER), turning(0.4), turning(0.3)), POSITION),
    "cylindrical": ((turning(d=0.3), sliding(0, 0.5, -QUARTER), sliding(-0.3, 0.6)), POSITION),
    "cylindrical and wrist": ((turning(d=0.3), sliding(0, 0.5, -QUARTER), sliding(0.1, 0.6), *WRIST), FULL),
    "cartesian and wrist": (
        (sliding(0, 1, -QUARTER), sliding(0, 1, -QUARTER, -QUARTER), sliding(0, 1), *WRIST), FULL,
    ),
    "stanford": (
        (turning(d=0.4, alpha=-QUARTER), turning(d=0.15, alpha=QUARTER), sliding(-0.5, 0.8), *WRIST), FULL,
    ),
}  # fmt: skip
TABLES = {
    **{name: rik.DHTable(joints, "standard", rows=rows) for name, (joints, rows) in SLIDING.items()},
    **{f"planar {n} {''.join(rows)}": planar(n, rows) for n in (3, 4, 5, 6) for rows in (("x", "z", "wy"), ("x", "y"))},
    **{f"planar {n} xywz": planar(n, ("x", "y", "wz")) for n in (3, 5)},
    **{f"structured position {n}": structured(n, 1, POSITION) for n in (3, 4, 5, 6, 7)},
    **{f"generic position {n}": generic(n, 0, POSITION) for n in (3, 4, 5, 6)},
    **{f"structured {n}.{seed}": structured(n, seed) for n, seed in [(6, 1), (7, 1), (8, 0), (9, 1), (10, 2)]},
    **{f"generic {n}": generic(n, 0) for n in (7, 8)},
}
STARTS = 150
MORE_STARTS = {"structured 8.0": 400}  # 4 starts in 100 share four pieces; each needs three


@cache
def robot_of(name):
    return rik.Robot.from_dh(TABLES[name])


@cache
def atlas_of(name):
    return searched(name)


def searched(name):
    """With proofs for arms that slide and planar ones: of others, what random starts find is enough to look at."""
    proved = name in SLIDING or name.startswith("planar")
    return find_singularities(robot_of(name), starts=MORE_STARTS.get(name, STARTS), certify=proved)


def last_sigma(name, values, corank):
    """σ_{m−k+1}/σ₁ by Pinocchio, not by the chain that the atlas was made with."""
    robot, chain = robot_of(name), atlas_of(name).robot.chain
    s = svd(robot.jacobian(robot.configuration(values), rows=chain.rows)).s
    return s[..., chain.full_rank - corank] / s[..., 0]


def check_not_spurious(name, row, rng):
    """Random fills of the free joints are singular; with any other joint moved away they are not."""
    n = robot_of(name).n
    for leaf in row.leaves:
        members = leaf.filled(atlas_of(name).robot.chain, rng, 20)
        assert last_sigma(name, members, row.corank).max() < 1e-9, row.words
        for joint in set(range(n)) - set(row.free):
            away = members + rng.uniform(0.3, 1.0, (20, 1)) * np.eye(n)[joint]
            assert np.median(last_sigma(name, away, row.corank)) > REGULAR, (row.words, joint)


def check_dimension(name, row):
    """n less the number of conditions; a curve is at least one more."""
    conditions = len(row.conditions) + len(row.relations)
    if row.curve:
        assert len(row.free) <= row.dimension < robot_of(name).n - conditions
    else:
        assert row.dimension == robot_of(name).n - conditions


# ------------------------------------------------------------------------------------------------ whole families
@pytest.mark.parametrize("name", TABLES)
def test_no_row_is_spurious_none_is_missing_and_dimensions_count_conditions(name):
    rng = np.random.default_rng(7)
    for row in atlas_of(name):
        check_not_spurious(name, row, rng)
        check_dimension(name, row)
    assert all(evidence.fresh > 0 and evidence.unmatched == 0 for evidence in atlas_of(name).evidence)


@pytest.mark.parametrize(
    "name", ["cylindrical and wrist", "structured position 6", "generic position 3", "planar 4 xy"]
)
def test_the_same_seed_gives_the_same_atlas(name):
    again = searched(name)
    assert json.dumps(to_plain(again)) == json.dumps(to_plain(atlas_of(name)))


# ------------------------------------------------------------------------------------------------ single findings
def test_planar_arms_are_singular_where_all_links_are_in_line():
    for n in (3, 4, 5, 6):
        (row,) = atlas_of(f"planar {n} xy").strata
        assert row.words == " and ".join(f"q{i} ∈ {{0, π}}" for i in range(2, n + 1))
        assert (row.dimension, row.components) == (1, 2 ** (n - 1))
        # With the orientation as a third row the last link may point anywhere.
        (row,) = atlas_of(f"planar {n} xzwy").strata
        assert row.components == 2 ** (n - 2)


def test_a_folded_stratum_of_an_arm_that_slides_is_read_with_all_its_values():
    rows = {row.words: (row.dimension, row.components) for row in atlas_of("stanford").of_corank(2)}
    assert rows["q3 = 0 m and q4 ∈ {0, π} and q5 ∈ {0, π}"] == (3, 4)


def test_a_folded_stratum_may_pin_a_sum_of_parallel_joints_and_a_value_that_is_no_special_angle():
    folded = [leaf for row in atlas_of("structured position 7") for leaf in row.leaves if _is_folded_form(leaf)]
    assert len(folded) == 8
    assert {len(leaf.pins) for leaf in folded} == {3}


def _is_folded_form(leaf):
    """Pins of q3, q5 and q6 + q7: ∂r/∂q is no help along them."""
    return [str(pin.angle) for pin in leaf.pins] == ["q3", "q5", "q6 + q7"]


def test_values_that_no_start_met_are_found_by_mirroring():
    atlas = atlas_of("stanford")
    chain, rng = atlas.robot.chain, np.random.default_rng(0)
    row = next(row for row in atlas.of_corank(2) if row.components == 8)
    one = row.leaves[0]
    assert len(joined(completed(chain, [one], rng))) == 8


def test_a_guess_that_is_not_singular_is_not_taken():
    atlas = atlas_of("scara")
    (row,) = atlas.strata
    chain = atlas.robot.chain
    assert len(completed(chain, list(row.leaves), np.random.default_rng(0))) == len(row.leaves)


@pytest.mark.slow
def test_the_stand_in_10_axis_arm_has_no_unaccounted_start_at_corank_1():
    atlas = find_singularities(rik.load("srs_10r"), 1, starts=300, certify=False)
    assert atlas.evidence[0].unmatched == 0
    assert all(not row.curve for row in atlas)
    words = {row.words: row.dimension for row in atlas}
    assert words["q4 ∈ {0, π} and q6 ∈ {0, π} and q8 ∈ {0, π}"] == 7
    assert words["q4 ∈ {0, π} and q6 ∈ {0, π} and q9 = ±π/2"] == 7


def test_points_off_every_leaf_are_not_accounted_for():
    atlas = atlas_of("structured position 7")
    chain = atlas.robot.chain
    leaves = [leaf for row in atlas.of_corank(1) for leaf in row.leaves]
    kept = [leaf for leaf in leaves if not _is_folded_form(leaf)]
    lost = np.concatenate([leaf.filled(chain, np.random.default_rng(0), 5) for leaf in leaves if _is_folded_form(leaf)])
    assert accounts(chain, 1, leaves, lost).all()
    assert not accounts(chain, 1, kept, lost).any()
    found = degenerate_leaves(chain, lost, 1, np.random.default_rng(0))
    assert all(sound(chain, leaf, np.random.default_rng(0)) for leaf in found)
    assert accounts(chain, 1, found, lost).all()


# ------------------------------------------------------------------------------------------------ coupled joints
@pytest.mark.slow
def test_a_relation_is_not_told_twice_with_other_joints_set_free():
    """Once q2 and q6 were let go since one relation of q4 and q5 seemed to be two."""
    robot = rik.Robot.from_dh(structured(6, 5, ("x", "y", "z", "wz")))
    atlas = find_singularities(robot, 1, starts=400)
    (row,) = [row for row in atlas if [str(each.angle) for each in row.conditions] == ["q3"]]
    assert (row.dimension, row.free) == (3, (0,))
    assert len(row.relations) == 1
    assert atlas.evidence[0].unmatched == 0


@pytest.mark.parametrize("odd", [False, True])
def test_larger_circuits_are_left_out_only_where_none_of_them_can_be_shorter(odd, monkeypatch):
    """On the srs_10r relations of corank 2 join three of five coupled joints; four are joined by what follows."""
    robot, met = rik.load("srs_10r"), 0
    conditions, leaves_out = coupled_joints._conditions, relation_bases.fewest_terms

    def both(groups, values, normals, count, **options):
        nonlocal met
        quick = conditions(groups, values, normals, count, odd=odd)
        with monkeypatch.context() as patch:
            patch.setattr(coupled_joints, "fewest_terms", lambda size, *, odd: -1)
            slow = conditions(groups, values, normals, count, odd=odd)
        assert [group for group, _ in quick] == [group for group, _ in slow]
        assert [each and each.terms for _, each in quick] == [each and each.terms for _, each in slow]
        met += len(groups) > 0 and len(quick) > 0 and quick[0][1] is not None
        return conditions(groups, values, normals, count, **options)

    monkeypatch.setattr(coupled_joints, "_conditions", both)
    find_singularities(robot, 2, starts=60, certify=False)
    assert met
    assert leaves_out(3, odd=odd) == 1
    assert leaves_out(4, odd=odd) == (1 if odd else 4)


@pytest.mark.slow
def test_sums_that_other_sums_add_up_to_are_no_conditions():
    robot = rik.Robot.from_dh(structured(10, 5))
    atlas = find_singularities(robot, 1, starts=80, certify=False)
    for row in atlas:
        angles = [each.angle.row(robot.n) for each in row.conditions]
        assert np.linalg.matrix_rank(np.array(angles)) == len(angles)


@pytest.mark.parametrize(
    "name, row, pieces",
    [("planar_2r", "x", 4), ("planar_3r", "x", 8), ("duleba_3r", "z", 4), ("puma560", "wz", 0)],
)
def test_where_the_whole_jacobian_vanishes_is_a_singularity_too(name, row, pieces):
    """In a single task row σ₁ is the only σ: next to itself it is never small."""
    robot = rik.load(name)
    atlas = find_singularities(robot, rows=[row], starts=100)
    assert sum(each.components for each in atlas) == pieces
    assert atlas.evidence[0].status is Completeness.CERTIFIED
    for each in atlas:
        assert np.abs(robot.jacobian(robot.configuration(each.samples), rows=[row])).max() < 1e-9


@pytest.mark.parametrize("small, large, told", [(7, 5, 5), (5, 7, 5), (4, 2, 4), (None, 6, 6)])
def test_a_larger_circuit_is_chosen_where_its_relation_is_shorter(small, large, told, monkeypatch):
    """Circuits of three and of four angles for one condition; four angles have four terms at least."""
    turns = [Angle((joint,), (1,), 2 * np.pi) for joint in range(4)]
    groups = [[Circuit(tuple(turns[:size]), np.eye(4)[None, size - 1])] for size in (3, 4)]
    asked = []

    def found(tried, values, **_):
        (((*angles,),),) = tried
        asked.append(len(angles))
        terms = small if len(angles) == 3 else large
        return [
            terms
            and Relation(tuple((Factor(each, "cos", 1.0),) for each in (angles * 3)[:terms]), np.ones(terms), 0, 9)
        ]

    monkeypatch.setattr(coupled_joints, "simplest_each", found)
    monkeypatch.setattr(coupled_joints, "_own", lambda group, relation: relation)
    ((_, relation),) = coupled_joints._conditions(groups, np.zeros((9, 4)), [], 1)
    assert len(relation.terms) == told
    assert asked == ([3] if small == 4 else [3, 4])
