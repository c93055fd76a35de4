"""What is measured on a finished span, whatever its search says: is it the surface that was asked for?

Three numbers would not agree if it were not: D / area - 1 vanishes for conformal maps only; the multiplier H of D' =
2H V' and the H that balances the area, A' = 2H V', are the same for conformal maps only; and the angle at which a
leaning side meets its wall is seen in the normals alone. H is measured weakly, with the field w = L_II⁻¹ V' inside,

    H = ½ <A', w> / <V', w>,

which needs no normals and converges next to corners, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.frames import area_vectors
from ..linalg import sum_rows
from ..measure.arrays import face_areas_in_space
from ..measure.intersections import self_intersections
from ..notes import Note, Sentence
from .branch import Branch, branch
from .contact import LeanCheck, lean_check
from .descent import Descent
from .linearised import Linearised
from .verdict import CONFORMAL, distortion

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# H may be off by this part of itself, or of the mean curvature of the normals where that is more.
_OFF = 0.02
# A surface with less curvature than this, in units of one over its size, is flat.
_FLAT = 1e-3
# Less than this part is shown as 0.
_NOUGHT = 1e-4
# A lean may be off by this angle, radians.
_LEAN = np.radians(0.5)
# The rim of a leaning side may run back by this part of the size.
_BACK = 1e-3


@dataclass(frozen=True)
class Checks:
    """The measures of a span.

    distortion, drawn_distortion: the mean over the surface of ½ (Q + 1/Q) - 1, D / area - 1, against the plan as it was
    adapted and as it was drawn. multiplier: H of the search. mean_curvature: H that balances the area. curvature_unit:
    the root mean square of the normals' curvature, which errors of H are compared with where |H| is less. crossings:
    pairs of faces that intersect. leans: of each leaning side. runs_back: the furthest that the rim of one runs back
    along its line, or beyond its end, a length. branch: which surface of this H it is. notes: what is
    not as it should be, each with a code.
    """

    distortion: float
    drawn_distortion: float
    multiplier: float
    mean_curvature: float
    curvature_unit: float
    crossings: int
    leans: tuple[LeanCheck, ...]
    runs_back: float
    branch: Branch
    notes: tuple[Note, ...]

    @property
    def lines(self) -> list[str]:
        """The measures as sentences for a report."""
        measured, searched = self._shown(self.mean_curvature), self._shown(self.multiplier)
        return [
            f"Mean curvature {measured} by the balance of the area, {searched} in the search.",
            f"The map from the plan stretches by {_stretch(self.distortion)} in the mean, from the plan as drawn by "
            f"{_stretch(self.drawn_distortion)}.",
            *([_BRANCHES[self.branch]] if searched != "0" or self.branch is Branch.SADDLE else []),
            *(lean.sentence for lean in self.leans),
        ]

    @property
    def curvature_scale(self) -> float:
        """What an error of H is compared with: |H|, or the curvature of the normals where that is more."""
        return max(abs(self.multiplier), self.curvature_unit)

    def _shown(self, H: float) -> str:
        return f"{H:.4g}" if abs(H) > _NOUGHT * self.curvature_scale else "0"


_BRANCHES = {
    Branch.FLATTER: "Of the surfaces of this mean curvature through these lines it is the flatter one.",
    Branch.FULLER: "Of the surfaces of this mean curvature through these lines it is the fuller one.",
    Branch.SADDLE: "Several surfaces of this mean curvature span these lines, and this one is a saddle: small changes "
    "lower its energy.",
}


def checks_of(
    descent: Descent,
    points: Array,
    normals: Array,
    domain: Domain,
    drawn: Domain,
    leans: Sequence[tuple[Int, float]],
    base: float,
    by_curvature: bool,
    notes: Sequence[Note] = (),
) -> Checks:
    """The checks of a span with these points and normals (V, 3) over its domain.

    drawn: the plan as drawn. leans: edges and angle of each side; base: the height that theirs are counted from.
    by_curvature: whether H was asked for. notes: to begin with.
    """
    here = Linearised(descent.problem, descent.state, None)
    area = float(face_areas_in_space(points, domain.faces).sum())
    measured = Checks(
        distortion=distortion(dirichlet_energy(domain, points), points, domain.faces),
        drawn_distortion=distortion(dirichlet_energy(drawn, points), points, domain.faces),
        multiplier=here.H,
        mean_curvature=balanced_curvature(here),
        curvature_unit=max(
            float(np.sqrt(dirichlet_energy(domain, normals) / area)), _FLAT / float(np.ptp(points, axis=0).max())
        ),
        crossings=len(self_intersections(points, domain.faces)),
        leans=tuple(lean_check(domain, points, normals, edges, angle, base) for edges, angle in leans),
        runs_back=descent.problem.rim.runs_back(descent.state.x),
        branch=branch(here),
        notes=(),
    )
    kept = len(domain.boundary_loops) > 1 and not descent.problem.moving_holes
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    found = [*notes, *_curvature(measured, kept), *_shape(measured, by_curvature), *_sides(measured, size)]
    return Checks(**{**vars(measured), "notes": tuple(found)})


def _curvature(measured: Checks, kept: bool) -> list[Note]:
    off = abs(measured.mean_curvature - measured.multiplier)
    numbers = [measured._shown(H) for H in (measured.mean_curvature, measured.multiplier)]
    wrong = "mean curvature measures {} instead of {}".format(*numbers)
    if kept and measured.distortion > CONFORMAL:
        text = f"The plan's holes were kept, which costs evenness: the map stretches by {_stretch(measured.distortion)}"
        return [Note("distorted", f"{text} in the mean, and {wrong}; let the holes move.")]
    if off > _OFF * measured.curvature_scale:
        return [Note("unbalanced", f"The {wrong}: refine the mesh, or round narrow corners.")]
    return []


def _shape(measured: Checks, by_curvature: bool) -> list[Note]:
    notes = []
    if measured.crossings:
        pairs = "one pair" if measured.crossings == 1 else f"{measured.crossings} pairs"
        notes.append(Note("crossing", f"The surface goes through itself, at {pairs} of faces; choose a flatter one."))
    if measured.branch is Branch.SADDLE:
        notes.append(Note("several", f"{_BRANCHES[Branch.SADDLE]} Lines that are less bent have one surface."))
    elif measured.branch is Branch.FULLER and by_curvature:
        notes.append(Note("several", f"{_BRANCHES[Branch.FULLER]} Leave out the surface to start from for the other."))
    return notes


def _sides(measured: Checks, size: float) -> list[Note]:
    notes = [
        Note("lean-missed", f"{lean.sentence} Refine the mesh, or bring the angle nearer to 90°.")
        for lean in measured.leans
        if not lean.off <= _LEAN
    ]
    if measured.runs_back > _BACK * size:
        text = Sentence(
            "At an end of a side that leans the rim runs {} back or past the end: next to a line its angle is too far "
            "from 90° for a surface that stays over the side. Bring it nearer to 90°, or let the neighbour lean, too.",
            measured.runs_back,
        )
        notes.append(Note("runs-back", text))
    return notes


def dirichlet_energy(domain: Domain, f: Array) -> float:
    """½ <f, L f> of points f (V, 3)."""
    i, j = domain.edges.T
    return 0.5 * float(domain.cotan_weights @ np.sum((f[j] - f[i]) ** 2, axis=1))


def _stretch(energy: float) -> str:
    """The distortion Q - 1 that belongs to ½ (Q + 1/Q) - 1, as a percentage."""
    return f"{100.0 * (energy + np.sqrt(energy * (energy + 2.0))):.1f} %" if energy > 0.0 else "0 %"


def balanced_curvature(here: Linearised) -> float:
    """½ <A', w> / <V', w>, w = L_II⁻¹ V' inside, of a surface that need not be conformal."""
    f, problem = here.state.f, here.problem
    w = here.volume.lifted
    slope = area_gradient(f, problem.domain.faces)[problem.coordinates.inside]
    return 0.5 * float(np.sum(slope * w) / np.sum(here.volume.u * w))


def area_gradient(f: Array, faces: Int) -> Array:
    """A' (V, 3): at each corner of a face ½ n × the side opposite it, n its unit normal; 0 where it has no area."""
    n = area_vectors(f, faces)
    n = n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300)
    corners = f[faces]
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    return sum_rows(faces.ravel(), 0.5 * np.cross(n[:, None], opposite).reshape(-1, 3), len(f))
