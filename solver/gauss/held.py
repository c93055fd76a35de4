"""Conditions that a vector gives: normals along edges, at vertices and at faces, mirrors, corners, free edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError
from ..linalg import as_numbers
from .boundary_data import Conditions
from .frames import at_ends, boundary_edges, check_range, unit

Array = NDArray[np.float64]
Int = NDArray[np.integer]


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
    check_range(indices, count, noun)
    return indices.astype(np.int64)


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
    is_number = isinstance(winding, (int, float, np.number)) and not isinstance(winding, bool)
    if not is_number or not (isinstance(winding, (int, np.integer)) or float(winding).is_integer()):
        raise ConditionError(f"The winding must be a whole number of turns, not {winding!r}.")
    if abs(winding) > max(len(chosen), 1):
        raise ConditionError(
            f"A winding of {float(min(abs(winding), 1e300)):g} turns is too much for {len(chosen)} edges, which show "
            "one each at most; take fewer turns, or a finer mesh.",
            edges=chosen,
        )
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
