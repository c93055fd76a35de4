"""Meshing a plan: well-shaped triangles of a given edge length inside an outline with holes.

The boundary is sampled first and then stays fixed. Inside, a lattice of equilateral triangles fills the uniform region
and Delaunay refinement the rest; springs between neighbours even out the spacing (Persson & Strang 2004, with the
boundary held), and the few remaining bad angles are improved one vertex at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ..errors import MeshError, check_choice, shown
from ..limits import LARGEST, MOST_VERTICES
from .outline import Loop, check_loops, inside, signed_area
from .quality import open_angles
from .rounding import ROUNDED, round_corners
from .sampling import MOST_ON_RIM, Boundary, sample
from .sizes import SizeField
from .triangulate import triangulate

_ROW = np.sqrt(0.75)
# Distances from walls and finer places beyond which the lattice keeps its points, and takes no part in the work.
_ORDERED, _DEEP = 4.0, 6.5


@dataclass(frozen=True)
class PlanMesh:
    """A meshed plan. `positions (V, 2)` start with the boundary, loop after loop, in the order of the input.

    `triangles (F, 3)` are counter-clockwise. `edges (B, 2)` are the boundary edges with the plan on their left;
    `loop (B,)` is 0 for the outline and 1 + k for hole k, `segment (B,)` the segment of that input loop from which the
    edge comes. The arc at a rounded corner is divided at its middle. `rounded (R,)`: the radii of the rounded corners,
    of `corners` in all.
    """

    positions: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    loop: np.ndarray
    segment: np.ndarray
    rounded: np.ndarray
    corners: int


def mesh_plan(
    outline: np.ndarray,
    holes: Sequence[np.ndarray] = (),
    *,
    max_edge: float,
    corner_radius: float | None = 0.0,
    corners: str = "all",
    keep: Sequence[Sequence[int]] = (),
) -> PlanMesh:
    """Mesh the plan bounded by `outline (K, 2)` and `holes`, with edges of about `max_edge`, few of them longer.

    Corners (turns of more than 23.5°) are rounded by `corner_radius`, less where room is short; with radius 0 they stay
    vertices, and with None each gets a radius in proportion to its loop and its edges (see `rounding`). `corners`:
    "all", "re-entrant" (only those that point into the plan, as a court's do) or "none" are rounded. Other points
    count as samples of smooth curves, which are sampled anew, except points between segments longer than two edges and
    points listed in `keep[i]` (indices into loop i, the outline first). Loops may run either way and may repeat their
    first point. Lengths are in the units of the input; only narrow places, bends and short sides are meshed finer.
    Raises `MeshError` for loops that bound no plan, lengths that do not fit and corners that are none of these.
    """
    check_choice(corners, ROUNDED, "kind of corners to round", MeshError)
    loops = check_loops(outline, holes, keep)
    everything = loops[0].points
    low, size = everything.min(axis=0), float(np.ptp(everything, axis=0).max())
    _check_lengths(max_edge, corner_radius, size)
    if corners == "re-entrant" and corner_radius == 0:
        raise MeshError("Re-entrant corners are rounded by a radius of 0; give a positive one, or have it chosen.")
    _check_count(loops, max_edge, size)
    origin = low + np.ptp(everything, axis=0) / 2
    in_units = [loop.in_units(origin, max_edge) for loop in loops]
    curves = round_corners(in_units, None if corner_radius is None else corner_radius / max_edge, corners)
    boundary, field = sample(curves)
    radii = np.concatenate([curve.radii for curve in curves]) * max_edge
    try:
        points, triangles = _Mesher(boundary, field).run()
    except MeshError as error:  # of an edge, in edge lengths from the middle
        if not error.vertices:
            raise
        a = error.vertices[0]
        x, y = origin + max_edge * boundary.points[a]
        first = sum(len(loop) for loop in [outline, *holes][: boundary.loop[a]])
        raise MeshError(
            f"At ({x:.6g}, {y:.6g}) the plan is too narrow for a mesh: a point of its boundary lies on another "
            "segment; move them apart.",
            edges=[first + int(boundary.segment[a])],
        ) from error
    edges = np.column_stack([np.arange(len(boundary.points)), boundary.following])
    return PlanMesh(
        origin + points * max_edge,
        triangles.astype(np.int32),
        edges.astype(np.int32),
        boundary.loop.astype(np.int32),
        boundary.segment.astype(np.int32),
        radii[radii > 0.0],
        int((radii > 0.0).sum() + sum(curve.sharp.sum() for curve in curves)),
    )


def _check_lengths(max_edge: float, corner_radius: float | None, size: float) -> None:
    if not 0.0 < max_edge < np.inf:
        raise MeshError(f"The edge length is {shown(max_edge)}; give a positive length.")
    if corner_radius is not None and not 0.0 <= corner_radius <= LARGEST:
        within = f"0 (corners stay) or a positive length up to {LARGEST:g}"
        raise MeshError(f"The corner radius is {shown(corner_radius)}; give {within}.")
    if max_edge >= size:
        raise MeshError(
            f"The edge length {shown(max_edge)} is larger than the plan, which measures {size:.6g}; "
            f"choose a shorter one, {size / 20:.2g} for example."
        )


def _check_count(loops: list[Loop], max_edge: float, size: float) -> None:
    """Refuse far too many vertices, as after a slip of the unit."""
    area = sum(signed_area(loop.points) for loop in loops)
    around = sum(float(loop.lengths.sum()) for loop in loops)
    shortest = max(np.sqrt(area / _ROW / MOST_VERTICES), around / MOST_ON_RIM)
    if max_edge < shortest:
        raise MeshError(
            f"The edge length {max_edge:.6g} would make more than {MOST_VERTICES:,} vertices of a plan that measures "
            f"{size:.6g}, or more than {MOST_ON_RIM:,} on the rim; choose one longer than {shortest:.2g}."
        )


class _Mesher:
    """Boundary points are `fixed`; inside, refinement and springs place the `free` points, and the others are lattice
    points away from walls and finer places. Only a `margin` of these takes part in the work.

    Lengths in units of the wanted edge length.
    """

    def __init__(self, boundary: Boundary, field: SizeField) -> None:
        self.fixed = boundary.points
        self.edges = np.column_stack([np.arange(len(boundary.points)), boundary.following])
        self.field = field
        self.ends = self.fixed[boundary.following]
        part = np.linspace(0, 1, 6)[:-1]
        walls = self.fixed[:, None, :] + part[None, :, None] * (self.ends - self.fixed)[:, None, :]
        self.wall = KDTree(walls.reshape(-1, 2))
        lattice = self._lattice()
        depth = self._depth(lattice)
        self.free = lattice[depth < _ORDERED]
        self.margin = lattice[(depth >= _ORDERED) & (depth < _DEEP)]
        self.deep = lattice[depth >= _DEEP]

    def run(self) -> tuple[np.ndarray, np.ndarray]:
        self._fill()
        self._relax(12)
        self._thin()
        self._fill()
        self._relax(12)
        return self._finish()

    def _all(self) -> np.ndarray:
        return np.concatenate([self.fixed, self.free, self.margin])

    def _triangles(self, points: np.ndarray) -> np.ndarray:
        """Triangles of the working set, except those that only span the deep lattice inside the margin."""
        triangles = triangulate(points, self.edges)
        return triangles[(triangles < len(self.fixed) + len(self.free)).any(axis=1)]

    def _from_wall(self, points: np.ndarray, most: float) -> np.ndarray:
        """Distance to the boundary, up to `most`."""
        return np.minimum(self.wall.query(points, distance_upper_bound=most)[0], most)

    def _depth(self, points: np.ndarray) -> np.ndarray:
        """Distance to the nearest wall or finer place."""
        return np.minimum(self._from_wall(points, _DEEP), self.field.room(points, _DEEP))

    def _lattice(self) -> np.ndarray:
        """Equilateral lattice along the longest wall, in the region of full size away from walls."""
        along = self._longest_direction()
        frame = np.column_stack([along, [-along[1], along[0]]])
        low, high = (self.fixed @ frame).min(axis=0), (self.fixed @ frame).max(axis=0)
        rows = np.arange(low[1] + _ROW, high[1], _ROW)
        columns = np.arange(low[0], high[0], 1.0)
        x = columns[None, :] + np.where(np.arange(len(rows)) % 2 == 0, 0.5, 0.0)[:, None]
        points = np.column_stack([x.ravel(), np.repeat(rows, len(columns))]) @ frame.T
        points = points[inside(points, self.fixed, self.ends)]
        points = points[self.field(points) > 0.9]
        return points[self._from_wall(points, 1.0) > 0.55]

    def _longest_direction(self) -> np.ndarray:
        """The main direction of the walls, by degrees; within that degree the direction of the longest wall."""
        step = self.ends - self.fixed
        length = np.hypot(*step.T)
        degree = np.round(np.degrees(np.arctan2(step[:, 1], step[:, 0]))).astype(int) % 180
        walls = np.nonzero(degree == np.argmax(np.bincount(degree, np.round(length, 6))))[0]
        return step[walls[np.argmax(length[walls])]] / length[walls].max()

    def _fill(self) -> None:
        """Delaunay refinement: add circumcentres of triangles that are too large, many at a time."""
        for _ in range(40):
            points = self._all()
            centre, radius = _circles(points[self._triangles(points)])
            size = self.field(centre)
            large = radius > 0.72 * size
            centre, radius, size = centre[large], radius[large], size[large]
            good = inside(centre, self.fixed, self.ends) & (self._from_wall(centre, 1.0) > 0.5 * size)
            good &= self._depth(centre) < _ORDERED
            centre, radius, size = centre[good], (radius / size)[good], size[good]
            if not len(centre):
                return
            self.free = np.concatenate([self.free, centre[_apart(centre, 0.8 * size, radius)]])

    def _relax(self, rounds: int) -> None:
        """Springs that push neighbours nearer than 1.2 wanted lengths apart; the boundary is held.

        Neighbours are updated when a point has moved by a tenth of its size since the last update.
        """
        first, last = len(self.fixed), len(self.fixed) + len(self.free)
        edges, before = np.zeros((0, 2), dtype=np.int64), np.full_like(self.free, np.inf)
        for _ in range(rounds):
            points = self._all()
            if len(self.free) and np.max(np.abs(self.free - before) / self.field(self.free)[:, None]) > 0.1:
                edges, before = _edges(self._triangles(points)), self.free
            bar = points[edges[:, 1]] - points[edges[:, 0]]
            length = np.hypot(*bar.T)
            wanted = self.field((points[edges[:, 1]] + points[edges[:, 0]]) / 2)
            wanted *= 1.2 * np.sqrt(np.sum(length**2) / np.sum(wanted**2))
            push = (np.maximum(wanted - length, 0.0) / length)[:, None] * bar
            force = [
                np.bincount(edges[:, 1], along, len(points)) - np.bincount(edges[:, 0], along, len(points))
                for along in push.T
            ]
            self._move(0.2 * np.column_stack(force)[first:last])

    def _move(self, step: np.ndarray) -> None:
        """Move the free points, but not close to a wall; a step is shorter than the distance to it."""
        size = self.field(self.free)
        step = step * np.minimum(1.0, 0.3 * size / np.maximum(np.hypot(*step.T), 1e-300))[:, None]
        moved = self.free + step
        good = self._from_wall(moved, 1.0) > 0.45 * size
        self.free = np.where(good[:, None], moved, self.free)

    def _thin(self) -> None:
        """Remove one of two points that are much nearer to each other than wanted."""
        size = self.field(self.free)
        self.free = self.free[_apart(self.free, 0.6 * size, -np.arange(len(self.free), dtype=float))]

    def _finish(self) -> tuple[np.ndarray, np.ndarray]:
        """Undo bridges in corners and necks, open the smallest angles, add the deep lattice."""
        triangles = self._triangles(self._all())
        for _ in range(4):
            if self._free_bridges(triangles, draw=True):
                triangles = self._triangles(self._all())
            first, last = len(self.fixed), len(self.fixed) + len(self.free)
            before, self.free = self.free, open_angles(self._all(), triangles, first, last)[first:last]
            if np.array_equal(self.free, before):
                break
            triangles = self._triangles(self._all())
        self._free_bridges(triangles, draw=False)
        points = np.concatenate([self._all(), self.deep])
        triangles = triangulate(points, self.edges)
        used, numbers = np.unique(triangles, return_inverse=True)
        return points[used], numbers.reshape(triangles.shape)

    def _free_bridges(self, triangles: np.ndarray, draw: bool) -> bool:
        """Undo inner edges that join two boundary vertices: N would be fixed at both, and at a corner all around.

        If the triangle beyond has an inner vertex close enough, `draw` moves that vertex into the circle of the first
        triangle, so that Delaunay flips the edge; otherwise the edge gets a vertex at its middle. Short ones, in tips
        sharper than about 45°, stay: splitting them would make angles still smaller. Returns whether any was undone.
        """
        points = self._all()
        edge, opposite = _inner_edges(triangles)
        bridge = (edge < len(self.fixed)).all(axis=1)
        edge, opposite = edge[bridge], opposite[bridge]
        middle = points[edge].mean(axis=1)
        long = np.hypot(*(points[edge[:, 1]] - points[edge[:, 0]]).T) > 0.75 * self.field(middle)
        edge, opposite, middle = edge[long], opposite[long], middle[long]
        opposite = np.sort(opposite, axis=1)
        corner, beyond = opposite.T
        first, last = len(self.fixed), len(self.fixed) + len(self.free)
        centre, radius = _circles(points[np.column_stack([edge, corner])])
        away = points[beyond] - centre
        distance = np.hypot(*away.T)
        drawn = draw & (corner < first) & (beyond >= first) & (beyond < last) & (distance < 1.35 * radius)
        points[beyond[drawn]] = (centre + away * (0.93 * radius / distance)[:, None])[drawn]
        self.free = np.concatenate([points[first:last], middle[~drawn]])
        return len(edge) > 0


def _circles(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Circumcentres (F, 2) and circumradii (F,) of triangles (F, 3, 2)."""
    a = corners[:, 0]
    b, c = corners[:, 1] - a, corners[:, 2] - a
    area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    bb, cc = np.sum(b * b, axis=1), np.sum(c * c, axis=1)
    centre = np.column_stack([c[:, 1] * bb - b[:, 1] * cc, b[:, 0] * cc - c[:, 0] * bb]) / (2 * area)[:, None]
    return a + centre, np.hypot(*centre.T)


def _apart(points: np.ndarray, distance: np.ndarray, priority: np.ndarray) -> np.ndarray:
    """Mask of the points with the highest priority within their distance."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    pairs = KDTree(points).query_pairs(float(distance.max()), output_type="ndarray")
    i, j = pairs.T
    near = np.hypot(*(points[i] - points[j]).T) < np.minimum(distance[i], distance[j])
    i, j = i[near], j[near]
    keep = np.ones(len(points), dtype=bool)
    first = (priority[i] > priority[j]) | ((priority[i] == priority[j]) & (i < j))
    keep[np.where(first, j, i)] = False
    return keep


def _edges(triangles: np.ndarray) -> np.ndarray:
    """Each edge once, (E, 2), its vertices sorted."""
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    key = np.unique(ends[:, 0].astype(np.int64) * (ends.max() + 1) + ends[:, 1])
    return np.column_stack(np.divmod(key, ends.max() + 1))


def _inner_edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (E, 2) with a triangle on each side, and the two vertices (E, 2) opposite them."""
    tail, head, apex = (np.roll(triangles, -k, axis=1).ravel() for k in range(3))
    count = np.int64(triangles.max() + 1)
    order = np.argsort(tail * count + head)
    keys = (tail * count + head)[order]
    at = np.minimum(np.searchsorted(keys, head * count + tail), len(keys) - 1)
    inner = (keys[at] == head * count + tail) & (tail < head)
    return np.column_stack([tail, head])[inner], np.column_stack([apex, apex[order[at]]])[inner]
