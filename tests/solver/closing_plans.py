"""Plans whose surfaces do not close by themselves: courtyards, three holes, a piece of a ring of tubes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver import Conditions, Domain, Side, conditions, shapes

COURTYARDS = {
    "one hole": (1.2, [(0.4, (0.25, 0.1))], (50, 35)),
    "three holes": (1.1, [(0.22, (0.45, 0.3)), (0.22, (-0.45, 0.25)), (0.22, (0.0, -0.5))], (35, 17, 29, 40)),
}


def ring(radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, 480, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + centre


def courtyard(edge: float, name: str = "one hole") -> tuple[shapes.Shape, Conditions]:
    """A round plan with holes off its centre, and tilts, in degrees, that are unequal and slope by 10° a unit."""
    radius, holes, degrees = COURTYARDS[name]
    shape = shapes.polygon(ring(radius), holes=[ring(*hole) for hole in holes], max_edge=edge)
    held = Conditions()
    for k, tilt in enumerate(degrees):
        edges = shape.sides["outer" if k == 0 else f"hole{k - 1}"]
        middles = shape.positions[shape.domain.edges[edges]].mean(axis=1)
        tilts = np.radians(tilt + 10 * middles[:, min(k, 1)])
        held += conditions.binormal(shape.domain, shape.positions, edges, tilts)
    return shape, held


@dataclass(frozen=True, eq=False)
class Elbow:
    """A piece of a closed ring of tubes with spokes, between mirrors, on an L-shaped plan (see `elbow`).

    corners: (F, 3, 2) of the faces. tube: the faces of the part of the ring that may be stretched, along y. start: (V,
    3) normals to begin with.
    """

    domain: Domain
    corners: np.ndarray
    tube: np.ndarray
    held: Conditions
    sides: dict[str, Side]
    start: np.ndarray


def elbow(columns: int = 12, spokes: int = 12, length: float = 1 / 6, spoke: float = 1 / 4) -> Elbow:
    """The upper half of half a node of the ring, between the plane of its spoke and that across the ring's tube.

    The plan is a unit square, a strip of the length of the `spoke` to its right, and one of the `length` of the ring's
    tube above, both a whole number of columns. Mirrors: "axis", the plane of the spoke; "end", across it; "ring",
    across the tube, at 180° / spokes from the axis; and the floor, twice: "outside" and "inside" of the ring. These
    come out at different heights.
    """
    points, faces = _grid(columns, length, spoke)
    domain = Domain.from_positions(points, faces)
    rim = domain.boundary_edges
    x, y = points[domain.edges[rim]].mean(axis=1).T
    edges = {"axis": rim[y < 1e-9], "end": rim[x > points[:, 0].max() - 1e-9]}
    edges |= {"ring": rim[y > points[:, 1].max() - 1e-9], "inside": rim[x < 1e-9]}
    edges["outside"] = np.setdiff1d(rim, np.concatenate(list(edges.values())))
    half = np.pi / spokes
    normals = {"axis": (0, -1, 0), "end": (1, 0, 0), "ring": (-np.sin(half), np.cos(half), 0)}
    normals |= {"inside": (0, 0, -1), "outside": (0, 0, -1)}
    held = Conditions()
    for name, normal in normals.items():
        held += conditions.mirror(domain, edges[name], normal)
    sides = {name: Side(name, edges[name], normal=normals[name]) for name in edges}
    corners = points[domain.faces]
    tube = np.flatnonzero(corners[:, :, 1].mean(axis=1) > 1)
    return Elbow(domain, corners, tube, held, sides, _bent(points, half))


def _grid(columns: int, length: float, spoke: float) -> tuple[np.ndarray, np.ndarray]:
    """Right triangles with alternating diagonals."""
    across, up = columns + round(columns * spoke), columns + round(columns * length)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(across), np.arange(up), indexing="ij"))
    inside = (i < columns) | (j < columns)
    i, j = i[inside], j[inside]
    a, b, c, d = ((i + k) * (up + 1) + j + m for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    even = ((i + j) % 2 == 0)[:, None]
    halves = np.where(even, np.column_stack([a, b, c, a, c, d]), np.column_stack([a, b, d, b, c, d]))
    used, faces = np.unique(halves, return_inverse=True)
    return np.column_stack([used // (up + 1), used % (up + 1)]) / columns, faces.reshape(-1, 3)


def _bent(points: np.ndarray, half: float) -> np.ndarray:
    """Normals (V, 3) of two round tubes that blend into each other along the diagonal."""
    x, y = np.clip(points, 0, 1).T[:, :, None]
    out, up, aside = np.array([np.cos(half), np.sin(half), 0]), np.array([0, 0, 1]), np.array([0, 1, 0])
    ring = np.sin(np.pi * x) * up - np.cos(np.pi * x) * out
    spoke = np.cos(0.5 * np.pi * y) * up + np.sin(0.5 * np.pi * y) * aside
    share = np.clip(0.5 + 0.5 * (points[:, :1] - points[:, 1:]), 0, 1)
    N = share * spoke + (1 - share) * ring
    return N / np.linalg.norm(N, axis=1)[:, None]
