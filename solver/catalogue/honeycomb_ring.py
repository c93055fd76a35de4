"""The honeycomb ring (paper, Sec. 5.3.3 and Figure 16): a domain of genus one with six boundary loops.

Six tubes of a hexagon and the half tubes that leave it are 72 copies of a quadrilateral between mirrors, on which the
map is a minimiser. On the ring it is a saddle with about a dozen unstable modes, and its periods vanish.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.topology import Homology
from ..errors import MeshError, Progress
from ..gauss import conditions as ways
from ..gauss.boundary_data import Conditions
from ..signatures import checked
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import solve_cmc
from ..symmetry.complete import complete
from ..symmetry.completion import Completion
from ..symmetry.glued_map import whole
from ..symmetry.sides import Side, side_plane
from . import modules

Array = NDArray[np.float64]

# The copies around a node, then those around the middle of the ring: for `complete(…, around=AROUND)`.
AROUND = (("axis", "bisector", "floor"), ("bisector", "end"))
# Tubes at a node → basis of the lattice of rings, in distances of nodes along and across a tube.
_LATTICES = {
    3: ((3.0, 0.0), (1.5, 1.5 * np.sqrt(3.0))),
    4: ((2.0, 0.0), (0.0, 2.0)),
    6: ((1.5, 0.5 * np.sqrt(3.0)), (0.0, np.sqrt(3.0))),
}


@dataclass(frozen=True, eq=False)
class Ring:
    """A whole ring, and the quadrilateral it is made of.

    domain: genus 1, with the edge lengths of the quadrilateral's plan; one boundary loop for each tube that leaves it.
    normals: (V, 3) the Gauss map. conditions: a mirror along each loop. positions: (V, 3) of f+, with the triangles of
    the domain. energy: E(N). periods: (b + 1, 3) of the assembled ring, for b loops.
    piece, sides: the solved quadrilateral and its sides "axis", "end", "floor", "bisector", as `complete` takes them.
    completion: its copies that form the ring. lattice: (2, 3) translations from one ring to the next; with
    `around=AROUND, translations=lattice, repeat=3` `complete` makes 3 × 3 of them.
    neck: the smallest radius of the tubes. spacing: of the nodes.
    """

    domain: Domain
    normals: Array
    conditions: Conditions
    positions: Array
    energy: float
    periods: Array
    piece: CmcSurface
    sides: list[Side]
    completion: Completion
    lattice: Array
    neck: float
    spacing: float

    def __repr__(self) -> str:
        return f"Ring({self.domain!r}, neck {self.neck:.4g}, spacing {self.spacing:.4g}, {self.piece.status.value})"

    @property
    def ok(self) -> bool:
        """Whether the map of the piece converged."""
        return self.piece.ok

    @property
    def message(self) -> str:
        return f"{self.piece.message} The ring consists of {len(self.completion.copies)} copies."


@checked
def ring(
    length: float = 2.4,
    *,
    tubes: int = 3,
    max_edge: float = 0.3,
    mean_curvature: float = 0.5,
    tolerance: float = 1e-12,
    progress: Progress | None = None,
) -> Ring:
    """A ring of tubes from a plan of this `length` and depth 1; longer plans have thinner necks (see `modules.node`).

    tubes: at a node; 3 for a hexagon of a honeycomb (72 copies, six loops), 4 for a square (64, eight loops), 6 for a
    triangle (72, twelve loops). max_edge: of the plan. tolerance: of the map on the quadrilateral.

    Raises `MeshError` on other numbers of tubes and on plans that are too short.
    """
    if tubes not in _LATTICES:
        raise MeshError(f"Rings have nodes of 3, 4 or 6 equal tubes, not {tubes!r}.")
    module = modules.node(tubes, length, max_edge=max_edge)
    surface, sides = _piece(module, mean_curvature, tolerance, progress)
    completion = complete(surface, sides, around=AROUND)
    joined = whole(completion)
    domain, N = joined.domain, joined.normals
    tau = domain.cotan_weights[:, None] * np.cross(*N[domain.edges.T])
    planes = {side.name: side_plane(surface, side) for side in sides}
    walls = AROUND[0]
    node = np.linalg.solve([module.normals[name] for name in walls], [planes[name].offset for name in walls])
    spacing = 2.0 * float(planes["end"].offset - node[0])
    section = surface.f_plus[planes["end"].cut_vertices] - node
    return Ring(
        domain=domain,
        normals=N,
        conditions=_mirrors(domain, N),
        positions=completion.mesh.vertices,
        energy=len(completion.copies) * surface.harmonic.energy,
        periods=surface.scale * Homology.of(domain).loops.T @ tau,
        piece=surface,
        sides=sides,
        completion=completion,
        lattice=spacing * np.column_stack([_LATTICES[tubes], np.zeros(2)]),
        neck=float(np.linalg.norm(section[:, 1:], axis=1).min()),
        spacing=spacing,
    )


def _piece(
    module: modules.Module, mean_curvature: float, tolerance: float, progress: Progress | None
) -> tuple[CmcSurface, list[Side]]:
    domain = module.shape.domain
    held, sides = Conditions(), []
    for name, edges in module.shape.sides.items():
        held += ways.mirror(domain, edges, module.normals[name])
        sides.append(Side(name, edges, "mirror", module.normals[name]))
    surface = solve_cmc(domain, held, mean_curvature=mean_curvature, tolerance=tolerance, progress=progress)
    return surface, sides


def _mirrors(domain: Domain, N: Array) -> Conditions:
    """A mirror across the middle of each tube that leaves the ring: N along the loop is orthogonal to the tube."""
    held = Conditions()
    for loop in domain.boundary_loop_edges:
        held += ways.mirror(domain, loop, np.linalg.svd(N[np.unique(domain.edges[loop])])[2][-1])
    return held
