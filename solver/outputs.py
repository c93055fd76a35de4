"""The files a solved job leaves: the sheets as meshes, with what the plan's mesh carries, and the report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .errors import JobError
from .files import MeshData, write_bytes, write_mesh
from .pipeline import Formed, sheet_polygons
from .plan import Plan

SHEET_KEYS = {"f_plus": "f+", "f_minus": "f-", "g": "g", "gauss": "gauss"}
"""Key of a file in a job → name of the sheet."""


def sheet_mesh(formed: Formed, sheet: str, plan: Plan, mesh: MeshData, *, triangles: bool = False) -> MeshData:
    """A placed sheet with the polygons, UVs, groups and materials of the plan's mesh.

    A polygon that the cut of an open surface runs through is there as triangles; edge groups are kept
    unless the surface is cut. `triangles` gives the plan's triangles instead, since a
    sheet that folds has polygons no other triangles fit. Raises `JobError` where the sheet degenerates to a
    point.
    """
    if sheet not in formed.placed:
        raise JobError(f"{sheet} degenerates to a point for these boundary conditions, so there is nothing to write.")
    assert plan.polygons is not None and plan.triangle_polygons is not None
    polygons, owner = list(formed.faces), plan.triangle_polygons
    if not triangles:
        polygons, owner = sheet_polygons(plan.polygons, plan.triangle_polygons, plan.triangles, formed.faces)
    uv_corners = []
    if mesh.uv_corners:
        for polygon, index in zip(polygons, owner, strict=True):
            rows = mesh.uv_corners[index]
            row_of = dict(zip(mesh.polygons[index].tolist(), rows.tolist(), strict=False))
            corners = [row_of[vertex] for vertex in formed.source[polygon].tolist()] if len(rows) else []
            uv_corners.append(np.array(corners, dtype=np.int32))
    names = {
        key: [values[index] for index in owner.tolist()] if (values := getattr(mesh, key)) else []
        for key in ("objects", "groups", "materials")
    }
    cut = len(formed.source) != len(plan.positions)
    return replace(
        mesh,
        positions=formed.placed[sheet],
        polygons=polygons,
        uv_corners=uv_corners,
        edge_groups={} if cut else mesh.edge_groups,
        **names,
    )


def report_data(formed: Formed) -> dict[str, Any]:
    """The report as plain data, with the message and the warnings."""
    return {"message": formed.message, "warnings": formed.warnings, **formed.report.to_dict()}


def write_results(
    formed: Formed, plan: Plan, mesh: MeshData, outputs: Mapping[str, Path], *, up: str | None = None
) -> None:
    """Write each of `outputs`, sheet or "report" → file; the report first: it says why a sheet is missing."""
    if "report" in outputs:
        text = json.dumps(report_data(formed), indent=2, ensure_ascii=False, allow_nan=False)
        write_bytes(outputs["report"], (text + "\n").encode())
    for name, file in outputs.items():
        if name != "report":
            sheet = sheet_mesh(formed, name, plan, mesh, triangles=file.suffix.lower() != ".obj")
            write_mesh(file, sheet, normals=formed.normals.get(name), up=up)
