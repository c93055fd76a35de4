"""Frames along boundary edges (tangent, conormal, normal) and how they are blended at vertices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain, is_names, side_edges
from ..errors import ConditionError, listed, plural
from ..linalg import as_array, as_numbers, out_of_range, sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Directions count as opposite when their weighted sum is shorter than this part of their weights.
_OPPOSITE = 1e-6


def boundary_edges(domain: DomainLike, edges: ArrayLike) -> Int:
    """Indices (K,) of boundary edges, from indices, (K, 2) vertex pairs or names of a shape's sides.

    Raises `ConditionError` on anything else, and on edges inside.
    """
    if is_names(edges):
        edges = side_edges(domain, cast("str | Sequence[str]", edges))
    domain, given = as_domain(domain), as_array(edges, "Edges", ConditionError)
    if given.size == 0:
        return np.zeros(0, dtype=np.int64)
    if not np.issubdtype(given.dtype, np.integer) or not (given.ndim == 1 or given.shape[1:] == (2,)):
        raise ConditionError(f"Edges must be indices (K,) or vertex pairs (K, 2), not {given.dtype} {given.shape}.")
    if given.ndim == 2:
        return _edges_of_pairs(domain, given.astype(np.int64))
    check_range(given, len(domain.edges), "edge")
    inside = np.unique(given[domain.edge_faces[given, 1] >= 0])
    if inside.size:
        raise ConditionError(
            f"{plural('edge', inside).capitalize()} {_is(inside)} not on the boundary (edge {inside[0]} joins vertices "
            f"{listed(domain.edges[inside[0]])}); choose boundary edges only.",
            edges=inside,
        )
    return given.astype(np.int64)


def of_boundary(edges: Int, values: Int) -> Int:
    """The values (E,) of boundary edges, -1 on others, at `edges`; `ConditionError` on edges of another domain."""
    values = np.asarray(values, dtype=np.int64)
    known = edges < len(values)
    bad = np.unique(np.concatenate([edges[~known], edges[known][values[edges[known]] < 0]]))
    if bad.size:
        raise ConditionError(
            f"The conditions are on {plural('edge', bad)}, not on the boundary of this domain; make them for it.",
            edges=bad,
        )
    return values[edges]


def _edges_of_pairs(domain: Domain, pairs: Int) -> Int:
    n = domain.vertex_count
    check_range(pairs.ravel(), n, "vertex")
    boundary = domain.boundary_edges
    keys = _pair_keys(domain.edges[boundary], n)
    order = np.argsort(keys)
    wanted = _pair_keys(pairs, n)
    slot = np.searchsorted(keys[order], wanted).clip(max=max(len(keys) - 1, 0))
    missing = pairs[keys[order][slot] != wanted] if len(keys) else pairs
    if len(missing):
        text = "; ".join(f"{a}, {b}" for a, b in missing[:4])
        raise ConditionError(
            f"No boundary edge joins vertices {text}{' and others' if len(missing) > 4 else ''}; "
            "choose boundary edges.",
            vertices=np.unique(missing),
        )
    return boundary[order[slot]].astype(np.int64)


def _pair_keys(pairs: NDArray, n: int) -> Int:
    low, high = np.sort(pairs.astype(np.int64), axis=1).T
    return low * n + high


@dataclass(frozen=True)
class Frames:
    """Frames at boundary vertices (n,): outward conormals and surface normals, (n, 3) each.

    ends (K, 2): the place among `vertices` of the ends of each edge; weights (K,): of the edge in the blend there.
    """

    vertices: Int
    conormals: Array
    normals: Array
    ends: Int
    weights: Array

    def mean(self, values: Array) -> Array:
        """Weighted mean (n,) at each vertex of the values (K,) of its edges."""
        places, weights = self.ends.ravel(), np.repeat(self.weights, 2)
        total = sum_rows(places, weights, len(self.vertices))
        return sum_rows(places, weights * np.repeat(values, 2), len(self.vertices)) / total


@dataclass(frozen=True)
class EdgeFrames:
    """Frames of boundary edges (K,): outward conormals t × n and the normals n of the faces behind."""

    conormals: Array
    normals: Array
    lengths: Array
    up: Array


def edge_frames(domain: Domain, positions: ArrayLike, edges: Int) -> EdgeFrames:
    """Frames at the midpoints of boundary edges, from the `positions` (V, 2|3)."""
    points = in_space(domain, positions)
    vectors = points[domain.edges[edges, 1]] - points[domain.edges[edges, 0]]
    faces = domain.edge_faces[edges, 0]
    areas = area_vectors(points, domain.faces[faces])
    tangents = unit_rows(vectors, "edge", "has no length in these positions", edges)
    normals = unit_rows(areas, "face", "has no area in these positions", faces)
    return EdgeFrames(np.cross(tangents, normals), normals, np.linalg.norm(vectors, axis=1), whole_area(domain, points))


def vertex_frames(domain: Domain, edges: Int, along: EdgeFrames) -> Frames:
    """The frames of edges blended at their ends; each edge weighs as the inverse of its length."""
    weights = 1.0 / along.lengths
    vertices, conormals = at_ends(domain, edges, along.conormals, weights)
    _, normals = at_ends(domain, edges, along.normals, weights)
    normals = normals - np.einsum("ij,ij->i", normals, conormals)[:, None] * conormals
    normals = unit_rows(normals, "vertex", "has faces that are folded over each other", vertices)
    ends = np.searchsorted(vertices, domain.edges[edges])
    return Frames(vertices, conormals, normals, ends, weights)


def loop_angles(domain: Domain) -> tuple[Array, Array]:
    """θ along the boundary loops: at vertices (V,), and in the middle of edges (E,); nan inside."""
    angles = np.full(domain.vertex_count, np.nan)
    middles = np.full(len(domain.edge_lengths), np.nan)
    for loop, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        lengths = domain.edge_lengths[edges]
        end = np.cumsum(lengths)
        angles[loop] = 2.0 * np.pi * (end - lengths) / end[-1]
        middles[edges] = 2.0 * np.pi * (end - 0.5 * lengths) / end[-1]
    return angles, middles


def at_ends(domain: Domain, edges: Int, normals: Array, weights: Array) -> tuple[Int, Array]:
    """Vertices of the edges, and the blend there of the normals (K, 3) of the edges."""
    ends = domain.edges[edges].ravel().astype(np.int64)
    return blend(ends, np.repeat(normals, 2, axis=0), np.repeat(weights, 2), "edges")


def blend(
    sites: Int, normals: Array, weights: Array, of_what: str, noun: str = "vertex"
) -> tuple[Int, Array]:
    """Sites (n,) and the normalised weighted sum (n, 3) of their normals; `ConditionError` where a sum vanishes."""
    unique, inverse = np.unique(sites, return_inverse=True)
    sums = sum_rows(inverse, weights[:, None] * normals, len(unique))
    length = np.linalg.norm(sums, axis=1)
    bad = unique[length <= _OPPOSITE * np.bincount(inverse, weights, len(unique))]
    if bad.size:
        raise ConditionError(
            f"The normals that {of_what} prescribe at {plural(noun, bad)} are opposite and cancel; "
            "change one of them, or leave an edge between them free.",
            **{_PLURALS[noun]: bad},
        )
    return unique, sums / length[:, None]


def in_space(domain: Domain, positions: ArrayLike) -> Array:
    """Positions (V, 2|3) as points (V, 3); `ConditionError` on another shape and on numbers out of range."""
    points = as_numbers(positions, "Positions", ConditionError)
    if points.ndim != 2 or points.shape[0] != domain.vertex_count or points.shape[1] not in (2, 3):
        raise ConditionError(f"Positions must be ({domain.vertex_count}, 2) or (…, 3), not {points.shape}.")
    bad, what = out_of_range(points)
    if bad.size:
        raise ConditionError(f"The position of {plural('vertex', bad)} is {what}; move it.", vertices=bad)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return points


def area_vectors(points: Array, faces: Int) -> Array:
    """(F, 3): the normal of each face, as long as its area."""
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    return 0.5 * np.cross(b - a, c - a)


def whole_area(domain: Domain, points: Array) -> Array:
    """The sum (3,) of the area vectors of all faces: ½ ∮ p × dp along the boundary, by Stokes' theorem."""
    tail, head = (points - points.mean(axis=0))[domain.edges[domain.boundary_edges].T]
    return 0.5 * np.cross(tail, head).sum(axis=0)


def unit(normals: ArrayLike, owners: Int, noun: str) -> Array:
    """Unit vectors (n, 3) from one vector, or from one an owner."""
    given = as_numbers(normals, "Normals", ConditionError)
    if given.shape not in ((3,), (len(owners), 3)):
        raise ConditionError(
            f"Normals must have shape (3,) or ({len(owners)}, 3), one for each {noun}, not {given.shape}."
        )
    rows = np.broadcast_to(given, (len(owners), 3))
    return unit_rows(rows, noun, "has a normal that is zero or not finite", owners)


def scaled_rows(vectors: Array) -> Array:
    """Rows times powers of two that bring their largest parts to about one, so that their squares have a double."""
    _, exponent = np.frexp(np.abs(vectors).max(axis=-1, keepdims=True, initial=0.0))
    return np.ldexp(vectors, -exponent)


def unit_rows(vectors: Array, noun: str, complaint: str, owners: Iterable[int] | None = None) -> Array:
    """Rows divided by their lengths; `ConditionError`, naming the first owner, where a length is zero or not finite."""
    largest = np.abs(vectors).max(axis=-1, keepdims=True, initial=0.0)
    bad = np.flatnonzero(~(np.isfinite(largest[:, 0]) & (largest[:, 0] > 0.0)))
    if bad.size:
        names = bad if owners is None else np.asarray(list(owners))[bad]
        raise ConditionError(
            f"{plural(noun, names[:1]).capitalize()} {complaint}; choose another.", **{_PLURALS[noun]: names}
        )
    near_one = scaled_rows(vectors)
    return near_one / np.linalg.norm(near_one, axis=-1, keepdims=True)


_PLURALS = {"vertex": "vertices", "edge": "edges", "face": "faces"}


def check_range(indices: Int, count: int, noun: str) -> None:
    """Raise `ConditionError`, naming them, on indices below 0 or not below `count`."""
    bad = np.unique(indices[(indices < 0) | (indices >= count)])
    if bad.size:
        raise ConditionError(
            f"There is no {plural(noun, bad)}; indices run from 0 to {count - 1}.", **{_PLURALS[noun]: bad}
        )


def _is(items: Int) -> str:
    return "is" if len(items) == 1 else "are"


def moving_average(domain: Domain, edges: Int, values: Array, width: float) -> Array:
    """Mean (K,) of `values` (K,) on boundary `edges` (K,) over the arc of length `width` around each edge's midpoint.

    The window stays within a connected run of the given edges: the last value continues beyond the end of a run, and
    around a whole loop the window wraps. A width of zero, or below an edge length, changes (almost) nothing.
    """
    given = np.full(len(domain.edges), np.nan)
    given[edges] = values
    averaged = np.empty(len(domain.edges))
    if width > 0.0:
        for loop in domain.boundary_loop_edges:
            for run, is_loop in _runs(loop, np.isfinite(given[loop])):
                averaged[run] = _average(domain.edge_lengths[run], given[run], width, is_loop)
        return averaged[edges]
    return np.array(values, dtype=np.float64)


def _runs(loop: Int, chosen: NDArray[np.bool_]) -> list[tuple[Int, bool]]:
    """Maximal runs of chosen edges in a closed walk, and whether a run is the whole walk."""
    if chosen.all():
        return [(loop, True)]
    start = int(np.flatnonzero(~chosen)[0])
    walk, marks = np.roll(loop, -start), np.roll(chosen, -start)
    breaks = np.flatnonzero(np.diff(marks.astype(np.int8))) + 1
    parts = zip(np.split(walk, breaks), np.split(marks, breaks), strict=True)
    return [(part, False) for part, mark in parts if mark[0]]


def _average(lengths: Array, values: Array, width: float, is_loop: bool) -> Array:
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    integral = np.concatenate([[0.0], np.cumsum(lengths * values)])
    total, width = ends[-1], min(width, ends[-1])
    if is_loop:
        ends = np.concatenate([ends[:-1] - total, ends, ends[1:] + total])
        integral = np.concatenate([integral[:-1] - integral[-1], integral, integral[1:] + integral[-1]])
    else:
        ends = np.concatenate([[-width], ends, [total + width]])
        integral = np.concatenate([[-width * values[0]], integral, [integral[-1] + width * values[-1]]])
    middles = np.cumsum(lengths) - 0.5 * lengths
    upper, lower = (np.interp(middles + s * 0.5 * width, ends, integral) for s in (1, -1))
    return (upper - lower) / width
