"""What a mesh path may reach: the robot's own files, declared packages, and nothing else."""

import json
import os
import struct
from pathlib import Path

import numpy as np
import pytest

from robust_ik.description.joint_tree import Mesh
from robust_ik.description.meshes import mesh_paths
from robust_ik.description.meshes.confined_reading import read_inside
from robust_ik.description.meshes.mesh_file_references import ConfinedResolver
from robust_ik.description.meshes.mesh_files import UnreadableMeshError, read_mesh
from robust_ik.description.meshes.mesh_paths import MeshPaths, is_shared


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A home with a secret mesh, and a robot downloaded into it."""
    place = tmp_path / "home" / "ann"
    for name in ("robot/urdf", "robot/meshes", "secrets", "ws/src/arm_description/urdf/old"):
        (place / name).mkdir(parents=True)
    for name in ("robot/meshes/a.stl", "secrets/s.stl", "s.stl", "ws/src/arm_description/a.stl"):
        (place / name).write_text("solid")
    monkeypatch.setenv("HOME", str(place))
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    return place


def found(folder, name, *package_dirs):
    return MeshPaths.of(folder, package_dirs).resolve(name)


def test_an_ancestor_is_no_package_because_it_is_called_so(home):
    for name in ("package://ann/s.stl", "package://ann/secrets/s.stl", "package://home/ann/s.stl"):
        for folder in (home / "robot", home / "robot/urdf", home / "robot/deep/down"):
            assert found(folder, name).path is None
    tmp = home.parent.parent
    assert found(home / "robot", f"package://{tmp.name}/home/ann/s.stl").path is None
    assert found(home / "robot", f"package://{tmp.parent.name}/{tmp.name}/home/ann/s.stl").path is None


def test_the_refusal_says_which_folder_to_give_and_then_it_is_found(home):
    refused = found(home / "robot/urdf", "package://ann/s.stl")
    assert f"{home} is called 'ann' but is no package" in refused.problem
    assert "--package-dir" in refused.problem
    assert found(home / "robot/urdf", "package://ann/s.stl", home).path == home / "s.stl"


def test_a_home_is_no_package_even_if_there_is_a_package_xml_in_it(home):
    (home / "package.xml").write_text("<package/>")
    assert found(home / "robot/urdf", "package://ann/s.stl").path is None
    assert found(home / "robot", "../s.stl").path is None


def test_what_everyone_shares_is_no_package_of_a_urdf_folder_in_it(home, monkeypatch):
    monkeypatch.setattr(mesh_paths.tempfile, "gettempdir", lambda: str(home / "passing"))
    (home / "passing/urdf").mkdir(parents=True)
    (home / "passing/other.stl").write_text("solid")
    (home / "urdf").mkdir()
    for shared in (home, home / "passing"):
        assert is_shared(shared)
        for name in ("../other.stl", "../s.stl", f"package://{shared.name}/s.stl"):
            assert found(shared / "urdf", name).path is None
    for folder in ("/", "/tmp", "/home", "/etc", "/usr", "/opt", str(home.parent / "bob")):
        assert is_shared(Path(folder))
    assert not is_shared(home / "robot")


@pytest.mark.parametrize("target", ["/", "../secrets", "..", "/tmp"])
def test_a_link_is_no_package(home, target):
    (home / "robot/p").symlink_to(target)
    (home / "robot/urdf/p").symlink_to(target)
    for folder in (home / "robot", home / "robot/urdf"):
        for name in ("package://p/s.stl", f"package://p{home}/s.stl", "package://p/secrets/s.stl", "p/s.stl"):
            assert found(folder, name).path is None
            assert found(folder, name, home / "robot").path is None


def test_a_package_that_a_workspace_of_ros_links_to_is_found_and_other_links_are_not(home, monkeypatch):
    (home / "ws/src/linked").symlink_to(home / "secrets")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(home / "ws/src"))
    assert found(home / "robot", "package://linked/s.stl").path is None
    (home / "secrets/package.xml").write_text("<package/>")
    assert found(home / "robot", "package://linked/s.stl").path == home / "secrets/s.stl"


@pytest.mark.parametrize("name", ["package://arm_description/a.stl", "package://arm_description/urdf/../a.stl"])
def test_a_folder_called_like_a_robots_package_is_one_without_package_xml(home, name):
    for folder in ("urdf", "urdf/old", "."):
        assert found(home / "ws/src/arm_description" / folder, name).path is not None


def test_the_folder_around_urdf_is_the_robots_own(home):
    for name in ("package://robot/meshes/a.stl", "../meshes/a.stl", f"file://{home}/robot/meshes/a.stl"):
        assert found(home / "robot/urdf", name).path == home / "robot/meshes/a.stl"


def test_the_folder_around_robots_is_the_robots_own_only_if_there_are_meshes(home):
    (home / "things/robots").mkdir(parents=True)
    (home / "things/a.stl").write_text("solid")
    assert found(home / "things/robots", "../a.stl").path is None
    (home / "things/meshes").mkdir()
    assert found(home / "things/robots", "../a.stl").path is not None


def test_the_path_is_the_real_one_so_that_nothing_can_be_put_in_between(home):
    (home / "robot/meshes/b.stl").symlink_to("a.stl")
    (home / "robot/more").symlink_to("meshes")
    for name in ("meshes/b.stl", "more/a.stl", "package://robot/more/b.stl"):
        assert found(home / "robot", name).path == home / "robot/meshes/a.stl"


def test_every_path_is_the_real_one_whatever_was_asked_for_before(home):
    for name, target in (("link.stl", home / "robot/meshes/a.stl"), ("out.stl", home / "s.stl")):
        (home / "robot/meshes" / name).symlink_to(target)
    (home / "robot/again").symlink_to(home / "robot/meshes")
    (home / "robot/away").symlink_to(home / "secrets")
    paths = MeshPaths.of(home / "robot/urdf", ())
    for _ in range(2):
        for name in ("meshes/a.stl", "meshes/link.stl", "again/a.stl", "again/link.stl"):
            assert paths.resolve(f"../{name}").path == home / "robot/meshes/a.stl"
        for name in ("meshes/out.stl", "again/out.stl", "away/s.stl"):
            assert "is a link that leads out" in paths.resolve(f"../{name}").problem


def test_a_file_exchanged_for_a_link_after_it_was_found_is_not_read(home):
    path = found(home / "robot", "meshes/a.stl").path
    assert read_inside(path, home / "robot", 100) == b"solid"
    path.unlink()
    path.symlink_to(home / "secrets/s.stl")
    with pytest.raises(OSError, match="is not in"):
        read_inside(path, home / "robot", 100)
    with pytest.raises(UnreadableMeshError, match="no file that can be read"):
        read_mesh(Mesh("a.stl", path, (1, 1, 1), home / "robot"))
    path.unlink()
    (home / "robot/meshes").rename(home / "robot/old")
    (home / "robot/meshes").symlink_to(home)
    with pytest.raises(OSError, match="is not in"):
        read_inside(home / "robot/meshes/s.stl", home / "robot", 100)


def test_pipes_folders_and_large_files_are_not_read(home):
    os.mkfifo(home / "robot/pipe.stl")
    for name in ("robot/pipe.stl", "robot/meshes"):
        with pytest.raises(OSError, match="is no file|directory"):
            read_inside(home / name, home, 100)
    with pytest.raises(ValueError, match="larger"):
        read_inside(home / "s.stl", home, 3)


# --------------------------------------------------------------------------------- what a mesh refers to
SECRET = np.array([[7, 7, 7], [8, 7, 7], [7, 8, 7]], dtype="<f4").tobytes()


def gltf(path, uri, images=()):
    """A triangle whose corners are read from a file."""
    header = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri, "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "count": 3, "componentType": 5126, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "images": [{"uri": image} for image in images],
    }
    path.write_text(json.dumps(header))
    return Mesh(path.name, path, (1.0, 1.0, 1.0), path.parent)


def test_a_buffer_inside_is_read(tmp_path):
    (tmp_path / "a b.bin").write_bytes(SECRET)
    for uri in ("a b.bin", "a%20b.bin", "./a%20b.bin"):
        (part,) = read_mesh(gltf(tmp_path / "a.gltf", uri))
        assert part.triangles.vertices.max() == 8


@pytest.mark.parametrize(
    "uri",
    ["../secret.bin", "%2e%2e/secret.bin", "..%2fsecret.bin", "sub/../../secret.bin", "..\\secret.bin", "link.bin",
     "folder/secret.bin", "file://{}/secret.bin", "{}/secret.bin", "inside.txt", ".hidden/secret.bin", "inside",
     "%252e%252e/secret.bin", "data:;base64", "data:../secret.bin", "link.bin\0.bin", "//{}/secret.bin"],
)  # fmt: skip
def test_a_buffer_or_image_that_is_outside_hidden_or_none_is_not_read(tmp_path, uri):
    robot = tmp_path / "robot"
    (robot / ".hidden").mkdir(parents=True)
    for name in ("secret.bin", "robot/inside.txt", "robot/.hidden/secret.bin", "robot/inside"):
        (tmp_path / name).write_bytes(SECRET)
    (robot / "link.bin").symlink_to("../secret.bin")
    (robot / "folder").symlink_to("..")
    uri = uri.format(tmp_path)
    with pytest.raises(UnreadableMeshError):
        read_mesh(gltf(robot / "a.gltf", uri))
    with pytest.raises(FileNotFoundError):
        ConfinedResolver(robot, robot).get(uri)


def test_a_json_that_is_broken_makes_trimesh_look_for_no_other(tmp_path):
    gltf(tmp_path / "model.gltf", "a.bin")
    (tmp_path / "a.bin").write_bytes(SECRET)
    (tmp_path / "b.gltf").write_text("{")
    with pytest.raises(UnreadableMeshError):
        read_mesh(Mesh("b.gltf", tmp_path / "b.gltf", (1, 1, 1), tmp_path))


def test_all_that_a_mesh_refers_to_is_bounded_together(tmp_path, monkeypatch):
    (tmp_path / "a.bin").write_bytes(bytes(60))
    monkeypatch.setattr("robust_ik.description.meshes.mesh_file_references.MAX_REFERENCE_BYTES", 100)
    resolver = ConfinedResolver(tmp_path, tmp_path)
    assert len(resolver.get("a.bin")) == 60
    with pytest.raises(FileNotFoundError):
        resolver.get("a.bin")


def test_a_mesh_is_of_the_kind_that_its_name_says_whatever_a_link_leads_to(tmp_path):
    (tmp_path / "0123").write_bytes(bytes(80) + struct.pack("<I", 1) + bytes(12) + SECRET + bytes(2))
    (tmp_path / "a.stl").symlink_to("0123")
    mesh = found(tmp_path, "a.stl")
    assert mesh.path == tmp_path / "0123"
    (part,) = read_mesh(Mesh("a.stl", mesh.path, (1.0, 1.0, 1.0), mesh.root))
    assert part.triangles.vertices.max() == 8
