"""Ready-made domains with named sides, at any size, for tests, examples and job files.

Every shape states how its vertices are numbered. Boundary loops start at angle 0 on round shapes, at x = 0 on unrolled
ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..domain.domain import Domain
from ..domain.shape import Shape
from ..errors import MeshError
from ..limits import MOST_VERTICES, POSITIVE, Range, shown
from ..meshing.mesher import mesh_plan
from ..meshing.outline import check_loops, signed_area
from ..meshing.rounding import rounded_sentence
from ..meshing.triangulate import triangulate
from ..notes import Note
from ..signatures import checked

__all__ = [
    "annulus",
    "cylinder",
    "disc",
    "polygon",
    "rectangle",
    "sphere",
    "strip",
    "torus",
]


def __dir__() -> list[str]:
    """The public names only."""
    return list(__all__)


_ROW = np.sqrt(0.75)  # height of an equilateral triangle


@checked
def disc(n: int) -> Shape:
    """The unit disc with about n vertices: a centre and R rings of 6, 12, …, 6 R, so n is 3 R (R + 1) + 1.

    Numbered from the outer ring inwards, each from angle 0: vertex 0 is (1, 0), the centre is the last. Side "outer".
    """
    _check_count(n, 7, "A disc", "vertices")
    rings = max(1, round((np.sqrt(12 * n - 3) - 3) / 6))
    first = np.append(np.cumsum(np.append(0, 6 * np.arange(rings, 1, -1))), 3 * rings * (rings + 1))
    start = first[::-1]  # start[k] is the first vertex of ring k; ring 0 is the centre
    points = [_circle(k / rings, 6 * k) for k in range(rings, 0, -1)] + [np.zeros((1, 2))]
    faces = [_ring_faces(k, start[k], start[k - 1]) for k in range(rings, 0, -1)]
    return _planar(np.concatenate(points), np.concatenate(faces), [("outer", 6 * rings)])


@checked
def annulus(inner: float, outer: float, n: int) -> Shape:
    """The ring between two radii with about n vertices, on circles one row apart. Sides "outer", "inner".

    Numbered from the outer circle inwards; outer and inner circle start at angle 0.
    """
    _check_lengths(inner, outer, "An annulus")
    if not inner < outer:
        raise MeshError(f"An annulus needs 0 < inner < outer; its radii are {inner} and {outer}.")
    _check_count(n, 18, "An annulus", "vertices")
    edge = np.sqrt(np.pi * (outer**2 - inner**2) / _ROW / n)
    radii = np.linspace(outer, inner, max(2, round((outer - inner) / (_ROW * edge))) + 1)
    counts = np.maximum(6, np.round(radii * n / radii.sum()).astype(int))
    # Inner circles are turned against each other, or rows of equal triangles would meet in seams.
    turned = np.modf(np.arange(len(radii)) * 0.618)[0]
    turned[[0, -1]] = 0.0
    points = np.concatenate([_circle(r, k, t) for r, k, t in zip(radii, counts, turned, strict=True)])
    walls = [_cycle(0, counts[0]), _cycle(counts[:-1].sum(), counts[-1])[::-1, ::-1]]
    faces = triangulate(points / edge, np.concatenate(walls))
    return _planar(points, faces, [("outer", counts[0])], inner=walls[1])


@checked
def polygon(
    outline: np.ndarray,
    holes: Sequence[np.ndarray] = (),
    max_edge: float | None = None,
    corner_radius: float | None = 0.0,
    corners: str = "all",
) -> Shape:
    """A plan with holes, meshed as `mesher.mesh_plan` does; by default with about a thousand vertices.

    `corner_radius` None chooses the radius of each corner, `corners` which are rounded. Where a radius was chosen, or
    there is no room for the one given, `notes` say how much was rounded.
    Sides "outer", "hole0", "hole1"…; "side0"… for each segment of the outline as given, "hole0.side0"… for those of
    the holes, as far as edges lie on them. Boundary vertices come first, loop after loop, with the plan on their
    left, from the first point on (from an arc's middle where that point is a rounded corner).
    """
    if max_edge is None:
        area = sum(signed_area(loop.points) for loop in check_loops(outline, holes))
        max_edge = float(np.sqrt(area / _ROW / 1000))
    mesh = mesh_plan(outline, holes, max_edge=max_edge, corner_radius=corner_radius, corners=corners)
    domain = Domain.from_positions(mesh.positions, mesh.triangles)
    sides = {}
    edges = _edge_indices(domain, mesh.edges)
    for loop in range(mesh.loop.max() + 1):
        sides["outer" if loop == 0 else f"hole{loop - 1}"] = edges[mesh.loop == loop]
    for loop in range(mesh.loop.max() + 1):
        prefix = "" if loop == 0 else f"hole{loop - 1}."
        for k in np.unique(mesh.segment[mesh.loop == loop]):
            sides[f"{prefix}side{k}"] = edges[(mesh.loop == loop) & (mesh.segment == k)]
    return Shape(domain, mesh.positions, sides, _rounding_notes(mesh.rounded, corner_radius))


def _rounding_notes(radii: np.ndarray, wanted: float | None) -> tuple[Note, ...]:
    """What was rounded otherwise than by the radius that is wanted."""
    text = rounded_sentence(radii)
    as_wanted = wanted is not None and bool((radii > 0.99 * wanted).all())
    return () if text is None or as_wanted else (Note("rounded", text),)


@checked
def strip(width: float, height: float, columns: int) -> Shape:
    """A rectangle [0, width] × [0, height] of near-equilateral triangles in an even number of rows.

    Numbered row by row from the bottom, from left to right. Sides "bottom", "right", "top", "left" and "outer".
    """
    _check_lengths(width, height, "A strip")
    _check_count(columns, 1, "A strip", "columns")
    rows = _even_rows(height * columns / width)
    _check_grid(columns, rows, "A strip")
    whole, halves = np.arange(columns + 1.0), np.concatenate([[0.0], np.arange(columns) + 0.5, [columns]])
    x = np.concatenate([whole if j % 2 == 0 else halves for j in range(rows + 1)])
    y = np.repeat(np.arange(rows + 1) * (height / rows), [columns + 1 + j % 2 for j in range(rows + 1)])
    positions = np.column_stack([x * (width / columns), y])
    i = np.arange(columns)
    k = np.arange(columns + 1)
    e, o, two = 0, columns + 1, 2 * columns + 3  # a row of whole columns, one of halves, the next of whole ones
    pair = np.concatenate(
        [
            np.column_stack([e + i, e + i + 1, o + i + 1]),
            np.column_stack([o + k + 1, o + k, e + k]),
            np.column_stack([o + k, o + k + 1, two + k]),
            np.column_stack([two + i + 1, two + i, o + i + 1]),
        ]
    )
    faces = (pair[None] + two * np.arange(rows // 2)[:, None, None]).reshape(-1, 3)
    domain = Domain.from_positions(positions, faces)
    x, y = x / columns, y / height
    tests = {"bottom": y == 0, "right": x == 1, "top": np.isclose(y, 1, atol=1e-12), "left": x == 0}
    walls = domain.boundary_edges
    walls = walls[_loop_order(domain, walls)]
    sides = {name: walls[on[domain.edges[walls]].all(axis=1)] for name, on in tests.items()}
    return Shape(domain, positions, sides | {"outer": walls})


rectangle = strip


@checked
def cylinder(circumference: float, height: float, columns: int) -> Shape:
    """A strip whose left and right side are glued: flat, with two loops. Sides "bottom" (y = 0) and "top".

    `positions` are the unrolled (x, y), x in [0, circumference), odd rows half a column further. Numbered row by row
    from the bottom; both loops have a vertex at x = 0, their smallest.
    """
    _check_lengths(circumference, height, "A cylinder")
    _check_count(columns, 3, "A cylinder", "columns")
    rows = _even_rows(height * columns / circumference)
    _check_grid(columns, rows, "A cylinder")
    step = np.array([circumference / columns, height / rows])
    domain, positions = _glued(columns, rows, step, wrap_rows=False)
    bottom = _edge_indices(domain, _cycle(0, columns))
    top = _edge_indices(domain, _cycle(rows * columns, columns)[:, ::-1])
    return Shape(domain, positions, {"bottom": bottom, "top": top[::-1]})


@checked
def torus(a: float, b: float, columns: int) -> Shape:
    """The flat torus: a rectangle a × b with opposite sides glued. No boundary; `positions` are the unrolled (x, y)."""
    _check_lengths(a, b, "A torus")
    _check_count(columns, 3, "A torus", "columns")
    rows = max(4, _even_rows(b * columns / a))
    _check_grid(columns, rows, "A torus")
    domain, positions = _glued(columns, rows, np.array([a / columns, b / rows]), wrap_rows=True)
    return Shape(domain, positions, {})


@checked
def sphere(n: int) -> Shape:
    """The unit sphere with about n vertices: an icosahedron whose faces are divided f² times, n = 10 f² + 2."""
    _check_count(n, 12, "A sphere", "vertices")
    f = max(1, round(np.sqrt((n - 2) / 10)))
    corners, triangles = _icosahedron()
    i, j = (a.ravel() for a in np.meshgrid(np.arange(f + 1), np.arange(f + 1), indexing="ij"))
    inside = i + j <= f
    i, j = i[inside], j[inside]
    weights = np.column_stack([f - i - j, i, j]) / f
    points = np.einsum("pk,tkx->tpx", weights, corners[triangles]).reshape(-1, 3)
    number = np.zeros((f + 1, f + 1), dtype=np.int64)
    number[i, j] = np.arange(len(i))
    i, j = i[i + j < f], j[i + j < f]
    up = np.column_stack([number[i, j], number[i + 1, j], number[i, j + 1]])
    i, j = i[i + j < f - 1], j[i + j < f - 1]
    down = np.column_stack([number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]])
    faces = np.concatenate([up, down])[None] + len(weights) * np.arange(20)[:, None, None]
    _, first, same = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    positions = points[first] / np.linalg.norm(points[first], axis=1, keepdims=True)
    faces = same.ravel()[faces.reshape(-1, 3)]
    return Shape(Domain.from_positions(positions, faces), positions, {})


def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    """Corners (12, 3) and counter-clockwise faces (20, 3): two poles, two rings of five."""
    ring = 2 * np.pi * np.arange(5) / 5
    z, r = 1 / np.sqrt(5), 2 / np.sqrt(5)
    upper = np.column_stack([r * np.cos(ring), r * np.sin(ring), np.full(5, z)])
    lower = np.column_stack([r * np.cos(ring + np.pi / 5), r * np.sin(ring + np.pi / 5), np.full(5, -z)])
    corners = np.concatenate([[[0, 0, 1.0]], upper, lower, [[0, 0, -1.0]]])
    k, after = np.arange(5), (np.arange(5) + 1) % 5
    pole = np.zeros(5, dtype=int)
    faces = [
        (pole, 1 + k, 1 + after),
        (1 + k, 6 + k, 1 + after),
        (6 + k, 6 + after, 1 + after),
        (pole + 11, 6 + after, 6 + k),
    ]
    return corners, np.concatenate([np.column_stack(f) for f in faces])


def _circle(radius: float, count: int, turned: float = 0.0) -> np.ndarray:
    angle = 2 * np.pi * (np.arange(count) + turned) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _cycle(first: int, count: int) -> np.ndarray:
    """Edges (count, 2) of the closed loop first, first + 1, …"""
    k = np.arange(count)
    return first + np.column_stack([k, (k + 1) % count])


def _ring_faces(k: int, outer: int, inner: int) -> np.ndarray:
    """Faces between ring k of the disc, which starts at vertex `outer`, and ring k - 1, in six equal sectors."""
    sector, i = (a.ravel() for a in np.meshgrid(np.arange(6), np.arange(k), indexing="ij"))
    out, within = sector * k + i, sector * (k - 1) + i
    count = max(1, 6 * (k - 1))
    wide = np.column_stack([outer + out, outer + (out + 1) % (6 * k), inner + within % count])
    out, within = out[i < k - 1], within[i < k - 1]
    narrow = np.column_stack([inner + (within + 1) % count, inner + within, outer + out + 1])
    return np.concatenate([wide, narrow])


def _glued(columns: int, rows: int, step: np.ndarray, wrap_rows: bool) -> tuple[Domain, np.ndarray]:
    """Staggered rows around a cylinder or torus; corners keep their unrolled positions in their face."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="xy"))
    odd = j % 2
    above = i + odd  # the vertex of the next row that lies half a column to the right
    lower, upper = np.zeros_like(i), np.ones_like(i)
    columns_of = np.concatenate([np.column_stack([i, i + 1, above]), np.column_stack([above, above - 1, i])])
    rows_of = np.concatenate([np.column_stack([lower, lower, upper]), np.column_stack([upper, upper, lower])])
    rows_of = rows_of + np.tile(j, 2)[:, None]
    corners = np.stack([(columns_of + 0.5 * (rows_of % 2)) * step[0], rows_of * step[1]], axis=2)
    row = rows_of % rows if wrap_rows else rows_of
    faces = row * columns + columns_of % columns
    levels = rows if wrap_rows else rows + 1
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(levels), indexing="xy"))
    positions = np.column_stack([(i + 0.5 * (j % 2)) * step[0], j * step[1]])
    return Domain.from_corners(faces, corners), positions


def _planar(points: np.ndarray, faces: np.ndarray, loops: list[tuple[str, int]], **sides: np.ndarray) -> Shape:
    """Shape whose first vertices are a loop; further sides are given by their edges."""
    domain = Domain.from_positions(points, faces)
    named = {name: _edge_indices(domain, _cycle(0, count)) for name, count in loops}
    return Shape(domain, points, named | {name: _edge_indices(domain, edges) for name, edges in sides.items()})


def _edge_indices(domain: Domain, pairs: np.ndarray) -> np.ndarray:
    """Index into `domain.edges` of each directed boundary edge (K, 2)."""
    walls = domain.boundary_edges
    keys = domain.edges[walls].astype(np.int64) @ [domain.vertex_count, 1]
    order = np.argsort(keys)
    wanted = np.asarray(pairs, dtype=np.int64) @ [domain.vertex_count, 1]
    return walls[order[np.searchsorted(keys, wanted, sorter=order)]]


def _loop_order(domain: Domain, walls: np.ndarray) -> np.ndarray:
    """Order of the edges of a single boundary loop, from its smallest vertex on."""
    tail, head = domain.edges[walls].T
    after = dict(zip(tail.tolist(), head.tolist(), strict=True))
    at, order = int(tail.min()), {}
    for place in range(len(walls)):
        order[at] = place
        at = after[at]
    return np.argsort([order[t] for t in tail.tolist()])


def _even_rows(columns_high: float) -> int:
    """Even number of rows, so that the last row is like the first."""
    return max(2, 2 * round(columns_high / _ROW / 2))


def _check_lengths(width: float, height: float, name: str) -> None:
    if width not in POSITIVE or height not in POSITIVE:
        raise MeshError(f"{name} needs two positive lengths, each {POSITIVE}, not {shown(width)} and {shown(height)}.")


def _check_count(value: int, least: int, name: str, unit: str) -> None:
    if value not in Range(least, MOST_VERTICES, whole=True):
        raise MeshError(f"{name} needs from {least} to {shown(MOST_VERTICES)} {unit}, not {shown(value)}.")


def _check_grid(columns: int, rows: int, name: str) -> None:
    count = (columns + 1) * (rows + 1)
    if count > MOST_VERTICES:
        raise MeshError(
            f"{name} of {shown(columns)} columns in {shown(rows)} rows has {shown(count)} vertices, and "
            f"{shown(MOST_VERTICES)} are the most; take fewer columns."
        )
