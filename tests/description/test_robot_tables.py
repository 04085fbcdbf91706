from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy import cos, pi, sin
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.dh.dh_toml import read_dh
from robust_ik.description.dh.dh_urdf import dh_to_urdf
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS

ROBOTS = Path(__file__).parents[2] / "robots"
FILES = sorted(ROBOTS.glob("*/*.toml"))
OURS = (
    "almarkhi_4dof",
    "duleba_3r",
    "pa10",
    "planar_2r",
    "planar_3r",
    "puma560",
    "puma560_corke",
    "srs_7r",
    "srs_10r",
)
every_file = pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)


def table(name):
    return read_dh(ROBOTS / name / f"{name}.toml")


def task_jacobian(arm, q):
    return arm.jacobian(q)[..., [ROWS.index(row) for row in arm.rows], :]


def coranks(arm, q):
    return svd(task_jacobian(arm, q)).corank(1e-9)


def configurations(arm, count=50, seed=0):
    return np.random.default_rng(seed).uniform(-pi, pi, (count, arm.n))


# ------------------------------------------------------------------------------------------------ every file
def test_every_arm_of_the_papers_is_there():
    assert set(OURS) <= {path.stem for path in FILES}


@every_file
def test_a_table_has_the_name_of_its_folder_and_a_readme_with_its_source(path):
    assert path.stem == path.parent.name == read_dh(path).name
    readme = (path.parent / "README.md").read_text(encoding="utf-8")
    assert readme.startswith(f"# {path.stem}")
    assert "## Source" in readme
    assert "## Caveats" in readme


@pytest.mark.parametrize("name", ["planar_3r", "srs_7r", "srs_10r"])
def test_numbers_of_ours_are_labelled_as_such(name):
    word = "substitute" if name == "planar_3r" else "stand-in"
    assert (ROBOTS / name / "README.md").read_text(encoding="utf-8").startswith(f"# {name}: a {word}")
    assert (ROBOTS / name / f"{name}.toml").read_text(encoding="utf-8").startswith(f"# {word.upper()} for ")


@every_file
def test_a_table_rests_where_it_can_move_every_way(path):
    arm = read_dh(path)
    assert svd(task_jacobian(arm, arm.rest)).s[-1] > 0.1


@every_file
def test_pinocchio_agrees_with_the_table(path):
    arm = read_dh(path)
    model = pin.buildModelFromXML(dh_to_urdf(arm))
    data, tip = model.createData(), model.getFrameId("tool", pin.FrameType.BODY)
    for q in configurations(arm, 5):
        J = pin.computeFrameJacobian(model, data, q, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        assert_allclose(J, arm.jacobian(q), rtol=0, atol=1e-12)
        assert_allclose(data.oMf[tip].homogeneous, arm.pose(q), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", OURS)
def test_no_limit_is_made_up(name):
    arm = table(name)
    assert np.isinf([arm.lower, arm.upper, arm.velocity]).all()


# ------------------------------------------------------------------------------------------------- duleba_3r
A0, A1, A2, A3 = 0.0, 0.3, 0.2, 0.3


def test_dulebas_arm_has_the_kinematics_of_equations_32_to_34():
    arm = table("duleba_3r")
    assert arm.rows == ("x", "y", "z")
    q = configurations(arm)
    q1, q2, q3 = q.T
    A = A1 + A2 * cos(q2) + A3 * cos(q2 + q3)
    height = A2 * sin(q2) + A3 * sin(q2 + q3)
    k = np.stack([cos(q1) * A, sin(q1) * A, A0 + height], axis=-1)
    J = np.array(
        [
            [-sin(q1) * A, -cos(q1) * height, -A3 * cos(q1) * sin(q2 + q3)],
            [cos(q1) * A, -sin(q1) * height, -A3 * sin(q1) * sin(q2 + q3)],
            [0 * A, A - A1, A3 * cos(q2 + q3)],
        ]
    )
    assert_allclose(arm.pose(q)[:, :3, 3], k, rtol=0, atol=1e-12)
    assert_allclose(task_jacobian(arm, q), np.moveaxis(J, -1, 0), rtol=0, atol=1e-12)
    assert_allclose(np.linalg.det(task_jacobian(arm, q)), -A2 * A3 * A * sin(q3), rtol=0, atol=1e-12)


def test_dulebas_path_starts_at_corank_one_and_ends_at_corank_two():
    arm = table("duleba_3r")
    start = np.radians([300, 90.768, 81.566])
    assert_allclose(arm.pose(start)[:3, 3], [0, 0, 0.24], rtol=0, atol=1e-5)
    assert_allclose(svd(task_jacobian(arm, start)).s, [0.4709, 0.1260, 0], rtol=0, atol=5e-5)
    end = np.array([np.radians(300), np.arccos(-A1 / (A2 + A3)), 0])
    assert_allclose(arm.pose(end)[:3, 3], [0, 0, 0.4], rtol=0, atol=1e-12)
    assert coranks(arm, end) == 2


# --------------------------------------------------------------------------------------------- planar arms
def test_the_planar_2r_arm_has_unit_links_in_the_xy_plane():
    arm = table("planar_2r")
    assert arm.rows == ("x", "y")
    q = configurations(arm)
    q1, q12 = q[:, 0], q.sum(axis=-1)
    position = np.stack([cos(q1) + cos(q12), sin(q1) + sin(q12), 0 * q1], axis=-1)
    assert_allclose(arm.pose(q)[:, :3, 3], position, rtol=0, atol=1e-12)
    assert_allclose(np.linalg.det(task_jacobian(arm, q)), sin(q[:, 1]), rtol=0, atol=1e-12)
    assert_allclose(arm.pose([-pi / 4, pi / 4])[:2, 3], [1.707, -0.707], rtol=0, atol=5e-4)
    assert_allclose(svd(task_jacobian(arm, [-pi / 4, pi / 4])).s, [2.0731, 0.3411], rtol=0, atol=5e-5)
    assert_allclose(coranks(arm, [[0.3, 0], [0.3, pi]]), 1)


def test_the_planar_3r_arm_moves_in_the_xz_plane_and_reaches_96_centimetres():
    arm = table("planar_3r")
    assert arm.rows == ("x", "z")
    q = configurations(arm)
    a, b, c = np.cumsum(q, axis=-1).T
    x = 0.36 * cos(a) + 0.36 * cos(b) + 0.24 * cos(c)
    z = 0.36 * sin(a) + 0.36 * sin(b) + 0.24 * sin(c)
    assert_allclose(arm.pose(q)[:, :3, 3], np.stack([x, 0 * x, z], axis=-1), rtol=0, atol=1e-12)
    assert_allclose(arm.pose([0.4, 0, 0])[:3, 3], 0.96 * np.array([cos(0.4), 0, sin(0.4)]), rtol=0, atol=1e-12)
    expected = [[0] * 3, [-1] * 3, [0] * 3]
    assert_allclose(arm.jacobian(q)[:, 3:], np.broadcast_to(expected, (50, 3, 3)), rtol=0, atol=1e-12)
    stretched_or_folded = [[0.4, p, r] for p in (0, pi) for r in (0, pi)]
    assert_allclose(coranks(arm, stretched_or_folded), 1)


# --------------------------------------------------------------------------------------------- S-R-S arms
ZERO, QUARTER = (0, pi, -pi), (pi / 2, -pi / 2)
RANK_1 = [{2: ZERO, 3: QUARTER}, {2: ZERO, 6: ZERO}, {4: ZERO}, {5: QUARTER, 6: ZERO}]
RANK_2 = [
    {2: ZERO, 3: ZERO, 4: ZERO},
    {2: ZERO, 4: ZERO, 6: ZERO},
    {4: ZERO, 5: ZERO, 6: ZERO},
    {2: ZERO, 3: QUARTER, 5: QUARTER, 6: ZERO},
]
SRS = ("pa10", "srs_7r")


def filled(row, seed):
    """Configurations with the listed joints (counted from 1) pinned and the others random."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-pi, pi, (40, 7))
    for joint, values in row.items():
        q[:, joint - 1] = rng.choice(values, 40)
    return q


@pytest.mark.parametrize("index", range(4))
def test_every_row_of_tables_3_and_4_of_the_paper_on_the_pa10_holds(index):
    arm = table("pa10")
    assert_allclose(coranks(arm, filled(RANK_1[index], index)), 1)
    assert_allclose(coranks(arm, filled(RANK_2[index], index)), 2)


@pytest.mark.parametrize("name", SRS)
def test_both_configurations_of_the_papers_figure_9_have_corank_three(name):
    assert_allclose(coranks(table(name), [[0] * 7, [pi, 0, pi, pi, pi, pi, pi]]), 3)


def test_the_stand_in_loses_one_direction_stretched_and_two_folded_as_its_wrist_meets_its_shoulder():
    arm = table("srs_7r")
    assert_allclose(coranks(arm, filled({4: (0,)}, 0)), 1)
    folded = filled({4: (pi, -pi)}, 0)
    assert_allclose(arm.frames(folded)[:, 5, :3, 3], 0, rtol=0, atol=1e-12)
    assert_allclose(coranks(arm, folded), 2)


def test_the_lattice_of_right_angles_has_the_known_coranks():
    free = 0.7371
    values = np.array([0, pi / 2, pi, free])
    inner = np.stack(np.meshgrid(*[values] * 5, indexing="ij"), axis=-1).reshape(-1, 5)
    # A free angle of the lattice is a different one for every joint, lest they be related by chance.
    inner = np.where(inner == free, free * np.array([1, 1.31, 0.83, 1.71, 0.57]), inner)
    q = np.concatenate([np.full((len(inner), 1), 0.3), inner, np.full((len(inner), 1), -0.4)], axis=-1)
    assert np.bincount(coranks(table("pa10"), q)).tolist() == [320, 440, 232, 32]


@pytest.mark.parametrize("name, upper_arm, forearm, hand", [("pa10", 0.45, 0.5, 0.45), ("srs_7r", 0.7, 0.7, 0.1)])
def test_the_elbow_alone_sets_the_distance_from_shoulder_to_wrist(name, upper_arm, forearm, hand):
    arm = table(name)
    q = configurations(arm)
    frames = arm.frames(q)
    squared = np.sum(frames[:, 5, :3, 3] ** 2, axis=-1)
    expected = upper_arm**2 + forearm**2 + 2 * upper_arm * forearm * cos(q[:, 3])
    assert_allclose(squared, expected, rtol=0, atol=1e-12)
    assert_allclose(np.linalg.norm(frames[:, -1, :3, 3] - frames[:, 5, :3, 3], axis=-1), hand, atol=1e-12)
    assert_allclose(arm.pose(np.zeros(7))[:3, 3], [0, 0, upper_arm + forearm + hand], rtol=0, atol=1e-12)


def test_the_ten_joint_arm_is_the_seven_joint_one_up_to_its_wrist_and_stands_upright_at_zero():
    arm, shorter = table("srs_10r"), table("srs_7r")
    q = configurations(arm)
    assert_allclose(arm.frames(q)[:, :7], shorter.frames(q[:, :7])[:, :7], rtol=0, atol=1e-12)
    assert_allclose(arm.pose(np.zeros(10))[:3, 3], [0, 0, 1.8], rtol=0, atol=1e-12)
    assert not coranks(arm, q).any()


# ------------------------------------------------------------------------------------------- almarkhi_4dof
def test_the_fault_tolerant_arm_is_nearly_singular_where_the_paper_prints_it_is():
    arm = table("almarkhi_4dof")
    assert arm.rows == ("x", "y", "z")
    printed = [[-3.11, 3.02, -1.53, 0.15], [-1.76, -1.85, -1.39, 0.02]]
    assert_allclose(svd(task_jacobian(arm, printed)).s[:, 2], [0.0024, 0.0050], rtol=0, atol=5e-5)


def test_the_fault_tolerant_arm_has_an_isotropic_optimum_and_never_loses_two_directions():
    arm = table("almarkhi_4dof")
    q4 = np.arccos(-np.sqrt(2 / 3))
    assert q4 == pytest.approx(2.526, abs=5e-4)
    assert_allclose(svd(task_jacobian(arm, [0.3, pi, pi, q4])).s, 1, rtol=0, atol=1e-12)
    assert svd(task_jacobian(arm, configurations(arm, 20_000))).s[:, 1].min() > 0.7


# ------------------------------------------------------------------------------------------------- PUMA 560
@pytest.mark.parametrize("name", ["puma560", "puma560_corke"])
def test_the_puma_loses_a_direction_where_its_wrist_is_straight(name):
    arm = table(name)
    q = configurations(arm)
    assert not coranks(arm, q).any()
    for straight in (0, pi):
        q[:, 4] = straight
        assert_allclose(coranks(arm, q), 1)


def test_the_puma_loses_a_direction_at_its_elbow_and_at_its_shoulder():
    arm = table("puma560")
    a2, a3, d4 = 0.4318, -0.0203, 0.4331
    q = configurations(arm)
    q[:, 2] = np.arctan2(d4, a3)
    assert_allclose(coranks(arm, q), 1)
    q = configurations(arm)
    q3 = q[:, 2]
    q[:, 1] = np.arctan2(a2 + a3 * cos(q3) + d4 * sin(q3), a3 * sin(q3) - d4 * cos(q3))
    assert_allclose(a2 * cos(q[:, 1]) + a3 * cos(q[:, 1] + q3) + d4 * sin(q[:, 1] + q3), 0, atol=1e-15)
    assert_allclose(coranks(arm, q), 1)


def test_the_puma_at_zero_has_its_wrist_where_its_lengths_say():
    measured, corke = table("puma560"), table("puma560_corke")
    assert (measured.convention, corke.convention) == ("modified", "standard")
    expected = [0.4318 - 0.0203, 0.2435 - 0.0934, 0.4331]
    assert_allclose(measured.pose(np.zeros(6))[:3, 3], expected, rtol=0, atol=1e-12)
    expected = [0.4318 + 0.0203, -0.15005, 0.4318]
    assert_allclose(corke.pose(np.zeros(6))[:3, 3], expected, rtol=0, atol=1e-12)


# ---------------------------------------------------------------------------------------------- kinova_gen3
GEN3 = [  # origin of each joint as seen from the one before, m, and roll, quarter turns; from GEN3_URDF_V12
    ((0, 0, 0.15643), 2),
    ((0, 0.005375, -0.12838), 1),
    ((0, -0.21038, -0.006375), -1),
    ((0, 0.006375, -0.21038), 1),
    ((0, -0.20843, -0.006375), -1),
    ((0, 0.00017505, -0.10593), 1),
    ((0, -0.10593, -0.00017505), -1),
    ((0, 0, -0.061525), 2),
]


def gen3_pose(q):
    """The chain written out: a shift, a roll, a turn about z for each joint."""
    T = np.eye(4)
    for (origin, quarters), angle in zip(GEN3, [*q, 0.0]):
        a = quarters * pi / 2
        shift, roll, turn = np.eye(4), np.eye(4), np.eye(4)
        shift[:3, 3] = origin
        roll[1:3, 1:3] = [[cos(a), -sin(a)], [sin(a), cos(a)]]
        turn[:2, :2] = [[cos(angle), -sin(angle)], [sin(angle), cos(angle)]]
        T = T @ shift @ roll @ turn
    return T


def test_the_gen3_has_the_lengths_and_limits_of_its_source():
    robot = rik.load("kinova_gen3")
    assert robot.tip == "EndEffector_Link"
    assert (robot.n, robot.nq) == (7, 11)
    for q in np.random.default_rng(0).uniform(-pi, pi, (10, 7)):
        assert_allclose(robot.pose(robot.configuration(q)), gen3_pose(q), rtol=0, atol=1e-12)
    limit = np.array([np.inf, 2.41, np.inf, 2.66, np.inf, 2.23, np.inf])
    assert_allclose(robot.upper, limit)
    assert_allclose(robot.lower, -limit)
    assert_allclose(robot.velocity_limit, 0.8727)
    assert robot.description.notes == ()


def test_a_urdf_of_ours_has_the_name_of_its_folder_and_a_readme_with_its_source():
    files = sorted(ROBOTS.glob("*/*.urdf"))
    assert "kinova_gen3" in {path.stem for path in files}
    for path in files:
        assert rik.load(path).description.name == path.stem == path.parent.name
        readme = (path.parent / "README.md").read_text(encoding="utf-8")
        assert readme.startswith(f"# {path.stem}")
        assert "## Source" in readme
        assert "## Caveats" in readme


def test_the_gen3_loses_a_direction_where_upper_arm_and_wrist_are_straight_and_at_neither_alone():
    """But for the millimetres by which its axes miss each other."""
    robot = rik.load("kinova_gen3")
    q = np.random.default_rng(0).uniform(-2, 2, (2000, 7))

    def smallest_sigma(straight):
        values = q.copy()
        values[:, straight] = 0.0
        return svd(robot.jacobian(robot.configuration(values))).s[:, -1]

    assert smallest_sigma([1, 5]).max() < 2e-3
    assert smallest_sigma([3]).max() < 5e-3
    for alone in ([1], [5]):
        assert smallest_sigma(alone).max() > 0.1
