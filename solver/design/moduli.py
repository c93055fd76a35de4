"""Conformal moduli: numbers that change the shape of a domain, but neither its faces nor what is said on its boundary.

Around holes and handles the surface closes for certain conformal types of the domain only (paper, Sec. 5.3.3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import ConditionError, MeshError, plural
from ..gauss.dirichlet import Dirichlet
from ..gauss.frames import area_vectors, in_space
from ..gauss.sphere import dot

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Step of the central differences of edge weights, which are smooth functions of the moduli.
_STEP = 1e-5
# Cosine up to which a line counts as orthogonal.
_ORTHOGONAL = 1e-6


@dataclass(frozen=True, eq=False)
class Moduli:
    """names: of the m numbers. first: the domain at q = 0, where a search begins. lengths(q): its edge lengths (E,) at
    q (m,). ranges: the least and the largest of each number.

    Lengths are parts of the domain's size, angles are radians, so that numbers of one size mean changes of one size.
    """

    names: tuple[str, ...]
    first: Domain
    lengths: Callable[[Array], Array]
    ranges: tuple[tuple[float, float], ...]

    @classmethod
    def none(cls, domain: Domain) -> Moduli:
        return cls((), domain, lambda q: domain.edge_lengths, ())

    def domain(self, q: Array) -> Domain:
        """Raises `MeshError` where a face is turned over or flat."""
        return self.first.with_lengths(self.lengths(q)) if q.any() else self.first

    def weights(self, q: Array) -> Array:
        """(E, m) the derivatives of the cotangent weights at q."""
        columns = []
        for step in _STEP * np.eye(len(q)):
            ahead, back = self.domain(q + step).cotan_weights, self.domain(q - step).cotan_weights
            columns.append((ahead - back) / (2.0 * _STEP))
        return np.stack(columns, axis=1)

    def clipped(self, q: Array) -> Array:
        """q, or the nearest that is in range."""
        low, high = np.array(self.ranges).reshape(-1, 2).T
        return np.clip(q, low, high)


def hole(domain: Domain, positions: ArrayLike, loop: int, motions: tuple[str, ...] = ("x", "y", "twist")) -> Moduli:
    """A hole of a plan that moves: `motions` of x, y (parts of the plan's size), twist (radians), size (logarithm).

    positions: (V, 2|3) of the plan, loop: which of `domain.boundary_loops` bounds the hole. The plan around it goes
    along, the less the nearer to the other loops (harmonically); what is said on the boundary stays. It moves by at
    most half the plan's size and turns by at most half a turn.
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

    ahead = area_vectors(points, domain.faces)
    i, j = domain.edges.T

    def moved(q: Array) -> Array:
        goal = points
        for name, number in zip(motions, q, strict=True):
            goal = _MOTIONS[name][0](goal, centre, size, float(number))
        now = points + share * (goal - points)
        turned = np.flatnonzero(dot(area_vectors(now, domain.faces), ahead)[:, 0] <= 0.0)
        if turned.size:
            raise MeshError(f"The hole has moved so far that {plural('face', turned)} turned over.", faces=turned)
        return np.linalg.norm(now[j] - now[i], axis=1)

    return Moduli(motions, domain, moved, tuple(_MOTIONS[name][1] for name in motions))


def _shifted(axis: int) -> Callable[[Array, Array, float, float], Array]:
    return lambda points, centre, size, number: points + number * size * np.eye(3)[axis]


def _twisted(points: Array, centre: Array, size: float, number: float) -> Array:
    turn = np.array([[np.cos(number), -np.sin(number), 0], [np.sin(number), np.cos(number), 0], [0, 0, 1]])
    return centre + (points - centre) @ turn.T


def _grown(points: Array, centre: Array, size: float, number: float) -> Array:
    return centre + np.exp(number) * (points - centre)


# Each with the range of its number.
_MOTIONS = {
    "x": (_shifted(0), (-0.5, 0.5)),
    "y": (_shifted(1), (-0.5, 0.5)),
    "twist": (_twisted, (-np.pi, np.pi)),
    "size": (_grown, (-2.0, 2.0)),
}


def tube(
    domain: Domain,
    corners: ArrayLike,
    faces: ArrayLike,
    axis: ArrayLike,
    name: str = "length",
    stretch: tuple[float, float] = (0.05, 20.0),
) -> Moduli:
    """A part of a flat domain that is stretched along an axis; the number is the logarithm of the stretch.

    corners: (F, 3, 2|3) of each triangle, unrolled: a cylinder, strips that are glued. faces: (n,) those of the part,
    whose borders to the others must be orthogonal to the axis (2|3,), since they keep their lengths. stretch: the least
    and the most.
    """
    return tubes(domain, corners, {name: (faces, axis)}, stretch)


def tubes(
    domain: Domain,
    corners: ArrayLike,
    parts: Mapping[str, tuple[ArrayLike, ArrayLike]],
    stretch: tuple[float, float] = (0.05, 20.0),
) -> Moduli:
    """Several parts, each of which is stretched along an axis of its own: name → (faces, axis) as in `tube`."""
    flat = np.asarray(corners, dtype=np.float64)
    taken = np.zeros(len(domain.faces), dtype=bool)
    chosen = []
    for name, (faces, axis) in parts.items():
        part, along = np.asarray(faces, dtype=np.int64), np.asarray(axis, dtype=np.float64)
        if taken[part].any():
            raise ConditionError(f"Tube {name!r} has faces of another one; give each face to one tube.")
        taken[part] = True
        along = along / np.linalg.norm(along)
        _check_border(domain, flat, part, along)
        chosen.append((part, along))
    place = domain.half_edges[:, 0]  # of each edge as its left face has it

    def stretched(q: Array) -> Array:
        moved = flat.copy()
        for number, (part, along) in zip(q, chosen, strict=True):
            moved[part] += (np.expm1(number) * (flat[part] @ along))[..., None] * along
        lengths = np.linalg.norm(np.roll(moved, 1, axis=1) - np.roll(moved, -1, axis=1), axis=2)
        return lengths.ravel()[place]

    low, high = np.log(stretch)
    return Moduli(tuple(parts), domain, stretched, ((float(low), float(high)),) * len(chosen))


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
