"""A shell completed by its symmetries: placed copies, as instances or as one welded mesh."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import JobError
from ..measure.summary import NOISE, percent
from ..notes import Sentence
from ..symmetry.complete import MOST_COPIES, complete
from ..symmetry.completion import Completion
from ..symmetry.sides import surface_size
from .measured import placed_normals
from .plan import Plan
from .plan_sides import plan_sides
from .shell import Shell, sheet_polygons

Array = NDArray[np.float64]
Int = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CopySelection:
    """The copies of a shell to make; by default all, or one unit cell where they have no end.

    sides: names of the groups across which the shell continues; None: by group (`plan_sides.goes_on`). copies: how
    many, the nearest first. box: (2, 3), world units: the copies with their centre in it. around: names of groups, see
    `complete`. repeat: number of unit cells, or of the copies around, along each translation; further ones of a list
    are ignored.
    """

    sides: Sequence[str] | None = None
    copies: int | None = None
    box: Array | None = None
    around: Sequence[Sequence[str]] = ()
    repeat: int | Sequence[int] = 1


@dataclass(frozen=True, eq=False, repr=False)
class Completed:
    """A shell and its copies, in world units; `completion` has the isometries."""

    shell: Shell
    completion: Completion

    @property
    def ok(self) -> bool:
        """Whether the shell is; the copies are exact isometries of it."""
        return self.shell.ok

    @property
    def message(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return f"Completed({self.summary().removesuffix('.')})"

    @property
    def copy_count(self) -> int:
        return len(self.completion.copies)

    @property
    def face_count(self) -> int:
        """Triangles of all copies."""
        return self.completion.face_count

    @property
    def sheets(self) -> list[str]:
        """The sheet that each copy shows."""
        return self.completion.sheets

    @cached_property
    def transforms(self) -> Array:
        """(K, 4, 4) from the placed sheet of each copy to the copy; reflections have a determinant < 0."""
        return self.completion.transforms(self.shell.similarity)

    @property
    def lattice(self) -> Array:
        """(k, 3) translations of the completed shell onto itself."""
        similarity = self.shell.similarity
        return similarity.scale * similarity.directions(self.completion.lattice)

    def piece(self, sheet: str) -> Array:
        """Points (n, 3) of a placed sheet whose sides lie exactly in their planes, so that instances meet."""
        return self.shell.similarity.points(self.completion.piece(sheet))

    @cached_property
    def points(self) -> Array:
        """(n, 3) of the welded mesh."""
        return self.shell.similarity.points(self.completion.mesh.vertices)

    @cached_property
    def normals(self) -> Array:
        """(n, 3) of the welded mesh, on the side from which its faces are counter-clockwise."""
        return placed_normals(self.completion.mesh.normals, "f+", self.shell.similarity)

    @property
    def source(self) -> NDArray[np.int32]:
        """(n,) the plan's vertex behind each vertex of the welded mesh."""
        return self.completion.mesh.source

    @property
    def largest_gap(self) -> float:
        """The largest distance between neighbours before their seams were closed, in world units."""
        return self.shell.similarity.scale * max((gap.largest for gap in self.completion.gaps), default=0.0)

    @property
    def relative_gap(self) -> float:
        """The same as a part of the shell's size."""
        return max((gap.relative for gap in self.completion.gaps), default=0.0)

    @property
    def largest_offset(self) -> float:
        """The largest distance between sides of one plane, in world units."""
        apart = [offset.distance for offset in self.completion.offsets]
        return self.shell.similarity.scale * max(apart, default=0.0)

    @property
    def relative_offset(self) -> float:
        """The same as a part of the shell's size."""
        return self.largest_offset / (self.shell.similarity.scale * surface_size(self.shell.surface))

    def polygons(self, plan: Plan, *, triangles: bool = False) -> Polygons:
        """The faces of the welded mesh as the plan was drawn, or its triangles."""
        assert plan.polygons is not None and plan.triangle_polygons is not None
        pieces, owner = list(self.shell.faces), plan.triangle_polygons
        if not triangles:
            pieces, owner = sheet_polygons(plan.polygons, plan.triangle_polygons, plan.triangles, self.shell.faces)
        return Polygons.of(self.completion, pieces, np.asarray(owner))

    def summary(self) -> str:
        """Copies, faces and the gap in a sentence."""
        count, relative = self.copy_count, self.relative_gap
        copies = f"{count} {'copy' if count == 1 else 'copies'}, {self.face_count} triangles"
        if relative < NOISE:
            return f"{copies}; the seams meet."
        text = f"{copies}; seams were up to {{}} apart ({percent(relative)} of the shell's size)."
        return Sentence(text, self.largest_gap)


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces of a welded mesh, vertices `corners` (C,) from `starts` (P + 1,), and where each comes from.

    cut_vertices (C,): the surface's vertex at each corner. faces (P,): the plan's polygon. copies (P,): the copy.
    """

    corners: Int
    starts: Int
    cut_vertices: Int
    faces: Int
    copies: Int

    @classmethod
    def of(cls, completion: Completion, pieces: Sequence[NDArray[np.integer]], owner: NDArray[np.integer]) -> Polygons:
        """From polygons `pieces` of the surface's vertices, and the plan's polygon (P,) of each."""
        sizes = np.array([len(piece) for piece in pieces])
        forth = np.concatenate(list(pieces)).astype(np.int64)
        ends = np.cumsum(sizes)
        back = forth[np.repeat(ends + ends - sizes - 1, sizes) - np.arange(len(forth))]
        turned = [copy.flipped for copy in completion.copies]
        cut_vertices = np.concatenate([back if flipped else forth for flipped in turned])
        count = len(turned)
        members = completion.members[np.repeat(np.arange(count), len(forth)), cut_vertices]
        starts = np.concatenate([[0], np.cumsum(np.tile(sizes, count))])
        faces = np.tile(np.asarray(owner, dtype=np.int64), count)
        return cls(members, starts, cut_vertices, faces, np.repeat(np.arange(count), len(sizes)))

    def lists(self) -> list[NDArray[np.int32]]:
        """Each polygon's vertices."""
        return np.split(self.corners.astype(np.int32), self.starts[1:-1])


def complete_plan(plan: Plan, shell: Shell, selection: CopySelection, sheet: str = "f+") -> Completed:
    """The copies of a placed shell across groups of its plan.

    Counts and transforms are cheap; the welded mesh is made on first use. Raises `JobError` on an unknown group,
    `SymmetryError` where the planes contradict each other or the copies have no end.
    """
    surface = shell.surface
    sides = plan_sides(plan, surface.domain, selection.sides)
    choice = {"copies": selection.copies, "box": selection.box, "around": selection.around, "frame": shell.similarity}
    completion = complete(surface, sides, sheet=sheet, **choice)
    if selection.repeat != 1:
        known = len(completion.lattice)
        times = [selection.repeat] * known if isinstance(selection.repeat, int) else list(selection.repeat)[:known]
        if len(times) < known:
            raise JobError(f"The copies repeat in {known} directions; give a number for each of them.")
        if len(completion.copies) * math.prod(times) > MOST_COPIES:
            count = len(completion.copies) * math.prod(times)
            raise JobError(f"That makes {count} copies, and {MOST_COPIES} are the most; repeat them less often.")
        if max(times, default=1) > 1:
            completion = complete(surface, sides, sheet=sheet, repeat=times, **choice)
    return Completed(shell, completion)
