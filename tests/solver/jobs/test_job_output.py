"""The files of a job: shells with the UVs and groups of the plan, cut open, with other faces; reports."""

from __future__ import annotations

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.errors import CmcError
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import load_job, run_job
from solver.shells.plan import Plan, plan_domain
from tests.solver.job_files import job, quad_plan


def test_a_job_forms_a_shell_with_all_the_plan_carries(folder):
    text = """
        mesh = "plan.obj"
        [[conditions]]
        group = "bottom"
        tilt = 30
        [size]
        span = 9
        [output]
        f_plus = "out/shell.obj"
        g = "out/g.glb"
        gauss = "out/gauss.ply"
        report = "out/report.json"
        """
    shell = run_job(load_job(job(folder, text)))
    plan, written = read_mesh(folder / "plan.obj"), read_mesh(folder / "out" / "shell.obj")
    assert_allclose(written.positions, shell.placed["f+"], rtol=1e-12, atol=1e-15)
    assert_array_equal(written.polygons, plan.polygons)
    assert_array_equal(written.uvs, plan.uvs)
    assert_array_equal(written.uv_corners, plan.uv_corners)
    assert written.materials == plan.materials
    assert written.groups == plan.groups
    assert_array_equal(written.edge_groups["bottom"], plan.edge_groups["bottom"])
    written = json.loads((folder / "out" / "report.json").read_text())
    assert written["converged"] is True
    assert written["message"] == shell.message
    assert_allclose(written["sheets"]["f+"]["span"], 9, rtol=1e-9)
    assert len(read_mesh(folder / "out" / "g.glb").positions) == len(plan.positions)
    assert sorted(p.name for p in (folder / "out").iterdir()) == [
        "g.glb",
        "gauss.ply",
        "report.json",
        "shell.obj",
    ]


def test_up_is_y_on_both_ways(folder):
    write_mesh(folder / "y.obj", quad_plan(), up="y")
    text = 'mesh = "y.obj"\nup = "y"\n[output]\nf_plus = "shell.obj"'
    shell = run_job(load_job(job(folder, text)))
    assert shell.placed["f+"][:, 2].max() > 1
    assert read_mesh(folder / "shell.obj").positions[:, 1].max() > 1
    assert_allclose(read_mesh(folder / "shell.obj", up="y").positions, shell.placed["f+"], atol=1e-12)


def test_a_degenerate_sheet_is_not_written(folder):
    text = "[shape]\nkind = 'disc'\nn = 100\n[output]\nf_minus = 'twin.obj'\nreport = 'report.json'"
    with pytest.raises(CmcError, match="f- degenerates to a point"):
        run_job(load_job(job(folder, text)))
    assert not (folder / "twin.obj").exists()
    assert json.loads((folder / "report.json").read_text())["converged"] is True


def test_a_courtyard_with_a_gap_is_written_cut_open(folder):
    mesh = quad_plan(9, 9)
    keep = [k for k in range(81) if not (3 <= k % 9 < 6 and 3 <= k // 9 < 6)]
    used, corners = np.unique([mesh.polygons[k] for k in keep], return_inverse=True)
    hole = MeshData(
        positions=mesh.positions[used],
        polygons=list(corners.reshape(-1, 4).astype(np.int32)),
        uvs=mesh.uvs,
        uv_corners=[mesh.uv_corners[k] for k in keep],
        materials=[mesh.materials[k] for k in keep],
        edge_groups={"bottom": mesh.edge_groups["bottom"]},
    )
    write_mesh(folder / "court.obj", hole)
    text = """
        mesh = "court.obj"
        [[conditions]]
        loop = 1
        kind = "plane"
        normal = [0.6, 0, 0.8]
        [output]
        f_plus = "shell.obj"
        """
    shell = run_job(load_job(job(folder, text)))
    assert not shell.ok
    written, uv = read_mesh(folder / "shell.obj"), mesh.uvs
    assert len(written.positions) == len(shell.source) > len(used)
    assert list(read_mesh(folder / "court.obj").edge_groups) == ["bottom"] and not written.edge_groups
    for polygon, rows, material in zip(written.polygons, written.uv_corners, written.materials, strict=True):
        flat = hole.positions[shell.source[polygon]][:, :2]
        assert_allclose((uv[rows] - [2.0 if material == "oak" else 0.0, 0.0]) * 9, flat, atol=1e-12)


def counts(plan: Plan) -> tuple[int, int, int, int]:
    """Vertices, edges, triangles, boundary edges."""
    domain = plan_domain(plan)
    return domain.vertex_count, len(domain.edges), len(domain.faces), len(domain.boundary_edges)


def triangle_area(mesh: MeshData) -> float:
    corners = np.array([mesh.positions[polygon] for polygon in mesh.polygons])
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()


DUAL = """
    mesh = "plan.obj"
    [default]
    tilt = 30
    [solver]
    sites = "{}"
    {}
    [output]
    combinatorics = "{}"
    f_plus = "shell.obj"
    g = "g.glb"
    f_minus = "twin.stl"
    gauss = "gauss.ply"
    report = "report.json"
    """


@pytest.mark.parametrize("delaunay", ["", "delaunay = true"])
@pytest.mark.parametrize("sites", ["vertices", "faces"])
@pytest.mark.parametrize("faces", ["dual", "corner"])
def test_polygons_are_written_with_what_the_plan_carries(folder, sites, faces, delaunay):
    """UVs lie where the polygons do: the plan's were drawn as its own coordinates, with a seam in the middle."""
    loaded = load_job(job(folder, DUAL.format(sites, delaunay, faces)))
    shell = run_job(loaded)
    assert shell.ok
    written = read_mesh(folder / "shell.obj")
    V, E, F, rim = counts(loaded.plan)
    if faces == "dual":
        assert len(written.polygons) == V
    elif sites == "vertices":
        assert len(written.polygons) == V + E + F
    else:
        assert F + E - rim < len(written.polygons) <= V + E - rim + F
    assert set(written.materials) == {"glass", "oak"} and set(written.groups) == {"west", "east"}
    assert set(written.objects) == {"plan"} and not written.edge_groups
    assert len(written.uvs) == len(written.positions)
    for polygon, rows, material in zip(written.polygons, written.uv_corners, written.materials, strict=True):
        uv = written.uvs[rows]
        assert_array_equal(rows, polygon)
        if np.ptp(uv[:, 0]) < 0.5:  # not across the seam
            assert (uv[:, 0].mean() > 1.5) == (material == "oak")
    assert -0.2 < written.uvs[:, 1].min() < 0.2 and 0.8 < written.uvs[:, 1].max() < 1.2
    for name in ("g.glb", "twin.stl", "gauss.ply"):
        assert {len(polygon) for polygon in read_mesh(folder / name).polygons} == {3}


def test_the_shell_of_other_faces_is_the_same_shell(folder):
    """Dual and corner meshes have the area of the triangles, up to the size of the mesh."""
    areas = {}
    for faces in ("primal", "dual", "corner"):
        shape = "[shape]\nkind = 'disc'\nn = 1500\n[default]\ntilt = 30\n"
        run_job(load_job(job(folder, f"{shape}[output]\nf_plus = 'shell.ply'\ncombinatorics = '{faces}'")))
        areas[faces] = triangle_area(read_mesh(folder / "shell.ply"))
    assert_allclose(areas["dual"], areas["primal"], rtol=0.02)
    assert_allclose(areas["corner"], areas["primal"], rtol=0.02)
