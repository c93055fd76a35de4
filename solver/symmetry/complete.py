"""Completion by symmetry: which copies of a surface there are across its sides, and which of them are neighbours.

Copy C shows the surface under an isometry of space; across its side j lies the copy C · (isometry of j), however the
two were generated (paper, Sec. 5.3.2 and Appendix G; see `sides` for the rule). Copies are generated breadth-first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import shown
from ..limits import POSITIVE, Range, check_number
from ..linalg import as_numbers
from ..signatures import checked
from ..surface.cmc_surface import CmcSurface, SurfaceLike, as_surface
from ..surface.placement import Similarity
from .arrangement import arrange
from .completion import Completion
from .isometries import CopySet, Isometry, cell, generate, translation
from .own_symmetry import translation_seams
from .seams import Seam, cut_seams, side_seams
from .sides import Side, SymmetryError, surface_size
from .unit_cell import compact

Array = NDArray[np.float64]

# The most copies that are made.
MOST_COPIES = 20_000
COPIES = Range(1, MOST_COPIES, whole=True)
# The most directions of a group that is searched for a unit cell: the largest point group of a lattice has 48, each
# with two sheets.
_MOST_DIRECTIONS = 512
# A tolerance is at most this part of the distance between two parallel planes, half the translation that they make.
_NARROW = 0.2


class TooManyError(SymmetryError):
    """More copies than allowed."""


@checked
def complete(
    surface: SurfaceLike,
    sides: Sequence[Side] = (),
    *,
    copies: int | None = None,
    box: ArrayLike | None = None,
    frame: Similarity | None = None,
    around: Sequence[Sequence[str]] = (),
    translations: ArrayLike | None = None,
    repeat: int | Sequence[int] = 1,
    sheet: str = "f+",
    coplanar: Sequence[Sequence[str]] = (),
    tolerance: float = 1e-2,
) -> Completion:
    """A surface and its copies across `sides`, across the copies' sides, and so on (paper, Theorem G.1).

    By default these are all copies if the group is finite, else one unit cell of its translations.
    copies: the number of copies, the nearest by adjacency.
    box: (2, 3) corners of a box; copies whose centre is in it, in the surface's units, or where `frame` places them.
    around: the orbit under the finite group of the first named sides, of that under the group of the next ones, …; for
        example everything around one corner, [("left", "bottom")].
    translations: (k, 3) vectors by which the copies repeat, `repeat` times each; by default the group's own.
    sheet: "f+" or "f-", that of the first copy; across tangent and free sides the surface continues as the other one.
    coplanar: names of sides that lie in one plane. Parallel planes within half a percent of the surface's size count as
        one in any case; their measured distance is in `offsets`. Others give a translation.
    tolerance: copies whose translations differ by less, as a part of the surface's size, are the same; it is lowered
        where two parallel planes are close to each other.
    A surface that is cut open also continues across its cuts. Where the surface has a symmetry of its own, so that its
    mirrors meet at obtuse angles, it continues by translations instead (see `own_symmetry`).

    Raises `SymmetryError` on sides that contradict each other or have the wrong kind, and on groups without end.
    """
    surface = as_surface(surface)
    if sheet not in ("f+", "f-"):
        raise SymmetryError(f'Sheet "{sheet}" has no copies; choose f+ or f-.')
    if box is not None and len(around):
        raise SymmetryError("Copies in a box and around corners exclude each other; choose one of them.")
    if tolerance not in POSITIVE:
        raise SymmetryError(f"The tolerance must be a positive part of the surface's size, not {shown(tolerance)}.")
    if isinstance(sides, Side):
        raise SymmetryError("The sides are a list; put the one side into a list.")
    arrangement = arrange(surface, sides, coplanar)
    seams = side_seams(arrangement.planes) + cut_seams(surface)
    if not seams and translations is None:
        raise SymmetryError("The surface has no sides to continue across; name some, or give translations.")
    within = min(tolerance * surface_size(surface), _NARROW * arrangement.narrowest)
    seams = translation_seams(surface, arrangement.planes, within) or seams
    limit = _limit(copies)
    steps = [seam.step for seam in seams]
    own = np.zeros((0, 3))
    if box is not None:
        made = _in_box(surface, sheet, steps, box, frame or Similarity(), within, limit)
    elif len(around):
        made = _around(seams, around, within, limit)
    elif copies is not None:
        made = generate(steps, within, lambda copy: True, limit)[0]
    else:
        made, own = cell(steps, within, _MOST_DIRECTIONS)
        made = compact(made, own, _seam_sizes(surface, seams), _middles(surface, sheet), arrangement.planes, within)
    vectors = own if translations is None else _vectors(translations)
    made = _repeated(made, vectors, repeat, within, limit)
    _check_extent(surface, sheet, made)
    return Completion(surface, sheet, made, seams, _neighbours(made, steps, within), own, arrangement)


def _check_extent(surface: CmcSurface, sheet: str, made: Sequence[Isometry]) -> None:
    other = "f-" if sheet == "f+" else "f+"
    for name, needed in ((sheet, True), (other, any(copy.sheet < 0 for copy in made))):
        if needed and surface.is_degenerate(name):
            raise SymmetryError(
                f"Sheet {name} of this surface is a point; choose the other one, and sides across which it stays."
            )


def _limit(copies: int | None) -> int:
    if copies is None:
        return MOST_COPIES
    check_number(copies, "number of copies", COPIES, SymmetryError)
    return int(copies)


def _vectors(translations: ArrayLike) -> Array:
    vectors = np.atleast_2d(as_numbers(translations, "Translations", SymmetryError))
    good = vectors.ndim == 2 and vectors.shape[1] == 3 and bool(np.isfinite(vectors).all())
    if not good or (np.linalg.norm(vectors, axis=1) == 0.0).any():
        raise SymmetryError("Translations must be finite vectors (k, 3), none of them zero.")
    return vectors


def _in_box(
    surface: CmcSurface,
    sheet: str,
    steps: Sequence[Isometry],
    corners: ArrayLike,
    frame: Similarity,
    tolerance: float,
    limit: int,
) -> list[Isometry]:
    """Copies whose centre is in the box; paths to them may lead through copies one piece beyond."""
    box = as_numbers(corners, "The corners of a box", SymmetryError)
    if box.shape != (2, 3) or not (box[0] < box[1]).all():
        raise SymmetryError("A box is given by its lowest and its highest corner, (2, 3), the one below the other.")
    middles = _middles(surface, sheet)
    beyond = frame.scale * surface_size(surface)

    def inside(copy: Isometry, margin: float) -> bool:
        centre = frame.points(copy.points(middles[copy.sheet]))
        return bool((centre >= box[0] - margin).all() and (centre <= box[1] + margin).all())

    reached, all_of_them = generate(steps, tolerance, lambda copy: inside(copy, beyond), limit)
    made = [copy for copy in reached if inside(copy, 0.0)]
    if not made:
        raise SymmetryError("No copy has its centre in the box; move the box to the surface, or make it larger.")
    if not all_of_them:
        raise TooManyError(f"There are more than {limit} copies in the box; make it smaller.")
    return made


def _middles(surface: CmcSurface, sheet: str) -> dict[int, Array]:
    """Centres of the sheet that copies with sheet 1 show, and of the other one."""
    other = "f-" if sheet == "f+" else "f+"
    return {1: surface.sheet(sheet).mean(axis=0), -1: surface.sheet(other).mean(axis=0)}


def _seam_sizes(surface: CmcSurface, seams: Sequence[Seam]) -> list[tuple[Isometry, float]]:
    """The step across each seam, and the size of the seam."""
    return [(seam.step, float(np.linalg.norm(np.ptp(surface.f_plus[seam.here], axis=0)))) for seam in seams]


def _around(seams: Sequence[Seam], groups: Sequence[Sequence[str]], tolerance: float, limit: int) -> list[Isometry]:
    """The orbit of the piece under the group of the first names, of that orbit under the group of the next, …"""
    steps = {seam.name: seam.step for seam in seams}
    made = [translation(np.zeros(3))]
    if any(isinstance(names, str) for names in groups):
        raise SymmetryError("Give the sides to go around as lists of names, one list for each group.")
    for names in groups:
        unknown = [name for name in names if name not in steps]
        if unknown:
            raise SymmetryError(f"There is no side {', '.join(map(repr, unknown))}; known are {', '.join(steps)}.")
        group, finite = generate([steps[name] for name in names], tolerance, lambda copy: True, _MOST_DIRECTIONS)
        if not finite:
            raise SymmetryError(
                f"The copies around {', '.join(map(repr, names))} have no end, since these sides are parallel or at an "
                "odd angle; leave one out, or give the number of copies."
            )
        made = _distinct(made, [lambda copy, g=g: g.then(copy) for g in group], tolerance, limit)
    return made


def _repeated(
    made: list[Isometry], vectors: Array, repeat: int | Sequence[int], tolerance: float, limit: int
) -> list[Isometry]:
    times = [repeat] * len(vectors) if isinstance(repeat, (int, np.integer)) else list(repeat)
    if isinstance(repeat, (int, np.integer)) and repeat != 1 and not len(vectors):
        raise SymmetryError("There is no translation to repeat the copies by; give one, or a number of copies.")
    if len(times) != len(vectors) or any(not isinstance(n, (int, np.integer)) or n < 1 for n in times):
        raise SymmetryError(f"There are {len(vectors)} translations, to be repeated once or more each, not {repeat!r}.")
    if not times or max(times) == 1:
        return made
    shifts = [np.asarray(at) @ vectors for at in np.ndindex(*times)]
    return _distinct(made, [lambda copy, v=v: translation(v).then(copy) for v in shifts], tolerance, limit)


def _distinct(
    made: Sequence[Isometry], images: Sequence[Callable[[Isometry], Isometry]], tolerance: float, limit: int
) -> list[Isometry]:
    known = CopySet(tolerance)
    for image in images:
        for copy in made:
            moved = image(copy)
            if known.index(moved) < 0:
                if len(known.copies) == limit:
                    raise SymmetryError(f"There would be more than {limit} copies; give a smaller number.")
                known.add(moved)
    return known.copies


def _neighbours(made: Sequence[Isometry], steps: Sequence[Isometry], tolerance: float) -> NDArray[np.int64]:
    known = CopySet(tolerance)
    for copy in made:
        known.add(copy)
    across = [[known.index(copy.then(step)) for step in steps] for copy in made]
    return np.array(across, dtype=np.int64).reshape(len(made), len(steps))
