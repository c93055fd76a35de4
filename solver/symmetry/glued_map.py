"""The Gauss map of a completed surface, from the copies of a piece's normals.

A copy (R, t, s) of a surface shows the sheet s with the normals s R N, and its domain is turned over where R reverses
orientation. Glued by adjacency, the copies of the domain are the domain of the completed surface, and the copies of the
normals are a map on it. It is harmonic wherever N is, since the sum over the links of a vertex on a side is that over
the piece and its images. A minimiser on the piece is a critical point on the whole, but as a rule no minimiser there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.gluing import glued_domain
from ..errors import ConditionError
from ..signatures import checked
from .completion import Completion

Array = NDArray[np.float64]

# Normals of two copies at a common vertex may differ by this much: given normals may have only five digits.
_SAME = 1e-5


@dataclass(frozen=True, eq=False)
class GluedMap:
    """domain: of all copies. normals: (V, 3) the map on it. members: (K, n) the vertex that each of a copy became."""

    domain: Domain
    normals: Array
    members: NDArray[np.int64]

    def __repr__(self) -> str:
        return f"GluedMap({len(self.members)} copies, {self.domain!r})"

    @property
    def ok(self) -> bool:
        """Always: copies that disagree raise."""
        return True

    @property
    def message(self) -> str:
        return f"The normals of {len(self.members)} copies agree along their sides."


@checked
def whole(completion: Completion) -> GluedMap:
    """The domain of the copies of a completion, and the Gauss map on it (paper, Appendix G).

    The domain is closed if no copy is missing and the surface closes; else sides without a neighbour are its boundary.
    Raises `ConditionError` if the surface is cut open, has its normals at faces or on another triangulation, or if
    copies disagree about a common normal.
    """
    surface = completion.surface
    if surface.is_open or not surface.graph.at_vertices or surface.graph.domain is not surface.domain:
        raise ConditionError(
            "The map of the completed surface needs a piece that is not cut open, with normals at the "
            'vertices of its own mesh; solve with sites="vertices" and delaunay=False, and close its periods first.'
        )
    domain, copies = surface.domain, completion.copies
    seams = []
    rim = domain.boundary_edges
    for j, seam in enumerate(completion.seams):
        edges = rim[np.isin(domain.edges[rim], seam.here).all(axis=1)]
        for k in np.flatnonzero(completion.neighbours[:, j] >= 0).tolist():
            other = int(completion.neighbours[k, j])
            if k < other:
                seams.append((k, other, edges))
    joined = glued_domain(domain, [copy.flipped for copy in copies], seams)
    members = completion.members
    images = np.stack([copy.sheet * surface.normals @ copy.linear.T for copy in copies])
    normals = np.zeros((joined.vertex_count, 3))
    normals[members] = images
    off = np.abs(images - normals[members]).max()
    if off > _SAME:
        raise ConditionError(
            f"Copies of the surface disagree about the normals along their sides, by {off:.1e}; solve with the "
            "conditions that belong to the sides, to a smaller tolerance."
        )
    return GluedMap(joined, normals, members)
