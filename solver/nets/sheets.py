"""The sheet of a surface on which a net is made: a domain, points and normals, whatever the surface came from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, MeshError, check_choice
from ..fitting.fit import Fit
from ..surface.cmc_surface import CmcSurface, SurfaceLike, as_surface

Array = NDArray[np.float64]

NET_SHEETS = ("f+", "f-", "g")


@runtime_checkable
class PlacedSurface(Protocol):
    """A shell: points and normals of its sheets in the world, and the surface behind it."""

    surface: CmcSurface
    placed: dict[str, Array]
    normals: dict[str, Array]
    faces: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Sheet:
    """Points (V, 3) of f+, f- or g on their domain, and the unit normals N (V, 3) with which H is positive on f±.

    domain: conformal to f±; where a surface is cut open, cut open like it. mean_curvature: H of f±, with its sign.
    normals: those of the sheet, -N on f-. pair: points and normals of f+ and f-, as far as they are no points; empty
    where the sheet stands alone.
    """

    domain: Domain
    points: Array
    normals: Array
    mean_curvature: float
    name: str = "f+"
    pair: tuple[tuple[Array, Array], ...] = ()

    @property
    def sheets(self) -> tuple[tuple[Array, Array], ...]:
        """Points and normals of f+ and f-, which have one Hopf differential."""
        return self.pair or ((self.points, self.normals),)

    @cached_property
    def metric(self) -> Array:
        """e^{2u} (F,) of the sheet, ½ |df|², in squared model lengths over those of the domain."""
        fx, fy = gradients(self.domain, self.points)
        return 0.5 * ((fx**2).sum(axis=1) + (fy**2).sum(axis=1))


def gradients(domain: Domain, values: Array) -> tuple[Array, Array]:
    """∂x and ∂y (F, k) of the linear interpolation of `values` (V, k), in the layout of each face."""
    corner = values[domain.faces]
    slopes = shape_gradients(domain)
    return np.einsum("fk,fkd->fd", slopes.real, corner), np.einsum("fk,fkd->fd", slopes.imag, corner)


def shape_gradients(domain: Domain) -> NDArray[np.complex128]:
    """∇λ (F, 3) of the barycentric coordinates as complex numbers x + iy in the layout of each face."""
    z = layout(domain)
    opposite = z[:, [2, 0, 1]] - z[:, [1, 2, 0]]
    return 1j * opposite / (2.0 * domain.face_areas[:, None])


def layout(domain: Domain) -> NDArray[np.complex128]:
    """The corners (F, 3) of each face in its own plane, as complex numbers; see `Domain.layout`."""
    return domain.layout[..., 0] + 1j * domain.layout[..., 1]


def sheet_of(given: SurfaceLike | PlacedSurface | Fit | Sheet, name: str) -> Sheet:
    """The sheet "f+", "f-" or "g" of a `CmcSurface`, `Span`, `Fit` or `Shell`, in its place.

    Raises `ConditionError` where that sheet is a point, or where all normals are the same.
    """
    check_choice(name, NET_SHEETS, "sheet of a net")
    if isinstance(given, Sheet):
        return given
    if isinstance(given, Fit):
        points = {one: given.points(one) for one in NET_SHEETS}
        normals = {one: given.normals(one) for one in NET_SHEETS}
        surface = given.surface
        mean_curvature = given.sign * surface.mean_curvature
    elif isinstance(given, PlacedSurface) and not isinstance(given, CmcSurface):
        points, normals, surface = given.placed, given.normals, given.surface
        mean_curvature = _placed_curvature(surface, points)
    else:
        surface = as_surface(given)
        points = {one: surface.sheet(one) for one in NET_SHEETS}
        normals = {one: surface.sheet_normals(one) for one in NET_SHEETS}
        mean_curvature = surface.mean_curvature
    usable = [one for one in ("f+", "f-") if one in points and not surface.is_degenerate(one)]
    if name not in points or (name != "g" and name not in usable):
        raise ConditionError(f"The sheet {name} of this surface is a point and carries no net; choose another one.")
    if not usable:
        raise ConditionError("Both sheets of this surface are points; there is nothing to put a net on.")
    pair = tuple((points[one], normals[one]) for one in usable)
    return Sheet(_cut_domain(surface), points[name], normals[name], mean_curvature, name, pair)


def _placed_curvature(surface: CmcSurface, points: dict[str, Array]) -> float:
    """H in the world: the surface's over the scale of the similarity that placed it."""
    name = next(iter(points))
    own, placed = (float(np.linalg.norm(one - one.mean(axis=0))) for one in (surface.sheet(name), points[name]))
    return surface.mean_curvature * own / placed if placed else surface.mean_curvature


def _cut_domain(surface: CmcSurface) -> Domain:
    """The domain of the surface's own vertices: cut open where the surface is."""
    if not surface.is_open:
        return surface.domain
    return Domain.from_edge_lengths(surface.faces, surface.domain.side_lengths)


def check_no_handles(domain: Domain) -> None:
    """Raise `MeshError` on handles and on closed domains, which nets do not know."""
    if domain.genus:
        handles = "a handle" if domain.genus == 1 else f"{domain.genus} handles"
        raise MeshError(
            f"The surface has {handles}, around which a net would need whole numbers of panels that are not found yet; "
            "make the net of one module and complete it by its mirrors."
        )
    if not len(domain.boundary_loops):
        raise MeshError("The surface is closed; nets need a rim: take a part of it.")

