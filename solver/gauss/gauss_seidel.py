"""Nonlinear Gauss-Seidel sweeps: each normal becomes the average of its neighbours (paper, Remark 8).

Sites of one colour have no link between them, so a sweep updates them all at once. Two faces on one circumcircle
(halves of a rectangle) are tied by an almost infinite weight and would hardly move one by one: after each sweep such
bodies turn as a whole, by the torque of the links that leave them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import LinkSubset, SiteGraph
from ..errors import Progress, Status
from ..linalg import sum_rows
from .newton import Minimum, Step, descend
from .problem import EnergyProblem, Point
from .sphere import dot, normalize

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# An average shorter than this part of its weights has no direction.
_SHORTEST = 1e-9
# Sweeps after which the pace is looked at, and the part of the energy that is rounding.
_LOOK, _ROUNDING = 100, 1e-12


def gauss_seidel(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 5_000,
    progress: Progress | None = None,
) -> Minimum:
    """Sweeps of N_i ← n / |n|, n = Σ_j star_ij N_j, within the plane of its mirror if it has one; no linear algebra.

    Each is a descent where star is positive and does not fall with c (cotan on Delaunay edges, Möbius). Convergence
    is linear, and the slower the finer the mesh: sweeps end early where their pace does not reach the tolerance within
    the limit, or where nothing falls any more.
    """
    graph, unknown = problem.graph, problem.dirichlet.unknown
    planes = problem.mirrors.planes(graph.count)
    palette = _palette(graph, unknown, planes) + _bodies(graph, unknown, planes)

    pace = _Pace(tolerance, max_iterations)

    def take_step(point: Point) -> Step | Status:
        if (ended := pace.ended(point)) is not None:
            return ended
        N = point.N.copy()
        for colour in palette:
            colour.update(problem, N)
        return Step(problem.at(N), 0, 1.0)

    return descend(problem, N, take_step, tolerance=tolerance, max_iterations=max_iterations, progress=progress)


class _Pace:
    """How fast the residual falls over the last sweeps, and whether that will do."""

    def __init__(self, tolerance: float, limit: int) -> None:
        self.tolerance, self.limit, self.sweep = tolerance, limit, 0
        self.looks: list[Point] = []

    def ended(self, point: Point) -> Status | None:
        """STALLED where the energy is level and the residual goes up and down, ITERATION_LIMIT at too slow a pace."""
        self.sweep += 1
        if self.sweep % _LOOK:
            return None
        self.looks = [*self.looks[-4:], point]
        if len(self.looks) < 3:
            return None
        residuals = np.array([look.residual for look in self.looks])
        is_level = np.ptp([look.energy for look in self.looks[-3:]]) <= _ROUNDING * abs(point.energy)
        if is_level and (np.diff(residuals) >= 0.0).sum() >= 2:
            return Status.STALLED
        fall = 0.5 * np.log(residuals[-3] / point.residual)
        left = _LOOK * np.log(point.residual / self.tolerance) / max(fall, 1e-300)
        return Status.ITERATION_LIMIT if fall > 0.0 and not is_level and self.sweep + left > self.limit else None


@dataclass(frozen=True, eq=False)
class _Colour:
    """Sites (n,) of one colour and their links: places (m,) of one end among them, sites (m,) at the other end.
    planes (n, 3): the normals of their mirrors, or zero."""

    sites: Int
    planes: Array
    places: Int
    neighbours: Int
    links: LinkSubset

    def update(self, problem: EnergyProblem, N: Array) -> None:
        """Average N (S, 3) at the sites of this colour."""
        others = N[self.neighbours]
        c = dot(N[self.sites[self.places]], others)[:, 0]
        star = problem.energy.star(c, self.links)
        star[~np.isfinite(star)] = 0.0  # a neighbour exactly opposite pulls nowhere
        mean = sum_rows(self.places, star[:, None] * others, len(self.sites))
        mean -= dot(mean, self.planes) * self.planes
        length = np.sqrt(dot(mean, mean))
        weight = sum_rows(self.places, np.abs(star), len(self.sites))[:, None]
        N[self.sites] = np.where(length > _SHORTEST * weight, mean / np.maximum(length, 1e-300), N[self.sites])


def _palette(graph: SiteGraph, unknown: Int, planes: Array) -> list[_Colour]:
    i, j = graph.links.T
    proper = np.flatnonzero(i != j)
    ends = np.concatenate([i[proper], j[proper]])
    neighbours = np.concatenate([j[proper], i[proper]])
    links = np.concatenate([proper, proper])
    colours = colouring(graph)
    is_unknown = np.zeros(graph.count, dtype=bool)
    is_unknown[unknown] = True
    palette = []
    for colour in range(colours.max() + 1):
        sites = np.flatnonzero((colours == colour) & is_unknown)
        place = np.full(graph.count, -1)
        place[sites] = np.arange(len(sites))
        chosen = np.flatnonzero(place[ends] >= 0)
        if len(sites):
            subset = graph.subset(links[chosen])
            palette.append(_Colour(sites, planes[sites], place[ends[chosen]], neighbours[chosen], subset))
    return palette


@dataclass(frozen=True, eq=False)
class _Bodies:
    """Bodies of one colour: their sites (n,) and the body (n,) of each; planes (k, 3): the normals of the bodies'
    mirrors, or zero; for each link (m,) that leaves a body the site inside, the site outside and the body."""

    sites: Int
    body: Int
    planes: Array
    inside: Int
    outside: Int
    owner: Int
    links: LinkSubset

    def update(self, problem: EnergyProblem, N: Array) -> None:
        """Turn each body by the angle that takes a single normal to its average.

        A body on a mirror turns about ν: only parts orthogonal to ν count.
        """
        count = int(self.body.max()) + 1
        a, b = N[self.inside], N[self.outside]
        star = problem.energy.star(dot(a, b)[:, 0], self.links)[:, None]
        star[~np.isfinite(star)] = 0.0
        plane = self.planes[self.owner]
        a, b = a - dot(a, plane) * plane, b - dot(b, plane) * plane
        torque = sum_rows(self.owner, star * np.cross(a, b), count)
        length = np.sqrt(dot(torque, torque))
        angle = np.arctan2(length, sum_rows(self.owner, star * dot(a, b), count))[self.body]
        axis = (torque / np.maximum(length, 1e-300))[self.body]
        v = N[self.sites]
        along = axis * dot(axis, v)
        N[self.sites] = normalize(along + np.cos(angle) * (v - along) + np.sin(angle) * np.cross(axis, v))


def _bodies(graph: SiteGraph, unknown: Int, planes: Array) -> list[_Bodies]:
    """Bodies of several sites, all unknown, colour by colour."""
    if graph.at_vertices:
        return []
    bodies, free = graph.bodies, np.bincount(graph.bodies[unknown], minlength=graph.count)
    size = np.bincount(bodies, minlength=graph.count)
    moves = (size > 1) & (free == size)
    plane_of = np.zeros((graph.count, 3))
    held = np.flatnonzero(planes.any(axis=1))
    plane_of[bodies[held]] = planes[held]
    i, j = graph.links.T
    leaving = np.flatnonzero(bodies[i] != bodies[j])
    inside, outside = np.concatenate([i[leaving], j[leaving]]), np.concatenate([j[leaving], i[leaving]])
    links = np.concatenate([leaving, leaving])
    colours = _coloured(bodies[i], bodies[j], graph.count)
    coloured = []
    for colour in range(colours[moves].max(initial=-1) + 1):
        chosen = moves & (colours == colour)
        number = np.cumsum(chosen) - 1
        sites, out = np.flatnonzero(chosen[bodies]), np.flatnonzero(chosen[bodies[inside]])
        if len(sites):
            owner = number[bodies[inside[out]]]
            subset = graph.subset(links[out])
            coloured.append(
                _Bodies(
                    sites,
                    number[bodies[sites]],
                    plane_of[np.flatnonzero(chosen)],
                    inside[out],
                    outside[out],
                    owner,
                    subset,
                )
            )
    return coloured


def colouring(graph: SiteGraph) -> Int:
    """(S,) colours from 0, different along every link."""
    i, j = graph.links.T
    return _coloured(i, j, graph.count)


def _coloured(first: Int, second: Int, count: int) -> Int:
    """(count,) colours from 0, different along every link: rounds of independent sets (Jones and Plassmann).

    In each round every uncoloured site whose priority is above that of its uncoloured neighbours takes the smallest
    colour that none of its neighbours has.
    """
    i, j = np.concatenate([first, second]), np.concatenate([second, first])
    proper = i != j
    i, j = i[proper], j[proper]
    priority = np.random.default_rng(0).permutation(count)
    colours = np.full(count, -1)
    while (colours < 0).any():
        rival = np.full(count, -1)
        waiting = (colours[i] < 0) & (colours[j] < 0)
        np.maximum.at(rival, i[waiting], priority[j[waiting]])
        chosen = np.flatnonzero((colours < 0) & (priority > rival))
        colours[chosen] = _smallest_free(count, chosen, i, j, colours)
    return colours


def _smallest_free(count: int, chosen: Int, i: Int, j: Int, colours: Int) -> Int:
    is_chosen = np.zeros(count, dtype=bool)
    is_chosen[chosen] = True
    near = is_chosen[i] & (colours[j] >= 0)
    taken = np.zeros((count, int(colours.max(initial=0)) + 2), dtype=bool)
    taken[i[near], colours[j[near]]] = True
    return np.argmin(taken[chosen], axis=1)
