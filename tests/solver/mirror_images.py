"""Domains and graphs glued to their mirror images, for tests of mirrors."""

from __future__ import annotations

import numpy as np

from solver import Domain, shapes
from solver.domain.sites import SiteGraph
from tests.solver.exact_surfaces import moved


def half_disc(n: int) -> tuple[Domain, np.ndarray, np.ndarray, np.ndarray]:
    """The upper half of `shapes.disc(n)`: domain, positions (V, 2), edges of the arc and of the diameter."""
    disc = shapes.disc(n)
    upper = disc.domain.faces[disc.positions[disc.domain.faces].mean(axis=1)[:, 1] > 0]
    used, faces = np.unique(upper, return_inverse=True)
    points = disc.positions[used]
    domain = Domain.from_positions(points, faces.reshape(-1, 3))
    rim = domain.boundary_edges
    is_flat = (np.abs(points[domain.edges[rim]][:, :, 1]) < 1e-9).all(axis=1)
    return domain, points, rim[~is_flat], rim[is_flat]


def doubled(points: np.ndarray, faces: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """A plane mesh at x >= 0 (axis 0) or y >= 0 (axis 1) with its mirror image; its own vertices come first."""
    image = np.arange(len(points))
    off = np.abs(points[:, axis]) > 1e-9
    image[off] = len(points) + np.arange(off.sum())
    turned = points[off] * np.where(np.arange(2) == axis, -1.0, 1.0)
    return np.concatenate([points, turned]), np.concatenate([faces, image[faces[:, ::-1]]])


def jittered_strip(width: float, height: float, columns: int, seed: int = 3) -> tuple[shapes.Shape, np.ndarray]:
    """A strip with its inside vertices moved at random; its sides keep their edges."""
    strip = shapes.strip(width, height, columns)
    inside = np.ones(strip.domain.vertex_count, dtype=bool)
    inside[strip.domain.boundary_vertices] = False
    points = moved(strip.positions, inside, 0.2 * width / columns, seed)
    return shapes.Shape(Domain.from_positions(points, strip.domain.faces), points, strip.sides), points


def doubled_graph(graph: SiteGraph, shared: np.ndarray) -> tuple[SiteGraph, np.ndarray]:
    """A graph and its copy, glued at the `shared` sites, and the number of each site of the copy."""
    off = np.setdiff1d(np.arange(graph.count), shared)
    image = np.arange(graph.count)
    image[off] = graph.count + np.arange(len(off))
    areas = np.concatenate([graph.areas, graph.areas[off]])
    areas[shared] *= 2.0
    links = np.concatenate([graph.links, image[graph.links]])
    whole = SiteGraph(graph.name, graph.domain, links, np.tile(graph.edges, 2), np.tile(graph.cells, (2, 1)), areas)
    whole.__dict__["weights"] = np.tile(graph.weights, 2)  # in place of those of the domain
    whole.__dict__["angles"] = np.tile(graph.angles, (2, 1))
    return whole, image


def reflect(N: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) reflected in the plane with this unit normal."""
    return N - 2.0 * (N @ normal)[:, None] * normal
