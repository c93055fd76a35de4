"""Copies of a surface welded along their seams into one mesh.

Cut vertices are merged because their copies are neighbours, never because they are near. The merged vertex is their
mean, which for reflected copies lies in the plane.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..domain.gluing import Glued
from ..signatures import checked
from ..surface import convert
from ..surface.cmc_surface import CmcSurface
from .sides import SidePlane

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True)
class Gap:
    """The distance between the two copies of a seam before they were welded.

    copies: the two. largest: distance of cut vertices that became one vertex. relative: as a part of the surface's
    size.
    """

    seam: str
    copies: tuple[int, int]
    largest: float
    relative: float


@dataclass(frozen=True, eq=False)
class CompletedMesh:
    """A welded mesh of copies, triangles counter-clockwise seen from the side of the normals.

    vertices, normals: (n, 3); the normal is N on f+ and -N on f-, turned as the copy is. faces: (F, 3).
    source: (n,) the vertex of the domain that each vertex comes from.
    copies: (F,) the copy that each face belongs to, in the order of the completion; the faces of a copy are
    consecutive, in the domain's order. corners: (F, 3) the corner `3 f + k` of the domain at each corner, so that
    `values.reshape(3 F, -1)[corners]` carries values at corners, such as texture coordinates.
    gaps: of all seams, each pair of neighbours once.
    """

    vertices: Array
    faces: NDArray[np.int32]
    normals: Array
    source: NDArray[np.int32]
    copies: NDArray[np.int32]
    corners: NDArray[np.int32]
    gaps: list[Gap]

    def __repr__(self) -> str:
        copies = int(self.copies.max(initial=-1)) + 1
        return f"CompletedMesh({len(self.vertices)} vertices, {len(self.faces)} faces, {copies} copies)"

    @checked
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh as OBJ, PLY, STL or GLB, by the suffix of `path`; see `convert.save_mesh`."""
        convert.save_mesh(path, self.vertices, self.faces, self.normals)

    def to_trimesh(self) -> trimesh.Trimesh:
        """The mesh as a `trimesh.Trimesh` with its normals."""
        return convert.to_trimesh(self.vertices, self.faces, self.normals)

    @property
    def largest_gap(self) -> float:
        """Relative to the size of the surface; 0 without seams."""
        return max((gap.relative for gap in self.gaps), default=0.0)

    @property
    def rim(self) -> Int:
        """(b, 2) directed edges of one face only: the boundary of the completed mesh, faces on the left."""
        starts, ends = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()
        count = len(self.vertices)
        forth, back = starts.astype(np.int64) * count + ends, ends.astype(np.int64) * count + starts
        return np.column_stack([starts, ends])[~np.isin(forth, back)]

    @property
    def is_closed(self) -> bool:
        return len(self.rim) == 0

    @property
    def is_oriented(self) -> bool:
        """Whether no two faces traverse an edge in the same direction, so that every edge has at most two faces."""
        starts, ends = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()
        keys = starts.astype(np.int64) * len(self.vertices) + ends
        return len(np.unique(keys)) == len(keys)

    @property
    def flipped_faces(self) -> Int:
        """Faces that face away from the mean of the normals at their corners."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        seen = np.einsum("fi,fi->f", np.cross(b - a, c - a), self.normals[self.faces].sum(axis=1))
        return np.flatnonzero(seen <= 0.0)


def welded(glued: Glued, points: Array, normals: Array, source: Int, gaps: list[Gap]) -> CompletedMesh:
    """The mesh of `glued` copies with `points` and `normals` (K, n, 3), of the domain's vertices `source` (n,)."""
    N = glued.mean(normals)
    origin = np.empty(glued.vertex_count, dtype=np.int32)
    origin[glued.members.ravel()[::-1]] = np.tile(source, len(points))[::-1]
    return CompletedMesh(
        vertices=glued.mean(points),
        faces=glued.faces,
        normals=N / np.linalg.norm(N, axis=1, keepdims=True),
        source=origin,
        copies=glued.copies,
        corners=glued.corners,
        gaps=gaps,
    )


def snapped_to_planes(surface: CmcSurface, sheet: str, planes: Sequence[SidePlane]) -> Array:
    """Points (n, 3) of "f+" or "f-", those along sides moved exactly into their planes, or onto a free side's sphere.

    At a mirror f± lie in the plane of g, at a tangent side in that plane moved by ± scale along the normal.
    """
    sign = {"f+": 1.0, "f-": -1.0}[sheet]
    points = surface.sheet(sheet).copy()
    on = np.zeros((len(points), len(planes)), dtype=bool)
    for k, plane in enumerate(planes):
        on[plane.cut_vertices, k] = True
    on_sides = np.flatnonzero(on.any(axis=1))
    patterns, which = np.unique(on[on_sides], axis=0, return_inverse=True)
    for k, pattern in enumerate(patterns):
        here = on_sides[which.ravel() == k]
        walls = [plane for plane, is_here in zip(planes, pattern, strict=True) if is_here]
        for wall in walls:
            if wall.normal is None:
                points[here] = wall.point + sign * surface.scale * surface.normals[here]
        points[here] = _projected(
            points[here], [wall for wall in walls if wall.normal is not None], sign * surface.scale
        )
    return points


def _projected(points: Array, walls: Sequence[SidePlane], height: float) -> Array:
    if not walls:
        return points
    A = np.array([wall.normal for wall in walls])
    offsets = np.array([wall.offset + (height if wall.switches else 0.0) for wall in walls])
    return points - (points @ A.T - offsets) @ np.linalg.pinv(A).T
