"""The Hopf differential of a surface: measured on the faces, denoised at the vertices, its zeros counted.

On a surface with conformal parameter z = x + iy and unit normals N, Q = 4 <f_z, N_z> has `|Q| = e^{2u} (k1 - k2)`, and
along a tangent vector X the normal curvature is H + ½ Re(Q X²) / e^{2u} |X|²: the direction with Q X² > 0 has the
larger curvature k1. Q dz² is holomorphic where H is constant. It is the same on f+ with N and on f- with -N. Its zeros
are umbilics of one sheet and branch points of the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.trees import Tree
from ..errors import ConditionError, MeshError, plural
from ..linalg import Factor, ReusedFactor, factorize, sum_rows
from ..surface.vertex_fit import fan_angles
from .sheets import Sheet, check_no_handles, gradients, layout, shape_gradients

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# The weight h² of |∂̄q|², as a multiple of a face's area: least error on jittered meshes of exact surfaces.
_SMOOTHING = 2.3
# Where the holomorphic part of Q is smaller than this part of the rest, Q is noise: the surface is a sphere or a plane.
_NOISE = 0.1
# …or where k1 - k2 is everywhere below this part of the curvature, over √V: spanned spheres have 0.15 / √V.
_ROUND = 0.5


@dataclass(frozen=True, eq=False)
class HopfDifferential:
    """Q of a sheet: measured on the faces (F,), and q (F, 3), holomorphic as far as possible, at their corners.

    Both are in the layout of each face (`Domain.layout`). vertex_orders: (V,) the order of the zero of q at each
    vertex, 0 at most of them; on the boundary 0.
    """

    domain: Domain
    measured: Complex
    at_corners: Complex
    vertex_orders: NDArray[np.int64]

    @cached_property
    def at_faces(self) -> Complex:
        """q (F,) in the middle of each face."""
        return self.at_corners.mean(axis=1)

    @property
    def zeros(self) -> NDArray[np.int64]:
        """Vertices at which q vanishes: umbilics, of index -order / 2."""
        return np.flatnonzero(self.vertex_orders)

    @property
    def orders(self) -> NDArray[np.int64]:
        """The order of each of the `zeros`."""
        return self.vertex_orders[self.zeros]

    @cached_property
    def boundary_winding(self) -> int:
        """How often q t² turns along the boundary, t the tangent, on all loops together.

        The zeros obey `Σ orders = boundary_winding - 2 χ`, by Poincaré and Hopf.
        """
        return round(float(_boundary_turn(self)) / (2.0 * np.pi))

    def __repr__(self) -> str:
        return f"HopfDifferential({len(self.measured)} faces, zeros of order {self.orders.tolist()})"


def hopf_differential(sheet: Sheet) -> HopfDifferential:
    """The Hopf differential of a sheet.

    Raises `MeshError` on handles and where the mesh is too coarse for q (zeros of negative order), `ConditionError` on
    spheres and planes, which are umbilic everywhere.
    """
    check_no_handles(sheet.domain)
    measured = measured_differential(sheet)
    at_corners = _denoised(sheet.domain, measured)
    _check_not_round(sheet, measured, at_corners.mean(axis=1))
    orders = _vertex_orders(sheet.domain, at_corners.mean(axis=1))
    bad = np.flatnonzero(orders < 0)
    if bad.size:
        raise MeshError(
            f"The mesh is too coarse for curvature lines near {plural('vertex', bad)}, where they seem to have a pole; "
            "refine it there, or round the corner of the plan.",
            vertices=bad,
        )
    return HopfDifferential(sheet.domain, measured, at_corners, orders)


def measured_differential(sheet: Sheet) -> Complex:
    """Q (F,) in the layout of each face, of f+ or f-, whichever jumps less from face to face."""
    found = [_measured(sheet.domain, *one) for one in sheet.sheets]
    return min(found, key=lambda Q: _jumps(sheet.domain, Q)) if len(found) > 1 else found[0]


def _measured(domain: Domain, points: Array, normals: Array) -> Complex:
    """Q (F,) = <f_x, N_x> - <f_y, N_y> - i (<f_x, N_y> + <f_y, N_x>)."""
    fx, fy = gradients(domain, points)
    nx, ny = gradients(domain, normals)
    real = np.einsum("fi,fi->f", fx, nx) - np.einsum("fi,fi->f", fy, ny)
    return real - 1j * (np.einsum("fi,fi->f", fx, ny) + np.einsum("fi,fi->f", fy, nx))


def _jumps(domain: Domain, Q: Complex) -> float:
    """The sum of the squared jumps of Q dz² across inner edges."""
    z = layout(domain)
    square = np.repeat(Q, 3) * (z[:, [2, 0, 1]] - z[:, [1, 2, 0]]).ravel() ** 2
    left, right = domain.half_edges[domain.interior_edges].T
    return float((np.abs(square[left] - square[right]) ** 2).sum())


def corner_turns(domain: Domain) -> Array:
    """Angles (F, 3) by which the layout of a face is turned against the frame of each of its vertices.

    The angles around an inner vertex are scaled to 2π, the middle of each corner kept. The frames are parallel along a
    tree of edges, hence everywhere on a flat disc.
    """
    corners = np.arange(domain.faces.size)
    start, stretch = fan_angles(domain, corners)
    z = layout(domain)
    leaving = np.angle(z[:, [1, 2, 0]] - z).ravel()
    turns = start + 0.5 * (stretch - 1.0) * domain.corner_angles.ravel() - leaving
    turns = turns.reshape(-1, 3)
    left = domain.half_edges[:, 0]
    face, k = left // 3, left % 3
    transport = turns[face, (k + 2) % 3] - turns[face, (k + 1) % 3]
    gauge = Tree.of(domain.edges, domain.vertex_count).integrate(transport[:, None])[:, 0]
    return turns + gauge[domain.faces]


class _TwoBlocks:
    """The factor of a real matrix, applied to real and imaginary part one after the other."""

    def __init__(self, factor: Factor) -> None:
        self.factor = factor

    def solve(self, b: Array) -> Array:
        n = len(b) // 2
        both = np.column_stack([b[:n].reshape(n, -1), b[n:].reshape(n, -1)])
        x = self.factor.solve(both)
        k = x.shape[1] // 2
        return np.concatenate([x[:, :k], x[:, k:]]).reshape(b.shape)


def _denoised(domain: Domain, Q: Complex) -> Complex:
    """q (F, 3) at the corners, the minimiser of Σ A_f |Q_f - q̄_f|² + Σ A_f h_f² |∂̄q|² over values at the vertices.

    q is linear in each face. The Hermitian matrix is almost real in the frames of `corner_turns`, so its real part is
    factored and preconditions conjugate gradients.
    """
    phase = np.exp(2j * corner_turns(domain))
    areas = domain.face_areas
    mean = phase / 3.0
    dbar = 0.5 * shape_gradients(domain) * phase
    blocks = np.einsum("f,fi,fj->fij", areas, mean.conj(), mean)
    blocks += np.einsum("f,fi,fj->fij", _SMOOTHING * areas**2, dbar.conj(), dbar)
    n = domain.vertex_count
    rows = np.repeat(domain.faces, 3, axis=1).ravel()
    cols = np.tile(domain.faces, (1, 3)).ravel()
    A = sp.csr_array(sp.coo_array((blocks.ravel(), (rows, cols)), shape=(n, n)))
    weighted = ((areas * Q)[:, None] * mean.conj()).ravel()
    right = sum_rows(domain.faces.ravel(), np.column_stack([weighted.real, weighted.imag]), n)
    real, imag = sp.csr_array(A.real), sp.csr_array(A.imag)
    both = sp.csr_array(sp.block_array([[real, -imag], [imag, real]]))
    x = ReusedFactor(both, _TwoBlocks(factorize(real))).solve(np.concatenate([right[:, 0], right[:, 1]]))
    return (x[:n] + 1j * x[n:])[domain.faces] * phase


def _check_not_round(sheet: Sheet, measured: Complex, q: Complex) -> None:
    """Raise `ConditionError` on a sphere or a plane."""
    areas, (points, normals) = sheet.domain.face_areas, sheet.sheets[0]
    kept = np.sqrt(areas @ np.abs(q) ** 2)
    noise = np.sqrt(areas @ np.abs(measured - q) ** 2)
    fx, fy = gradients(sheet.domain, points)
    nx, ny = gradients(sheet.domain, normals)
    bent = np.sqrt(areas @ ((fx**2 + fy**2).sum(axis=1) * (nx**2 + ny**2).sum(axis=1)))
    flat = bent <= 1e-9 * areas @ (fx**2 + fy**2).sum(axis=1) / max(np.ptp(points, axis=0).max(), 1e-300)
    if flat or kept < _NOISE * noise or kept < _ROUND * bent / np.sqrt(len(points)):
        shape = "plane" if flat else "sphere"
        raise ConditionError(
            f"The surface is a part of a {shape} as far as this mesh can tell, umbilic everywhere: every line on it is "
            "a curvature line. Lay any net on it, or bend its rim."
        )


def edge_turns(domain: Domain, q: Complex) -> Array:
    """arg (E,) of q dz² seen from the left face of an inner edge over that from the right one; 0 on the boundary."""
    z = layout(domain)
    side = (z[:, [2, 0, 1]] - z[:, [1, 2, 0]]).ravel()
    square = np.repeat(q, 3) * side**2
    left, right = domain.half_edges.T
    turns = np.angle(square[left] * square[np.maximum(right, 0)].conj())
    return np.where(right >= 0, turns, 0.0)


def _vertex_orders(domain: Domain, q: Complex) -> NDArray[np.int64]:
    """The order (V,) of q at each inner vertex: (Σ turns across its edges - 2 K) / 2π, with the angle defect K."""
    turns = edge_turns(domain, q)
    tail, head = domain.edges.T
    n = domain.vertex_count
    total = np.bincount(tail, turns, n) - np.bincount(head, turns, n)
    defect = 2.0 * np.pi - np.bincount(domain.faces.ravel(), domain.corner_angles.ravel(), n)
    orders = np.rint((total - 2.0 * defect) / (2.0 * np.pi)).astype(np.int64)
    orders[domain.boundary_vertices] = 0
    return orders


def _boundary_turn(hopf: HopfDifferential) -> float:
    """The angle by which q t² turns along the boundary: twice the exterior angles, and q from face to face."""
    domain = hopf.domain
    q = hopf.at_faces
    rim = domain.boundary_edges
    n = domain.vertex_count
    angles = np.bincount(domain.faces.ravel(), domain.corner_angles.ravel(), n)
    # q in the frame of a vertex, in the face of the boundary edge that leaves it and of the one that arrives
    phase = np.exp(-2j * corner_turns(domain))
    half = domain.half_edges[rim, 0]
    face, k = half // 3, half % 3
    leaving, arriving = np.zeros((2, n), dtype=np.complex128)
    leaving[domain.edges[rim, 0]] = q[face] * phase[face, (k + 1) % 3]
    arriving[domain.edges[rim, 1]] = q[face] * phase[face, (k + 2) % 3]
    on = domain.boundary_vertices
    return float((2.0 * (np.pi - angles[on]) + np.angle(leaving[on] * arriving[on].conj())).sum())
