"""Starts near the lowest of several minimisers, found on a coarse mesh.

Boundary normals within a closed hemisphere have one minimiser, which lies in it (Jäger and Kaul), up to the choice of
the hemisphere. Others may have several, and saddles at which a start with their symmetry ends. On the coarse mesh each
start descends to a minimiser, saddles are left along a direction that leads down, and the solve starts from the lowest.
Where energies differ by less than the coarse mesh resolves, `side` decides, so that refinement does not change the
answer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal

from ..domain.coarsen import Coarse, coarsened
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import Status
from .boundary_data import Conditions
from .initial_map import every_start
from .newton import Minimum, longest, newton
from .problem import EnergyProblem, Point
from .sphere import dot, exp, inner, normalize

Array = NDArray[np.float64]

# Vertices of the coarse mesh; with fewer of its own a domain is its own coarse mesh.
_COUNT = 1000
_TOLERANCE = 1e-3
# Of its vertices at most this part is held: otherwise it is too coarse for a thin strip, and says nothing about it.
_MOST_HELD = 0.5
# It decides alone where at most this part is held and each boundary loop keeps at least this number of vertices.
_FEW_HELD, _FINE_LOOP = 0.25, 16
# Steps from one start on it.
_STEPS = 50
# Relative difference of energies that the coarse mesh does not decide. The two lowest of the twisted disc with m = 4
# differ by 4 %, the lowest minimiser and the saddle with m = 2 by 0.3 %; saddles are left before energies are compared.
_ALIKE = 0.01
# Eigenvalue in the H¹ product below which a direction leads down.
_UNSTABLE = -5e-3
_ESCAPES = 4
# Ends of a descent at which the map is critical, as far as its mesh tells.
_CRITICAL = (Status.CONVERGED, Status.STALLED)
_LEAP = 0.5
# Steps of Lanczos' method, checked every few; the lowest value has converged when it changes by less than this.
_LOOKS, _EVERY, _SETTLED = 40, 4, 2e-3
_TINY = 1e-14
# Sweeps that smooth a start: as many as fine vertices to a coarse one, which takes too long on a very large mesh.
_SWEEPS = 200


class Lowest(NamedTuple):
    """A map (S, 3) near the lowest minimiser, and whether the coarse mesh is fine enough to be sure of that."""

    start: Array
    is_sure: bool


def lowest_start(
    graph: SiteGraph, conditions: Conditions, side: int, problem_on: Callable[[Domain, Conditions], EnergyProblem]
) -> Lowest | None:
    """A map (S, 3) near the lowest minimiser with these boundary normals; None where the coarse mesh has no answer.

    problem_on: the energy at the vertices of a domain under conditions.
    """
    fixed, data = conditions.resolve()
    domain = graph.domain
    coarse = coarsened(domain, _COUNT) if domain.vertex_count > 2 * _COUNT else _itself(domain)
    if coarse is None:
        return None
    is_kept = np.isin(coarse.vertices, fixed)
    is_too_thin = coarse.domain is not domain and is_kept.mean() > _MOST_HELD
    if is_kept.all() or is_too_thin or not is_kept.any():
        return None
    normals = data[np.searchsorted(fixed, coarse.vertices[is_kept])]
    held = Conditions(np.flatnonzero(is_kept), normals, up=conditions.up)
    problem = problem_on(coarse.domain, held)
    lowest = _lowest(problem, normals, conditions.up, side)
    start = None if lowest is None else _smoothed(graph, lowest, coarse, fixed, data)
    shortest = min((len(loop) for loop in coarse.domain.boundary_loops), default=_FINE_LOOP)
    is_sure = bool(is_kept.mean() <= _FEW_HELD and shortest >= _FINE_LOOP)
    return None if start is None else Lowest(start, is_sure)


def lower(minimum: Minimum, usual: Minimum) -> Minimum:
    """The minimum from the coarse mesh, unless the usual start leads to an energy that is clearly lower, or converges
    where the other does not."""
    if usual.status is not Status.CONVERGED:
        return minimum
    is_lower = usual.history[-1].energy < (1.0 - _ALIKE) * minimum.history[-1].energy
    return usual if is_lower or minimum.status not in (Status.CONVERGED, Status.CANCELLED) else minimum


def escaped(problem: EnergyProblem, minimum: Minimum, up: Array, side: int, **limits: object) -> Minimum:
    """A minimiser below a critical map that turns out to be a saddle; the map itself where no direction leads down.

    The status is SADDLE where it is still one after a few attempts.
    """
    history = list(minimum.history)
    for _ in range(_ESCAPES):
        way = falling_direction(problem, problem.at(minimum.N))
        if way is None:
            return Minimum(minimum.N, minimum.residual, minimum.status, history)
        facing = inner(problem.graph.areas[:, None] * way, np.broadcast_to(up, way.shape))
        start = _away(problem, minimum.N, way if side * facing >= 0.0 else -way)
        minimum = newton(problem, start, **limits)  # pyright: ignore[reportArgumentType]
        history += minimum.history
        if minimum.status not in _CRITICAL:  # cancelled, say, or normals of neighbours have become opposite
            break
    else:
        if falling_direction(problem, problem.at(minimum.N)) is not None:
            return Minimum(minimum.N, minimum.residual, Status.SADDLE, history)
    return Minimum(minimum.N, minimum.residual, minimum.status, history)


def falling_direction(problem: EnergyProblem, point: Point) -> Array | None:
    """An admissible field (S, 3) along which the energy curves downwards; None where there seems to be none.

    Lanczos' method for H v = λ K v with the H¹ product K, from a random field. All but a few λ are close to one,
    so that a few steps find the lowest.
    """
    N, operator = point.N, problem.hessian(point)
    areas = problem.graph.areas
    rest = problem.project(N, (areas / areas.mean())[:, None] * np.random.default_rng(0).standard_normal(N.shape))
    fields, duals, diagonal, beside = [], [], [], []
    lowest = np.inf
    for step in range(1, _LOOKS + 1):
        z = problem.project(N, problem.dirichlet.precondition(rest))
        length = float(np.sqrt(max(0.0, inner(rest, z))))
        if length < _TINY:
            break
        fields.append(z / length)
        duals.append(rest / length)
        beside.append(length)
        curved = operator(fields[-1])
        diagonal.append(inner(fields[-1], curved))
        rest = curved
        for field, dual in zip(fields, duals, strict=True):
            rest = rest - inner(field, rest) * dual
        if step % _EVERY == 0:
            values, vectors = eigh_tridiagonal(diagonal, beside[1:], select="i", select_range=(0, 0))
            if abs(values[0] - lowest) < _SETTLED:
                break
            lowest = float(values[0])
    if not fields:  # all normals are held
        return None
    values, vectors = eigh_tridiagonal(diagonal, beside[1:], select="i", select_range=(0, 0))
    if values[0] >= _UNSTABLE:
        return None
    way = np.zeros_like(N)
    for part, field in zip(vectors[:, 0], fields, strict=True):
        way += part * field
    return way


def _itself(domain: Domain) -> Coarse:
    every = np.arange(domain.vertex_count)
    return Coarse(domain, every, every)


def _lowest(problem: EnergyProblem, data: Array, up: Array, side: int) -> Array | None:
    """The lowest minimiser (n, 3) below the starts; of those with nearly equal energies the one facing `side`."""
    ends: list[tuple[float, float, Array]] = []
    for start in every_start(problem.dirichlet, data, up, side):
        minimum = _descended(problem, newton(problem, start, tolerance=_TOLERANCE, max_iterations=_STEPS))
        if minimum is not None:
            mean = (problem.graph.areas[:, None] * minimum.N).sum(axis=0)
            ends.append((minimum.history[-1].energy, side * float(mean @ up), minimum.N))
    if not ends:
        return None
    least = min(energy for energy, _, _ in ends)
    alike = [end for end in ends if end[0] <= (1.0 + _ALIKE) * least]
    return max(alike, key=lambda end: end[1])[2]


def _descended(problem: EnergyProblem, minimum: Minimum) -> Minimum | None:
    """The same, or a lower one where it is a saddle; None where it has not converged."""
    for _ in range(_ESCAPES):
        if minimum.status not in _CRITICAL:
            return None
        way = falling_direction(problem, problem.at(minimum.N))
        if way is None:
            return minimum
        minimum = newton(problem, _away(problem, minimum.N, way), tolerance=_TOLERANCE, max_iterations=_STEPS)
    return None


def _away(problem: EnergyProblem, N: Array, way: Array) -> Array:
    """The map a leap from N along `way`, shorter where neighbours would become opposite: energies may be infinite."""
    leap = _LEAP * way / longest(way)
    while not np.isfinite(problem.at(exp(N, leap)).energy):
        leap = 0.5 * leap
    return exp(N, leap)


def _smoothed(
    graph: SiteGraph, lowest: Array, coarse: Coarse, fixed: NDArray[np.integer], data: Array
) -> Array | None:
    """A map (S, 3) at the sites from one at the vertices (n, 3) of the coarse mesh, constant on regions at first: a few
    sweeps of means over neighbours, until steps between regions are gone. None where normals cancel at a site."""
    domain = graph.domain
    count, N = domain.vertex_count, lowest[coarse.region]
    N[fixed] = data
    if len(lowest) < count:
        i, j = domain.edges.T
        ones = np.ones(2 * len(i))
        around = sp.csr_array((ones, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(count, count))
        for _ in range(min(_SWEEPS, int(np.ceil(count / len(lowest))))):
            sums = N + around @ N
            length = np.linalg.norm(sums, axis=1, keepdims=True)
            N = np.where(length > _TINY, sums / np.maximum(length, _TINY), N)
            N[fixed] = data
    means = graph.means(N)
    return normalize(means) if dot(means, means).min() > _TINY else None
