"""A job file: a plan, conditions on its boundary, a size, and the files to write (TOML, see `EXAMPLE`).

Lengths are in the units of the mesh, angles in degrees, paths relative to the job file.
"""

from __future__ import annotations

import os
import re
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import CmcError, JobError, MeshError, Progress
from ..gauss.conditions import KINDS, Parameter
from ..io.mesh_files import FORMATS, read_mesh
from ..io.obj import MeshData, decoded
from ..notes import Note
from ..shells.close import closing_report
from ..shells.complete import Completed, complete_plan
from ..shells.fit import FitOptions, fit_plan
from ..shells.form import check_plan, form
from ..shells.mixed import sides_report
from ..shells.numbering import drawn_numbers
from ..shells.plan import Group, Plan, Settings, plan_domain
from ..shells.rim_curves import read_curves
from ..shells.shell import Shell
from ..shells.span import span_report
from ..surface.cmc_surface import COMBINATORICS, SHEETS
from .close_table import read_close
from .complete_table import CompleteOptions, read_complete
from .fit_table import read_fit
from .job_files import write_job
from .job_paths import check_paths, named_inputs
from .outputs import SHEET_KEYS, completed_report, piece_file
from .selection import Pairs, select
from .settings_table import read_settings
from .shape_table import MadePlan, read_shape
from .start_table import read_start_key
from .tables import Table

EXAMPLE = """\
mesh = "plan.obj"        # OBJ, PLY, STL or GLB; or a [shape] with kind = "disc", n = 2000

[[conditions]]           # edges without a condition get kind = "binormal", tilt = 0, or the one of [default]
group = "supports"       # a polyline group of the OBJ, or the rim of the faces in a group or material;
                         # or loop = 0, side = "top" (of a shape), edges = [[0, 1]], vertices = [0, 1, 2]
kind = "binormal"        # or "line" (the rim lies on these edges, or on curve = "curve.obj"), "lean" (angle), "plane",
                         # "mirror" (normal), "twisted" (m), "gauss_map", "free"
tilt = 20                # degrees: 0 is a vertical rim, 90 flat

[size]                   # without it, the size that fits the drawn outline best
span = 12.0              # or height, rise, radius (1/H), mean_curvature; on lines rise, height, volume, curvature
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


@dataclass(eq=False, repr=False)
class Job:
    """A job file, read and checked: a plan, its settings, and the files to write.

    mesh: the drawn mesh, with its UVs, groups and materials. outputs: sheet ("f+", "f-", "g", "gauss") or "report" →
    file. up: the up axis of the mesh files, None for each format's own. fit, complete: the options of these tables,
    None without the table. warnings: likely mistakes in the file; they join the shell's. data: the tables as written.
    """

    path: Path
    plan: Plan
    settings: Settings
    mesh: MeshData
    outputs: dict[str, Path]
    up: str | None = None
    fit: FitOptions | None = None
    complete: CompleteOptions | None = None
    warnings: list[Note] = field(default_factory=list)
    data: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        tables = "".join(f", [{name}]" for name in ("fit", "complete") if getattr(self, name) is not None)
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
    root.finish(_KEYS)
    made, up = _read_plan(root, file.parent)
    plan, mesh = made.plan(), made.mesh
    if "start" in root:
        read_start_key(root, plan, mesh, file.parent)
    domain = plan_domain(plan)
    fit = read_fit(root, domain, mesh, file.parent, up) if "fit" in root else None
    groups = [_group(table, domain, mesh, made.sides, file.parent, up) for table in root.tables("conditions")]
    plan.groups = groups if fit is not None else made.groups_beside(groups)
    plan.flipped_corners = _flipped_corners(root.table("default"), mesh)
    output = root.table("output")
    settings = read_settings(root, output.text("combinatorics", "primal", among=list(COMBINATORICS)), made.settings)
    outputs = _outputs(output, file.parent)
    complete = read_complete(root, plan.groups, file.parent) if "complete" in root else None
    if "close" in root:
        settings = replace(settings, close=read_close(root))
    job = Job(file, plan, settings, mesh, outputs, up, fit, complete, [*mesh.notes, *root.notes], data)
    check_paths(file, _reads(root, mesh, file.parent), _writes(job))
    with drawn_numbers(plan):
        if fit is None:
            check_plan(plan, settings, domain)
    return job


def run_job(job: Job, progress: Progress | None = None) -> Shell:
    """Solve or fit the shell of a job, and write its files; raises `CmcError` where that fails."""
    started = time.time()
    shell, more = _shell(job, progress)
    completed, failure = _completed(job, shell)
    if completed is not None:
        more["completed"] = completed_report(completed)
    written = write_job(job, shell, job.plan, completed, more, started)
    failure = failure or next(iter(written), None)
    if failure is not None:
        raise failure
    return shell


def _shell(job: Job, progress: Progress | None) -> tuple[Shell, dict[str, Any]]:
    """The shell, and further tables of the report."""
    plan, more = job.plan, {}
    if job.fit is not None:
        shell = fit_plan(plan, job.fit, progress=progress)
    else:
        shell = form(plan, job.settings, progress=progress)
    if shell.closing is not None:
        more["closing"] = closing_report(shell.closing)
    if shell.fit is not None and shell.fit.sides and job.fit is None:
        more["sides"] = sides_report(plan.groups, shell.fit)
    if shell.span is not None:
        more["span"] = span_report(shell.span)
    if len(shell.surface.periods):
        more["holes"] = [gap.to_dict() for gap in shell.gaps]
    return replace(shell, warnings=[*job.warnings, *shell.warnings]), more


def _completed(job: Job, shell: Shell) -> tuple[Completed | None, CmcError | None]:
    """The completed shell of a [complete], welded; or the error to raise once the shell itself is written."""
    if job.complete is None:
        return None, None
    try:
        completed = complete_plan(job.plan, shell, job.complete.copies, job.settings.sheet)
        len(completed.points)  # welds
    except CmcError as error:
        return None, error
    return completed, None


_KEYS = (
    "mesh", "up", "shape", "start", "conditions", "default", "size", "solver", "output", "fit", "close", "complete",
)  # fmt: skip
# Thirty names in a row joined by dots: the time that TOML takes for a key grows with the cube of their number.
_DOTTED = re.compile(r"""(?<![\w"'-])(?:(?:"[^"\n]*"|'[^'\n]*'|[\w-]++)[ \t]*+\.[ \t]*+){30}""")


# What often stands in a line that is not TOML, and what to write in its place.
_HINTS = (
    (r"[“”„‘’«»]", "write straight quotes"),
    (r'= *"[^"\n]*\\', 'write paths with "/", or in single quotes'),
    (r"= *-?\d+,\d", "write numbers with a point, and without separators"),
)


def _hint(error: Exception, text: str) -> str:
    """"; …" what to write in a line that is not valid, where that can be guessed."""
    place = re.search(r"at line (\d+)", str(error))
    line = text.split("\n")[int(place[1]) - 1] if place else ""
    return next((f"; {hint}" for pattern, hint in _HINTS if re.search(pattern, line)), "")


def _parse(file: Path) -> dict[str, object]:
    text = ""
    if file.suffix.lower() in FORMATS:
        raise JobError(f'{file} is a mesh, not a job; write a job that names it, mesh = "{file.name}".')
    try:
        text = decoded(file.read_bytes())
        if deep := _DOTTED.search(text):
            line = text.count("\n", 0, deep.start()) + 1
            raise JobError(f"{file}, line {line}: a key of thirty names or more; shorten it.")
        return tomllib.loads(text)
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    except tomllib.TOMLDecodeError as error:
        raise JobError(f"{file} is not valid TOML: {error}{_hint(error, text)}.") from error
    except (RecursionError, ValueError) as error:
        why = "it is nested too deeply" if isinstance(error, RecursionError) else "a number in it has too many digits"
        raise JobError(f"{file} cannot be read: {why}.") from error


def _read_plan(root: Table, folder: Path) -> tuple[MadePlan, str | None]:
    """The plan of a mesh file or a shape, and the up axis of files."""
    up = root.text("up", among=("y", "z")) or None
    if ("mesh" in root) == ("shape" in root):
        raise root.fail('a job needs either mesh = "file" or a [shape].')
    if "shape" in root:
        return read_shape(root), up
    name = root.text("mesh")
    if not name.strip():
        raise root.fail(f'"mesh" is empty; name a file ({", ".join(FORMATS)}).')
    return MadePlan(read_mesh(folder / name, up=up)), up


def _reads(root: Table, mesh: MeshData, folder: Path) -> list[tuple[str, Path]]:
    """The files that a job reads, by what messages call them."""
    files = [(what, folder / path) for what, path in named_inputs(root.data).items()]
    return files + [("a material file of the mesh", library) for library in mesh.libraries]


def _writes(job: Job) -> list[tuple[str, Path]]:
    """The files that a job writes, by what messages call them."""
    keys = {sheet: key for key, sheet in SHEET_KEYS.items()}
    files = [(f'"{keys.get(name, name)}" of [output]', file) for name, file in job.outputs.items()]
    if job.complete is None:
        return files
    files += [(f'"{key}" of [complete]', file) for key, file in job.complete.named.items()]
    if (instances := job.complete.instances) is not None:
        files += [('a piece of "instances"', piece_file(instances, sheet)) for sheet in SHEETS]
    return files


def _flipped_corners(default: Table, mesh: MeshData) -> list[int]:
    try:
        return mesh.from_file(default.integers("flipped_corners")).tolist()
    except MeshError as error:
        raise default.fail(f'"flipped_corners": {error}') from error


def _group(
    table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs], folder: Path, up: str | None
) -> Group:
    name, edges = select(table, domain, mesh, sides)
    kind = table.text("kind", "binormal", among=list(KINDS))
    parameters: dict[str, object] = {p.name: _parameter(table, p) for p in KINDS[kind].parameters if p.name in table}
    table.known.extend(p.name for p in KINDS[kind].parameters)
    if KINDS[kind].curve and (curve := table.text("curve")):
        parameters["curve"] = _curve(table, folder / curve, up)
    table.finish()
    return Group(name, edges, kind, parameters)


def _curve(table: Table, file: Path, up: str | None) -> NDArray[np.float64]:
    curves = read_curves(file, up)
    if len(curves) != 1:
        raise table.fail(f"{file.name} has {len(curves)} closed polylines; a side lies on one, so give one a file.")
    return curves[0]


def _parameter(table: Table, parameter: Parameter) -> float | tuple[float, ...]:
    if isinstance(parameter.default, tuple):
        return table.vector(parameter.name, parameter.default)
    value = table.number(parameter.name, parameter.default, parameter.within)
    return table.radians(parameter.name, value) if parameter.unit == "radians" else value


def _outputs(table: Table, folder: Path) -> dict[str, Path]:
    outputs = {}
    for key, name in {**SHEET_KEYS, "report": "report"}.items():
        value = table.text(key)
        if key in table:
            outputs[name] = Path(os.path.normpath(folder / value))
            suffix = outputs[name].suffix.lower()
            if name != "report" and suffix not in FORMATS:
                raise table.fail(f'"{key}" has no format known here ("{suffix}"); use one of {", ".join(FORMATS)}.')
            if name == "report" and suffix in FORMATS:
                raise table.fail(f'"report" is a file of JSON, not of meshes ("{suffix}"); call it report.json.')
    table.finish()
    return outputs
