"""A shell whose mean curvature misses its target: by how much, where most of that is, and the way out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..meshing.rounding import CORNER
from ..notes import Note
from .arrays import Array, Indices, face_areas_in_space
from .curvature import mean_curvature_of
from .sheet import SheetReport, faces_near
from .summary import off_by

# A part of the shell holds the error if it has at least this share of it, and this many times as much as of the area.
_MOST, _DENSER = 0.5, 2.0


def curvature_note(
    sheet: SheetReport, domain: Domain, drawn: Array, points: Array, faces: Indices, normals: Array
) -> Note | None:
    """The warning "curvature" or "not-cmc" where H of a measured sheet is off or lost, else None.

    drawn (V, 2|3): the plan's vertices, which have the corners; points, normals (n, 3) and faces (F, 3): the sheet, the
    faces in the order of the domain's.
    """
    H = sheet.mean_curvature
    if H is None or not H.is_off:
        return None
    errors = mean_curvature_of(points, faces, normals) - H.target
    squares = face_areas_in_space(points, faces) * np.where(np.isfinite(errors), errors, 0.0) ** 2
    cause = _cause(sheet, domain, np.asarray(drawn, dtype=np.float64), squares)
    return Note("not-cmc" if H.is_lost else "curvature", f"Mean curvature is off by {off_by(H)}{cause}")


def _cause(sheet: SheetReport, domain: Domain, drawn: Array, squares: Array) -> str:
    """Why, and what to do, as the end of a sentence. squares (F,): squared error times area of the faces."""
    corners = boundary_corners(domain, drawn)
    near = faces_near(domain.faces, corners)
    share = squares[near].sum() / max(float(squares.sum()), np.finfo(float).tiny)
    if share >= _MOST and share >= _DENSER * domain.face_areas[near].sum() / domain.face_areas.sum():
        worst = _worst(corners, domain, squares)
        place = ", ".join(f"{x:.4g}" for x in drawn[worst, :2])
        return (
            f", most of it next to corners of the plan, first of all that at ({place}): round them, or have the "
            "boundary normals differ less there."
        )
    flatter = ", or choose smaller tilts" if len(domain.boundary_edges) else ""
    if sheet.intersections is not None and sheet.intersections.count:
        return f", and it goes through itself: refine the mesh{flatter}."
    return f": the mesh is too coarse for it; halve its edge length{flatter}."


def _worst(corners: NDArray[np.int64], domain: Domain, squares: Array) -> int:
    """The corner whose faces have the largest squared error."""
    of_vertex = np.bincount(domain.faces.ravel(), np.repeat(squares, 3), minlength=domain.vertex_count)
    return int(corners[np.argmax(of_vertex[corners])])


def boundary_corners(domain: Domain, drawn: Array) -> NDArray[np.int64]:
    """Vertices at which the drawn boundary turns by more than `CORNER`; drawn (V, 2|3)."""
    found = []
    for loop in domain.boundary_loops:
        before, after = drawn[loop] - drawn[np.roll(loop, 1)], drawn[np.roll(loop, -1)] - drawn[loop]
        lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
        cosine = np.einsum("ij,ij->i", before, after) / np.maximum(lengths, np.finfo(float).tiny)
        found.append(loop[cosine < np.cos(CORNER)])
    return np.concatenate([np.empty(0, dtype=np.int64), *found]).astype(np.int64)
