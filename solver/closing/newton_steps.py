"""Newton's method for the closing conditions. Each step ends as near the beginning as first order allows,

    min |N - N₀|²_W + κ |q|²  with  J δN + J_q δq = -p,

with W the H¹ product along the boundary: without its derivative part the normals spike at corners. These steps settle
on the least change at a linear rate. Once the gap is small, the shortest step that closes it takes over: it converges
quadratically and hardly changes anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import MeshError
from ..gauss.frames import in_space
from ..gauss.sphere import dot, exp, normalize, tangent_axes
from ..linalg import factorize, graph_laplacian, sum_rows
from ..surface.adjoint import boundary_shares
from .closing_map import HARMONIC, ClosingMap, Place

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The length, as a part of the boundary, over which a change of its normals spreads.
_REACH = 0.02
# Residuals of harmonic maps: on the way, and in the end, where the periods need as many digits.
_LOOSE, _TIGHT = HARMONIC, 1e-11
# Radians by which a step may turn a normal, and by which it may change a modulus.
_LARGEST_TURN = 0.5
_HALVINGS = 8
# Gap, as a part of the size, that counts as small.
_LITTLE = 1e-3
# A step must leave less than this part of the gap.
_PROGRESS = 0.98
# Singular values below this part of the largest count as zero.
_RANK = 1e-8
# Derivatives must reach the sums up to this part of them.
_UNREACHED = 0.1


@dataclass(frozen=True, eq=False)
class Step:
    """place: the next one, None where no step gains. rank: how many of the sums change independently. reaches: whether
    the derivatives reach all sums left. at_end: whether moduli reached the end of their range, or turned faces over."""

    place: Place | None
    rank: int
    reaches: bool
    at_end: bool


class ClosingSteps:
    """by: "normals", "moduli" or "both" change. weight: κ. axes: (n, 3), the only ones about which normals turn."""

    def __init__(self, of: ClosingMap, by: str, weight: float, axes: Array | None) -> None:
        self.map, self.by, self.weight, self.axes = of, by, weight, axes
        self.product = boundary_product(of.moduli.first, of.fixed)

    def start(self, initial: Array | None) -> Place:
        return self.map.at(np.zeros(len(self.map.moduli.names)), self.map.first, initial, _LOOSE)

    def refined(self, place: Place) -> Place:
        """The same place, its map to the tightest residual."""
        if place.reached.harmonic.residual <= _TIGHT:
            return place
        return self.map.at(place.q, place.rim, place.reached.N, _TIGHT)

    def step(self, place: Place) -> Step:
        turn, change, rank, reaches = self._newton(place)
        far = max(np.sqrt(dot(turn, turn)).max(initial=0.0), np.abs(change).max(initial=0.0))
        length = min(1.0, _LARGEST_TURN / max(far, 1e-300))
        tolerance = float(np.clip(0.01 * place.gap**2, _TIGHT, _LOOSE))
        at_end = False
        for _ in range(_HALVINGS):
            rim = place.rim if self.by == "moduli" else exp(place.rim, length * turn)
            start = place.reached.N + place.extension.spread(rim - place.rim)
            q = self.map.moduli.clipped(place.q + length * change)
            at_end |= bool((q != place.q + length * change).any())
            try:
                trial = self.map.at(q, rim, start, tolerance)
            except MeshError:  # moduli that turn a face over
                trial, at_end = None, True
            # past a fold of the moduli no map exists, and the last iterate has no periods
            if trial is not None and trial.is_harmonic and trial.gap < _PROGRESS * place.gap:
                return Step(trial, rank, reaches, at_end)
            length *= 0.5
        return Step(None, rank, reaches, at_end)

    def _newton(self, place: Place) -> tuple[Array, Array, int, bool]:
        """Changes of the normals (n, 3) and of the moduli (m,), the rank, and whether they reach all sums."""
        if self.by == "moduli":
            columns = self.map.by_moduli(place)
            change, _, rank, _ = np.linalg.lstsq(columns, -place.sums, rcond=_RANK)
            return np.zeros_like(place.rim), change, int(rank), _is_reached(columns @ change, place.sums)
        basis = self._basis(place.rim)
        inverse = factorize(sp.csr_array(basis.T @ self.product @ basis))
        J = self.map.by_normals(place) @ basis
        spread = inverse.solve(np.ascontiguousarray(J.T))
        back = 1.0 if place.gap > _LITTLE else 0.0
        so_far, q = back * (basis.T @ (place.rim - self.map.first).ravel()), back * place.q
        gram, wanted = J @ spread, J @ so_far - place.sums
        columns = np.zeros((len(place.sums), 0))
        if self.by == "both":
            columns = self.map.by_moduli(place)
            gram, wanted = gram + columns @ columns.T / self.weight, wanted + columns @ q
        multiplier, _, rank, _ = np.linalg.lstsq(gram, wanted, rcond=_RANK)
        turn = spread @ multiplier - so_far
        change = columns.T @ multiplier / self.weight - q if self.by == "both" else np.zeros(len(place.q))
        moved = J @ turn + columns @ change[: columns.shape[1]]
        return (basis @ turn).reshape(-1, 3), change, int(rank), _is_reached(moved, place.sums)

    def _basis(self, rim: Array) -> sp.csr_array:
        """(3 n, d) directions in which normals may turn: two in each tangent plane, or one about an axis; at the end of
        a mirror, the one in its plane."""
        about = tangent_axes(rim) if self.axes is None else normalize(np.cross(self.axes, rim))[:, None]
        lines, held = self.map.lines(rim)
        every = enumerate(about.swapaxes(0, 1))
        directions = [np.where(held[:, None], lines if k == 0 else 0.0, d) for k, d in every]
        rows, starts = np.arange(rim.size), np.arange(0, rim.size + 1, 3)
        basis = sp.csc_array(sp.hstack([sp.csc_array((d.ravel(), rows, starts)) for d in directions]))
        basis.eliminate_zeros()
        return sp.csr_array(basis[:, np.flatnonzero(np.diff(basis.indptr))])


def _is_reached(moved: Array, sums: Array) -> bool:
    return bool(np.linalg.norm(moved + sums) <= _UNREACHED * np.linalg.norm(sums))


def boundary_product(domain: Domain, vertices: Int) -> sp.csr_array:
    """(3 n, 3 n) the H¹ product ∫ <u, v> + s² <u', v'> of vector functions at vertices (n,) of the boundary.

    The boundary has length one; s = `_REACH`.
    """
    edges = domain.boundary_edges
    lengths = domain.edge_lengths[edges] / domain.edge_lengths[edges].sum()
    mass = sp.diags_array(boundary_shares(domain))
    stiffness = graph_laplacian(domain.edges[edges], _REACH**2 / lengths, domain.vertex_count)
    scalar = sp.csr_array(mass + stiffness)[vertices][:, vertices]
    return sp.csr_array(sp.kron(scalar, sp.eye_array(3)))


def boundary_tangents(domain: Domain, positions: ArrayLike, vertices: Int) -> Array:
    """(n, 3) unit tangents of a plan's boundary at some of its vertices; positions (V, 2|3)."""
    points = in_space(domain, positions)
    i, j = domain.edges[domain.boundary_edges].T
    along = normalize(points[j] - points[i])
    return normalize((sum_rows(i, along, domain.vertex_count) + sum_rows(j, along, domain.vertex_count))[vertices])
