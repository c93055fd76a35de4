"""Lines of a net as polylines on the surface: principal lines, or lines of normal curvature H."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..fitting.fit import Fit
from ..gauss.sphere import normalize
from ..signatures import checked
from ..surface.cmc_surface import SurfaceLike
from .exact_lines import followed
from .field import LineField, line_field
from .places import normals_at, points_at
from .sheets import PlacedSurface
from .tracing import Lines

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Line:
    """A line: points and unit normals (k, 3) from one end to the other, both on the rim unless it is closed.

    family: 0 along the larger principal curvature, 1 along the smaller one; of a diagonal net its two families.
    closed: then the first point is not repeated. curvature: (k,) the normal curvature along it.
    """

    points: Array
    normals: Array
    family: int
    closed: bool
    curvature: Array

    def __repr__(self) -> str:
        ends = "closed" if self.closed else "from rim to rim"
        low, high = self.curvature.min(), self.curvature.max()
        return f"Line(family {self.family}, length {self.length:.4g}, {ends}, curvature {low:.4g} to {high:.4g})"

    @property
    def length(self) -> float:
        """In model length."""
        ahead = np.roll(self.points, -1, axis=0) if self.closed else self.points[1:]
        return float(np.linalg.norm(ahead - self.points[: len(ahead)], axis=1).sum())

    @property
    def ends(self) -> Array:
        """The two points (2, 3) on the rim; (0, 3) where the line is closed."""
        return self.points[:0] if self.closed else self.points[[0, -1]]


@checked
def curvature_lines(
    surface: SurfaceLike | PlacedSurface | Fit,
    spacing: float | None = None,
    *,
    count: int | None = None,
    kind: str = "principal",
    sheet: str = "f+",
    quantised: bool = True,
) -> list[Line]:
    """The lines of a net as polylines, family 0 first; arguments and errors as `panel_net`.

    quantised: lines of whole numbers, which close around umbilics and loops and leave their exact directions by a few
    tenths of a degree. False: the exact lines through evenly spaced points of the rim and of paths between loops; near
    lines that arrive from elsewhere, some are left out, and a line that winds for ever ends where it meets itself.
    """
    field = line_field(surface, spacing, count, kind, sheet, quantise=quantised)
    if quantised:
        return lines_of(field, field.lines)
    families, closed, faces, places = followed(field)
    return [
        line_at(field, family, is_closed, f, b)
        for family, is_closed, f, b in zip(families, closed, faces, places, strict=True)
    ]


@checked
def isothermic_coordinates(
    surface: SurfaceLike | PlacedSurface | Fit,
    spacing: float | None = None,
    *,
    count: int | None = None,
    kind: str = "principal",
    sheet: str = "f+",
) -> Array:
    """(F, 3, 2) coordinates at the corners of the surface's faces, in which the lines of the net are at whole numbers.

    They are w = ∫ √Q dz in units of the spacing, almost conformal: squares drawn in them, as texture coordinates, are
    almost squares between curvature lines. They jump by whole numbers, and change sign, across cuts from the umbilics
    to the rim and between loops. Lines of family 0 run along the first. Arguments and errors as `panel_net`.
    """
    field = line_field(surface, spacing, count, kind, sheet)
    return field.coordinates.values[field.coordinates.isothermic.cut.faces]


def lines_of(field: LineField, lines: Lines) -> list[Line]:
    """Polylines through the ends of the chords of traced lines."""
    chords = lines.chords
    order = np.lexsort((chords.position, chords.line))
    stops = np.searchsorted(chords.line[order], np.arange(1, len(lines.family)))
    found = []
    for number, mine in enumerate(np.split(order, stops)):
        faces, places = chords.face[mine], chords.barycentric[mine, 0]
        if not lines.closed[number]:
            faces = np.append(faces, faces[-1])
            places = np.vstack([places, chords.barycentric[mine[-1], 1]])
        found.append(line_at(field, int(lines.family[number]), bool(lines.closed[number]), faces, places))
    return sorted(found, key=lambda line: line.family)


def line_at(field: LineField, family: int, closed: bool, faces: Int, places: Array) -> Line:
    """The line through barycentric places (k, 3) on faces (k,)."""
    H = np.full(len(faces), field.sheet.mean_curvature)
    half = field.half_difference(faces, places)
    curvature = H if field.kind == "diagonal" else H + half if family == 0 else H - half
    sheet = field.sheet
    return Line(points_at(sheet, faces, places), normalize(normals_at(sheet, faces, places)), family, closed, curvature)
