"""Meshes that would take too long or too much to read are refused by what they claim."""

import json
import struct

import numpy as np
import pytest
import trimesh

from robust_ik.description.joint_tree import Mesh
from robust_ik.description.meshes import mesh_files, mesh_size_limits
from robust_ik.description.meshes.mesh_files import UnreadableMeshError, read_mesh
from robust_ik.description.meshes.triangle_meshes import Triangles, tidy

HEAD = '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_geometries>'
HEAD += "<geometry id='g'><mesh><triangles><p>0 1 2 2 1 0</p></triangles></mesh></geometry>"
HEAD += "</library_geometries><library_nodes>"
TAIL = '</library_nodes><library_visual_scenes><visual_scene id="s">{}</visual_scene></library_visual_scenes></COLLADA>'
SHOWN = '<node><instance_geometry url="#g"/></node>'
CIRCLE = '<node id="n0"><instance_node url="#n0"/></node>'
INSTANCE = '<node><instance_node url="#n0"/></node>'


def doubling(depth):
    """Nodes each of which holds the next one twice."""
    twice = "".join(f'<node id="n{i}">{2 * f"<instance_node url=§#n{i + 1}§/>"}</node>' for i in range(depth))
    return (twice + f'<node id="n{depth}"><instance_geometry url="#g"/></node>').replace("§", '"')


def gltf(**changed):
    header = {"asset": {"version": "2.0"}, "accessors": [{"count": 3, "componentType": 5126, "type": "VEC3"}]}
    return json.dumps(header | changed).encode()


def primitives(count, accessor):
    return {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * count}], "accessors": [accessor]}


LARGE = {"count": 3000, "componentType": 5126, "type": "VEC3"}
MANY = mesh_size_limits.MAX_FACE_LINES + 1
REFUSED = {
    "a doubling scene.dae": ((HEAD + doubling(40) + TAIL.format(INSTANCE)).encode(), "triangles"),
    "a scene in itself.dae": ((HEAD + CIRCLE + TAIL.format(INSTANCE)).encode(), "hold each other"),
    "many instances.dae": ((HEAD + TAIL.format(10_000 * SHOWN)).replace("2 1 0", 200 * "0 1 2 ").encode(), "triangles"),
    "many elements.dae": ((HEAD + "<a/>" * 70_000 + TAIL).encode(), "elements"),
    "many numbers.dae": ((HEAD + "0 " * 12_100_000 + TAIL).encode(), "numbers"),
    "an entity.dae": (b'<!DOCTYPE x [<!ENTITY a "b">]>' + HEAD.encode(), "DOCTYPE"),
    "a large accessor.gltf": (gltf(accessors=[{"count": 10**9, "componentType": 5126, "type": "MAT4"}]), "numbers"),
    "a negative accessor.gltf": (gltf(accessors=[{"count": -1, "componentType": 5126, "type": "VEC3"}]), "negative"),
    "one accessor often.gltf": (gltf(**primitives(2000, LARGE)), "triangles"),
    "many nodes.gltf": (gltf(nodes=[{}] * 30_000), "signs '{'"),
    "deep lists.gltf": (b"[" * 100_000, "signs"),
    "many faces.obj": (b"v 0 0 0\n" + b"f 1 1 1\n" * MANY, "faces"),
    "many groups.obj": (b"usemtl a\nf 1 1 1\n" * 3000, "groups"),
    "a long face.obj": (b"f " + b"1 " * 20_000 + b"\n", "line of over"),
    "a long face in pieces.obj": (b"f " + b"1 1 1 \\\n" * 9_000 + b"\n", "line of over"),
    "many facets.stl": (b"solid x\n" + b"facet\nendfacet\n" * MANY, "facets"),
    "many triangles.stl": (bytes(80) + struct.pack("<I", 600_001) + bytes(50 * 600_001), "triangles"),
    "many solids.stl": (b"solid\nendsolid\n" * 3000, "solids"),
    "many lines.off": (b"OFF\n" + b"3 0 0 0\n" * MANY, "lines"),
    "many lines.ply": (b"ply\nformat ascii 1.0\nend_header\n" + b"3 0 0 0\n" * MANY, "lines"),
    "many elements.ply": (b"ply\nformat ascii 1.0\n" + b"element x 1\n" * 60 + b"end_header\n", "elements"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_mesh_that_holds_or_claims_too_much_is_refused_before_it_is_read(tmp_path, name, monkeypatch):
    content, why = REFUSED[name]
    (tmp_path / name).write_bytes(content)

    def never(*_, **__):
        raise AssertionError("it was read")

    monkeypatch.setattr(trimesh, "load", never)
    with pytest.raises(UnreadableMeshError, match=why):
        read_mesh(Mesh(name, tmp_path / name, (1.0, 1.0, 1.0), tmp_path))


def test_what_a_scene_shows_often_is_counted_as_often(tmp_path, monkeypatch):
    blob = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4").tobytes()
    (tmp_path / "a.bin").write_bytes(blob)
    nodes = [{"mesh": 0, "translation": [i, 0, 0]} for i in range(30)]
    header = gltf(
        buffers=[{"uri": "a.bin", "byteLength": 36}], bufferViews=[{"buffer": 0, "byteLength": 36}], nodes=nodes,
        scenes=[{"nodes": list(range(30))}],
        **primitives(1, {"bufferView": 0, "count": 3, "componentType": 5126, "type": "VEC3"}),
    )  # fmt: skip
    (tmp_path / "a.gltf").write_bytes(header)
    mesh = Mesh("a.gltf", tmp_path / "a.gltf", (1.0, 1.0, 1.0), tmp_path)
    assert sum(len(part.triangles.faces) for part in read_mesh(mesh)) == 30
    monkeypatch.setattr(mesh_size_limits, "MAX_TRIANGLES", 20)
    with pytest.raises(UnreadableMeshError, match="21 triangles"):
        read_mesh(mesh)


def test_images_are_opened_only_if_their_readers_run_no_other_program(tmp_path):
    for kind, size, opened in (("PNG", 100, True), ("EPS", 100, False), (None, 100, False), ("PNG", 10_000, False)):
        image = type("Image", (), {"width": size, "height": size, "format": kind})()
        assert mesh_files._may_be_opened(image) is opened


def test_corners_are_one_exactly_where_they_are_at_one_place():
    rng = np.random.default_rng(0)
    points = rng.choice(np.array([0.0, -0.0, 1e-30, 1.0, 3.5e8], np.float32), (300, 3))
    merged = tidy(Triangles.of(points, np.arange(300)))
    places = {tuple(p) for p in (points + 0).tolist()}
    assert {tuple(p) for p in (merged.vertices + 0).tolist()} <= places
    triangles = {tuple(map(tuple, face)) for face in (points + 0).reshape(-1, 3, 3).tolist()}
    assert {tuple(map(tuple, face)) for face in (merged.vertices[merged.faces] + 0).tolist()} <= triangles


def test_a_soup_of_triangles_is_thinned_out_whatever_they_are():
    points = np.random.default_rng(0).normal(size=(120_000, 3))
    thin = tidy(Triangles.of(points, np.arange(120_000)), max_faces=20_000)
    assert 5_000 < len(thin.faces) <= 20_000
