"""Files of results: meshes by Blender's exporters, with materials, or as Export writes them; the scene as a .blend.

All go through an `Outbox`, whose scratch folder lies beside the folder of the plan: paths to textures hold in both.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import addon_utils
import bpy

from ...solver.errors import JobError
from ...solver.interrupts import check
from ...solver.io.file_checks import check_file
from ...solver.io.mesh_files import FORMATS, mesh_bytes
from ...solver.io.whole_files import Outbox
from ..bridges.export_bridge import joined, read_objects

EXPORTED = tuple(sorted(suffix[1:] for suffix in FORMATS))
"""Formats of results, as for Export."""


@dataclass(frozen=True)
class Exporting:
    """What is exported: objects, to a file under a scratch name of an outbox."""

    outbox: Outbox
    context: bpy.types.Context
    objects: Sequence[bpy.types.Object]
    file: Path
    target: Path


def take_export(
    outbox: Outbox, context: bpy.types.Context, objects: Sequence[bpy.types.Object], target: Path
) -> None:
    """Export objects as one file, with its material files, to an outbox. Raises `JobError`."""
    exporting = Exporting(outbox, context, objects, outbox.at(target), target)
    with _selected(context, objects):
        _EXPORTERS.get(target.suffix, _export_arrays)(exporting)
    if not exporting.file.exists():
        raise JobError(f"{target} cannot be written.")


def take_blend(outbox: Outbox, target: Path) -> None:
    """Save a copy of the scene to an outbox. Raises `JobError`."""
    file = str(outbox.at(target))
    call(
        bpy.ops.wm.save_as_mainfile,
        f"{target} cannot be written",
        filepath=file,
        copy=True,
        check_existing=False,
        relative_remap=True,
    )


def call(operator: Callable[..., set[str]], complaint: str, **arguments: object) -> None:
    """Call one of Blender's operators, which fails with an exception or by not finishing."""
    try:
        finished = operator(**arguments)
    except RuntimeError as error:
        check()
        lines = str(error).removeprefix("Error: ").strip().splitlines()
        reason = [line for line in lines if not line.startswith("Location: ")] or ["nothing says why"]
        raise JobError(f"{complaint}: {reason[-1]}") from error
    check()
    if "FINISHED" not in finished:
        raise JobError(f"{complaint}.")


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


def _export_glb(exporting: Exporting) -> None:
    addon_utils.enable("io_scene_gltf2")
    call(
        bpy.ops.export_scene.gltf,
        f"{exporting.target} cannot be written",
        filepath=str(exporting.file),
        export_format="GLB",
        use_selection=True,
        export_apply=True,
    )
    scale = exporting.context.scene.unit_settings.scale_length
    if scale != 1.0:
        check_file(exporting.file, exporting.target)
        exporting.outbox.write(exporting.target, _scaled(exporting.file.read_bytes(), scale))


def _scaled(glb: bytes, scale: float) -> bytes:
    """A GLB with its scenes scaled: the exporter leaves out the unit of the scene, and glTF's is the metre."""
    length = struct.unpack("<I", glb[12:16])[0]
    data = json.loads(glb[20 : 20 + length])
    for root in {number for scene in data.get("scenes", []) for number in scene.get("nodes", [])}:
        node = data["nodes"][root]
        if "matrix" in node:
            node["matrix"] = [part if k % 4 == 3 else scale * part for k, part in enumerate(node["matrix"])]
            continue
        node["scale"] = [scale * part for part in node.get("scale", [1.0, 1.0, 1.0])]
        if "translation" in node:
            node["translation"] = [scale * part for part in node["translation"]]
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + length :]
    return glb[:8] + struct.pack("<II", 20 + len(text) + len(rest), len(text)) + glb[16:20] + text + rest


def _export_obj(exporting: Exporting) -> None:
    """With z up, as `python -m solver` reads and writes OBJ."""
    call(
        bpy.ops.wm.obj_export,
        f"{exporting.target} cannot be written",
        filepath=str(exporting.file),
        export_selected_objects=True,
        forward_axis="Y",
        up_axis="Z",
        path_mode="RELATIVE",
    )
    depsgraph = exporting.context.evaluated_depsgraph_get()
    meshes = [ob.evaluated_get(depsgraph).data for ob in exporting.objects]
    wanted = sum(len(mesh.vertices) for mesh in meshes), sum(len(mesh.polygons) for mesh in meshes)
    data = exporting.file.read_bytes() if exporting.file.exists() else b""
    if (data.count(b"\nv "), data.count(b"\nf ")) != wanted:  # it says FINISHED on a full disk, too
        raise JobError(f"{exporting.target} cannot be written: only a part of it was; the disk may be full.")


def _export_arrays(exporting: Exporting) -> None:
    """As Export writes it."""
    parts = read_objects(exporting.objects, exporting.context.evaluated_depsgraph_get())
    mesh, normals = joined(parts)
    exporting.outbox.write(exporting.target, mesh_bytes(exporting.target, mesh, normals=normals))


_EXPORTERS: dict[str, Callable[[Exporting], None]] = {".glb": _export_glb, ".obj": _export_obj}
