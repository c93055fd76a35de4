"""The files of a job: the sheets as meshes, with UVs, groups and materials of the plan, the copies, the report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import JobError
from ..io.mesh_files import corner_rows, mesh_bytes
from ..io.obj import MeshData
from ..io.whole_files import Outbox
from ..measure.report import to_plain
from ..notes import notes_data
from ..shells.complete import Completed
from ..shells.plan import Plan
from ..shells.polygon_sheets import PolygonSheet, polygon_sheet
from ..shells.shell import Shell, sheet_polygons
from .complete_table import CompleteOptions

SHEET_KEYS = {"f_plus": "f+", "f_minus": "f-", "g": "g", "gauss": "gauss"}
"""Key of a file in a job → name of the sheet."""


def sheet_mesh(shell: Shell, sheet: str, plan: Plan, mesh: MeshData, *, triangles: bool = False) -> MeshData:
    """A placed sheet with the polygons, UVs, groups and materials of the plan's mesh.

    A polygon that the cut of an open surface runs through falls into triangles; edge groups are kept unless the surface
    is cut. triangles: the plan's triangles instead, since no other triangles fit the polygons of a sheet that folds.
    Raises `JobError` where the shell does not have the sheet.
    """
    _check_placed(shell, sheet)
    assert plan.polygons is not None and plan.triangle_polygons is not None
    polygons, owner = list(shell.faces), plan.triangle_polygons
    if not triangles:
        polygons, owner = sheet_polygons(plan.polygons, plan.triangle_polygons, plan.triangles, shell.faces)
    uv_corners = []
    if mesh.uv_corners:
        for polygon, index in zip(polygons, owner, strict=True):
            rows = mesh.uv_corners[index]
            row_of = dict(zip(mesh.polygons[index].tolist(), rows.tolist(), strict=False))
            corners = [row_of[vertex] for vertex in shell.source[polygon].tolist()] if len(rows) else []
            uv_corners.append(np.array(corners, dtype=np.int32))
    names = {
        key: [values[index] for index in owner.tolist()] if (values := getattr(mesh, key)) else []
        for key in ("objects", "groups", "materials")
    }
    cut = len(shell.source) != len(plan.positions)
    return replace(
        mesh,
        positions=shell.placed[sheet],
        polygons=polygons,
        uv_corners=uv_corners,
        edge_groups={} if cut else mesh.edge_groups,
        **names,
    )


def polygon_mesh(sheet: PolygonSheet, plan: Plan, mesh: MeshData) -> MeshData:
    """A dual or corner mesh with the UVs, objects, groups and materials of the plan's mesh.

    Every vertex has one UV, interpolated in its triangle; a polygon with a vertex that has none gets none.
    """
    assert plan.triangle_polygons is not None
    owners = sheet.owners(plan.triangles, plan.triangle_polygons).tolist()
    uvs, uv_corners = np.empty((0, 2)), []
    if mesh.uv_corners:
        rows = corner_rows(mesh.polygons, mesh.uv_corners, plan.triangles, plan.triangle_polygons)
        padded = np.vstack([mesh.uvs, np.full((1, 2), np.nan)])  # row -1
        uvs = sheet.from_corners(padded[rows], plan.triangles)
        known = np.isfinite(uvs).all(axis=1)
        uv_corners = [p if known[p].all() else p[:0] for p in sheet.polygons]
        uvs = np.nan_to_num(uvs)
    names = {
        key: [values[index] for index in owners] if (values := getattr(mesh, key)) else []
        for key in ("objects", "groups", "materials")
    }
    return replace(
        mesh, positions=sheet.points, polygons=sheet.polygons, uvs=uvs, uv_corners=uv_corners, edge_groups={}, **names
    )


def _check_placed(shell: Shell, sheet: str) -> None:
    if sheet not in shell.placed:
        if not shell.report.mean_curvature:
            raise JobError(f"A surface of mean curvature 0 has no {sheet}; leave it out, or choose H ≠ 0.")
        raise JobError(f"{sheet} degenerates to a point for these boundary conditions, so there is nothing to write.")


def report_data(shell: Shell) -> dict[str, Any]:
    """The report as plain data, with the message and the warnings, and for a fit how near it came."""
    data = {"message": shell.message, "warnings": notes_data(shell.warnings), **shell.report.to_dict()}
    if shell.fit is None:
        return data
    fit = shell.fit
    return data | {
        "fit": {
            "met": fit.is_met,
            "status": fit.status.value,
            "message": fit.message,
            "distances": to_plain(fit.distances),
            "evaluations": len(fit.history),
        }
    }


def take_sheets(
    outbox: Outbox,
    shell: Shell,
    plan: Plan,
    mesh: MeshData,
    outputs: Mapping[str, Path],
    *,
    up: str | None = None,
    combinatorics: str = "primal",
) -> list[JobError]:
    """Write each sheet of `outputs`, sheet → file, to an outbox; returns why some are missing.

    combinatorics: of `COMBINATORICS`, the polygons of the sheets.
    """
    missing = []
    for name, file in outputs.items():
        if name == "report":
            continue
        try:
            _check_placed(shell, name)
        except JobError as error:
            missing.append(error)
            continue
        if combinatorics == "primal":
            sheet = sheet_mesh(shell, name, plan, mesh, triangles=file.suffix.lower() != ".obj")
            outbox.write(file, mesh_bytes(file, sheet, normals=shell.normals[name], up=up))
        else:
            polygons = polygon_sheet(shell, name, combinatorics)
            data = mesh_bytes(file, polygon_mesh(polygons, plan, mesh), normals=polygons.normals, up=up)
            outbox.write(file, data)
    return missing


def take_completed(
    outbox: Outbox, completed: Completed, options: CompleteOptions, plan: Plan, mesh: MeshData, up: str | None = None
) -> None:
    """Write the welded mesh and the instances, a list in JSON with the pieces as OBJ files beside it, to an outbox."""
    if options.mesh is not None:
        data = completed_mesh(completed, plan, mesh, triangles=options.mesh.suffix.lower() != ".obj")
        outbox.write(options.mesh, mesh_bytes(options.mesh, data, normals=completed.normals, up=up))
    if options.instances is not None:
        _take_instances(outbox, completed, options.instances, plan, mesh, up)


def completed_report(completed: Completed, *, welded: bool = True) -> dict[str, Any]:
    """The report on the copies as plain data; lengths are those of the placed shell.

    welded=False leaves out the numbers of the welded mesh, and does not make it.
    """
    numbers = {
        "copies": completed.copy_count,
        "sheets": {name: completed.sheets.count(name) for name in sorted(set(completed.sheets))},
        "triangles": completed.face_count,
        "largest_gap": completed.largest_gap,
        "relative_gap": completed.relative_gap,
        "largest_offset": completed.largest_offset,
        "relative_offset": completed.relative_offset,
        "lattice": to_plain(completed.lattice),
    }
    if welded:
        mesh = completed.completion.mesh
        numbers |= {"vertices": len(mesh.vertices), "is_closed": mesh.is_closed}
    return numbers


def completed_mesh(completed: Completed, plan: Plan, mesh: MeshData, *, triangles: bool = False) -> MeshData:
    """The welded mesh with the polygons (or triangles), UVs, groups and materials of the plan's mesh on every copy."""
    polygons = completed.polygons(plan, triangles=triangles)
    lists = polygons.lists()
    uv_corners = []
    if mesh.uv_corners:
        rows = np.split(polygons.cut_vertices, polygons.starts[1:-1])
        source = completed.shell.source
        for index, corners in zip(polygons.faces.tolist(), rows, strict=True):
            drawn = mesh.uv_corners[index]
            row_of = dict(zip(mesh.polygons[index].tolist(), drawn.tolist(), strict=False))
            copied = [row_of[vertex] for vertex in source[corners].tolist()] if len(drawn) else []
            uv_corners.append(np.array(copied, dtype=np.int32))
    names = {
        key: [values[index] for index in polygons.faces.tolist()] if (values := getattr(mesh, key)) else []
        for key in ("objects", "groups", "materials")
    }
    return replace(
        mesh, positions=completed.points, polygons=lists, uv_corners=uv_corners, edge_groups={}, **names
    )


def piece_file(instances: Path, sheet: str) -> Path:
    """The OBJ of a piece, beside the list of its instances."""
    keys = {name: key for key, name in SHEET_KEYS.items()}
    return instances.with_name(f"{instances.stem}_{keys[sheet]}.obj")


def _take_instances(
    outbox: Outbox, completed: Completed, file: Path, plan: Plan, mesh: MeshData, up: str | None
) -> None:
    pieces = {name: piece_file(file, name) for name in sorted(set(completed.sheets))}
    for name, path in pieces.items():
        data = sheet_mesh(completed.shell, name, plan, mesh)
        points = replace(data, positions=completed.piece(name))
        outbox.write(path, mesh_bytes(path, points, normals=completed.shell.normals[name], up=up))
    instances = {
        "pieces": {name: path.name for name, path in pieces.items()},
        "lattice": to_plain(completed.lattice),
        "instances": [
            {"piece": name, "matrix": to_plain(matrix)}
            for name, matrix in zip(completed.sheets, completed.transforms, strict=True)
        ],
    }
    outbox.write(file, (json.dumps(instances, ensure_ascii=False, allow_nan=False) + "\n").encode())
