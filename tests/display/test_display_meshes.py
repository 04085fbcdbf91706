import os
import struct
import time
import zipfile

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from robust_ik.description.joint_tree import Mesh
from robust_ik.description.meshes import mesh_files
from robust_ik.description.meshes.mesh_file_references import ConfinedResolver
from robust_ik.description.meshes.mesh_files import UnreadableMeshError, read_mesh
from robust_ik.description.meshes.triangle_meshes import Triangles, signed_volume, tidy
from robust_ik.description.urdf.urdf_reader import parse_urdf
from robust_ik.display import Scene, draw_robot
from robust_ik.robot.robot import Robot

RED = (1.0, 0.0, 0.0, 1.0)
SUFFIXES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".off")

TRIANGLE_OBJ = "mtllib {mtl}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paint\nf 1 2 3\n"
MTL = "newmtl paint\nKd 1 0 0\n"

DAE = """<?xml version="1.0"?>{doctype}
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="x" meter="{unit}"/><up_axis>{up}</up_axis></asset>
 <library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert>
  <diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
 <library_materials><material id="m" name="{name}"><instance_effect url="#e"/></material></library_materials>
 <library_geometries><geometry id="g"><mesh>
  <source id="p"><float_array id="a" count="9">0 0 0 2 0 0 0 3 0</float_array><technique_common>
   <accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
   <param name="Z" type="float"/></accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s"><node><translate>0 0 10</translate>
  <instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m"/>
  </technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""


def mesh_of(path, scale=(1.0, 1.0, 1.0), root=None):
    return Mesh(path.name, path, scale, root or path.parent)


def dae(path, unit="1", up="Z_UP", doctype="", name="red"):
    path.write_text(DAE.format(unit=unit, up=up, doctype=doctype, name=name))
    return mesh_of(path)


def exported(tmp_path, suffix, shape=None):
    path = tmp_path / f"shape{suffix}"
    (shape or trimesh.creation.box((1.0, 2.0, 3.0))).export(path)
    return path


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".off"])
def test_a_box_is_a_box_in_every_format(tmp_path, suffix):
    parts = read_mesh(mesh_of(exported(tmp_path, suffix), scale=(2.0, 1.0, 0.5)))
    assert_allclose(Triangles.joined([p.triangles for p in parts]).bounds, [[-1, -1, -0.75], [1, 1, 0.75]])
    assert sum(len(p.triangles.faces) for p in parts) == 12


@pytest.mark.parametrize("up", ["X_UP", "Y_UP", "Z_UP"])
def test_the_unit_of_a_collada_file_is_applied_and_its_up_axis_is_not(tmp_path, up):
    (part,) = read_mesh(dae(tmp_path / "a.dae", unit="0.001", up=up))
    assert_allclose(part.triangles.bounds, [[0, 0, 0.01], [0.002, 0.003, 0.01]], rtol=1e-6)
    assert part.color == RED


@pytest.mark.filterwarnings("ignore:Setting the shape on a NumPy array:DeprecationWarning")  # pycollada does
@pytest.mark.parametrize("up", ["Y_UP", "Z_UP"])
def test_a_collada_file_in_metres_lies_where_trimesh_puts_it(tmp_path, up):
    mesh = dae(tmp_path / "a.dae", up=up)
    (part,) = read_mesh(mesh)
    assert_allclose(part.triangles.bounds, trimesh.load(mesh.path, force="scene").bounds, rtol=1e-6)


def test_a_mirrored_mesh_keeps_its_faces_outwards(tmp_path):
    (part,) = read_mesh(mesh_of(exported(tmp_path, ".stl"), scale=(-1.0, 1.0, 1.0)))
    assert signed_volume(part.triangles) == pytest.approx(6.0)
    assert part.triangles.closed


def test_colours_of_vertices_are_kept(tmp_path):
    shape = trimesh.creation.box()
    shape.visual.vertex_colors = np.random.default_rng(0).integers(0, 255, (8, 4), dtype=np.uint8)
    (part,) = read_mesh(mesh_of(exported(tmp_path, ".ply", shape)))
    assert part.color is None
    assert {tuple(c) for c in part.triangles.colors} == {tuple(c) for c in shape.visual.vertex_colors[:, :3]}


def test_a_uniform_colour_is_one_colour(tmp_path):
    shape = trimesh.creation.box()
    shape.visual.vertex_colors = (255, 0, 0, 255)
    (part,) = read_mesh(mesh_of(exported(tmp_path, ".ply", shape)))
    assert part.color == RED
    assert part.triangles.colors is None


# ---------------------------------------------------------------------------------------- confinement
def obj_that_refers_to(folder, mtl):
    folder.mkdir(exist_ok=True, parents=True)
    (folder / "a.obj").write_text(TRIANGLE_OBJ.format(mtl=mtl))
    return folder / "a.obj"


@pytest.mark.parametrize("mtl", ["paint.mtl", "../materials/paint.mtl", "sub/../paint.mtl", "spa%20ce.mtl"])
def test_materials_inside_the_root_are_read(tmp_path, mtl):
    path = obj_that_refers_to(tmp_path / "pkg" / "meshes", mtl)
    for place in ("meshes/paint.mtl", "materials/paint.mtl", "meshes/spa ce.mtl"):
        (tmp_path / "pkg" / place).parent.mkdir(exist_ok=True)
        (tmp_path / "pkg" / place).write_text(MTL)
    (part,) = read_mesh(mesh_of(path, root=tmp_path / "pkg"))
    assert part.color == RED


@pytest.mark.parametrize("kind", ["dots", "absolute", "address", "link", "folder", "fifo"])
def test_what_is_outside_the_root_is_not_read_and_the_mesh_is_drawn_without_it(tmp_path, kind, monkeypatch):
    outside, folder = tmp_path / "outside.mtl", tmp_path / "pkg"
    outside.write_text(MTL)
    name = {
        "dots": "../outside.mtl",
        "absolute": str(outside),
        "address": outside.as_uri(),
    }.get(kind, "inside.mtl")
    path = obj_that_refers_to(folder, name)
    if kind == "link":
        (folder / "inside.mtl").symlink_to(outside)
    if kind == "folder":
        (folder / "inside.mtl").mkdir()
    if kind == "fifo":
        os.mkfifo(folder / "inside.mtl")
    (part,) = read_mesh(mesh_of(path))
    assert part.color != RED
    assert len(part.triangles.faces) == 1
    with pytest.raises(FileNotFoundError):
        ConfinedResolver(folder, folder).get(name)


def test_a_texture_outside_the_root_is_not_read(tmp_path):
    (tmp_path / "secret.png").write_bytes(b"\x89PNG")
    folder = tmp_path / "pkg"
    path = obj_that_refers_to(folder, "paint.mtl")
    (folder / "paint.mtl").write_text(MTL + "map_Kd ../secret.png\n")
    (part,) = read_mesh(mesh_of(path))
    assert part.color == RED


def test_a_buffer_outside_the_root_makes_the_mesh_unreadable(tmp_path):
    folder = tmp_path / "pkg"
    folder.mkdir()
    trimesh.Scene(trimesh.creation.box()).export(str(folder / "a.gltf"))
    assert read_mesh(mesh_of(folder / "a.gltf"))
    text = (folder / "a.gltf").read_text()
    for buffer in folder.glob("*.bin"):
        buffer.rename(tmp_path / buffer.name)
        text = text.replace(buffer.name, f"../{buffer.name}")
    (folder / "a.gltf").write_text(text)
    with pytest.raises(UnreadableMeshError):
        read_mesh(mesh_of(folder / "a.gltf"))


def test_nothing_is_listed_or_written_beside_a_mesh(tmp_path):
    resolver = ConfinedResolver(tmp_path, tmp_path)
    assert list(resolver.keys()) == []
    with pytest.raises(PermissionError):
        resolver.write("a", b"")
    with pytest.raises(FileNotFoundError):
        resolver.namespaced("..").get(f"../{tmp_path.name}/../x")


def test_an_external_entity_is_not_read(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("0.5")
    doctype = f'<!DOCTYPE x [<!ENTITY e SYSTEM "{secret.as_uri()}">]>'
    mesh = dae(tmp_path / "a.dae", doctype=doctype)
    mesh.path.write_text(mesh.path.read_text().replace("1 0 0 1</color>", "&e; 0 0 1</color>"))
    try:
        (part,) = read_mesh(mesh)
    except UnreadableMeshError:
        return
    assert part.color is None or part.color[0] != pytest.approx(0.5, abs=0.01)


def test_entities_that_multiply_are_refused_quickly(tmp_path):
    entities = "".join(f'<!ENTITY e{i + 1} "{f"&e{i};" * 10}">' for i in range(30))
    mesh = dae(tmp_path / "a.dae", doctype=f'<!DOCTYPE x [<!ENTITY e0 "ha">{entities}]>', name="&e30;")
    started = time.process_time()
    with pytest.raises(UnreadableMeshError):
        read_mesh(mesh)
    assert time.process_time() - started < 30  # 10³⁰ of them would never end


# ---------------------------------------------------------------------------------------- broken files
CONTENTS = {
    "nothing": b"",
    "zeros": bytes(300),
    "noise": np.random.default_rng(0).bytes(2000),
    "text": "not a mesh at all, ähem\n".encode() * 20,
    "xml": b"<COLLADA><library_geometries/></COLLADA>",
    "deep xml": b"<a>" * 5000,
    "json": b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "x.bin", "byteLength": 8}], "meshes": [{}]}',
    "faces without vertices": b"f 1 2 3\nf 9999 1 -5\n",
    "huge binary stl": bytes(80) + struct.pack("<I", 0xFFFFFFFF) + bytes(50),
    "lying ply": b"ply\nformat ascii 1.0\nelement vertex 99999999\nproperty float x\nend_header\n1\n",
    "nan": b"solid x\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\nvertex inf 1 0\nvertex 0 0 1\nendloop\n"
    b"endfacet\nendsolid\n",
}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", CONTENTS)
def test_a_broken_file_is_told_and_never_raises_anything_else(tmp_path, suffix, content, capfd):
    path = tmp_path / f"broken{suffix}"
    path.write_bytes(CONTENTS[content])
    with pytest.raises(UnreadableMeshError):
        read_mesh(mesh_of(path))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb", ".off", ".dae"])
def test_damaged_files_are_read_or_refused(tmp_path, suffix):
    whole = dae(tmp_path / "a.dae").path.read_bytes() if suffix == ".dae" else exported(tmp_path, suffix).read_bytes()
    rng, path = np.random.default_rng(1), tmp_path / f"damaged{suffix}"
    for trial in range(40):
        data = bytearray(whole[: rng.integers(1, len(whole))] if trial % 2 else whole)
        for place in rng.integers(0, len(data), 1 + trial // 4):
            data[place] = rng.integers(0, 256)
        path.write_bytes(data)
        try:
            parts = read_mesh(mesh_of(path))
        except UnreadableMeshError:
            continue
        for part in parts:
            assert np.isfinite(part.triangles.vertices).all()
            assert part.triangles.faces.max() < len(part.triangles.vertices)


def test_missing_zipped_and_oversized_files_are_refused_with_a_reason(tmp_path, monkeypatch):
    with pytest.raises(UnreadableMeshError, match="no folder of package"):
        read_mesh(Mesh("package://a/b.stl", None, (1.0, 1.0, 1.0), None, "no folder of package 'a' found"))
    with pytest.raises(UnreadableMeshError, match="is no file"):
        read_mesh(mesh_of(tmp_path / "gone.stl"))
    with zipfile.ZipFile(tmp_path / "a.dae", "w") as archive:
        archive.writestr("a.dae", DAE)
    with pytest.raises(UnreadableMeshError, match="zip"):
        read_mesh(mesh_of(tmp_path / "a.dae"))
    monkeypatch.setattr(mesh_files, "MAX_BYTES", 100)
    with pytest.raises(UnreadableMeshError, match="larger than"):
        read_mesh(mesh_of(exported(tmp_path, ".stl")))


# ---------------------------------------------------------------------------------------- triangles
def soup(shape):
    corners = np.asarray(shape.vertices)[np.asarray(shape.faces)].reshape(-1, 3)
    return Triangles.of(corners, np.arange(len(corners)))


def test_sharp_edges_are_split_and_smooth_ones_shared():
    assert len(tidy(soup(trimesh.creation.box())).vertices) == 24
    ball = trimesh.creation.icosphere(subdivisions=3)
    assert len(tidy(soup(ball)).vertices) == len(ball.vertices)


def test_detail_is_dropped_but_not_the_shape():
    ball = trimesh.creation.icosphere(subdivisions=5)
    light = tidy(soup(ball), max_faces=3000)
    assert 500 < len(light.faces) <= 3000
    assert signed_volume(light) == pytest.approx(4 / 3 * np.pi, rel=0.03)


def test_closed_shapes_are_told_from_open_ones():
    box = trimesh.creation.box()
    assert tidy(soup(box)).closed
    box.update_faces(np.arange(12) > 1)
    assert not tidy(soup(box)).closed
    box = trimesh.creation.box()
    box.invert()
    assert not tidy(soup(box)).closed


def test_vertices_that_are_not_finite_go_with_their_faces():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]])
    mesh = tidy(Triangles.of(vertices, [[0, 1, 2], [0, 1, 3]]))
    assert len(mesh.faces) == 1
    assert len(tidy(Triangles.of(vertices, [[0, 1, 3]])).faces) == 0


def test_where_meshes_are_missing_links_without_shapes_are_drawn_too():
    """Else the arm would end in mid-air: here the first link's mesh is missing and the second has no visual."""
    links = '<link name="a"><visual><geometry><mesh filename="gone.stl"/></geometry></visual></link><link name="b"/>'
    joints = "".join(
        f'<joint name="j{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        '<origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        for parent, child in ("ab", "bc")
    )
    robot = Robot.from_description(parse_urdf(f'<robot name="r">{links}<link name="c"/>{joints}</robot>'))
    drawn = draw_robot(Scene()["robot"], robot)
    assert {"a", "b"} <= set(drawn.nodes)
