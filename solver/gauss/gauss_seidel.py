"""Nonlinear Gauss-Seidel sweeps: each normal becomes the average of its neighbours (paper, Remark 8).

Sites of one colour have no link between them, so a sweep updates them all at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import LinkSubset, SiteGraph
from ..linalg import sum_rows
from .minimise import Minimum, Progress, Step, descend
from .problem import EnergyProblem, Point
from .sphere import dot

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# An average shorter than this part of its weights says nothing about a direction.
_SHORTEST = 1e-9


def gauss_seidel(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 20_000,
    progress: Progress | None = None,
) -> Minimum:
    """Sweeps of N_i ← n / |n|, n = Σ_j star_ij N_j, which need no linear algebra.

    Each is a descent where star is positive and does not fall with c (cotan on Delaunay edges, Möbius). Convergence
    is linear, and slower the finer the mesh.
    """
    palette = _palette(problem.graph, problem.dirichlet.unknown)

    def take_step(point: Point) -> Step | int:
        N = point.N.copy()
        for colour in palette:
            colour.average(problem, N)
        return Step(problem.at(N), 0, 1.0)

    return descend(problem, N, take_step, tolerance=tolerance, max_iterations=max_iterations, progress=progress)


@dataclass(frozen=True, eq=False)
class _Colour:
    """Sites (n,) of one colour and their links: the place (m,) of one end among them, the site (m,) at the other."""

    sites: Int
    places: Int
    neighbours: Int
    links: LinkSubset

    def average(self, problem: EnergyProblem, N: Array) -> None:
        """Update N (S, 3) at the sites of this colour."""
        others = N[self.neighbours]
        c = dot(N[self.sites[self.places]], others)[:, 0]
        star = problem.energy.star(c, self.links)
        star[~np.isfinite(star)] = 0.0  # a neighbour exactly opposite pulls nowhere
        mean = sum_rows(self.places, star[:, None] * others, len(self.sites))
        length = np.sqrt(dot(mean, mean))
        weight = sum_rows(self.places, np.abs(star), len(self.sites))[:, None]
        N[self.sites] = np.where(length > _SHORTEST * weight, mean / np.maximum(length, 1e-300), N[self.sites])


def _palette(graph: SiteGraph, unknown: Int) -> list[_Colour]:
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
            palette.append(_Colour(sites, place[ends[chosen]], neighbours[chosen], subset))
    return palette


def colouring(graph: SiteGraph) -> Int:
    """(S,) colours from 0, different along every link: rounds of independent sets (Jones and Plassmann).

    In each round every uncoloured site whose priority is above that of its uncoloured neighbours takes the smallest
    colour that none of its neighbours has.
    """
    i, j = (np.concatenate(pair) for pair in (graph.links.T, graph.links[:, ::-1].T))
    proper = i != j
    i, j = i[proper], j[proper]
    priority = np.random.default_rng(0).permutation(graph.count)
    colours = np.full(graph.count, -1)
    while (colours < 0).any():
        rival = np.full(graph.count, -1)
        waiting = (colours[i] < 0) & (colours[j] < 0)
        np.maximum.at(rival, i[waiting], priority[j[waiting]])
        chosen = np.flatnonzero((colours < 0) & (priority > rival))
        colours[chosen] = _smallest_free(graph.count, chosen, i, j, colours)
    return colours


def _smallest_free(count: int, chosen: Int, i: Int, j: Int, colours: Int) -> Int:
    is_chosen = np.zeros(count, dtype=bool)
    is_chosen[chosen] = True
    near = is_chosen[i] & (colours[j] >= 0)
    taken = np.zeros((count, int(colours.max(initial=0)) + 2), dtype=bool)
    taken[i[near], colours[j[near]]] = True
    return np.argmin(taken[chosen], axis=1)
