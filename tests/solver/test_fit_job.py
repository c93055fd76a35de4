"""Jobs with a [fit]: exact caps, curves from files, a mesh that is approximated, wishes that cannot be met."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.__main__ import main
from solver.errors import JobError
from solver.files import MeshData, read_mesh, write_mesh
from solver.fit_table import read_curve
from solver.job import Job, load_job, run_job

DISC = '[shape]\nkind = "disc"\nn = 150\nscale = 5.0\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    angle = 2 * np.pi * np.arange(90) / 90
    circle = np.column_stack([5 * np.cos(angle), 5 * np.sin(angle), 1 + 0.1 * np.cos(angle)])
    lines = [f"v {x} {y} {z}" for x, y, z in circle]
    ring = " ".join(str(k + 1) for k in [*range(90), 0])
    (tmp_path / "curve.obj").write_text("\n".join([*lines, f"l {ring}\n"]))
    return tmp_path


def load(folder: Path, text: str) -> Job:
    path = folder / "job.toml"
    path.write_text(text)
    return load_job(path)


# --- what fits give ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("knob", "value", "measure"),
    [
        ("rise", 0.4, lambda f: f.placed["f+"][:, 2].max() / 5),
        ("height", 2.0, lambda f: f.placed["f+"][:, 2].max()),
        ("mean_curvature", 0.12, lambda f: f.report.mean_curvature),
    ],
)
def test_a_cap_over_a_circle(folder, knob, value, measure):
    text = DISC + f'[fit]\n{knob} = {value}\n[output]\nf_plus = "cap.obj"\nreport = "cap.json"\n'
    formed = run_job(load(folder, text))
    assert formed.converged, formed.message
    assert_allclose(measure(formed), value, rtol=5e-3)
    cap = formed.placed["f+"]
    rim = np.unique(formed.surface.domain.edges[formed.surface.domain.boundary_edges])
    assert_allclose(np.linalg.norm(cap[rim], axis=1), 5, atol=0.025)
    centre = np.array([0, 0, cap[:, 2].max() - 1 / formed.report.mean_curvature])
    assert_allclose(np.linalg.norm(cap - centre, axis=1) * formed.report.mean_curvature, 1, atol=0.02)
    assert_allclose(read_mesh(folder / "cap.obj").positions, cap, atol=1e-12)
    written = json.loads((folder / "cap.json").read_text())
    assert written["fit"]["met"] is True
    assert written["fit"]["evaluations"] == len(formed.fit.history)
    assert written["fit"]["distances"] == {k: pytest.approx(v) for k, v in formed.fit.distances.items()}
    assert written["message"] == formed.message


def test_a_curve_from_a_file(folder):
    formed = run_job(load(folder, DISC + '[fit]\noutline = "curve.obj"\nrise = 0.3\n'))
    assert formed.converged, formed.message
    rim = formed.placed["f+"][formed.surface.domain.boundary_vertices]
    assert_allclose(rim[:, 2], 1 + 0.02 * rim[:, 0], atol=0.03)
    assert formed.report.shown.outline.max < 0.05


def test_a_curve_whose_up_is_y(folder):
    points = read_curve(folder / "curve.obj")
    turned = read_curve(folder / "curve.obj", up="y")
    assert_allclose(turned, np.column_stack([points[:, 0], -points[:, 2], points[:, 1]]))
    assert_allclose(points[:, 2], 1 + 0.02 * points[:, 0], atol=1e-12)
    assert len(points) == 90
    assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 10 * np.sin(np.pi / 90), rtol=1e-3)


def test_a_curve_whose_last_point_repeats_the_first(folder):
    (folder / "closed.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\ng a\nl 1 2 3 4\n")
    assert_allclose(read_curve(folder / "closed.obj"), [[0, 0, 0], [1, 0, 0], [1, 1, 0]])


def test_anchors_draw_the_rim(folder):
    """Four supports at the corners of a square: the shell stands on them."""
    loaded = load(folder, DISC)
    points = loaded.plan.positions
    feet = [
        int(np.argmin(np.linalg.norm(points - goal, axis=1)))
        for goal in 5.0 * np.array([*np.eye(3)[:2], *-np.eye(3)[:2]])
    ]
    tables = "".join(f"[[fit.anchors]]\nvertex = {k}\nplace = {(1.1 * points[k]).tolist()}\n" for k in feet)
    formed = run_job(load(folder, DISC + "[fit]\nrise = 0.3\n" + tables))
    assert formed.converged, formed.message
    assert_allclose(formed.placed["f+"][feet], 1.1 * points[feet], atol=0.05)
    together = f"[[fit.anchors]]\nvertices = {feet}\nplaces = {(1.1 * points[feet]).tolist()}\n"
    wish = load(folder, DISC + "[fit]\n" + together).wish
    assert wish is not None and wish.anchors is not None and not wish.on_curve
    assert_allclose(wish.anchors[1], 1.1 * points[feet])


def test_wishes_arrive(folder, monkeypatch):
    """What the table says reaches the fit, and what it does not say stays the fit's own."""
    calls = []

    def stop(domain, positions, **wishes):
        calls.append(wishes)
        raise JobError("far enough")

    monkeypatch.setattr("solver.fitting.fit_outline", stop)
    text = "[fit]\noutline = true\nvolume = 9\nfree_heights = true\nsmooth = 1e-5\nsheet = 'f-'\nmax_evaluations = 7\n"
    text += "[[fit.anchors]]\nvertex = 3\nplace = [1, 2, 3]\nweight = 0.5\n"
    for wished in (text, "[fit]\n"):
        with pytest.raises(JobError, match="far enough"):
            run_job(load(folder, DISC + wished))
    vertices, places, weights = calls[0].pop("anchors")
    assert (vertices.tolist(), places.tolist(), weights.tolist()) == ([3], [[1, 2, 3]], [0.5])
    assert calls[0].items() >= {"volume": 9.0, "free_heights": True, "smooth": 1e-5, "sheet": "f-"}.items()
    assert calls[0]["max_evaluations"] == 7 and calls[0]["on_curve"] is True and calls[0]["curve"] is None
    assert "max_evaluations" not in calls[1] and "rise" not in calls[1] and calls[1]["anchors"] is None


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
    formed = run_job(load(cap, 'mesh = "cap.obj"\n[fit]\napproximate = true\nregularisation = 1e-6\n'))
    assert formed.converged, formed.message
    assert_allclose(formed.placed[formed.report.sheet], read_mesh(cap / "cap.obj").positions, atol=0.03)
    assert_allclose(formed.report.mean_curvature, 1 / 3, rtol=0.02)
    assert formed.fit is not None and formed.fit.distances["Gauss map"] < 0.02


def test_a_wish_that_cannot_be_met(folder, capsys):
    """A circle of radius 5 spans no shell of 1/H = 2: the best one is written and the exit code is 1."""
    (folder / "job.toml").write_text(DISC + '[fit]\nmean_curvature = 0.5\n[output]\nf_plus = "best.obj"\n')
    assert main([str(folder / "job.toml")]) == 1
    assert "ask for a smaller mean curvature" in capsys.readouterr().err
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
        ("[fit]\nrise = -1", r'\[fit\]: "rise" must be positive, not -1'),
        ("[fit]\nsmooth = -1", r'"smooth" must be zero or more, not -1'),
        ("[fit]\nmax_evaluations = 0", r'"max_evaluations" must be 1 or more, not 0'),
        ("[fit]\noutline = 3", r'"outline" must be true, false or an OBJ file'),
        ("[fit]\noutline = false", r'nothing to fit to: give "outline", "approximate" or \[\[fit.anchors\]\]'),
        ("[fit]\noutline = 'none.obj'", r"none\.obj cannot be read: No such file"),
        ("[fit]\noutline = 'curve.ply'", r"curve\.ply is no OBJ file"),
        ("[fit]\nsheet = 'g'", r'there is no sheet "g"'),
        ("[fit]\napproximate = true\nrise = 1", r'leaves no choice of "rise"; take it out'),
        ("[fit]\nregularisation = 1", r'"regularisation" goes with "approximate"'),
        ("[fit]\napproximate = true\nregularisation = -1", r'"regularisation" must be zero or more'),
        ("[fit]\n[size]\nspan = 3", r"\[fit\]: a fit finds .* take size out"),
        ("[fit]\n[default]\n[[conditions]]\nloop = 0", r"take conditions and default out"),
        ("[[fit.anchors]]\nvertex = 1", r'\[\[fit.anchors\]\] 1: an anchor needs "vertex" and "place", or'),
        ("[[fit.anchors]]\nvertex = 1\nplace = [0, 0]", r'"place" must be a list of 3 numbers'),
        ("[[fit.anchors]]\nvertex = 1000\nplace = [0, 0, 0]", r"there is no vertex 1000; the mesh has \d+, counted"),
        ("[[fit.anchors]]\nvertices = [1, 2]\nplaces = [[0, 0, 0]]", r"2 vertices cannot be at 1 places"),
        ("[[fit.anchors]]\nvertices = [0.5]\nplaces = [[0, 0, 0]]", r'"vertices" must be a list of vertices'),
        ("[[fit.anchors]]\nvertex = 1\nplace = [0, 0, 0]\nweight = 0", r'"weight" must be positive'),
        ("[[fit.anchors]]\nvertex = 1\nplace = [0, 0, 0]\nwieght = 1", r'unknown key "wieght"; did you mean "weight"'),
    ],
)
def test_what_is_wrong_with_a_fit_is_named(folder, text, message):
    with pytest.raises(JobError, match=message):
        load(folder, DISC + text)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("l 1 2 3", "no closed polyline .* Its vertex 0 has 1 segments"),
        ("f 1 2 3", "no closed polyline"),
        ("l 1 2 3 1\nl 4 5 6 4", "more than one closed polyline"),
        ("l 1 2 9", r"line 7: there is no vertex 9"),
    ],
)
def test_curves_that_are_none(folder, lines, message):
    (folder / "bad.obj").write_text("".join(f"v {k} {k * k} 0\n" for k in range(6)) + lines + "\n")
    with pytest.raises(JobError, match=message):
        load(folder, DISC + '[fit]\noutline = "bad.obj"')
