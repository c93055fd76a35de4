"""Jobs with a [complete] table: modules between mirrors, their planes in the report, copies as mesh and instances."""

from __future__ import annotations

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver.__main__ import main
from solver.catalogue import modules
from solver.errors import JobError
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import load_job, run_job
from solver.jobs.outcomes import FAILED, OK, UNUSABLE
from solver.shells.form import form
from solver.symmetry.sides import SymmetryError

TUBE = modules.node(2, 2.2, max_edge=0.25)


def job_file(folder, complete: str, module=TUBE, kinds=None, more: str = ""):
    """A job on a module written as OBJ with its sides as polylines; `complete` are the lines of the table."""
    shape = module.shape
    points = np.column_stack([2.0 * shape.positions, np.zeros(len(shape.positions))])
    groups = {name: shape.domain.edges[edges] for name, edges in shape.sides.items()}
    faces = list(shape.domain.faces)
    data = MeshData(
        points, faces, uvs=shape.positions, uv_corners=faces, edge_groups=groups, materials=["steel"] * len(faces)
    )
    write_mesh(folder / "module.obj", data)
    lines = ['mesh = "module.obj"', more]
    for name, normal in module.normals.items():
        kind = (kinds or {}).get(name, "mirror")
        lines += ["[[conditions]]", f'group = "{name}"', f'kind = "{kind}"', f"normal = {normal.tolist()}"]
    lines += ["[complete]", complete, "[output]", 'report = "report.json"']
    path = folder / "job.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_a_tube_of_three_periods_as_one_mesh(tmp_path, capsys):
    path = job_file(tmp_path, 'mesh = "tube.obj"\nrepeat = 3')
    assert main([str(path)]) == OK
    assert "completed → " in capsys.readouterr().out
    job = load_job(path)
    tube = read_mesh(tmp_path / "tube.obj")
    faces = len(job.plan.triangles)
    assert len(tube.polygons) == 3 * 8 * faces == len(tube.uv_corners) == len(tube.materials)
    report = json.loads((tmp_path / "report.json").read_text())["completed"]
    assert report["copies"] == 24 and report["sheets"] == {"f+": 24} and report["triangles"] == 24 * faces
    assert report["vertices"] == len(tube.positions) and not report["is_closed"]
    assert report["largest_gap"] < 1e-6 and report["largest_offset"] == 0.0
    ((x, y, z),) = report["lattice"]
    assert_allclose([y, z], 0.0, atol=1e-9)
    assert_allclose(np.ptp(tube.positions[:, 0]), 3 * abs(x), rtol=1e-6)
    uvs = tube.uvs[np.concatenate(tube.uv_corners)]
    assert_allclose(uvs.min(axis=0), 0.0, atol=1e-6)
    assert_allclose(uvs.max(axis=0), job.mesh.uvs.max(axis=0), atol=1e-6)


def test_faces_of_the_mesh_keep_their_places_in_the_texture(tmp_path):
    """Every copy of a face has that face's UVs at the vertices that come from its vertices, turned over or not."""
    path = job_file(tmp_path, 'mesh = "tube.obj"')
    run_job(load_job(path))
    tube, plan = read_mesh(tmp_path / "tube.obj"), load_job(path).mesh
    count = len(plan.polygons)
    for k in (0, 5):
        drawn = plan.uvs[plan.uv_corners[k]]
        for copy in range(8):
            uv = tube.uvs[tube.uv_corners[copy * count + k]]
            order = np.argmin(np.linalg.norm(uv[:, None] - drawn[None], axis=2), axis=1)
            assert_allclose(uv, drawn[order], atol=1e-6)
            assert sorted(order.tolist()) == [0, 1, 2]


def test_instances_put_the_pieces_where_the_mesh_is(tmp_path):
    nodoid = TUBE
    kinds = {"bisector": "plane", "end": "plane"}
    path = job_file(tmp_path, 'mesh = "whole.obj"\ninstances = "whole.json"', nodoid, kinds)
    run_job(load_job(path))
    whole = read_mesh(tmp_path / "whole.obj").positions
    report = json.loads((tmp_path / "whole.json").read_text())
    assert set(report["pieces"]) == {"f+", "f-"}
    pieces = {name: read_mesh(tmp_path / file).positions for name, file in report["pieces"].items()}
    for instance in report["instances"]:
        matrix = np.array(instance["matrix"])
        placed = pieces[instance["piece"]] @ matrix[:3, :3].T + matrix[:3, 3]
        apart = np.linalg.norm(placed[:, None] - whole[None], axis=2).min(axis=1)
        assert apart.max() < 1e-5 * np.ptp(whole)
    assert len({instance["piece"] for instance in report["instances"]}) == 2


@pytest.mark.parametrize(("choice", "count"), [
    ("copies = 5", 5),
    ('around = [["axis", "floor"]]', 4),
    ('around = [["axis", "floor"]]\nsides = ["axis", "floor", "end"]', 4),
    ('sides = ["axis"]', 2),
    ("box = [[-9, -9, -9], [0, 9, 9]]", 12),
])  # fmt: skip
def test_which_copies(tmp_path, choice, count):
    path = job_file(tmp_path, f'instances = "tube.json"\n{choice}')
    run_job(load_job(path))
    instances = json.loads((tmp_path / "tube.json").read_text())["instances"]
    assert len(instances) == count
    middle = np.append(read_mesh(tmp_path / "tube_f_plus.obj").positions.mean(axis=0), 1.0)
    if "box" in choice:
        places = np.array([np.array(instance["matrix"]) @ middle for instance in instances])
        assert (np.abs(places[:, :3]) < 9.0).all() and (places[:, 0] < 0.0).all()


def test_the_report_has_the_planes_of_the_sides(tmp_path):
    path = job_file(tmp_path, 'mesh = "tube.stl"')
    shell = run_job(load_job(path))
    planes = {plane["name"]: plane for plane in json.loads((tmp_path / "report.json").read_text())["planes"]}
    assert list(planes) == [f"group {name}" for name in TUBE.normals]
    for name, normal in TUBE.normals.items():
        plane = planes[f"group {name}"]
        assert_allclose(plane["normal"], normal, atol=1e-12)
        assert plane["kind"] == "mirror" and plane["error"] < 1e-6 and plane["relative"] < 1e-6
        edges = TUBE.shape.domain.edges[TUBE.shape.sides[name]]
        assert_allclose(shell.placed["f+"][np.unique(edges)] @ normal, plane["offset"], atol=1e-6)
    assert '"group floor" meets the plane (0, 0, -1)' in shell.summary()


def test_a_plane_that_is_touched_is_that_of_the_sheet_shown(tmp_path):
    path = job_file(tmp_path, 'mesh = "tube.stl"', kinds={"bisector": "plane", "end": "plane"})
    shell = run_job(load_job(path))
    end = next(plane for plane in shell.report.planes if plane.name == "group end")
    edges = TUBE.shape.domain.edges[TUBE.shape.sides["end"]]
    heights = shell.placed["f+"][np.unique(edges)] @ TUBE.normals["end"]
    assert_allclose(heights, end.offset, atol=1.0001 * end.error)
    assert 0.0 < end.error < 0.02 * np.ptp(shell.placed["f+"])
    assert '"group end" touches the plane (1, 0, 0)' in shell.summary()


@pytest.mark.parametrize(("lines", "message"), [
    ("repeat = 2", r'name a file: "mesh"'),
    ('mesh = "a.txt"', r'"mesh" has no format known here \("\.txt"\)'),
    ('instances = "a.obj"', r'"instances" has no format known here'),
    ('mesh = "a.obj"\ncopies = 0', r'"copies" must be a whole number from 1 to 20,000, not 0'),
    ('mesh = "a.obj"\ncopies = 3\nbox = [[0, 0, 0], [1, 1, 1]]', "give one of copies, box and around"),
    ('mesh = "a.obj"\nbox = [[0, 0, 0], [1, 1, -1]]', r'"box" must be two corners, the lowest one first'),
    ('mesh = "a.obj"\nbox = [[0, 0], [1, 1]]', r'"box" must be a list of two corners'),
    ('mesh = "a.obj"\nrepeat = 0', r'"repeat" must be a whole number from 1 to 20,000, or up to three'),
    ('mesh = "a.obj"\ncopies = 3\nrepeat = 2', r'"repeat" goes with the unit cell'),
    ('mesh = "a.obj"\nsides = ["flor"]', r'no condition is on "flor"; did you mean "floor"\?'),
    ('mesh = "a.obj"\nsides = "floor"', r'"sides" must be a list of texts'),
    ('mesh = "a.obj"\naround = ["axis"]', r'"around" must be a list of lists of sides'),
    ('mesh = "a.obj"\naround = [["flor"]]', r'"around": no condition is on "flor"'),
    ('mesh = "a.obj"\ncount = 3', r'unknown key "count"'),
])  # fmt: skip
def test_a_table_that_is_wrong_is_refused(tmp_path, lines, message):
    with pytest.raises(JobError, match=message) as caught:
        load_job(job_file(tmp_path, lines))
    assert "[complete]" in str(caught.value)


def test_without_a_side_to_go_on_across_the_job_is_refused(tmp_path):
    kinds = dict.fromkeys(TUBE.normals, "gauss_map")
    path = job_file(tmp_path, 'mesh = "a.obj"', kinds=kinds)
    path.write_text("\n".join(line for line in path.read_text().splitlines() if not line.startswith("normal")))
    with pytest.raises(JobError, match=r"\[complete\]: There is no side to continue across"):
        load_job(path)
    assert main([str(path)]) == UNUSABLE


def test_fits_have_no_copies(tmp_path):
    path = tmp_path / "job.toml"
    path.write_text('[shape]\nkind = "disc"\nn = 100\n[fit]\nrise = 0.3\n[complete]\nmesh = "a.obj"\n')
    with pytest.raises(JobError, match="a fitted shell has no sides"):
        load_job(path)


def test_copies_that_have_no_end_fail_after_the_report_was_written(tmp_path):
    """Around two parallel sides; the shell itself is fine."""
    path = job_file(tmp_path, 'mesh = "a.obj"\naround = [["bisector", "end"]]')
    with pytest.raises(SymmetryError, match="have no end"):
        run_job(load_job(path))
    assert main([str(path)]) == FAILED
    assert "completed" not in json.loads((tmp_path / "report.json").read_text())
    assert not (tmp_path / "a.obj").exists()


@pytest.mark.parametrize(("more", "sign"), [("", 1.0), ("[default]\nflipped_corners = [{vertex}]", -1.0)])
def test_a_corner_between_two_mirrors_takes_its_other_normal(tmp_path, more, sign):
    """At the end of the tube, below: N = ±(ν of the end × ν of the floor)."""
    shape, normals = TUBE.shape, TUBE.normals
    ends = [np.unique(shape.domain.edges[shape.sides[name]]) for name in ("end", "floor")]
    (vertex,) = np.intersect1d(*ends)
    job = load_job(job_file(tmp_path, 'mesh = "a.stl"', more=more.format(vertex=vertex)))
    shell = form(job.plan, job.settings, intersections=False)
    assert_allclose(shell.surface.normals[vertex], sign * np.cross(normals["end"], normals["floor"]), atol=1e-9)


def test_more_copies_than_are_ever_made_are_refused_at_once(tmp_path):
    job = load_job(job_file(tmp_path, 'mesh = "a.obj"\nrepeat = 20000'))
    with pytest.raises(JobError, match="That makes 160000 copies, and 20000 are the most"):
        run_job(job)


@pytest.mark.parametrize(("given", "message"), [
    ('["a"]', r'"flipped_corners" must be a list, each a whole number'),
    ("[0, 999]", r'"flipped_corners": there is no vertex 999; the mesh has \d+'),
])  # fmt: skip
def test_flipped_corners_are_vertices(tmp_path, given, message):
    path = job_file(tmp_path, 'mesh = "a.stl"', more=f"[default]\nflipped_corners = {given}")
    with pytest.raises(JobError, match=message):
        load_job(path)
