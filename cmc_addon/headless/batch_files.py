"""The inputs of a run without a window: opening them, and making plans of mesh files and jobs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ...solver.errors import JobError
from ...solver.fitting.goals import OutlineOptions
from ...solver.io.mesh_files import FORMATS
from ...solver.jobs.job import Job, load_job, make_job
from ...solver.jobs.job_files import job_inputs
from ...solver.jobs.provenance import hash_of
from ...solver.shells.closing_options import ClosingOptions
from ...solver.shells.plan import Group, Settings, plan_domain
from ..bridges.corner_bridge import flip
from ..bridges.import_bridge import import_plan
from ..bridges.start_bridge import write_start
from ..properties.settings import SIDES, SIZE_PROPERTY
from ..properties.stored import ROLES
from .exporters import call
from .ranges import check_range

INPUTS = (".blend", ".toml", *FORMATS)


def open_input(path: Path, conditions: Sequence[Mapping[str, object]] = (), up: str | None = None) -> Job | None:
    """Make the file the scene: open a .blend, or import a mesh or a job, which is returned, into an empty scene.

    conditions: for a mesh file, tables as in a job file; up: its up axis. Raises `CmcError` if the file cannot be
    read.
    """
    suffix = path.suffix.lower()
    if suffix not in INPUTS:
        raise JobError(f'{path} has no format known here ("{suffix}"); use one of {", ".join(INPUTS)}.')
    if "\0" in str(path) or not path.is_file():
        raise JobError(f"There is no file {path}.")
    if suffix == ".blend":
        call(bpy.ops.wm.open_mainfile, f"{path} cannot be opened", filepath=str(path), load_ui=False)
        return None
    job = load_job(path) if suffix == ".toml" else _mesh_job(path, conditions, up)
    if isinstance(job.fit, OutlineOptions):
        raise JobError(
            f'{path}: [fit] to an outline is for python -m solver; in Blender give the sides kind = "line" and a size '
            "in [size] in its place."
        )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
    plan = import_plan(bpy.context, path.stem, job.mesh, _all_groups(job))
    for vertex in job.plan.flipped_corners:
        flip(plan.data, vertex)
    write_start(plan.data, job.plan)
    for name, value in _object_settings(job.settings).items():
        check_range(plan.cmc.bl_rna.properties[name], value)
        setattr(plan.cmc, name, value)
    return job


def input_hashes(path: Path, job: Job | None) -> dict[str, str]:
    """Name → hash of the open file and of all that it reads: meshes of a job, libraries of a .blend."""
    if job is not None:
        return {path.name: hash_of(path), **job_inputs(job)}
    libraries = [Path(bpy.path.abspath(library.filepath)) for library in bpy.data.libraries]
    return {file.name: hash_of(file) for file in (path, *libraries) if file.is_file()}


def _mesh_job(path: Path, conditions: Sequence[Mapping[str, object]], up: str | None) -> Job:
    tables: dict[str, object] = {"mesh": path.name, "conditions": [dict(table) for table in conditions], "close": {}}
    if up:
        tables["up"] = up
    return make_job(tables, path)


def _all_groups(job: Job) -> list[Group]:
    """The job's groups, then the mesh's other groups, then the other edges if the job's default is not Blender's."""
    domain, settings = plan_domain(job.plan), job.settings
    default = {"tilt": settings.default_tilt} if settings.default_kind == "binormal" else {}
    free = {tuple(sorted(pair)): pair for pair in domain.edges[domain.boundary_edges].tolist()}

    def take(name: str, pairs: Iterable[Sequence[int]]) -> Group:
        keys = dict.fromkeys(tuple(sorted(pair)) for pair in pairs)
        edges = [free.pop(key) for key in keys if key in free]
        return Group(name, np.array(edges, dtype=np.int32).reshape(-1, 2), settings.default_kind, default)

    groups = [
        replace(group, name=short_name(group.name), edges=take(group.name, group.edges.tolist()).edges)
        for group in job.plan.groups
    ]
    groups += [take(name, pairs.tolist()) for name, pairs in job.mesh.edge_groups.items()]
    if settings.default_kind != "line" and (settings.default_kind, settings.default_tilt) != ("binormal", 0.0):
        groups.append(take("Rest", list(free)))
    return [group for group in groups if len(group.edges)]


def short_name(name: str) -> str:
    """The name in Blender's list: "group platform" becomes "platform"."""
    return name.removeprefix("group ").removeprefix("side ")


def _object_settings(settings: Settings) -> dict[str, object]:
    """A job's settings as properties of a plan object."""
    roles = {sheet: role for role, sheet in ROLES.items()}
    values: dict[str, object] = {
        "shell": "DEGREE" if settings.degree is not None else {"first": "FIRST", "bubble": "BUBBLE"}[settings.shell],
        "side": {number: name for name, number in SIDES.items()}[settings.side],
        "size": settings.size.upper(),
        "default_kind": "LINE" if settings.default_kind == "line" else "BINORMAL",
        "holes": settings.holes.upper(),
        "corners": settings.corners.upper(),
        **_closing(settings.close),
        "blend": settings.blend,
        "against": settings.against.upper(),
        "ground": settings.ground.upper(),
        "sheet": roles[settings.sheet],
        "sites": settings.sites.upper(),
        "energy": settings.solver_choice[1].upper(),
        "method": settings.method.upper(),
        "delaunay": settings.delaunay,
        "combinatorics": settings.combinatorics.upper(),
        "averaging": settings.averaging.upper(),
        "flip": settings.flip,
        "rotate": settings.rotate,
        "tolerance": settings.tolerance,
        "count_modes": settings.count_modes,
    }
    if settings.degree is not None:
        values["degree"] = settings.degree
    value_name = SIZE_PROPERTY[settings.size.upper()]
    return values | ({value_name: settings.value} if value_name else {})


def _closing(options: ClosingOptions | None) -> dict[str, object]:
    """How a job keeps its shell closed. Raises `JobError` on what is chosen for each hole, since they move alike here.
    """
    if options is None:
        return {"keep_closed": False}
    usual = ClosingOptions(options.by, options.weight)
    if isinstance(options.move, Mapping) or options.holes is not None or options.max_steps != usual.max_steps:
        raise JobError(
            'In Blender all holes of a plan move alike; take "holes", "max_steps" and motions of single holes out of '
            "[close], or run the job with python -m solver."
        )
    return {
        "keep_closed": True,
        "close_by": options.by.upper(),
        "close_weight": options.weight,
        "close_shift": "x" in options.move,
        "close_twist": "twist" in options.move,
        "close_size": "size" in options.move,
    }
