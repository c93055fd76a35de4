"""Initial maps: where a minimiser starts.

The harmonic extension h of the boundary normals in R³, normalised, is the natural start, but it often vanishes
somewhere. On every flat plan with outward conormals the data lie in one plane; Newton's method would stay in it and
find a critical map that is no minimiser. There h is lifted onto the sphere: `h + s √(1 - |h|²) u` keeps the boundary
normals (|h| = 1) and pushes the inside to the side s = ±1 of u, the oriented normal of the domain.

A *wound* start covers the sphere a given number of times more: another homotopy class.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from ..domain.trees import Tree
from ..errors import ConditionError
from ..linalg import sum_rows
from .dirichlet import Dirichlet
from .sphere import degree as degree_of
from .sphere import dot, normalize, tangent_axes

Array = NDArray[np.float64]

# Data are coplanar when the smallest singular value of the boundary normals is below this part of the largest.
_COPLANAR = 1e-6
# An extension shorter than this somewhere is not normalised: its direction there would be an accident of the mesh.
_SHORTEST = 0.2
_VANISHING = 1e-9
# Principal axes count as equal above this ratio.
_EQUAL = 0.9
# Boundary normals that lean away from the wanted side by this much on average need the way over the pole.
_LEANING = 0.05
# A mean of unit normals shorter than this has no direction.
_BALANCED = 1e-9
# The part of the domain's conformal radius that a wound bubble takes.
_BUBBLE = 0.5


def harmonic_start(dirichlet: Dirichlet, data: Array, up: Array, side: int) -> Array:
    """Unit normals (S, 3) from the fixed normals `data` (n, 3); `up` (3,): the oriented normal of the domain, or zero.

    The first candidate that is nowhere short wins: lifted over the pole, where the data lean away from `side`; the
    extension itself, unless the data are coplanar; lifted along each principal axis of the data, the least one first.
    Raises `ConditionError` where all vanish somewhere.
    """
    candidates = _candidates(dirichlet, data, up, side)
    shortest = np.array([np.sqrt(dot(c, c).min()) for c in candidates])
    good = np.flatnonzero(shortest >= _SHORTEST)
    best = int(good[0]) if good.size else int(np.argmax(shortest))
    if shortest[best] < _VANISHING:
        raise ConditionError("The boundary normals cancel inside, so no start exists; give an initial map.")
    start = normalize(candidates[best])
    start[dirichlet.fixed] = data
    return start


def every_start(dirichlet: Dirichlet, data: Array, up: Array, side: int) -> list[Array]:
    """The candidates of `harmonic_start` and some more, each (S, 3), but for those that vanish somewhere."""
    candidates = _candidates(dirichlet, data, up, side)
    extension = dirichlet.extend(data)
    room = np.sqrt(np.maximum(0.0, 1.0 - dot(extension, extension)))
    candidates += [extension + sign * room * axis for axis in _between_axes(data) for sign in (1, -1)]
    starts = [normalize(c) for c in candidates if np.sqrt(dot(c, c).min()) > _VANISHING]
    for start in starts:
        start[dirichlet.fixed] = data
    return starts


def _candidates(dirichlet: Dirichlet, data: Array, up: Array, side: int) -> list[Array]:
    extension = dirichlet.extend(data)
    axes = _axes(data, up if up.any() else _winding(dirichlet, data))
    room = np.sqrt(np.maximum(0.0, 1.0 - dot(extension, extension)))
    candidates = [] if _is_coplanar(data) else [extension]
    over = leaning(data, up, side)
    if over is not None:
        candidates.insert(0, extension + 2.0 * _depth(dirichlet)[:, None] * over)
    return candidates + [extension + sign * side * room * axis for axis in axes for sign in (1, -1)]


def _between_axes(data: Array) -> list[Array]:
    """The diagonals between principal axes (3,) along which the data spread equally, where symmetry hides a choice."""
    _, spread, basis = np.linalg.svd(data, full_matrices=False)
    return [
        (basis[k] + sign * basis[k + 1]) / np.sqrt(2.0)
        for k in range(len(spread) - 1)
        if spread[k + 1] > _EQUAL * spread[k]
        for sign in (1, -1)
    ]


def over_the_other_pole(dirichlet: Dirichlet, N: Array) -> Array:
    """The map N (S, 3) lifted over the pole opposite to its mean, at free sites: a start for the second solution with
    the same boundary (paper, Theorem D.1), one degree lower where N faces the front.

    Raises `ConditionError` where the mean of N vanishes.
    """
    pole = _mean_direction(dirichlet, N)
    if pole is None:
        raise ConditionError("The normals point to all sides equally, so they have no other pole to be lifted over.")
    return _lifted(dirichlet, N, pole)


def _mean_direction(dirichlet: Dirichlet, N: Array) -> Array | None:
    """The unit vector (3,) along the mean of N (S, 3); None where N points to all sides equally."""
    areas = dirichlet.graph.areas
    mean = (areas[:, None] * N).sum(axis=0)
    length = float(np.linalg.norm(mean))
    return None if length < _BALANCED * float(areas.sum()) else mean / length


def _lifted(dirichlet: Dirichlet, N: Array, pole: Array) -> Array:
    """N lifted over the pole opposite to `pole` (3,), at free sites."""
    lifted = N - 2.0 * _depth(dirichlet)[:, None] * pole
    lifted[dot(lifted, lifted)[:, 0] < 1e-9] = -pole
    start = normalize(lifted)
    start[dirichlet.fixed] = N[dirichlet.fixed]
    return start


def leaning(data: Array, up: Array, side: int) -> Array | None:
    """The pole (3,) of that side, if the data (n, 3) lean away from it on average; else None."""
    length = float(np.linalg.norm(up))
    if not (length and len(data)) or side * float((data @ up).mean()) >= -_LEANING * length:
        return None
    return side * up / length


def wound_start(dirichlet: Dirichlet, start: Array, degree: float) -> Array:
    """A map with the boundary normals of `start` (S, 3) and the degree nearest to `degree` in its class.

    On a domain with two boundary loops whose normals are a and -a it winds around the axis a. On a disc it goes over
    the other pole if that has the wanted degree; else a bubble is grafted in the middle. Other domains raise
    `ConditionError`.
    """
    graph = dirichlet.graph
    most = len(graph.triangles) / 2
    if not abs(degree) < most:
        raise ConditionError(
            f"No map of this mesh has degree {degree:g}: a triangle covers less than half of the sphere, so that the "
            f"degree is below {most:g} here."
        )
    turns = round(degree - degree_of(start, graph.triangles))
    if turns == 0:
        return start
    rings, genus = graph.rings, graph.domain.genus
    if len(rings) == 2 and genus == 0 and _ends_are_antipodal(graph, start):
        wound = _winding_cylinder(dirichlet, start, round(degree))
        other = _winding_cylinder(dirichlet, start, -round(degree))
    elif len(rings) == 1 and genus == 0:
        pole = _mean_direction(dirichlet, start)
        if pole is not None:  # over it a map shrinks less easily than a bubble does
            lifted = _lifted(dirichlet, start, pole)
            if abs(degree_of(lifted, graph.triangles) - degree) < 0.5:
                return lifted
        wound = _grafted(dirichlet, start, turns)
        other = _grafted(dirichlet, start, -turns)
    else:
        raise ConditionError(
            f"A start of degree {degree:g} can be made on discs, and on cylinders whose two ends carry "
            "opposite constant normals; give an initial map instead."
        )
    miss, other_miss = (abs(degree_of(map_, graph.triangles) - degree) for map_ in (wound, other))
    return wound if miss <= other_miss else other


def _is_coplanar(data: Array) -> bool:
    values = np.linalg.svd(data, compute_uv=False)
    return len(data) < 3 or bool(values[-1] <= _COPLANAR * values[0])


def _axes(data: Array, up: Array) -> list[Array]:
    """Directions to lift to: the principal axes of the data, the least one first, turned towards `up`."""
    basis = np.linalg.svd(data.T @ data)[2][::-1]
    signs = np.where(basis @ up < 0.0, -1.0, 1.0)
    return list(signs[:, None] * basis)


def _winding(dirichlet: Dirichlet, data: Array) -> Array:
    """The vector area Σ N_i × N_j of the normals along the longest boundary loop: positive around an outline."""
    graph = dirichlet.graph
    if not graph.rings:
        return np.zeros(3)
    lengths = [graph.domain.edge_lengths[edges].sum() for edges in graph.domain.boundary_loop_edges]
    normals = np.zeros((graph.count, 3))
    normals[dirichlet.fixed] = data
    around = normals[graph.rings[int(np.argmax(lengths))]]
    return np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)


def _depth(dirichlet: Dirichlet) -> Array:
    """(S,) in [0, 1]: the solution of Δu = -1 that vanishes at the fixed sites, scaled."""
    depth = dirichlet.solve(dirichlet.graph.areas[:, None], np.zeros((len(dirichlet.fixed), 1)))[:, 0]
    return depth / depth.max()


def _ends_are_antipodal(graph: SiteGraph, start: Array) -> bool:
    first, second = (start[ring] for ring in graph.rings)
    a, b = first[0], second[0]
    return bool(np.allclose(first, a) and np.allclose(second, b) and np.allclose(a, -b, atol=1e-6))


def _winding_cylinder(dirichlet: Dirichlet, start: Array, turns: int) -> Array:
    """cos(πu) a + sin(πu) (cos kv b + sin kv a × b): meridians from a to -a that turn with the conformal angle v."""
    first, second = dirichlet.graph.rings
    values = np.zeros((len(start), 1))
    values[second] = 1.0
    u = dirichlet.extend(values[dirichlet.fixed])
    axis = start[first[0]]
    spin = _angle_around(dirichlet, u[:, 0]) ** turns
    return _meridians(axis, np.pi * u, spin)


def _grafted(dirichlet: Dirichlet, start: Array, turns: int) -> Array:
    """Replace the map around the deepest site p by one that leaves N(p) along all meridians and returns to N.

    The polar coordinates around p are conformal: ρ = exp(-2πG) with Green's function G, and its conjugate angle.
    """
    source = np.zeros((len(start), 1))
    depth = _depth(dirichlet)
    depth[dirichlet.graph.rings[0]] = 0.0  # the deepest site of a free side has only half a neighbourhood
    centre = int(np.argmax(depth))
    if not depth[centre] > 0.0:
        raise ConditionError("A map of another degree starts from a site inside, and there is none; refine the mesh.")
    source[centre] = 1.0
    green = dirichlet.solve(source, np.zeros((len(dirichlet.fixed), 1)))
    radius = np.exp(-2.0 * np.pi * green)
    inside = radius[:, 0] < _BUBBLE
    pole = start[centre]
    bubble = _meridians(pole, np.pi * (1.0 - radius / _BUBBLE), _angle_around(dirichlet, green[:, 0]) ** turns)
    grafted = start.copy()
    grafted[inside] = _carried(pole, start[inside], bubble[inside])
    return grafted


def _meridians(axis: Array, colatitude: Array, spin: NDArray[np.complex128]) -> Array:
    b, c = tangent_axes(axis[None])[0]
    around = spin.real[:, None] * b + spin.imag[:, None] * c
    return np.cos(colatitude) * axis + np.sin(colatitude) * around


def _carried(pole: Array, targets: Array, vectors: Array) -> Array:
    """Rotate each vector as the pole is rotated to its target along a great circle (not antipodal)."""
    axis = np.cross(pole, targets)
    cosine = (targets @ pole)[:, None]
    return cosine * vectors + np.cross(axis, vectors) + axis * dot(axis, vectors) / np.maximum(1.0 + cosine, 1e-12)


def _angle_around(dirichlet: Dirichlet, potential: Array) -> NDArray[np.complex128]:
    """exp(iv) (S,) with v the harmonic conjugate of a potential, scaled to turn once around its source or its hole.

    v lives on the cells; a site gets the mean over its cells.
    """
    graph = dirichlet.graph
    i, j = graph.links.T
    flux = dirichlet.weights * (potential[j] - potential[i])
    on_ring = np.zeros(graph.count)
    on_ring[graph.rings[0]] = 1.0
    total = abs(float(np.sum(flux * (on_ring[j] - on_ring[i]))))
    inside = (graph.cells >= 0).all(axis=1)
    tree = Tree.of(graph.cells[inside], graph.cell_count)
    v = tree.integrate(flux[inside, None])[:, 0] * (2.0 * np.pi / total)
    sites, cells = graph.incidence
    spin: NDArray[np.complex128] = np.exp(1j * v)[cells]
    sums = sum_rows(sites, spin.real, graph.count) + 1j * sum_rows(sites, spin.imag, graph.count)
    length = np.abs(sums)
    # any direction where cells cancel or are missing: at the source and on the rim, where nothing turns
    return np.where(length > 1e-9, sums / np.maximum(length, 1e-9), 1.0)
