"""The coordinates behind lines and panels: from a surface and a spacing to w in whole numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError, check_choice
from ..fitting.fit import Fit
from ..limits import POSITIVE, Range, check_number
from ..signatures import checked
from ..surface.cmc_surface import SurfaceLike
from .cut import cut_domain
from .hopf import HopfDifferential, hopf_differential
from .isothermic import Isothermic
from .quantise import Quantised, quantised
from .sheets import PlacedSurface, Sheet, shape_gradients, sheet_of
from .sides import LineSide, line_sides
from .tracing import Lines, traced

Array = NDArray[np.float64]
Int = NDArray[np.integer]

KINDS = {
    "principal": "Lines of principal curvature: almost flat, almost rectangular panels",
    "diagonal": "Lines half-way between them, of normal curvature H: beams of one radius, twisted panels",
}

_COUNT = Range(1, 1_000_000, whole=True)
# No net has more lines across than vertices of the mesh would carry: crossings are at most this many a triangle.
_MOST_A_FACE = 40


@dataclass(frozen=True, eq=False)
class LineField:
    """The coordinates behind a net: a sheet, its Hopf differential, w, and w as whole numbers.

    sides: that are lines of the net. kind: of net. spacing: the wanted side in model length; step: in units of w.
    """

    sheet: Sheet
    hopf: HopfDifferential
    coordinates: Quantised
    sides: list[LineSide]
    kind: str
    spacing: float
    step: float

    @cached_property
    def lines(self) -> Lines:
        """The lines at whole numbers. Raises `ConditionError` where none crosses the surface."""
        lines = traced(self.coordinates.isothermic.cut, self.coordinates.values)
        if not len(lines.family):
            raise ConditionError(
                f"No line crosses the surface at a spacing of {self.spacing:.3g}; choose a smaller one, or more panels."
            )
        return lines

    def scaled(self, factor: float) -> LineField:
        """The field of lines that are `factor` times as far apart."""
        step = factor * self.step
        coordinates = quantised(self.coordinates.isothermic, step, self.sides)
        return replace(self, coordinates=coordinates, spacing=factor * self.spacing, step=step)

    @cached_property
    def on_line(self) -> NDArray[np.bool_]:
        """(E,) the boundary edges that are on a line of the net."""
        found = np.zeros(len(self.sheet.domain.edge_lengths), dtype=bool)
        for side in self.sides:
            found[side.edges] = True
        return found

    def half_difference(self, faces: Int, barycentric: Array) -> Array:
        """½ (k1 - k2) (n,) = ½ |Q| / e^{2u} at places (n, 3) on faces (n,)."""
        q = np.einsum("nk,nk->n", barycentric, self.hopf.at_corners[faces])
        return 0.5 * np.abs(q) / self.sheet.metric[faces]


def line_field(
    surface: SurfaceLike | PlacedSurface | Fit | Sheet,
    spacing: float | None,
    count: int | None,
    kind: str,
    sheet: str,
    quantise: bool = True,
    known: Int | None = None,
) -> LineField:
    """Checked arguments, and the coordinates of a net; see `panel_net`. known: as in `line_sides`."""
    check_choice(kind, KINDS, "kind of net")
    _check_size(spacing, count)
    on = sheet_of(surface, sheet)
    hopf = hopf_differential(on)
    cut = cut_domain(hopf)
    step, side = _steps(on, hopf, spacing, count)
    isothermic = Isothermic.of(cut, 0.25 * np.pi if kind == "diagonal" else 0.0)
    sides = [] if kind == "diagonal" else line_sides(hopf, cut, known)
    return LineField(on, hopf, quantised(isothermic, step, sides, exact=not quantise), sides, kind, side, step)


@dataclass(frozen=True)
class NetPreview:
    """What a net will be like, before it is made: about how many panels, and their sides.

    spacing: the median side. sides: those that 5 % and 95 % of the panels are below. sphere_gap: w² / 16, how far each
    panel will depart from the sphere of radius 1 / |H|.
    """

    panels: int
    spacing: float
    sides: tuple[float, float]
    sphere_gap: float


@checked
def preview_net(
    surface: SurfaceLike | PlacedSurface | Fit,
    spacing: float | None = None,
    *,
    count: int | None = None,
    sheet: str = "f+",
) -> NetPreview:
    """The numbers of a net from its Hopf differential alone: sides are w / √(k1 - k2).

    Arguments and errors as `panel_net`. The lines are rounded to whole numbers afterwards, by up to 18 %, and the rim
    adds panels that it cuts.
    """
    _check_size(spacing, count)
    on = sheet_of(surface, sheet)
    hopf = hopf_differential(on)
    step, side = _steps(on, hopf, spacing, count)
    sides = step / np.sqrt(np.abs(hopf.at_faces) / on.metric)
    panels = np.abs(hopf.at_faces) * on.domain.face_areas
    order = np.argsort(sides)
    share = np.cumsum(panels[order]) / panels.sum()
    low, high = (float(sides[order[np.searchsorted(share, part)]]) for part in (0.05, 0.95))
    return NetPreview(max(1, round(float(panels.sum()) / step**2)), side, (low, high), step**2 / 16.0)


def _check_size(spacing: float | None, count: int | None) -> None:
    if (spacing is None) == (count is None):
        raise ConditionError("Give either the spacing of a net or the count of its panels.")
    if spacing is not None:
        check_number(spacing, "spacing", POSITIVE)
    if count is not None:
        check_number(count, "count of panels", _COUNT)


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
            f"The net would have more than {most:,} panels, {_MOST_A_FACE} in a triangle of the mesh; choose a spacing "
            f"of at least {np.sqrt(panels.sum() / most) / median:.3g}, or refine the mesh."
        )
    return step, step / median


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
