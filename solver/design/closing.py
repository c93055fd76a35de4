"""Closing the periods of a surface: around holes and handles it shall come back to where it began.

The periods p (k, 3) of g are functions of the boundary normals N₀ and of the conformal type of the domain, given by a
few moduli q. Newton's method with the derivatives J of `adjoint` and of `moduli`; of all the steps that close to first
order it takes the one that ends nearest to where all began,

    min |N - N₀|²_W + κ |q|²  with  J δN + J_q δq = -p,

W being the H¹ product along the boundary: without its part of derivatives the normals spike at corners.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.topology import Homology
from ..errors import ConditionError, MeshError, chosen
from ..gauss.conditions import Conditions
from ..gauss.frames import area_vectors, in_space
from ..gauss.harmonic import HarmonicSolver
from ..gauss.sphere import dot, exp, normalize
from ..linalg import factorize, graph_laplacian, sum_rows
from ..surface.cmc import CmcSurface
from ..surface.solve import CmcSolver
from .adjoint import Extension, State
from .moduli import Moduli
from .targets import boundary_shares

Array = NDArray[np.float64]
Int = NDArray[np.integer]
Progress = Callable[[int, float], bool | None]

# The length along the boundary, as a part of all of it, over which a change of its normals is spread.
_REACH = 0.02
# Harmonic maps are found to this residual, so that periods are known to as many digits.
_RESIDUAL = 1e-11
# Radians by which a step may turn a normal, and by which it may change a modulus.
_LARGEST_TURN = 0.5
_HALVINGS = 8
# A step that leaves more than this part of the gap is no progress.
_PROGRESS = 0.98
# Singular values below this part of the largest are none.
_RANK = 1e-8
# Part of the first surface's area below which there is none to speak of.
_COLLAPSED = 0.05
WAYS = ("normals", "moduli", "both")


class ClosingStatus(Enum):
    """How closing ended; `sentence` says it to a person."""

    CLOSED = "closed"
    STALLED = "stalled"
    RANK_DEFICIENT = "rank deficient"
    STEP_LIMIT = "step limit"
    CANCELLED = "cancelled"
    COLLAPSED = "collapsed"

    @property
    def sentence(self) -> str:
        return {
            ClosingStatus.CLOSED: "The surface closes.",
            ClosingStatus.STALLED: "No step brings the surface nearer to closing; change the boundary, or let more of "
            "it move.",
            ClosingStatus.RANK_DEFICIENT: "What may change does not reach all parts of the gap; let the normals "
            "change, or more moduli.",
            ClosingStatus.STEP_LIMIT: "The limit of steps was reached before the surface closed.",
            ClosingStatus.CANCELLED: "Closing was cancelled.",
            ClosingStatus.COLLAPSED: "The surface collapses on the way; no closed one was found near this boundary.",
        }[self]


@dataclass(frozen=True, eq=False)
class Closing:
    """The surface reached, and what it took.

    domain: with the moduli (m,) found, names in `names`. conditions: with the normals found, at vertices.
    gaps: the longest period as a part of the size, before and after each step. turned: (n,) radians by which the
    prescribed normals changed. area_ratio: the area of f+ now as a part of that before.
    """

    surface: CmcSurface
    domain: Domain
    conditions: Conditions
    moduli: Array
    names: tuple[str, ...]
    gaps: list[float]
    turned: Array
    status: ClosingStatus
    area_ratio: float

    @property
    def closed(self) -> bool:
        return self.status is ClosingStatus.CLOSED

    @property
    def message(self) -> str:
        """How it ended, the gap, and what changed."""
        words = [self.status.sentence, f"The gap was {self.gaps[0]:.2g} of the size and is {self.gaps[-1]:.2g}."]
        if self.turned.any():
            largest, mean = np.degrees([self.turned.max(), np.sqrt(np.mean(self.turned**2))])
            words.append(f"Normals along the boundary turned by {largest:.1f}° at most, {mean:.1f}° root mean square.")
        words += [f"{name} changed by {q:+.3g}." for name, q in zip(self.names, self.moduli, strict=True)]
        return " ".join(words)


def close_periods(
    domain: Domain,
    conditions: Conditions,
    *,
    by: str = "normals",
    moduli: Moduli | None = None,
    weight: float = 1.0,
    positions: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    mean_curvature: float = 0.5,
    tolerance: float = 1e-9,
    max_steps: int = 12,
    progress: Progress | None = None,
) -> Closing:
    """Change the prescribed normals, the moduli of the domain, or both until the periods of the surface vanish.

    by: "normals", the least change of the normals in the H¹ norm along the boundary; "moduli", Newton's method in
    those; "both", the least of both together, the squares of moduli times `weight`. positions: (V, 2|3) of the plan;
    with them only the tilts change, each normal turning about the boundary's tangent. tolerance: of the periods, as
    sums along loops, as a part of the size of f+. progress(step, gap) is called at every step, False cancels.

    Not closing is a status, with the nearest surface. Raises `ConditionError` on a simply connected domain, on names
    that do not exist, and where nothing may change.
    """
    chosen(by, dict.fromkeys(WAYS), "way to close")
    if (moduli is None) != (by == "normals"):
        raise ConditionError(f'Closing by "{by}" {"needs" if moduli is None else "does not take"} moduli.')
    if not conditions.vertices.size and by != "moduli":
        raise ConditionError("No normals are prescribed that could change; close by moduli.")
    newton = _Newton(domain, conditions, by, moduli, weight, positions)
    return newton.run(initial, tolerance, max_steps, progress, mean_curvature)


@dataclass(frozen=True, eq=False)
class _Place:
    """A map on the way: moduli (m,), prescribed normals (n, 3), the surface at scale 1, periods, size and gap."""

    q: Array
    rim: Array
    extension: Extension
    state: State
    size: float

    @property
    def periods(self) -> Array:
        return self.state.periods.ravel()

    @property
    def gap(self) -> float:
        return float(np.sqrt(dot(self.state.periods, self.state.periods).max())) / self.size


class _Newton:
    def __init__(
        self,
        domain: Domain,
        conditions: Conditions,
        by: str,
        moduli: Moduli | None,
        weight: float,
        positions: ArrayLike | None,
    ) -> None:
        self.conditions, self.by, self.weight = conditions, by, weight
        self.moduli = moduli or Moduli((), lambda q: domain)
        self.fixed, self.first = conditions.resolve()
        self.domain = self.moduli.domain(np.zeros(len(self.moduli.names)))
        if Homology.of(self.domain).is_trivial:
            raise ConditionError("The domain has neither holes nor handles: its surface has no periods to close.")
        self.product = boundary_product(self.domain, self.fixed)
        self.axes = None if positions is None else _tangents(self.domain, positions, self.fixed)

    def run(
        self, initial: ArrayLike | None, tolerance: float, limit: int, progress: Progress | None, mean_curvature: float
    ) -> Closing:
        start = None if initial is None else np.asarray(initial, dtype=np.float64)
        place = self._at(np.zeros(len(self.moduli.names)), self.first, start)
        area, gaps = _area(place), [place.gap]
        while True:
            status = _ended(place, len(gaps) - 1, tolerance, limit, area)
            if progress is not None and progress(len(gaps) - 1, place.gap) is False:
                status = ClosingStatus.CANCELLED
            if status is not None:
                break
            following, full = self._step(place)
            if following is None:
                status = ClosingStatus.STALLED if full else ClosingStatus.RANK_DEFICIENT
                break
            place = following
            gaps.append(place.gap)
        return self._result(place, gaps, status, _area(place) / area, mean_curvature)

    def _at(self, q: Array, rim: Array, start: Array | None) -> _Place:
        extension = Extension(HarmonicSolver(self.moduli.domain(q)), self.conditions)
        state = extension(rim, start, _RESIDUAL)
        size = float(np.linalg.norm(np.ptp(state.g + state.N, axis=0)))
        return _Place(q, rim, extension, state, size)

    def _step(self, place: _Place) -> tuple[_Place | None, bool]:
        """The next place, None where no step gains, and whether the derivatives reach all periods."""
        turn, change, full = self._newton_step(place)
        far = max(np.sqrt(dot(turn, turn)).max(initial=0.0), np.abs(change).max(initial=0.0))
        length = min(1.0, _LARGEST_TURN / max(far, 1e-300))
        for _ in range(_HALVINGS):
            rim = exp(place.rim, length * turn)
            start = place.state.N + place.extension.spread(rim - place.rim)
            try:
                trial = self._at(place.q + length * change, rim, start)
            except MeshError:  # moduli that turn a face over
                length *= 0.5
                continue
            if trial.gap < _PROGRESS * place.gap:
                return trial, full
            length *= 0.5
        return None, full

    def _newton_step(self, place: _Place) -> tuple[Array, Array, bool]:
        """Changes of the normals (n, 3) and of the moduli (m,), and whether they reach all periods."""
        rows, columns = self._by_normals(place), self._by_moduli(place)
        basis = self._basis(place.rim)
        inverse = factorize(sp.csr_array(basis.T @ self.product @ basis))
        J = rows @ basis
        spread = inverse.solve(np.ascontiguousarray(J.T)) if J.size else J.T
        so_far = basis.T @ (place.rim - self.first).ravel()
        wanted = J @ so_far - place.periods
        if self.by == "both":
            wanted = wanted + columns @ place.q
        gram = J @ spread
        if self.by != "normals":
            gram = gram + columns @ columns.T / self.weight
        multiplier, _, rank, _ = np.linalg.lstsq(gram, wanted, rcond=_RANK)
        turn = (basis @ (spread @ multiplier - so_far)).reshape(-1, 3)
        if self.by == "moduli":
            change, _, rank, _ = np.linalg.lstsq(columns, -place.periods, rcond=_RANK)
            return np.zeros_like(place.rim), change, bool(rank == len(place.periods))
        change = columns.T @ multiplier / self.weight - place.q if self.by == "both" else np.zeros(len(place.q))
        return turn, change, bool(rank == len(place.periods))

    def _basis(self, rim: Array) -> sp.csr_array:
        """(3 n, d) directions in which normals may turn: two of each tangent plane, or one about an axis."""
        if self.axes is not None:
            directions = [normalize(np.cross(self.axes, rim))]
        else:
            helper = np.eye(3)[np.argmin(np.abs(rim), axis=1)]
            first = normalize(np.cross(rim, helper))
            directions = [first, np.cross(rim, first)]
        return sp.csr_array(sp.hstack([sp.block_diag(d[:, :, None]) for d in directions]))

    def _by_normals(self, place: _Place) -> Array:
        """(3 k, 3 n) the derivatives of the periods by the prescribed normals."""
        if self.by == "moduli":
            return np.zeros((len(place.periods), place.rim.size))
        zero = np.zeros_like(place.state.N)
        units = np.eye(len(place.periods)).reshape(-1, *place.state.periods.shape)
        return np.stack([place.extension.pull_back(place.state, zero, zero, unit).ravel() for unit in units])

    def _by_moduli(self, place: _Place) -> Array:
        """(3 k, m) the derivatives of the periods by the moduli, the map following (implicit function theorem)."""
        if self.by == "normals":
            return np.zeros((len(place.periods), 0))
        columns = self.moduli.weights(place.q).T
        return np.stack([place.extension.by_weights(place.state, column).ravel() for column in columns], axis=1)

    def _result(
        self, place: _Place, gaps: list[float], status: ClosingStatus, area_ratio: float, mean_curvature: float
    ) -> Closing:
        found = place.extension.given(place.rim)
        tolerance = np.inf if status is ClosingStatus.CLOSED else 1e-3
        surface = CmcSolver(place.extension.domain).solve(
            found, initial=place.state.N, mean_curvature=mean_curvature, period_tolerance=tolerance
        )
        turned = np.arccos(np.clip(dot(place.rim, self.first)[:, 0], -1.0, 1.0))
        domain, names = place.extension.domain, self.moduli.names
        return Closing(surface, domain, found, place.q, names, gaps, turned, status, area_ratio)


def _ended(place: _Place, step: int, tolerance: float, limit: int, area: float) -> ClosingStatus | None:
    if _area(place) < _COLLAPSED * area:
        return ClosingStatus.COLLAPSED
    if place.gap <= tolerance:
        return ClosingStatus.CLOSED
    return ClosingStatus.STEP_LIMIT if step >= limit else None


def boundary_product(domain: Domain, vertices: Int) -> sp.csr_array:
    """(3 n, 3 n) the H¹ product along the boundary of vector functions at some of its vertices (n,).

    ∫ <u, v> + s² <u', v'>, the length of the boundary being one, s = `_REACH`.
    """
    edges = domain.boundary_edges
    lengths = domain.edge_lengths[edges] / domain.edge_lengths[edges].sum()
    mass = sp.diags_array(boundary_shares(domain))
    stiffness = graph_laplacian(domain.edges[edges], _REACH**2 / lengths, domain.vertex_count)
    scalar = sp.csr_array(mass + stiffness)[vertices][:, vertices]
    return sp.csr_array(sp.kron(scalar, sp.eye_array(3)))


def _tangents(domain: Domain, positions: ArrayLike, vertices: Int) -> Array:
    """(n, 3) unit tangents of the boundary of a plan at some of its vertices."""
    points = in_space(domain, positions)
    i, j = domain.edges[domain.boundary_edges].T
    along = normalize(points[j] - points[i])
    return normalize((sum_rows(i, along, domain.vertex_count) + sum_rows(j, along, domain.vertex_count))[vertices])


def _area(place: _Place) -> float:
    """Of f+ at scale 1."""
    points = place.state.g + place.state.N
    return float(np.linalg.norm(area_vectors(points, place.extension.domain.faces), axis=1).sum())
