"""Jobs with sides on lines: their kinds, sizes and curves, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver.__main__ import main
from solver.errors import CmcError, JobError
from solver.io.mesh_files import read_mesh
from solver.jobs.job import load_job

LINE = '[default]\nkind = "line"\n'
DISC = f'[shape]\nkind = "disc"\nn = 300\nscale = 5.0\n{LINE}'
HALL = f'[shape]\nkind = "rectangle"\nwidth = 8\nheight = 5\ncolumns = 16\n{LINE}'
RING = f'[shape]\nkind = "annulus"\ninner = 0.5\nouter = 1.0\nn = 600\n{LINE}'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    angle = 2 * np.pi * np.arange(90) / 90
    lines = [f"v {0.6 * x} {0.6 * y} 0.5" for x, y in zip(np.cos(angle), np.sin(angle), strict=True)]
    ring = " ".join(str(k + 1) for k in [*range(90), 0])
    (tmp_path / "upper.obj").write_text("\n".join([*lines, f"l {ring}\n"]))
    (tmp_path / "two.obj").write_text("\n".join([*lines, "l 1 30 60 1", "l 2 31 61 2\n"]))
    return tmp_path


def run(folder: Path, text: str) -> tuple[int, dict, np.ndarray]:
    (folder / "job.toml").write_text(text + '\n[output]\nf_plus = "shell.obj"\nreport = "report.json"\n')
    code = main([str(folder / "job.toml")])
    report = json.loads((folder / "report.json").read_text())
    return code, report, read_mesh(folder / "shell.obj").positions


@pytest.mark.parametrize(
    "size, height",
    [
        ("", 1.75),
        ("[size]\nrise = 0.4", 2.0),
        ("[size]\nheight = -1.5", -1.5),
        ("[size]\ncurvature = 0", 0.0),
        ("[size]\ncurvature = -0.12", -5 * 1 / 3),
        ("[size]\nmean_curvature = 0.12", 5 * 1 / 3),
        ("[size]\nvolume = 82.7\nflip = true", -2.0),
    ],
)
def test_every_size_of_a_cap(folder, size, height):
    """Over a circle of radius 5; the volume of a cap of height 2 is π 2 (75 + 4) / 6 = 82.7."""
    code, report, points = run(folder, f"{DISC}{size}")
    z = points[:, 2]
    assert code == 0 and report["converged"]
    assert_allclose(z[np.abs(z).argmax()], height, rtol=0.03, atol=1e-9)


def test_leans_mirrors_and_lines_in_one_job(folder):
    sides = (
        '[[conditions]]\nside = "top"\nkind = "lean"\nangle = 70\n'
        '[[conditions]]\nside = "left"\nkind = "mirror"\nnormal = [-1, 0, 0]\n'
    )
    code, report, points = run(folder, f"{HALL}{sides}[size]\nrise = 0.3")
    assert code == 0
    assert report["planes"][0]["relative"] < 1e-9
    assert_allclose(points[:, 2].max(), 0.75, rtol=1e-2)


def test_lines_and_a_touched_plane_in_one_job(folder):
    """The report says how far each side is from what was asked of it."""
    side = '[[conditions]]\nside = "top"\nkind = "plane"\nnormal = [0, 0.64, 0.77]\n'
    _, report, _ = run(folder, f"{HALL}{side}[size]\nrise = 0.3")
    sides = {each["name"]: each for each in report["sides"]}
    assert sides["side top"]["kind"] == "held" and sides["side top"]["angle"] < 1e-5
    assert sides[""]["kind"] == "line" and sides[""]["distance"] < 0.05


def test_a_ring_between_the_drawn_line_and_a_curve(folder):
    inner = '[[conditions]]\nside = "inner"\nkind = "line"\ncurve = "upper.obj"\n'
    code, report, points = run(folder, f"{RING}{inner}[size]\ncurvature = 0")
    assert code == 0 and report["mean_curvature"] == 0.0
    assert_allclose([points[:, 2].min(), points[:, 2].max()], [0.0, 0.5], atol=1e-6)


def test_holes_and_corners_are_chosen(folder):
    code, _, _ = run(folder, f'{RING}[solver]\nholes = "keep"\n[size]\nheight = 0.03')
    assert code == 0
    (folder / "job.toml").write_text(f'{RING}[solver]\ncorners = "sharpp"')
    with pytest.raises(JobError, match='no corners "sharpp"; did you mean "sharp"'):
        load_job(folder / "job.toml")


@pytest.mark.parametrize(
    "text, message",
    [
        (f"{DISC}[size]\nspan = 3.0", 'not sized by "span"'),
        (f"{DISC}[size]\nrise = 3.0", '"rise" must be a number of at most 2 in size, not 3'),
        (f"{DISC}[size]\nrise = 0.3\ncurvature = 0", "give one size, not rise and curvature"),
        (f'{DISC}[solver]\nmethod = "saddle"', 'leave out "method"'),
        (f'{DISC}[[conditions]]\nside = "outer"\nkind = "line"\ncurve = "two.obj"', "two.obj has 2 closed polylines"),
        (f'{DISC}[[conditions]]\nside = "outer"\nkind = "line"\ncurve = "none.obj"', "none.obj cannot be read"),
        (f'{DISC}[[conditions]]\nside = "outer"\nkind = "lean"\ncurve = "two.obj"', 'unknown key "curve"'),
        (f'{DISC}[[conditions]]\nside = "outer"\nkind = "lean"\nangle = 170', "A lean of 170° is out of range"),
    ],
)
def test_what_does_not_fit_is_named_before_solving(folder, text, message):
    (folder / "job.toml").write_text(text)
    with pytest.raises(CmcError, match=message):
        load_job(folder / "job.toml")


def test_a_result_may_not_overwrite_the_curve(folder):
    inner = '[[conditions]]\nside = "inner"\nkind = "line"\ncurve = "upper.obj"\n'
    (folder / "job.toml").write_text(f'{RING}{inner}[output]\nf_plus = "upper.obj"\n')
    with pytest.raises(JobError, match=r'would overwrite "curve" of \[\[conditions\]\] 1'):
        load_job(folder / "job.toml")
