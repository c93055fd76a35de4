"""Errors of a surface: of H, distortion, and the distance to another surface. For tests and for tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from solver import CmcSurface, conformal_distortion, mean_curvature_of

Array = NDArray[np.float64]

# Faces whose area, per area of the domain, is below this part of the mean are at a branch point.
BRANCH = 0.01


@dataclass(frozen=True)
class Errors:
    """Errors of a sheet: |H - ½| in L² and L∞, mean of ½ (Q + 1/Q) - 1; without branch points."""

    l2: float
    linf: float
    distortion: float


def errors_of(surface: CmcSurface, sheet: str = "f+") -> Errors:
    """The errors of f+ or f- on the faces of the input, at mean curvature ½."""
    points, N = surface.sheet(sheet), surface.normals * (1.0 if sheet == "f+" else -1.0)
    error = np.abs(mean_curvature_of(points, surface.faces, N) - surface.mean_curvature)
    Q = conformal_distortion(surface.domain, points, surface.faces)
    a, b, c = (points[surface.faces[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    weights = surface.domain.face_areas
    good = areas / weights > BRANCH * areas.sum() / weights.sum()
    return Errors(
        l2=float(np.sqrt(np.average(error[good] ** 2, weights=areas[good]))),
        linf=float(error[good].max()),
        distortion=float(np.average((0.5 * (Q + 1 / Q) - 1)[good], weights=weights[good])),
    )


def curvature_errors(surface):
    """L² and L∞ errors of H over the area of f+."""
    H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
    a, b, c = (surface.f_plus[surface.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    error = H - surface.mean_curvature
    return np.sqrt(np.average(error**2, weights=areas)), np.abs(error).max()


# --- the distance between corresponding points, translation aside --------------------------


def centred(points):
    return points - points.mean(axis=0)


def worst(a, b):
    """Largest distance between corresponding points, translation aside."""
    return np.linalg.norm(centred(a) - centred(b), axis=1).max()


# --- the distance between two triangle meshes ----------------------------------------------


def hausdorff(points: Array, faces: Array, other_points: Array, other_faces: Array) -> float:
    """Hausdorff distance between two triangle meshes, from dense samples of each."""
    spacing = 0.01 * np.linalg.norm(np.ptp(points, axis=0))
    one, other = sampled(points, faces, spacing)[0], sampled(other_points, other_faces, spacing)[0]
    there = distances(one, other_points, other_faces, spacing)
    back = distances(other, points, faces, spacing)
    return float(max(there.max(), back.max()))


def sampled(points: Array, faces: Array, spacing: float) -> tuple[Array, NDArray[np.int64]]:
    """Points (n, 3) of a mesh, its vertices among them, at most about `spacing` apart, and the face of each (n,)."""
    corners = points[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.ceil(longest / spacing).astype(int)
    found, owners = [], []
    for n in np.unique(parts):
        i, j = (a.ravel() for a in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
        i, j = i[i + j <= n], j[i + j <= n]
        which = np.flatnonzero(parts == n)
        weights = np.column_stack([n - i - j, i, j]) / n
        found.append(np.einsum("sk,fkx->fsx", weights, corners[which]).reshape(-1, 3))
        owners.append(np.repeat(which, len(i)))
    return np.concatenate(found), np.concatenate(owners)


def distances(queries: Array, points: Array, faces: Array, spacing: float) -> Array:
    """Distance (n,) of each query to the mesh: exact to the faces that own its 8 nearest samples."""
    samples, owners = sampled(points, faces, spacing)
    nearest = owners[KDTree(samples).query(queries, k=8)[1]]
    best = np.full(len(queries), np.inf)
    for column in nearest.T:
        best = np.minimum(best, to_triangles(queries, points[faces[column]]))
    return best


def to_triangles(queries: Array, corners: Array) -> Array:
    """Distance (n,) of each query (n, 3) to its triangle (n, 3, 3): to its plane above it, else to an edge."""
    result = np.full(len(queries), np.inf)
    a = corners[:, 0]
    normal = np.cross(corners[:, 1] - a, corners[:, 2] - a)
    inside = np.ones(len(queries), dtype=bool)
    for k in range(3):
        p, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        inside &= np.einsum("ij,ij->i", np.cross(along, queries - p), normal) >= 0.0
        length = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        part = np.clip(np.einsum("ij,ij->i", queries - p, along) / length, 0.0, 1.0)
        result = np.minimum(result, np.linalg.norm(queries - p - part[:, None] * along, axis=1))
    size = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    height = np.abs(np.einsum("ij,ij->i", queries - a, normal)) / size
    return np.where(inside, height, result)
