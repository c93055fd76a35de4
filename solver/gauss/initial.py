"""Where a minimiser starts.

The harmonic extension h of the boundary normals in R³, normalised, is the natural start, but it vanishes
somewhere more often than not. On every flat plan with outward conormals the data lie in one plane; Newton's
method would stay in it and find a critical map that is no minimiser. Where that happens h is lifted onto the
sphere: `h + s √(1 - |h|²) u` keeps the boundary normals (|h| = 1) and pushes the inside to the side s = ±1 of
u, the oriented normal of the domain.

A *wound* start covers the sphere a given number of times more than that: another homotopy class.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.topology import DualTree
from ..errors import ConditionError
from ..linalg import sum_rows
from .dirichlet import Dirichlet
from .sphere import degree as degree_of
from .sphere import dot, normalize

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Data count as coplanar when the smallest singular value of the boundary normals is below this part of the
# largest.
_COPLANAR = 1e-6
# An extension shorter than this somewhere is not normalised: its direction there would be an accident of the
# mesh.
_SHORTEST = 0.2
# Boundary normals that on average lean this much away from the side asked for want the way over the pole.
_LEANING = 0.05
# The part of the domain's conformal radius that a wound bubble takes.
_BUBBLE = 0.5


def harmonic_start(domain: Domain, dirichlet: Dirichlet, data: Array, up: Array, side: int) -> Array:
    """Unit normals (V, 3) from the fixed normals `data` (n, 3); `up` (3,) is the oriented normal of the
    domain, or zero.

    Candidates, the first that is nowhere short winning: the extension itself (unless the data are coplanar);
    lifted over the pole, where the data lean away from `side`; lifted along each principal axis of the data,
    the least one first.
    """
    extension = dirichlet.extend(data)
    axes = _axes(data, up if up.any() else _winding(domain, dirichlet.fixed, data))
    room = np.sqrt(np.maximum(0.0, 1.0 - dot(extension, extension)))
    candidates = [] if _is_coplanar(data) else [extension]
    if up.any() and side * float((data @ up).mean()) < -_LEANING * np.linalg.norm(up):
        depth = _depth(dirichlet, domain)[:, None]
        candidates.insert(0, extension + 2.0 * side * depth * up / np.linalg.norm(up))
    candidates += [extension + sign * side * room * axis for axis in axes for sign in (1, -1)]
    shortest = np.array([np.sqrt(dot(c, c).min()) for c in candidates])
    good = np.flatnonzero(shortest >= _SHORTEST)
    best = int(good[0]) if good.size else int(np.argmax(shortest))
    if shortest[best] < 1e-9:
        raise ConditionError("The boundary normals cancel inside and no start was found; give an initial map.")
    start = normalize(candidates[best])
    start[dirichlet.fixed] = data
    return start


def wound_start(domain: Domain, dirichlet: Dirichlet, start: Array, degree: float) -> Array:
    """A map with the boundary normals of `start` (V, 3) whose degree is the one nearest to `degree` in its
    class.

    On a domain with two boundary loops whose normals are a and -a it winds around the axis a. On a disc it
    grafts a bubble in the middle. Other domains raise `ConditionError`.
    """
    turns = round(degree - degree_of(start, domain.faces))
    if turns == 0:
        return start
    loops = domain.boundary_loops
    if len(loops) == 2 and domain.genus == 0 and _ends_are_antipodal(domain, start):
        wound = _winding_cylinder(domain, dirichlet, start, round(degree))
        other = _winding_cylinder(domain, dirichlet, start, -round(degree))
    elif len(loops) == 1 and domain.genus == 0:
        wound = _grafted(domain, dirichlet, start, turns)
        other = _grafted(domain, dirichlet, start, -turns)
    else:
        raise ConditionError(
            f"A start of degree {degree:g} is known for discs, and for cylinders whose two ends carry "
            "opposite constant normals; give an initial map instead."
        )
    miss, other_miss = (abs(degree_of(map_, domain.faces) - degree) for map_ in (wound, other))
    return wound if miss <= other_miss else other


def _is_coplanar(data: Array) -> bool:
    values = np.linalg.svd(data, compute_uv=False)
    return len(data) < 3 or bool(values[-1] <= _COPLANAR * values[0])


def _axes(data: Array, up: Array) -> list[Array]:
    """Directions to lift to: the data's least one first, turned towards `up`."""
    basis = np.linalg.svd(data.T @ data)[2][::-1]
    signs = np.where(basis @ up < 0.0, -1.0, 1.0)
    return list(signs[:, None] * basis)


def _winding(domain: Domain, fixed: Int, data: Array) -> Array:
    """The vector area Σ N_i × N_j of the normals along the longest boundary loop: positive around an outline."""
    loops = domain.boundary_loops
    if not loops:
        return np.zeros(3)
    lengths = [domain.edge_lengths[edges].sum() for edges in domain.boundary_loop_edges]
    normals = np.zeros((domain.vertex_count, 3))
    normals[fixed] = data
    around = normals[loops[int(np.argmax(lengths))]]
    return np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)


def _depth(dirichlet: Dirichlet, domain: Domain) -> Array:
    """(V,) in [0, 1]: the solution of Δu = -1 that vanishes at the fixed sites, scaled."""
    depth = dirichlet.solve(domain.vertex_areas[:, None], np.zeros((len(dirichlet.fixed), 1)))[:, 0]
    return depth / depth.max()


def _ends_are_antipodal(domain: Domain, start: Array) -> bool:
    first, second = (start[loop] for loop in domain.boundary_loops)
    a, b = first[0], second[0]
    return bool(np.allclose(first, a) and np.allclose(second, b) and np.allclose(a, -b, atol=1e-6))


def _winding_cylinder(domain: Domain, dirichlet: Dirichlet, start: Array, turns: int) -> Array:
    """cos(πu) a + sin(πu) (cos kv b + sin kv a × b): meridians from a to -a that turn with the conformal angle v."""
    first, second = domain.boundary_loops
    values = np.zeros((domain.vertex_count, 1))
    values[second] = 1.0
    u = dirichlet.extend(values[dirichlet.fixed])
    axis = start[first[0]]
    spin = _angle_around(domain, u[:, 0]) ** turns
    return _meridians(axis, np.pi * u, spin)


def _grafted(domain: Domain, dirichlet: Dirichlet, start: Array, turns: int) -> Array:
    """Replace the map around the deepest vertex p by one that leaves N(p) along all meridians and comes back
    to N.

    The polar coordinates around p are conformal: ρ = exp(-2πG) with Green's function G, and its conjugate
    angle.
    """
    source = np.zeros((domain.vertex_count, 1))
    centre = int(np.argmax(_depth(dirichlet, domain)))
    source[centre] = 1.0
    green = dirichlet.solve(source, np.zeros((len(dirichlet.fixed), 1)))
    radius = np.exp(-2.0 * np.pi * green)
    inside = radius[:, 0] < _BUBBLE
    pole = start[centre]
    bubble = _meridians(pole, np.pi * (1.0 - radius / _BUBBLE), _angle_around(domain, green[:, 0]) ** turns)
    grafted = start.copy()
    grafted[inside] = _carried(pole, start[inside], bubble[inside])
    return grafted


def _meridians(axis: Array, colatitude: Array, spin: NDArray[np.complex128]) -> Array:
    b = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    b /= np.linalg.norm(b)
    around = spin.real[:, None] * b + spin.imag[:, None] * np.cross(axis, b)
    return np.cos(colatitude) * axis + np.sin(colatitude) * around


def _carried(pole: Array, targets: Array, vectors: Array) -> Array:
    """Rotate each vector as the pole is rotated to its target along a great circle (not antipodal)."""
    axis = np.cross(pole, targets)
    cosine = (targets @ pole)[:, None]
    return cosine * vectors + np.cross(axis, vectors) + axis * dot(axis, vectors) / np.maximum(1.0 + cosine, 1e-12)


def _angle_around(domain: Domain, potential: Array) -> NDArray[np.complex128]:
    """exp(iv) (V,) with v the harmonic conjugate of a potential, scaled to turn once around its source or its hole."""
    i, j = domain.edges.T
    flux = domain.cotan_weights * (potential[j] - potential[i])
    total = abs(_outflow(domain, flux))
    v = DualTree.of(domain).integrate(domain, flux[:, None])[:, 0] * (2.0 * np.pi / total)
    spin: NDArray[np.complex128] = np.exp(1j * np.repeat(v, 3))
    corners = domain.faces.ravel()
    n = domain.vertex_count
    sums = sum_rows(corners, spin.real, n) + 1j * sum_rows(corners, spin.imag, n)
    return sums / np.maximum(np.abs(sums), 1e-12)


def _outflow(domain: Domain, flux: Array) -> float:
    """Flux of a potential through the first boundary loop."""
    on_loop = np.zeros(domain.vertex_count)
    on_loop[domain.boundary_loops[0]] = 1.0
    i, j = domain.edges.T
    return float(np.sum(flux * (on_loop[j] - on_loop[i])))
