"""Loading by name and by path, the catalogue, reach, and the motion of the demo."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import Follow
from robust_ik.description import catalog
from robust_ik.description.urdf.urdf_reader import parse_urdf
from robust_ik.errors import suggest
from robust_ik.robot.reach import find_reach
from robust_ik.simulation.scenarios import stretch
from robust_ik.simulation.scenarios.stretch import BEYOND

OURS = {
    "duleba_3r", "kinova_gen3", "planar_2r", "planar_3r", "pa10", "almarkhi_4dof", "puma560", "puma560_corke", "srs_7r",
    "srs_10r",
}  # fmt: skip
ARMS = ["xarm7", "panda", "ur5", "kinova", "z1", "so100", "tiago", "pa10", "puma560", "planar_2r", "planar_3r",
        "duleba_3r", "almarkhi_4dof", "srs_10r", "double_pendulum", "finger_edu", "borinot"]  # fmt: skip


def test_our_robots_and_the_examples_are_found_by_name():
    entries = catalog.catalog()
    assert {name for name, entry in entries.items() if entry.source == catalog.OURS} == OURS
    assert {"panda", "ur5", "xarm7", "tiago_dual", "anymal_b", "anymal_c", "so101"} <= set(entries)
    assert all(entry.path.is_file() for entry in entries.values())


def test_every_urdf_of_the_example_package_has_a_name_of_its_own():
    paths = [entry.path for entry in catalog.catalog().values() if entry.source == catalog.EXAMPLES]
    root = next(
        parent for parent in paths[0].parents if parent.name == "robots" and (parent / "ur_description").is_dir()
    )
    on_disk = {path for path in root.rglob("*.urdf") if "<link" in path.read_text(errors="replace")}
    assert set(paths) == on_disk
    assert len(set(paths)) == len(paths)


@pytest.mark.parametrize("name", [n for n, e in catalog.catalog().items() if n not in ("hector", "iris_simple")])
def test_every_robot_of_the_catalogue_loads_whole(name):
    robot = rik.load(name, whole_tree=True)
    assert robot.name == name
    assert robot.n >= 1
    assert robot.lower.shape == robot.upper.shape == robot.velocity_limit.shape == (robot.n,)
    assert (robot.lower <= robot.upper).all()
    for array in (robot.lower, robot.upper, robot.velocity_limit, robot.rest):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    leaf = robot.description.leaves[0]
    assert_allclose(robot.pose(robot.rest, leaf)[3], [0, 0, 0, 1])


@pytest.mark.parametrize("name", [n for n, e in catalog.catalog().items() if e.known is not None])
def test_documented_tips_exist_and_rests_lie_inside_the_limits(name):
    robot = rik.load(name)
    known = catalog.find(name).known
    assert robot.tip == known.tip
    values = robot.joint_values(robot.rest)
    assert (values >= robot.lower).all()
    assert (values <= robot.upper).all()
    if known.rest:
        assert_allclose(values, known.rest)


def test_a_tip_given_overrides_the_documented_one():
    assert rik.load("panda", tip="panda_link8").tip == "panda_link8"
    assert rik.load("panda", tip="panda_leftfinger").n == 8


def test_a_path_loads_as_the_name_does(rng):
    by_name = rik.load("ur5")
    by_path = rik.load(catalog.find("ur5").path)
    q = by_name.random(rng)
    assert by_path.tip == "tool0"
    assert (by_name.jacobian(q) == by_path.jacobian(q)).all()
    table = rik.load(catalog.find("pa10").path)
    assert table.n == 7
    assert rik.load(str(catalog.find("duleba_3r").path)).rows == ("x", "y", "z")


def test_rows_can_be_chosen_when_loading():
    assert rik.load("panda", rows=("x", "y")).jacobian(np.zeros(7)).shape == (2, 7)
    assert rik.load("pa10", rows=("x", "y", "z")).jacobian(np.zeros(7)).shape == (3, 7)


def test_an_unknown_name_is_refused_and_near_ones_are_offered():
    with pytest.raises(rik.RobotNotFoundError, match=r"'pandas' and no file.*did you mean 'panda'"):
        rik.load("pandas")


@pytest.mark.parametrize("name", ["missing.urdf", "missing.toml"])
def test_a_missing_file_is_said(name, tmp_path):
    with pytest.raises(rik.LoadError, match="no file"):
        rik.load(tmp_path / name)


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "robot.sdf"
    path.write_text("<sdf/>")
    with pytest.raises(rik.LoadError, match="it is SDF, not a URDF: .* or convert it"):
        rik.load(path)
    for name, says in [("r.xml", "MuJoCo's MJCF"), ("r.usda", "is USD, not a URDF"), ("r.txt", "neither a .urdf, nor")]:
        (tmp_path / name).write_text("<mujoco/>")
        with pytest.raises(rik.LoadError, match=says):
            rik.load(tmp_path / name)


def test_a_dh_table_has_one_tip():
    with pytest.raises(rik.InputError, match="one tip, 'tool'"):
        rik.load("pa10", tip="link3")


def test_an_ambiguous_robot_says_which_tips_there_are():
    with pytest.raises(rik.TipError, match="leftNub, rightNub"):
        rik.load("alex_nub_hands")


def test_a_note_is_logged_once_for_each_file(tmp_path, caplog):
    for name in ("a", "b", "a"):
        path = tmp_path / f"{name}.urdf"
        path.write_text(gantry())
        robot = rik.load(path)
        assert "has no position limits" in robot.notes[0] or "states no position limits" in robot.notes[0]
    told = [record.getMessage() for record in caplog.records if record.name == "robust_ik"]
    assert [message.split(": ")[0] for message in told] == [str(tmp_path / "a.urdf"), str(tmp_path / "b.urdf")]
    assert all("it is taken as unlimited" in message for message in told)


def test_a_tip_that_was_guessed_is_noted(caplog):
    robot = rik.Robot.from_urdf(catalog.find("panda").path)
    assert robot.tip == "panda_hand"
    assert "no tip was given: 'panda_hand'" in robot.notes[-1]
    assert rik.Robot.from_urdf(catalog.find("panda").path, "panda_hand").notes == ()
    assert rik.load("panda").notes == ()


def test_suggestions_put_near_names_first_and_cut_long_lists():
    assert suggest("tol0", ["tool0", "base"]) == "did you mean 'tool0'? there are: base, tool0"
    assert suggest("zzz", []) == "there are: none"
    assert "(100 in all)" in suggest("zzz", [f"a{i}" for i in range(100)])


# ----------------------------------------------------------------------------------------------------- reach
@pytest.mark.parametrize(
    "name, distance", [("planar_2r", 2.0), ("planar_3r", 0.96), ("pa10", 0.45 + 0.5 + 0.45), ("srs_7r", 1.5)]
)
def test_the_reach_is_the_stretched_length(name, distance):
    reach = find_reach(rik.load(name))
    assert_allclose(reach.distance, distance, atol=1e-6)
    assert_allclose(np.linalg.norm(rik.load(name).pose(reach.q)[:3, 3] - reach.center), reach.distance)


@pytest.mark.parametrize("name", ["panda", "ur5", "xarm7", "z1", "tiago"])
def test_no_random_configuration_reaches_farther(name, rng):
    robot = rik.load(name)
    reach = find_reach(robot)
    p = robot.pose(robot.random(rng, 3000))[:, :3, 3]
    assert np.linalg.norm(p - reach.center, axis=-1).max() <= reach.distance
    values = robot.joint_values(reach.q)
    assert (values >= robot.lower - 1e-12).all()
    assert (values <= robot.upper + 1e-12).all()


def test_the_reach_of_a_robot_without_tip_is_refused():
    with pytest.raises(rik.TipError, match="without a tip"):
        find_reach(rik.load("panda", whole_tree=True))
    with pytest.raises(rik.TipError, match="without a tip"):
        stretch(rik.load("panda", whole_tree=True))


# ------------------------------------------------------------------------------------------- the demo's motion
@pytest.mark.parametrize("name", ARMS)
def test_the_demo_leaves_its_reach_comes_back_and_stays_calm(name):
    scenario = stretch(rik.load(name))
    offset = scenario.path.goal - scenario.reach.center
    assert_allclose(np.linalg.norm(offset), BEYOND * scenario.reach.distance)
    for inverse in (rik.JParse(), rik.DampedLeastSquares()):
        run = scenario.run(inverse)
        assert run.largest_speed < 60
        assert np.linalg.norm(run.final_error) < 2e-3
        start = scenario.robot.jacobian(scenario.q0)
        assert rik.svd(start).corank() == 0


@pytest.mark.parametrize("name", ["xarm7", "panda", "ur5", "kinova", "pa10", "puma560", "so100"])
def test_in_the_demo_jparse_passes_calmly_where_the_pseudo_inverse_would_ask_for_fifty_times_its_speed(name):
    """At the states of the calm run: the pseudo-inverse's own peaks hang on the last bit."""
    scenario = stretch(rik.load(name))
    calm = scenario.run(rik.JParse())
    motion = Follow(scenario.path, scenario.gain, scenario.max_linear, scenario.max_angular)
    states = [(calm.time[i], calm.q[i]) for i in np.argsort(calm.sigma[:, -1])[:300]]
    equations = [motion(time)[0][0].equation(scenario.robot, q) for time, q in states]
    asked = [np.abs(rik.MoorePenrose().solve(each.J, each.xdot)).max() for each in equations]
    assert max(asked) > 50 * calm.largest_speed
    assert calm.sigma[:, -1].min() < 0.01 * calm.sigma[0, 0]


@pytest.mark.parametrize(
    "name, rows",
    [("panda", "x y z wx wy wz"), ("so100", "x y z"), ("planar_3r", "x z"), ("borinot", "x z"), ("duleba_3r", "x y z")],
)
def test_the_demo_uses_the_rows_the_arm_can_move(name, rows):
    assert " ".join(stretch(rik.load(name)).robot.rows) == rows


@pytest.mark.parametrize(
    "name, tip",
    [("panda", "panda_hand_tcp"), ("xarm7", "link_eef"), ("ur5", "tool0"), ("kinova", "j2s6s200_end_effector"),
     ("z1", "link06"), ("so100", "gripper"), ("so101", "gripper_frame_link"), ("tiago", "arm_tool_link")],
)  # fmt: skip
def test_the_documented_tips_are_these(name, tip):
    assert rik.load(name).tip == tip


def test_a_file_of_a_robots_name_does_not_hide_the_robot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "panda").write_text("hello")
    assert rik.load("panda").n == 7


@pytest.mark.parametrize("name", ["x" * 5000, "~nobody_of_that_name/x", "a\0b"])
def test_a_name_that_cannot_be_is_refused(name):
    with pytest.raises(rik.LoadError, match="no robot called|is no .urdf"):
        rik.load(name)


def test_the_catalogue_cannot_be_changed():
    with pytest.raises(TypeError):
        catalog.catalog()["x"] = None


def gantry(lower="", upper=""):
    limit = f'<limit {lower} {upper} velocity="1" effort="1"/>'
    joints = [
        f'<joint name="{axis}" type="prismatic"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<axis xyz="{" ".join(str(int(i == k)) for k in range(3))}"/>{limit}</joint>'
        for i, axis in enumerate("xyz")
    ]
    links = [f'<link name="l{i}"/>' for i in range(4)]
    return f'<robot name="gantry">{"".join(links + joints)}</robot>'


def test_the_reach_does_not_follow_slides_without_end():
    robot = rik.Robot.from_description(parse_urdf(gantry()))
    assert find_reach(robot).distance < np.sqrt(3)
    bounded = rik.Robot.from_description(parse_urdf(gantry('lower="-2"', 'upper="3"')))
    assert_allclose(find_reach(bounded).distance, 3 * np.sqrt(3), atol=1e-6)


def test_a_tip_that_its_joints_leave_in_place_is_refused():
    table = rik.DHTable([rik.DHJoint(a=0, d=0, alpha=1.0), rik.DHJoint(a=0, d=0, alpha=0)], "standard")
    with pytest.raises(rik.TipError, match="leave the tip 'tool' where it is"):
        stretch(rik.Robot.from_dh(table))


def test_the_demos_pull_is_capped():
    scenario = stretch(rik.load("panda"))
    run = scenario.run(rik.JParse())
    J, rows = scenario.robot.jacobian(run.q), slice(0, 3)
    given_speed = np.linalg.norm((J @ run.qdot[..., None])[:, rows, 0], axis=-1)
    assert given_speed.max() <= 5 * 0.3 * scenario.reach.distance * 1.001
