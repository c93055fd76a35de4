"""Job files with mutations: keys, types, values, lines and bytes; read, and run where that is not refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np

from solver import shapes
from solver.io.mesh_files import read_mesh, write_mesh
from solver.io.obj import MeshData
from solver.jobs.job import Job, load_job, run_job

from .case import Case, Result, of_shell, pick
from .files import flip

Rng = np.random.Generator

_RIM = '[[conditions]]\nloop = 0\nkind = "twisted"\nm = 1.0\n'
_EDGES = '[[conditions]]\nedges = [[0, 1], [1, 2]]\nkind = "plane"\nnormal = [1, 0, 1]\n'
_VERTICES = '[[conditions]]\nvertices = [0, 1, 2, 3]\nkind = "gauss_map"\n'
_OUTER = '[[conditions]]\nside = "outer"\nkind = "binormal"\ntilt = 25\n'
_GROUP = '[[conditions]]\ngroup = "rim"\ntilt = 40.5\n'
_MIRRORS = (
    '[[conditions]]\nside = "bottom"\nkind = "mirror"\nnormal = [0, -1, 0]\n'
    '[[conditions]]\nside = "left"\nkind = "mirror"\nnormal = [-1, 0, 0]\n[[conditions]]\nside = "top"\ntilt = 60\n'
)
_RECTANGLE = "outline = [[0, 0], [6, 0], [6, 4], [0, 4]]"
_PLANS = (
    ('[shape]\nkind = "disc"\nn = 90\nscale = 5.0\n', ("", _OUTER, _RIM, _EDGES, _VERTICES)),
    ('[shape]\nkind = "strip"\nwidth = 3.0\nheight = 2.0\ncolumns = 9\n', ("", _MIRRORS, _MIRRORS, _OUTER, _EDGES)),
    ('[shape]\nkind = "annulus"\ninner = 0.4\nouter = 1.0\nn = 120\n', ("", _OUTER, _RIM, _EDGES)),
    (f'[shape]\nkind = "polygon"\n{_RECTANGLE}\nmax_edge = 0.7\ncorner_radius = 1.0\n', ("", _OUTER, _EDGES)),
    (
        f'[shape]\nkind = "polygon"\n{_RECTANGLE}\nholes = [[[2, 1], [4, 1], [4, 2], [2, 2]]]\nmax_edge = 0.6\n',
        ("", _OUTER, _RIM, '[[conditions]]\nside = "hole0"\ntilt = 30\n'),
    ),
    ('mesh = "plan.obj"\n', ("", _GROUP, _GROUP, _RIM, _EDGES)),
    ('mesh = "plan.ply"\n', ("", _RIM, _VERTICES)),
)
"""Plans, and conditions that fit them."""

_REST = (
    '[default]\nkind = "binormal"\ntilt = 30\nblend = 0.5\n',
    '[size]\nspan = 12.0\nground = "rim"\nrotate = true\n',
    "[size]\nrise = 3.0\nflip = true\n",
    "[size]\nmean_curvature = 0.3\n",
    '[solver]\nsites = "faces"\nenergy = "mobius"\nmethod = "newton"\n',
    '[solver]\ndelaunay = true\naveraging = "area"\ntolerance = 1e-5\n',
    "[solver]\nside = -1\ncount_modes = true\n",
    '[solver]\nshell = "bubble"\n',
    "[solver]\ndegree = 1\n",
    "[fit]\noutline = true\nrise = 0.35\n",
    "[fit]\napproximate = true\nregularisation = 1e-3\nmax_evaluations = 5\n",
    "[fit]\noutline = false\nmax_evaluations = 5\n[[fit.anchors]]\nvertex = 1\nplace = [0.0, 0.0, 0.0]\n",
    '[close]\nby = "normals"\n',
    '[close]\nby = "hole"\n',
    '[complete]\nrepeat = [2, 2]\nmesh = "patch.obj"\ninstances = "patch.json"\n',
    "[complete]\ncopies = 2\n",
    '[output]\nf_minus = "shell.stl"\ng = "g.glb"\nreport = "report.json"\ncombinatorics = "dual"\n',
)
_OUTPUT = '[output]\nf_plus = "shell.obj"\nreport = "report.json"\n'
_TEXTS = (
    '""',
    '"\\u0000"',
    '"."',
    '"plan.obj"',
    '"job.toml"',
    '"sub/"',
    '"x.xyz"',
    '"naïve.obj"',
    f'"{"a" * 300}"',
    '"f-"',
    '"rim"',
)
_NUMBERS = (
    "nan", "inf", "-inf", "0", "-1", "1", "2", "0.5", "12", "30.5", "1e300", "-1e300", "1e-300", "9223372036854775807",
    "99999999999999999999", "9" * 5000, "180", "-90", "1e-12", "1e9", "1_000", "0x7f",
)  # fmt: skip
_LISTS = (
    "[]", "[[]]", "[1, 2]", "[1, 2, 3]", '["a"]', "[[0, 1]]", "[[0, 0], [1, 0], [1, 1]]", "[nan, 0, 0]", "[0, 0, 0]",
    "[1e300, 0, 0]", "[[[[]]]]", "[" * 300 + "]" * 300, '[{a = 1}]', "[0, 5, 9]", "[0, 99999]", "[-1, 0]",
)  # fmt: skip
_OTHERS = ("true", "false", "{}", "1979-05-27", "07:32:00", "{a = 1}", "")


def case(rng: np.random.Generator, folder: Path) -> Case:
    _write_plan(folder)
    plan, conditions = pick(rng, _PLANS)
    rest = {one.split("\n")[0]: one for one in [pick(rng, _REST) for _ in range(rng.integers(0, 3))]}
    fits = "[fit]" in rest and rng.random() < 0.9
    rest = {name: one for name, one in rest.items() if not fits or name in ("[fit]", "[output]")}
    text = "\n".join([plan, "" if fits else pick(rng, conditions), *({"[output]": _OUTPUT} | rest).values()])
    for _ in range(rng.integers(0, 3)):
        text = pick(rng, [value, value, value, key, line, other])(rng, text)
    data = text.encode("utf-8", "surrogatepass")
    data = flip(rng, data) if rng.random() < 0.1 else data
    file = folder / "job.toml"
    file.write_bytes(data)
    return Case(data.decode("utf-8", "replace"), lambda: _run(file))


def _write_plan(folder: Path) -> None:
    shape = shapes.disc(61)
    flat = np.column_stack([3.0 * shape.positions, np.zeros(61)])
    faces = list(shape.domain.faces)
    rim = shape.domain.edges[shape.domain.boundary_edges].astype(np.int32)
    mesh = MeshData(flat, faces, uvs=shape.positions, uv_corners=faces, edge_groups={"rim": rim})
    for suffix in (".obj", ".ply"):
        write_mesh(folder / f"plan{suffix}", mesh)


def _run(file: Path) -> Result:
    """Load, run, and read what was written: JSON without NaN, meshes that can be read."""
    job = load_job(file)
    _stay_in(job, file.parent)
    shell = run_job(job)
    for path in job.files.values():
        if path.suffix.lower() in (".obj", ".ply", ".stl", ".glb"):
            read_mesh(path)
        else:
            json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    return of_shell(shell)


def _stay_in(job: Job, folder: Path) -> None:
    """Flipped bits make other paths; nothing is written outside of the case's folder."""
    job.outputs = {name: path for name, path in job.outputs.items() if path.is_relative_to(folder)}
    if job.complete is not None and not all(path.is_relative_to(folder) for path in job.complete.files.values()):
        job.complete = None


def _refuse(constant: str) -> None:
    raise AssertionError(f"{constant} in a JSON file")


def value(rng: Rng, text: str) -> str:
    """Another value of a key, of its type as a rule."""
    found = list(re.finditer(r"(?m)^(\w+ = )(.*)$", text))
    if not found:
        return text
    one = pick(rng, found)
    alike = _TEXTS if one[2].startswith('"') else _LISTS if one[2].startswith("[") else _NUMBERS
    new = pick(rng, alike if rng.random() < 0.75 else _TEXTS + _NUMBERS + _LISTS + _OTHERS)
    return text[: one.start(2)] + new + text[one.end(2) :]


def key(rng: Rng, text: str) -> str:
    """A key or a table misspelt, or under another one's name."""
    found = list(re.finditer(r"(?m)^\[*(\w+)", text))
    if not found:
        return text
    one = pick(rng, found)
    name = pick(rng, [one[1][:-1] or "x", one[1] + "s", one[1].upper(), pick(rng, found)[1], "", '"a b"', "a.b.c"])
    return text[: one.start(1)] + name + text[one.end(1) :]


def line(rng: Rng, text: str) -> str:
    """A line left out, doubled, or somewhere else."""
    lines = text.split("\n")
    one = lines.pop(int(rng.integers(len(lines))))
    for _ in range(rng.integers(0, 3)):
        lines.insert(int(rng.integers(len(lines) + 1)), one)
    return "\n".join(lines)


def other(rng: Rng, text: str) -> str:
    """Characters that do not belong, or the end missing."""
    a = int(rng.integers(len(text) + 1))
    stray = pick(rng, ["\0", '"', "[", "]", "=", "\\", "é", "\r", "#", "'''"])
    return pick(rng, [text[:a], text[:a] + stray + text[a:], "\ufeff" + text])
