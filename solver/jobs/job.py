"""A job file: a plan, conditions on its boundary, a size, and the files to write (TOML, see `EXAMPLE`).

Lengths are in the units of the mesh, angles in degrees, paths relative to the job file.
"""

from __future__ import annotations

import inspect
import os
import time
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..catalogue import shapes
from ..domain.domain import Domain
from ..domain.sites import SITES
from ..errors import CmcError, ConditionError, JobError, MeshError, Progress
from ..gauss.conditions import KINDS, Parameter
from ..gauss.energies import ENERGIES, energy_on
from ..gauss.methods import METHODS
from ..io.mesh_files import FORMATS, read_mesh
from ..io.obj import MeshData, decoded
from ..shells.close import ClosingOptions, close_plan, closing_report
from ..shells.complete import Completed, complete_plan
from ..shells.fit import FitOptions, fit_plan
from ..shells.form import form
from ..shells.gaps import hole_gaps
from ..shells.numbering import drawn_numbers
from ..shells.plan import SHELLS, Group, Plan, Settings, plan_domain, usual_sheet
from ..shells.plan_conditions import plan_conditions
from ..shells.shell import Shell
from ..surface.averaging import AVERAGINGS
from ..surface.cmc_surface import COMBINATORICS, SHEETS
from ..surface.placement import GROUNDS, SIZES
from .close_table import read_close
from .complete_table import CompleteOptions, read_complete
from .fit_table import read_fit
from .job_files import write_job
from .outputs import SHEET_KEYS, completed_report
from .selection import Pairs, select
from .start_table import read_start_key
from .tables import Table, suggestion

EXAMPLE = """\
mesh = "plan.obj"        # OBJ, PLY, STL or GLB; or a [shape] with kind = "disc", n = 2000

[[conditions]]           # edges without a condition get kind = "binormal", tilt = 0, or the one of [default]
group = "supports"       # a polyline group of the OBJ, or the rim of the faces in a group or material;
                         # or loop = 0, side = "top" (of a shape), edges = [[0, 1]], vertices = [0, 1, 2]
kind = "binormal"        # or "plane", "mirror" (normal), "twisted" (m), "gauss_map", "free"
tilt = 20                # degrees: 0 is a vertical rim, 90 flat

[size]                   # without it, the size that fits the drawn outline best
span = 12.0              # or rise, radius (1/H), mean_curvature
ground = "lowest"        # or "rim"; also rotate, flip = true, sheet = "f-"

# [fit]                  # in place of conditions and a size: the shell whose rim lies on the outline
# outline = true         # or a closed polyline, "curve.obj"; or approximate = true: the shell nearest to the mesh
# rise = 0.35            # or height, volume, mean_curvature

# [close]                # over a plan with holes: the shell that closes around them
# by = "normals"         # or "tilts", "hole", "both"

# [complete]             # the shell and its copies across the conditions of kind "mirror" and "plane"
# repeat = [3, 3]        # or copies, box, around
# mesh = "patch.obj"     # or instances = "patch.json"

[output]
f_plus = "shell.obj"     # also f_minus, g, gauss; .obj keeps polygons, UVs and materials
                         # combinatorics = "dual" or "corner": other polygons than the plan's
report = "report.json"
"""

SHAPES: dict[str, Callable[..., shapes.Shape]] = {
    "disc": shapes.disc,
    "polygon": shapes.polygon,
    "rectangle": shapes.rectangle,
    "strip": shapes.strip,
    "annulus": shapes.annulus,
}


@dataclass(eq=False, repr=False)
class Job:
    """A job file, read and checked: a plan, its settings, and the files to write.

    mesh: the drawn mesh, with its UVs, groups and materials. outputs: sheet ("f+", "f-", "g", "gauss") or "report" →
    file. up: the up axis of the mesh files, None for each format's own. fit, close, complete: the options of these
    tables, None without the table. warnings: likely mistakes in the file; they join the shell's. data: the tables as
    written.
    """

    path: Path
    plan: Plan
    settings: Settings
    mesh: MeshData
    outputs: dict[str, Path]
    up: str | None = None
    fit: FitOptions | None = None
    close: ClosingOptions | None = None
    complete: CompleteOptions | None = None
    warnings: list[str] = field(default_factory=list)
    data: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        tables = "".join(f", [{name}]" for name in ("fit", "close", "complete") if getattr(self, name) is not None)
        return f"Job({self.path.name}: {self.plan!r}, {self.settings!r}{tables})"

    @property
    def files(self) -> dict[str, Path]:
        """Name of a result → the file it is written to."""
        return self.outputs | ({} if self.complete is None else self.complete.files)


def load_job(path: str | os.PathLike[str]) -> Job:
    """Read a job file and its mesh, and check that they make a plan with conditions.

    Raises `CmcError` that names the mistake and its place: `JobError` in the job, `MeshError` and `ConditionError` in
    the mesh.
    """
    file = Path(path)
    return make_job(_parse(file), file)


def make_job(data: Mapping[str, object], file: Path) -> Job:
    """A job from the tables of a job file at `file`, which need not exist; raises as `load_job`."""
    root = Table(dict(data), str(file))
    mesh, sides, up = _read_plan(root, file.parent)
    plan = Plan.from_mesh(mesh)
    if "start" in root:
        read_start_key(root, plan, mesh, file.parent)
    domain = plan_domain(plan)
    fit = read_fit(root, domain, mesh, file.parent, up) if "fit" in root else None
    plan.groups = [_group(table, domain, mesh, sides) for table in root.tables("conditions")]
    plan.flipped_corners = _flipped_corners(root.table("default"), mesh)
    output = root.table("output")
    settings = _settings(root, output.text("combinatorics", "primal", among=list(COMBINATORICS)))
    outputs = _outputs(output, file.parent)
    complete = read_complete(root, plan.groups, file.parent) if "complete" in root else None
    close = read_close(root) if "close" in root else None
    root.known += ["fit", "close", "complete", "start"]
    root.finish()
    if fit is None:
        with drawn_numbers(plan):
            plan_conditions(plan, settings, domain)
    return Job(file, plan, settings, mesh, outputs, up, fit, close, complete, [*mesh.notes, *root.notes], data)


def run_job(job: Job, progress: Progress | None = None) -> Shell:
    """Solve, close or fit the shell of a job, and write its files; raises `CmcError` where that fails."""
    started = time.time()
    shell, plan, more = _shell(job, progress)
    completed, failure = _completed(job, plan, shell)
    if completed is not None:
        more["completed"] = completed_report(completed)
    written = write_job(job, shell, plan, completed, more, started)
    failure = failure or next(iter(written), None)
    if failure is not None:
        raise failure
    return shell


def _shell(job: Job, progress: Progress | None) -> tuple[Shell, Plan, dict[str, Any]]:
    """The shell, its plan, whose holes may have moved, and further tables of the report."""
    plan, more = job.plan, {}
    if job.fit is not None:
        shell = fit_plan(plan, job.fit, progress=progress)
    elif job.close is not None:
        closed = close_plan(plan, job.settings, job.close, progress=progress)
        shell, plan = closed.shell, closed.plan
        more["closing"] = closing_report(closed)
    else:
        shell = form(plan, job.settings, progress=progress)
    if len(shell.surface.periods):
        more["holes"] = [gap.to_dict() for gap in hole_gaps(shell)]
    return replace(shell, warnings=[*job.warnings, *shell.warnings]), plan, more


def _completed(job: Job, plan: Plan, shell: Shell) -> tuple[Completed | None, CmcError | None]:
    """The completed shell of a [complete], welded; or the error to raise once the shell itself is written."""
    if job.complete is None:
        return None, None
    try:
        completed = complete_plan(plan, shell, job.complete.copies, job.settings.sheet)
        len(completed.points)  # welds
    except CmcError as error:
        return None, error
    return completed, None


def _parse(file: Path) -> dict[str, object]:
    try:
        return tomllib.loads(decoded(file.read_bytes()))
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    except tomllib.TOMLDecodeError as error:
        raise JobError(f"{file} is not valid TOML: {error}.") from error


def _read_plan(root: Table, folder: Path) -> tuple[MeshData, dict[str, Pairs], str | None]:
    """The mesh, the named sides of a shape, and the up axis of files."""
    up = root.text("up", among=("y", "z")) or None
    name, shape = root.text("mesh"), root.table("shape")
    if ("mesh" in root) == ("shape" in root):
        raise root.fail('a job needs either mesh = "file" or a [shape].')
    if name:
        return read_mesh(folder / name, up=up), {}, up
    made, scale = _make_shape(shape)
    flat = scale * made.positions
    positions = np.column_stack([flat, np.zeros(len(flat))])
    faces = list(made.domain.faces)
    sides: dict[str, Pairs] = {side: made.domain.edges[edges] for side, edges in made.sides.items()}
    return MeshData(positions, faces, uvs=flat, uv_corners=faces), sides, up


def _make_shape(table: Table) -> tuple[shapes.Shape, float]:
    """The shape of a [shape] table: `kind`, the arguments of that function in `shapes`, and a `scale`."""
    make = SHAPES.get(table.text("kind"))
    if make is None:
        name = table.text("kind")
        raise table.fail(f'there is no shape "{name}"{suggestion(name, SHAPES)}')
    scale = table.number("scale", 1.0)
    if not scale > 0:
        raise table.fail(f'"scale" must be positive, not {scale}.')
    arguments = {}
    for name, parameter in inspect.signature(make).parameters.items():
        if name in table:
            arguments[name] = _SHAPE_VALUES.get(name, Table.number)(table, name)
        elif parameter.default is inspect.Parameter.empty:
            raise table.fail(f'a {table.text("kind")} needs "{name}".')
        table.known.append(name)
    table.finish()
    try:
        return make(**arguments), scale
    except CmcError as error:
        raise table.fail(str(error)) from error


def _holes(table: Table, key: str) -> list[np.ndarray]:
    holes = table.data[key]
    if not isinstance(holes, list):
        raise table.fail(f'"{key}" must be a list of outlines.')
    return [Table({key: hole}, table.where).rows(key, 2, "points, [[0, 0], [1, 0]]") for hole in holes]


_SHAPE_VALUES: dict[str, Callable[[Table, str], object]] = {
    "n": Table.integer,
    "columns": Table.integer,
    "outline": lambda table, key: table.rows(key, 2, "points, [[0, 0], [1, 0]]"),
    "holes": _holes,
}


def _flipped_corners(default: Table, mesh: MeshData) -> list[int]:
    try:
        return mesh.from_file(default.integers("flipped_corners")).tolist()
    except MeshError as error:
        raise default.fail(f'"flipped_corners": {error}') from error


def _group(table: Table, domain: Domain, mesh: MeshData, sides: dict[str, Pairs]) -> Group:
    name, edges = select(table, domain, mesh, sides)
    kind = table.text("kind", "binormal", among=list(KINDS))
    parameters = {p.name: _parameter(table, p) for p in KINDS[kind].parameters if p.name in table}
    table.known.extend(p.name for p in KINDS[kind].parameters)
    table.finish()
    return Group(name, edges, kind, parameters)


def _parameter(table: Table, parameter: Parameter) -> float | tuple[float, ...]:
    if isinstance(parameter.default, tuple):
        return table.vector(parameter.name, parameter.default)
    value = table.number(parameter.name, parameter.default)
    return table.radians(parameter.name, value) if parameter.unit == "radians" else value


def _settings(root: Table, combinatorics: str) -> Settings:
    default, size, solver = root.table("default"), root.table("size"), root.table("solver")
    values: dict[str, object] = {"combinatorics": combinatorics}
    values["default_kind"] = default.text("kind", "binormal", among=list(KINDS))
    values["default_tilt"] = default.angle("tilt")
    values["blend"] = default.number("blend")
    default.known.append("flipped_corners")
    default.finish()
    chosen = [name for name in SIZES if name in size and name != "match_plan"]
    if len(chosen) > 1:
        raise size.fail(f"give one size, not {' and '.join(chosen)}.")
    for name in SIZES:
        if name != "match_plan":
            value = size.number(name, 1.0)
            if name in chosen:
                values |= {"size": name, "value": value}
    values["ground"] = size.text("ground", "lowest", among=list(GROUNDS))
    values |= _solver_settings(solver)
    values["sheet"] = size.text("sheet", usual_sheet(str(values.get("shell"))), among=SHEETS)
    values |= {name: size.flag(name) for name in ("rotate", "flip")}
    size.finish()
    try:
        return Settings(**values)  # type: ignore[arg-type]
    except CmcError as error:
        raise size.fail(str(error)) from error


def _solver_settings(table: Table) -> dict[str, object]:
    readers: dict[str, Callable[[Table, str], object]] = {
        "sites": partial(Table.text, among=list(SITES)),
        "energy": partial(Table.text, among=list(ENERGIES)),
        "method": partial(Table.text, among=list(METHODS)),
        "delaunay": Table.flag,
        "averaging": partial(Table.text, among=list(AVERAGINGS)),
        "tolerance": Table.number,
        "period_tolerance": Table.number,
        "side": Table.integer,
        "degree": Table.number,
        "shell": partial(Table.text, among=list(SHELLS)),
        "count_modes": Table.flag,
    }
    assert set(readers) <= {option.name for option in fields(Settings)}
    values = {name: read(table, name) for name, read in readers.items() if name in table}
    table.known.extend(readers)
    table.finish()
    if "degree" in values and values.get("shell", "first") != "first":
        raise table.fail('"degree" already chooses the shell; leave it out, or "shell".')
    try:
        energy_on(str(values.get("energy", "cotan")), str(values.get("sites", "vertices")))
    except ConditionError as error:
        raise table.fail(f'"energy" and "sites" do not fit: {error}') from error
    return values


def _outputs(table: Table, folder: Path) -> dict[str, Path]:
    outputs = {}
    for key, name in {**SHEET_KEYS, "report": "report"}.items():
        value = table.text(key)
        if key in table:
            outputs[name] = Path(os.path.normpath(folder / value))
            suffix = outputs[name].suffix.lower()
            if name != "report" and suffix not in FORMATS:
                raise table.fail(f'"{key}" has no format known here ("{suffix}"); use one of {", ".join(FORMATS)}.')
    table.finish()
    return outputs
