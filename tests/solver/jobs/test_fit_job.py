"""Jobs with a [fit]: exact caps, curves from files, a mesh to approximate, goals that cannot be met."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.__main__ import main
from solver.errors import JobError
from solver.fitting.gauss_map import GaussMapOptions
from solver.fitting.goals import OutlineOptions
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import Job, load_job, run_job
from solver.shells.plan import plan_domain

DISC = '[shape]\nkind = "disc"\nn = 150\nscale = 5.0\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    angle = 2 * np.pi * np.arange(90) / 90
    circle = np.column_stack([5 * np.cos(angle), 5 * np.sin(angle), 1 + 0.1 * np.cos(angle)])
    lines = [f"v {x} {y} {z}" for x, y, z in circle]
    ring = " ".join(str(k + 1) for k in [*range(90), 0])
    (tmp_path / "curve.obj").write_text("\n".join([*lines, f"l {ring}\n"]))
    (tmp_path / "two.obj").write_text("\n".join([*lines, "l 1 30 60 1", "l 2 31 61 2\n"]))
    return tmp_path


def load(folder: Path, text: str) -> Job:
    path = folder / "job.toml"
    path.write_text(text)
    return load_job(path)


# --- what fits give ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("height_parameter", "value", "measure"),
    [
        ("rise", 0.4, lambda f: f.placed["f+"][:, 2].max() / 5),
        ("height", 2.0, lambda f: f.placed["f+"][:, 2].max()),
        ("mean_curvature", 0.12, lambda f: f.report.mean_curvature),
    ],
)
def test_a_cap_over_a_circle(folder, height_parameter, value, measure):
    text = DISC + f'[fit]\n{height_parameter} = {value}\n[output]\nf_plus = "cap.obj"\nreport = "cap.json"\n'
    shell = run_job(load(folder, text))
    assert shell.ok, shell.message
    assert_allclose(measure(shell), value, rtol=5e-3)
    cap = shell.placed["f+"]
    rim = np.unique(shell.surface.domain.edges[shell.surface.domain.boundary_edges])
    assert_allclose(np.linalg.norm(cap[rim], axis=1), 5, atol=0.025)
    centre = np.array([0, 0, cap[:, 2].max() - 1 / shell.report.mean_curvature])
    assert_allclose(np.linalg.norm(cap - centre, axis=1) * shell.report.mean_curvature, 1, atol=0.02)
    assert_allclose(read_mesh(folder / "cap.obj").positions, cap, atol=1e-12)
    written = json.loads((folder / "cap.json").read_text())
    assert written["fit"]["met"] is True
    assert written["fit"]["evaluations"] == len(shell.fit.history)
    assert written["fit"]["distances"] == {k: pytest.approx(v) for k, v in shell.fit.distances.items()}
    assert written["message"] == shell.message


def test_a_curve_from_a_file(folder):
    shell = run_job(load(folder, DISC + '[fit]\noutline = "curve.obj"\nrise = 0.3\n'))
    assert shell.ok, shell.message
    rim = shell.placed["f+"][shell.surface.domain.boundary_vertices]
    assert_allclose(rim[:, 2], 1 + 0.02 * rim[:, 0], atol=0.03)
    assert shell.report.shown.outline.max < 0.05


def test_anchors_draw_the_rim(folder):
    """Four supports at the corners of a square: the shell stands on them."""
    loaded = load(folder, DISC)
    points = loaded.plan.positions
    feet = [
        int(np.argmin(np.linalg.norm(points - goal, axis=1)))
        for goal in 5.0 * np.array([*np.eye(3)[:2], *-np.eye(3)[:2]])
    ]
    tables = "".join(f"[[fit.anchors]]\nvertex = {k}\nplace = {(1.1 * points[k]).tolist()}\n" for k in feet)
    shell = run_job(load(folder, DISC + "[fit]\nrise = 0.3\n" + tables))
    assert shell.ok, shell.message
    assert_allclose(shell.placed["f+"][feet], 1.1 * points[feet], atol=0.05)
    together = f"[[fit.anchors]]\nvertices = {feet}\nplaces = {(1.1 * points[feet]).tolist()}\n"
    fit = load(folder, DISC + "[fit]\n" + together).fit
    assert isinstance(fit, OutlineOptions) and fit.anchors is not None and not fit.on_curve
    assert_allclose(fit.anchors[1], 1.1 * points[feet])


@pytest.mark.parametrize(("least", "met"), [(40, True), (60, False)])
def test_bounds_on_the_tilt(folder, least, met):
    """Over a circle a cap of rise r leans by 90° - 2 atan r, of 0.4 by 46.4°."""
    shell = run_job(load(folder, DISC + f"[fit]\nrise = 0.4\ntilt = [{least}, 90]\n"))
    assert shell.fit is not None and shell.fit.is_met == met, shell.message
    off = np.degrees(shell.fit.distances["tilt bounds"])
    if met:
        assert_allclose(shell.placed["f+"][:, 2].max(), 2.0, rtol=5e-3)
    assert off < 0.6 if met else off > 0.6


COURT = """[shape]
kind = "polygon"
outline = [[0, 0], [12, 0], [12, 10], [0, 10]]
holes = [[[3, 3], [6, 3], [6, 6], [3, 6]]]
max_edge = 0.8
corner_radius = 1.4
"""


def test_a_courtyard_is_closed(folder):
    shell = run_job(load(folder, COURT + "[fit]\nrise = 0.2\n"))
    assert shell.fit is not None and not shell.surface.is_open
    assert shell.fit.distances["period"] < 1e-3 * 15.6
    assert shell.report.shown.outline.max < 0.06 * 15.6


def test_curves_for_a_courtyard(folder):
    """The court's line is raised by one; the outer one is the plan's own, but written into the file."""
    plan = load(folder, COURT).plan
    court, outer = sorted((plan.positions[loop] for loop in plan_domain(plan).boundary_loops), key=np.ptp)
    lines = [f"v {x} {y} {z}" for x, y, z in [*(court + [0, 0, 1.0]), *outer]]
    first = len(court)
    loops = [[*range(1, first + 1), 1], [*range(first + 1, first + len(outer) + 1), first + 1]]
    (folder / "lines.obj").write_text("\n".join([*lines, *("l " + " ".join(map(str, loop)) for loop in loops)]) + "\n")
    shell = run_job(load(folder, COURT + "[fit]\noutline = 'lines.obj'\nrise = 0.3\n"))
    inner = min(shell.surface.domain.boundary_loops, key=lambda loop: np.ptp(plan.positions[loop]))
    assert not shell.surface.is_open
    assert_allclose(shell.placed["f+"][inner, 2].mean(), 1.0, atol=0.3)


def test_options_arrive(folder, monkeypatch):
    """The keys of the table reach the fit; the others keep the defaults of its options."""
    calls = []

    def stop(domain, positions, **options):
        calls.append(options)
        raise JobError("far enough")

    monkeypatch.setattr("solver.shells.fit.fit_outline", stop)
    text = "[fit]\noutline = true\nvolume = 9\nfree_heights = true\nsmooth = 1e-5\nsheet = 'f-'\nmax_evaluations = 7\n"
    text += "tilt = [-10, 90]\n[[fit.anchors]]\nvertex = 3\nplace = [1, 2, 3]\nweight = 0.5\n"
    for keys in (text, "[fit]\n"):
        with pytest.raises(JobError, match="far enough"):
            run_job(load(folder, DISC + keys))
    vertices, places, weights = calls[0].pop("anchors")
    assert (vertices.tolist(), places.tolist(), weights.tolist()) == ([3], [[1, 2, 3]], [0.5])
    assert calls[0].items() >= {"volume": 9.0, "free_heights": True, "smooth": 1e-5, "sheet": "f-"}.items()
    assert calls[0]["max_evaluations"] == 7 and calls[0]["on_curve"] is True and calls[0]["curve"] is None
    assert_allclose(calls[0]["tilt"], [-np.pi / 18, np.pi / 2])
    assert calls[1] == vars(OutlineOptions(solver=calls[1]["solver"]))


def test_options_of_an_approximation_arrive(cap, monkeypatch):
    calls = []

    def stop(domain, positions, **options):
        calls.append(options)
        raise JobError("far enough")

    monkeypatch.setattr("solver.shells.fit.fit_gauss_map", stop)
    for keys in ("regularisation = 0.01\nnear = 0.5\nmax_evaluations = 9\n", ""):
        with pytest.raises(JobError, match="far enough"):
            run_job(load(cap, f'mesh = "cap.obj"\n[fit]\napproximate = true\n{keys}'))
    assert calls[0].items() >= {"regularisation": 0.01, "near": 0.5, "max_evaluations": 9}.items()
    assert calls[1] == vars(GaussMapOptions(solver=calls[1]["solver"]))


@pytest.fixture
def cap(folder) -> Path:
    """A sphere's cap of radius 3, 0.8 rad wide, as a mesh file."""
    disc = shapes.disc(150)
    angle = 0.8 * np.linalg.norm(disc.positions, axis=1)
    flat = disc.positions / np.maximum(np.linalg.norm(disc.positions, axis=1), 1e-9)[:, None]
    points = 3 * np.column_stack([np.sin(angle)[:, None] * flat, np.cos(angle)])
    write_mesh(folder / "cap.obj", MeshData(points, list(disc.domain.faces)))
    return folder


def test_a_mesh_that_is_a_sphere_is_its_own_approximation(cap):
    shell = run_job(load(cap, 'mesh = "cap.obj"\n[fit]\napproximate = true\nregularisation = 1e-6\n'))
    assert shell.ok, shell.message
    assert_allclose(shell.placed[shell.report.sheet], read_mesh(cap / "cap.obj").positions, atol=0.03)
    assert_allclose(shell.report.mean_curvature, 1 / 3, rtol=0.02)
    assert shell.fit is not None and shell.fit.distances["Gauss map"] < 0.02


def test_a_hypar_is_approximated_by_a_minimal_surface(folder):
    """H = 0 in the report; the sheets that such a surface has are written."""
    square = shapes.polygon([[-5, -5], [5, -5], [5, 5], [-5, 5]], max_edge=1.0)
    points = np.column_stack([square.positions, 0.1 * square.positions.prod(axis=1)])
    write_mesh(folder / "hypar.obj", MeshData(points, list(square.domain.faces)))
    outputs = '[output]\nf_plus = "film.obj"\ngauss = "gauss.obj"\nreport = "film.json"\n'
    (folder / "job.toml").write_text(f'mesh = "hypar.obj"\n[fit]\napproximate = true\n{outputs}')
    assert main([str(folder / "job.toml")]) == 0
    report = json.loads((folder / "film.json").read_text())
    assert report["mean_curvature"] == 0.0 and report["fit"]["met"]
    x, y, z = read_mesh(folder / "film.obj").positions.T
    assert_allclose(z, 0.1 * x * y, rtol=0, atol=0.1)
    gauss = read_mesh(folder / "gauss.obj").positions  # a part of the unit sphere
    assert 0.3 < np.ptp(gauss, axis=0).max() < 2.0


def test_near_brings_an_approximation_nearer(cap):
    """A cap with waves, which no shell can have."""
    mesh = read_mesh(cap / "cap.obj")
    waves = 0.1 * np.sin(4 * mesh.positions[:, 0]) * np.cos(3 * mesh.positions[:, 1])
    write_mesh(cap / "wavy.obj", MeshData(mesh.positions + waves[:, None] * [0, 0, 1], mesh.polygons))
    far = []
    for near in ("", "near = 300\n"):
        shell = run_job(load(cap, f'mesh = "wavy.obj"\n[fit]\napproximate = true\n{near}'))
        placed = shell.placed[shell.report.sheet]
        far.append(np.abs(placed - read_mesh(cap / "wavy.obj").positions)[:, 2].mean())
    assert far[1] < 0.9 * far[0]


def test_a_goal_that_cannot_be_met(folder, capsys):
    """A circle of radius 5 spans no shell of 1/H = 2: the best one is written and the exit code is 1."""
    (folder / "job.toml").write_text(DISC + '[fit]\nmean_curvature = 0.5\n[output]\nf_plus = "best.obj"\n')
    assert main([str(folder / "job.toml")]) == 1
    assert "Choose a smaller one" in capsys.readouterr().err
    assert (folder / "best.obj").exists()


def test_what_is_printed(folder, capsys):
    (folder / "job.toml").write_text(DISC + "[fit]\nrise = 0.3\n")
    assert main(["-v", str(folder / "job.toml")]) == 0
    shown = capsys.readouterr()
    assert "rim on curve" in shown.out and "evaluations" in shown.out
    assert ": distance " in shown.err


# --- what is wrong -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[fit]\nris = 1", r'\[fit\]: unknown key "ris"; did you mean "rise"\?'),
        ("[fit]\nrise = 1\nvolume = 3", r"\[fit\]: give one of rise, height, volume, mean_curvature, not rise and vol"),
        ("[fit]\nrise = -1", r'\[fit\]: "rise" must be a positive number, from 1e-30 to 1e\+30, not -1'),
        ("[fit]\nsmooth = -1", r'"smooth" must be a number from 0 to 1e\+30, not -1'),
        ("[fit]\nmax_evaluations = 0", r'"max_evaluations" must be a whole number from 1 to 100,000, not 0'),
        ("[fit]\noutline = 3", r'"outline" must be true, false or an OBJ file'),
        ("[fit]\noutline = false", r'nothing to fit to: give "outline", "approximate" or \[\[fit.anchors\]\]'),
        ("[fit]\noutline = 'none.obj'", r"none\.obj cannot be read: No such file"),
        ("[fit]\noutline = 'curve.ply'", r"curve\.ply is no OBJ file"),
        ("[fit]\nsheet = 'g'", r'there is no sheet "g"'),
        ("[fit]\napproximate = true\nrise = 1", r'leaves no choice of "rise"; take it out'),
        ("[fit]\nregularisation = 1", r'"regularisation" goes with "approximate"'),
        ("[fit]\nnear = 1", r'"near" goes with "approximate"'),
        ("[fit]\napproximate = true\nnear = -1", r'"near" must be a number from 0'),
        ("[fit]\napproximate = true\ntilt = [0, 1]", r'leaves no choice of "tilt"'),
        ("[fit]\ntilt = 3", r'"tilt" must be a list of 2 numbers'),
        ("[fit]\ntilt = [50, 20]", r'"tilt" must be two angles from -90 to 90, smaller one first, not \[50,'),
        ("[fit]\ntilt = [0, 120]", r'"tilt" must be two angles from -90 to 90'),
        ("[fit]\noutline = 'two.obj'", r"two\.obj: There are 2 curves, but the plan's boundary has one loop"),
        ("[fit]\napproximate = true\nregularisation = -1", r'"regularisation" must be a number from 0'),
        ("[fit]\n[size]\nspan = 3", r"\[fit\]: a fit finds .* take size out"),
        ("[fit]\n[default]\n[[conditions]]\nloop = 0", r"take conditions and default out"),
        ("[[fit.anchors]]\nvertex = 1", r'\[\[fit.anchors\]\] 1: an anchor needs "vertex" and "place", or'),
        ("[[fit.anchors]]\nvertex = 1\nplace = [0, 0]", r'"place" must be a list of 3 numbers'),
        ("[[fit.anchors]]\nvertex = 1000\nplace = [0, 0, 0]", r"there is no vertex 1000; the mesh has \d+, counted"),
        ("[[fit.anchors]]\nvertices = [1, 2]\nplaces = [[0, 0, 0]]", r"2 vertices cannot be at 1 places"),
        ("[[fit.anchors]]\nvertices = [0.5]\nplaces = [[0, 0, 0]]", r'"vertices" must be a list of vertices'),
        ("[[fit.anchors]]\nvertex = 1\nplace = [0, 0, 0]\nweight = 0", r'"weight" must be a positive number'),
        ("[[fit.anchors]]\nvertex = 1\nplace = [0, 0, 0]\nwieght = 1", r'unknown key "wieght"; did you mean "weight"'),
    ],
)
def test_what_is_wrong_with_a_fit_is_named(folder, text, message):
    with pytest.raises(JobError, match=message):
        load(folder, DISC + text)
