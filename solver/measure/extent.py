"""How a sheet lies in space: boundary edges, face normals, lean and overhang."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arrays import Array, Indices, double_areas, edge_vectors, points_in_space, triangles_of

if TYPE_CHECKING:
    from ..domain.domain import Domain

# Angle by which a face must lean past the vertical to overhang: more than rounding, less than anyone draws.
_PAST_VERTICAL = 1e-6


def boundary_sides(domain: Domain, faces: ArrayLike | None = None) -> NDArray[np.int32]:
    """Boundary edges as pairs of cut vertices (K, 2), the surface on their left, in the order of the faces.

    `faces` (F, 3) are the cut vertices of a surface, face by face as the domain's. The edges along which a surface
    is cut open are not boundary edges of its domain and are left out.
    """
    triangles = np.asarray(domain.faces if faces is None else faces)
    face, corner = np.nonzero(domain.edge_faces[domain.face_edges, 1] < 0)
    return np.stack([triangles[face, (corner + 1) % 3], triangles[face, (corner + 2) % 3]], axis=1).astype(np.int32)


def face_normals(vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Unit normals (F, 3) of the triangles, counter-clockwise seen from their tips; nan where degenerate."""
    points = points_in_space(vertices)
    u, v = edge_vectors(points, triangles_of(faces, len(points)))
    return (np.cross(u, v, axis=0) / double_areas(u, v)).T


def leans(vertices: ArrayLike, faces: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Array:
    """Angle (F,) in radians by which the upper side of each face leans out past the vertical; below 0 it does not.

    The upper side of a sheet is the one whose area vector points up, so a flipped dome, a bowl, does not overhang,
    whichever way its faces wind. `up` is a direction (3,). Degenerate faces give nan.
    """
    points = points_in_space(vertices)
    triangles: Indices = triangles_of(faces, len(points))
    direction = np.asarray(up, dtype=np.float64)
    u, v = edge_vectors(points, triangles)
    heights = direction @ np.cross(u, v, axis=0) / np.linalg.norm(direction)
    side = -1.0 if heights.sum() < 0 else 1.0
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.arcsin(np.clip(-side * heights / double_areas(u, v), -1.0, 1.0))


def overhanging_faces(vertices: ArrayLike, faces: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> NDArray[np.int32]:
    """Faces (k,) whose upper side looks below the horizon: they lean out past the vertical (see `leans`)."""
    with np.errstate(invalid="ignore"):
        return np.flatnonzero(leans(vertices, faces, up) > _PAST_VERTICAL).astype(np.int32)
