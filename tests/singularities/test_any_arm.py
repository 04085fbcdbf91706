"""The atlas of arms as they are really met: few joints, any size, any mount, long slides, rounded numbers."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import robust_ik as rik
from robust_ik.kinematics.svd import whole_svd
from robust_ik.singularities.atlas.evidence import Completeness
from robust_ik.singularities.conditions.angle_sums import Angle, brought
from robust_ik.singularities.families.leaf import Leaf, Pin, verified
from robust_ik.singularities.families.leaf_survey import Survey
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.geometry import straightening
from robust_ik.singularities.geometry.coincidence_tolerance import Tolerance
from robust_ik.singularities.geometry.line_arm import LineArm, made_parallel
from robust_ik.singularities.geometry.screw_chain import ScrewChain, axes_at_zero
from robust_ik.singularities.geometry.straightening import straightened
from robust_ik.singularities.lost_motion import sides
from tests.arms import LIFT, arm_of, times, ur5

DATA = Path(__file__).parents[1] / "data"
STARTS = 200
RIGHT = float(np.pi / 2)


@cache
def case(name, starts=STARTS, **how):
    return rik.find_singularities(rik.load(DATA / f"{name}.urdf", **how), starts=starts)


def rows(atlas, corank=1):
    return [row.words for row in atlas.of_corank(corank)]


def is_certified(atlas):
    return all(each.status is Completeness.CERTIFIED for each in atlas.evidence)


# ----------------------------------------------------------------------------------------------- few joints
@pytest.mark.parametrize("name", ["pan_tilt", "pan_tilt_centred", "one_r", "one_p", "gantry3p"])
def test_arms_whose_joints_always_move_the_tip_have_no_singularities(name):
    atlas = case(name)
    assert len(atlas) == 0
    assert is_certified(atlas)
    assert "its corank is" in atlas.explanation


@pytest.mark.parametrize("name", ["gimbal_3r", "gimbal_turned_mount"])
def test_a_gimbal_locks_at_a_right_angle_whatever_its_mount(name):
    atlas = case(name)
    assert rows(atlas) == ["q2 = ±π/2"]
    assert [row.dimension for row in atlas] == [2]
    assert is_certified(atlas)


def test_a_scara_is_singular_where_its_arm_is_straight():
    atlas = case("scara")
    assert rows(atlas) == ["q2 ∈ {0, π}"]
    assert is_certified(atlas)
    assert atlas.strata[0].lost.words == "pure force"


def test_an_arm_of_five_joints_has_its_elbow_and_all_else_where_its_six_rows_lose_rank():
    atlas = case("five_dof")
    assert rows(atlas) == ["q3 = ±π/2", "q2 − q4 = 0 and q2 + q3 + q4 = −π/2", "q2 − q4 = π and q2 + q3 + q4 = π/2"]
    assert is_certified(atlas)
    robot = rik.load(DATA / "five_dof.urdf")
    for row in atlas:
        s = np.linalg.svd(robot.jacobian(robot.configuration(row.samples)), compute_uv=False)
        assert (s[:, robot.n - row.corank] < 1e-9 * s[:, 0]).all()
    anywhere = np.linalg.svd(robot.jacobian(robot.random(np.random.default_rng(0), 500)), compute_uv=False)
    assert (anywhere[:, -1] > 1e-6 * anywhere[:, 0]).mean() > 0.99


FIVE_JOINTS = {
    "youbot": [(0.033, 0.147, 90), (0.155, 0, 0), (0.135, 0, 0), (0, 0, 90), (0, 0.2175, 0)],
    "widowx": [(0.05, 0.127, 90), (0.2, 0, 0), (0.15, 0, 0), (0, 0, 90), (0, 0.12, 0)],
}
"""a, d, α° of arms of five joints: a shoulder, parallel axes, a wrist that turns."""


@pytest.mark.parametrize("name", FIVE_JOINTS)
def test_arms_of_five_joints_have_an_elbow_and_a_wrist_over_their_first_axis(name):
    joints = tuple(rik.DHJoint(a=a, d=d, alpha=np.radians(turn)) for a, d, turn in FIVE_JOINTS[name])
    atlas = rik.find_singularities(rik.Robot.from_dh(rik.DHTable(joints, "standard")), starts=STARTS)
    elbow, wrist = atlas.of_corank(1)
    assert elbow.words == "q3 ∈ {0, π}"
    assert "q2 + q3 + q4 ∈ {0, π}" in wrist.words
    assert wrist.dimension == 3
    assert atlas.evidence[0].status is Completeness.CERTIFIED


@pytest.mark.parametrize("name", ["so100", "so101"])
def test_hobby_arms_of_five_joints_have_an_elbow_and_a_wrist(name):
    atlas = rik.find_singularities(rik.load(name), 1, starts=STARTS)
    assert atlas.robot.chain.n == 5
    assert [row.dimension for row in atlas] == [4, 3]
    assert atlas.strata[0].words.startswith("q3 ∈ {")
    assert atlas.strata[1].words.startswith("q2 + q3 + q4")
    assert atlas.evidence[0].status is Completeness.CERTIFIED


def test_what_few_joints_lose_comes_back_as_they_leave():
    """Every lost direction is a force that does no work in any motion there, but does as some joint moves on."""
    robot, atlas = rik.load(DATA / "five_dof.urdf"), case("five_dof")
    for row in atlas:
        lost = row.lost.example
        q = robot.configuration(row.lost.values)
        np.testing.assert_allclose(lost.twists.T @ robot.jacobian(q), 0, atol=1e-9)
        np.testing.assert_allclose(robot.jacobian(q) @ lost.self_motions, 0, atol=1e-9)
        assert lost.self_motions.shape == (robot.n, row.corank)
        change = np.einsum("ir,ijk,jm->rmk", lost.twists, robot.hessian(q), lost.self_motions)
        assert (np.abs(change).max(axis=(1, 2)) > 1e-3).all()


def test_rows_that_are_asked_for_are_analysed_as_before():
    robot = rik.load(DATA / "scara.urdf")
    atlas = rik.find_singularities(robot, rows=("x", "y", "z"), starts=STARTS)
    assert atlas.robot.chain.rows == ("x", "y", "z")
    assert rows(atlas) == ["q2 ∈ {0, π}"]


# ----------------------------------------------------------------------------------------------- size and place
@pytest.mark.parametrize("size", [7e-7, 1e-6, 1e-3, 0.01, 30.0, 1e6])
def test_rows_words_and_proofs_are_the_same_at_any_size(size):
    one, other = (rik.find_singularities(ur5(each), starts=STARTS) for each in (1.0, size))
    assert [(row.corank, row.words, row.lost.words) for row in one] == [
        (row.corank, row.words, row.lost.words) for row in other
    ]
    assert [each.status for each in one.evidence] == [each.status for each in other.evidence]


def shaped(atlas, size):
    """The rows of an arm of this size: of coefficients, which are lengths, the number, and values of slides by size."""

    def valued(each):
        return str(each.angle), tuple(np.round(np.divide(each.values, 1.0 if each.angle.circular else size), 6) + 0.0)

    return [
        (row.corank, row.dimension, row.components, row.lost.words, row.within_limits, len(row.inside),
         [valued(each) for each in row.conditions], [[str(each.angles), len(each.terms)] for each in row.relations])
        for row in atlas
    ]  # fmt: skip


@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.005, 30.0, 1e6])
def test_rows_and_proofs_of_arms_that_slide_are_the_same_at_any_size(size, tmp_path):
    """A slide of a millimetre moves the joints of a tiny arm as far as a metre those of a large one."""
    one, other = (rik.find_singularities(arm_of(LIFT, "0.1 0 0", each), starts=STARTS) for each in (1.0, size))
    assert shaped(one, 1.0) == shaped(other, size)
    assert any("q2 = −0.15" in row.words for row in one)
    assert [each.status for each in one.evidence] == [each.status for each in other.evidence]
    robot = arm_of(LIFT, "0.1 0 0", size)
    for row in other:
        J = robot.jacobian(robot.configuration(row.samples))
        J[:, :3] /= size
        J[:, :, 1] *= size
        s = np.linalg.svd(J, compute_uv=False)
        assert (s[:, 6 - row.corank] < 1e-9).all()
        assert (s[:, 5 - row.corank] > 1e-6).all()
        assert row.off < 1e-8
        for values in row.inside:
            assert set(values) <= {value for each in row.conditions for value in each.values}
        for relation in row.relations:
            np.testing.assert_allclose(relation.of(row.samples), 0, atol=1e-6)
    assert rik.SingularityAtlas.load(other.save(tmp_path / "atlas.json")).markdown() == other.markdown()


def follower(size, kind, tmp_path):
    """Four joints, the third of which follows the second: a slide a turn, as a screw does, or a turn a slide."""
    turns = '<limit lower="-3" upper="3" velocity="1" effort="1"/>'
    slides = f'<limit lower="{-size!r}" upper="{size!r}" velocity="1" effort="1"/>'
    leads = kind == "screw"
    second = ("revolute", turns) if leads else ("prismatic", slides)
    third = ("prismatic", slides, 0.05 * size) if leads else ("revolute", turns, 2 / size)
    mimic = f'<mimic joint="q2" multiplier="{third[2]!r}"/>'
    lines = [
        ("revolute", "0 0 0.3", "0 0 1", turns), (second[0], "0.4 0 0", "0 1 0", second[1]),
        (third[0], "0.2 0.1 0", "1 0 0", third[1] + mimic), ("revolute", "0.1 0 0.3", "0 1 0", turns),
        ("fixed", "0.1 0 0.25", "0 0 1", ""),
    ]  # fmt: skip
    joints = "".join(
        f'<joint name="q{i}" type="{what}"><parent link="l{i - 1}"/><child link="l{i}"/>'
        f'<origin xyz="{times(origin, size)}"/><axis xyz="{axis}"/>{rest}</joint>'
        for i, (what, origin, axis, rest) in enumerate(lines, 1)
    )
    path = tmp_path / "follower.urdf"
    links = "".join(f'<link name="l{i}"/>' for i in range(6))
    path.write_text(f'<robot name="r">{links}{joints}</robot>')
    return rik.load(path, tip="l5")


@pytest.mark.parametrize("kind", ["screw", "wheel"])
@pytest.mark.parametrize("size", [2.0**-13, 2.0**14])
def test_slides_that_turn_others_and_screws_have_the_rows_of_the_same_arm_at_any_size(kind, size, tmp_path):
    one, other = (
        rik.find_singularities(follower(each, kind, tmp_path), starts=STARTS, rows=("x", "y", "z"), certify=False)
        for each in (1.0, size)
    )
    assert len(one) > 0
    assert other.robot.chain.rows == one.robot.chain.rows
    assert [(row.corank, row.dimension, row.lost.words) for row in one] == [
        (row.corank, row.dimension, row.lost.words) for row in other
    ]
    np.testing.assert_allclose(one.robot.chain.upper, other.robot.chain.upper / [1, 1 if kind == "screw" else size, 1])


def test_a_screw_of_many_turns_is_searched_within_one(tmp_path):
    robot = follower(1.0, "screw", tmp_path)
    text = Path(robot.description.file).read_text().replace('lower="-3" upper="3"', 'lower="-99" upper="99"')
    text = text.replace('lower="-1.0" upper="1.0"', 'lower="-99" upper="99"')
    path = tmp_path / "many.urdf"
    path.write_text(text)
    np.testing.assert_allclose(ScrewChain.of(rik.load(path, tip="l5")).upper, np.pi)


def test_the_nearest_singularity_and_curves_of_a_tiny_arm_are_those_of_a_large_one():
    one, other = (
        rik.find_singularities(arm_of(LIFT, "0.1 0 0", each), 2, starts=STARTS, certify=False) for each in (1.0, 1e-3)
    )
    q = np.array([0.3, 0.2, 1.0, 0.4, -0.5, 0.9, 0.1])
    sizes = np.array([1, 1e-3, 1, 1, 1, 1, 1])
    for row, same in zip(one, other):
        (way,) = [each for each in one.distances(q) if each.stratum is row]
        (short,) = [each for each in other.distances(q * sizes) if each.stratum is same]
        np.testing.assert_allclose(short.values / sizes, way.values, atol=0.3)  # slides weigh half as much
        assert short.sigma[-1] < 1e-6 * short.sigma.max()
        np.testing.assert_allclose(short.path[0], q * sizes)
        if row.curve or row.relations:
            assert one.curves(row)
            assert other.curves(same)
            for relation in same.relations:
                points = np.concatenate([curve.values for curve in other.curves(same)])
                np.testing.assert_allclose(relation.of(points), 0, atol=1e-6)
    again = other.extended(60)
    assert [row.words for row in again][: len(other)] == [row.words for row in other]


def test_a_tiny_arm_has_the_families_of_the_same_arm_at_full_size():
    tiny = case("tiny_arm_mm")
    assert [len(tiny.of_corank(k)) for k in (1, 2)] == [3, 7]
    assert is_certified(tiny)


def test_a_mount_changes_nothing():
    joints = [
        ("0 0 0.1", "0 0 0", "0 0 1", -3, 3), ("0.05 0 0.1", "0 0 0", "0 1 0", -3, 3),
        ("0 0 0.4", "0 0 0", "0 1 0", -3, 3), ("0 0 0.3", "0 0 0", "0 1 0", -3, 3),
        ("0 0 0.1", "0 0 0", "0 0 1", -3, 3),
    ]  # fmt: skip
    turned = [("0.3 -0.1 0.1", "0.5235987755982988 0 0.7853981633974483", *joints[0][2:]), *joints[1:]]
    one, other = (rik.find_singularities(arm_of(each, "0 0 0.1"), starts=STARTS) for each in (joints, turned))
    assert [row.words for row in one] == [row.words for row in other]
    assert len(one) > 0


@pytest.mark.parametrize("name", ["mobile_drive_1000", "mobile_drive_999999"])
def test_a_slide_of_kilometres_has_the_families_of_one_of_five_metres(name, tmp_path):
    text = (DATA / "mobile_drive_1000.urdf").read_text()
    assert text.count('"-1000') == text.count('"1000') == 1
    near = tmp_path / "near.urdf"
    near.write_text(text.replace('"-1000', '"-5').replace('"1000', '"5'))
    wanted = rik.find_singularities(rik.load(near), 1, certify=False)
    found = rik.find_singularities(rik.load(DATA / f"{name}.urdf"), 1, certify=False)
    assert len(wanted) == 8
    assert rows(found) == rows(wanted)
    assert not found.robot.reduced


def test_what_only_rounding_moves_is_nothing_to_lose():
    atlas = case("lift_and_telescope")
    assert atlas.robot.chain.m == 6
    assert atlas.robot.chain.full_rank < atlas.robot.chain.n
    assert len(atlas) == 0


def test_an_arm_on_a_torso_is_analysed():
    atlas = case("torso_and_arm_8r", starts=100)
    assert len(atlas.of_corank(1)) > 0
    assert all(each.status is not Completeness.INTERRUPTED for each in atlas.evidence)


# ----------------------------------------------------------------------------------------------- rounded numbers
def test_rounded_lengths_are_told_and_the_meant_families_found_with_how_near_the_model_comes():
    atlas = case("lengths_rounded_6r", starts=500)
    assert "q5 ∈ {0, π}" in rows(atlas)
    assert atlas.evidence[0].status is Completeness.CERTIFIED
    assert "q6: lengths changed by 1e-07 m" in atlas.explanation
    (wrist,) = [row for row in atlas if row.words == "q5 ∈ {0, π}"]
    assert 1e-9 < wrist.off < 1e-6


@pytest.mark.parametrize("digits", [5, 6, 7])
def test_an_arm_with_rounded_lengths_and_angles_has_the_rows_of_the_exact_one(digits):
    joints = [
        ("0 0 0.6718", "0 0 0", "0 0 1", -3, 3),
        ("0 0.1397 0", f"{-RIGHT} 0 0", "0 0 1", -3, 3),
        ("0.4318 0 0", "0 0 0", "0 0 1", -3, 3),
        ("0.0203 -0.4331234 0", f"{RIGHT} 0 0", "0 0 1", -3, 3),
        ("0 0.0000004 0", f"{-RIGHT} 0 0", "0 0 1", -3, 3),
        ("0 0 0", f"{RIGHT} 0 0", "0 0 1", -3, 3),
    ]
    rounded = [
        (*(" ".join(str(round(float(word), digits)) for word in text.split()) for text in line[:2]), *line[2:])
        for line in joints
    ]
    one, other = (rik.find_singularities(arm_of(each, "0 0 0.1"), starts=STARTS) for each in (joints, rounded))
    assert [(row.corank, row.dimension, len(row.conditions)) for row in one] == [
        (row.corank, row.dimension, len(row.conditions)) for row in other
    ]
    assert "q5 ∈ {0, π}" in rows(one)
    assert "q5 ∈ {0, π}" in rows(other)


@pytest.mark.parametrize("name", ["panda", "ur5", "puma560", "kinova_gen3", "pa10"])
def test_an_arm_by_its_common_normals_has_its_axes(name):
    robot = rik.load(name)
    chain = ScrewChain.of(robot)
    axes, points = axes_at_zero(chain.rotations, chain.offsets)
    frames = LineArm.of(axes, points, robot.pose(robot.neutral)[:3, 3]).frames
    np.testing.assert_allclose(frames[:, :3, 2], axes, atol=1e-12)
    apart = np.cross(frames[:, :3, 3] - points, axes)
    np.testing.assert_allclose(apart, 0, atol=1e-12)


def test_near_lengths_become_alike_and_nothing_else_changes():
    rng = np.random.default_rng(0)
    turns = Rotation.random(6, random_state=1).as_matrix()
    arm = LineArm.of(turns[:, :, 2], rng.normal(size=(6, 3)), rng.normal(size=3))
    same, changes = arm.evened(Tolerance(1e-9, 1e-9, 1e-9))
    assert max(max(each) for each in changes) < 1e-12
    np.testing.assert_allclose(same.frames, arm.frames, atol=1e-9)


def test_right_angles_with_eleven_decimals_are_exact_and_no_word_is_said():
    """The UR5's file has 1.57079632679: along double factors of minors σ would be 1e-12, where it is zero."""
    robot = rik.load("ur5")
    axes, _ = axes_at_zero(ScrewChain.of(robot).rotations, ScrewChain.of(robot).offsets)
    assert 1e-13 < np.abs(axes - np.round(axes)).max() < 1e-10
    atlas = rik.find_singularities(robot, 1, rows=("z", "wx", "wy"), starts=STARTS, certify=False)
    assert atlas.evidence[0].unexplained == 0
    assert "q2 = ±π/2 and q3 ∈ {0, π} and q4 = ±π/2" in rows(atlas)
    assert not atlas.robot.changes
    assert atlas.robot.given is atlas.robot.chain


# ------------------------------------------------------------------------------------ angles that share joints
def test_angles_that_share_joints_are_brought_to_their_values_together():
    rng = np.random.default_rng(0)
    angles = [Angle((1, 3), (1, -1), 2 * np.pi), Angle((1, 2, 3), (1, 1, 1), 2 * np.pi), Angle((4,), (1,), np.inf)]
    to = np.array([0.3, -2.0, 0.5])
    found = brought(rng.normal(size=(50, 5)) * 4, angles, to)
    for angle, value in zip(angles, to):
        np.testing.assert_allclose(angle.wrapped(angle.of(found) - value), 0, atol=1e-12)


def test_an_angle_that_others_determine_is_left_as_it_is():
    angles = [Angle((0,), (1,), 2 * np.pi), Angle((1,), (1,), 2 * np.pi), Angle((0, 1), (1, 1), 2 * np.pi)]
    found = brought(np.zeros((1, 2)), angles, np.array([0.1, 0.2, 9.0]))
    np.testing.assert_allclose(found, [[0.1, 0.2]])


@pytest.mark.parametrize("short", [1e-3, 1e-5, 1e-6])
def test_a_family_that_is_nearly_a_point_has_its_relation(short):
    """The arm reaches its first axis only where it is nearly stretched: the last digit of its lengths counts."""
    lengths = (0.5 - short, 0.2, 0.3)
    joints = [rik.DHJoint(a=a, d=0.0, alpha=turn) for a, turn in zip(lengths, (RIGHT, 0.0, 0.0))]
    robot = rik.Robot.from_dh(rik.DHTable(tuple(joints), "standard"))
    atlas = rik.find_singularities(robot, 1, rows=("x", "y", "z"), starts=500)
    (relation,) = [row.relations[0] for row in atlas if row.relations]
    np.testing.assert_allclose(relation.coefficients * lengths[0], lengths, rtol=1e-3 if short < 1e-5 else 1e-6)
    assert "no short relation" not in atlas.markdown()


# ------------------------------------------------------------------------------------ how it is written
def test_names_in_latex_have_subscripts():
    latex = case("five_dof").latex()
    assert r"$q_{2} - q_{4} = 0$, $q_{2} + q_{3} + q_{4} = -\pi /2$" in latex
    latex = case("lengths_rounded_6r", starts=500).latex()
    assert "s_{2}" in latex
    assert "c_{2-3}" in latex


# ------------------------------------------------------------------------------------ nothing is moved far
NEARLY = "0.932039 0.362362 0.000010"


@pytest.mark.parametrize("axis", ["0.93204 0.36236 0", NEARLY, "0.93205 0.36235 0", "-0.932039 -0.362362 0.00001"])
def test_axes_that_are_parallel_but_for_rounding_stay_where_they_are(axis):
    """Their common normal is kilometres away: it must not be taken for how far they are apart."""

    def shoulder(third):
        lines = [("0 0 0", "0 0 1"), ("0 0 0.3", "0.93204 0.36236 0"), ("0.1 0 0.4", third)]
        return arm_of([(origin, "0 0 0", each, -3.0, 3.0) for origin, each in lines], "0.1 0 0.3")

    wanted = rik.find_singularities(shoulder("0.93204 0.36236 0"), 1, starts=60, rows=("x", "y", "z"))
    found = rik.find_singularities(shoulder(axis), 1, starts=60, rows=("x", "y", "z"))
    elbow = [np.sort(row.conditions[0].values) for atlas in (wanted, found) for row in atlas if "q3 ∈" in row.words]
    sign = -1 if axis.startswith("-") else 1
    np.testing.assert_allclose(np.sort(sign * elbow[1]), elbow[0], atol=1e-3)


def test_straightened_arms_move_as_the_model_does():
    rng = np.random.default_rng(4)
    for _ in range(40):
        way = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()[0]
        second, third = (" ".join(f"{x:.{digits}f}" for x in way) for digits in (6, 5))
        lines = [("0 0 0.1", "0 0 1"), ("0.1 0 0.2", second), ("0.1 0.2 0.4", third), ("0 0.1 0.3", "1 0 0")]
        robot = arm_of([(origin, "0 0 0", axis, -3.0, 3.0) for origin, axis in lines], "0.1 0 0.3")
        chain, _, _ = straightened(robot, ScrewChain.of(robot))
        values = chain.random(rng, 8)
        apart = chain.jacobian(values) - robot.jacobian(robot.configuration(values))
        assert np.abs(apart).max() < 1e-3


def test_a_row_has_the_dimension_that_its_conditions_leave(tmp_path):
    lines = [("0 0 0", "0 0 1"), ("0 0 1", "1 0 0"), ("0 0 1", "1 0 0")]
    for size in (1e-4, 1e-3, 3e-3, 0.03, 1.0):
        robot = arm_of([(origin, "0 0 0", axis, -3.0, 3.0) for origin, axis in lines], "0 0 1", size)
        atlas = rik.find_singularities(robot, starts=60, rows=("x",))
        assert len(atlas) == 4
        assert rik.SingularityAtlas.load(atlas.save(tmp_path / "atlas.json")).markdown() == atlas.markdown()


def test_what_comes_after_nearly_parallel_axes_turns_as_a_whole():
    rng = np.random.default_rng(2)
    axes = Rotation.random(5, random_state=3).as_matrix()[:, :, 2]
    axes[2] = axes[1] + 5e-5 * np.cross(axes[1], axes[0])
    axes[2] /= np.linalg.norm(axes[2])
    points, tip = rng.normal(size=(5, 3)), rng.normal(size=3)
    new, at, end, turns = made_parallel(axes, points, tip, 1e-4)
    np.testing.assert_array_equal(new[2], new[1])
    assert [turn > 0 for turn in turns] == [False, True, False, False]
    for j, k in ((2, 3), (3, 4), (2, 4)):
        assert new[j] @ new[k] == pytest.approx(axes[j] @ axes[k], abs=1e-12)
        assert (at[k] - at[2]) @ new[j] == pytest.approx((points[k] - points[2]) @ axes[j], abs=1e-12)
    assert (end - at[2]) @ new[4] == pytest.approx((tip - points[2]) @ axes[4], abs=1e-12)


def test_a_geometry_that_moves_otherwise_than_the_model_is_not_taken(monkeypatch):
    lines = [("0 0 0", "0 0 1"), ("0 0 0.3", "0.93204 0.36236 0"), ("0.1 0 0.4", NEARLY)]
    robot = arm_of([(origin, "0 0 0", axis, -3.0, 3.0) for origin, axis in lines], "0.1 0 0.3")
    monkeypatch.setattr(straightening, "made_parallel", lambda *given: (*given[:3], [0.0] * 2))
    chain, changes, exact = straightening.straightened(robot, ScrewChain.of(robot))
    assert (changes, exact) == ((), None)
    values = chain.random(np.random.default_rng(0), 4)
    np.testing.assert_allclose(chain.jacobian(values), robot.jacobian(robot.configuration(values)), atol=1e-9)


# ------------------------------------------------------------------------------------ the search itself
@pytest.mark.parametrize(("name", "corank"), [("five_dof", 1), ("five_dof", 2), ("scara", 2), ("gimbal_3r", 1)])
def test_the_residual_of_few_joints_is_differentiated(name, corank):
    chain = ScrewChain.of(rik.load(DATA / f"{name}.urdf"))
    values = chain.random(np.random.default_rng(1), 3)
    at = Residual.at(chain, values, corank)
    found = whole_svd(chain.jacobian(values))
    left, right = found.U[:, :, chain.n - corank :], found.Vt[:, chain.n - corank :]

    def block(q):
        return (np.swapaxes(left, 1, 2) @ chain.jacobian(q) @ np.swapaxes(right, 1, 2)).swapaxes(1, 2).reshape(3, -1)

    np.testing.assert_allclose(at.vector, block(values), atol=1e-12)
    step = 1e-6
    for joint in range(chain.n):
        moved = step * np.eye(chain.n)[joint]
        slope = (block(values + moved) - block(values - moved)) / (2 * step)
        np.testing.assert_allclose(at.derivative[..., joint], slope, atol=1e-8)


def test_an_arm_that_never_has_full_rank_is_analysed_in_all_rows():
    joints = tuple(
        rik.DHJoint(a=a, d=d, alpha=np.radians(turn)) for a, d, turn in [(0, 0, 0), (0, 0.21, -90), (0.16, 0, -90)]
    )
    atlas = rik.find_singularities(rik.Robot.from_dh(rik.DHTable(joints, "standard")), starts=60)
    assert "its 3 joints never move the tip in more than two of six ways" in atlas.explanation
    assert "one motion of joint1 and joint2 never moves it; its corank is 2 − rank" in atlas.explanation
    assert atlas.robot.chain.m == 6


def test_a_leaf_without_members_is_no_leaf():
    chain = ScrewChain.of(rik.load(DATA / "scara.urdf"))
    pin = Pin(Angle((1,), (1,), 2 * np.pi), 0.0)
    leaf = Leaf(1, 3, (pin,), (), (0, 2, 3), (), np.zeros((0, 4)))
    assert verified(chain, [leaf], np.random.default_rng(0)) == [False]


def test_points_that_nothing_explains_are_an_estimate_not_an_interruption(monkeypatch):
    nothing = lambda chain, corank, values, rng, **_: Survey((), np.zeros(len(values), bool), 0)  # noqa: E731
    monkeypatch.setattr("robust_ik.singularities.atlas.corank_search.survey", nothing)
    atlas = rik.find_singularities(rik.load("planar_2r"), 1, starts=50, certify=False)
    assert atlas.evidence[0].found > 0
    assert atlas.evidence[0].status is Completeness.ESTIMATE
    assert "interrupted" not in atlas.explanation
    assert "below 100 %" in atlas.explanation


@pytest.mark.parametrize(("low", "high", "expected"), [(0, 0, 0), (-5e-18, 2.0, 1), (-2.0, 5e-18, 1), (-1.0, 1.0, 2)])
def test_curvatures_of_rounding_lead_to_no_side(low, high, expected):
    assert sides(low, high) == expected
