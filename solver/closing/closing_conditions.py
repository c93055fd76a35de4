"""Closing conditions: the periods, and the distances between sides of one plane, that must vanish.

Along a mirror with the normal ν the boundary points of the conjugate lie in one plane exactly: around a vertex there
Σ_j <tau_ij, ν> = 0, since LN has no part along N × ν. The distance between two such planes is the sum of <tau, ν> along
any path of faces from one side to the other, a period like those around holes (paper, Sec. 5.3.3; see
`surface.periods`). All conditions are linear in tau, and so in the products N_i × N_j.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from ..domain.domain import Domain
from ..domain.topology import Homology
from ..errors import ConditionError
from ..gauss.boundary_data import Conditions
from ..gauss.frames import boundary_edges
from ..gauss.mirrors import MirrorSides, parallel
from ..surface.periods import Factored, path_across, smoothed
from ..symmetry.sides import Side

Array = NDArray[np.float64]
Int = NDArray[np.integer]

NOTHING_OPEN = (
    "There is nothing to close: the domain has neither holes nor handles, and no two sides must share a plane."
)


@dataclass(frozen=True, eq=False)
class ClosingConditions:
    """m conditions: K sums of parts of tau along paths that must vanish.

    paths: (E, m) how often the path of each condition crosses each edge; names: of the m conditions. directions: (K, 3)
    units, owners (K,): the condition of each sum, three for a period, one for the distance between two planes.
    """

    homology: Homology
    paths: Int
    directions: Array
    owners: Int
    names: tuple[str, ...]

    @classmethod
    def of(cls, domain: Domain, conditions: Conditions, coplanar: Sequence[Sequence[Side]] = ()) -> ClosingConditions:
        """All periods of a domain, and the distances of the sides of each group from its first side.

        Raises `ConditionError` where nothing is open, or sides are not along mirrors of one direction.
        """
        homology = Homology.of(domain)
        loops = len(homology.generators)
        names = [f"period {k}" for k in range(loops)]
        paths, directions = [homology.loops[:, k] for k in range(loops)], [np.eye(3)] * loops
        for group in coplanar:
            (first, start, normal), *others = _runs(domain, conditions, group)
            for name, end, _ in others:
                names.append(f"{first!r} to {name!r}")
                paths.append(path_across(homology, start, end))
                directions.append(normal[None])
        if not names:
            raise ConditionError(NOTHING_OPEN)
        sizes = [len(each) for each in directions]
        owners = np.repeat(np.arange(len(names)), sizes)
        return cls(homology, np.stack(paths, axis=1), np.concatenate(directions), owners, tuple(names))

    def forms(self, dirichlet: Factored, domain: Domain) -> Array:
        """η (E, m) of the paths, on a domain with the same faces."""
        return smoothed(domain, self.paths, dirichlet)

    def sums(self, forms: Array, tau: Array) -> Array:
        """(K,) from η (E, m) and tau (E, 3)."""
        return np.asarray(np.einsum("kx,kx->k", (forms.T @ tau)[self.owners], self.directions))

    def by_tau(self, forms: Array, k: int) -> Array:
        """(E, 3) the derivative of sum k by tau."""
        return forms[:, self.owners[k], None] * self.directions[k]

    def lengths(self, sums: Array) -> Array:
        """(len(names),) of the periods and distances."""
        return np.sqrt(np.bincount(self.owners, sums**2, len(self.names)))


def _runs(domain: Domain, conditions: Conditions, group: Sequence[Side]) -> list[tuple[str, int, Array]]:
    """Side name, boundary edge and plane normal of each piece of boundary in a group; touching sides are one piece."""
    planes = MirrorSides.of(domain, conditions).planes
    edges, owners = [], []
    for k, side in enumerate(group):
        chosen = boundary_edges(domain, side.edges)
        mirrored = planes[chosen].any(axis=1)
        if not chosen.size or not (mirrored.all() if side.kind == "mirror" else side.kind == "free"):
            raise ConditionError(
                f"Side {side.name!r} cannot be moved into a plane: it is not all along a mirror, nor free."
            )
        edges.append(chosen)
        owners.append(np.full(len(chosen), k))
    together, owner = np.concatenate(edges), np.concatenate(owners)
    along = planes[together].any(axis=1)
    if not along.any():
        raise ConditionError("Free sides have no plane of their own; name a mirror whose plane they share.")
    # on a free side the conjugate is one point, which has a place along any normal
    normals = np.where(along[:, None], planes[together], planes[together][along][0])
    odd = np.flatnonzero(~parallel(normals, normals[along][:1]))
    if odd.size:
        names = [group[owner[at]].name for at in (0, odd[0])]
        raise ConditionError(f"Sides {names[0]!r} and {names[1]!r} cannot lie in one plane: they are not parallel.")
    held = conditions.resolve()[0]
    ends = domain.edges[together]
    rows, columns = np.repeat(np.arange(len(together)), 2), ends.ravel()
    loose = ~np.isin(columns, held)
    shape = (len(together), domain.vertex_count)
    touching = sp.csr_array((np.ones(loose.sum()), (rows[loose], columns[loose])), shape=shape)
    pieces = connected_components(touching @ touching.T, directed=False)[1]
    firsts = np.sort(np.unique(pieces, return_index=True)[1])
    return [(group[int(owner[at])].name, int(together[at]), normals[0]) for at in firsts]
