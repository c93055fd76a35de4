"""A plan of quads and job files beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solver.io.obj import MeshData


def quad_plan(columns: int = 6, rows: int = 4) -> MeshData:
    """A grid of quads with two materials, a seam in its UVs, and the bottom as a polyline group."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    index = np.arange(x.size).reshape(rows + 1, columns + 1)
    quads = [
        np.array([index[j, i], index[j, i + 1], index[j + 1, i + 1], index[j + 1, i]], dtype=np.int32)
        for j in range(rows)
        for i in range(columns)
    ]
    left = [quad[0] % (columns + 1) < columns // 2 for quad in quads]
    uv = np.column_stack([x.ravel() / columns, y.ravel() / rows])
    bottom = np.column_stack([index[0, :-1], index[0, 1:]]).astype(np.int32)
    return MeshData(
        positions=np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]),
        polygons=quads,
        uvs=np.vstack([uv, uv + [2.0, 0.0]]),
        uv_corners=[quad if one else quad + len(uv) for quad, one in zip(quads, left, strict=True)],
        objects=["plan"] * len(quads),
        groups=["west" if one else "east" for one in left],
        materials=["glass" if one else "oak" for one in left],
        edge_groups={"bottom": bottom},
    )


def job(folder: Path, text: str) -> Path:
    path = folder / "job.toml"
    path.write_text(text)
    return path


PLAN = 'mesh = "plan.obj"\n'
