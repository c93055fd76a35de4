"""The volume under a sheet: between it and the level of its rim, as the fits have it (docs/explanation/fitting.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array, Indices

if TYPE_CHECKING:
    from ..domain.domain import Domain


def volume_over(points: Array, faces: Indices, up: Array, level: float = 0.0) -> float:
    """Σ_f (area seen from above) × (mean height over `level`), with the sign of the faces as seen from above.

    points (n, 3), faces (F, 3), up (3,) a unit vector. Over a closed surface the level drops out: the volume inside.
    """
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a) @ up
    return float(np.sum(area * ((a + b + c) @ up / 3.0 - level)))


def sheet_volume(domain: Domain, points: Array, faces: Indices, up: Array) -> float:
    """The volume between a sheet and the mean height of its outer rim; what lies below counts as negative.

    A closed sheet has the volume inside it. The faces may look down as well as up.
    """
    if not len(domain.boundary_edges):
        return abs(volume_over(points, faces, up))
    a, b, c = (points[faces[:, k]] for k in range(3))
    seen = float(np.sum(np.cross(b - a, c - a) @ up))
    return (-1.0 if seen < 0 else 1.0) * volume_over(points, faces, up, rim_height(domain, points, faces, up))


def rim_height(domain: Domain, points: Array, faces: Indices, up: Array) -> float:
    """The mean height of the outer boundary loop, by length: of several the one with the largest area from above."""
    face, corner = np.nonzero(domain.edge_faces[domain.face_edges, 1] < 0)
    edge = domain.face_edges[face, corner]
    loop = np.empty(len(domain.edge_lengths), dtype=np.int64)
    for number, edges in enumerate(domain.boundary_loop_edges):
        loop[edges] = number
    p, q = (points[faces[face, (corner + k) % 3]] for k in (1, 2))
    p, q, owner = p - points.mean(axis=0), q - points.mean(axis=0), loop[edge]
    outer = int(np.argmax(np.abs(np.bincount(owner, np.cross(p, q) @ up))))
    mine = owner == outer
    lengths = np.linalg.norm(q[mine] - p[mine], axis=1)
    heights = 0.5 * (p[mine] + q[mine]) @ up
    return float(points.mean(axis=0) @ up + np.average(heights, weights=lengths if lengths.any() else None))
