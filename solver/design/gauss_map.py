"""The CMC surface whose tangent planes are nearest to those of a given surface (paper, Sec. 5.2, Figures 10, 11)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..gauss.conditions import Conditions, gauss_map
from ..gauss.frames import area_vectors, in_space, unit_rows
from ..linalg import sum_rows
from ..surface.placement import procrustes
from ..surface.solve import CmcSolver
from .fit import Fit, Progress, Start, fit
from .targets import GaussMap, SmoothRim

Array = NDArray[np.float64]


def fit_gauss_map(
    domain: Domain,
    positions: ArrayLike,
    regularisation: float = 1e-3,
    *,
    max_evaluations: int = 200,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Minimise ½ ∫ |N - N_φ|² + λ ½ ∮ |dN₀|² over the boundary normals N₀, λ = `regularisation` >= 0.

    Both terms are without unit: the domain has area one, the boundary length one. positions: (V, 3) of the surface φ
    on the vertices of the domain, by which it is also sized and placed: least squares over its area, scale and shift
    only, since the tangent planes are what was fitted. Of f± the one that comes nearer is the sheet of the result.
    """
    if not (np.isfinite(regularisation) and regularisation >= 0.0):
        raise ConditionError(f"The regularisation must be a number from 0 on, not {regularisation}.")
    points = in_space(domain, positions)
    normals = vertex_normals(domain, points)
    rim = gauss_map(domain, points, domain.boundary_edges)
    conditions = Conditions(rim.vertices, rim.vertex_normals, up=rim.up)
    targets = [GaussMap(normals), SmoothRim(weight=regularisation)]
    start = Start(conditions, 1.0, np.zeros(3), normals)
    found = fit(
        domain,
        targets,
        start,
        size=1.0,
        free_scale=False,
        free_shift=False,
        max_evaluations=max_evaluations,
        solver=solver,
        progress=progress,
    )
    return _placed(found, points)


def vertex_normals(domain: Domain, points: Array) -> Array:
    """Unit normals (V, 3) of a surface, its faces weighted by their angles at each vertex."""
    faces = domain.faces
    of_faces = unit_rows(area_vectors(points, faces), "face", "has no area in these positions")
    weighted = of_faces[:, None, :] * domain.corner_angles[:, :, None]
    sums = sum_rows(faces.ravel(), weighted.reshape(-1, 3), domain.vertex_count)
    return unit_rows(sums, "vertex", "has faces whose normals cancel")


def _placed(found: Fit, points: Array) -> Fit:
    """The fit over the surface it was fitted to; a negative scale is a reflection in a point."""
    surface = found.surface
    weights = surface.domain.vertex_areas[surface.source]
    goals = points[surface.source]
    best = None
    for sheet in ("f+", "f-"):
        if surface.is_degenerate(sheet):
            continue
        scale, _, shift = procrustes(surface.sheet(sheet), goals, weights)
        miss = scale * surface.sheet(sheet) + shift - goals
        error = float(np.einsum("n,ni,ni->", weights, miss, miss))
        if best is None or error < best[0]:
            best = error, sheet, scale, shift
    if best is None:
        raise ConditionError("The surface is flat or a point: no CMC surface of finite size has its tangent planes.")
    _, sheet, scale, shift = best
    size = abs(scale)
    surface = replace(
        surface,
        g=size * surface.g,
        f_plus=size * surface.f_plus,
        f_minus=size * surface.f_minus,
        scale=size * surface.scale,
        periods=size * surface.periods,
    )
    return replace(found, surface=surface, shift=shift, sheet=sheet, sign=float(np.sign(scale)))
