"""Optional plan data: intrinsic edge lengths and an initial map.

Lengths set the conformal type of a domain that cannot be drawn, such as a flat torus. An initial map chooses among
several harmonic maps, and takes the place of boundary conditions on a closed plan.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain import connectivity
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import MeshError, plural
from ..linalg import as_numbers

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# A side must be shorter than the two others by at least this part: single precision leaves 1e-7.
_SHORTER = 1e-6
# Names in messages, with those of the attributes in Blender.
_LENGTHS = "The plan's own edge lengths (cmc_length)"
_START = "The start of the plan (cmc_start)"
# Vectors of a start shorter than this have no direction.
_SHORTEST = 1e-6


def side_lengths(triangles: Int, edges: ArrayLike, lengths: ArrayLike) -> Array:
    """(T, 3) lengths of the sides of triangles (T, 3), side k opposite corner k, from those of edges (E, 2), pairs.

    Raises `MeshError` on lengths that are not positive numbers, and on a side that is not among the edges.
    """
    pairs = np.sort(np.asarray(edges, dtype=np.int64).reshape(-1, 2), axis=1)
    values = np.asarray(lengths, dtype=np.float64).ravel()
    corners = np.asarray(triangles, dtype=np.int64)
    sides = np.sort(np.stack([np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)], axis=2), axis=2)
    count = int(max(corners.max(initial=0), pairs.max(initial=0))) + 1
    keys = pairs @ [count, 1]
    order = np.argsort(keys, kind="stable")
    wanted = sides @ [count, 1]
    slot = order[np.searchsorted(keys[order], wanted).clip(max=max(len(keys) - 1, 0))] if len(keys) else None
    known = np.zeros(wanted.shape, dtype=bool) if slot is None else keys[slot] == wanted
    if slot is None or not known.all():
        bad = np.flatnonzero(~known.all(axis=1))
        raise MeshError(
            f"{_LENGTHS} are needed for every side of a triangle, and {plural('face', bad)} "
            f"{'has' if len(bad) == 1 else 'have'} a side without; triangulate the faces, or leave the lengths out.",
            faces=bad,
        )
    sides_of = values[slot]
    bad = np.flatnonzero(~(np.isfinite(sides_of) & (sides_of > 0.0)).all(axis=1))
    if bad.size:
        raise MeshError(
            f"{_LENGTHS} are not positive numbers at {plural('face', bad)}; give each edge one, or leave them out.",
            faces=bad,
        )
    return sides_of


def metric_domain(positions: Array, triangles: Int, lengths: Array) -> Domain:
    """The domain of drawn triangles (T, 3) with other side lengths (T, 3), side k opposite corner k.

    Raises `MeshError` where the triangles are not a surface, and naming faces whose sides make no triangle.
    """
    faces = connectivity.as_faces(triangles)
    connectivity.check_faces(faces, len(positions))
    sides = np.asarray(lengths, dtype=np.float64)
    if sides.shape != faces.shape:
        raise MeshError(f"{_LENGTHS} must have shape {faces.shape}, not {sides.shape}.")
    bad = np.flatnonzero(2.0 * sides.max(axis=1) >= (1.0 - _SHORTER) * sides.sum(axis=1))
    if bad.size:
        raise MeshError(
            f"{_LENGTHS} make no triangle of {plural('face', bad)}: one side is as long as the two others together; "
            "correct them, or leave them out.",
            faces=bad,
        )
    return Domain.from_edge_lengths(faces, sides)


def start_map(initial: ArrayLike, count: int) -> Array:
    """Unit normals (V, 3) of a start: one vector for each of `count` vertices, normalised.

    Raises `MeshError` on another shape, and naming vertices whose vector is zero or not finite.
    """
    given = as_numbers(initial, "The normals of a start", MeshError)
    if given.shape != (count, 3):
        raise MeshError(f"A start has a normal for each of the {count} vertices of the plan, not shape {given.shape}.")
    length = np.linalg.norm(given, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > _SHORTEST)))
    if bad.size:
        raise MeshError(
            f"{_START} has no normal at {plural('vertex', bad)}, where it is zero or not finite; give one, or leave "
            "the start out.",
            vertices=bad,
        )
    return given / length[:, None]


def at_sites(graph: SiteGraph, normals: Array) -> Array:
    """Unit normals (S, 3) of a start at the sites of a graph: means over the corners of faces, the ends of rim edges.

    Raises `MeshError` naming where they cancel.
    """
    means = graph.means(normals)
    length = np.linalg.norm(means, axis=1)
    bad = np.flatnonzero(length < _SHORTEST)
    if bad.size:
        where, offenders = graph.named(bad)
        raise MeshError(f"The normals of the start cancel at {where}; refine the plan there.", **offenders)
    return means / length[:, None]
