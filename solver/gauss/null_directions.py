"""Null directions, infinitesimal symmetries of the energy: rotations of the sphere, translations of a flat domain."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..domain.trees import Tree
from ..errors import MeshError, plural
from ..linalg import sum_rows
from .problem import EnergyProblem

Array = NDArray[np.float64]
Fields = Callable[[Array], Array]

# A rotation that moves fixed normals by less, in radians, respects them.
_UNMOVED = 1e-7
# Sides of an edge with a smaller angle between them, in radians, are parallel: rounding of lengths in single precision
# adds up to 3e-5 on a torus of 16000 vertices.
_PARALLEL = 1e-4


def free_rotations(problem: EnergyProblem, N: Array) -> Array:
    """Axes (k, 3) of the rotations of the sphere that keep the conditions.

    All three where nothing is held, one where all fixed normals and all normals of mirrors are parallel, else none.
    N: (S, 3) with the fixed normals.
    """
    held = np.concatenate([N[problem.dirichlet.fixed], problem.mirrors.normals])
    moved = len(held) * np.eye(3) - held.T @ held  # <a, · a> = Σ |a × held_i|²
    values, axes = np.linalg.eigh(moved)
    return axes.T[values <= _UNMOVED**2 * max(len(held), 1)]


def drifts(problem: EnergyProblem, N: Array) -> Fields | None:
    """The translations of a flat domain whose held normals at vertices are constant along each boundary; else None.

    They keep the energy up to the resolution of the mesh. N: (S, 3) with the fixed normals.
    """
    graph = problem.graph
    if not graph.at_vertices:
        return None
    rim = graph.domain.edges[graph.domain.boundary_edges]
    held = rim[np.isin(rim, problem.dirichlet.fixed).all(axis=1)]
    if np.abs(N[held[:, 0]] - N[held[:, 1]]).max(initial=0.0) > _UNMOVED:
        return None
    try:
        return translations(graph.domain)
    except MeshError:
        return None


def translations(domain: DomainLike) -> Fields:
    """N (V, 3) ↦ its derivatives (k, V, 3) along the translations of a flat domain: k = 2 on a torus, 1 on a cylinder.

    They keep the energy up to the resolution of the mesh, if the boundary data are constant along each loop. Raises
    `MeshError` if the domain is not flat, turns around a loop, or has a boundary that is not straight.
    """
    domain = as_domain(domain)
    corners = parallel_layout(domain)
    rim = domain.half_edges[domain.boundary_edges, 0]
    along = corners[rim // 3, (rim + 2) % 3] - corners[rim // 3, (rim + 1) % 3]
    along /= np.linalg.norm(along, axis=1)[:, None]
    values, axes = np.linalg.eigh(len(along) * np.eye(2) - along.T @ along)
    directions = axes.T[values <= _PARALLEL * max(len(along), 1)]
    if not len(directions):
        raise MeshError("The boundary of this domain is not straight, so no translation takes it into itself.")
    sides = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)  # opposite each corner
    turned = np.stack([-sides[:, :, 1], sides[:, :, 0]], axis=2)  # twice the area times the gradients
    total = 2.0 * sum_rows(domain.faces.ravel(), np.repeat(domain.face_areas, 3), domain.vertex_count)
    rows = np.repeat(domain.faces, 3, axis=1).ravel()
    columns = np.tile(domain.faces, (1, 3)).ravel()
    shape = (domain.vertex_count, domain.vertex_count)
    means = []
    for direction in directions:
        slopes = np.tile(turned @ direction, (1, 3)).ravel() / total[rows]
        means.append(sp.csr_array((slopes, (rows, columns)), shape=shape))
    return lambda N: np.stack([mean @ N for mean in means])


def parallel_layout(domain: Domain) -> Array:
    """Corners (F, 3, 2) of the faces of a flat domain, turned so that edges are parallel in both their faces.

    Raises `MeshError`, naming edges, if no such layout exists.
    """
    inside = domain.interior_edges
    angles = []
    for half in domain.half_edges[inside].T:
        side = domain.layout[half // 3, (half + 2) % 3] - domain.layout[half // 3, (half + 1) % 3]
        angles.append(np.arctan2(side[:, 1], side[:, 0]))
    pairs = domain.edge_faces[inside]
    turn = angles[1] + np.pi - angles[0]
    total = Tree.of(pairs, len(domain.faces)).integrate(turn[:, None])[:, 0]
    off = total[pairs[:, 0]] - total[pairs[:, 1]] - turn
    bad = inside[np.abs(np.exp(1j * off) - 1.0) > _PARALLEL]
    if bad.size:
        raise MeshError(f"This domain is not flat: its faces cannot be made parallel across {plural('edge', bad)}.")
    cosine, sine = np.cos(total), np.sin(total)
    turns = np.stack([np.stack([cosine, sine], axis=1), np.stack([-sine, cosine], axis=1)], axis=1)
    return np.asarray(np.einsum("fkx,fxy->fky", domain.layout, turns))
