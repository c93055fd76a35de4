"""Plans laid anew, for lines to which the drawn plan is too unlike: under the lines, or as a surface rolled out.

A conformal map is smooth up to a corner only where plan and surface have the same angle there. The rolled-out plan has
the surface's angles and lengths along its outline; what the Gauss curvature is too much or too little for a flat one is
bent away evenly, with two further terms that close it:

    Σ turns + ∮ (a + b cos 2πs/L + c sin 2πs/L) ds/L = 2π,   Σ edges = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import MeshError
from ..gauss.dirichlet import Dirichlet
from ..gauss.frames import area_vectors
from ..gauss.harmonic import HarmonicSolver
from ..linalg import sum_rows

Array = NDArray[np.float64]

# Steps from the plan to the surface rolled out.
_WAY = 8
# Newton's steps to close an outline, and the part of its length by which it may stay open.
_STEPS = 30
_CLOSED = 1e-9


def under_lines(domain: Domain, f: Array) -> Domain | None:
    """The faces of a surface f (V, 3) over the lines, as seen from above; None where one is turned over."""
    return _flat(domain, f[:, :2])


def rolled_out(domain: Domain, positions: Array, f: Array) -> Domain | None:
    """The plan of one loop whose outline has the lengths and angles of that of the surface f (V, 3), or comes near.

    From the flat `positions` (V, 2) it goes there in steps, whose displacements are harmonic on the domain; it ends
    before the first at which a face would turn over. None where there is no such step.
    """
    if len(domain.boundary_loops) != 1:
        return None
    loop = domain.boundary_loops[0].astype(np.int64)
    first, last = _outline(domain, np.column_stack([positions, 0.0 * positions[:, 0]])), _outline(domain, f)
    if first is None or last is None:
        return None
    dirichlet = HarmonicSolver(domain).dirichlet(domain.boundary_vertices.astype(np.int64))
    reached, now = None, positions
    for t in np.arange(1, _WAY + 1) / _WAY:
        turns, lengths = ((1.0 - t) * a + t * b for a, b in zip(first, last, strict=True))
        outline = closed_outline(turns, lengths)
        if outline is None:
            break
        now = _moved(dirichlet, now, loop, _laid_over(outline, now[loop]))
        moved = _flat(domain, now)
        if moved is None:
            break
        reached = moved
    return reached


def _outline(domain: Domain, f: Array) -> tuple[Array, Array] | None:
    """Turns and edge lengths (n,) of the boundary of a surface f (V, 3), from the angles of its faces."""
    try:
        surface = Domain.from_positions(f, domain.faces)
    except MeshError:
        return None
    loop = domain.boundary_loops[0].astype(np.int64)
    angles = sum_rows(domain.faces.ravel(), surface.corner_angles.ravel(), domain.vertex_count)
    return np.pi - angles[loop], np.linalg.norm(np.roll(f[loop], -1, axis=0) - f[loop], axis=1)


def _laid_over(outline: Array, rim: Array) -> Array:
    """The outline (n, 2) turned and moved to where it is nearest to the rim (n, 2)."""
    z, w = (each @ [1.0, 1.0j] for each in (outline - outline.mean(axis=0), rim - rim.mean(axis=0)))
    turned = z * np.exp(1j * np.angle(np.vdot(z, w)))
    return np.column_stack([turned.real, turned.imag]) + rim.mean(axis=0)


def _moved(dirichlet: Dirichlet, positions: Array, loop: NDArray[np.integer], rim: Array) -> Array:
    """Positions (V, 2) with the loop at `rim` (n, 2), displaced harmonically."""
    off = np.zeros((len(loop), 2))
    off[np.searchsorted(dirichlet.fixed, loop)] = rim - positions[loop]
    return positions + dirichlet.extend(off)


def closed_outline(turns: Array, lengths: Array) -> Array | None:
    """Points (n, 2) of a closed outline with these edges (n,), and nearly these turns (n,) at their starts."""
    total = float(lengths.sum())
    s = (np.cumsum(lengths) - lengths) / total
    shares = 0.5 * (lengths + np.roll(lengths, 1)) / total
    waves = shares[:, None] * np.column_stack([np.ones_like(s), np.cos(2 * np.pi * s), np.sin(2 * np.pi * s)])
    sums = np.cumsum(waves, axis=0)  # of the direction of each edge
    bends = np.zeros(3)
    for _ in range(_STEPS):
        directions = np.cumsum(turns) + sums @ bends
        edges = lengths[:, None] * np.column_stack([np.cos(directions), np.sin(directions)])
        off = np.append(edges.sum(axis=0) / total, turns.sum() + sums[-1] @ bends - 2.0 * np.pi)
        if np.abs(off).max() < _CLOSED:
            return np.cumsum(edges, axis=0) - edges
        across = np.column_stack([-edges[:, 1], edges[:, 0]]) / total
        jacobian = np.vstack([across.T @ sums, sums[-1]])
        bends = bends - np.linalg.solve(jacobian, off)
    return None


def _flat(domain: Domain, positions: Array) -> Domain | None:
    """The domain with the lengths of positions (V, 2); None where a face is turned over."""
    points = np.column_stack([positions, np.zeros(len(positions))])
    if area_vectors(points, domain.faces)[:, 2].min() <= 0.0:
        return None
    i, j = domain.edges.T
    try:
        return domain.with_lengths(np.linalg.norm(positions[j] - positions[i], axis=1))
    except MeshError:
        return None
