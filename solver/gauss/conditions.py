"""Boundary conditions: what the tangent planes do along the boundary.

A condition fixes the normals N at some sites, or holds them to a plane with normal ν (a mirror, N · ν = 0; paper, Sec.
5.1.1). Conditions are combined with `+`. Where kinds meet at a site, fixed goes before mirror before free: two normals
that fix it blend to their normalised sum, as a normal does with its reflection; two mirrors leave N = ±ν₁ × ν₂. Sites
of which nothing is said are free: there the natural condition ∂N/∂ν = 0 holds by itself (paper, Sec. 5.1).

Conditions along boundary edges serve every kind of site. With normals at vertices they hold at the vertices of the
edges. With normals at faces an edge fixes the normal of the face behind it, to what holds in the middle of the edge:
half a triangle further in (paper, Fig. 7, bottom). The shell then answers to a plan that is narrower by that much, a
first-order change, and a rough one where the triangles are irregular. With "faces_and_rim" the condition holds in the
middle of the edge itself, half-way between the face and its mirror image, and the face is free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..linalg import as_numbers, sum_rows
from .boundary_data import Conditions
from .frames import (
    EdgeFrames,
    Frames,
    area_vectors,
    at_ends,
    boundary_edges,
    check_range,
    edge_frames,
    in_space,
    loop_angles,
    unit,
    unit_rows,
    vertex_frames,
)

Array = NDArray[np.float64]
Int = NDArray[np.integer]


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


def mirror(domain: Domain, edges: ArrayLike, plane_normal: ArrayLike, winding: float = 0) -> Conditions:
    """Along boundary edges the surface meets a plane with this normal ν (3,) at right angles: N · ν = 0 (paper,
    Sec. 5.1.1), while N is free to turn within the plane.

    The surface goes on as its own reflection (Schwarz). Where two mirrors meet, N = ±ν₁ × ν₂. The sign is that of an
    `initial` map where there is one. If not, it is the one on the upper side of the plan, if other conditions know one
    and it is not in its plane; else the one that belongs to plane normals which point out of f+: around a corner of
    less than 180°, the product of ν of the edges that arrive and of those that leave, the domain being on their left.
    `side=-1` is the other one. `corner` overrides it all. Where a mirror meets a condition that fixes the normals along
    edges, that one wins; at their common vertex it blends with its reflection, unless it is nearer to ν than to the
    plane.

    winding: of the start. Along a side N turns about ν from the normal at its first end to that at its last by the
    smaller angle (where they are opposite, over the upper side, or else as on a convex side if ν points outwards), and
    by so many full turns more; around a whole loop, by so many.
    With normals at faces the constraint is on the face behind the edge, first order as it is for fixed normals; with
    "faces_and_rim" it is on the edge's own site, and as exact as at vertices.
    """
    chosen = boundary_edges(domain, edges)
    normals = unit(_vector(plane_normal), chosen, "edge")
    if not isinstance(winding, (int, float, np.number)) or not float(winding).is_integer():
        raise ConditionError(f"The winding must be a whole number of turns, not {winding!r}.")
    turns = np.full(len(chosen), int(winding), dtype=np.int64)
    return Conditions(mirrors=chosen, mirror_normals=normals, windings=turns)


def corner(domain: Domain, vertices: ArrayLike, normals: ArrayLike) -> Conditions:
    """Which of ±ν₁ × ν₂ is the normal at vertices (n,) between two mirrors: the one nearer to `normals` (n, 3), or
    (3,)."""
    sites = _indices(vertices, domain.vertex_count, "vertex", "Vertices")
    return Conditions(corners=sites, corner_normals=unit(normals, sites, "vertex"))


def free(domain: Domain, edges: ArrayLike) -> Conditions:
    """Nothing is prescribed along boundary edges: the natural condition ∂N/∂ν = 0, as where nothing is said.

    Ends of the edges that another condition holds stay held. (Edges are checked all the same.)
    """
    boundary_edges(domain, edges)
    return Conditions()


def balanced(domain: Domain) -> Conditions:
    """∫ N μ = 0 on a closed domain, μ = <dN ∧ *dN> (paper, Sec. 5.3.4): among such maps descent does not end at a
    constant one. An initial map is needed.

    Every harmonic map of a closed domain is balanced (Theorem E.2); along a boundary there is a flux, so a domain that
    has one is refused with `ConditionError`.
    """
    if len(domain.boundary_edges):
        raise ConditionError("Maps balance on closed domains only, and this one has a boundary; leave the balance out.")
    return Conditions(is_balanced=True)


def _vector(value: ArrayLike) -> Array:
    given = as_numbers(value, "The normal of a mirror", ConditionError)
    if given.shape != (3,):
        raise ConditionError(f"The normal of a mirror must be one vector (3,), not {given.shape}.")
    return given


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
    "mirror": Kind(
        "Mirror",
        "The surface meets a plane at right angles, and goes on as its own reflection",
        (
            Parameter("normal", "Normal", "Normal of the plane, pointing out of the surface", (0.0, 0.0, 1.0)),
            Parameter("winding", "Extra Turns", "Full turns that the tangent plane makes along the mirror", 0.0),
        ),
        lambda domain, positions, edges, normal=(0.0, 0.0, 1.0), winding=0: mirror(domain, edges, normal, winding),
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
