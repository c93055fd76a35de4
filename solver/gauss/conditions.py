"""Boundary conditions: what the tangent planes do along the boundary.

A condition fixes the normals N at some sites (here: vertices). Conditions are combined with `+`; where two of
them fix the same vertex, it gets the normalised sum of their normals. Sites of which nothing is said are
free: there the natural condition ∂N/∂ν = 0 holds by itself (paper, Sec. 5.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..linalg import as_numbers, sum_rows
from .frames import (
    Frames,
    area_vectors,
    at_ends,
    blend,
    boundary_edges,
    check_range,
    in_space,
    loop_angles,
    unit,
    unit_rows,
    vertex_frames,
)

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Conditions:
    """Prescribed normals, not yet combined: `sites` (n,) may repeat, `normals` (n, 3) are unit vectors.

    `up` (3,) is the oriented area vector of the positions the conditions were made from, zero if there were
    none: the side to which data that lie in one plane bulge (see `initial`).
    """

    sites: Int = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    normals: Array = field(default_factory=lambda: np.zeros((0, 3)))
    up: Array = field(default_factory=lambda: np.zeros(3))

    def __add__(self, other: Conditions) -> Conditions:
        return Conditions(
            np.concatenate([self.sites, other.sites]),
            np.concatenate([self.normals, other.normals]),
            # conditions on one surface all say the same; a sum would only change the length
            self.up if self.up.any() else other.up,
        )

    def resolve(self) -> tuple[Int, Array]:
        """Sorted fixed sites (n,) and the one unit normal (n, 3) of each.

        Raises `ConditionError` naming the sites whose normals cancel.
        """
        return blend(self.sites, self.normals, np.ones(len(self.sites)), "conditions")


@dataclass(frozen=True)
class Parameter:
    """A number or vector of a kind of condition, as a user interface shows it."""

    name: str
    label: str
    description: str
    default: float | tuple[float, ...]
    unit: str = ""


@dataclass(frozen=True)
class Kind:
    """A kind of condition, as a user interface offers it."""

    label: str
    description: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Conditions] = field(repr=False)


def fixed(domain: Domain, edges: ArrayLike, normal: ArrayLike) -> Conditions:
    """A constant normal (3,) along boundary edges, or one an edge (K, 3): the surface touches a plane there.

    `edges` are indices into `domain.edges` or (K, 2) vertex pairs. A vertex between two edges gets the
    normalised sum.
    """
    chosen = boundary_edges(domain, edges)
    normals = unit(normal, chosen, "edge")
    return Conditions(*at_ends(domain, chosen, normals, np.ones(len(chosen))))


def fixed_at(domain: Domain, vertices: ArrayLike, normals: ArrayLike) -> Conditions:
    """Normals (n, 3), or one for all (3,), at vertices (n,), inside or on the boundary."""
    given = np.atleast_1d(np.asarray(vertices))
    if given.ndim != 1 or (given.size and not np.issubdtype(given.dtype, np.integer)):
        raise ConditionError(f"Vertices must be indices (n,), not {given.dtype} {given.shape}.")
    sites = given.astype(np.int64)
    check_range(sites, domain.vertex_count, "vertex")
    return Conditions(sites, unit(normals, sites, "vertex"))


def binormal(domain: Domain, positions: ArrayLike, edges: ArrayLike, tilt: ArrayLike = 0.0) -> Conditions:
    """The outward conormal of the surface `positions` (V, 2|3) along boundary edges, tilted by `tilt` radians.

    N = cos(tilt) t × n + sin(tilt) n with t the edge direction and n the normal of the face behind the edge (paper,
    Fig. 2 and 3): 0 makes the new surface meet the old one at a right angle, +π/2 makes it tangent. `tilt` is one
    angle, or one an edge (K,). At a vertex between edges of length a and b, t × n, n and the tilts are first blended
    with weights 1/a and 1/b, which is second order where the boundary is smooth; one tilt for all is exact everywhere.
    """
    chosen = boundary_edges(domain, edges)
    tilts = as_numbers(tilt, "Tilts", ConditionError)
    if tilts.shape not in ((), chosen.shape) or not np.isfinite(tilts).all():
        raise ConditionError(f"The tilt must be a finite angle, or {len(chosen)} of them, one for each edge.")
    frames = vertex_frames(domain, positions, chosen)
    return _tilted(frames, frames.mean(np.broadcast_to(tilts, chosen.shape)))


def twisted(domain: Domain, positions: ArrayLike, edges: ArrayLike, m: float) -> Conditions:
    """The outward conormal turned by m θ around the boundary tangent (paper, Fig. 3), towards the surface
    normal.

    θ = 2π × arc length along the loop from its first listed vertex, as a part of the loop's length.
    """
    if not np.isfinite(m):
        raise ConditionError(f"The number of twists must be finite, not {m}.")
    frames = vertex_frames(domain, positions, boundary_edges(domain, edges))
    return _tilted(frames, m * loop_angles(domain)[frames.vertices])


def _tilted(frames: Frames, angle: Array) -> Conditions:
    """cos(angle) conormal + sin(angle) normal, with an angle (n,) for each vertex."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return Conditions(frames.vertices, cosine * frames.conormals + sine * frames.normals, frames.up)


def gauss_map(domain: Domain, positions: ArrayLike, edges: ArrayLike) -> Conditions:
    """The normals of the surface `positions` (V, 2|3) itself at the vertices of boundary edges, weighted by angle."""
    chosen = boundary_edges(domain, edges)
    points = in_space(domain, positions)
    faces = domain.faces
    face_normals = unit_rows(area_vectors(points, faces), "face", "has no area in these positions")
    weighted = face_normals[:, None, :] * domain.corner_angles[:, :, None]
    sums = sum_rows(faces.ravel(), weighted.reshape(-1, 3), domain.vertex_count)
    sites = np.unique(domain.edges[chosen]).astype(np.int64)
    normals = unit_rows(sums[sites], "vertex", "has faces whose normals cancel", sites)
    return Conditions(sites, normals, area_vectors(points, faces).sum(axis=0))


def free(domain: Domain, edges: ArrayLike) -> Conditions:
    """Nothing is prescribed along boundary edges: the natural condition ∂N/∂ν = 0. (Edges are checked all the same.)"""
    boundary_edges(domain, edges)
    return Conditions()


KINDS: dict[str, Kind] = {
    "binormal": Kind(
        "Outward, tilted",
        "The tangent plane leans by an angle: 0° stands vertically on the plan, 90° lies flat in it",
        (Parameter("tilt", "Angle", "0° is a vertical rim that leans neither way, 90° is flat", 0.0, "radians"),),
        lambda domain, positions, edges, tilt=0.0: binormal(domain, positions, edges, tilt),
    ),
    "plane": Kind(
        "Constant plane",
        "The surface touches one plane along these edges",
        (Parameter("normal", "Normal", "Normal of the plane, pointing out of the surface", (0.0, 0.0, 1.0)),),
        lambda domain, positions, edges, normal=(0.0, 0.0, 1.0): fixed(domain, edges, normal),
    ),
    "twisted": Kind(
        "Twisted",
        "The tangent plane turns around the boundary as one walks along it",
        (Parameter("m", "Turns", "Full turns of the tangent plane in one walk around the loop", 1.0),),
        lambda domain, positions, edges, m=1.0: twisted(domain, positions, edges, m),
    ),
    "gauss_map": Kind(
        "As drawn",
        "The surface keeps the tangent planes of the drawn mesh along these edges",
        (),
        lambda domain, positions, edges: gauss_map(domain, positions, edges),
    ),
    "free": Kind(
        "Free",
        "Nothing is prescribed; the normals settle by themselves",
        (),
        lambda domain, positions, edges: free(domain, edges),
    ),
}


def build(kind: str, domain: Domain, positions: ArrayLike, edges: ArrayLike, **parameters: object) -> Conditions:
    """The condition named `kind` in `KINDS`, with that kind's parameters (angles in radians)."""
    if kind not in KINDS:
        raise ConditionError(f"There is no boundary condition called {kind!r}; known are {', '.join(KINDS)}.")
    known = {parameter.name for parameter in KINDS[kind].parameters}
    unknown = sorted(set(parameters) - known)
    if unknown:
        raise ConditionError(
            f"The boundary condition {kind!r} has no parameter {', '.join(unknown)}; "
            f"it has {', '.join(sorted(known)) or 'none'}."
        )
    return KINDS[kind].make(domain, positions, edges, **parameters)
