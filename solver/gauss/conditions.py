"""Boundary conditions: what the tangent planes do along the boundary.

A condition fixes the normals N at some sites (here: vertices). Conditions are combined with `+`; where two of them fix
the same vertex, it gets the normalised sum of their normals. Sites of which nothing is said are free: there the
natural condition ∂N/∂ν = 0 holds by itself (paper, Sec. 5.1).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, listed, plural

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Normals whose (weighted) sum is shorter than this part of their weights count as opposite.
_OPPOSITE = 1e-6


@dataclass(frozen=True, eq=False)
class Conditions:
    """Prescribed normals, not yet combined: `sites` (n,) may repeat, `normals` (n, 3) are unit vectors.

    `up` (3,) is the oriented area vector of the positions the conditions were made from, zero if there were none: the
    side to which data that lie in one plane bulge (see `initial`).
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
        return _blend(self.sites, self.normals, np.ones(len(self.sites)), "conditions")


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

    `edges` are indices into `domain.edges` or (K, 2) vertex pairs. A vertex between two edges gets the normalised sum.
    """
    chosen = boundary_edges(domain, edges)
    normals = _unit(normal, chosen, "edge")
    return _on_vertices(domain, chosen, normals, np.ones(len(chosen)), np.zeros(3))


def fixed_at(domain: Domain, vertices: ArrayLike, normals: ArrayLike) -> Conditions:
    """Normals (n, 3), or one for all (3,), at vertices (n,), inside or on the boundary."""
    sites = np.atleast_1d(np.asarray(vertices)).astype(np.int64)
    _check_range(sites, domain.vertex_count, "vertex")
    return Conditions(sites, _unit(normals, sites, "vertex"))


def binormal(domain: Domain, positions: ArrayLike, edges: ArrayLike, tilt: float = 0.0) -> Conditions:
    """The outward conormal of the surface `positions` (V, 2|3) along boundary edges, tilted by `tilt` radians.

    N = cos(tilt) t × n + sin(tilt) n with t the edge direction and n the normal of the face behind the edge (paper,
    Fig. 2 and 3): 0 makes the new surface meet the old one at a right angle, +π/2 makes it tangent. A vertex between
    edges of length a and b weighs their normals 1/a and 1/b, which is second order where the boundary is smooth.
    """
    chosen = boundary_edges(domain, edges)
    frame = _edge_frames(domain, positions, chosen)
    if not np.isfinite(tilt):
        raise ConditionError(f"The tilt must be a finite angle, not {tilt}.")
    normals = np.cos(tilt) * frame.conormals + np.sin(tilt) * frame.normals
    return _on_vertices(domain, chosen, normals, 1.0 / frame.lengths, frame.up)


def twisted(domain: Domain, positions: ArrayLike, edges: ArrayLike, m: float) -> Conditions:
    """The outward conormal turned by m θ around the boundary tangent (paper, Fig. 3), towards the surface normal.

    θ = 2π × arc length along the loop from its first listed vertex, as a part of the loop's length.
    """
    chosen = boundary_edges(domain, edges)
    frame = _edge_frames(domain, positions, chosen)
    if not np.isfinite(m):
        raise ConditionError(f"The number of twists must be finite, not {m}.")
    conormals = _on_vertices(domain, chosen, frame.conormals, 1.0 / frame.lengths, frame.up)
    normals = _on_vertices(domain, chosen, frame.normals, 1.0 / frame.lengths, frame.up)
    c = conormals.normals
    n = normals.normals - np.einsum("ij,ij->i", normals.normals, c)[:, None] * c
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    angle = (m * _loop_angles(domain)[conormals.sites])[:, None]
    return Conditions(conormals.sites, np.cos(angle) * c + np.sin(angle) * n, frame.up)


def gauss_map(domain: Domain, positions: ArrayLike, edges: ArrayLike) -> Conditions:
    """The normals of the surface `positions` (V, 2|3) itself at the vertices of boundary edges, weighted by angle."""
    chosen = boundary_edges(domain, edges)
    points = _in_space(domain, positions)
    faces = domain.faces
    face_normals = _unit_rows(_area_vectors(points, faces), "face", "has no area in these positions")
    weighted = face_normals[:, None, :] * domain.corner_angles[:, :, None]
    sums = np.zeros((domain.vertex_count, 3))
    np.add.at(sums, faces.ravel(), weighted.reshape(-1, 3))
    sites = np.unique(domain.edges[chosen]).astype(np.int64)
    normals = _unit_rows(sums[sites], "vertex", "has faces whose normals cancel", sites)
    return Conditions(sites, normals, _area_vectors(points, faces).sum(axis=0))


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


def boundary_edges(domain: Domain, edges: ArrayLike) -> Int:
    """Indices (K,) of boundary edges, from indices or from (K, 2) vertex pairs; `ConditionError` on any other."""
    given = np.asarray(edges)
    if given.size == 0:
        return np.zeros(0, dtype=np.int64)
    if not np.issubdtype(given.dtype, np.integer) or not (given.ndim == 1 or given.shape[1:] == (2,)):
        raise ConditionError(f"Edges must be indices (K,) or vertex pairs (K, 2), not {given.dtype} {given.shape}.")
    if given.ndim == 2:
        return _edges_of_pairs(domain, given.astype(np.int64))
    _check_range(given, len(domain.edges), "edge")
    inside = np.unique(given[domain.edge_faces[given, 1] >= 0])
    if inside.size:
        raise ConditionError(
            f"{plural('edge', inside).capitalize()} {_is(inside)} not on the boundary (edge {inside[0]} joins vertices "
            f"{listed(domain.edges[inside[0]])}); choose boundary edges only.",
            edges=inside,
        )
    return given.astype(np.int64)


def _edges_of_pairs(domain: Domain, pairs: Int) -> Int:
    n = domain.vertex_count
    _check_range(pairs.ravel(), n, "vertex")
    boundary = domain.boundary_edges
    keys = _pair_keys(domain.edges[boundary], n)
    order = np.argsort(keys)
    wanted = _pair_keys(pairs, n)
    slot = np.searchsorted(keys[order], wanted).clip(max=max(len(keys) - 1, 0))
    missing = pairs[keys[order][slot] != wanted] if len(keys) else pairs
    if len(missing):
        text = "; ".join(f"{a}, {b}" for a, b in missing[:4])
        raise ConditionError(
            f"No boundary edge joins vertices {text}{' and others' if len(missing) > 4 else ''}; choose boundary edges.",
            vertices=np.unique(missing),
        )
    return boundary[order[slot]].astype(np.int64)


def _pair_keys(pairs: NDArray, n: int) -> Int:
    low, high = np.sort(pairs.astype(np.int64), axis=1).T
    return low * n + high


@dataclass(frozen=True)
class _Frames:
    conormals: Array  # (K, 3), outward
    normals: Array  # (K, 3), of the face behind the edge
    lengths: Array  # (K,)
    up: Array  # (3,)


def _edge_frames(domain: Domain, positions: ArrayLike, edges: Int) -> _Frames:
    points = _in_space(domain, positions)
    vectors = points[domain.edges[edges, 1]] - points[domain.edges[edges, 0]]
    faces = domain.edge_faces[edges, 0]
    tangents = _unit_rows(vectors, "edge", "has no length in these positions", edges)
    all_normals = _area_vectors(points, domain.faces)
    normals = _unit_rows(all_normals[faces], "face", "has no area in these positions", faces)
    return _Frames(np.cross(tangents, normals), normals, np.linalg.norm(vectors, axis=1), all_normals.sum(axis=0))


def _loop_angles(domain: Domain) -> Array:
    """θ (V,) along the boundary loops; nan inside."""
    angles = np.full(domain.vertex_count, np.nan)
    for loop, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        lengths = domain.edge_lengths[edges]
        angles[loop] = 2.0 * np.pi * (np.cumsum(lengths) - lengths) / lengths.sum()
    return angles


def _on_vertices(domain: Domain, edges: Int, normals: Array, weights: Array, up: Array) -> Conditions:
    ends = domain.edges[edges].ravel().astype(np.int64)
    sites, blended = _blend(ends, np.repeat(normals, 2, axis=0), np.repeat(weights, 2), "edges")
    return Conditions(sites, blended, up)


def _blend(sites: Int, normals: Array, weights: Array, of_what: str) -> tuple[Int, Array]:
    """Normalised weighted sum of the normals at each site; refuses sums that vanish."""
    unique, inverse = np.unique(sites, return_inverse=True)
    sums = np.stack([np.bincount(inverse, weights * x, len(unique)) for x in normals.T], axis=1)
    length = np.linalg.norm(sums, axis=1)
    bad = unique[length <= _OPPOSITE * np.bincount(inverse, weights, len(unique))]
    if bad.size:
        raise ConditionError(
            f"The normals that {of_what} prescribe at {plural('vertex', bad)} are opposite and cancel; "
            "change one of them, or leave an edge between them free.",
            vertices=bad,
        )
    return unique, sums / length[:, None]


def _in_space(domain: Domain, positions: ArrayLike) -> Array:
    points = np.asarray(positions, dtype=np.float64)
    if points.ndim != 2 or points.shape[0] != domain.vertex_count or points.shape[1] not in (2, 3):
        raise ConditionError(f"Positions must be ({domain.vertex_count}, 2) or (…, 3), not {points.shape}.")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return points


def _area_vectors(points: Array, faces: Int) -> Array:
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    return 0.5 * np.cross(b - a, c - a)


def _unit(normals: ArrayLike, owners: Int, noun: str) -> Array:
    """Unit vectors (n, 3) from one vector or one an owner."""
    given = np.asarray(normals, dtype=np.float64)
    if given.shape not in ((3,), (len(owners), 3)):
        raise ConditionError(f"Normals must have shape (3,) or ({len(owners)}, 3), one for each {noun}, not {given.shape}.")
    return _unit_rows(np.broadcast_to(given, (len(owners), 3)), noun, "has a normal that is zero or not finite", owners)


def _unit_rows(vectors: Array, noun: str, complaint: str, owners: Iterable[int] | None = None) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    bad = np.flatnonzero(~(np.isfinite(length[:, 0]) & (length[:, 0] > 0.0)))
    if bad.size:
        names = bad if owners is None else np.asarray(list(owners))[bad]
        raise ConditionError(f"{plural(noun, names[:1]).capitalize()} {complaint}; choose another.", **{_PLURALS[noun]: names})
    return vectors / length


_PLURALS = {"vertex": "vertices", "edge": "edges", "face": "faces"}


def _check_range(indices: Int, count: int, noun: str) -> None:
    bad = np.unique(indices[(indices < 0) | (indices >= count)])
    if bad.size:
        raise ConditionError(f"There is no {plural(noun, bad)}; indices run from 0 to {count - 1}.", **{_PLURALS[noun]: bad})


def _is(items: Int) -> str:
    return "is" if len(items) == 1 else "are"
