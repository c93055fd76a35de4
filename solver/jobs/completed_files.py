"""The files of a completed shell: one welded mesh, or its pieces and a list of where they go."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..files import MeshData, write_bytes, write_mesh
from ..measure.report import plain
from ..plans.completing import Completed
from ..plans.plan import Plan
from .complete_table import Completing
from .outputs import SHEET_KEYS, sheet_mesh


def write_completed(
    completed: Completed, wanted: Completing, plan: Plan, mesh: MeshData, up: str | None = None
) -> None:
    """Write what is wanted; instances are a list in JSON, with the pieces as OBJ files beside it."""
    if wanted.mesh is not None:
        data = completed_mesh(completed, plan, mesh, triangles=wanted.mesh.suffix.lower() != ".obj")
        write_mesh(wanted.mesh, data, normals=completed.normals, up=up)
    if wanted.instances is not None:
        _write_instances(completed, wanted.instances, plan, mesh, up)


def completed_report(completed: Completed, *, welded: bool = True) -> dict[str, Any]:
    """What there is to know about the copies, as plain data; lengths are those of the placed shell.

    welded: False leaves out what is known of the welded mesh only, which then is not made.
    """
    told = {
        "copies": completed.copy_count,
        "sheets": {name: completed.sheets.count(name) for name in sorted(set(completed.sheets))},
        "triangles": completed.face_count,
        "largest_gap": completed.largest_gap,
        "relative_gap": completed.relative_gap,
        "largest_offset": completed.largest_offset,
        "lattice": plain(completed.lattice),
    }
    if welded:
        mesh = completed.completion.mesh
        told |= {"vertices": len(mesh.vertices), "is_closed": mesh.is_closed}
    return told


def completed_mesh(completed: Completed, plan: Plan, mesh: MeshData, *, triangles: bool = False) -> MeshData:
    """The welded mesh with the polygons (or triangles), UVs, groups and materials of the plan's mesh on every copy."""
    polygons = completed.polygons(plan, triangles=triangles)
    lists = polygons.lists()
    uv_corners = []
    if mesh.uv_corners:
        rows = np.split(polygons.rows, polygons.starts[1:-1])
        source = completed.formed.source
        for index, corners in zip(polygons.faces.tolist(), rows, strict=True):
            drawn = mesh.uv_corners[index]
            row_of = dict(zip(mesh.polygons[index].tolist(), drawn.tolist(), strict=False))
            found = [row_of[vertex] for vertex in source[corners].tolist()] if len(drawn) else []
            uv_corners.append(np.array(found, dtype=np.int32))
    names = {
        key: [values[index] for index in polygons.faces.tolist()] if (values := getattr(mesh, key)) else []
        for key in ("objects", "groups", "materials")
    }
    return replace(
        mesh, positions=completed.points, polygons=lists, uv_corners=uv_corners, edge_groups={}, **names
    )


def _write_instances(completed: Completed, file: Path, plan: Plan, mesh: MeshData, up: str | None) -> None:
    keys = {sheet: key for key, sheet in SHEET_KEYS.items()}
    pieces = {name: file.with_name(f"{file.stem}_{keys[name]}.obj") for name in sorted(set(completed.sheets))}
    for name, path in pieces.items():
        data = sheet_mesh(completed.formed, name, plan, mesh)
        points = replace(data, positions=completed.piece(name))
        write_mesh(path, points, normals=completed.formed.normals[name], up=up)
    told = {
        "pieces": {name: path.name for name, path in pieces.items()},
        "lattice": plain(completed.lattice),
        "instances": [
            {"piece": name, "matrix": plain(matrix)}
            for name, matrix in zip(completed.sheets, completed.transforms, strict=True)
        ],
    }
    write_bytes(file, (json.dumps(told, ensure_ascii=False, allow_nan=False) + "\n").encode())
