"""The files of a run without a window: opening inputs and writing outputs."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import addon_utils
import bpy
import numpy as np

from ...solver.errors import JobError
from ...solver.io.mesh_files import FORMATS
from ...solver.jobs.job import Job, load_job, make_job
from ...solver.shells.plan import Group, Settings, plan_domain
from ..bridges.corner_bridge import flip
from ..bridges.import_bridge import import_plan
from ..bridges.start_bridge import write_start
from ..properties.settings import SIDES, SIZE_PROPERTY
from ..properties.stored import ROLES

INPUTS = (".blend", ".toml", *FORMATS)

# --- input ---------------------------------------------------------------------------------


def open_input(path: Path, conditions: Sequence[Mapping[str, object]] = (), up: str | None = None) -> None:
    """Make the file the scene: open a .blend, or import a mesh or a job into an empty scene.

    conditions: for a mesh file, tables as in a job file; up: its up axis. Raises `CmcError` if the file cannot be
    read.
    """
    suffix = path.suffix.lower()
    if suffix not in INPUTS:
        raise JobError(f'{path} has no format known here ("{suffix}"); use one of {", ".join(INPUTS)}.')
    if not path.is_file():
        raise JobError(f"There is no file {path}.")
    if suffix == ".blend":
        _call(bpy.ops.wm.open_mainfile, f"{path} cannot be opened", filepath=str(path), load_ui=False)
        return
    job = load_job(path) if suffix == ".toml" else _mesh_job(path, conditions, up)
    for table, wanted in (("fit", job.fit), ("close", job.close), ("complete", job.complete)):
        if wanted is not None:
            raise JobError(
                f"The job has a [{table}], which is not run in Blender without a window; use python -m solver."
            )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
    plan = import_plan(bpy.context, path.stem, job.mesh, _all_groups(job))
    for vertex in job.plan.flipped_corners:
        flip(plan.data, vertex)
    write_start(plan.data, job.plan)
    for name, value in _object_settings(job.settings).items():
        setattr(plan.cmc, name, value)


def _mesh_job(path: Path, conditions: Sequence[Mapping[str, object]], up: str | None) -> Job:
    tables: dict[str, object] = {"mesh": path.name, "conditions": [dict(table) for table in conditions]}
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
        replace(group, name=_short(group.name), edges=take(group.name, group.edges.tolist()).edges)
        for group in job.plan.groups
    ]
    groups += [take(name, pairs.tolist()) for name, pairs in job.mesh.edge_groups.items()]
    if (settings.default_kind, settings.default_tilt) != ("binormal", 0.0):
        groups.append(take("Rest", list(free)))
    return [group for group in groups if len(group.edges)]


def _short(name: str) -> str:
    """The name in Blender's list: "group platform" becomes "platform"."""
    return name.removeprefix("group ").removeprefix("side ")


def _object_settings(settings: Settings) -> dict[str, object]:
    """A job's settings as properties of a plan object."""
    roles = {sheet: role for role, sheet in ROLES.items()}
    values: dict[str, object] = {
        "shell": "DEGREE" if settings.degree is not None else {"first": "FIRST", "bubble": "BUBBLE"}[settings.shell],
        "side": {number: name for name, number in SIDES.items()}[settings.side],
        "size": settings.size.upper(),
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


# --- output --------------------------------------------------------------------------------


def save_blend(path: Path) -> None:
    """Save a copy of the scene next to its place and move it there; so relative paths stay valid."""
    _make_folder(path.parent)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.blend")
    try:
        _call(
            bpy.ops.wm.save_as_mainfile,
            f"{path} cannot be written",
            filepath=str(temporary),
            copy=True,
            check_existing=False,
            relative_remap=True,
        )
        os.replace(temporary, path)
    except OSError as error:
        raise JobError(f"{path} cannot be written: {error.strerror or error}.") from error
    finally:
        temporary.unlink(missing_ok=True)


def export(context: bpy.types.Context, objects: Sequence[bpy.types.Object], place: Path, name: str) -> None:
    """Export objects as the file `name` in the folder `place`, with its material files. Raises `JobError`."""
    exporter = EXPORTERS[Path(name).suffix.removeprefix(".")]
    _make_folder(place)
    with tempfile.TemporaryDirectory(prefix=".export-", dir=place) as scratch:
        with _selected(context, objects):
            exporter(str(Path(scratch) / name))
        for file in sorted(Path(scratch).iterdir()):
            os.replace(file, place / file.name)


def _make_folder(place: Path) -> None:
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise JobError(f"{place} cannot be made: {error.strerror or error}.") from error


@contextmanager
def _selected(context: bpy.types.Context, objects: Sequence[bpy.types.Object]) -> Iterator[None]:
    """Select these objects only, which exporters need, and restore the selection."""
    before = [ob for ob in context.view_layer.objects if ob.select_get()]
    for ob in before:
        ob.select_set(False)
    for ob in objects:
        ob.select_set(True)
    try:
        yield
    finally:
        for ob in objects:
            ob.select_set(False)
        for ob in before:
            ob.select_set(True)


def _export_glb(path: str) -> None:
    addon_utils.enable("io_scene_gltf2")
    _call(
        bpy.ops.export_scene.gltf,
        f"{Path(path).name} cannot be written",
        filepath=path,
        export_format="GLB",
        use_selection=True,
        export_apply=True,
    )


def _export_obj(path: str) -> None:
    """With z up, as `python -m solver` reads and writes OBJ."""
    _call(
        bpy.ops.wm.obj_export,
        f"{Path(path).name} cannot be written",
        filepath=path,
        export_selected_objects=True,
        forward_axis="Y",
        up_axis="Z",
    )


EXPORTERS: dict[str, Callable[[str], None]] = {"glb": _export_glb, "obj": _export_obj}


def _call(operator: Callable[..., set[str]], complaint: str, **arguments: object) -> None:
    """Call one of Blender's operators, which fails with an exception or by not finishing."""
    try:
        finished = operator(**arguments)
    except RuntimeError as error:
        raise JobError(f"{complaint}: {str(error).removeprefix('Error: ').strip()}") from error
    if "FINISHED" not in finished:
        raise JobError(f"{complaint}.")
