"""Unit normals of a spanning surface: along its lines from the flux, inside the paper's harmonic map.

The force of the rim, F = (L f - 2H · ⅓ Σ area vectors) at a rim vertex, points along the outward conormal, so
N = F × γ' / |F × γ'|; one pass ¼ ½ ¼ along the rim takes out the alternating part of its error. At a corner N is normal
to both sides; at a re-entrant one, where the surface is as steep as r^(2/3) and has no normal, it is the mean of those
beside it (H measured around holes with sharp corners is then off half as much). Means of face normals would be of no
use: H measured with them does not converge on irregular meshes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.frames import area_vectors
from ..linalg import sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Two sides whose directions enclose a smaller sine at a corner do not give a normal there.
_CORNER_SINE = 0.1
# A corner whose angle is larger is re-entrant, radians.
_RE_ENTRANT = np.radians(200.0)
# Cosine of the angle up to which the normals of an earlier surface are a start.
_NEAR = 0.5


def rim_normals(
    domain: Domain, f: Array, H: float, loop: Int, tangents: Array, marks: Int, on_line: NDArray[np.bool_]
) -> Array:
    """N (n, 3) along a loop of vertices (n,); rows that are not `on_line` (n,) mean nothing.

    tangents (n, 3): γ' where a vertex slides along a curve, zero where it is that of the rim itself.
    """
    areas = sum_rows(domain.faces.ravel(), np.repeat(area_vectors(f, domain.faces) / 3.0, 3, axis=0), len(f))
    force = (domain.laplacian @ f - 2.0 * H * areas)[loop]
    behind, ahead = _side_tangents(f[loop])
    along = tangents.copy()
    along[marks] = 0.0
    unknown = ~along.any(axis=1)
    along[unknown] = (behind + ahead)[unknown]
    N = _unit(np.cross(force, along))
    N = _smoothed(N, along, marks, on_line)
    return _at_corners(N, behind, ahead, marks, _angles(domain, loop[marks]))


def _side_tangents(p: Array) -> tuple[Array, Array]:
    """Unit directions in which a closed polyline arrives at and leaves each point, to second order on smooth sides."""
    ahead = _one_sided(p, 1)
    return -_one_sided(p, -1), ahead


def _one_sided(p: Array, way: int) -> Array:
    """Derivative at each point of the parabola through it and the next two, by the length."""
    first = np.roll(p, -way, axis=0) - p
    second = np.roll(p, -2 * way, axis=0) - p
    a = np.linalg.norm(first, axis=1, keepdims=True)
    b = a + np.linalg.norm(second - first, axis=1, keepdims=True)
    return _unit(first * b / a - second * a / b)


def _smoothed(N: Array, tangents: Array, marks: Int, on_line: NDArray[np.bool_]) -> Array:
    """One pass ¼ ½ ¼, not across marked points; normal to the curve again."""
    kept = on_line.copy()
    kept[marks] = False
    before, after = np.roll(kept, 1), np.roll(kept, -1)
    weights = np.stack([0.25 * before, 0.25 * after])
    mean = weights[0][:, None] * np.roll(N, 1, axis=0) + weights[1][:, None] * np.roll(N, -1, axis=0)
    mean += (1.0 - weights.sum(axis=0))[:, None] * N
    t = _unit(tangents)
    mean -= np.einsum("ij,ij->i", mean, t)[:, None] * t
    both = kept & before & after
    return np.where(both[:, None], _unit(mean), N)


def _angles(domain: Domain, vertices: Int) -> Array:
    """(k,) the plan's angles at vertices (k,): those of the surface, where the plan has its corners."""
    return sum_rows(domain.faces.ravel(), domain.corner_angles.ravel(), domain.vertex_count)[vertices]


def _at_corners(N: Array, behind: Array, ahead: Array, marks: Int, angles: Array) -> Array:
    """N with that of both sides at the marked points, on the side of their neighbours; angles (k,): the plan's there."""
    N = N.copy()
    across = np.cross(behind, ahead)[marks]
    sine = np.linalg.norm(across, axis=1)
    near = N[(marks - 1) % len(N)] + N[(marks + 1) % len(N)]
    sign = np.where(np.einsum("ij,ij->i", across, near) < 0.0, -1.0, 1.0)
    clear = (sine > _CORNER_SINE) & (angles < _RE_ENTRANT)
    N[marks[clear]] = (sign * 1.0)[clear, None] * _unit(across[clear])
    N[marks[~clear]] = _unit(near[~clear])
    return N


def start_normals(domain: Domain, f: Array, rim: Int, at_rim: Array) -> Array:
    """A start (V, 3) for the harmonic map: normals of the faces, and those known at the vertices `rim`."""
    N = _face_normals(domain, f)
    N[rim] = at_rim
    return N


def changed_normals(start: Array, domain: Domain, f: Array, N: Array) -> Array:
    """The harmonic normals N (V, 3) of an earlier surface f, changed as normals of the faces have changed since.

    start (V, 3): for the harmonic map, as it is where normals have changed much.
    """
    changed = N + start - _face_normals(domain, f)
    near = np.einsum("ij,ij->i", changed, start) > _NEAR
    return np.where(near[:, None], changed, start)


def _face_normals(domain: Domain, f: Array) -> Array:
    """Normals (V, 3) of the faces around each vertex, by their areas."""
    return _unit(sum_rows(domain.faces.ravel(), np.repeat(area_vectors(f, domain.faces), 3, axis=0), len(f)))


def _unit(v: Array) -> Array:
    return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)


