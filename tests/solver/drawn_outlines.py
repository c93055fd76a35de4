"""Outlines of plans, and a check that a mesh fills its boundary."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain
from solver.meshing.mesher import PlanMesh
from solver.meshing.outline import signed_area

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
L_SHAPE = np.array([[0.0, 0.0], [12.0, 0.0], [12.0, 4.0], [5.0, 4.0], [5.0, 10.0], [0.0, 10.0]])


def ellipse(count: int, a: float, b: float, centre=(0.0, 0.0)) -> np.ndarray:
    t = 2 * np.pi * np.arange(count) / count
    return np.column_stack([centre[0] + a * np.cos(t), centre[1] + b * np.sin(t)])


def check(mesh: PlanMesh) -> Domain:
    """The mesh covers exactly what its boundary edges bound, and its boundary is those edges."""
    domain = Domain.from_positions(mesh.positions, mesh.triangles)
    assert domain.euler_characteristic == 1 - mesh.loop.max()
    rim = domain.edges[domain.boundary_edges]
    assert_array_equal(rim[np.argsort(rim[:, 0])], mesh.edges)
    bounded = sum(signed_area(mesh.positions[mesh.edges[mesh.loop == k, 0]]) for k in range(mesh.loop.max() + 1))
    assert_allclose(domain.area, bounded, rtol=1e-11)
    assert domain.vertex_count == len(mesh.positions)
    return domain
