"""Plans as other programs write them: each of these files is one plan, and gives its shell."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.errors import CmcError, MeshError
from solver.io.mesh_files import read_mesh
from solver.io.obj import MeshData, obj_text, read_obj
from solver.jobs.job import Job, load_job, run_job

WIDE, HIGH = 6, 4
POINTS = [(x, y) for y in range(HIGH + 1) for x in range(WIDE + 1)]
QUADS = [
    [k + 1, k + 2, k + WIDE + 3, k + WIDE + 2] for j in range(HIGH) for k in np.arange(WIDE) + j * (WIDE + 1)
]
BOTTOM = "l 1 2 3 4 5 6 7\n"
JOB = """mesh = "{file}"
[[conditions]]
group = "{group}"
tilt = 40
[default]
tilt = 10
[output]
report = "report.json"
f_plus = "shell.obj"
"""
ENERGY, PLY_ENERGY, MATERIAL_ENERGY = 6.99565, 6.8526, 6.13601


def vertices() -> str:
    return "".join(f"v {x} {y} 0\n" for x, y in POINTS)


def faces(quads: list[list[int]] = QUADS) -> str:
    return "".join("f " + " ".join(map(str, quad)) + "\n" for quad in quads)


def plain(name: str = "Long Side") -> str:
    return vertices() + faces() + f"g {name}\n" + BOTTOM


def with_material(name: str) -> str:
    """Two rows of quads in the middle have a material, as the cases have it."""
    lines = faces().splitlines(keepends=True)
    return vertices() + "".join(lines[:12]) + f"usemtl {name}\n" + "".join(lines[12:])


def with_map() -> str:
    uvs = "".join(f"vt\t{x / WIDE} {y / HIGH}\n" for x, y in POINTS)
    return uvs + plain().replace(faces(), "".join("f " + " ".join(f"{v}/{v}" for v in quad) + "\n" for quad in QUADS))


def unwelded() -> str:
    points = "".join(f"v {POINTS[v - 1][0]} {POINTS[v - 1][1]} 0\n" for quad in QUADS for v in quad)
    rim = "".join(f"l {4 * k + 1} {4 * k + 2}\n" for k in range(WIDE))
    return points + faces(np.arange(1, 4 * len(QUADS) + 1).reshape(-1, 4).tolist()) + "g Long Side\n" + rim


def own_line() -> str:
    line = "".join(f"v {x} 0 0\n" for x in range(WIDE + 1))
    return plain().replace(BOTTOM, line + "l 36 37 38 39 40 41 42\n")


def loaded(folder: Path, data: str | bytes, group: str = "Long Side", file: str = "plan.obj") -> Job:
    (folder / file).write_bytes(data.encode() if isinstance(data, str) else data)
    (folder / "job.toml").write_text(JOB.format(file=file, group=group), encoding="utf-8")
    return load_job(folder / "job.toml")


def energy(folder: Path, *args: str) -> float:
    run_job(loaded(folder, *args))
    return json.loads((folder / "report.json").read_text())["energy"]


PLAIN = plain()
SAME = {
    "plain": PLAIN,
    "tab_all": "\n".join(line.replace(" ", "\t", 1) for line in PLAIN.splitlines()),
    "tab_face": PLAIN.replace("f 11 12", "f\t11 12"),
    "tab_l": PLAIN.replace("g Long", "g\tLong").replace("l 1", "l\t1"),
    "tab_v": PLAIN.replace("v ", "v\t"),
    "tab_vt": with_map(),
    "bom": "\ufeff" + PLAIN,
    "bom16": PLAIN.encode("utf-16"),
    "carriage_returns": PLAIN.replace("\n", "\r"),
    "repeated": vertices() + faces([[*quad, quad[-1]] for quad in QUADS]) + "g Long Side\n" + BOTTOM,
    "repeated_first": vertices() + faces([[*quad, quad[0]] for quad in QUADS]) + "g Long Side\n" + BOTTOM,
    "repeated_in_the_middle": PLAIN.replace("f 1 2 9", "f 1 2 2 9"),
    "comments": PLAIN.replace("f 1 2 9 8", "f 1 2 9 8 # first"),
    "loose": PLAIN + "v 100 100 100\nv 200 1 1\n",
    "loose_first": "v -50 0 0\n" + vertices() + faces([[v + 1 for v in q] for q in QUADS])
    + "g Long Side\nl 2 3 4 5 6 7 8\n",
    "own_line": own_line(),
    "unwelded": unwelded(),
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_plan_gives_the_same_shell(tmp_path, name):
    assert_allclose(energy(tmp_path, SAME[name]), ENERGY, rtol=1e-5)


@pytest.mark.parametrize("name", ["Side #1", "Südseite", "#1", "Long\tSide"])
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "utf-16"])
def test_names_of_groups(tmp_path, name, encoding):
    group = name.replace("\t", "\\t")
    assert_allclose(energy(tmp_path, plain(name).encode(encoding), group), ENERGY, rtol=1e-5)


@pytest.mark.parametrize("name", ["Glass", "Glass #2", "Glas-Süd"])
def test_names_of_materials(tmp_path, name):
    text = with_material(name).replace("usemtl ", "usemtl\t")
    assert_allclose(energy(tmp_path, text.encode("cp1252"), name), MATERIAL_ENERGY, rtol=1e-5)
    assert f"usemtl {name}" in (tmp_path / "shell.obj").read_text(encoding="utf-8")


@pytest.mark.parametrize(("drawn", "asked"), [("Cafe\u0301", "Caf\u00e9"), ("Caf\u00e9", "Cafe\u0301")])
def test_an_accent_is_the_same_however_it_is_stored(tmp_path, drawn, asked):
    assert [len(g.edges) for g in loaded(tmp_path, plain(drawn), asked).plan.groups] == [6]


def test_a_job_file_with_a_byte_order_mark(tmp_path):
    loaded(tmp_path, PLAIN)
    job = tmp_path / "job.toml"
    for encoding in ("utf-8-sig", "utf-16"):
        job.write_bytes(JOB.format(file="plan.obj", group="Long Side").encode(encoding))
        assert len(load_job(job).plan.groups) == 1


def test_names_survive_writing_and_reading(tmp_path):
    quad = np.array([0, 1, 3, 2])
    mesh = MeshData(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]), [quad], materials=["Steel #25"])
    (tmp_path / "m.obj").write_text(obj_text(mesh))
    assert read_obj(tmp_path / "m.obj").materials == ["Steel #25"]


def ply(points: list[tuple[int, int]], quads: list[list[int]]) -> str:
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(quads)}\nproperty list uchar int vertex_indices\nend_header\n"
    return head + "".join(f"{x} {y} 0\n" for x, y in points) + "".join(f"4 {' '.join(map(str, q))}\n" for q in quads)


PLY_QUADS = [[v - 1 for v in quad] for quad in QUADS]
PLIES = {
    "quads": ply(POINTS, PLY_QUADS),
    "split": ply([POINTS[v] for q in PLY_QUADS for v in q], np.arange(4 * len(QUADS)).reshape(-1, 4).tolist()),
    "nouse": ply([*POINTS, (50, 50)], PLY_QUADS),
    "nouse_first": ply([(50, 50), *POINTS], [[v + 1 for v in q] for q in PLY_QUADS]),
}


@pytest.mark.parametrize("name", PLIES)
def test_ply_files_of_one_plan(tmp_path, name):
    (tmp_path / "plan.ply").write_text(PLIES[name])
    (tmp_path / "job.toml").write_text('mesh = "plan.ply"\n[default]\ntilt = 20\n[output]\nreport = "report.json"\n')
    shell = run_job(load_job(tmp_path / "job.toml"))
    report = json.loads((tmp_path / "report.json").read_text())
    assert_allclose([report["energy"], report["sheets"]["f+"]["rise"]], [PLY_ENERGY, 3.01], rtol=1e-4)
    merged = [w for w in shell.warnings if "24 parts of the mesh coincide along their edges; 61 vertices" in w]
    assert bool(merged) == (name == "split")


def test_a_slit_stays_open(tmp_path):
    """Coinciding vertices are merged to join parts, never inside of one part, where they may be meant."""
    text = vertices() + "v 2 1 0\n" + faces([[36 if v == 10 and k == 8 else v for v in q] for k, q in enumerate(QUADS)])
    (tmp_path / "plan.obj").write_text(text)
    assert len(read_mesh(tmp_path / "plan.obj").positions) == 36


def test_numbers_in_a_job_are_those_of_the_file(tmp_path):
    (tmp_path / "plan.obj").write_text(SAME["loose_first"])
    text = 'mesh = "plan.obj"\n[[conditions]]\nvertices = [1, 2, 3]\n[[conditions]]\nedges = [[3, 4], [4, 5]]\n'
    (tmp_path / "job.toml").write_text(text)
    groups = load_job(tmp_path / "job.toml").plan.groups
    assert_array_equal([group.edges for group in groups], [[[0, 1], [1, 2]], [[2, 3], [3, 4]]])
    for numbers, message in (("[0, 1]", "no face of the mesh has vertex 0"), ("[1, 99]", "no vertex 99; the mesh")):
        (tmp_path / "job.toml").write_text(f'mesh = "plan.obj"\n[[conditions]]\nvertices = {numbers}\n')
        with pytest.raises(CmcError, match=message):
            load_job(tmp_path / "job.toml")


def test_a_polyline_beside_the_faces_is_named(tmp_path):
    text = PLAIN + "v 9 9 0\nv 9 10 0\ng Axis\nl 36 37\n"
    job = loaded(tmp_path, text)
    assert [w for w in job.warnings if '"Axis" has 1 segment with an end (vertices 35, 36)' in w]
    with pytest.raises(CmcError, match='no group "Axis"'):
        loaded(tmp_path, text, "Axis")


def test_faces_without_area_are_left_out_and_named(tmp_path):
    job = loaded(tmp_path, PLAIN.replace("f 1 2 9 8", "f 1 1 2\nf 1 2 9 8"))
    assert len(job.mesh.polygons) == 24 and "Left out of the mesh, since they have no area: face 0." in job.warnings


def test_an_unfinished_mesh_is_refused(tmp_path):
    with pytest.raises(MeshError, match="has no face with an area"):
        loaded(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\n")


FLIPPED = PLAIN.replace("f 12 13 20 19", "f 19 20 13 12")


@pytest.mark.parametrize(
    ("text", "message", "numbers"),
    [
        (PLAIN.replace("g Long", "f 12 13 20 19\ng Long"), "Faces 10, 24 have the same vertices", (10, 24)),
        (FLIPPED, "Face 10 has the other orientation than the rest of the mesh; recalculate", (10,)),
        (FLIPPED.replace("f 1 2", "f 1 1 2\nf 1 2"), "Face 11 has the other orientation", (11,)),
        (PLAIN.replace("f 1 2", "f 1 1 2\nf 1 3 2 4 5\nf 1 2"), "Polygon 1 has a spike", (1,)),
    ],
)
def test_messages_count_the_faces_of_the_file(tmp_path, text, message, numbers):
    with pytest.raises(MeshError, match=message) as caught:
        loaded(tmp_path, text)
    assert caught.value.faces == numbers


def test_messages_count_the_vertices_of_the_file(tmp_path):
    third = SAME["loose_first"].replace("g Long", "v 3 2 5\nf 10 11 37\ng Long")
    with pytest.raises(MeshError, match="Edge from vertex 9 to 10 has more than two faces") as caught:
        loaded(tmp_path, third)
    assert caught.value.vertices == (9, 10)
