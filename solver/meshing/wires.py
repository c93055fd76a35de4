"""From edges in space to the outline of a plan: closed loops, their plane, and the outer one among them.

Arrays only; the add-on's `outline_bridge` reads them from Blender and writes the mesh back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..errors import MeshError, plural
from ..linalg import out_of_range
from .outline import inside, signed_area
from .rounding import AUTOMATIC

_FLAT = 1e-5  # of the size: an outline this close to a plane counts as flat
_TOUCHING = 1e-5  # of the size: loose ends this close are one
_LEVEL = 1e-4  # the horizontal part of a normal below which its plane counts as level


@dataclass(frozen=True, eq=False)
class Wire:
    """Edges in space as drawn: points (V, 3), edges (E, 2), the group of each edge (E,), 0 for none.

    `name`: of the whole, in messages. `numbered`: messages name points by number, else by place.
    """

    name: str
    points: NDArray[np.float64]
    edges: NDArray[np.int32]
    groups: NDArray[np.int32]
    numbered: bool = True

    def loose_ends(self) -> NDArray[np.bool_]:
        """(V,) points at which one edge ends."""
        return np.bincount(self.edges.ravel(), minlength=len(self.points)) == 1

    def where(self, vertices: NDArray[np.int64]) -> str:
        """Vertices as a message names them: by number, or by the place of the first."""
        if self.numbered:
            return plural("vertex", vertices)
        return "({:.4g}, {:.4g}, {:.4g})".format(*self.points[vertices[0]])


@dataclass(frozen=True, eq=False)
class Plane:
    """`axes` (3, 3): two directions in the plane and its normal, which points upwards; `height` along the normal."""

    axes: NDArray[np.float64]
    height: float

    def flatten(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Plan coordinates (n, 2) of points (n, 3); in a level plane these are x and y."""
        return points @ self.axes[:2].T

    def raised(self, plan: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) of plan coordinates (n, 2)."""
        return plan @ self.axes[:2] + self.height * self.axes[2]


@dataclass(frozen=True, eq=False)
class Outline:
    """The outer loop and then the holes, as lists of vertices and edges of the wire: segment k is `edges[k]` and
    leaves `vertices[k]`. `off`: the largest distance of the wire from its plane."""

    wire: Wire
    plane: Plane
    vertices: list[NDArray[np.int64]]
    edges: list[NDArray[np.int64]]
    off: float

    @property
    def loops(self) -> list[NDArray[np.float64]]:
        """Plan coordinates (K, 2) of each loop."""
        return [self.plane.flatten(self.wire.points[index]) for index in self.vertices]

    @property
    def groups(self) -> list[NDArray[np.int32]]:
        """Group of each segment of each loop."""
        return [self.wire.groups[index] for index in self.edges]

    @property
    def size(self) -> float:
        """Longer side of the box around the outline, in plan coordinates."""
        return float(np.ptp(self.loops[0], axis=0).max())

    def borders(self) -> list[NDArray[np.int64]]:
        """Points of each loop between two groups, which must stay vertices."""
        return [np.flatnonzero(group != np.roll(group, 1)) for group in self.groups]


def make_outline(wire: Wire) -> Outline:
    """Loops of the wire in its best plane, the one with the largest area first.

    Raises `MeshError`, naming the vertices, on coordinates that are not finite or all the same, open ends, points where
    more than two edges meet, and loops outside the largest one.
    """
    bad, what = out_of_range(wire.points)
    if bad.size:
        pronoun = "it" if bad.size == 1 else "them"
        raise MeshError(
            f"The position of {plural('vertex', bad)} of {wire.name} is {what}; move or delete {pronoun}.",
            vertices=bad,
        )
    if not len(wire.edges):
        raise MeshError(f"{wire.name} has no outline: draw a closed loop of edges, a face, or a closed curve.")
    wire = joined_ends(wire)
    chains = chain(wire)
    plane, off = fit_plane(wire.points[np.concatenate([vertices for vertices, _ in chains])])
    areas = [abs(signed_area(plane.flatten(wire.points[vertices]))) for vertices, _ in chains]
    order = sorted(range(len(chains)), key=lambda k: -areas[k])
    outline = Outline(wire, plane, [chains[k][0] for k in order], [chains[k][1] for k in order], off)
    if not outline.size:
        raise MeshError(f"All points of {wire.name} are at one place; check its scale.")
    _check_parts(outline)
    return outline


def joined_ends(wire: Wire) -> Wire:
    """The wire with loose ends that touch made one, as lines of a drawing or a ring that repeats its first point."""
    loose = np.flatnonzero(wire.loose_ends())
    if not loose.size:
        return wire
    near = _TOUCHING * float(np.ptp(wire.points, axis=0).max())
    same, of_edge = np.arange(len(wire.points)), {tuple(sorted(pair)) for pair in wire.edges.tolist()}
    for i, j in sorted(KDTree(wire.points[loose]).query_pairs(near)):
        if (loose[i], loose[j]) not in of_edge:
            same[loose[j]] = same[loose[i]]
    return replace(wire, edges=same[wire.edges].astype(np.int32))


def chain(wire: Wire) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Closed loops as vertices and the edges that leave them; each starts with its first drawn edge."""
    count = np.bincount(wire.edges.ravel(), minlength=len(wire.points))
    _check_degrees(wire, count)
    # The two edges at each vertex: the places of the vertex among the ends of all edges, in pairs.
    places = np.argsort(wire.edges.ravel(), kind="stable").reshape(-1, 2) // 2
    pair = np.zeros((len(wire.points), 2), dtype=np.int64)
    pair[count == 2] = places
    ends, pairs = wire.edges.tolist(), pair.tolist()
    done = np.zeros(len(ends), dtype=bool)
    loops = []
    for first in range(len(ends)):
        if done[first]:
            continue
        vertices, edges = [], []
        edge, vertex = first, ends[first][0]
        while not done[edge]:
            done[edge] = True
            vertices.append(vertex)
            edges.append(edge)
            a, b = ends[edge]
            vertex = b if vertex == a else a
            one, other = pairs[vertex]
            edge = other if edge == one else one
        loops.append((np.array(vertices), np.array(edges)))
    return loops


def fit_plane(points: NDArray[np.float64]) -> tuple[Plane, float]:
    """The plane nearest to the points (n, 3), and their largest distance from it.

    Its normal points upwards. Its first direction is as near to the x axis as possible (to the y axis if x is the
    normal), so that plan coordinates in a level plane are x and y, and heights are kept.
    """
    centre = points.mean(axis=0)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    _, _, directions = np.linalg.svd((points - centre) / size, full_matrices=False)
    normal = directions[2] if len(directions) == 3 else np.array([0.0, 0.0, 1.0])
    if abs(normal[2]) < _LEVEL:  # an upright plan is seen from the front, or from the right
        normal = -normal if (normal[1] > _LEVEL or (abs(normal[1]) <= _LEVEL and normal[0] < 0)) else normal
    elif normal[2] < 0:
        normal = -normal
    if np.hypot(normal[0], normal[1]) < _LEVEL and np.ptp(points[:, 2]) <= _FLAT * size:
        normal = np.array([0.0, 0.0, 1.0])
    start = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    first = start - (start @ normal) * normal
    first /= np.linalg.norm(first)
    axes = np.array([first, np.cross(normal, first), normal])
    height = float(centre @ normal)
    return Plane(axes, height), float(np.abs(points @ normal - height).max())


def explained(error: MeshError, outline: Outline) -> MeshError:
    """The mesher's error, which numbers points along the loops, with the vertices that the user drew."""
    if not error.vertices:
        return error
    along = np.concatenate(outline.vertices)
    index = along[np.asarray(error.vertices)]
    where = f"In {outline.wire.name}: {outline.wire.where(index)}."
    return MeshError(f"{error} {where}", vertices=index)


def is_flat(outline: Outline) -> bool:
    """Whether the outline lies in its plane, up to rounding."""
    return outline.off <= _FLAT * outline.size


def default_edge_length(size: float) -> float:
    """A fortieth of the plan's size: about two thousand triangles, a second's work."""
    return size / 40.0


def default_corner_radius(size: float) -> float:
    """The largest automatic radius on a plan of this size, see `rounding`."""
    return AUTOMATIC * size


def nearest(midpoints: NDArray[np.float64], starts: NDArray, ends: NDArray) -> NDArray[np.int64]:
    """The nearest segment (m, d) of each point (n, d), by a few samples on each."""
    parts = np.array([1, 3, 5]) / 6.0
    samples = starts[:, None, :] + parts[None, :, None] * (ends - starts)[:, None, :]
    index = np.asarray(KDTree(samples.reshape(-1, samples.shape[2])).query(midpoints)[1])
    return index // len(parts)


def _check_degrees(wire: Wire, count: NDArray[np.int64]) -> None:
    ends = np.flatnonzero(count == 1)
    if ends.size:
        raise MeshError(
            f"The outline of {wire.name} is open at {wire.where(ends)}; close it (F joins two vertices, "
            "Merge by Distance welds ends that only touch).",
            vertices=ends,
        )
    knots = np.flatnonzero(count > 2)
    if knots.size:
        raise MeshError(
            f"More than two edges of the outline of {wire.name} meet at {wire.where(knots)}; an outline runs "
            "through each point once, so dissolve the extra edges or pull the loops apart.",
            vertices=knots,
        )


def _check_parts(outline: Outline) -> None:
    outer, *others = outline.loops
    apart = [
        k for k, loop in enumerate(others, 1) if not inside(loop, outer, np.roll(outer, -1, axis=0)).any()
    ]
    twins = _coinciding(outline) if apart else 0
    if twins:
        raise MeshError(
            f"{outline.wire.name} has {len(apart) + 1} outlines beside each other, of which {twins} vertices coincide "
            "and are not joined; weld them (Merge by Distance), so that they become one.",
            vertices=np.concatenate([outline.vertices[k] for k in apart]),
        )
    if apart:
        raise MeshError(
            f"{outline.wire.name} has {len(apart) + 1} separate outlines; mesh one plan at a time "
            "(P separates loose parts), or join them into one.",
            vertices=np.concatenate([outline.vertices[k] for k in apart]),
        )


def _coinciding(outline: Outline) -> int:
    """How many points of one loop lie on points of another."""
    points = np.concatenate(outline.loops)
    loop = np.repeat(np.arange(len(outline.loops)), [len(loop) for loop in outline.loops])
    pairs = KDTree(points).query_pairs(_TOUCHING * outline.size, output_type="ndarray")
    return int((loop[pairs[:, 0]] != loop[pairs[:, 1]]).sum())
