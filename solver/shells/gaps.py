"""The gap around each hole of a plan: its length and place on a placed shell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.topology import Homology
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import Similarity

Array = NDArray[np.float64]

# Two copies of a vertex that differ by the period, up to this part of it, are the two ends of the gap.
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class HoleGap:
    """name: "hole 1" has the longest rim, the outline left out; or "period 1" on a plan with handles.

    period (3,), in world units: the shift of the shell once around the hole. relative: its length as a part of the size
    of f+, the diagonal of its box. at (3,): its beginning on the rim of the hole, at the gap where the shell is cut
    open there.
    """

    name: str
    period: Array
    relative: float
    at: Array

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.period))

    def to_dict(self) -> dict[str, object]:
        return {
            "name": self.name,
            "period": self.period.tolist(),
            "length": self.length,
            "relative": self.relative,
            "at": self.at.tolist(),
        }


def surface_gaps(surface: CmcSurface, similarity: Similarity, points: Array) -> list[HoleGap]:
    """One per hole; on a plan with handles one per period, since not every period belongs to a hole.

    points (n, 3): of the shown sheet in its place.
    """
    domain = surface.domain
    if not len(surface.periods):
        return []
    periods = similarity.scale * similarity.directions(period_vectors(surface))
    relative = relative_lengths(surface).tolist()
    if _has_handles(domain):
        middle = points.mean(axis=0)
        return [HoleGap(f"period {k + 1}", period, relative[k], middle) for k, period in enumerate(periods)]
    gaps = []
    for k, loop in enumerate(hole_loops(domain)):
        at, period = _ends(surface.source, points, domain.boundary_loops[loop], periods[k])
        gaps.append(HoleGap(f"hole {k + 1}", period, relative[k], at))
    return gaps


def relative_lengths(surface: CmcSurface) -> Array:
    """(k,) the lengths of `period_vectors` as parts of the diagonal of the box of f+."""
    size = float(np.linalg.norm(np.ptp(surface.f_plus, axis=0)))
    return np.linalg.norm(period_vectors(surface), axis=1) / size


def period_vectors(surface: CmcSurface) -> Array:
    """(k, 3) the periods around the holes, the longest rim first, in the units of the surface; on a plan with handles
    those around the generators of its homology."""
    domain = surface.domain
    if _has_handles(domain):
        return surface.periods
    return turns_of_loops(Homology.of(domain))[hole_loops(domain)] @ surface.periods


def _has_handles(domain: Domain) -> bool:
    return domain.genus > 0


def hole_loops(domain: Domain) -> list[int]:
    """Indices of the holes in `domain.boundary_loops`, the longest rim first."""
    lengths = [domain.edge_lengths[edges].sum() for edges in domain.boundary_loop_edges]
    return np.argsort(-np.array(lengths), kind="stable")[1:].tolist()


def turns_of_loops(homology: Homology) -> NDArray[np.int64]:
    """(b, k) how often a walk along each boundary loop, on the faces beside it, winds around each period.

    From one boundary edge of a vertex to the next the walk crosses all other edges there, from right to left where they
    begin at the vertex.
    """
    domain, crossings = homology.domain, homology.crossings.astype(np.int64)
    owner = np.full(domain.vertex_count, -1)
    for k, loop in enumerate(domain.boundary_loops):
        owner[loop] = k
    turns = np.zeros((len(domain.boundary_loops), crossings.shape[1]), dtype=np.int64)
    for end, sign in ((0, 1), (1, -1)):
        loops = owner[domain.edges[homology.cut, end]]
        np.add.at(turns, loops[loops >= 0], sign * crossings[homology.cut[loops >= 0]])
    return turns


def _ends(source: NDArray[np.integer], points: Array, loop: NDArray[np.integer], period: Array) -> tuple[Array, Array]:
    """The beginning of the gap, and the period from there to its other end."""
    length = np.linalg.norm(period)
    for vertex in loop.tolist():
        first, *copies = np.flatnonzero(source == vertex).tolist()
        for copy in copies:
            jump = points[copy] - points[first]
            for sign in (1.0, -1.0):
                if np.linalg.norm(jump - sign * period) <= _SAME * length:
                    return points[first], jump
    return points[np.isin(source, loop)].mean(axis=0), period
