"""A span as a fit: the exact surface on its lines in the fields of a `Fit`, and the start of a search from it.

Goals that ask for no more than a rim on its lines and one number need no search over boundary normals: the span is the
surface. Other goals are near it, so a search starts there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import Status
from ..spanning.span import Span
from ..spanning.verdict import SpanStatus
from ..surface.cmc_surface import CmcSurface
from .fit import Fit, FitStatus, Start
from .sides import Sides, opposite
from .target import Shape, Target

Array = NDArray[np.float64]

_STATUS = {SpanStatus.CONVERGED: FitStatus.CONVERGED, SpanStatus.CANCELLED: FitStatus.CANCELLED}


def spanned_fit(
    span: Span, targets: Sequence[Target], *, size: float, sheet: str = "f+", base: float = 0.0
) -> Fit:
    """The span as that sheet of a fit. Its distances are from `targets`, whose heights are over `base`."""
    surface, shift, sign = _seated(span)
    conditions = span.conditions
    if sheet == "f-":
        surface, conditions = _turned(surface), opposite(conditions)
    points, rim = span.points - [0.0, 0.0, base], span.domain.boundary_vertices.astype(np.int64)
    shape = Shape(span.domain, rim, points, span.normals, size)
    return Fit(
        surface=surface,
        shift=shift,
        conditions=conditions,
        distances={target.label: target.distance(shape) for target in targets},
        value=sum(target.weight * target.partials(shape).value for target in targets),
        status=_STATUS.get(span.status, FitStatus.NO_SURFACE),
        history=[step.residual for step in span.history],
        sheet=sheet,
        sign=sign,
        unmet=() if span.ok else (span.message,),
        span=span,
    )


def start_from(span: Span, sides: Sides, *, sheet: str, least: float, base: float = 0.0) -> Start:
    """The start of a search at the span, with heights over `base`, and with the normals that `sides` give.

    least: the mean curvature of the flattest start, since f± = (g ± N) / 2H.
    """
    side = -1.0 if sheet == "f-" else 1.0
    scale = 0.5 / max(span.mean_curvature, least)
    g = (span.points - scale * span.normals)[span.domain.boundary_vertices]
    N = side * span.normals
    shift = g.mean(axis=0) - [0.0, 0.0, base]
    return Start(sides.conditions(N), scale, shift, N, held=sides.held)


def _seated(span: Span) -> tuple[CmcSurface, Array, float]:
    """The surface with g centred, H >= 0; the shift and the sign that take it to its place.

    It closes around each hole: a period of zero. The surface of the largest H, in place of one that does not exist, is
    as good as any.
    """
    surface, sign = span.as_surface, -1.0 if span.mean_curvature < 0.0 else 1.0
    if span.kept.largest is not None:
        surface = replace(surface, harmonic=replace(surface.harmonic, status=Status.CONVERGED))
    shift = surface.g[span.domain.boundary_vertices].mean(axis=0)
    seated = replace(
        surface,
        centre=surface.centre + shift / surface.scale,
        g=sign * (surface.g - shift),
        f_plus=sign * (surface.f_plus - shift),
        f_minus=sign * (surface.f_minus - shift),
        scale=sign * surface.scale,
        periods=np.zeros((len(span.domain.boundary_loops) - 1, 3)),
    )
    return seated, shift, sign


def _turned(surface: CmcSurface) -> CmcSurface:
    """The same surface as f-: of the opposite map, whose g is the same."""
    harmonic = replace(surface.harmonic, normals=-surface.harmonic.normals)
    return replace(
        surface, harmonic=harmonic, f_plus=surface.f_minus, f_minus=surface.f_plus, normals=-surface.normals
    )
