"""What else the user of a shell should know: the warnings of `Shell.warnings`, each with its code."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.delaunay import speed_note
from ..domain.domain import Domain
from ..errors import Status
from ..measure.curvature_fault import curvature_note
from ..measure.report import Report
from ..notes import Note
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import ALIKE, Similarity
from .plan import Plan, Settings
from .second_shell import off_degree

Array = NDArray[np.float64]

# Share of the shell's area that may overhang, and degrees by which it may, before it is worth a warning: next to a
# vertical rim the faces of an ordinary mesh lean by a degree or two.
_OVERHANG = 0.01
_LEAN = 5.0


def shell_notes(
    plan: Plan,
    settings: Settings,
    surface: CmcSurface,
    similarity: Similarity,
    measured: Report,
    points: Array,
    normals: Array,
) -> list[Note]:
    """Warnings about the plan, the solve and the measured sheet; points and normals (n, 3): of the sheet shown.

    normals: on the side from which f+ is convex, as for `Shell.mean_curvature`.
    """
    notes = [
        *plan_notes(plan, surface.domain),
        *_solve_notes(settings, surface, similarity, measured),
        curvature_note(measured.shown, surface.domain, plan.positions, points, surface.faces, normals)
        if surface.status in (Status.CONVERGED, Status.GAP)
        else None,
        *_sheet_notes(plan, surface, measured),
    ]
    return [note for note in notes if note is not None]


def plan_notes(plan: Plan, domain: Domain) -> list[Note]:
    """Likely mistakes in the plan: groups without edges, faces that look down."""
    empty = [group.name for group in plan.groups if not np.size(group.edges)]
    notes = [Note("empty-group", f'Group "{name}" has no edges.') for name in empty]
    a, b, c = (plan.positions[domain.faces[:, k]] for k in range(3))
    areas = 0.5 * np.cross(b - a, c - a)
    if areas[:, 2].sum() < -0.5 * np.linalg.norm(areas, axis=1).sum():
        text = "The plan's faces look down, so the shell hangs below it; flip their normals, or flip the shell."
        notes.append(Note("faces-down", text))
    return notes


def _solve_notes(settings: Settings, surface: CmcSurface, similarity: Similarity, measured: Report) -> list[Note]:
    """How the solve ended, where that is not as asked."""
    notes = []
    if surface.status is not Status.CONVERGED:
        notes.append(Note("gap" if surface.status is Status.GAP else "not-converged", measured.sentence))
    if settings.size == "match_plan" and similarity.likeness < ALIKE and len(surface.domain.boundary_edges):
        text = (
            f"The boundary of {settings.sheet} does not follow the drawn outline, so only its size is "
            "matched; allow it to rotate, or size it by span, rise or radius."
        )
        notes.append(Note("size-only", text))
    if settings.degree is not None and off_degree(surface, settings.degree):
        text = (
            f"The normals have degree {surface.harmonic.degree:.3g}, not {settings.degree:g}: no map of that "
            "degree was found on this mesh; refine it, or choose another degree."
        )
        notes.append(Note("degree", text))
    slow = speed_note(surface.domain) if settings.delaunay else None
    return notes if slow is None else [*notes, slow]


def _sheet_notes(plan: Plan, surface: CmcSurface, measured: Report) -> list[Note]:
    """What the measures of the sheet show."""
    notes, shown = [], measured.shown
    twin = "f-" if measured.sheet == "f+" else "f+"
    if twin not in measured.sheets and surface.mean_curvature:
        notes.append(Note("point", f"{twin} degenerates to a point for these boundary conditions and is left out."))
    if shown.intersections is not None and shown.intersections.count:
        owner = plan.triangle_polygons
        pair = [int(i if owner is None else owner[i]) for i in shown.intersections.pairs[0]]
        count = shown.intersections.count
        which = f"{count} pairs of faces cross, the first of them" if count > 1 else "one pair of faces crosses,"
        text = f"{shown.name} goes through itself: {which} {pair[0]} and {pair[1]}."
        notes.append(Note("crossing", text))
    leaning = None if surface.domain.genus else shown.overhang  # half of every tube overhangs
    if leaning is not None and leaning.area_share > _OVERHANG and leaning.largest_lean > _LEAN:
        text = (
            f"{100 * leaning.area_share:.0f} % of {shown.name} overhangs: its faces lean out past the vertical, by up "
            f"to {leaning.largest_lean:.0f}°."
        )
        notes.append(Note("overhang", text))
    return notes
