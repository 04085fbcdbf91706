"""Reading URDF: what is read, what is refused and how it is said."""

import math
import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.catalog import catalog
from robust_ik.description.joint_tree import Box, Cylinder, Mesh, Sphere
from robust_ik.description.urdf.urdf_reader import MAX_BYTES, parse_urdf, read_urdf

LIMIT = '<limit lower="-1" upper="2" velocity="3" effort="4"/>'


def joint(name="j1", kind="revolute", parent="a", child="b", inside=LIMIT, axis="0 0 1"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="1 0 0"/><axis xyz="{axis}"/>{inside}</joint>'
    )


def urdf(*joints, links="abc", inside=""):
    return f"""<robot name="r">{"".join(f'<link name="{link}"/>' for link in links)}{"".join(joints)}{inside}</robot>"""


TWO = (joint(), joint("j2", parent="b", child="c"))
PLAIN = urdf(*TWO)


def test_joints_links_and_limits_are_read():
    description = parse_urdf(urdf(*TWO))
    assert description.links == ("a", "b", "c")
    assert description.root == "a"
    assert description.leaves == ("c",)
    first = description.joints[0]
    assert (first.name, first.kind, first.lower, first.upper, first.velocity) == ("j1", "revolute", -1, 2, 3)


def test_comments_processing_instructions_and_foreign_elements_do_no_harm():
    text = urdf(*TWO, inside="<!-- hi --><ros2_control><joint name='j1'/></ros2_control><gazebo/>")
    assert [j.name for j in parse_urdf(f"<?xml version='1.0'?><?x y?>{text}").joints] == ["j1", "j2"]


@pytest.mark.parametrize("limit", ['<limit effort="1" velocity="0"/>', '<limit lower="0" upper="0" effort="1"/>'])
def test_limits_of_zero_are_limits_not_stated_and_that_is_noted(limit):
    description = parse_urdf(urdf(joint(inside=limit), TWO[1]))
    assert description.joints[0].lower == -math.inf
    assert description.joints[0].velocity == math.inf
    assert any("j1" in note and "unlimited" in note for note in description.notes)


def test_a_mimic_joint_follows_its_source_and_is_no_joint_of_its_own(rng):
    follower = joint("j2", parent="b", child="c", inside=LIMIT + '<mimic joint="j1" multiplier="-2" offset="0.3"/>')
    robot = rik.Robot.from_description(parse_urdf(urdf(joint(), follower)))
    free = rik.Robot.from_description(parse_urdf(urdf(*TWO)))
    assert robot.joint_names == ("j1",)
    q = robot.random(rng, 5)
    both = np.concatenate([q, -2 * q + 0.3], axis=-1)
    assert_allclose(robot.pose(q), free.pose(both), atol=1e-14)
    assert_allclose(robot.jacobian(q), free.jacobian(both) @ [[1], [-2]], atol=1e-14)
    assert_allclose(robot.hessian(q)[..., 0, 0], free.hessian(both) @ [1, -2] @ [1, -2], atol=1e-14)


def test_a_mimic_of_a_mimic_works():
    text = urdf(
        joint(),
        joint("j2", parent="b", child="c", inside=LIMIT + '<mimic joint="j1" multiplier="2" offset="1"/>'),
        joint("j3", parent="c", child="d", inside=LIMIT + '<mimic joint="j2" multiplier="3" offset="1"/>'),
        links="abcd",
    )
    robot = rik.Robot.from_description(parse_urdf(text))
    assert robot.n == 1
    # q3 = 3 (2 q1 + 1) + 1, so the whole turns by q1 (1 + 2 + 6).
    assert_allclose(robot.jacobian([0.1])[5], 9)


def test_the_source_of_a_mimic_stays_although_it_does_not_carry_the_tip():
    text = urdf(
        joint(),
        joint("j2", parent="a", child="c", inside=LIMIT + '<mimic joint="j1"/>'),
    )
    robot = rik.Robot.from_description(parse_urdf(text), "c")
    assert robot.joint_names == ("j1",)
    assert robot.jacobian([0.2])[5, 0] == pytest.approx(1)


def test_a_mimic_of_nothing_is_a_free_joint_and_that_is_noted():
    description = parse_urdf(urdf(joint(inside=LIMIT + '<mimic joint="nobody"/>'), TWO[1]))
    assert description.joints[0].mimic is None
    assert "nobody" in description.notes[0]


def test_prismatic_and_continuous_joints_move_as_they_should():
    text = urdf(joint(kind="prismatic", axis="0 3 4"), joint("j2", "continuous", "b", "c", inside=""))
    robot = rik.Robot.from_description(parse_urdf(text))
    assert (robot.n, robot.nq) == (2, 3)
    q = robot.configuration([0.5, np.pi])
    assert_allclose(robot.pose(q)[:3, 3] - robot.pose(robot.neutral)[:3, 3], [0, 0.3, 0.4], atol=1e-12)
    assert robot.upper.tolist() == [2, np.inf]


def test_joints_that_do_not_move_the_tip_are_dropped_and_a_whole_tree_keeps_them():
    text = urdf(*TWO, joint("side", parent="a", child="d"), links="abcd")
    description = parse_urdf(text)
    assert rik.Robot.from_description(description, "c").joint_names == ("j1", "j2")
    assert rik.Robot.from_description(description, "d").joint_names == ("side",)
    whole = rik.Robot.from_description(description, whole_tree=True)
    assert set(whole.joint_names) == {"j1", "j2", "side"}
    assert whole.jacobian(np.zeros(3), "d").any()
    with pytest.raises(rik.TipError, match="leaves are c, d"):
        whole.jacobian(np.zeros(3))


def test_a_joint_name_is_a_tip_too():
    description = parse_urdf(urdf(*TWO))
    robot = rik.Robot.from_description(description, "j2")
    assert robot.joint_names == ("j1", "j2")


def test_a_link_and_a_joint_may_share_a_name(rng):
    text = urdf(joint("b"), joint("c", parent="b", child="c"), joint("d", parent="a", child="d"), links="abcd")
    robot = rik.Robot.from_description(parse_urdf(text), "c")
    assert robot.joint_names == ("b", "c")
    assert robot.pose(robot.random(rng)).shape == (4, 4)


def test_shapes_and_colours_are_read():
    visual = """<visual><origin xyz="0 0 1"/><geometry>{}</geometry><material name="m"/></visual>"""
    shapes = ["<box size='1 2 3'/>", "<sphere radius='2'/>", "<cylinder radius='1' length='2'/>"]
    shapes += ["<mesh filename='package://p/x.stl' scale='2 2 2'/>", "<mesh filename='x.weird'/>"]
    text = (
        "<robot name='r'><material name='m'><color rgba='1 0 .5 1'/></material><link name='a'>"
        + "".join(visual.format(shape) for shape in shapes)
        + "</link></robot>"
    )
    visuals = parse_urdf(text).visuals
    assert [type(v.shape) for v in visuals] == [Box, Sphere, Cylinder, Mesh, Mesh]
    assert visuals[0].placement[2, 3] == 1
    assert visuals[0].color == (1, 0, 0.5, 1)
    assert visuals[3].shape.scale == (2, 2, 2)
    assert "package 'p'" in visuals[3].shape.problem
    assert ".stl" in visuals[4].shape.problem


BILLION = """<?xml version="1.0"?><!DOCTYPE lolz [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;">]><robot name="&c;"><link name="a"/></robot>"""
OUTSIDE = """<?xml version="1.0"?><!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]>
<robot name="r"><link name="&x;"/></robot>"""

BROKEN = {
    "billion laughs": (BILLION, "DOCTYPE"),
    "external entity": (OUTSIDE, "DOCTYPE"),
    "external entity in text": (OUTSIDE.replace('<link name="&x;"/>', '&x;<link name="a"/>'), "DOCTYPE"),
    "external DTD": ('<!DOCTYPE robot SYSTEM "http://example.com/x.dtd"><robot name="r"/>', "DOCTYPE"),
    "undefined entity": ('<robot name="&nope;"><link name="a"/></robot>', "not well-formed|Entity"),
    "truncated": (urdf(*TWO)[:150], "not well-formed XML"),
    "empty": ("", "not well-formed XML"),
    "no XML": ("hello", "not well-formed XML"),
    "another root": ("<launch/>", "root element is <launch>"),
    "SDF": ("<sdf version='1.7'><model name='r'/></sdf>", "it is SDF, not a URDF: .*convert it"),
    "MJCF": ("<mujoco model='r'><worldbody/></mujoco>", "it is MuJoCo's MJCF, not a URDF: .*convert it"),
    "no link": ("<robot name='r'/>", "no <link>"),
    "no limits": (urdf(joint(inside=""), TWO[1]), "joint 'j1' is revolute but has no <limit>.*continuous"),
    "no limits prismatic": (urdf(joint(kind="prismatic", inside=""), TWO[1]), "prismatic but has no <limit>"),
    "limits reversed": (
        urdf(joint(inside='<limit lower="1" upper="-1" velocity="1" effort="1"/>'), TWO[1]),
        "'j1' has its limits reversed: lower 1.0 > upper -1.0",
    ),
    "unknown type": (urdf(joint(kind="spherical"), TWO[1]), "type 'spherical'; possible are revolute"),
    "no type": (urdf(joint().replace('type="revolute"', ""), TWO[1]), "type None"),
    "no parent": (urdf(joint().replace('<parent link="a"/>', "")), "parent link None"),
    "unknown child": (urdf(joint(child="zz")), "child link 'zz', which does not exist"),
    "two of a name": (urdf(joint(), joint(parent="b", child="c")), "two joints are called 'j1'"),
    "two links of a name": (urdf(*TWO, links="abca"), "two links are called 'a'"),
    "nameless link": ("<robot name='r'><link/></robot>", "has no name"),
    "two parents": (urdf(joint(), joint("j2", parent="c", child="b")), "child of two joints"),
    "loop": (urdf(joint(parent="b", child="c"), joint("j2", parent="c", child="b")), "loop through"),
    "only a loop": (urdf(joint(parent="a", child="b"), joint("j2", parent="b", child="a"), links="ab"), "a loop"),
    "two roots": (urdf(joint()), "exactly one link must have no parent joint, found a, c"),
    "zero axis": (urdf(joint(axis="0 0 0"), TWO[1]), "zero axis"),
    "NaN origin": (urdf(joint().replace("1 0 0", "nan 0 0"), TWO[1]), "3 finite numbers.*joint 'j1'"),
    "comma": (urdf(joint(axis="0,1 0 1"), TWO[1]), "3 finite numbers"),
    "two numbers": (urdf(joint().replace("1 0 0", "1 0"), TWO[1]), "3 finite numbers"),
    "infinite limit": (urdf(joint(inside='<limit lower="-inf" upper="1"/>'), TWO[1]), "1 finite number "),
    "mimics itself": (urdf(joint(inside=LIMIT + '<mimic joint="j1"/>'), TWO[1]), "mimics itself"),
    "mimic loop": (
        urdf(
            joint(inside=LIMIT + '<mimic joint="j2"/>'),
            joint("j2", parent="b", child="c", inside=LIMIT + '<mimic joint="j1"/>'),
        ),
        "mimics itself, through j1 → j2",
    ),
    "deep": ("<robot name='r'>" + "<a>" * 5000 + "</a>" * 5000 + "</robot>", "not well-formed XML"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_or_unsafe_urdf_is_refused_in_one_sentence(case):
    text, match = BROKEN[case]
    with pytest.raises(rik.UrdfError, match=match) as caught:
        rik.Robot.from_description(parse_urdf(text, source="x.urdf"))
    assert str(caught.value).startswith("x.urdf: ")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_tip_that_nothing_moves_is_refused():
    with pytest.raises(rik.TipError, match="no joint moves 'a' of r; frames that move: b, c"):
        rik.Robot.from_description(parse_urdf(urdf(*TWO)), "a")


def test_a_robot_without_joints_is_refused():
    with pytest.raises(rik.TipError, match="no joint that moves"):
        rik.Robot.from_description(parse_urdf(urdf(links="a")))
    with pytest.raises(rik.TipError, match="no joint that moves"):
        rik.Robot.from_description(parse_urdf(urdf(links="a")), whole_tree=True)


def test_an_unknown_tip_is_refused_and_names_are_offered():
    with pytest.raises(rik.FrameNotFoundError, match=r"no link or joint 'cc'; did you mean 'c'.*a, b, c, j1, j2"):
        rik.Robot.from_description(parse_urdf(urdf(*TWO)), "cc")


def test_several_longest_chains_are_an_error_that_lists_them():
    text = urdf(*TWO, joint("j3", parent="b", child="d"), links="abcd")
    with pytest.raises(rik.TipError, match="2 chains of 2 joints; give a tip .*, one of: c, d"):
        rik.Robot.from_description(parse_urdf(text))


def test_joints_are_the_same_without_shapes():
    for entry in catalog().values():
        if entry.path.suffix == ".urdf":
            whole, bare = read_urdf(entry.path), read_urdf(entry.path, shapes=False)
            assert (bare.name, bare.links, bare.joints) == (whole.name, whole.links, whole.joints)
            assert not bare.visuals
            assert not bare.collisions


def test_a_missing_file_is_said(tmp_path):
    with pytest.raises(rik.RobotNotFoundError, match="no file"):
        read_urdf(tmp_path / "none.urdf")


def test_a_huge_file_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "huge.urdf"
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(rik.LoadError, match="refused"):
        read_urdf(path)


def test_random_bytes_are_refused_never_crash(rng):
    good = urdf(*TWO).encode()
    for _ in range(300):
        data = bytearray(good)
        for index in rng.integers(0, len(data), 3):
            data[index] = rng.integers(0, 256)
        try:
            parse_urdf(bytes(data))
        except rik.UrdfError:
            continue


# ------------------------------------------------------------------------------------------------- mesh paths
@pytest.fixture
def package(tmp_path):
    """A package with a mesh, a URDF folder, and a secret outside of it."""
    for name in ("ws/arm/urdf", "ws/arm/meshes", "ws/other/meshes", "elsewhere"):
        (tmp_path / name).mkdir(parents=True)
    for name in ("ws/arm/meshes/a.stl", "ws/other/meshes/b.stl", "elsewhere/secret.stl"):
        (tmp_path / name).write_text("solid")
    (tmp_path / "ws/arm/package.xml").write_text("<package/>")
    (tmp_path / "ws/other/package.xml").write_text("<package/>")
    return tmp_path


def mesh(package: Path, filename: str, package_dirs=(), tag="visual") -> Mesh:
    path = package / "ws/arm/urdf/arm.urdf"
    shape = f"<{tag}><geometry><mesh filename='{filename}'/></geometry></{tag}>"
    path.write_text(f"<robot name='arm'><link name='a'>{shape}</link></robot>")
    return read_urdf(path, package_dirs).solids[0].shape


@pytest.mark.parametrize(
    "filename",
    ["package://arm/meshes/a.stl", "package:///arm/meshes/a.stl", "../meshes/a.stl", "model://arm/meshes/a.stl",
     "package://arm/urdf/../meshes/a.stl", "package://arm//meshes/a.stl"],
)  # fmt: skip
def test_meshes_of_the_own_package_are_found(package, filename):
    found = mesh(package, filename)
    assert found.path == package / "ws/arm/meshes/a.stl"
    assert found.root == package / "ws/arm"
    assert found.problem == ""


def test_meshes_of_a_neighbouring_package_are_found(package):
    assert mesh(package, "package://other/meshes/b.stl").path == package / "ws/other/meshes/b.stl"


def test_package_dirs_may_hold_packages_or_be_one(package, tmp_path):
    (tmp_path / "elsewhere/far/meshes").mkdir(parents=True)
    (tmp_path / "elsewhere/far/meshes/c.stl").write_text("solid")
    for given in (tmp_path / "elsewhere", tmp_path / "elsewhere/far", str(tmp_path / "elsewhere")):
        assert mesh(package, "package://far/meshes/c.stl", [given]).path is not None
    assert mesh(package, f"file://{tmp_path}/elsewhere/secret.stl", [tmp_path / "elsewhere"]).path is not None


def test_ros_environment_variables_name_packages(package, tmp_path, monkeypatch):
    (tmp_path / "elsewhere/share/far").mkdir(parents=True)
    (tmp_path / "elsewhere/share/far/c.stl").write_text("solid")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "elsewhere"))
    assert mesh(package, "package://far/c.stl").path is not None
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere/share"))
    assert mesh(package, "package://far/c.stl").path is not None


@pytest.mark.parametrize("tag", ["visual", "collision"])
@pytest.mark.parametrize(
    "filename",
    ["package://arm/../../elsewhere/secret.stl", "../../../elsewhere/secret.stl", "package://../elsewhere/secret.stl",
     "package://other/../../elsewhere/secret.stl"],
)  # fmt: skip
def test_a_mesh_path_that_climbs_out_of_its_package_is_refused(package, filename, tag):
    with pytest.raises(rik.UrdfError, match=r"climbs out|names no package"):
        mesh(package, filename, tag=tag)


def test_a_link_that_leads_out_of_the_package_is_not_followed_unless_its_folder_is_allowed(package):
    (package / "ws/arm/meshes/l.stl").symlink_to(package / "elsewhere/secret.stl")
    (package / "ws/arm/meshes/loop.stl").symlink_to("loop.stl")
    found = mesh(package, "package://arm/meshes/l.stl")
    assert found.path is None
    assert "leads out" in found.problem
    assert mesh(package, "package://arm/meshes/l.stl", [package / "elsewhere"]).path is not None
    assert mesh(package, "package://arm/meshes/loop.stl").path is None


def test_paths_with_dots_and_relative_package_dirs_mean_what_they_say(package, monkeypatch):
    mesh(package, "../meshes/a.stl")
    monkeypatch.chdir(package / "ws/arm/urdf")
    assert read_urdf("../urdf/arm.urdf").visuals[0].shape.path == package / "ws/arm/meshes/a.stl"
    mesh(package, "package://other/meshes/b.stl")
    (package / "ws/other/package.xml").unlink()
    assert read_urdf("arm.urdf").visuals[0].shape.path is None
    assert read_urdf("arm.urdf", ["../.."]).visuals[0].shape.path is not None


def test_a_relative_path_may_lead_into_a_folder_that_was_allowed(package):
    name = "../../../elsewhere/secret.stl"
    assert mesh(package, name, [package / "elsewhere"]).path == package / "elsewhere/secret.stl"


def test_a_mesh_name_that_no_file_can_have_is_reported(package):
    assert mesh(package, "x" * 5000 + ".stl").path is None


@pytest.mark.parametrize(
    "filename, problem",
    [
        ("package://arm/meshes/none.stl", "not found at .*arm"),
        ("package://nobody/none.stl", "no folder of package 'nobody'"),
        ("file:///etc/x.stl", "outside the robot's folders"),
        ("/etc/x.stl", "outside the robot's folders"),
        ("http://example.com/x.stl", "never fetched"),
        ("../meshes/a.mesh", "is none of .stl"),
        ("../meshes/passwd", "is none of .stl"),
    ],
)
def test_a_mesh_that_is_not_there_is_reported_and_the_robot_still_loads(package, filename, problem):
    found = mesh(package, filename)
    assert found.path is None
    assert re.search(problem, found.problem)


def test_a_package_name_does_not_open_folders_of_the_system(package):
    # /etc is a folder beside an ancestor, but no package: without package.xml it is not looked into.
    assert mesh(package, "package://etc/x.stl").path is None
    (package / "elsewhere" / "x.stl").write_text("solid")
    assert mesh(package, "package://elsewhere/x.stl").path is None


# ------------------------------------------------------------------------------------- found by attacking the reader
def chain_text(count, inside=lambda i: "", kind="fixed"):
    joints = [joint(f"j{i}", kind, f"l{i}", f"l{i + 1}", inside(i)) for i in range(count)]
    return urdf(*joints, links=[f"l{i}" for i in range(count + 1)])


def test_a_urdf_too_deep_for_the_parsers_below_is_refused():
    with pytest.raises(rik.UrdfError, match="4000 joints deep; more than 1000 are refused"):
        parse_urdf(chain_text(4000))


def test_long_chains_of_mimics_and_wide_trees_are_read_in_no_time():
    mimics = chain_text(900, lambda i: LIMIT + (f'<mimic joint="j{i - 1}"/>' if i else ""), "revolute")
    description = parse_urdf(mimics)
    assert description.driver["j899"].source == "j0"
    wide = [joint(f"j{i}", "fixed", "root", f"l{i}", "") for i in range(7000)]
    parse_urdf(urdf(*wide, links=["root", *(f"l{i}" for i in range(7000))]))


def test_more_moving_joints_than_memory_can_hold_are_refused():
    with pytest.raises(rik.UrdfError, match="201 joints that move; more than 200"):
        rik.Robot.from_description(parse_urdf(chain_text(201, lambda i: LIMIT, "revolute")))


@pytest.mark.parametrize("axis", ["", "<axis/>"])
def test_an_axis_that_is_not_written_is_x(axis):
    text = urdf(joint().replace('<axis xyz="0 0 1"/>', axis), TWO[1])
    robot = rik.Robot.from_description(parse_urdf(text))
    assert_allclose(robot.jacobian([0, 0])[3:, 0], [1, 0, 0])


def test_an_axis_element_that_says_nothing_is_noted():
    text = urdf(joint().replace('<axis xyz="0 0 1"/>', "<axis/>"), TWO[1])
    assert parse_urdf(text).notes == ("joint 'j1': has an <axis> without xyz, which is taken as x",)


@pytest.mark.parametrize("blank", ["\u00a0", "\t", "\n", "  "])
def test_any_blank_stands_between_numbers_and_around_them(blank, capfd):
    spaced = PLAIN.replace('xyz="1 0 0"', f'xyz="1{blank}0{blank}0{blank}"').replace('lower="-1"', f'lower="-1{blank}"')
    robot, plain = (rik.Robot.from_description(parse_urdf(text)) for text in (spaced, PLAIN))
    assert_allclose(robot.pose([0.1, 0.2]), plain.pose([0.1, 0.2]))
    assert robot.lower.tolist() == plain.lower.tolist()
    assert capfd.readouterr().err == ""


def test_pinocchio_is_given_no_shape_to_complain_about(capfd):
    shape = "<visual><geometry><mesh/></geometry><material/></visual>"
    rik.Robot.from_description(parse_urdf(PLAIN.replace('<link name="c"/>', f'<link name="c">{shape}</link>')))
    assert "Error" not in capfd.readouterr().err


@pytest.mark.parametrize("axis", ["0 0 1e5", "0 0 1e-5"])
def test_an_axis_of_any_length_is_a_direction(axis):
    robot = rik.Robot.from_description(parse_urdf(urdf(joint(axis=axis), TWO[1])))
    assert_allclose(robot.jacobian([0, 0])[3:, 0], [0, 0, 1])


@pytest.mark.parametrize("follower", ["continuous", "revolute", "prismatic"])
def test_what_follows_a_continuous_joint_does_not_jump_at_half_a_turn(follower):
    mimic = '<mimic joint="j1" multiplier="0.5"/>'
    inside = mimic if follower == "continuous" else LIMIT + mimic
    text = urdf(joint(kind="continuous", inside=""), joint("j2", follower, "b", "c", inside))
    description = parse_urdf(text)
    assert any("j1" in note for note in description.notes)
    robot = rik.Robot.from_description(description)
    ahead, behind = robot.configuration([3.2]), robot.configuration([3.1])
    twist = rik.pose_error(robot.pose(behind), robot.pose(ahead))
    assert np.abs(twist).max() < 0.2


def test_the_limits_of_followers_bind_their_source():
    follower = joint("j2", parent="b", child="c", inside=LIMIT + '<mimic joint="j1" multiplier="-10" offset="1"/>')
    robot = rik.Robot.from_description(parse_urdf(urdf(joint(), follower)))
    # −1 ≤ 1 − 10 q ≤ 2 and |10 q̇| ≤ 3
    assert_allclose([robot.lower[0], robot.upper[0], robot.velocity_limit[0]], [-0.1, 0.2, 0.3])


def test_limits_without_effort_or_velocity_build():
    robot = rik.Robot.from_description(parse_urdf(urdf(joint(inside='<limit lower="-1" upper="1"/>'), TWO[1])))
    assert robot.velocity_limit[0] == np.inf
    assert robot.lower[0] == -1


def test_limits_as_large_as_nobody_means_are_none():
    inside = '<limit lower="-1e16" upper="1e16" velocity="1" effort="1"/>'
    robot = rik.Robot.from_description(parse_urdf(urdf(joint(inside=inside), TWO[1])))
    assert robot.upper[0] == np.inf


def test_a_link_frame_is_meant_where_a_joint_has_the_same_name():
    # Joint "c" carries link "b", one metre before link "c".
    robot = rik.Robot.from_description(parse_urdf(urdf(joint("c"), joint("j2", parent="b", child="c"))), "c")
    assert robot.joint_names == ("c", "j2")
    assert_allclose(robot.pose([0, 0])[:3, 3], [2, 0, 0])


MORE_BROKEN = {
    "huge number": (urdf(joint().replace("1 0 0", "1e308 0 0"), TWO[1]), "at most 1e\\+06"),
    "upper case": (
        urdf(*TWO).replace("<joint", "<Joint").replace("</joint", "</Joint"),
        "<Joint> must be written <joint>",
    ),
    "underscore": (urdf(joint(inside='<limit lower="-1_0" upper="1"/>'), TWO[1]), "1 finite number "),
    "negative speed": (urdf(joint(inside='<limit lower="-1" upper="1" velocity="-1"/>'), TWO[1]), "negative speed"),
    "mimic of no name": (urdf(joint(inside=LIMIT + "<mimic/>"), TWO[1]), "<mimic> that names no joint"),
    "half a limit": (urdf(joint(inside='<limit lower="0.5"/>'), TWO[1]), "upper 0.0 .one that is not stated is 0"),
    "surrogate": (urdf(*TWO).replace('"r"', '"\ud800"'), "not text"),
}


@pytest.mark.parametrize("case", MORE_BROKEN)
def test_more_that_is_broken_is_refused_in_one_sentence(case):
    text, match = MORE_BROKEN[case]
    with pytest.raises(rik.UrdfError, match=match):
        rik.Robot.from_description(parse_urdf(text))


SHAPES = {
    "<box size='1 2'/>": "needs size with 3 numbers",
    "<box/>": "needs size with 3 numbers",
    "<box size='1 -2 1'/>": "needs size with 3 numbers that are not negative",
    "<sphere radius='-1'/>": "radius with 1 number",
    "<cylinder radius='1'/>": "length with 1 number",
    "<cylinder radius='nan' length='1'/>": "radius with 1 number",
    "<mesh filename='x.stl' scale='2 2'/>": "scale of 1 or 3 numbers",
    "<mesh filename='x.stl' scale='1 1 1 1'/>": "scale of 1 or 3 numbers",
    "<mesh filename='x.stl' scale='nan inf 1'/>": "scale of 1 or 3 numbers",
    "": "has no geometry",
    "<capsule radius='1' length='2'/>": "is a capsule",
}


@pytest.mark.parametrize("part", ["visual", "collision"])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_shape_that_cannot_be_is_left_out_and_that_is_noted(shape, part):
    good = f"<{part}><geometry><sphere radius='1'/></geometry></{part}>"
    bad = f"<{part}><geometry>{shape}</geometry></{part}>"
    description = parse_urdf(f"<robot name='r'><link name='a'>{bad}{good}</link></robot>")
    assert [each.shape for each in description.solids] == [Sphere(1)]
    (note,) = description.notes
    assert re.search(f"link 'a': a <{part}> .*{SHAPES[shape]}.*left out", note)


def test_text_is_read_as_it_is_whatever_encoding_it_declares():
    text = '<?xml version="1.0" encoding="ISO-8859-1"?>' + urdf(joint("é"), TWO[1])
    assert parse_urdf(text).joints[0].name == "é"
    assert parse_urdf(text.encode("latin-1")).joints[0].name == "é"


# ------------------------------------------------------------------------------ what is mended, and what is noted
MENDED = {
    "prefix of an element": (PLAIN.replace("</robot>", "<drake:acceleration value='1'/></robot>"), "drake:accel"),
    "prefix of an attribute": (PLAIN.replace("effort=", "drake:acceleration='4' effort="), "limit drake:acceleration"),
    "prefix inside gazebo": (
        PLAIN.replace("</robot>", "<gazebo><sensor:camera n:a='b' xmlns:n='' /></gazebo></robot>"),
        "sensor:camera",
    ),
    "two colons": (PLAIN.replace("</robot>", "<a:b:c/></robot>"), "a:b:c"),
    "blank line": ("\n" + '<?xml version="1.0"?>' + PLAIN, "very beginning"),
    "comment first": ('<!-- by hand -->\n<?xml version="1.0"?>' + PLAIN, "very beginning"),
    "mark and blank": ('\ufeff <?xml version="1.0"?>' + PLAIN, "very beginning"),
    "mark read as Latin-1": ("ï»¿" + PLAIN, "text before the first tag"),
    "text after the declaration": ("<?xml version='1.0'?>?<!-- c -->." + PLAIN, "text before the first tag"),
    "end of CDATA": (PLAIN.replace("</robot>", "<gazebo>a]]>b</gazebo></robot>"), "']]>'"),
    "version 0.0": ('<?xml version="0.0"?>' + PLAIN, "version '0.0' is read as 1.0"),
    "two hyphens": (PLAIN.replace("</robot>", "<!-- a -- b\n---></robot>"), "'--'"),
    "control characters": (PLAIN.replace("</robot>", "<gazebo>\x01&#2;</gazebo></robot>\0"), "control characters"),
    "bare ampersand": (PLAIN.replace("</robot>", "<gazebo a='R & D'>x&y &amp; z</gazebo></robot>"), "bare '&'"),
    "bare less-than": (PLAIN.replace("</robot>", "<gazebo a='1 < 2'/></robot>"), "bare '<'"),
    "no space": (PLAIN.replace("</robot>", "<gazebo a='1'b='2'/></robot>"), "without a space"),
    "default namespace": (PLAIN.replace("<robot", "<robot xmlns='http://x'"), "default XML namespace"),
    "all of it": (
        '\n<?xml version="0.0"?><!-- -- -->' + PLAIN.replace("</robot>", "<p:q a='&' b='<'c='\x02'/></robot>"),
        "<p:q>",
    ),
}


@pytest.mark.parametrize("form", ["text", "bytes"])
@pytest.mark.parametrize("case", MENDED)
def test_what_lenient_readers_read_is_mended_and_noted(case, form):
    text, match = MENDED[case]
    description = parse_urdf(text if form == "text" else text.encode())
    assert any(match in note for note in description.notes)
    plain = parse_urdf(PLAIN)
    assert (description.links, description.joints) == (plain.links, plain.joints)


def test_sound_files_have_nothing_to_note():
    for head in ("", '<?xml version="1.0"?>\n', '\ufeff<?xml version="1.0" encoding="utf-8"?><!-- a - b -->'):
        text = head + PLAIN.replace("</robot>", "<gazebo xmlns:s='http://s'><s:c s:d='&lt;'/></gazebo></robot>")
        assert parse_urdf(text).notes == parse_urdf(text.encode()).notes == ()


@pytest.mark.parametrize("case", ["prefix of an element", "two hyphens", "bare ampersand", "default namespace"])
@pytest.mark.parametrize("entity", [BILLION, OUTSIDE], ids=["billion", "outside"])
def test_a_doctype_stays_refused_behind_what_could_be_mended(case, entity):
    head = entity[entity.index("<!DOCTYPE") : entity.index("]>") + 2]
    for text in (head + MENDED[case][0], "\n" + '<?xml version="1.0"?>' + head + MENDED[case][0]):
        with pytest.raises(rik.UrdfError, match="DOCTYPE"):
            parse_urdf(text)
        with pytest.raises(rik.UrdfError, match="DOCTYPE"):
            parse_urdf(text.encode())


def test_an_entity_stays_refused_behind_what_could_be_mended():
    with pytest.raises(rik.UrdfError, match="not well-formed XML"):
        parse_urdf("\n" + '<?xml version="1.0"?>' + PLAIN.replace('"a"', '"&nope;"', 1))


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252", "utf-8", "utf-16", "utf-8-sig"])
def test_bytes_of_any_usual_encoding_are_read_though_none_is_declared(encoding):
    description = parse_urdf(urdf(joint("é"), TWO[1]).encode(encoding))
    assert description.joints[0].name == "é"
    assert any("Windows-1252" in note for note in description.notes) == (encoding in ("latin-1", "cp1252"))


def test_one_stray_byte_does_not_spoil_the_others():
    data = urdf(joint("é"), TWO[1]).encode() + b"<!-- \xe9 -->"
    assert parse_urdf(data).joints[0].name == "é"


def test_an_encoding_that_is_declared_counts_also_where_something_is_mended():
    text = '<?xml version="1.0" encoding="gbk"?>' + urdf(joint("臂"), TWO[1]).replace("</robot>", "<a:b/></robot>")
    assert parse_urdf(text.encode("gbk")).joints[0].name == "臂"


def test_names_with_a_prefix_are_no_joints_and_no_links():
    inside = "<x:joint name='j9'/><x:link name='z'/>"
    description = parse_urdf(PLAIN.replace("</robot>", inside + "</robot>"))
    assert [each.name for each in description.joints] == ["j1", "j2"]
    assert description.links == ("a", "b", "c")


UNUSED = {
    "inertia": (
        '<link name="c"/>',
        '<link name="c"><inertial><mass value="nan"/></inertial></link>',
        "mass or inertia",
    ),
    "inertia of words": (
        '<link name="c"/>',
        '<link name="c"><inertial><origin xyz="0 0"/><inertia ixx="inf" iyy="heavy"/></inertial></link>',
        "mass or inertia",
    ),
    "part of an inertia": (
        '<link name="c"/>',
        '<link name="c"><inertial><mass value="1"/><inertia ixx="1"/></inertial></link>',
        "mass or inertia that is incomplete",
    ),
    "damping": (LIMIT, LIMIT + '<dynamics damping="much"/>', "<dynamics>"),
    "empty dynamics": (LIMIT, LIMIT + "<dynamics/>", "<dynamics>"),
    "safety": (LIMIT, LIMIT + '<safety_controller soft_lower_limit="x"/>', "<safety_controller>"),
    "calibration": (LIMIT, LIMIT + '<calibration rising="x"/>', "<calibration>"),
    "effort": ('effort="4"', 'effort="NaN"', "an effort"),
    "materials": ("</robot>", '<material name="m"/><material name="m"/></robot>', "material 'm': it is defined twice"),
    "colour": ("</robot>", '<material name="m"><color rgba="red"/></material></robot>', "a colour that"),
}


@pytest.mark.parametrize("case", UNUSED)
def test_what_kinematics_never_use_is_left_out_where_it_cannot_be_read(case):
    old, new, match = UNUSED[case]
    robot = rik.Robot.from_description(parse_urdf(PLAIN.replace(old, new)))
    plain = rik.Robot.from_description(parse_urdf(PLAIN))
    assert any(match in note for note in robot.description.notes)
    assert_allclose(robot.jacobian([0.3, 0.4]), plain.jacobian([0.3, 0.4]))
    assert np.isfinite(robot.model.inertias[1].mass)


def test_numbers_in_elements_of_other_programs_are_not_read():
    inside = (
        "<gazebo><origin xyz='a b'/><mass value='nan'/></gazebo><transmission name='t'><axis xyz='0'/></transmission>"
    )
    assert parse_urdf(PLAIN.replace("</robot>", inside + "<sensor><limit lower='?'/></sensor></robot>")).notes == ()


@pytest.mark.parametrize(
    "given, read", [("1 0 0", (1, 0, 0, 1)), ("1 0 0 0.5 9", (1, 0, 0, 0.5)), ("1 0", None), ("red", None)]
)
def test_a_colour_of_three_or_five_numbers_is_read_and_others_are_left_out(given, read):
    visual = f"<visual><geometry><sphere radius='1'/></geometry><material name='m'><color rgba='{given}'/></material>"
    description = parse_urdf(f"<robot name='r'><link name='a'>{visual}</visual></link></robot>")
    assert description.visuals[0].color == read
    assert "colour" in description.notes[0]


SIDE = {
    "limits reversed": joint("f", "prismatic", "b", "d", '<limit lower="1" upper="0" velocity="1" effort="1"/>'),
    "zero axis": joint("f", parent="b", child="d", axis="0 0 0"),
    "axis": joint("f", parent="b", child="d", axis="0 1"),
    "no <limit>": joint("f", parent="b", child="d", inside=""),
    "limit lower": joint("f", parent="b", child="d", inside='<limit lower="-pi" upper="1"/>'),
    "negative speed": joint("f", parent="b", child="d", inside='<limit lower="-1" upper="1" velocity="-1"/>'),
    "names no joint": joint("f", parent="b", child="d", inside=LIMIT + "<mimic/>"),
    "multiplier": joint("f", parent="b", child="d", inside=LIMIT + '<mimic joint="j1" multiplier="x"/>'),
    "mimics itself": joint("f", parent="b", child="d", inside=LIMIT + '<mimic joint="f"/>'),
    "has type 'screw'": joint("f", "screw", "b", "d"),
}


@pytest.mark.parametrize("defect", SIDE)
def test_a_joint_that_cannot_move_is_an_error_only_for_what_it_moves(defect):
    text = urdf(*TWO, SIDE[defect], links="abcd")
    description = parse_urdf(text)
    robot = rik.Robot.from_description(description, "c")
    assert robot.joint_names == ("j1", "j2")
    assert any(note.startswith("joint 'f': ") and defect in note for note in description.notes)
    assert robot.pose(robot.neutral, "d").shape == (4, 4)
    with pytest.raises(rik.UrdfError, match=f"joint 'f'.*{defect}.*the tip 'd' depends on it; .*not move is 'b'"):
        rik.Robot.from_description(description, "d")
    with pytest.raises(rik.UrdfError, match=f"joint 'f'.*{defect}"):
        rik.Robot.from_description(description, whole_tree=True)


def test_a_joint_that_follows_one_that_cannot_move_is_refused_too():
    text = urdf(SIDE["mimics itself"].replace('"b"', '"a"'), joint(inside=LIMIT + '<mimic joint="f"/>'), links="abd")
    description = parse_urdf(text)
    with pytest.raises(rik.UrdfError, match="joint 'f'.*mimics itself"):
        rik.Robot.from_description(description, "b")


def test_reversed_limits_of_a_follower_are_passed_over():
    follower = joint(
        "j2", parent="b", child="c", inside='<limit lower="1" upper="-1" velocity="1"/><mimic joint="j1"/>'
    )
    robot = rik.Robot.from_description(parse_urdf(urdf(joint(), follower)), "c")
    assert (robot.lower[0], robot.upper[0]) == (-1, 2)
    assert any("joint 'j2'" in note and "reversed" in note for note in robot.description.notes)


def test_many_notes_of_a_kind_are_one_sentence_with_a_count():
    shape = "<visual><geometry><box/></geometry></visual>"
    links = "".join(f'<link name="x{i}">{shape}</link>' for i in range(50))
    joints = "".join(joint(f"f{i}", "fixed", "a", f"x{i}", "") for i in range(50))
    (note,) = parse_urdf(PLAIN.replace("</robot>", links + joints + "</robot>")).notes
    assert "(50 in all)" in note
    assert len(note) < 400


def test_rotations_of_urdf_1_1_are_read_as_pinocchio_reads_them(rng):
    straight_up = [[0, -np.sqrt(0.5), 0, np.sqrt(0.5)], [0.5, 0.5, 0.5, -0.5], [0.5, -0.5, 0.5, 0.5], [0, 0, 1, 0]]
    for quaternion in [*straight_up, *rng.normal(size=(20, 4))]:
        words = " ".join(map(repr, map(float, quaternion)))
        text = PLAIN.replace('xyz="1 0 0"', f'xyz="1 0 0" quat_xyzw="{words}"').replace(
            "<robot", '<robot version="1.1"'
        )
        robot, model = rik.Robot.from_description(parse_urdf(text)), pin.buildModelFromXML(text)
        data, q = model.createData(), robot.random(rng)
        pin.framesForwardKinematics(model, data, q)
        expected = data.oMf[model.getFrameId("c", pin.FrameType.BODY)].homogeneous
        assert_allclose(robot.pose(q), expected, atol=1e-12)
        assert robot.notes == ()


def test_quaternions_of_older_files_are_passed_over_with_a_note_and_bad_ones_are_refused():
    text = PLAIN.replace('xyz="1 0 0"', 'xyz="1 0 0" quat_xyzw="0 0 1 0"')
    description = parse_urdf(text)
    assert "quat_xyzw" in description.notes[0]
    plain = rik.Robot.from_description(parse_urdf(PLAIN))
    assert_allclose(rik.Robot.from_description(description).pose([0, 0]), plain.pose([0, 0]))
    for wrong in ('quat_xyzw="0 0 0 0"', 'quat_xyzw="0 0 1"', 'quat_xyzw="0 0 0 1" rpy="0 0 0"'):
        bad = text.replace('quat_xyzw="0 0 1 0"', wrong).replace("<robot", '<robot version="1.1"')
        with pytest.raises(rik.UrdfError, match="quat_xyzw=.* must hold 4 finite numbers.*joint 'j1'"):
            parse_urdf(bad)
    assert "version '2.0' is not known" in parse_urdf(PLAIN.replace("<robot", '<robot version="2.0"')).notes[0]


# ------------------------------------------------------------------------------------------------------- xacro
@pytest.mark.parametrize(
    "old, new",
    [
        ('xyz="1 0 0"', 'xyz="${length} 0 0"'),
        ('name="a"', 'name="$(arg prefix)a"'),
        ('lower="-1"', 'lower="${-pi}"'),
        ("</robot>", '<xacro:arm prefix="a"/><xacro:include filename="arm.xacro"/></robot>'),
        ("</robot>", '<xacro:macro name="arm"><link name="e"/></xacro:macro><xacro:arm/></robot>'),
        ("</robot>", '<xacro:if value="1"><link name="e"/></xacro:if></robot>'),
        ('<axis xyz="0 0 1"/>', '<xacro:insert_block name="axis"/>'),
    ],
)
def test_xacro_that_was_not_expanded_is_named_as_such(old, new):
    text = PLAIN.replace("<robot", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'").replace(old, new, 1)
    with pytest.raises(rik.UrdfError, match=r"xacro that was not expanded: line 1 .*robust-ik\[xacro\]"):
        parse_urdf(text)


@pytest.mark.parametrize(
    "text",
    [
        "<robot name='r' xmlns:xacro='http://x'><xacro:macro name='m'><link name='a'/></xacro:macro></robot>",
        "<robot name='r' xmlns:x='http://www.ros.org/wiki/xacro'><x:include filename='a'/><x:arm/></robot>",
        PLAIN.replace("<robot", "<robot xmlns:xacro='http://x'")
        .replace('<link name="a"/>', "")
        .replace("</robot>", "<xacro:include filename='a.xacro'/></robot>"),
    ],
    ids=["library", "other prefix", "links in an include"],
)
def test_xacro_whose_links_are_elsewhere_is_named_as_such(text):
    with pytest.raises(rik.UrdfError, match=r"xacro that was not expanded: .*robust-ik\[xacro\]"):
        parse_urdf(text)


@pytest.mark.parametrize("declared", [True, False])
@pytest.mark.parametrize("left", ["property name='w' value='1'", "include filename='x.xacro'", "sensors p='a'"])
def test_what_is_left_of_xacro_and_does_no_harm_is_noted(declared, left):
    text = PLAIN.replace("</robot>", f"<xacro:{left}/></robot>")
    if declared:
        text = text.replace("<robot", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'")
    assert any("<xacro:" in note for note in parse_urdf(text).notes)
    assert parse_urdf(text).joints == parse_urdf(PLAIN).joints


def test_files_that_cannot_be_read_are_refused(tmp_path):
    for path in ("x" * 5000 + ".urdf", "~nobody_of_that_name/x.urdf", tmp_path):
        with pytest.raises(rik.LoadError):
            read_urdf(path)


def test_limits_that_seem_degrees_are_asked_about():
    inside = '<limit lower="-170" upper="170" velocity="1" effort="1"/>'
    assert "are they degrees?" in parse_urdf(urdf(joint(inside=inside), TWO[1])).notes[0]


def test_a_relative_path_that_leaves_a_folder_that_is_no_package_is_reported(tmp_path):
    (tmp_path / "arm").mkdir()
    (tmp_path / "m.stl").write_text("solid")
    visual = "<visual><geometry><mesh filename='../m.stl'/></geometry></visual>"
    (tmp_path / "arm" / "a.urdf").write_text(f"<robot name='a'><link name='a'>{visual}</link></robot>")
    found = read_urdf(tmp_path / "arm" / "a.urdf").visuals[0].shape
    assert found.path is None
    assert "--package-dir" in found.problem
    assert read_urdf(tmp_path / "arm" / "a.urdf", [tmp_path]).visuals[0].shape.path is not None


def test_collision_shapes_are_read_like_visuals_and_beside_them(tmp_path):
    shape = '<origin xyz="1 2 3"/><geometry><box size="1 2 3"/></geometry>'
    text = urdf(*TWO).replace(
        '<link name="b"/>',
        f'<link name="b"><visual>{shape}</visual><collision>{shape}</collision><collision><geometry>'
        '<capsule radius="1" length="1"/></geometry></collision></link>',
    )
    description = parse_urdf(text)
    (seen,), (solid,) = description.visuals, description.collisions
    assert (solid.link, solid.shape, solid.color) == (seen.link, seen.shape, None)
    assert_allclose(solid.placement, seen.placement)
    assert description.solids == description.collisions
    assert description.file is None
    path = tmp_path / "a.urdf"
    path.write_text(text)
    assert read_urdf(path).file == path


def test_a_robot_without_collision_shapes_is_as_solid_as_it_looks():
    text = urdf(*TWO).replace(
        '<link name="b"/>', '<link name="b"><visual><geometry><sphere radius="1"/></geometry></visual></link>'
    )
    description = parse_urdf(text)
    assert description.collisions == ()
    assert description.solids == description.visuals
