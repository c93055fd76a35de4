"""Outlines for Mesh Plan alone: what it refuses, and whether what it makes is a mesh of the plan."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solver.meshing.mesher import PlanMesh, mesh_plan
from solver.meshing.quality import smallest_angles

from .case import Case, Result, pick
from .outlines import drawn, edge_for


def case(rng: np.random.Generator, folder: Path) -> Case:
    name, outline, holes = drawn(rng)
    max_edge = edge_for(rng, outline, (10, 800))
    radius = pick(rng, [0.0, 0.0, 1.0, 3.0, 30.0]) * abs(max_edge)
    keep = [rng.integers(-1, len(outline) + 1, 3).tolist()] if rng.random() < 0.1 else []
    text = f"{name}, {len(outline)} points, {len(holes)} holes, max_edge {max_edge:.3g}, corner_radius {radius:.3g}"
    return Case(text, lambda: _checked(mesh_plan(outline, holes, max_edge=max_edge, corner_radius=radius, keep=keep)))


def _checked(mesh: PlanMesh) -> Result:
    """A mesh whose triangles are all the right way round, and whose rim is the boundary of its triangles."""
    if not (smallest_angles(mesh.positions, mesh.triangles) > 0.0).all():
        raise AssertionError("a triangle is flat or the wrong way round")
    tails, heads = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    pairs = set(zip(tails.tolist(), heads.tolist(), strict=True))
    rim = {(a, b) for a, b in pairs if (b, a) not in pairs}
    if rim != set(map(tuple, mesh.edges.tolist())):
        raise AssertionError("the edges are not the boundary of the triangles")
    return Result(numbers={"positions": mesh.positions})
