"""Starts near the lowest of several minimisers, found on a coarse mesh.

Boundary normals within a closed hemisphere have one minimiser, which lies in it (Jäger and Kaul), up to the choice of
the hemisphere. Others may have several, and saddles at which a start with their symmetry ends. On the coarse mesh each
start descends to a minimiser, saddles are left along a direction that leads down, and the solve starts from the lowest.
Where energies differ by less than the coarse mesh resolves, `side` decides, so that refinement does not change the
answer.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal
from scipy.optimize import linprog

from ..domain.coarsen import Coarse, coarsened
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import Status
from ..linalg import sum_rows
from .boundary_data import Conditions
from .initial_map import every_start
from .newton import Minimum, longest, newton
from .problem import EnergyProblem, Point
from .sphere import dot, exp, inner, normalize

Array = NDArray[np.float64]

# Vertices of the coarse mesh; with fewer of its own a domain is its own coarse mesh.
_COUNT = 1000
_TOLERANCE = 1e-3
# Relative difference of energies that the coarse mesh does not decide. The two lowest of the twisted disc with m = 4
# differ by 4 %, the lowest minimiser and the saddle with m = 2 by 0.3 %; saddles are left before energies are compared.
_ALIKE = 0.01
# Eigenvalue in the H¹ product below which a direction leads down.
_UNSTABLE = -5e-3
_ESCAPES = 4
_LEAP = 0.5
# Steps of Lanczos' method, checked every few; the lowest value has converged when it changes by less than this.
_LOOKS, _EVERY, _SETTLED = 40, 4, 2e-3
_TINY = 1e-14


def lowest_start(
    graph: SiteGraph, conditions: Conditions, side: int, problem_on: Callable[[Domain, Conditions], EnergyProblem]
) -> Array | None:
    """A map (S, 3) near the lowest minimiser with these boundary normals; None where they have only one, or the coarse
    mesh has no answer.

    problem_on: the energy at the vertices of a domain under conditions.
    """
    if conditions.mirrors.size or conditions.faces.size or not len(graph.domain.boundary_edges):
        return None
    fixed, data = conditions.resolve()
    if fits_in_hemisphere(data):
        return None
    domain = graph.domain
    coarse = coarsened(domain, _COUNT) if domain.vertex_count > 2 * _COUNT else _itself(domain)
    if coarse is None:
        return None
    is_kept = np.isin(coarse.vertices, fixed)
    normals = data[np.searchsorted(fixed, coarse.vertices[is_kept])]
    held = Conditions(np.flatnonzero(is_kept), normals, up=conditions.up)
    problem = problem_on(coarse.domain, held)
    lowest = _lowest(problem, normals, conditions.up, side)
    return None if lowest is None else _smoothed(graph, lowest[coarse.region], fixed, data)


def fits_in_hemisphere(data: Array) -> bool:
    """Whether unit vectors (n, 3) lie in a closed hemisphere: a · N >= 0 for some a that is not zero."""
    if len(data) < 3 or np.linalg.svd(data, compute_uv=False)[-1] < 1e-6 * np.sqrt(len(data)):
        return True
    best = linprog(-data.sum(axis=0), A_ub=-data, b_ub=np.zeros(len(data)), bounds=(-1.0, 1.0))
    return bool(best.status == 0 and -best.fun > 1e-9 * len(data))


def escaped(problem: EnergyProblem, minimum: Minimum, up: Array, side: int, **limits: object) -> Minimum:
    """A minimiser below a critical map that turns out to be a saddle; the map itself where no direction leads down.

    The status is SADDLE where it is still one after a few attempts.
    """
    history = list(minimum.history)
    for _ in range(_ESCAPES):
        way = falling_direction(problem, problem.at(minimum.N))
        if way is None:
            return Minimum(minimum.N, minimum.residual, minimum.status, history)
        step = _LEAP * way / longest(way)
        facing = inner(problem.graph.areas[:, None] * step, np.broadcast_to(up, step.shape))
        start = exp(minimum.N, step if side * facing >= 0.0 else -step)
        minimum = newton(problem, start, **limits)  # pyright: ignore[reportArgumentType]
        history += minimum.history
        if minimum.status is Status.CANCELLED:
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
    random = np.random.default_rng(0).standard_normal(N.shape)
    rest = problem.project(N, problem.graph.areas[:, None] * random)
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
    values, vectors = eigh_tridiagonal(diagonal, beside[1:], select="i", select_range=(0, 0))
    if values[0] >= _UNSTABLE:
        return None
    return np.einsum("k,kij->ij", vectors[:, 0], np.stack(fields))


def _itself(domain: Domain) -> Coarse:
    every = np.arange(domain.vertex_count)
    return Coarse(domain, every, every)


def _lowest(problem: EnergyProblem, data: Array, up: Array, side: int) -> Array | None:
    """The lowest minimiser (n, 3) below the starts; of those with nearly equal energies the one facing `side`."""
    ends: list[tuple[float, float, Array]] = []
    for start in every_start(problem.dirichlet, data, up, side):
        minimum = _descended(problem, newton(problem, start, tolerance=_TOLERANCE))
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
        if minimum.status not in (Status.CONVERGED, Status.STALLED):
            return None
        way = falling_direction(problem, problem.at(minimum.N))
        if way is None:
            return minimum
        minimum = newton(problem, exp(minimum.N, _LEAP * way / longest(way)), tolerance=_TOLERANCE)
    return None


def _smoothed(graph: SiteGraph, rough: Array, fixed: NDArray[np.integer], data: Array) -> Array | None:
    """A map (S, 3) at the sites from one at the vertices (V, 3) that is constant on regions: a few sweeps of means over
    neighbours, enough times to remove the steps between regions. None where normals cancel at a site."""
    domain = graph.domain
    i, j = domain.edges.T
    ends, others = np.concatenate([i, j]), np.concatenate([j, i])
    across = np.sqrt(domain.vertex_count / max(1, len(np.unique(rough, axis=0))))
    N = rough
    for _ in range(int(np.ceil(across**2))):
        N = N + sum_rows(ends, N[others], domain.vertex_count)
        N[fixed] = data
        N = normalize(N)
    means = graph.means(N)
    return normalize(means) if dot(means, means).min() > _TINY else None
