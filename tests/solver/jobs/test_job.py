"""Job files: conditions, shapes and settings, and the plan read from them."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import JobError
from solver.io.mesh_files import write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import EXAMPLE, load_job, run_job
from solver.jobs.shape_table import SHAPES
from solver.shells.plan import Plan, plan_domain
from solver.shells.plan_conditions import plan_conditions
from tests.solver.job_files import PLAN, job, quad_plan

JOBS = Path(__file__).parents[3] / "assets" / "jobs"


def pairs(plan: Plan) -> list[set[frozenset[int]]]:
    return [{frozenset(pair) for pair in group.edges.tolist()} for group in plan.groups]


def test_angles_are_degrees_and_settings_arrive(folder):
    text = """
        mesh = "plan.obj"
        [[conditions]]
        group = "bottom"
        kind = "plane"
        normal = [0, -1, 1]
        [default]
        kind = "binormal"
        tilt = 45
        [size]
        radius = 4.5
        ground = "rim"
        flip = true
        rotate = true
        [solver]
        averaging = "linear"
        tolerance = 1e-7
        side = -1
        """
    loaded = load_job(job(folder, text))
    settings = loaded.settings
    assert loaded.plan.groups[0].parameters == {"normal": (0.0, -1.0, 1.0)}
    assert_allclose(settings.default_tilt, np.pi / 4)
    assert (settings.size, settings.value, settings.ground) == ("radius", 4.5, "rim")
    assert settings.flip and settings.rotate
    assert (settings.averaging, settings.tolerance, settings.side) == ("linear", 1e-7, -1)


def test_where_a_condition_holds(folder):
    """By polyline, material, loop, edges and vertices: a rectangle of 6 by 4 quads, 7 vertices a row."""
    bottom = {frozenset((i, i + 1)) for i in range(6)}
    cases = {
        'group = "bottom"': bottom,
        "edges = [[0, 1], [2, 1]]": {frozenset((0, 1)), frozenset((1, 2))},
        "vertices = [0, 1, 2, 3, 4, 5, 6, 8]": bottom,
    }
    for where, expected in cases.items():
        assert pairs(load_job(job(folder, f'mesh = "plan.obj"\n[[conditions]]\n{where}')).plan) == [expected]
    for where in ('group = "east"', 'group = "oak"'):
        (found,) = pairs(load_job(job(folder, f'mesh = "plan.obj"\n[[conditions]]\n{where}')).plan)
        assert len(found) == 3 + 4 + 3
        assert all(min(vertex % 7 for vertex in pair) >= 3 for pair in found)
    (found,) = pairs(load_job(job(folder, 'mesh = "plan.obj"\n[[conditions]]\nloop = 0')).plan)
    assert len(found) == 20


def test_loop_0_is_the_longest(folder):
    text = '[shape]\nkind = "annulus"\ninner = 1\nouter = 3\nn = 300\n[[conditions]]\nloop = {}\n'
    radii = []
    for number in (0, 1):
        plan = load_job(job(folder, text.format(number))).plan
        radii.append(np.linalg.norm(plan.positions[plan.groups[0].edges[:, 0]], axis=1))
    assert_allclose(radii[0], 3)
    assert_allclose(radii[1], 1)


def test_loop_0_is_the_longest_wherever_it_starts(folder):
    """Here the vertices of the hole come first."""
    mesh = quad_plan(9, 9)
    missing = [k for k in range(81) if 3 <= k % 9 < 6 and 3 <= k // 9 < 6]
    quads = [k for k in range(81) if k not in missing]
    hole = np.unique([mesh.polygons[k] for k in missing])
    used = np.unique([mesh.polygons[k] for k in quads])
    order = np.concatenate([np.intersect1d(hole, used), np.setdiff1d(used, hole)])
    new = np.full(100, -1)
    new[order] = np.arange(len(order))
    write_mesh(folder / "court.obj", MeshData(mesh.positions[order], [new[mesh.polygons[k]] for k in quads]))
    plan = load_job(job(folder, 'mesh = "court.obj"\n[[conditions]]\nloop = 0')).plan
    assert len(plan.groups[0].edges) == 36
    plan = load_job(job(folder, 'mesh = "court.obj"\n[[conditions]]\nloop = 1')).plan
    assert len(plan.groups[0].edges) == 12
    assert plan.groups[0].edges.min() == 0


SHAPE_JOBS = {
    "disc": 'kind = "disc"\nn = 100\nscale = 5',
    "rectangle": 'kind = "rectangle"\nwidth = 6\nheight = 4\ncolumns = 6',
    "strip": 'kind = "strip"\nwidth = 6\nheight = 4\ncolumns = 6',
    "annulus": 'kind = "annulus"\ninner = 1\nouter = 3\nn = 300',
    "cylinder": 'kind = "cylinder"\nsize = 4\nheight = 0.5\ncolumns = 16',
    "wente": 'kind = "wente"\nsize = 8\nangle = 120\ncolumns = 8',
    "ring": 'kind = "ring"\nsize = 5\ncolumns = 4',
    "polygon": 'kind = "polygon"\noutline = [[0, 0], [8, 0], [8, 6], [0, 6]]\n'
    "holes = [[[3, 2], [3, 4], [5, 4], [5, 2]]]\nmax_edge = 1.0\ncorner_radius = 0.5",
}


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes(folder, kind):
    side = {"cylinder": "top", "wente": "mirror", "ring": "tube 1"}.get(kind, "outer")
    loaded = load_job(job(folder, f"[shape]\n{SHAPE_JOBS[kind]}\n[[conditions]]\nside = '{side}'\ntilt = 10"))
    plan = loaded.plan
    assert plan.positions.shape[1] == 3
    assert len(plan.groups[0].edges) > (10 if side == "outer" else 3)
    assert [group.name for group in plan.groups].count(f"side {side}") == 1
    if side == "outer":
        assert_allclose(loaded.mesh.uvs, plan.positions[:, :2])
    if kind == "disc":
        assert_allclose(np.linalg.norm(plan.positions, axis=1).max(), 5)
    if kind == "polygon":
        assert len(plan.positions) > 40


@pytest.mark.parametrize(("scale", "more"), [("", ""), ("scale = 2.0\n", " The lengths are those before the scale.")])
def test_corners_rounded_by_themselves_are_said(folder, scale, more):
    polygon = SHAPE_JOBS["polygon"].replace("corner_radius = 0.5", 'corner_radius = "auto"')
    loaded = load_job(job(folder, f"[shape]\n{scale}{polygon}"))
    assert loaded.warnings == [f"Rounded 8 corners by 0.2 to 0.8.{more}"]
    assert loaded.warnings[0].code == "rounded"
    assert load_job(job(folder, f"[shape]\n{SHAPE_JOBS['polygon']}")).warnings == []


def test_corners_of_a_court_alone_are_rounded(folder):
    polygon = SHAPE_JOBS["polygon"].replace("corner_radius = 0.5", 'corner_radius = "auto"\ncorners = "re-entrant"')
    assert load_job(job(folder, f"[shape]\n{polygon}")).warnings == ["Rounded 4 corners by 0.2."]


def test_sides_of_a_rectangle(folder):
    text = f"[shape]\n{SHAPE_JOBS['rectangle']}\n[[conditions]]\nside = 'top'\nkind = 'free'"
    plan = load_job(job(folder, text)).plan
    assert_allclose(plan.positions[plan.groups[0].edges][:, :, 1], 4)


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".glb"])
def test_plans_from_other_formats(folder, suffix):
    """The same shell as from the OBJ, to single precision; a quad may be cut along its other diagonal."""
    write_mesh(folder / f"plan{suffix}", quad_plan())
    shell = run_job(load_job(job(folder, f'mesh = "plan{suffix}"\n[[conditions]]\nloop = 0\ntilt = 30')))
    drawn = run_job(load_job(job(folder, 'mesh = "plan.obj"\n[[conditions]]\nloop = 0\ntilt = 30')))
    assert len(shell.source) == len(drawn.source)
    assert_allclose(np.ptp(shell.placed["f+"], axis=0), np.ptp(drawn.placed["f+"], axis=0), rtol=0.02)


def test_the_example_is_a_job(folder):
    data = tomllib.loads(EXAMPLE)
    write_mesh(
        folder / "plan.obj",
        MeshData(**{**vars(quad_plan()), "edge_groups": {"supports": np.array([[0, 1], [1, 2]])}}),
    )
    loaded = load_job(job(folder, EXAMPLE))
    assert loaded.settings.value == data["size"]["span"]
    assert_allclose(loaded.plan.groups[0].parameters["tilt"], np.radians(20))
    assert set(loaded.outputs) == {"f+", "report"}


@pytest.mark.parametrize("name", sorted(path.name for path in JOBS.glob("*.toml")))
def test_the_jobs_that_come_with_the_project(tmp_path, name):
    shutil.copytree(JOBS, tmp_path / "assets" / "jobs")
    loaded = load_job(tmp_path / "assets" / "jobs" / name)
    shell = run_job(loaded)
    assert shell.ok
    assert shell.report.shown.rise > 0.1 * shell.report.shown.span
    assert len(loaded.outputs) >= 2
    for file in loaded.outputs.values():
        assert file.parent == tmp_path / "build" / "jobs"
        assert file.exists()


def test_choices_of_the_solver_arrive(folder):
    text = """
        mesh = "plan.obj"
        [solver]
        sites = "faces"
        energy = "{}"
        method = "flow"
        delaunay = true
        [output]
        combinatorics = "corner"
        """
    for energy, known_as in (("tan", "tan"), ("cotan", "dual_cotan")):
        settings = load_job(job(folder, text.format(energy))).settings
        assert settings.solver_choice == ("faces", known_as, True)
        assert (settings.method, settings.combinatorics) == ("flow", "corner")
    assert load_job(job(folder, PLAN)).settings.solver_choice == ("vertices", "cotan", False)


def test_leans_are_against_the_horizon_or_the_drawn_surface(folder):
    """Over a hipped plan: the rim stands upright, or at right angles to its sloping faces."""
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [2, 2, 2]], dtype=float)
    rows = [f"v {x} {y} {z}" for x, y, z in points] + ["f 1 2 5", "f 2 3 5", "f 3 4 5", "f 4 1 5"]
    (folder / "hip.obj").write_text("\n".join(rows) + "\n")
    z = {}
    for against in ("horizon", "surface"):
        read = load_job(job(folder, f'mesh = "hip.obj"\n[default]\ntilt = 20\nagainst = "{against}"\n'))
        assert read.settings.against == against
        normals = plan_conditions(read.plan, read.settings, plan_domain(read.plan)).edge_normals
        z[against] = normals[:, 2]
    assert_allclose(z["horizon"], np.sin(np.radians(20)), rtol=0, atol=1e-12)
    assert_allclose(z["surface"], np.sin(np.radians(20 - 45)), rtol=0, atol=1e-12)
    with pytest.raises(JobError, match="against"):
        load_job(job(folder, 'mesh = "hip.obj"\n[default]\nagainst = "wind"\n'))
