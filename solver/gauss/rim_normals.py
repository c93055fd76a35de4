"""Conditions that the drawn surface gives: normals that lean, turn about the rim, or are those of the drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, Shape, as_domain, is_names
from ..errors import ConditionError, check_choice, plural
from ..linalg import as_numbers
from .boundary_data import Conditions
from .drawn_normals import drawn_normals
from .frames import (
    EdgeFrames,
    Frames,
    boundary_edges,
    edge_frames,
    in_space,
    loop_angles,
    scaled_rows,
    unit_rows,
    vertex_frames,
)
from .horizon import against_horizon, level_at_vertices, upwards

Array = NDArray[np.float64]
Int = NDArray[np.integer]


AGAINST = {
    "horizon": ("Horizon", "0° is a vertical rim and 90° a level one, however the plan stands or curves"),
    "surface": ("Drawn Surface", "0° is at right angles to the drawn faces along the rim, and 90° continues them"),
}
"""What the lean of `binormal` is measured against: name → label and description. On level plans both are the same."""


def binormal(
    domain: DomainLike,
    positions: ArrayLike | None = None,
    edges: ArrayLike | None = None,
    tilt: ArrayLike | None = 0.0,
    *,
    against: str = "horizon",
    up: ArrayLike | None = None,
) -> Conditions:
    """Normals at right angles to boundary edges of the surface `positions` (V, 2|3), leaning by `tilt` radians.

    N = cos(tilt) c + sin(tilt) m, both at right angles to the edge direction t. against="horizon": c = t × u is level
    and points outwards, with u upwards: 0 is a vertical rim, ½ π a level one, whatever was drawn. Along vertical edges
    the horizon says nothing, and within 15° of the vertical the frame turns smoothly to the drawn one. up: u (3,); by
    default z, or -z for a surface that looks down. against="surface": c = t × n and m = n, the normal of the face
    behind the edge (paper, Fig. 2 and 3): 0 makes the new surface meet the old one at a right angle, ½ π makes it
    tangent. On level plans both are the same.

    `tilt` is one angle, or one an edge (K,). At a vertex between edges of length a and b, c, m and the tilts are first
    blended with weights 1/a and 1/b. Against the horizon this is second order where the boundary is smooth and nowhere
    vertical; face normals are first order on curved surfaces. One tilt for all is exact everywhere. Where the level
    conormals of two edges cancel, their vertex has the drawn frame.

    With a shape: `binormal(shape, "outer", tilt=0.6)`. Raises `ConditionError` on edges inside, on unknown names of
    sides, on tilts beyond π, which are degrees, and on an `up` that is no direction.
    """
    domain, positions, edges, tilt = placed(domain, positions, edges, tilt)
    check_choice(against, AGAINST, "reference for the lean")
    chosen = boundary_edges(domain, edges)
    domain = as_domain(domain)
    tilts = _tilts(tilt, chosen)
    along = edge_frames(domain, positions, chosen)
    frames = vertex_frames(domain, chosen, along)
    if against == "horizon":
        along = against_horizon(along, upwards(along.up) if up is None else _upwards(up))
        frames = level_at_vertices(frames, along)
    return _tilted(chosen, along, tilts, frames, frames.mean(tilts))


def _upwards(up: ArrayLike) -> Array:
    given = as_numbers(up, "The upward direction", ConditionError)
    if given.shape != (3,) or not np.isfinite(given).all() or not given.any():
        raise ConditionError(f"The upward direction must be one vector (3,) with a length, not {up}.")
    given = scaled_rows(given)
    return given / np.linalg.norm(given)


def _tilts(tilt: ArrayLike | None, edges: Int) -> Array:
    tilts = as_numbers(0.0 if tilt is None else tilt, "Tilts", ConditionError)
    if tilts.shape not in ((), edges.shape):
        raise ConditionError(
            f"The tilt must be one angle, or {len(edges)} of them, one for each edge, not an array {tilts.shape}."
        )
    bad = np.flatnonzero(~np.isfinite(tilts))
    if bad.size:
        where = f" of {plural('edge', edges[bad])}" if tilts.ndim else ""
        raise ConditionError(
            f"The tilt{where} is {tilts.flat[bad[0]]}; it must be a finite angle.",
            edges=edges[bad] if tilts.ndim else edges,
        )
    _check_radians(tilts, "tilt")
    return np.broadcast_to(tilts, edges.shape)


def twisted(
    domain: DomainLike, positions: ArrayLike | None = None, edges: ArrayLike | None = None, m: float | None = None
) -> Conditions:
    """The outward conormal turned by m θ around the boundary tangent (paper, Fig. 3), towards the surface normal.

    θ = 2π × arc length along the loop from its first listed vertex, as a part of the loop's length. `m`, the number of
    turns, is required, up to half the number of the loop's edges. With a shape: `twisted(shape, "outer", m=1)`.
    """
    domain, positions, edges, turns = placed(domain, positions, edges, m)
    if turns is None:
        raise ConditionError("A twisted boundary needs m, the number of turns.")
    count = as_numbers(turns, "The number of twists", ConditionError)
    if count.ndim or not np.isfinite(count):
        raise ConditionError(f"The number of twists must be finite, not {turns}.")
    chosen = boundary_edges(domain, edges)
    domain = as_domain(domain)
    _check_turns(domain, chosen, float(count))
    along = edge_frames(domain, positions, chosen)
    frames = vertex_frames(domain, chosen, along)
    angles, middles = loop_angles(domain)
    return _tilted(chosen, along, count * middles[chosen], frames, count * angles[frames.vertices])


def gauss_map(
    domain: DomainLike, positions: ArrayLike | None = None, edges: ArrayLike | None = None
) -> Conditions:
    """The normals of the surface `positions` (V, 2|3) itself along boundary edges, to second order.

    At a vertex the normal of a quadratic fitted to its neighbours (`drawn_normals`); in the middle of an edge the mean
    of its ends; at a face its own. With a shape: `gauss_map(shape, "outer")`.
    """
    domain, positions, edges, _ = placed(domain, positions, edges)
    chosen = boundary_edges(domain, edges)
    domain = as_domain(domain)
    points = in_space(domain, positions)
    sites = np.unique(domain.edges[chosen]).astype(np.int64)
    normals = drawn_normals(domain, points, sites)
    ends = normals[np.searchsorted(sites, domain.edges[chosen])]
    middles = unit_rows(ends.sum(axis=1), "edge", "has opposite normals at its ends", chosen)
    behind = edge_frames(domain, points, chosen)
    return Conditions(sites, normals, chosen, middles, behind.normals, up=behind.up)


def placed(
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


def _check_turns(domain: Domain, edges: Int, turns: float) -> None:
    """Raise `ConditionError` on more turns than the edges of a loop can show: half a turn from one to the next."""
    for loop in domain.boundary_loop_edges:
        if 2.0 * abs(turns) > len(loop) and np.isin(loop, edges).any():
            raise ConditionError(
                f"{turns:g} turns are too many for a loop of {len(loop)} edges, which shows {len(loop) // 2} at most; "
                "take fewer turns, or a finer mesh.",
                edges=loop,
            )


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
