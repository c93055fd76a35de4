"""A shell in its place, measured: its sheets in world units, the report, and the warnings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import Status
from ..fitting.fit import Fit
from ..gauss.methods import METHODS
from ..measure.curvature import vertex_mean_curvature
from ..measure.planes import PlaneReport, measure_plane
from ..measure.report import Report, report
from ..notes import Note
from ..spanning.span import Span
from ..surface.cmc_surface import SHEETS, CmcSurface
from ..surface.placement import PlacementError, Plane, Similarity
from ..surface.solve import CmcSolver
from ..symmetry.sides import side_cut_vertices
from .close import Closing
from .plan import Plan, Settings
from .plan_sides import group_sides
from .shell import Shell
from .shell_notes import shell_notes

Array = NDArray[np.float64]


def check_shown(surface: CmcSurface, shown: str) -> list[str]:
    """The sheets that are not points; raises `PlacementError` where the one to show is not among them."""
    if not surface.mean_curvature:
        sheets = ["f+"]  # a surface of H = 0 has no twin
    else:
        sheets = [name for name in SHEETS if not surface.is_degenerate(name)]
    if not sheets or surface.status is Status.COLLAPSED:
        if not len(surface.domain.boundary_edges):
            raise PlacementError(
                "All normals became the same, since nothing holds those of a closed plan; choose the method "
                f"{METHODS['critical'].label}, which stays near the initial map."
            )
        raise PlacementError(Status.COLLAPSED.sentence)
    if shown not in sheets:
        raise PlacementError(
            f"{shown} degenerates to a point for these boundary conditions, so there is no shell to place; "
            f"show {sheets[0]}, or change a tilt."
        )
    return sheets


def placed_sheets(
    surface: CmcSurface, similarity: Similarity, plane: Plane, sheets: Sequence[str]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Points (n, 3) and normals (n, 3) of the placed sheets, of "g" and of "gauss".

    Where H = 0 there is no g, and the normals are those of a unit sphere.
    """
    placed = {name: similarity.points(surface.sheet(name)) for name in sheets}
    N = similarity.directions(surface.normals)
    radius = abs(surface.scale) if surface.mean_curvature else 1.0
    if surface.mean_curvature:
        placed["g"] = similarity.points(surface.g)
    placed["gauss"] = plane.origin + similarity.scale * radius * N
    return placed, {name: placed_normals(surface.normals, name, similarity) for name in placed}


def placed_normals(N: Array, sheet: str, similarity: Similarity) -> Array:
    """Normals N (n, 3) of the surface on a placed sheet, on the side from which its faces are counter-clockwise."""
    inward = (sheet == "f-") != similarity.mirrored
    return similarity.directions(-N if inward else N)


def measure_shell(
    plan: Plan,
    settings: Settings,
    surface: CmcSurface,
    plane: Plane,
    similarity: Similarity,
    solver: CmcSolver,
    *,
    outline: Array | list[Array] | None,
    fit: Fit | None = None,
    span: Span | None = None,
    closing: Closing | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """The placed and measured shell. plane: its normal is the vertical. outline: see `report`. span: the surface's."""
    sheet = settings.sheet
    sheets = check_shown(surface, sheet)
    placed, normals = placed_sheets(surface, similarity, plane, sheets)
    measured = report(
        surface,
        outline if len(surface.domain.boundary_edges) else None,
        corners=() if span is None else span.corners,
        sheet=sheet,
        positions={name: placed[name] for name in sheets},
        intersections=intersections,
        up=plane.normal,
    )
    measured = replace(measured, planes=_planes(plan, surface, similarity, placed[sheet]))
    if span is not None:
        measured = _with_search(measured, span)
    N = similarity.directions(surface.normals) * (1.0 if sheet == "f+" else -1.0)
    H = vertex_mean_curvature(placed[sheet], surface.faces, N)
    notes = shell_notes(plan, settings, surface, similarity, measured, placed[sheet], N)
    if span is not None:
        notes += _span_notes(span, bool(intersections))
    mixed = fit is not None and fit.is_met and bool(fit.sides)
    message = measured.sentence if fit is None or mixed else fit.message
    if closing is not None and not closing.ok:
        notes = [Note("gap", closing.message), *(note for note in notes if note != measured.sentence)]
    if closing is not None and (surface.status is Status.CONVERGED or not closing.ok):
        message = closing.message
    if fit is not None and not fit.is_met:
        notes.insert(0, Note("goal-missed", fit.message))
    return Shell(
        surface=surface,
        similarity=similarity,
        placed=placed,
        normals=normals,
        source=surface.source,
        faces=surface.faces,
        mean_curvature=np.where(np.isfinite(H), H, measured.mean_curvature),  # the target beside degenerate faces
        report=measured,
        message=message,
        warnings=notes,
        solver=solver,
        fit=fit,
        span=span,
        closing=closing,
    )


def _span_notes(span: Span, checked: bool) -> list[Note]:
    """What is known of the search, and with its slower checks; crossings are in the report already."""
    notes = span.checks.notes if checked and span.ok else span.asked.lines.notes
    return [note for note in notes if note.code != "crossing"]


def _with_search(measured: Report, span: Span) -> Report:
    """The report with the search for a span in place of the solve for its normals."""
    last = span.history[-1]
    found = replace(measured, iterations=len(span.history) - 1, residual=float(last.residual))
    return found if span.ok else replace(found, status=span.status.value, sentence=span.message)


def _planes(plan: Plan, surface: CmcSurface, similarity: Similarity, points: Array) -> tuple[PlaneReport, ...]:
    """The planes in which the mirrors and planes of the plan's groups lie on a placed sheet, points (n, 3)."""
    planes = []
    for group in plan.groups:
        if group.kind in ("mirror", "plane"):
            for side in group_sides(group, surface.domain):
                along, weights = side_cut_vertices(surface, np.asarray(side.edges))
                normal = similarity.directions(np.asarray(side.normal))
                planes.append(measure_plane(side.name, group.kind, points, along, weights, normal))
    return tuple(planes)
