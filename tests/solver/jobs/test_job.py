"""Job files: what they may say, what they give, and what they complain about."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.errors import CmcError, ConditionError, JobError, MeshError
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import EXAMPLE, SHAPES, load_job, run_job
from solver.shells.plan import Plan, plan_domain

JOBS = Path(__file__).parents[3] / "assets" / "jobs"


def quad_plan(columns: int = 6, rows: int = 4) -> MeshData:
    """A grid of quads with two materials, a seam in its UVs, and the bottom as a polyline group."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    index = np.arange(x.size).reshape(rows + 1, columns + 1)
    quads = [
        np.array([index[j, i], index[j, i + 1], index[j + 1, i + 1], index[j + 1, i]], dtype=np.int32)
        for j in range(rows)
        for i in range(columns)
    ]
    left = [quad[0] % (columns + 1) < columns // 2 for quad in quads]
    uv = np.column_stack([x.ravel() / columns, y.ravel() / rows])
    bottom = np.column_stack([index[0, :-1], index[0, 1:]]).astype(np.int32)
    return MeshData(
        positions=np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]),
        polygons=quads,
        uvs=np.vstack([uv, uv + [2.0, 0.0]]),
        uv_corners=[quad if one else quad + len(uv) for quad, one in zip(quads, left, strict=True)],
        objects=["plan"] * len(quads),
        groups=["west" if one else "east" for one in left],
        materials=["glass" if one else "oak" for one in left],
        edge_groups={"bottom": bottom},
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_mesh(tmp_path / "plan.obj", quad_plan())
    return tmp_path


def job(folder: Path, text: str) -> Path:
    path = folder / "job.toml"
    path.write_text(text)
    return path


def pairs(plan: Plan) -> list[set[frozenset[int]]]:
    return [{frozenset(pair) for pair in group.edges.tolist()} for group in plan.groups]


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
    "polygon": 'kind = "polygon"\noutline = [[0, 0], [8, 0], [8, 6], [0, 6]]\n'
    "holes = [[[3, 2], [3, 4], [5, 4], [5, 2]]]\nmax_edge = 1.0\ncorner_radius = 0.5",
}


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes(folder, kind):
    loaded = load_job(job(folder, f"[shape]\n{SHAPE_JOBS[kind]}\n[[conditions]]\nside = 'outer'\ntilt = 10"))
    plan = loaded.plan
    assert plan.positions.shape[1] == 3
    assert len(plan.groups[0].edges) > 10
    assert_allclose(loaded.mesh.uvs, plan.positions[:, :2])
    if kind == "disc":
        assert_allclose(np.linalg.norm(plan.positions, axis=1).max(), 5)
    if kind == "polygon":
        assert len(plan.positions) > 40


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


def test_up_is_y_on_both_ways(folder):
    write_mesh(folder / "y.obj", quad_plan(), up="y")
    text = 'mesh = "y.obj"\nup = "y"\n[output]\nf_plus = "shell.obj"'
    shell = run_job(load_job(job(folder, text)))
    assert shell.placed["f+"][:, 2].max() > 1
    assert read_mesh(folder / "shell.obj").positions[:, 1].max() > 1
    assert_allclose(read_mesh(folder / "shell.obj", up="y").positions, shell.placed["f+"], atol=1e-12)


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


PLAN = 'mesh = "plan.obj"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mesh = \nup = 1", r"job\.toml is not valid TOML: .*line 1"),
        ("", r'needs either mesh = "file" or a \[shape\]'),
        (PLAN + "[shape]\nkind = 'disc'", r'needs either mesh = "file" or a \[shape\]'),
        ("mesh = 3", r'"mesh" must be a text, not 3'),
        ("mesh = 'none.obj'", r"There is no file .*none\.obj"),
        (PLAN + "shap = 1", r'job\.toml: unknown key "shap"; did you mean "shape"\?'),
        (PLAN + "[size]\nspam = 3", r'\[size\]: unknown key "spam"; did you mean "span"\?'),
        (PLAN + "[size]\nspan = 3\nrise = 2", r"\[size\]: give one size, not span and rise"),
        (PLAN + "[size]\nspan = -3", r"\[size\]: The span must be a positive number, not -3"),
        (PLAN + "[size]\nspan = '3'", r'\[size\]: "span" must be a number, not "3"'),
        (PLAN + "[size]\nground = 'rom'", r'there is no ground "rom"; did you mean "rim"\?'),
        (PLAN + "[size]\nflip = 1", r'"flip" must be true or false, not 1'),
        (PLAN + "[size]\nsheet = 'g'", r'there is no sheet "g"; known are f\+, f-'),
        (PLAN + "[solver]\nside = 1.5", r'\[solver\]: "side" must be a whole number, not 1.5'),
        (PLAN + "[solver]\nsites = 'edges'", r'\[solver\]: there is no sites "edges"; known are vertices, faces'),
        (PLAN + "[solver]\nenergy = 'moebius'", r'\[solver\]: there is no energy "moebius"; did you mean "mobius"\?'),
        (PLAN + "[solver]\nenergy = 'mobius'", r'\[solver\]: "energy" and "sites" do not fit: .* choose cotan'),
        (PLAN + "[solver]\nmethod = 'newtn'", r'\[solver\]: there is no method "newtn"; did you mean "newton"\?'),
        (PLAN + "[solver]\ndelaunay = 1", r'\[solver\]: "delaunay" must be true or false, not 1'),
        (PLAN + "[solver]\naveraging = 'mean'", r'\[solver\]: there is no averaging "mean"'),
        (PLAN + "[output]\ncombinatorics = 'duel'", r'\[output\]: there is no combinatorics "duel"; did you mean'),
        (PLAN + "[solver]\ncombinatorics = 'dual'", r'\[solver\]: unknown key "combinatorics"'),
        (PLAN + "[solver]\nmaxiter = 9", r'\[solver\]: unknown key "maxiter"; known are'),
        (PLAN + "[output]\nfplus = 'a.obj'", r'\[output\]: unknown key "fplus"; did you mean "f_plus"\?'),
        (PLAN + "[output]\nf_plus = 'a.dxf'", r'"f_plus" has no format known here \("\.dxf"\)'),
        (PLAN + "[conditions]\nloop = 0", r'"conditions" must be written as \[\[conditions\]\]'),
        (
            PLAN + "[[conditions]]\ntilt = 1",
            r"\[\[conditions\]\] 1: a condition needs one of loop, side, .* it has none",
        ),
        (PLAN + "[[conditions]]\nloop = 0\nside = 'top'", r'it has "loop" and "side"'),
        (PLAN + "[[conditions]]\nloop = 1", r"there is no boundary loop 1; there are 1"),
        (PLAN + "[[conditions]]\nside = 'top'", r"only shapes have sides"),
        (PLAN + "[[conditions]]\ngroup = 'botom'", r'no group "botom" in the mesh; did you mean "bottom"\?'),
        (PLAN + "[[conditions]]\nedges = [[0, 1, 2]]", r'"edges" must be a list of pairs of vertices'),
        (PLAN + "[[conditions]]\nedges = [[0, 1.5]]", r'"edges" must be whole numbers'),
        (PLAN + "[[conditions]]\nvertices = [0, 8]", r"no boundary edge has both ends among these"),
        (PLAN + "[[conditions]]\nloop = 0\nkind = 'plain'", r'no kind "plain"; did you mean "plane"\?'),
        (PLAN + "[[conditions]]\nloop = 0\nm = 2", r'\[\[conditions\]\] 1: unknown key "m"; known are'),
        (
            PLAN + "[[conditions]]\nloop = 0\nkind = 'plane'\nnormal = [1, 0]",
            r'"normal" must be a list of 3 numbers',
        ),
        (PLAN + "[default]\nkind = 'fre'", r'\[default\]: there is no kind "fre"; did you mean "free"\?'),
        ("[shape]\nkind = 'dics'\nn = 50", r'\[shape\]: there is no shape "dics"; did you mean "disc"\?'),
        ("[shape]\nkind = 'disc'", r'a disc needs "n"'),
        ("[shape]\nkind = 'disc'\nn = 50\nradius = 2", r'\[shape\]: unknown key "radius"'),
        ("[shape]\nkind = 'disc'\nn = 50\nscale = 0", r'"scale" must be positive, not 0'),
        ("[shape]\nkind = 'disc'\nn = 2", r"\[shape\]: .*disc"),
        (
            "[shape]\nkind = 'disc'\nn = 60\n[[conditions]]\nside = 'outr'",
            r'no side "outr"; did you mean "outer"\?',
        ),
        ("up = 'x'\n" + PLAN, r'there is no up "x"; known are y, z'),
    ],
)
def test_what_is_wrong_with_a_job_is_named(folder, text, message):
    with pytest.raises(JobError, match=message):
        load_job(job(folder, text))


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        (
            "edges = [[0, 8]]",
            ConditionError,
            r'"edges of \[\[conditions\]\] 1": No boundary edge joins vertices 0, 8',
        ),
        (
            "loop = 0\n[[conditions]]\ngroup = 'bottom'",
            ConditionError,
            r'two groups, "loop 0" and "group bottom"',
        ),
        ("loop = 0\nkind = 'free'", ConditionError, "All boundary edges are free"),
    ],
)
def test_conditions_that_do_not_fit_the_mesh(folder, text, error, message):
    with pytest.raises(error, match=message):
        load_job(job(folder, PLAN + "[[conditions]]\n" + text))


def test_meshes_that_are_no_plan(folder):
    write_mesh(folder / "one.obj", MeshData(np.eye(3), [np.array([0, 1, 2])]))
    with pytest.raises(MeshError, match="no vertex inside its boundary"):
        load_job(job(folder, 'mesh = "one.obj"'))
    (folder / "bad.obj").write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match=r"bad\.obj, line 2: there is no vertex 2"):
        load_job(job(folder, 'mesh = "bad.obj"'))


def test_a_job_that_is_not_there(tmp_path):
    with pytest.raises(JobError, match=r"nosuch\.toml cannot be read: No such file"):
        load_job(tmp_path / "nosuch.toml")


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


# --- sites, energies, faces ----------------------------------------------------------------


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


DISC = "[shape]\nkind = 'disc'\nn = 100\nscale = 5\n"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("[default]\ntilt = 0.6109\n", r'[default]: "tilt" is 0.6109°'),
        ("[[conditions]]\nloop = 0\ntilt = -0.35\n", r'[[conditions]] 1: "tilt" is -0.35°'),
        ("[fit]\nrise = 0.3\ntilt = [0.2, 90]\n", r'[fit]: "tilt" is 0.2°'),
    ],
)
def test_degrees_that_look_like_radians_are_noticed(folder, text, where):
    loaded = load_job(job(folder, DISC + text + "[output]\nreport = 'report.json'\n"))
    assert len(loaded.warnings) == 1 and loaded.warnings[0].startswith(where)
    assert "angles in jobs are in degrees" in loaded.warnings[0]
    shell = run_job(loaded)
    assert shell.warnings[0] == loaded.warnings[0]
    assert json.loads((folder / "report.json").read_text())["warnings"] == shell.warnings


@pytest.mark.parametrize("tilt", ["0", "1", "1.0", "2.5", "-20"])
def test_plain_degrees_are_not(folder, tilt):
    assert not load_job(job(folder, DISC + f"[default]\ntilt = {tilt}\n")).warnings
