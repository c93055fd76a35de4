"""Boundary conditions: what the tangent planes do along the boundary.

A condition fixes the normals N at some sites. Conditions are combined with `+`; where two of them fix the same
site, it gets the normalised sum of their normals. Sites of which nothing is said are free: there the natural
condition ∂N/∂ν = 0 holds by itself (paper, Sec. 5.1).

Conditions along boundary edges serve every kind of site. With normals at vertices they hold at the vertices of the
edges. With normals at faces an edge fixes the normal of the face behind it, to what holds in the middle of the edge:
half a triangle further in (paper, Fig. 7, bottom). The shell then answers to a plan that is narrower by that much, a
first-order change, and a rough one where the triangles are irregular. With "faces_and_rim" the condition holds in the
middle of the edge itself, half-way between the face and its mirror image, and the face is free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, plural
from ..linalg import as_numbers, sum_rows
from .frames import (
    EdgeFrames,
    Frames,
    area_vectors,
    at_ends,
    blend,
    boundary_edges,
    check_range,
    edge_frames,
    in_space,
    loop_angles,
    of_boundary,
    unit,
    unit_rows,
    vertex_frames,
)

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def _none() -> Int:
    return np.zeros(0, dtype=np.int64)


def _no_normals() -> Array:
    return np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Conditions:
    """Prescribed unit normals, not yet combined: owners (n,) may repeat.

    vertices, vertex_normals: at vertices. edges, edge_normals: the same conditions in the middle of boundary edges.
    faces, face_normals: at faces, prescribed one by one. only_vertices: those of `vertices` that were prescribed one
    by one and so say nothing about faces.
    up: (3,) the oriented area vector of the positions the conditions were made from, zero if there were none: the
    side to which data that lie in one plane bulge (see `initial`).
    """

    vertices: Int = field(default_factory=_none)
    vertex_normals: Array = field(default_factory=_no_normals)
    edges: Int = field(default_factory=_none)
    edge_normals: Array = field(default_factory=_no_normals)
    faces: Int = field(default_factory=_none)
    face_normals: Array = field(default_factory=_no_normals)
    only_vertices: Int = field(default_factory=_none)
    up: Array = field(default_factory=lambda: np.zeros(3))

    def __add__(self, other: Conditions) -> Conditions:
        names = [item.name for item in fields(self) if item.name != "up"]
        joined = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names}
        # conditions on one surface all say the same; a sum would only change the length
        return Conditions(**joined, up=self.up if self.up.any() else other.up)

    @property
    def is_empty(self) -> bool:
        """Whether every site is free."""
        return not (self.vertices.size or self.edges.size or self.faces.size)

    def resolve(self, sites: str = "vertices", owners: Int | None = None) -> tuple[Int, Array]:
        """Sorted fixed sites (n,) and the one unit normal (n, 3) of each, with normals at vertices or at faces.

        owners: (E,) the site that each boundary edge fixes, needed where they are not at vertices. Raises
        `ConditionError` naming the sites whose normals cancel, or normals prescribed one by one at the other kind of
        site.
        """
        if sites == "vertices":
            self._refuse(self.faces, "face", "faces", "vertices")
            return blend(self.vertices, self.vertex_normals, np.ones(len(self.vertices)), "conditions")
        self._refuse(self.only_vertices, "vertex", "vertices", sites)
        if owners is None:
            raise ConditionError("Where normals live on faces, the sites that boundary edges fix are needed.")
        edges, edge_normals = blend(self.edges, self.edge_normals, np.ones(len(self.edges)), "conditions", "edge")
        fixed = np.concatenate([of_boundary(edges, owners), self.faces])
        normals = np.concatenate([edge_normals, self.face_normals])
        return blend(fixed, normals, np.ones(len(fixed)), "conditions", "face")

    def carried(self, edges: Int) -> Conditions:
        """The same on another triangulation of the domain, `edges` (E,) being the boundary edges there.

        Raises `ConditionError` for normals prescribed at faces one by one, since those faces are gone.
        """
        if self.faces.size:
            raise ConditionError(
                f"Normals are prescribed at {plural('face', np.unique(self.faces))}, which the Delaunay triangulation "
                "does not have; prescribe them along boundary edges, or solve with delaunay=False.",
                faces=self.faces,
            )
        return replace(self, edges=of_boundary(self.edges, edges))

    def _refuse(self, single: Int, noun: str, given: str, wanted: str) -> None:
        if single.size:
            raise ConditionError(
                f"Normals are prescribed at {plural(noun, np.unique(single))}, but live on {wanted} here; solve with "
                f"sites={given!r}, or prescribe them along boundary edges.",
                **{given: single},
            )


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
    return Conditions(*at_ends(domain, chosen, normals, np.ones(len(chosen))), chosen, normals)


def fixed_at(domain: Domain, vertices: ArrayLike, normals: ArrayLike) -> Conditions:
    """Normals (n, 3), or one for all (3,), at vertices (n,), inside or on the boundary; not for normals on faces."""
    sites = _indices(vertices, domain.vertex_count, "vertex", "Vertices")
    return Conditions(sites, unit(normals, sites, "vertex"), only_vertices=sites)


def fixed_at_faces(domain: Domain, faces: ArrayLike, normals: ArrayLike) -> Conditions:
    """Normals (n, 3), or one for all (3,), at faces (n,), inside or on the boundary, where normals live on faces."""
    sites = _indices(faces, len(domain.faces), "face", "Faces")
    return Conditions(faces=sites, face_normals=unit(normals, sites, "face"))


def _indices(given: ArrayLike, count: int, noun: str, what: str) -> Int:
    try:
        indices = np.atleast_1d(np.asarray(given))
    except ValueError:
        raise ConditionError(f"{what} must be indices (n,), not lists of several lengths.") from None
    if indices.ndim != 1 or (indices.size and not np.issubdtype(indices.dtype, np.integer)):
        raise ConditionError(f"{what} must be indices (n,), not {indices.dtype} {indices.shape}.")
    indices = indices.astype(np.int64)
    check_range(indices, count, noun)
    return indices


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
    tilts = np.broadcast_to(tilts, chosen.shape)
    along = edge_frames(domain, positions, chosen)
    frames = vertex_frames(domain, chosen, along)
    return _tilted(chosen, along, tilts, frames, frames.mean(tilts))


def twisted(domain: Domain, positions: ArrayLike, edges: ArrayLike, m: float) -> Conditions:
    """The outward conormal turned by m θ around the boundary tangent (paper, Fig. 3), towards the surface
    normal.

    θ = 2π × arc length along the loop from its first listed vertex, as a part of the loop's length.
    """
    if not np.isfinite(m):
        raise ConditionError(f"The number of twists must be finite, not {m}.")
    chosen = boundary_edges(domain, edges)
    along = edge_frames(domain, positions, chosen)
    frames = vertex_frames(domain, chosen, along)
    angles, middles = loop_angles(domain)
    return _tilted(chosen, along, m * middles[chosen], frames, m * angles[frames.vertices])


def _tilted(edges: Int, along: EdgeFrames, tilts: Array, frames: Frames, angles: Array) -> Conditions:
    """cos(tilt) conormal + sin(tilt) normal, with a tilt (K,) for each edge and an angle (n,) for each vertex."""
    return Conditions(
        frames.vertices,
        _turned(frames.conormals, frames.normals, angles),
        edges,
        _turned(along.conormals, along.normals, tilts),
        up=along.up,
    )


def _turned(conormals: Array, normals: Array, angles: Array) -> Array:
    return np.cos(angles)[:, None] * conormals + np.sin(angles)[:, None] * normals


def gauss_map(domain: Domain, positions: ArrayLike, edges: ArrayLike) -> Conditions:
    """The normals of the surface `positions` (V, 2|3) itself along boundary edges.

    At a vertex the mean over its faces, weighted by their angles there; at a face its own.
    """
    chosen = boundary_edges(domain, edges)
    points = in_space(domain, positions)
    faces = domain.faces
    face_normals = unit_rows(area_vectors(points, faces), "face", "has no area in these positions")
    weighted = face_normals[:, None, :] * domain.corner_angles[:, :, None]
    sums = sum_rows(faces.ravel(), weighted.reshape(-1, 3), domain.vertex_count)
    sites = np.unique(domain.edges[chosen]).astype(np.int64)
    normals = unit_rows(sums[sites], "vertex", "has faces whose normals cancel", sites)
    behind = face_normals[domain.edge_faces[chosen, 0]]
    return Conditions(sites, normals, chosen, behind, up=area_vectors(points, faces).sum(axis=0))


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
