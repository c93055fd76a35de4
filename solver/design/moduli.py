"""Conformal moduli: numbers that change the shape of a domain, but neither its faces nor what is said on its boundary.

Around holes and handles the surface closes for certain conformal types of the domain only (paper, Sec. 5.3.3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import ConditionError, plural
from ..gauss.dirichlet import Dirichlet
from ..gauss.frames import in_space

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Step of the central differences of edge weights, which are smooth functions of the moduli.
_STEP = 1e-5
# Cosine up to which a line counts as orthogonal.
_ORTHOGONAL = 1e-6


@dataclass(frozen=True, eq=False)
class Moduli:
    """names: of the m numbers. domain(q): for q (m,), all with the same faces; q = 0 is where a search begins.

    Lengths are parts of the domain's size, angles are radians, so that numbers of one size mean changes of one size.
    """

    names: tuple[str, ...]
    domain: Callable[[Array], Domain]

    def weights(self, q: Array) -> Array:
        """(E, m) the derivatives of the cotangent weights at q."""
        columns = []
        for step in _STEP * np.eye(len(q)):
            ahead, back = self.domain(q + step).cotan_weights, self.domain(q - step).cotan_weights
            columns.append((ahead - back) / (2.0 * _STEP))
        return np.stack(columns, axis=1)


def hole(domain: Domain, positions: ArrayLike, loop: int, motions: tuple[str, ...] = ("x", "y", "twist")) -> Moduli:
    """A hole of a plan that moves: `motions` of x, y (parts of the plan's size), twist (radians), size (logarithm).

    positions: (V, 2|3) of the plan, loop: which of `domain.boundary_loops` bounds the hole. The plan around it goes
    along, the less the nearer to the other loops (harmonically); what is said on the boundary stays.
    """
    points = in_space(domain, positions)
    unknown = [name for name in motions if name not in _MOTIONS]
    if unknown:
        raise ConditionError(f"There is no motion {unknown[0]!r} of a hole; known are {', '.join(_MOTIONS)}.")
    if not 0 <= loop < len(domain.boundary_loops):
        raise ConditionError(f"There is no boundary loop {loop}; the plan has {len(domain.boundary_loops)}.")
    rim = domain.boundary_vertices.astype(np.int64)
    graph = SiteGraph.of(domain, "vertices")
    on_hole = np.isin(rim, domain.boundary_loops[loop]).astype(np.float64)
    share = Dirichlet(graph, graph.weights, rim).extend(on_hole[:, None])
    centre = points[domain.boundary_loops[loop]].mean(axis=0)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))

    def moved(q: Array) -> Domain:
        goal = points
        for name, number in zip(motions, q, strict=True):
            goal = _MOTIONS[name](goal, centre, size, float(number))
        return Domain.from_positions(points + share * (goal - points), domain.faces)

    return Moduli(motions, moved)


def _shifted(axis: int) -> Callable[[Array, Array, float, float], Array]:
    return lambda points, centre, size, number: points + number * size * np.eye(3)[axis]


def _twisted(points: Array, centre: Array, size: float, number: float) -> Array:
    turn = np.array([[np.cos(number), -np.sin(number), 0], [np.sin(number), np.cos(number), 0], [0, 0, 1]])
    return centre + (points - centre) @ turn.T


def _grown(points: Array, centre: Array, size: float, number: float) -> Array:
    return centre + np.exp(number) * (points - centre)


_MOTIONS = {"x": _shifted(0), "y": _shifted(1), "twist": _twisted, "size": _grown}


def tube(domain: Domain, corners: ArrayLike, faces: ArrayLike, axis: ArrayLike, name: str = "length") -> Moduli:
    """A part of a flat domain that is stretched along an axis; the number is the logarithm of the stretch.

    corners: (F, 3, 2|3) of each triangle, unrolled: a cylinder, strips that are glued. faces: (n,) those of the part,
    whose borders to the others must be orthogonal to the axis (2|3,), since they keep their lengths.
    """
    flat = np.asarray(corners, dtype=np.float64)
    along = np.asarray(axis, dtype=np.float64)
    along = along / np.linalg.norm(along)
    part = np.asarray(faces, dtype=np.int64)
    _check_border(domain, flat, part, along)

    def stretched(q: Array) -> Domain:
        moved = flat.copy()
        moved[part] += (np.expm1(q[0]) * (flat[part] @ along))[..., None] * along
        lengths = np.linalg.norm(np.roll(moved, 1, axis=1) - np.roll(moved, -1, axis=1), axis=2)
        return Domain.from_edge_lengths(domain.faces, lengths, face_edges=domain.face_edges)

    return Moduli((name,), stretched)


def _check_border(domain: Domain, flat: Array, part: Int, along: Array) -> None:
    """Refuse a part whose edges to the rest would be stretched."""
    inside = np.zeros(len(domain.faces), dtype=bool)
    inside[part] = True
    left, right = domain.edge_faces.T
    border = np.flatnonzero((right >= 0) & (inside[left] != inside[right]))
    half = domain.half_edges[border]
    own = np.where(inside[left[border]], half[:, 0], half[:, 1])
    sides = flat[own // 3, (own + 2) % 3] - flat[own // 3, (own + 1) % 3]
    leaning = border[np.abs(sides @ along) > _ORTHOGONAL * np.linalg.norm(sides, axis=1)]
    if leaning.size:
        raise ConditionError(
            f"The border of the stretched part is not orthogonal to its axis at {plural('edge', leaning)}; it keeps "
            "its length, so the part has to end on a line across.",
            edges=leaning,
        )
