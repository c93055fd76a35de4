"""Panels made flat: the nodes that are nearest to a net whose panels on f+, g and f- are planar and parallel.

Unknowns are the nodes X and axes n, near the normals: g and f- have nodes X - n / 2H and X - n / H. Where e × dn = 0
along a beam, e and dn the differences of its ends, the beams of the three sheets are parallel, and their panels are
planar together; the node then has no torsion either. Inner panels are parallel so; clipped ones are planar on f+ alone,
and other beams have coplanar axes, det(n_i, n_j, e) = 0. Gauss–Newton steps of least norm solve these equations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..errors import ConditionError, Progress
from ..gauss.sphere import normalize
from ..linalg import factorize
from ..signatures import checked
from .net import Net
from .panel_measures import vector_area

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Residuals are parts of the side; below this one the panels are flat.
_FLAT = 1e-11
_MOST_STEPS = 25
# The weight of the step's norm beside the equations: at first, its change from step to step, and at last, where the
# matrix can still be factored although equations depend on each other.
_DAMPING, _LESS, _LEAST = 1e-6, 0.3, 1e-9
# Clipped beams shorter than this part of the side have no direction to hold.
_SHORT = 0.15


@checked
def planarise(net: Net, *, keep_rim: bool = False, progress: Progress | None = None) -> Net:
    """The net with flat panels: its `vertices`, `normals` and `axes`, and how far each node has `moved`.

    Whole panels are planar on f+, g and f-, at the nodes X, X - axes / 2H and X - axes / H, with parallel beams;
    clipped ones on the sheet of the net. keep_rim: nodes on the rim stay, and only whole panels become planar.
    `flatness` is what is left, as a part of the side. progress: called with each step and what is left before it;
    returning False ends the work with the nodes as they are then.

    Raises `ConditionError` on diagonal nets, whose panels are twisted.
    """
    if net.kind != "principal":
        raise ConditionError("The panels of a diagonal net are twisted; triangulate them, or take the principal net.")
    equations = _Equations.of(net, keep_rim)
    X, axes = net.vertices.copy(), net.normals.copy()
    residual, damping = equations.residual(X, axes), _DAMPING
    for number in range(_MOST_STEPS):
        left = float(np.abs(residual).max(initial=0.0))
        if left < _FLAT or (progress is not None and progress(number, left) is False):
            break
        step = equations.step(X, axes, residual, damping)
        X, axes = X + step[:, :3], axes + step[:, 3:]
        residual, damping = equations.residual(X, axes), max(_LESS * damping, _LEAST)
    return replace(
        net,
        vertices=X,
        normals=normalize(axes),
        axes=axes,
        moved=np.linalg.norm(X - net.vertices, axis=1),
        flatness=float(np.abs(residual).max(initial=0.0)),
    )


@dataclass(frozen=True, eq=False)
class _Equations:
    """Planar corners (p, 4), three of a panel and another one; parallel and coplanar beams (b, 2); `held` nodes.

    Residuals are parts of the side, and angles. Beams are measured by their lengths in the net at the `start` (n, 3):
    divided by its own length, a short beam could satisfy its equation by vanishing.
    """

    count: int
    side: float
    planar: Int
    parallel: Int
    coplanar: Int
    held: NDArray[np.bool_]
    start: Array

    @classmethod
    def of(cls, net: Net, keep_rim: bool) -> _Equations:
        side = float(np.median(net.side_lengths))
        panels = net.inner if keep_rim else np.arange(len(net.polygons))
        planar = [_fan(net.vertices, net.polygons[panel]) for panel in panels]
        inside = {pair for panel in net.inner for pair in _sides(net.polygons[panel])}
        lines = net.edges[net.family >= 0]
        is_parallel = np.array([(int(i), int(j)) in inside or (int(j), int(i)) in inside for i, j in lines], dtype=bool)
        lengths = np.linalg.norm(net.vertices[lines[:, 1]] - net.vertices[lines[:, 0]], axis=1)
        held = np.zeros(len(net.vertices), dtype=bool)
        if keep_rim:
            held[net.edges[net.family < 0]] = True
        return cls(
            len(net.vertices),
            side,
            np.concatenate([*planar, np.zeros((0, 4), dtype=np.int64)]).astype(np.int64),
            lines[is_parallel],
            lines[~is_parallel & (lengths >= _SHORT * side)],
            held,
            net.vertices,
        )

    def residual(self, X: Array, axes: Array) -> Array:
        flat = _heights(X, self.planar) / self.side
        e, dn, size = self._beams(X, axes, self.parallel)
        along = np.cross(e, dn) / size[:, None]
        i, j = self.coplanar.T
        e, _, size = self._beams(X, axes, self.coplanar)
        twist = np.einsum("bi,bi->b", np.cross(axes[i], axes[j]), e) / size
        return np.concatenate([flat, along.ravel(), twist])

    def step(self, X: Array, axes: Array, residual: Array, damping: float) -> Array:
        """The step (n, 6) of X and axes: (JᵀJ + damping W) d = -Jᵀ r, W = 1 / side² on X and 1 on axes."""
        J = self.jacobian(X, axes)
        free = np.flatnonzero(np.repeat(~self.held, 6) | np.tile([False] * 3 + [True] * 3, self.count))
        J = sp.csr_array(J[:, free])
        weight = np.tile([1.0 / self.side**2] * 3 + [1.0] * 3, self.count)[free]
        A = sp.csr_array(J.T @ J + sp.diags_array(damping * weight))
        step = np.zeros(6 * self.count)
        step[free] = -factorize(A).solve(J.T @ residual)
        return step.reshape(-1, 6)

    def jacobian(self, X: Array, axes: Array) -> sp.csr_array:
        """(r, 6 n) derivative of `residual`, the lengths it is divided by held; rows as there."""
        rows, cols, data = [], [], []

        def add(row: Int, node: Int, part: int, vectors: Array) -> None:
            rows.append(np.repeat(row, 3))
            cols.append((6 * node[:, None] + 3 * part + np.arange(3)).ravel())
            data.append(vectors.ravel())

        a, b, c, v = self.planar.T
        p, q, r = X[b] - X[a], X[c] - X[a], X[v] - X[a]
        normal = np.cross(p, q)
        scale = 1.0 / (np.linalg.norm(normal, axis=1, keepdims=True) * self.side)
        row = np.arange(len(a))
        by_b, by_c, by_v = np.cross(q, r) * scale, np.cross(r, p) * scale, normal * scale
        for node, vectors in ((b, by_b), (c, by_c), (v, by_v), (a, -(by_b + by_c + by_v))):
            add(row, node, 0, vectors)
        start = len(a)
        i, j = self.parallel.T
        e, dn, size = self._beams(X, axes, self.parallel)
        for k in range(3):
            unit = np.eye(3)[k]
            row = start + 3 * np.arange(len(i)) + k
            # component k of e × dn: its gradients are dn × unit in e and unit × e in dn
            by_e, by_dn = np.cross(dn, unit) / size[:, None], np.cross(unit, e) / size[:, None]
            for node, part, vectors in ((j, 0, by_e), (i, 0, -by_e), (j, 1, by_dn), (i, 1, -by_dn)):
                add(row, node, part, vectors)
        start += 3 * len(i)
        i, j = self.coplanar.T
        e, _, size = self._beams(X, axes, self.coplanar)
        row = start + np.arange(len(i))
        by_e = np.cross(axes[i], axes[j]) / size[:, None]
        by_i, by_j = np.cross(axes[j], e) / size[:, None], np.cross(e, axes[i]) / size[:, None]
        for node, part, vectors in ((j, 0, by_e), (i, 0, -by_e), (i, 1, by_i), (j, 1, by_j)):
            add(row, node, part, vectors)
        shape = (start + len(i), 6 * self.count)
        return sp.csr_array(
            sp.coo_array((np.concatenate(data), (np.concatenate(rows), np.concatenate(cols))), shape=shape)
        )

    def _beams(self, X: Array, axes: Array, beams: Int) -> tuple[Array, Array, Array]:
        """e, dn (b, 3) and the length of e at the start (b,)."""
        i, j = beams.T
        return X[j] - X[i], axes[j] - axes[i], np.linalg.norm(self.start[j] - self.start[i], axis=1)


def _heights(X: Array, planar: Int) -> Array:
    """The distance (p,) of the fourth of each corners from the plane through the first three."""
    a, b, c, v = (X[planar[:, k]] for k in range(4))
    normal = np.cross(b - a, c - a)
    return np.einsum("pi,pi->p", normal, v - a) / np.linalg.norm(normal, axis=1)


def _sides(polygon: Int) -> list[tuple[int, int]]:
    corners = polygon.tolist()
    return list(zip(corners, corners[1:] + corners[:1], strict=True))


def _fan(X: Array, polygon: Int) -> Int:
    """The three corners of a panel with the largest triangle, with each of the others, (k - 3, 4)."""
    corners = polygon.tolist()
    triples = np.array(list(combinations(range(len(corners)), 3)))
    areas = np.linalg.norm(vector_area(X[polygon[triples]]), axis=1)
    best = triples[int(np.argmax(areas))]
    rest = np.setdiff1d(np.arange(len(corners)), best)
    return np.column_stack([np.tile(polygon[best], (len(rest), 1)), polygon[rest]])
