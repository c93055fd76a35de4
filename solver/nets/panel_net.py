"""Nets of panels on a surface, from its Hopf differential."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError, check_choice
from ..fitting.fit import Fit
from ..limits import POSITIVE, Range, check_number
from ..signatures import checked
from ..surface.cmc_surface import SurfaceLike
from .cells import Cells, cells_of
from .cut import cut_domain
from .hopf import HopfDifferential, hopf_differential
from .isothermic import Isothermic
from .net import KINDS, Net
from .places import normals_at, points_at
from .quantise import Quantised, quantised
from .rim_nodes import rim_nodes
from .sheets import PlacedSurface, Sheet, gradients, shape_gradients, sheet_of
from .sides import corner_vertices, line_sides
from .slivers import merged
from .tracing import Lines, traced
from .zero_cells import cells_of_vertices

Array = NDArray[np.float64]
Int = NDArray[np.integer]

_COUNT = Range(1, 1_000_000, whole=True)
# No net has more lines across than vertices of the mesh would carry: crossings are at most this many a triangle.
_MOST_A_FACE = 40
# The rim of the panels is within this part of the spacing from the rim of the surface.
_NEAR = 0.1


@dataclass(frozen=True, eq=False)
class LineField:
    """The coordinates behind a net: a sheet, its Hopf differential, w, and w as whole numbers.

    spacing: the wanted side in model length.
    """

    sheet: Sheet
    hopf: HopfDifferential
    coordinates: Quantised
    spacing: float

    @property
    def lines(self) -> Lines:
        """The lines at whole numbers."""
        return traced(self.coordinates.isothermic.cut, self.coordinates.values)


@checked
def panel_net(
    surface: SurfaceLike | PlacedSurface | Fit,
    spacing: float | None = None,
    *,
    count: int | None = None,
    kind: str = "principal",
    sheet: str = "f+",
) -> Net:
    """A net of panels along the curvature lines of a surface of constant mean curvature, or along their diagonals.

    Lines of whole numbers of w = ∫ √Q dz, Q the Hopf differential 4 <f_z, N_z>: they close around umbilics and loops.
    The mesh is that of the lines' crossings. Inner panels have four corners, and 4 + 2 n around umbilics of order n;
    at the rim panels are clipped, the smallest ones joined to their neighbours.

    surface: a `CmcSurface`, `Span`, `Fit` or `Shell`. spacing: the wanted side of a panel in model length, its median
    over the net; sides vary as 1 / √(k1 - k2). count: or the number of panels. kind: "principal", or "diagonal": the
    lines of normal curvature H at 45° to these, at H = 0 the asymptotic lines. sheet: "f+", "f-" or "g".

    Raises `MeshError` on surfaces with handles and on meshes too coarse; `ConditionError` on spheres and planes, which
    have no curvature lines, and on a spacing too large for the surface.
    """
    field = line_field(surface, spacing, count, kind, sheet)
    lines = field.lines
    domain, near = field.sheet.domain, _NEAR * field.spacing
    corners = rim_nodes(domain, field.sheet.points, lines.points, corner_vertices(field.hopf), near)
    cells = cells_of(domain, lines, corners)
    return _net(field, lines, cells, kind)


def line_field(
    surface: SurfaceLike | PlacedSurface | Fit | Sheet,
    spacing: float | None,
    count: int | None,
    kind: str,
    sheet: str,
    quantise: bool = True,
) -> LineField:
    """Checked arguments, and the coordinates of a net; see `panel_net`."""
    check_choice(kind, KINDS, "kind of net")
    if (spacing is None) == (count is None):
        raise ConditionError("Give either the spacing of a net or the count of its panels.")
    if spacing is not None:
        check_number(spacing, "spacing", POSITIVE)
    if count is not None:
        check_number(count, "count of panels", _COUNT)
    on = sheet_of(surface, sheet)
    hopf = hopf_differential(on)
    cut = cut_domain(hopf)
    step, side = _steps(on, hopf, spacing, count)
    isothermic = Isothermic.of(cut, kind == "diagonal")
    sides = line_sides(hopf, cut)
    return LineField(on, hopf, quantised(isothermic, step, sides, exact=not quantise), side)


def _steps(sheet: Sheet, hopf: HopfDifferential, spacing: float | None, count: int | None) -> tuple[float, float]:
    """The spacing in units of w, and as the median side: side = w / √(k1 - k2), panels as dense as |Q|."""
    difference = np.abs(hopf.at_faces) / sheet.metric
    panels = np.abs(hopf.at_faces) * sheet.domain.face_areas
    order = np.argsort(difference)
    middle = np.searchsorted(np.cumsum(panels[order]), 0.5 * panels.sum())
    median = float(np.sqrt(difference[order[min(middle, len(order) - 1)]]))
    step = float(np.sqrt(panels.sum() / count)) if count is not None else float(spacing or 0.0) * median
    most = _MOST_A_FACE * len(panels)
    if panels.sum() / step**2 > most:
        raise ConditionError(
            f"The net would have more than {most:,} panels, {_MOST_A_FACE} in a triangle of the mesh; choose a spacing of "
            f"at least {np.sqrt(panels.sum() / most) / median:.3g}, or refine the mesh."
        )
    return step, step / median


def _net(field: LineField, lines: Lines, cells: Cells, kind: str) -> Net:
    sheet, hopf = field.sheet, field.hopf
    points = points_at(sheet, cells.faces, cells.barycentric)
    rim = {(int(i), int(j)) for i, j in cells.arcs[cells.family < 0]}
    kept = set(cells.corners.tolist())
    polygons, members = merged([cell.tolist() for cell in cells.cells], rim, points, kept, _NEAR * field.spacing)
    number = np.full(len(points), -1)
    used = np.unique(np.concatenate(polygons))
    number[used] = np.arange(len(used))
    edges, family = _edges(polygons, cells)
    panel_of_cell = np.empty(len(cells.cells), dtype=np.int64)
    for panel, parts in enumerate(members):
        panel_of_cell[parts] = panel
    orders, branched = _umbilics(field, lines, cells, panel_of_cell, len(polygons))
    clipped = np.zeros(len(polygons), dtype=bool)
    clipped[panel_of_cell[np.unique(cells.cell_of_half[2 * np.flatnonzero(cells.family < 0)])]] = True
    k1 = _larger_curvature(field, cells)
    return Net(
        vertices=points[used],
        normals=normals_at(sheet, cells.faces[used], cells.barycentric[used]),
        polygons=[number[polygon] for polygon in polygons],
        edges=number[edges],
        family=family,
        faces=cells.faces[used],
        barycentric=cells.barycentric[used],
        clipped=clipped,
        orders=orders,
        branched=branched,
        kind=kind,
        sheet=sheet.name,
        spacing=field.spacing,
        spacings=field.coordinates.spacings,
        curvature=np.array([k1[polygon].mean() for polygon in polygons]),
        deviation=mean_deviation(field.coordinates),
        mean_curvature=sheet.mean_curvature,
        euler_characteristic=sheet.domain.euler_characteristic,
    )


def _edges(polygons: list[list[int]], cells: Cells) -> tuple[Int, Int]:
    """The edges (m, 2) of the panels and their families (m,), -1 on the rim."""
    ends = np.concatenate([np.column_stack([p, np.roll(p, -1)]) for p in polygons])
    edges = np.unique(np.sort(ends, axis=1), axis=0)
    count = len(cells.faces)
    keys = np.sort(cells.arcs, axis=1) @ [count, 1]
    order = np.lexsort((cells.family, keys))  # the rim first, where a line joins the same two nodes
    wanted = edges @ [count, 1]
    at = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return edges, np.where(keys[order][at] == wanted, cells.family[order][at], -1)


def _umbilics(field: LineField, lines: Lines, cells: Cells, panel_of_cell: Int, count: int) -> tuple[Int, Int]:
    """The sum of the orders of the zeros in each panel, and the panels in which the sheet has a branch point."""
    zeros = field.hopf.zeros
    where = panel_of_cell[cells_of_vertices(field.sheet.domain, lines, cells)[zeros]]
    orders = np.bincount(where, field.hopf.orders, count).astype(np.int64)
    return orders, np.unique(where[branch_points(field.sheet, zeros)])


def branch_points(sheet: Sheet, zeros: Int) -> NDArray[np.bool_]:
    """Which zeros of q are branch points of f±: where <N, N_x × N_y> < 0. At H = 0 and on g none are."""
    if sheet.mean_curvature == 0.0 or sheet.name == "g":
        return np.zeros(len(zeros), dtype=bool)
    nx, ny = gradients(sheet.domain, sheet.normals)
    middle = sheet.normals[sheet.domain.faces].mean(axis=1)
    turned = np.einsum("fi,fi->f", middle, np.cross(nx, ny)) * sheet.domain.face_areas
    around = np.bincount(sheet.domain.faces.ravel(), np.repeat(turned, 3), sheet.domain.vertex_count)
    return around[zeros] < 0.0


def _larger_curvature(field: LineField, cells: Cells) -> Array:
    """k1 (n,) = H + ½ |Q| / e^{2u} at the nodes."""
    q = np.einsum("nk,nk->n", cells.barycentric, field.hopf.at_corners[cells.faces])
    return field.sheet.mean_curvature + 0.5 * np.abs(q) / field.sheet.metric[cells.faces]


def mean_deviation(coordinates: Quantised) -> float:
    """The mean angle, in radians, between ∂w of whole numbers and √q, panels counted alike."""
    cut = coordinates.isothermic.cut
    slopes = shape_gradients(cut.domain)
    w = (coordinates.values * coordinates.spacings)[cut.faces]
    # ∂_z of u + iv is half the conjugate of its gradients: u_x - i u_y + i (v_x - i v_y)
    derivative = np.einsum("fk,fk->f", slopes.conj(), w[..., 0] + 1j * w[..., 1])
    z = cut.domain.layout[:, 2] - cut.domain.layout[:, 1]
    exact = coordinates.isothermic.omega[:, 0] / (z[:, 0] + 1j * z[:, 1])
    weights = np.abs(exact) ** 2 * cut.domain.face_areas
    return float(weights @ np.abs(np.angle(derivative / exact)) / weights.sum())
