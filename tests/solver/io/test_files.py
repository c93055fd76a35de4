"""Reading and writing mesh files: OBJ keeps all its data, the other formats keep their triangles."""

from __future__ import annotations

import json
import os
import stat
import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.errors import JobError, MeshError
from solver.io.mesh_files import FORMATS, read_mesh, write_mesh
from solver.io.obj import MeshData, obj_text

PLAN = """\
# two quads, a triangle and a pentagon
mtllib roof.mtl
o Hall of 12
v 0 0 0
v 1 0 0 1.0 0.5 0.25
v 2 0 0.5
v 0 1 0
v 1 1 0
v 2 1 0
v 3 0.5 0.1
v 1.5 2 0
v 0.5 2 0
vt 0 0
vt 0.3333333333333333 0
vt 1 0
vt 0 1
vt 0.5 1
vt 1 1
vt 0.9 0.9
vn 0 0 1
g floor
usemtl Glass Panel
s 1
f 1/1/1 2/2/1 5/5/1 4/4/1
usemtl Oak
f 2/7 3/3 6/6 \\
  5/5
g
f 3//1 7//1 6//1
g top
f -5/-3 -4/-2 -2/-1 -1/-1 -6/-1
g support
l 1 2 3
l 3 7
"""


@pytest.fixture
def plan(tmp_path: Path) -> MeshData:
    (tmp_path / "plan.obj").write_text(PLAN)
    return read_mesh(tmp_path / "plan.obj")


def test_obj_is_read(plan, tmp_path):
    assert plan.positions.shape == (9, 3)
    assert_array_equal(plan.positions[6], [3, 0.5, 0.1])
    assert [p.tolist() for p in plan.polygons] == [[0, 1, 4, 3], [1, 2, 5, 4], [2, 6, 5], [4, 5, 7, 8, 3]]
    assert [t.tolist() for t in plan.uv_corners] == [[0, 1, 4, 3], [6, 2, 5, 4], [], [4, 5, 6, 6, 6]]
    assert plan.uvs[1, 0] == 0.3333333333333333
    assert plan.objects == ["Hall of 12"] * 4
    assert plan.groups == ["floor", "floor", "", "top"]
    assert plan.materials == ["Glass Panel", "Oak", "Oak", "Oak"]
    assert {name: pairs.tolist() for name, pairs in plan.edge_groups.items()} == {"support": [[0, 1], [1, 2], [2, 6]]}
    assert plan.libraries == [tmp_path / "roof.mtl"]


def test_obj_survives_writing_and_reading(plan, tmp_path):
    write_mesh(tmp_path / "out" / "again.obj", plan)
    again = read_mesh(tmp_path / "out" / "again.obj")
    assert_array_equal(again.positions, plan.positions)
    assert_array_equal(again.uvs, plan.uvs)
    for one, other in zip(again.polygons, plan.polygons, strict=True):
        assert_array_equal(one, other)
    for one, other in zip(again.uv_corners, plan.uv_corners, strict=True):
        assert_array_equal(one, other)
    assert again.objects == plan.objects
    assert again.groups == plan.groups
    assert again.materials == plan.materials
    assert_array_equal(again.edge_groups["support"], plan.edge_groups["support"])
    assert again.libraries == plan.libraries


def test_numbers_have_full_precision(plan):
    positions = np.random.default_rng(0).normal(size=(9, 3)) * 1e5
    words = [line.split()[1:] for line in obj_text(replace(plan, positions=positions)).splitlines()]
    assert_array_equal([[float(w) for w in line] for line in words[1:10]], positions)


def test_up_is_turned_when_read_and_turned_back_when_written(plan, tmp_path):
    write_mesh(tmp_path / "y.obj", plan, up="y")
    assert_array_equal(read_mesh(tmp_path / "y.obj", up="y").positions, plan.positions)
    raw = read_mesh(tmp_path / "y.obj").positions
    assert_array_equal(raw, plan.positions[:, [0, 2, 1]] * [1, 1, -1])


@pytest.mark.parametrize("suffix", [s for s in FORMATS if s != ".obj"])
def test_other_formats_keep_the_triangles(plan, tmp_path, suffix):
    """The same triangles in the same places, on the same number of vertices."""
    write_mesh(tmp_path / f"plan{suffix}", plan)
    again = read_mesh(tmp_path / f"plan{suffix}")
    assert len(again.positions) == 9
    assert {len(p) for p in again.polygons} == {3}
    assert len(again.polygons) == 2 + 2 + 1 + 3
    order = np.linalg.norm(again.positions[:, None] - plan.positions, axis=2).argmin(axis=1)
    assert_array_equal(np.sort(order), np.arange(9))
    assert_allclose(again.positions, plan.positions[order], atol=1e-6)
    corners = {frozenset(order[p].tolist()) for p in again.polygons}
    assert frozenset([2, 6, 5]) in corners


def test_glb_has_uvs_split_at_seams_and_normals(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mesh = MeshData(
        positions=np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0.0]]),
        polygons=[np.array([0, 1, 2, 3]), np.array([1, 4, 5, 2])],
        uvs=np.array([[0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5], [0.75, 0.75]]),
        uv_corners=[np.array([0, 1, 2, 3]), np.array([4, 1, 2, 3])],
    )
    normals = np.tile([0.0, 0.6, 0.8], (6, 1))
    write_mesh(tmp_path / "m.glb", mesh, normals=normals)
    (loaded,) = trimesh.load(tmp_path / "m.glb", process=False).geometry.values()
    assert len(loaded.vertices) == 8
    seam = np.flatnonzero(np.isclose(loaded.vertices, [1, 0, 0]).all(axis=1))
    assert_allclose(np.sort(loaded.visual.uv[seam], axis=0), [[0.5, 0], [0.75, 0.75]], atol=1e-6)
    assert_allclose(loaded.vertex_normals, np.tile([0, 0.8, -0.6], (8, 1)), atol=1e-6)
    assert loaded.visual.material.doubleSided
    assert len(read_mesh(tmp_path / "m.glb").positions) == 6


def test_stl_vertices_that_nearly_coincide_are_merged(tmp_path):
    facets = "".join(
        f"facet normal 0 0 1\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
        for a, b, c in [("0 0 0", "100 0 0", "100 100 0"), ("0.00001 0 0", "100 100.00001 0", "0 100 0")]
    )
    (tmp_path / "m.stl").write_text(f"solid m\n{facets}endsolid m\n")
    mesh = read_mesh(tmp_path / "m.stl")
    assert [p.tolist() for p in mesh.polygons] == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0\nv 1 x 0\n", r'bad.obj, line 2: "1 x 0" is not a position'),
        ("v 0 0\n", r'bad.obj, line 1: "0 0" is not a position; it takes 3 numbers'),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", r"bad.obj, line 3: a face needs three vertices or more, not 2"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n", r"line 5: there is no vertex 4; 3 are defined above"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", r"line 4: there is no vertex 0"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", r"line 4: there is no vertex -4"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 a\n", r'line 4: "a" is not the number of a vertex'),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3\n", r"line 5: some corners of the face have"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/2 2/1 3/1\n", r"line 4: there is no texture coordinate 2"),
        ("v 0 0 0\nl 1 2\n", r"line 2: there is no vertex 2"),
        ("v 0 0 0\n", r"bad.obj has no faces"),
    ],
)
def test_obj_errors_name_file_and_line(tmp_path, text, message):
    (tmp_path / "bad.obj").write_text(text)
    with pytest.raises(MeshError, match=message):
        read_mesh(tmp_path / "bad.obj")


@pytest.mark.parametrize("suffix", [".ply", ".glb", ".stl"])
def test_broken_files_of_other_formats(plan, tmp_path, suffix):
    path = tmp_path / f"cut{suffix}"
    write_mesh(path, plan)
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(MeshError, match=rf"cut{suffix} (cannot be read|has no faces)"):
        read_mesh(path)


def test_missing_files_and_unknown_formats(plan, tmp_path):
    with pytest.raises(JobError, match=r"no file .*nosuch\.obj"):
        read_mesh(tmp_path / "nosuch.obj")
    (tmp_path / "hall.obj").write_text("v 0 0 0\n")
    with pytest.raises(JobError, match=r'no file .*hal\.obj; did you mean "hall\.obj"\?'):
        read_mesh(tmp_path / "hal.obj")
    with pytest.raises(JobError, match=r'plan\.dxf has no format known here \("\.dxf"\); use one of \.obj'):
        read_mesh(tmp_path / "plan.dxf")
    with pytest.raises(JobError, match=r"no format known here"):
        write_mesh(tmp_path / "plan", plan)
    with pytest.raises(JobError, match=r'up axis is "y" or "z", not "x"'):
        read_mesh(tmp_path / "plan.obj", up="x")


def test_a_file_that_cannot_be_written_leaves_nothing_behind(plan, tmp_path):
    (tmp_path / "taken.obj").mkdir()
    with pytest.raises(JobError, match=r"taken\.obj cannot be written"):
        write_mesh(tmp_path / "taken.obj", plan)
    (tmp_path / "file").write_text("")
    with pytest.raises(JobError, match=r"file.m\.obj cannot be written"):
        write_mesh(tmp_path / "file" / "m.obj", plan)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "plan.obj", "taken.obj"]


@pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX")
def test_files_have_the_usual_permissions(plan, tmp_path):
    write_mesh(tmp_path / "m.obj", plan)
    (tmp_path / "plain").write_text("")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("m.obj", "plain")}
    assert len(modes) == 1


@pytest.mark.parametrize("suffix", [s for s in FORMATS if s != ".obj"])
def test_polygons_without_a_triangulation_are_written_as_fans(tmp_path, suffix):
    """One that crosses itself and one without area, as a folded sheet may have, beside a pentagon."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [3, 0, 0], [3, 1, 0], [2, 2, 0], [2, 0, 0.0]])
    crossed, flat, pentagon = [0, 1, 2, 3], [0, 1, 7, 4], [1, 7, 4, 5, 6]
    mesh = MeshData(points, [np.array(p) for p in (crossed, flat, pentagon)])
    write_mesh(tmp_path / f"m{suffix}", mesh)
    again = read_mesh(tmp_path / f"m{suffix}")
    assert len(again.polygons) == 2 + 2 + 3


def stl(triangles: np.ndarray) -> bytes:
    records = np.zeros(len(triangles), dtype=[("normal", "<3f4"), ("corners", "<9f4"), ("more", "<u2")])
    records["corners"] = triangles.reshape(-1, 9)
    return b"\0" * 80 + np.uint32(len(triangles)).tobytes() + records.tobytes()


def glb(index: int) -> bytes:
    """One triangle whose last corner has this index."""
    data = struct.pack("<9f3I", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, index)
    view, shape = {"buffer": 0}, {"count": 3, "type": "VEC3", "componentType": 5126}
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {**shape, "bufferView": 0},
            {**shape, "bufferView": 1, "componentType": 5125, "type": "SCALAR"},
        ],
        "bufferViews": [{**view, "byteLength": 36}, {**view, "byteOffset": 36, "byteLength": 12}],
        "buffers": [{"byteLength": 48}],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


CORNERS = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0], [0, 1, 0.0]]])


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("nan.stl", stl(np.where(CORNERS == 1, np.nan, CORNERS)), "position of vertices 1, 2, .* is not finite"),
        ("inf.stl", stl(np.where(CORNERS == 1, np.inf, CORNERS)), "position of vertices 1, 2, .* is not finite"),
        ("index.glb", glb(112), "face 0 has vertex 112, but there are 3"),
        ("huge.glb", glb(2**32 - 1), "face 0 has vertex 4294967295, but there are 3"),
        ("nul.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nmtllib a\0b\n", "nul.obj, line 5: a null character"),
        ("nan.obj", b"v 0 0 0\nv nan 0 0\n", r'nan.obj, line 2: "nan 0 0" is not a position; .* finite'),
        ("inf.obj", b"v 0 0 1e999\n", r"inf.obj, line 1: .* finite"),
        ("words.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float z\nend_header\n0\n", "it is damaged"),
        ("flat.stl", stl(np.zeros((3, 3, 3))), "has no face with an area"),
    ],
)
def test_damaged_files_are_refused_with_a_sentence(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(MeshError, match=message):
        read_mesh(tmp_path / name)


def test_a_good_glb_is_read(tmp_path):
    (tmp_path / "m.glb").write_bytes(glb(2))
    assert [polygon.tolist() for polygon in read_mesh(tmp_path / "m.glb").polygons] == [[0, 1, 2]]


def test_names_with_a_null_character(plan, tmp_path):
    with pytest.raises(JobError, match="There is no file"):
        read_mesh(tmp_path / "a\0b.obj")
    with pytest.raises(JobError, match="cannot be written"):
        write_mesh(tmp_path / "a\0b.obj", plan)


@pytest.mark.parametrize("spread", [0.0, 1e-7])
def test_thousands_of_vertices_in_one_place(tmp_path, spread):
    """Memory in proportion to the file: all pairs of them would take more than 2 GB."""
    noise = spread * np.random.default_rng(0).random((6000, 3, 3))
    (tmp_path / "m.stl").write_bytes(stl(np.tile(CORNERS[:1], (6000, 1, 1)) + noise))
    tracemalloc.start()
    mesh = read_mesh(tmp_path / "m.stl")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(mesh.positions) == 3 and peak < 1e8
