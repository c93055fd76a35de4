"""The result of a completion: copies of a surface, their transforms and gaps, and the welded mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..domain.gluing import Glued, check_glued, glue
from ..errors import Status
from ..measure.summary import count as plural_count
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import Similarity
from .arrangement import Arrangement, Corner, Offset
from .isometries import Isometry
from .seams import Seam
from .sides import SidePlane, surface_size
from .weld import CompletedMesh, Gap, snapped_to_planes, welded

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Neighbours that are nearer than this part of the surface's size meet.
_MEETS = 0.01


@dataclass(frozen=True, eq=False)
class Completion:
    """Copies of a surface, and which of them are neighbours; the mesh is built when `mesh` is first read.

    copies: the first one is the surface itself, unless a box leaves it out. sheet: the one it shows, "f+" or "f-".
    neighbours: (K, m) the copy across each of the m `seams`, -1 at the outer rim.
    lattice: (k, 3) translations under which the completed surface repeats; empty where only copies were counted.
    arrangement: planes, offsets and corners of the sides. is_whole: whether no copy is missing, so that the group is
    finite and all of it is here.
    """

    surface: CmcSurface
    sheet: str
    copies: list[Isometry]
    seams: list[Seam]
    neighbours: NDArray[np.int64]
    lattice: Array
    arrangement: Arrangement

    def __repr__(self) -> str:
        repeats = f", repeats by {plural_count(len(self.lattice), 'translation')}" if len(self.lattice) else ""
        whole = ", whole" if self.is_whole else ""
        copies = plural_count(len(self.copies), "copy", "copies")
        return f"Completion({copies} of {self.sheet}, {self.face_count} faces{repeats}{whole})"

    @property
    def ok(self) -> bool:
        """Whether the map of the piece converged and neighbours met, within a hundredth of the surface's size."""
        return self.surface.harmonic.status is Status.CONVERGED and self._widest <= _MEETS

    @property
    def message(self) -> str:
        """Copies, faces, and how near neighbours came before they were welded, in a sentence or two."""
        words = (
            f"{plural_count(len(self.copies), 'copy', 'copies')} with {self.face_count} faces; before welding, "
            f"neighbours were up to {100 * self._widest:.2g} % of the size apart."
        )
        if self._widest > _MEETS:
            words += " Refine the mesh, or solve with the conditions of the sides."
        harmonic = self.surface.harmonic.status
        return words if harmonic is Status.CONVERGED else f"{self.surface.outcome} {words}"

    @property
    def _widest(self) -> float:
        return max((gap.relative for gap in self.gaps), default=0.0)

    @property
    def planes(self) -> list[SidePlane]:
        return self.arrangement.planes

    @property
    def offsets(self) -> list[Offset]:
        return self.arrangement.offsets

    @property
    def corners(self) -> list[Corner]:
        return self.arrangement.corners

    @property
    def face_count(self) -> int:
        return len(self.copies) * len(self.surface.faces)

    @property
    def vertex_count(self) -> int:
        """Number of vertices of the welded mesh."""
        return self._glued.vertex_count

    @property
    def members(self) -> NDArray[np.int64]:
        """(K, n) the vertex of the welded mesh that each cut vertex of each copy becomes."""
        return self._glued.members

    @property
    def is_whole(self) -> bool:
        return bool((self.neighbours >= 0).all())

    @property
    def sheets(self) -> list[str]:
        """The sheet that each copy shows, "f+" or "f-"."""
        return ["f+" if self._sign * copy.sheet > 0 else "f-" for copy in self.copies]

    def transforms(self, similarity: Similarity | None = None) -> Array:
        """(K, 4, 4), for the sheet that each copy shows; with a `similarity`, for the surface placed by it."""
        return np.array([(copy.placed(similarity) if similarity else copy).matrix for copy in self.copies])

    @cached_property
    def mesh(self) -> CompletedMesh:
        """The copies welded along their seams; raises `MeshError` where the piece is too coarse to be glued."""
        glued = self._glued
        check_glued(glued)
        pieces = {name: self.piece(name) for name in set(self.sheets)}
        points = np.array([copy.points(pieces[name]) for copy, name in self._shown])
        turns = np.array([self._sign * copy.sheet * copy.linear for copy in self.copies])
        normals = np.einsum("ni,kji->knj", self.surface.normals, turns)
        return welded(glued, points, normals, self.surface.source, self.gaps)

    def piece(self, sheet: str) -> Array:
        """Points (n, 3) of a sheet with its sides exactly in their planes, so that plain instances of it meet."""
        return snapped_to_planes(self.surface, sheet, self.planes)

    @property
    def _sign(self) -> int:
        return 1 if self.sheet == "f+" else -1

    @cached_property
    def _shown(self) -> list[tuple[Isometry, str]]:
        return list(zip(self.copies, self.sheets, strict=True))

    @cached_property
    def _glued(self) -> Glued:
        joins = [np.zeros((0, 4), dtype=np.int64)]
        for j, seam in enumerate(self.seams):
            k = np.flatnonzero(self.neighbours[:, j] >= 0)
            other = self.neighbours[k, j]
            count = len(seam.here)
            here = np.repeat(k, count), np.tile(seam.here, len(k))
            there = np.repeat(other, count), np.tile(seam.there, len(k))
            joins.append(np.column_stack([*here, *there]))
        flipped = [copy.flipped for copy in self.copies]
        return glue(self.surface.faces, len(self.surface.g), flipped, np.concatenate(joins))

    @cached_property
    def gaps(self) -> list[Gap]:
        """Gaps between neighbours before welding, as the surface was solved, each pair once."""
        size = surface_size(self.surface)
        gaps = []
        for j, seam in enumerate(self.seams):
            for k in np.flatnonzero(self.neighbours[:, j] >= 0):
                other = int(self.neighbours[k, j])
                if k <= other:
                    here, there = self._image(int(k), seam.here), self._image(other, seam.there)
                    apart = float(np.linalg.norm(here - there, axis=1).max())
                    gaps.append(Gap(seam.name, (int(k), other), apart, apart / size))
        return gaps

    def _image(self, k: int, cut_vertices: Int) -> Array:
        copy, name = self._shown[k]
        return copy.points(self.surface.sheet(name)[cut_vertices])
