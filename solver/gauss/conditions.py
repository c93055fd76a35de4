"""Boundary conditions: prescribed tangent planes, mirrors and free edges along the boundary.

A condition fixes the normals N at some sites, or holds them in a plane with normal ν (a mirror, N · ν = 0; paper, Sec.
5.1.1). Conditions are combined with `+`. Where kinds meet at a site, fixed goes before mirror before free: two normals
that fix it blend to their normalised sum, as a normal does with its reflection; two mirrors leave N = ±ν₁ × ν₂. Sites
without a condition are free: there the natural condition ∂N/∂ν = 0 holds by itself (paper, Sec. 5.1).

Every condition takes a domain or a shape. `edges` are indices into `domain.edges`, (K, 2) vertex pairs or, of a shape,
the name of a side or a list of names; a shape brings its positions, too, so they may be left out:
`binormal(shape, "outer", tilt=0.6)`. Angles are radians.

Conditions along boundary edges serve every kind of site. With normals at vertices they hold at the vertices of the
edges. With normals at faces an edge fixes the normal of the face behind it, to the value in the middle of the edge:
half a triangle too far inside (paper, Fig. 7, bottom). The shell is then that of a narrower plan, a first-order error,
and a rough one where the triangles are irregular. With "faces_and_rim" the condition holds in the middle of the edge
itself, half-way between the face and its mirror image, and the face is free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.shape import DomainLike, Shape, as_domain, is_names
from ..errors import ConditionError, check_choice
from ..limits import NUMBERS, Range, check_number
from ..linalg import as_numbers
from .boundary_data import Conditions
from .drawn_normals import drawn_normals
from .frames import (
    EdgeFrames,
    Frames,
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


__all__ = [
    "KINDS",
    "Conditions",
    "Kind",
    "Parameter",
    "balanced",
    "binormal",
    "build",
    "corner",
    "fixed",
    "fixed_at",
    "fixed_at_faces",
    "free",
    "gauss_map",
    "mirror",
    "twisted",
]


def __dir__() -> list[str]:
    """The public names only."""
    return list(__all__)


TURNS = Range(-1000, 1000)


@dataclass(frozen=True)
class Parameter:
    """A number or vector that a kind of condition takes, as a user interface shows it."""

    name: str
    label: str
    description: str
    default: float | tuple[float, ...]
    unit: str = ""
    within: Range = NUMBERS


@dataclass(frozen=True)
class Kind:
    """A kind of boundary condition, as a user interface offers it."""

    label: str
    description: str
    parameters: tuple[Parameter, ...]
    make: Callable[..., Conditions] = field(repr=False)


def fixed(domain: DomainLike, edges: ArrayLike, normal: ArrayLike) -> Conditions:
    """A constant normal (3,) along boundary edges, or one an edge (K, 3): the surface touches a plane there.

    A vertex between two edges gets the normalised sum. Raises `ConditionError` on edges inside, on unknown names of
    sides and on normals that are zero, not finite or opposite at a vertex.
    """
    chosen, domain = boundary_edges(domain, edges), as_domain(domain)
    normals = unit(normal, chosen, "edge")
    return Conditions(*at_ends(domain, chosen, normals, np.ones(len(chosen))), chosen, normals)


def fixed_at(domain: DomainLike, vertices: ArrayLike, normals: ArrayLike) -> Conditions:
    """Normals (n, 3), or one for all (3,), at vertices (n,), inside or on the boundary; not for normals at faces."""
    sites = _indices(vertices, as_domain(domain).vertex_count, "vertex", "Vertices")
    return Conditions(sites, unit(normals, sites, "vertex"), only_vertices=sites)


def fixed_at_faces(domain: DomainLike, faces: ArrayLike, normals: ArrayLike) -> Conditions:
    """Normals (n, 3), or one for all (3,), at faces (n,), inside or on the boundary, where normals live at faces."""
    sites = _indices(faces, len(as_domain(domain).faces), "face", "Faces")
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


def binormal(
    domain: DomainLike, positions: ArrayLike | None = None, edges: ArrayLike | None = None, tilt: ArrayLike | None = 0.0
) -> Conditions:
    """The outward conormal of the surface `positions` (V, 2|3) along boundary edges, tilted by `tilt` radians.

    N = cos(tilt) t × n + sin(tilt) n with t the edge direction and n the normal of the face behind the edge (paper,
    Fig. 2 and 3): 0 makes the new surface meet the old one at a right angle, +π/2 makes it tangent. `tilt` is one
    angle, or one an edge (K,). At a vertex between edges of length a and b, t × n, n and the tilts are first blended
    with weights 1/a and 1/b, which is second order where the boundary is smooth; one tilt for all is exact everywhere.
    With a shape: `binormal(shape, "outer", tilt=0.6)`. Raises `ConditionError` on edges inside, on unknown names of
    sides, and on tilts beyond π, which are degrees.
    """
    domain, positions, edges, tilt = _placed(domain, positions, edges, tilt)
    chosen = boundary_edges(domain, edges)
    domain = as_domain(domain)
    tilts = as_numbers(0.0 if tilt is None else tilt, "Tilts", ConditionError)
    if tilts.shape not in ((), chosen.shape) or not np.isfinite(tilts).all():
        raise ConditionError(f"The tilt must be a finite angle, or {len(chosen)} of them, one for each edge.")
    _check_radians(tilts, "tilt")
    tilts = np.broadcast_to(tilts, chosen.shape)
    along = edge_frames(domain, positions, chosen)
    frames = vertex_frames(domain, chosen, along)
    return _tilted(chosen, along, tilts, frames, frames.mean(tilts))


def twisted(
    domain: DomainLike, positions: ArrayLike | None = None, edges: ArrayLike | None = None, m: float | None = None
) -> Conditions:
    """The outward conormal turned by m θ around the boundary tangent (paper, Fig. 3), towards the surface normal.

    θ = 2π × arc length along the loop from its first listed vertex, as a part of the loop's length. `m`, the number of
    turns, is required. With a shape: `twisted(shape, "outer", m=1)`.
    """
    domain, positions, edges, turns = _placed(domain, positions, edges, m)
    if turns is None:
        raise ConditionError("A twisted boundary needs m, the number of turns.")
    check_number(turns, "number of twists", TURNS)
    count = np.float64(turns)  # pyright: ignore[reportArgumentType]
    chosen = boundary_edges(domain, edges)
    domain = as_domain(domain)
    along = edge_frames(domain, positions, chosen)
    frames = vertex_frames(domain, chosen, along)
    angles, middles = loop_angles(domain)
    return _tilted(chosen, along, count * middles[chosen], frames, count * angles[frames.vertices])


def _placed(
    given: DomainLike, positions: ArrayLike | None, edges: ArrayLike | None, parameter: ArrayLike | None = None
) -> tuple[DomainLike, ArrayLike, ArrayLike, ArrayLike | None]:
    """The arguments of a condition in their order; with a shape the positions may be left out, also by place."""
    if isinstance(given, Shape) and positions is not None and (edges is None or is_names(positions)):
        if edges is not None:
            parameter = edges
        positions, edges = None, positions
    if positions is None and isinstance(given, Shape):
        positions = given.positions
    if positions is None:
        raise ConditionError("A Domain has no positions; pass those of its vertices (V, 2|3), or a Shape.")
    if edges is None:
        raise ConditionError("The edges are missing; pass boundary edges, or names of a shape's sides.")
    return given, positions, edges, parameter


def _check_radians(angles: Array, name: str, most: float = np.pi) -> None:
    """Raise `ConditionError` on angles beyond `most`, which were meant as degrees."""
    largest = float(angles.flat[np.argmax(np.abs(angles))]) if angles.size else 0.0
    if abs(largest) > most * (1.0 + 1e-6):  # half a turn in single precision, too
        raise ConditionError(
            f"The {name} {largest:g} is more than half a turn: angles are in radians. For {largest:g}° write "
            f"np.radians({largest:g})."
        )


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


def gauss_map(
    domain: DomainLike, positions: ArrayLike | None = None, edges: ArrayLike | None = None
) -> Conditions:
    """The normals of the surface `positions` (V, 2|3) itself along boundary edges, to second order.

    At a vertex the normal of a quadratic fitted to its neighbours (`drawn_normals`); in the middle of an edge the mean
    of its ends; at a face its own. With a shape: `gauss_map(shape, "outer")`.
    """
    domain, positions, edges, _ = _placed(domain, positions, edges)
    chosen = boundary_edges(domain, edges)
    domain = as_domain(domain)
    points = in_space(domain, positions)
    sites = np.unique(domain.edges[chosen]).astype(np.int64)
    normals = drawn_normals(domain, points, sites)
    ends = normals[np.searchsorted(sites, domain.edges[chosen])]
    middles = unit_rows(ends.sum(axis=1), "edge", "has opposite normals at its ends", chosen)
    behind = edge_frames(domain, points, chosen)
    return Conditions(sites, normals, chosen, middles, behind.normals, up=behind.up)


def mirror(domain: DomainLike, edges: ArrayLike, plane_normal: ArrayLike, winding: float = 0) -> Conditions:
    """Along boundary edges the surface meets a plane with this normal ν (3,) at right angles: N · ν = 0 (paper,
    Sec. 5.1.1), while N is free to turn within the plane.

    The surface continues as its own reflection (Schwarz). Where two mirrors meet, N = ±ν₁ × ν₂. The sign is that of an
    `initial` map if one is given. If not, N points to the upper side of the plan, where other conditions know one and
    N is not in the plan's plane; else to the side for which the plane normals point out of f+: around a corner of less
    than 180°, the product of ν of the edges that arrive and of those that leave, with the domain on their left.
    `side=-1` takes the other sign. `corner` overrides all this. Where a mirror meets a condition that fixes the normals
    along edges, that condition wins; at their common vertex it blends with its reflection, unless it is nearer to ν
    than to the plane.

    winding: full turns of the start. Along a side N turns about ν from the normal at its first end to that at its last
    by the smaller angle (where they are opposite, over the upper side, or else as on a convex side if ν points
    outwards) and by `winding` full turns more; around a whole loop, by `winding` full turns.
    With normals at faces the constraint is on the face behind the edge, first order as for fixed normals; with
    "faces_and_rim" it is on the edge's own site, and as exact as at vertices.
    """
    chosen = boundary_edges(domain, edges)
    normals = unit(_vector(plane_normal), chosen, "edge")
    check_number(winding, "winding", TURNS)
    if not float(winding).is_integer():
        raise ConditionError(f"The winding must be a whole number of turns, not {winding!r}.")
    turns = np.full(len(chosen), int(winding), dtype=np.int64)
    return Conditions(mirrors=chosen, mirror_normals=normals, windings=turns)


def corner(domain: DomainLike, vertices: ArrayLike, normals: ArrayLike) -> Conditions:
    """Choose between ±ν₁ × ν₂ at vertices (n,) between two mirrors: the one nearer to `normals` (n, 3) or (3,)."""
    sites = _indices(vertices, as_domain(domain).vertex_count, "vertex", "Vertices")
    return Conditions(corners=sites, corner_normals=unit(normals, sites, "vertex"))


def free(domain: DomainLike, edges: ArrayLike) -> Conditions:
    """No condition along boundary edges but the natural one, ∂N/∂ν = 0, as on edges in no condition.

    Ends of the edges that another condition holds stay held. (Edges are checked all the same.)
    """
    boundary_edges(domain, edges)
    return Conditions()


def balanced(domain: DomainLike) -> Conditions:
    """∫ N μ = 0 on a closed domain, μ = <dN ∧ *dN> (paper, Sec. 5.3.4): among such maps descent does not end at a
    constant one. An initial map is needed.

    Every harmonic map of a closed domain is balanced (Theorem E.2). Raises `ConditionError` on a domain with a
    boundary, since there is a flux through it.
    """
    if len(as_domain(domain).boundary_edges):
        raise ConditionError("Maps balance on closed domains only, and this one has a boundary; leave the balance out.")
    return Conditions(is_balanced=True)


def _vector(value: ArrayLike) -> Array:
    given = as_numbers(value, "The normal of a mirror", ConditionError)
    if given.shape != (3,):
        raise ConditionError(f"The normal of a mirror must be one vector (3,), not {given.shape}.")
    return given


KINDS: dict[str, Kind] = {
    "binormal": Kind(
        "Outward, leaning",
        "The rim leans by an angle: 0° stands upright on the plan, 90° lies flat in it",
        (Parameter("tilt", "Lean", "The rim leans by this angle; 0° stands upright, 90° lies flat", 0.0, "radians"),),
        lambda domain, positions, edges, tilt=0.0: binormal(domain, positions, edges, tilt),
    ),
    "plane": Kind(
        "Constant plane",
        "The shell touches one plane along these edges",
        (Parameter("normal", "Normal", "Normal of the plane, pointing out of the shell", (0.0, 0.0, 1.0)),),
        lambda domain, positions, edges, normal=(0.0, 0.0, 1.0): fixed(domain, edges, normal),
    ),
    "twisted": Kind(
        "Twisted",
        "The tangent plane turns about the rim, along the rim",
        (Parameter("m", "Turns", "Full turns of the tangent plane on the way around the loop", 1.0, within=TURNS),),
        lambda domain, positions, edges, m=1.0: twisted(domain, positions, edges, m),
    ),
    "gauss_map": Kind(
        "As drawn",
        "The shell keeps the tangent planes of the drawn mesh along these edges",
        (),
        lambda domain, positions, edges: gauss_map(domain, positions, edges),
    ),
    "mirror": Kind(
        "Mirror",
        "The shell meets a plane at a right angle and continues as its own reflection",
        (
            Parameter("normal", "Normal", "Normal of the plane, pointing out of the shell", (0.0, 0.0, 1.0)),
            Parameter("winding", "Extra Turns", "Extra full turns of the tangent plane along a mirror", 0.0, "", TURNS),
        ),
        lambda domain, positions, edges, normal=(0.0, 0.0, 1.0), winding=0: mirror(domain, edges, normal, winding),
    ),
    "free": Kind(
        "Free",
        "Nothing is prescribed; the rim finds its own tangent planes",
        (),
        lambda domain, positions, edges: free(domain, edges),
    ),
}


def build(
    kind: str,
    domain: DomainLike,
    positions: ArrayLike | None = None,
    edges: ArrayLike | None = None,
    **parameters: object,
) -> Conditions:
    """The condition named `kind` in `KINDS`, with that kind's parameters (angles in radians)."""
    check_choice(kind, KINDS, "boundary condition")
    known = {parameter.name for parameter in KINDS[kind].parameters}
    unknown = sorted(set(parameters) - known)
    if unknown:
        raise ConditionError(
            f"The boundary condition {kind!r} has no parameter {', '.join(unknown)}; "
            f"it has {', '.join(sorted(known)) or 'none'}."
        )
    _, positions, edges, _ = _placed(domain, positions, edges)
    return KINDS[kind].make(domain, positions, edges, **parameters)
