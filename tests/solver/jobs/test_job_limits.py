"""Numbers and sizes out of range, and texts that cannot be read: a sentence, at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from solver.errors import CmcError, JobError
from solver.jobs.job import load_job, run_job
from tests.solver.job_files import job

FLOOR = '[[conditions]]\nside = "outer"\nkind = "plane"\n[complete]\nmesh = "a.obj"\n'
DISC = '[shape]\nkind = "disc"\nn = 40\n'
RECTANGLE = '[shape]\nkind = "rectangle"\nwidth = 1\n'

BEYOND = {
    "400 digits": ("[default]\ntilt = " + "9" * 400 + "\n" + DISC, '"tilt" must be .* number of about 401 digits'),
    "5000 digits": ("[default]\ntilt = " + "9" * 5000 + "\n" + DISC, "too many digits"),
    "5000 hexadecimal digits": ("[solver]\nside = 0x" + "f" * 5000 + "\n" + DISC, '"side" must be a whole number'),
    "nested lists": ("a = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
    "nested tables": ("a = " + "{a = " * 2000 + "1" + "}" * 2000, "nested too deeply"),
    "a dotted key": ("x = 1\n" + "a." * 20_000 + "a = 1", "line 2: a key of thirty names"),
    "a dotted header": ("[" + '"a".' * 20_000 + "a]\n", "line 1: a key of thirty names"),
    "a null character": (DISC + '[output]\nreport = "a\\u0000b"', '"report" contains a null character'),
    "a null character in a list": (DISC + '[close]\nby = "hole"\nmove = ["x\\u0000"]', '"move" contains a null'),
    "a null character in a curve": (DISC + '[fit]\noutline = "x\\u0000.obj"', '"outline" contains a null'),
    "many vertices": ('[shape]\nkind = "disc"\nn = 1_000_000_000', "from 7 to 1,000,000 vertices, not 1,000,000,000"),
    "more vertices": ('[shape]\nkind = "disc"\nn = 1' + "0" * 30, '"n" must be a whole number'),
    "many in a ring": ('[shape]\nkind = "annulus"\ninner = 1\nouter = 2\nn = 999_999_999', "from 18 to 1,000,000"),
    "many columns": (RECTANGLE + "height = 1\ncolumns = 1_000_000_000", "from 1 to 1,000,000 columns"),
    "many rows": (RECTANGLE + "height = 1e9\ncolumns = 1", "1,000,000 are the most"),
    "height": (RECTANGLE + "height = 1e300\ncolumns = 3", '"height" must be a positive number, .*, not 1e'),
    "radii": ('[shape]\nkind = "annulus"\ninner = 1e-300\nouter = 1\nn = 100', '"inner" must be .*, not 1e-300'),
    "an outline": ('[shape]\nkind = "polygon"\noutline = [[0, 0], [1e300, 0], [0, 1e300]]', 'numbers of "outline"'),
    "a long plan": (
        '[shape]\nkind = "polygon"\noutline = [[0, 0], [1e6, 0], [1e6, 1], [0, 1]]\nmax_edge = 0.5',
        "Points 0 and 3 .* within a millionth of the plan's size",
    ),
    "a narrow plan": (
        '[shape]\nkind = "polygon"\noutline = [[0, 0], [1e5, 0], [1e5, 1], [0, 1]]\nmax_edge = 30',
        "narrow places",
    ),
    "turns": (DISC + '[[conditions]]\nside = "outer"\nkind = "mirror"\nwinding = 1e300', '"winding" must be .* 1,000'),
    "twists": (DISC + '[[conditions]]\nside = "outer"\nkind = "twisted"\nm = 1e9', '"m" must be .* 1,000 in size'),
    "a degree": (DISC + "[solver]\ndegree = -1e300", '"degree" must be a number of at most 1,000 in size'),
    "a tolerance": (DISC + "[solver]\ntolerance = 1e300", '"tolerance" must be .* from 1e-15 to 1, not 1e.300'),
    "no tolerance": (DISC + "[solver]\ntolerance = 0", '"tolerance" must be .* from 1e-15 to 1, not 0'),
    "a span": (DISC + "[size]\nspan = 1e308", '"span" must be a positive number'),
    "a fit's height": (DISC + "[fit]\nheight = 1e-300", '"height" must be a positive number, from 1e-30'),
    "evaluations": (DISC + "[fit]\nmax_evaluations = 1" + "0" * 30, "from 1 to 100,000, not 1,000,000"),
    "a place": (DISC + "[[fit.anchors]]\nvertex = 0\nplace = [1e300, 0, 0]", 'numbers of "place" must be at most'),
    "a box": (
        DISC + FLOOR + 'box = [[-1e300, -1, -1], [1e300, 1, 1]]',
        'numbers of "box" must be at most',
    ),
    "copies": (DISC + FLOOR + "copies = 1_000_000", "from 1 to 20,000, not 1,000,000"),
    "units": (DISC + FLOOR + "repeat = [1, 0x" + "f" * 5000 + "]", "from 1 to 20,000"),
    "steps": (DISC + "[close]\nmax_steps = 1" + "0" * 12, '"max_steps" must be|limit of steps must be'),
    "vertices": (DISC + "[[conditions]]\nvertices = [1e30, 2]", "must be whole numbers of at most"),
    "flipped corners": (DISC + "[default]\nflipped_corners = [99999999999999999999]", '"flipped_corners" must'),
}


@pytest.mark.parametrize("name", BEYOND)
def test_what_is_out_of_range_is_named(tmp_path: Path, name: str):
    text, message = BEYOND[name]
    with pytest.raises(JobError, match=message):
        load_job(job(tmp_path, text))


FAR = {
    "a low fit": ("[fit]\nheight = 1e-12", "height 1e-12 does not go with an outline that measures 2.8"),
    "a flat fit": ("[fit]\nmean_curvature = 1e-15", "mean curvature 1e-15 does not go with an outline"),
    "a far anchor": ("[[fit.anchors]]\nvertex = 0\nplace = [1e9, 0, 0]", "100 times the plan's size"),
}


@pytest.mark.parametrize("name", FAR)
def test_a_fit_far_from_its_plan_is_refused(tmp_path: Path, name: str):
    text, message = FAR[name]
    with pytest.raises(CmcError, match=message):
        run_job(load_job(job(tmp_path, DISC + text)))


def test_a_corner_radius_of_nothing_leaves_the_corners(tmp_path: Path):
    square = '[shape]\nkind = "polygon"\noutline = [[0, 0], [1, 0], [1, 1], [0, 1]]\nmax_edge = 0.3\n'
    plans = [load_job(job(tmp_path, square + f"corner_radius = {radius}")).plan for radius in ("0", "1e-15")]
    assert np.array_equal(plans[0].positions, plans[1].positions)


BLAMED = [
    ("[default]\nblend = -1\n" + DISC, r"\[default\]: \"blend\" must be"),
    (DISC + "[solver]\nside = 2", r"\[solver\]: The side must be \+1 or -1"),
    ('mesh = ""', '"mesh" is empty; name a file'),
    ('mehs = "plan.obj"', 'unknown key "mehs"; did you mean "mesh"'),
    (DISC + '[[conditions]]\ngruop = "rim"', 'unknown key "gruop"; did you mean "group"'),
    ('[shape]\nknid = "disc"\nn = 40', 'unknown key "knid"; did you mean "kind"'),
    (
        '[shape]\nkind = "polygon"\noutline = [[0, 0], [1, 0], [0, 1]]\ncorners = "reentrant"',
        r'\[shape\]: There is no kind of corners to round "reentrant"; did you mean "re-entrant"',
    ),
    ('[shape]\nkind = "disc"\nm = 40', 'unknown key "m"; known are kind, scale, n'),
    (DISC + "[default]\nfliped_corners = [1]", 'unknown key "fliped_corners"; did you mean "flipped_corners"'),
]


@pytest.mark.parametrize(("text", "message"), BLAMED)
def test_the_table_and_the_key_are_named(tmp_path: Path, text: str, message: str):
    with pytest.raises(JobError, match=message):
        load_job(job(tmp_path, text))


OVERWRITTEN = [
    ('mesh = "plan.obj"\n[output]\nf_plus = "plan.obj"', '"f_plus" of .output. would overwrite "mesh"'),
    ('mesh = "plan.obj"\n[output]\nf_plus = "./sub/../plan.obj"', '"f_plus" of .output. would overwrite "mesh"'),
    ('mesh = "plan.obj"\n[output]\nf_plus = "PLAN.obj"', '"f_plus" of .output. would overwrite "mesh"'),
    ('mesh = "plan.obj"\n[output]\nf_plus = "link.obj"', '"f_plus" of .output. would overwrite "mesh"'),
    ('mesh = "plan.obj"\n[output]\nreport = "job.toml"', '"report" of .output. would overwrite the job itself'),
    ('mesh = "plan.obj"\n[output]\nreport = "plan.mtl"', "would overwrite a material file of the mesh"),
    ('mesh = "plan.obj"\n[output]\nf_plus = "a.obj"\ng = "sub/../a.obj"', '"f_plus" of .output. and "g" of .output.'),
    (
        'mesh = "plan.obj"\n[fit]\noutline = "curve.obj"\n[output]\nf_plus = "curve.obj"',
        'would overwrite "outline" of .fit.',
    ),
    (
        DISC + '[[conditions]]\nside = "outer"\nkind = "plane"\n[complete]\nmesh = "a.obj"\n[output]\nf_plus = "a.obj"',
        '"f_plus" of .output. and "mesh" of .complete. are one file',
    ),
    (
        DISC + '[[conditions]]\nside = "outer"\nkind = "plane"\n[complete]\ninstances = "a.json"\n'
        '[output]\nf_plus = "a_f_plus.obj"',
        '"f_plus" of .output. and a piece of "instances" are one file',
    ),
]


@pytest.mark.parametrize(("text", "message"), OVERWRITTEN)
def test_a_job_does_not_overwrite_what_it_reads_or_writes(folder: Path, text: str, message: str):
    plan = folder / "plan.obj"
    plan.write_text("mtllib plan.mtl\n" + plan.read_text())
    (folder / "link.obj").symlink_to(plan)
    (folder / "curve.obj").write_text("v 0 0 0\nv 6 0 0\nv 6 4 0\nv 0 4 0\nl 1 2 3 4 1\n")
    with pytest.raises(CmcError, match=message):
        load_job(job(folder, text))
