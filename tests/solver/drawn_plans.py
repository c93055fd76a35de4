"""Plans drawn as a disc or a grid of squares, and their boundary edges."""

from __future__ import annotations

import numpy as np

from solver.io.polygons import triangulate_polygons
from solver.shells.plan import Plan, plan_domain


def disc(rings: int = 8, radius: float = 5.0, centre: tuple[float, float, float] = (0, 0, 0)) -> Plan:
    """A hexagonal disc; ring k has 6k vertices, the last 6 · rings are the boundary."""
    points, triangles = [np.zeros((1, 2))], []
    start, inner = 1, [0]
    for k in range(1, rings + 1):
        angles = 2 * np.pi * np.arange(6 * k) / (6 * k)
        points.append(k / rings * np.column_stack([np.cos(angles), np.sin(angles)]))
        ring = list(range(start, start + 6 * k))
        for side in range(6):
            for step in range(k):
                a, b = ring[side * k + step], ring[(side * k + step + 1) % (6 * k)]
                c = inner[(side * (k - 1) + step) % len(inner)]
                triangles.append((a, b, c))
                if step:
                    triangles.append((inner[side * (k - 1) + step - 1], a, c))
        start, inner = start + 6 * k, ring
    flat = radius * np.vstack(points)
    return Plan(np.column_stack([flat, np.zeros(len(flat))]) + centre, np.array(triangles))


def grid(columns: int, rows: int, size: float = 1.0, hole: bool = False) -> Plan:
    """Quads; `hole` leaves out the middle third each way."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    points = size * np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]).astype(float)
    index = np.arange(len(points)).reshape(rows + 1, columns + 1)
    quads = [
        np.array([index[j, i], index[j, i + 1], index[j + 1, i + 1], index[j + 1, i]])
        for j in range(rows)
        for i in range(columns)
        if not (hole and columns <= 3 * i < 2 * columns and rows <= 3 * j < 2 * rows)
    ]
    used, corners = np.unique(np.concatenate(quads), return_inverse=True)
    quads = list(corners.reshape(-1, 4))
    triangles, owner = triangulate_polygons(points[used], quads)
    return Plan(points[used], triangles, quads, triangle_polygons=owner)


def boundary_pairs(plan: Plan) -> np.ndarray:
    domain = plan_domain(plan)
    return domain.edges[domain.boundary_edges]
