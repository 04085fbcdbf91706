"""Xacro files are expanded where xacrodoc is installed, in a process that can read the robot's folders and no more."""

import importlib.util
import sys

import pytest

import robust_ik as rik
from robust_ik.description.urdf import xacro_files

pytest.importorskip("xacrodoc")

ARM = """<?xml version="1.0"?>
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="length" default="0.5"/>
  <xacro:arg name="gripper" default="false"/>
  <xacro:property name="turn" value="${pi / 2}"/>
  <xacro:include filename="{parts}"/>
  <link name="base"/>
  <xacro:segment name="one" parent="base"/>
  <xacro:segment name="two" parent="one"/>
  <xacro:if value="$(arg gripper)"><xacro:segment name="hand" parent="two"/></xacro:if>
</robot>"""
PARTS = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="segment" params="name parent">
    <link name="${name}"><visual><geometry><mesh filename="package://arm_description/meshes/a.stl"/></geometry></visual>
    </link>
    <joint name="to_${name}" type="revolute"><parent link="${parent}"/><child link="${name}"/>
      <origin xyz="0 0 $(arg length)"/><axis xyz="0 1 0"/><limit lower="${-turn}" upper="${turn}" velocity="1"/></joint>
  </xacro:macro>
</robot>"""


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "ws/arm_description"
    (folder / "urdf").mkdir(parents=True)
    (tmp_path / "far").mkdir()
    (folder / "meshes").mkdir()
    (folder / "meshes/a.stl").write_text("solid")
    (folder / "package.xml").write_text("<package><name>arm_description</name></package>")
    (folder / "urdf/parts.xacro").write_text(PARTS)
    (tmp_path / "ws/secret.xacro").write_text(PARTS)
    return folder


def arm(package, text=ARM, parts="$(find arm_description)/urdf/parts.xacro"):
    path = package / "urdf/arm.urdf.xacro"
    path.write_text(text.replace("{parts}", parts))
    return path


def test_a_xacro_file_loads_with_its_arguments_and_its_packages(package):
    path = arm(package)
    robot = rik.load(path)
    assert robot.joint_names == ("to_one", "to_two")
    assert robot.pose(robot.neutral)[2, 3] == pytest.approx(1)
    assert robot.description.visuals[0].shape.path == package / "meshes/a.stl"
    assert (robot.description.file, robot.notes) == (path, ())
    given = rik.Robot.from_urdf(path, xacro_args={"length": 2, "gripper": True})
    assert given.n == 3
    assert given.pose(given.neutral)[2, 3] == pytest.approx(6)


def test_packages_of_xacro_are_looked_up_in_the_folders_that_are_given(package, tmp_path):
    path = tmp_path / "far/elsewhere.xacro"
    path.write_text(arm(package).read_text())
    with pytest.raises(rik.UrdfError, match="no folder of package 'arm_description' found: give package_dirs="):
        rik.load(path)
    for given in (tmp_path / "ws", package):
        assert rik.load(path, package_dirs=[given]).n == 2


REFUSED = {
    "outside": ('<xacro:include filename="$(find arm_description)/../secret.xacro"/>', "outside the robot's folders"),
    "by link": ('<xacro:include filename="link.xacro"/>', "outside the robot's folders"),
    "yaml": ("<a b=\"${xacro.load_yaml('/etc/hostname')}\"/>", "outside the robot's folders"),
    "no file": ('<xacro:include filename="none.xacro"/>', "none.xacro"),
    "argument": ("<a b='$(arg nothing)'/>", "'?nothing'?.*--xacro-arg"),
    "name": ("<a b='${nothing}'/>", "nothing"),
    "not XML": ("<a", "not well-formed"),
    "hidden names": ("<a b=\"${().__class__.__mro__}\"/>", "invalid name"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_xacro_file_that_cannot_be_expanded_is_refused_in_one_line(package, case):
    inside, says = REFUSED[case]
    (package / "urdf/link.xacro").symlink_to(package.parent / "secret.xacro")
    path = arm(package, ARM.replace("</robot>", inside + "</robot>"))
    with pytest.raises(rik.UrdfError, match=f"its xacro cannot be expanded: .*{says}") as caught:
        rik.load(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_a_file_of_macros_alone_is_told_from_a_robot(package):
    with pytest.raises(rik.UrdfError, match="writes no link: name the file that uses its macros"):
        rik.load(package / "urdf/parts.xacro")


def test_a_xacro_file_may_not_write_or_start_anything(package):
    # Out of xacro's evaluator, which forbids hidden names only where they stand in the open.
    system = "(lambda: [c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0]"
    for called in ("['system']('touch made')", "['open']('made', 65)"):
        called = f"{system}.__init__.__globals__)(){called}"
        path = arm(package, ARM.replace("</robot>", f'<a b="${{{called}}}"/></robot>'))
        with pytest.raises(rik.UrdfError, match="outside the robot's folders|may not do this"):
            rik.load(path)
    assert not (package / "urdf/made").exists()


def test_a_xacro_file_without_end_is_given_up(package, monkeypatch):
    monkeypatch.setattr(xacro_files, "SECONDS", 2)
    path = arm(package, ARM.replace("</robot>", '<a b="${9**9**9**9}"/></robot>'))
    with pytest.raises(rik.UrdfError, match="given up after 2 seconds|cannot be expanded|ended the process"):
        rik.load(path)


def test_a_xacro_file_that_asks_for_all_memory_is_refused(package):
    path = arm(package, ARM.replace("</robot>", "<a b=\"${'x' * 10**11}\"/></robot>"))
    with pytest.raises(rik.UrdfError, match="cannot be expanded: .*|ended the process"):
        rik.load(path)


def test_arguments_for_what_is_no_xacro_are_refused(package, tmp_path):
    (tmp_path / "a.urdf").write_text("<robot name='r'><link name='a'/></robot>")
    for robot in (tmp_path / "a.urdf", "panda", "pa10"):
        with pytest.raises(rik.InputError, match="argument"):
            rik.load(robot, xacro_args={"length": "1"})
    for wrong in ("length:=1", {1: 2}, {"": "x"}, {"a b": "x"}):
        with pytest.raises(rik.InputError, match="xacro_args must map names to values"):
            rik.load(arm(package), xacro_args=wrong)


def test_without_xacrodoc_it_is_said_how_to_get_it(package, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(rik.LoadError, match=r"pip install 'robust-ik\[xacro\]', or run 'xacro arm.urdf.xacro > "):
        rik.load(arm(package))


def test_the_process_reads_only_where_the_robot_lies():
    from robust_ik.description.meshes.mesh_paths import MeshPaths
    from robust_ik.description.urdf.xacro_process import _Readable

    readable = _Readable(MeshPaths(None))
    readable.audit("open", (sys.executable, "r", 0))
    readable.audit("import", ("x",))
    for event, arguments in [("open", ("/etc/hostname", "r", 0)), ("open", (sys.executable, "w", 1)),
                             ("subprocess.Popen", ()), ("os.system", ()), ("socket.connect", ())]:  # fmt: skip
        with pytest.raises(PermissionError):
            readable.audit(event, arguments)
