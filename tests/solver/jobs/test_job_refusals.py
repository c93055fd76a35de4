"""Job files that are refused: the message names the key, the entry and the way out."""

from __future__ import annotations

import json

import numpy as np
import pytest

from solver.errors import ConditionError, JobError, MeshError
from solver.io.mesh_files import write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import load_job, run_job
from solver.notes import notes_data
from tests.solver.job_files import PLAN, job


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
        (PLAN + "[size]\nspan = -3", r'\[size\]: "span" must be a positive number, from 1e-30 to 1e\+30, not -3'),
        (PLAN + "[size]\nspan = '3'", r'\[size\]: "span" must be a positive number, .*, not "3"'),
        (PLAN + "[size]\nground = 'rom'", r'there is no ground "rom"; did you mean "rim"\?'),
        (PLAN + "[size]\nflip = 1", r'"flip" must be true or false, not 1'),
        (PLAN + "[size]\nsheet = 'g'", r'there is no sheet "g"; known are f\+, f-'),
        (PLAN + "[solver]\nside = 1.5", r'\[solver\]: "side" must be a whole number of .*, not 1.5'),
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
        (PLAN + "[[conditions]]\nloop = 0\nkind = 'plain'", r'no kind "plain"; did you mean "plane" or "line"\?'),
        (PLAN + "[[conditions]]\nloop = 0\nm = 2", r'\[\[conditions\]\] 1: unknown key "m"; known are'),
        (
            PLAN + "[[conditions]]\nloop = 0\nkind = 'plane'\nnormal = [1, 0]",
            r'"normal" must be a list of 3 numbers',
        ),
        (PLAN + "[default]\nkind = 'fre'", r'\[default\]: there is no kind "fre"; did you mean "free"\?'),
        ("[shape]\nkind = 'dics'\nn = 50", r'\[shape\]: there is no shape "dics"; did you mean "disc"\?'),
        ("[shape]\nkind = 'disc'", r'a disc needs "n"'),
        ("[shape]\nkind = 'disc'\nn = 50\nradius = 2", r'\[shape\]: unknown key "radius"'),
        ("[shape]\nkind = 'disc'\nn = 50\nscale = 0", r'"scale" must be a positive number, .*, not 0'),
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
    assert json.loads((folder / "report.json").read_text())["warnings"] == notes_data(shell.warnings)


@pytest.mark.parametrize("tilt", ["0", "1", "1.0", "2.5", "-20"])
def test_plain_degrees_are_not(folder, tilt):
    assert not load_job(job(folder, DISC + f"[default]\ntilt = {tilt}\n")).warnings
