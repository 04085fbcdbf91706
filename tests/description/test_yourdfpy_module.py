"""URDF files are read without trimesh, and who uses trimesh and yourdfpy themselves notices nothing.

Each program runs in a process of its own, since what is imported once stays.
"""

import subprocess
import sys

import pytest
import trimesh

MESHES = ("trimesh", "yourdfpy", "scipy", "networkx")
LOAD = "robot = rik.load('arm.urdf')\n"
SCENES = """
import yourdfpy
found = yourdfpy.URDF.load('arm.urdf', build_collision_scene_graph=True, load_collision_meshes=True)
assert [len(each.faces) for each in found.scene.geometry.values()] == [12]
assert len(found.collision_scene.geometry) == 1
assert yourdfpy.urdf.trimesh is sys.modules['trimesh'] and yourdfpy.urdf.tra is sys.modules['trimesh.transformations']
assert yourdfpy.URDF.__module__ == 'yourdfpy.urdf'
"""
WHOLE = """
import trimesh, trimesh.transformations
assert trimesh is sys.modules['trimesh'] and trimesh.transformations is sys.modules['trimesh.transformations']
assert trimesh.__spec__.name == 'trimesh'
below = {name.split('.')[1] for name in sys.modules if name.startswith('trimesh.')}
assert below <= set(dir(trimesh)), below - set(dir(trimesh))
assert trimesh.creation.box().volume == 1.0 and trimesh.load('box.stl').is_watertight
"""
COPY = "from robust_ik.description.yourdfpy_module import urdf\nassert urdf.__name__ == 'robust_ik_yourdfpy'\n"
ITSELF = "from robust_ik.description.yourdfpy_module import urdf\nassert urdf is sys.modules['yourdfpy.urdf']\n"
URDF = """<robot name="arm">
  <material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="a">
    <inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0.1 0.2 0.3" rpy="0.3 -1.2 2.9"/>
      <geometry><mesh filename="box.stl" scale="1 2 3"/></geometry><material name="blue"/></visual>
    <collision><geometry><cylinder radius="0.1" length="0.7"/></geometry></collision>
  </link>
  <link name="b"/><link name="c"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="1 0 0.1" rpy="1 2 3"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-1" upper="2" velocity="3" effort="4"/></joint>
  <joint name="k" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.5" velocity="1" effort="4"/></joint>
</robot>"""


@pytest.fixture
def run(tmp_path):
    """Runs a program in a new process, in a folder with a robot and its mesh."""
    (tmp_path / "arm.urdf").write_text(URDF)
    trimesh.creation.box().export(tmp_path / "box.stl")

    def go(*parts):
        program = "import sys\nimport robust_ik as rik\n" + "\n".join(parts)
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr

    return go


def test_a_urdf_is_read_and_written_without_what_only_meshes_need(run):
    nothing = f"assert not set({MESHES}) & set(sys.modules)"
    run(LOAD, COPY, nothing, "assert rik.load('planar_2r').n == 2", nothing)


@pytest.mark.parametrize("parts", [(SCENES, LOAD, ITSELF, SCENES), (LOAD, COPY, SCENES), (LOAD, SCENES, LOAD, SCENES)])
def test_whoever_uses_yourdfpy_has_scenes_and_meshes_before_and_after(run, parts):
    run(*parts)


@pytest.mark.parametrize("parts", [(WHOLE, LOAD, ITSELF, WHOLE), (LOAD, COPY, WHOLE), (LOAD, WHOLE, SCENES)])
def test_whoever_imports_trimesh_gets_the_whole_of_it(run, parts):
    run(*parts)


def test_the_meshes_of_a_robot_are_read_when_they_are_asked_for(run):
    read = """
from robust_ik.description.meshes import read_mesh
part, = read_mesh(robot.description.visuals[0].shape)
assert abs(part.triangles.vertices).max(axis=0).tolist() == [0.5, 1.0, 1.5]
"""
    run(LOAD, "assert 'trimesh' not in sys.modules", read, WHOLE, SCENES)


def test_it_reads_the_same_as_yourdfpy_itself_and_as_types_too(run):
    same = """
import typing, numpy as np, yourdfpy
from dataclasses import fields, is_dataclass
from robust_ik.description.catalog import catalog
def agree(one, other):
    if is_dataclass(one):
        assert type(one).__qualname__ == type(other).__qualname__
        return all(agree(getattr(one, each.name), getattr(other, each.name)) for each in fields(other))
    if isinstance(one, list):
        return len(one) == len(other) and all(map(agree, one, other))
    return np.array_equal(one, other) if isinstance(one, np.ndarray) else one == other
plain = {'build_scene_graph': False, 'load_meshes': False}
for path in ('arm.urdf', *(str(catalog()[name].path) for name in ('panda', 'talos', 'ur5'))):
    ours, theirs = urdf.URDF.load(path, **plain), yourdfpy.URDF.load(path, **plain)
    assert agree(ours.robot, theirs.robot), path
    assert ours.write_xml_string() == theirs.write_xml_string()
hints = typing.get_type_hints(urdf.URDF.scene.fget)
assert hints == typing.get_type_hints(yourdfpy.URDF.scene.fget), hints
"""
    run(LOAD, COPY, same)


def test_a_version_that_uses_more_of_trimesh_finds_it(run):
    scenes = "assert [len(each.faces) for each in urdf.URDF.load('arm.urdf').scene.geometry.values()] == [12]"
    look = "[hasattr(each, '__warningregistry__') for each in list(sys.modules.values())]"  # as assertWarns of unittest
    run(LOAD, COPY, look, "assert 'trimesh' not in sys.modules", scenes, WHOLE)


@pytest.mark.parametrize("broken", ["exec_module", "get_code", "__init__"])
def test_where_that_way_fails_yourdfpy_itself_is_imported(run, broken):
    breaking = f"""
from importlib.machinery import SourceFileLoader
before = SourceFileLoader.{broken}
def fail(self, name, *rest):
    if 'robust_ik_yourdfpy' in (name, getattr(name, '__name__', name)):
        raise RuntimeError('another version')
    return before(self, name, *rest)
SourceFileLoader.{broken} = fail
"""
    run(breaking, LOAD, ITSELF, "assert 'robust_ik_yourdfpy' not in sys.modules", SCENES, WHOLE)


def test_threads_that_load_and_import_at_once_all_get_what_they_ask_for(run):
    threads = """
import threading
from concurrent.futures import ThreadPoolExecutor
start = threading.Barrier(6)
def load(_):
    start.wait()
    return rik.load('arm.urdf').n
def trimesh(_):
    start.wait()
    import trimesh
    return trimesh.creation.box().volume
with ThreadPoolExecutor(6) as pool:
    loads = [pool.submit(load, i) for i in range(4)]
    imports = [pool.submit(trimesh, i) for i in range(2)]
    assert [each.result() for each in loads] == [2] * 4 and [each.result() for each in imports] == [1.0] * 2
"""
    run(threads, WHOLE, SCENES)
