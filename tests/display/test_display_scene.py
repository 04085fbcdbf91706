import base64
import hashlib
import re
import socket
from html.parser import HTMLParser

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from robust_ik.description.meshes.triangle_meshes import signed_volume
from robust_ik.display import Scene, draw_configuration, draw_robot
from robust_ik.display.scene.animation_tracks import Tracks
from robust_ik.display.scene.camera import View
from robust_ik.display.scene.meshcat_module import geometry, umsgpack
from robust_ik.display.scene.node_names import distinct, node_names
from robust_ik.display.scene.packed_scene import packed_scene
from robust_ik.display.scene.primitives import double_arrow, revolved, rod, swept_tube, turning_ring
from robust_ik.errors import InputError
from robust_ik.robot.robot import Robot
from robust_ik.runtime.output_files import write_file

ARM = """<robot name="arm">
 <link name="base"><visual><origin xyz="0 0 1"/><geometry>{base}</geometry>
  <material name="c"><color rgba="1 0.5 0 0.5"/></material></visual></link>
 <link name="{upper}">{visual}</link>
 <link name="hand"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
 <joint name="shoulder" type="revolute"><parent link="base"/><child link="{upper}"/><origin xyz="0 0 2"/>
  <axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
 <joint name="elbow" type="revolute"><parent link="{upper}"/><child link="hand"/><origin xyz="1 0 0"/>
  <axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
</robot>"""
CYLINDER = '<cylinder radius="0.2" length="1.6"/>'
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual>'


def arm(tmp_path, base=CYLINDER, upper="upper", visual=""):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM.format(base=base, upper=upper, visual=visual), encoding="utf-8")
    return Robot.from_urdf(path, tip="hand")


def contents(scene):
    return [umsgpack.unpackb(command) for command in scene.commands]


def of_type(scene, kind):
    return {command["path"]: command for command in contents(scene) if command["type"] == kind}


# ---------------------------------------------------------------------------------------- recording
def test_a_recorded_scene_holds_what_a_visualizer_was_told():
    scene = Scene()
    box = geometry.Box([1, 2, 3])
    scene["a/b"].set_object(box)
    scene["a/b"].set_transform(np.diag([1.0, 2, 3, 1]))
    scene["a"].set_property("visible", False)
    assert [(c["type"], c["path"]) for c in contents(scene)] == [
        ("set_property", "/meshcat/a"),
        ("set_object", "/meshcat/a/b"),
        ("set_transform", "/meshcat/a/b"),
    ]


def test_what_is_said_again_replaces_what_was_said():
    scene = Scene()
    for value in range(50):
        scene["a"].set_property("visible", value % 2 == 0)
        scene["a"].set_property("color", [value, 0, 0, 1])
        scene["a"].set_transform(np.eye(4))
    assert [c.get("value") for c in contents(scene)] == [False, [49, 0, 0, 1], None]


def test_deleting_removes_everything_below_and_unknown_paths_are_no_matter():
    scene = Scene()
    scene["a/b"].set_object(geometry.Box([1, 1, 1]))
    scene["c"].set_property("visible", True)
    scene["nothing/here"].delete()
    scene["a"].delete()
    assert [c["path"] for c in contents(scene)] == ["/meshcat/c"]
    scene["/"].delete()
    assert contents(scene) == []


def test_a_command_that_needs_a_browser_is_refused():
    with pytest.raises(InputError, match="capture_image"):
        Scene().visualizer.window.send(type("Capture", (), {"lower": lambda self: {"type": "capture_image"}})())


def test_clearing_ends_what_plays(tmp_path):
    scene = Scene()
    scene.clear()
    assert contents(scene) == []
    scene.visualizer.window.send(Tracks(np.arange(3.0)).command())
    scene["a"].set_property("visible", True)
    scene.clear()
    assert [(c["type"], c["animations"]) for c in contents(scene)] == [("set_animation", [])]


def test_no_socket_is_opened_for_a_file(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a socket was opened")

    monkeypatch.setattr(socket, "socket", refuse)
    scene = Scene()
    draw_configuration(scene, arm(tmp_path))
    assert scene.save(tmp_path / "scene.html").stat().st_size > 500_000
    assert scene.url is None


# ---------------------------------------------------------------------------------------- packing
def test_a_geometry_that_is_shown_often_is_packed_once_and_found_again():
    scene, box = Scene(), trimesh.creation.icosphere(subdivisions=3)
    for index in range(5):
        shape = geometry.TriangularMeshGeometry(box.vertices, box.faces)
        scene[f"ball{index}"].set_object(shape)
    packed = [umsgpack.unpackb(base64.b64decode(text)) for text in packed_scene(scene.commands)]
    shared = {c["key"]: c["geometry"] for c in packed if c["type"] == "share_geometry"}
    objects = [c["object"] for c in packed if c["type"] == "set_object"]
    assert len(shared) == 1
    assert len(objects) == 5
    for described in objects:
        (reference,) = described["geometries"]
        assert reference["uuid"] == described["object"]["geometry"]
        assert shared[reference["shared"]]["data"]["attributes"]["position"]["itemSize"] == 3


def test_the_same_scene_packs_to_the_same_text(tmp_path):
    scenes = [Scene(), Scene()]
    for scene in scenes:
        draw_configuration(scene, arm(tmp_path))
    assert packed_scene(scenes[0].commands) == packed_scene(scenes[1].commands)


# ---------------------------------------------------------------------------------------- robots
def test_every_link_stands_where_the_robot_says(tmp_path):
    robot, scene = arm(tmp_path, visual=f"<visual><geometry>{CYLINDER}</geometry></visual>"), Scene()
    drawn = draw_robot(scene["robot"], robot)
    q = np.array([0.3, -0.7])
    drawn.show(q)
    transforms = of_type(scene, "set_transform")
    assert set(drawn.nodes) == {"base", "upper", "hand"}
    for link, node in drawn.nodes.items():
        matrix = np.reshape(transforms[f"/meshcat/robot/{node}"]["matrix"], (4, 4)).T
        assert_allclose(matrix, robot.pose(q, link), atol=1e-12)


@pytest.mark.parametrize(
    ("base", "kind", "half"),
    [
        (CYLINDER, "CylinderGeometry", [0.2, 0.2, 0.8]),
        ('<box size="0.2 0.4 0.6"/>', "BoxGeometry", [0.1, 0.2, 0.3]),
        ('<sphere radius="0.3"/>', "SphereGeometry", [0.3, 0.3, 0.3]),
    ],
)
def test_primitives_lie_as_in_the_urdf(tmp_path, base, kind, half):
    robot, scene = arm(tmp_path, base=base), Scene()
    drawn = draw_robot(scene["robot"], robot)
    path = f"/meshcat/robot/{drawn.nodes['base']}/visual0"
    described = of_type(scene, "set_object")[path]["object"]
    assert described["geometries"][0]["type"] == kind
    assert described["materials"][0]["color"] == 0xFF8000
    assert described["materials"][0]["opacity"] == 0.5
    matrix = np.reshape(of_type(scene, "set_transform")[path]["matrix"], (4, 4)).T
    assert_allclose(matrix[:3, 3], [0, 0, 1])
    if kind == "CylinderGeometry":
        assert_allclose(np.abs(matrix[:3, :3] @ [0, 1, 0]), [0, 0, 1], atol=1e-12)
    assert_allclose(drawn.corners["base"].max(axis=0), np.add(half, [0, 0, 1]), atol=1e-12)


def test_a_mesh_is_drawn_in_the_colour_of_the_urdf_before_its_own(tmp_path):
    shape = trimesh.creation.box((0.2, 0.2, 0.2))
    shape.visual.vertex_colors = (255, 0, 0, 255)
    shape.export(tmp_path / "red.ply")
    scene = Scene()
    draw_robot(scene["robot"], arm(tmp_path, base='<mesh filename="red.ply"/>', visual=MESH.format("red.ply")))
    colors = [c["object"]["materials"][0]["color"] for c in of_type(scene, "set_object").values()]
    assert colors[:2] == [0xFF8000, 0xFF0000]


def test_missing_and_broken_meshes_are_listed_and_stood_in_for(tmp_path):
    (tmp_path / "broken.stl").write_bytes(b"solid nothing")
    visual = MESH.format("gone.stl") + MESH.format("broken.stl") + MESH.format("package://nowhere/a.dae")
    scene = Scene()
    drawn = draw_robot(scene["robot"], arm(tmp_path, visual=visual))
    assert [lost.name for lost in drawn.missing_meshes] == ["gone.stl", "broken.stl", "package://nowhere/a.dae"]
    assert {lost.link for lost in drawn.missing_meshes} == {"upper"}
    assert all(lost.reason for lost in drawn.missing_meshes)
    shown = [path for path in of_type(scene, "set_object") if drawn.nodes["upper"] in path]
    assert {path.rsplit("/", 1)[1] for path in shown} == {"bones", "knuckle"}
    # The bone reaches from the shoulder to the elbow.
    assert drawn.corners["upper"][:, 0].max() == pytest.approx(1, abs=0.05)


def test_a_robot_without_any_shape_is_drawn_as_a_skeleton(tmp_path):
    robot = arm(tmp_path)
    bare = type(robot.description)(**{**vars_of(robot.description), "visuals": ()})
    drawn = draw_robot(Scene()["robot"], Robot.from_description(bare, "hand"))
    assert set(drawn.nodes) == {"base", "upper", "hand"}
    assert drawn.missing_meshes == ()


def vars_of(description):
    return {name: getattr(description, name) for name in description.__dataclass_fields__}


@pytest.mark.parametrize(
    "name", ["a/b", "constructor", "__proto__", "..", "&lt;i&gt;", "ünï cödé", "&#x2028;", "x" * 500]
)
def test_any_link_name_makes_one_safe_node(tmp_path, name):
    scene = Scene()
    drawn = draw_robot(scene["robot"], arm(tmp_path, upper=name, visual=MESH.format("gone.stl")))
    paths = of_type(scene, "set_object")
    assert all(re.fullmatch(r"/meshcat/robot/\d+_[\w.-]{1,60}/\w+", path, re.ASCII) for path in paths)
    assert len(set(drawn.nodes.values())) == 3


def test_node_names_and_labels_are_told_apart():
    assert len(set(node_names(["a/b", "a b", "a_b", "a:b"]).values())) == 4
    assert distinct(["a", "b", "a", "a", "a (2)"]) == ["a", "b", "a (2)", "a (3)", "a (2) (2)"]


def test_a_configuration_shows_what_is_lost_there(tmp_path):
    scene = Scene()
    draw_configuration(scene, arm(tmp_path).with_rows(("x", "z")), np.array([0.4, 0.0]))
    shown = {c["path"]: c["value"] for c in contents(scene) if c.get("property") == "visible"}
    assert shown["/meshcat/lost/arrow0"] is True
    assert shown["/meshcat/lost/ring0"] is False
    arrow = np.reshape(of_type(scene, "set_transform")["/meshcat/lost/arrow0"]["matrix"], (4, 4)).T
    along = arrow[:3, 2] / np.linalg.norm(arrow[:3, 2])
    assert_allclose(np.abs(along), [np.cos(0.4), 0, np.sin(0.4)], atol=1e-9)


# ---------------------------------------------------------------------------------------- shapes and views
@pytest.mark.parametrize("shape", [double_arrow(), turning_ring(), rod(np.zeros(3), np.array([0, 1.0, 2]), 0.1)])
def test_solids_look_outwards(shape):
    assert signed_volume(shape) > 0
    assert np.isfinite(shape.vertices).all()


def test_a_revolved_triangle_is_a_cone():
    cone = revolved(np.array([(0, 0), (1, 0), (0, 3.0)]), sides=200)
    assert signed_volume(cone) == pytest.approx(np.pi, rel=1e-3)


def test_a_tube_has_as_many_faces_between_any_two_points():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [0.5, 0, 0], [1e6, 1, 0]])
    tube = swept_tube(points, 0.1, sides=5)
    assert len(tube.faces) == 4 * 10
    assert np.isfinite(tube.vertices).all()
    assert set((tube.faces[:10] // 5).ravel()) == {0, 1}


@pytest.mark.parametrize("flat", [(1, 1, 1), (1, 1, 0), (1, 0, 1), (0, 0, 1), (0, 0, 0)])
def test_the_camera_sees_every_point_from_above(flat):
    points = np.random.default_rng(0).normal(size=(50, 3)) * flat
    view = View.of(points)
    assert (np.linalg.norm(points - view.center, axis=1) <= view.radius + 1e-12).all()
    assert np.linalg.norm(view.direction) == pytest.approx(1)
    assert view.direction[2] > 0.2


def test_the_camera_looks_across_the_motion():
    view = View.of(np.random.default_rng(0).normal(size=(50, 3)), along=np.array([0, 2.0, 0]))
    assert abs(view.direction[1]) < 0.6


# ---------------------------------------------------------------------------------------- pages
class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self.title = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.lasttag == "script" and data.strip():
            self.scripts.append(data)
        if self.lasttag == "title" and not self.title:
            self.title = data


def test_a_page_fetches_nothing_and_runs_only_its_own_scripts():
    page = Scene().html("Robot </title><script>alert(1)</script>")
    tags = Tags(page)
    assert tags.title == "Robot </title><script>alert(1)</script>"
    assert [tag for tag, _ in tags.tags].count("script") == 3
    for tag, attributes in tags.tags:
        assert "src" not in attributes, tag
        assert not attributes.get("href", "data:").startswith(("http", "//")), tag
    policy = next(a["content"] for _, a in tags.tags if "http-equiv" in a)
    assert "default-src 'none'" in policy
    for script in tags.scripts[1:]:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    style = page.split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style


def test_a_page_is_written_at_once_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "folder" / "page.html"
    assert write_file(path, "first ü") == path
    assert path.read_text(encoding="utf-8") == "first ü"
    assert path.stat().st_mode & 0o777 == 0o666 & ~_umask(tmp_path)
    monkeypatch.setattr("pathlib.Path.replace", _fail)
    with pytest.raises(InputError, match="disk full"):
        write_file(path, "second")
    assert [p.name for p in path.parent.iterdir()] == ["page.html"]
    assert path.read_text(encoding="utf-8") == "first ü"


def _fail(*_):
    raise OSError("disk full")


def _umask(tmp_path):
    (tmp_path / "plain").touch()
    return 0o666 & ~(tmp_path / "plain").stat().st_mode


def test_a_folder_or_a_file_in_the_way_is_refused_clearly(tmp_path):
    with pytest.raises(InputError, match="is a folder; give the name of a file"):
        Scene().save(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is no folder"):
        Scene().save(tmp_path / "file" / "page.html")


def test_a_notebook_shows_a_scene_in_a_frame_that_cannot_break_out():
    shown = Scene()._repr_html_()
    tags = Tags(shown).tags
    assert [tag for tag, _ in tags] == ["iframe"]
    assert tags[0][1]["srcdoc"] == Scene().html()
