"""Jobs with a [close] table: courts that close in each of four ways, what moves, what is left, what is wrong."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ClosingOptions
from solver.__main__ import main
from solver.domain.topology import Homology
from solver.errors import CmcError, JobError
from solver.io.mesh_files import read_mesh
from solver.jobs.job import load_job, run_job
from solver.jobs.outcomes import FAILED, OK, UNUSABLE
from solver.shells.form import form
from solver.shells.gaps import hole_loops, turns_of_loops
from solver.shells.plan import plan_domain

COURT = """
[shape]
kind = "polygon"
outline = [[0, 0], [12, 0], [12, 10], [0, 10]]
holes = [[[3, 3], [6, 3], [6, 6], [3, 6]]]
max_edge = 1.1
corner_radius = 1.4
[[conditions]]
side = "outer"
tilt = 50
[[conditions]]
side = "hole0"
tilt = 35
"""
OUTPUT = '[output]\nf_plus = "shell.obj"\nreport = "report.json"\n'


def job_file(folder, close: str, plan: str = COURT):
    path = folder / "job.toml"
    path.write_text(plan + close + OUTPUT)
    return path


def written(folder) -> dict:
    return json.loads((folder / "report.json").read_text())


@pytest.mark.parametrize("way", ["normals", "tilts", "hole", "both"])
def test_a_court_closes_and_what_changed_is_told(tmp_path, way, capsys):
    path = job_file(tmp_path, f'[close]\nby = "{way}"\n')
    assert main(["-v", str(path)]) == OK
    shown = capsys.readouterr()
    assert "step 1: residual or gap" in shown.err
    report, plan = written(tmp_path), load_job(path).plan
    closing = report["closing"]
    assert closing["closed"] and closing["gap_before"] > 0.1 and closing["gap"] < 1e-8 and closing["steps"] <= 10
    assert closing["area_ratio"] > 0.9
    assert not report["is_open"] and report["holes"][0]["relative"] < 1e-8
    assert report["message"] == closing["message"] and "The gap was" in closing["message"]
    shell = read_mesh(tmp_path / "shell.obj")
    assert len(shell.positions) == len(plan.positions), "welded across the cut"
    turns, moves = closing["largest_turn"] > 1.0, bool(closing["moved"])
    assert (turns, moves) == {"hole": (False, True), "both": (True, True)}.get(way, (True, False))
    assert closing["message"] in shown.out
    assert ("turned by" in closing["message"]) == turns and ("Holes moved" in closing["message"]) == moves
    if turns:
        assert closing["rms_turn"] < closing["largest_turn"]
    if moves:
        assert set(closing["moved"]) == {"x", "y", "twist"}
        assert 0.1 < closing["moved"]["x"] < 3.0, "a length in the units of the plan"


def test_without_the_table_the_gap_is_told(tmp_path):
    assert main([str(job_file(tmp_path, ""))]) == FAILED
    report = written(tmp_path)
    (hole,) = report["holes"]
    assert hole["name"] == "hole 1" and "closing" not in report
    assert_allclose(hole["length"], report["gap"], rtol=1e-9)
    assert hole["relative"] == pytest.approx(hole["length"] / 17, rel=0.2)


def test_one_motion_does_not_close_and_says_what_is_left(tmp_path, capsys):
    path = job_file(tmp_path, '[close]\nby = "hole"\nmove = ["size"]\nmax_steps = 3\n')
    assert main([str(path)]) == FAILED
    report = written(tmp_path)
    assert not report["closing"]["closed"] and report["closing"]["gap"] > 1e-3 and report["is_open"]
    assert report["closing"]["gap"] == report["holes"][0]["relative"], "one gap, one number"
    assert report["closing"]["message"] == report["message"] == report["warnings"][0]["text"]
    assert " and is " in report["message"] and "The surface closes" not in report["message"]
    assert report["message"].split(".")[0] in capsys.readouterr().err


TWO = """
[shape]
kind = "polygon"
outline = [[0, 0], [14, 0], [14, 8], [0, 8]]
holes = [[[3, 3], [5, 3], [5, 5], [3, 5]], [[9, 2.5], [11.5, 2.5], [11.5, 5], [9, 5]]]
max_edge = 1.1
corner_radius = 0.9
[default]
tilt = 40
"""


def test_gaps_are_those_around_each_hole(tmp_path):
    """Against sums of tau over the edges that a walk along the hole crosses."""
    shell = run_job(load_job(job_file(tmp_path, "", TWO)))
    surface, domain = shell.surface, shell.surface.domain
    N, (i, j) = surface.harmonic.normals, domain.edges.T
    tau = domain.cotan_weights[:, None] * np.cross(N[i], N[j])
    tau[domain.boundary_edges] = 0.0
    gaps, ends = shell.gaps, []
    assert [gap.name for gap in gaps] == ["hole 1", "hole 2"]
    for gap, loop in zip(gaps, hole_loops(domain), strict=True):
        on = np.isin(np.arange(domain.vertex_count), domain.boundary_loops[loop])
        period = tau[on[i]].sum(axis=0) - tau[on[j]].sum(axis=0)
        world = shell.similarity.scale * shell.similarity.directions(period[None])[0]
        assert_allclose(gap.length, np.linalg.norm(world), rtol=1e-6)
        assert min(np.linalg.norm(gap.period - world), np.linalg.norm(gap.period + world)) < 1e-6
        rim = shell.placed["f+"][on[shell.source]]
        ends.append(max(np.linalg.norm(rim - end, axis=1).min() for end in (gap.at, gap.at + gap.period)))
    assert min(ends) < 1e-6, "from one end of the gap to the other, where one cut ends at the hole"
    assert not turns_of_loops(Homology.of(domain)).sum(axis=0).any(), "all loops together bound"


def test_one_hole_of_two_moves(tmp_path):
    path = job_file(tmp_path, '[close]\nby = "both"\nholes = [1]\nweight = 0.5\n', TWO)
    job = load_job(path)
    assert job.settings.close == ClosingOptions("both", 0.5, holes=(1,))
    assert main([str(path)]) == OK
    assert set(written(tmp_path)["closing"]["moved"]) == {"x", "y", "twist"}
    each = job_file(tmp_path, '[close]\nby = "both"\nmove = { 2 = ["x"], 1 = ["y", "size"] }\n', TWO)
    assert main([str(each)]) == OK
    assert set(written(tmp_path)["closing"]["moved"]) == {"hole 2 x", "hole 1 y", "hole 1 size"}
    both = job_file(tmp_path, '[close]\nby = "both"\n', TWO)
    assert main([str(both)]) == OK
    assert set(written(tmp_path)["closing"]["moved"]) == {f"hole {k} {q}" for k in (1, 2) for q in ("x", "y", "twist")}


def test_the_plan_with_the_moved_hole_gives_the_closed_shell(tmp_path):
    """Shifted, not turned, a hole's rim has the normals that it had."""
    symmetric = COURT.replace("[3, 3], [6, 3], [6, 6], [3, 6]", "[3, 3.5], [6, 3.5], [6, 6.5], [3, 6.5]")
    job = load_job(job_file(tmp_path, '[close]\nby = "hole"\nmove = ["x", "y", "twist"]\n', symmetric))
    shell = form(job.plan, job.settings)
    assert shell.closing is not None and shell.closed and abs(shell.closing.moved["twist"]) < 0.2
    loop = plan_domain(job.plan).boundary_loops[hole_loops(plan_domain(job.plan))[0]]
    assert shell.adapted_plan is not None
    shift = (shell.adapted_plan - job.plan.positions[:, :2])[loop].mean(axis=0)
    assert_allclose(shift, [shell.closing.moved["x"], shell.closing.moved["y"]], atol=2e-6)
    again = form(shell.closing.plan, replace(job.settings, close=None), intersections=False)
    assert again.closing is None and again.gaps[0].relative < 2e-3


@pytest.mark.parametrize(("table", "message"), [
    ('by = "force"', r'\[close\]: there is no by "force"'),
    ("wieght = 1", r'unknown key "wieght"; did you mean "weight"'),
    ("weight = 1", r'"weight" goes with by = "both", not with "normals"'),
    ('by = "normals"\nmove = ["x"]', r'"move" goes with by = "hole" or "both", not with "normals"'),
    ('by = "hole"\nmove = ["up"]', r'there is no motion "up" of a hole; known are x, y'),
    ('by = "hole"\nmove = []', r"The holes need a motion"),
    ('by = "hole"\nmove = {}', r"The holes need a motion"),
    ('by = "hole"\nmove = { 1 = [] }', r"The holes need a motion"),
    ('by = "hole"\nmove = { 1 = ["up"] }', r'\[move\]: there is no motion "up" of a hole'),
    ('by = "hole"\nmove = { first = ["x"] }', r'\[move\]: the keys are numbers of holes, .* not "first"'),
    ('by = "hole"\nholes = [1]\nmove = { 1 = ["x"] }', r"name the holes already"),
    ('by = "both"\nweight = 0', r"weight must be a positive number, .*, not 0"),
    ("max_steps = 0", r"limit of steps must be a whole number from 1 to 100,000"),
])  # fmt: skip
def test_what_is_wrong_with_the_table_is_named(tmp_path, table, message):
    with pytest.raises(JobError, match=message):
        load_job(job_file(tmp_path, f"[close]\n{table}\n"))


def test_what_cannot_be_closed_is_an_unusable_job(tmp_path):
    """Exit code 2, and nothing is solved for it."""
    disc = '[shape]\nkind = "disc"\nn = 60\n'
    for plan, close, message in (
        (COURT, '[close]\nby = "hole"\nholes = [3]\n', "The plan has 1 hole; there is no hole 3"),
        (COURT, '[close]\n[solver]\nsites = "faces"\n', "Closing needs normals on vertices"),
        (disc, "[fit]\nrise = 0.2\n[close]\n", "a fit closes its shell by itself"),
    ):
        path = job_file(tmp_path, close, plan)
        with pytest.raises(CmcError, match=message):
            load_job(path)
        assert main([str(path)]) == UNUSABLE

    assert main([str(job_file(tmp_path, '[close]\nby = "hole"\n', disc))]) == OK
    assert "closing" not in written(tmp_path), "nothing is open"
