"""The CMC surface whose rim lies on a given curve: the plan's outline, another closed curve, or some anchors.

Boundary normals are free, and so are the size and the place. Where the curve bounds a surface of constant mean
curvature at all, there is one for every rise from flat to about a half sphere; one number chooses among them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import Progress
from ..gauss.conditions import binormal
from ..gauss.frames import in_space
from ..linalg import check_number
from ..surface.solve import CmcSolver
from .fit import Fit, FitStatus, Start, fit
from .goals import Goals

Array = NDArray[np.float64]

# Evaluations for the straight way, and the part of the wished rise, height, volume or H of a flatter shell from which
# another is tried.
_STRAIGHT = 120
_FLATTER = 0.6
# Part of the radius of a circle with the plan's area beyond which the film that a fit starts from is not stretched.
_STEEPEST = 0.95


@dataclass(frozen=True)
class _Phase:
    """share: of the evaluations. smoother: how much more calm boundary normals count than in the end; rough ones early
    on lead to folded rims. strictness: of the height_parameter. gain: of a step that is worth another."""

    share: float
    smoother: float
    strictness: float
    gain: float


_PHASES = (_Phase(0.4, 3.0, 100.0, 1e-2), _Phase(0.6, 1.0, 1e4, 5e-4))
# A fit that goes on from another is smooth already; it first goes along with the height_parameter, in a quarter of the
# evaluations that it would take with a height_parameter that counts most at once.
_ON = (_Phase(0.7, 1.0, 10.0, 5e-3), _Phase(0.3, 1.0, 1e4, 1e-3))


def fit_outline(
    domain: Domain,
    positions: ArrayLike,
    curve: ArrayLike | Sequence[ArrayLike] | None = None,
    *,
    rise: float | None = None,
    height: float | None = None,
    volume: float | None = None,
    mean_curvature: float | None = None,
    free_heights: bool = False,
    anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    on_curve: bool = True,
    tilt: tuple[float, float] | None = None,
    smooth: float = 1e-7,
    sheet: str = "f+",
    max_evaluations: int = 300,
    initial: Fit | None = None,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
) -> Fit:
    """The surface over a plan whose rim lies on a closed curve (paper, Sec. 7: boundary control), heights upwards.

    positions: (V, 2|3) of the plan. curve: (m, 3) closed polyline, by default the plan's own boundary; on a plan with
    holes it is the outer one, or a list with one for each of `domain.boundary_loops`. Of rise, height, volume and
    mean_curvature at most one is given (`HEIGHT_PARAMETERS`); without any, the rise is 0.5. free_heights: only the
    outline seen from above counts. anchors: vertices (k,), places (k, 3) and weights (k,) of supports; with `on_curve`
    false they are all that counts. tilt: the least and the most tilt of the tangent planes along the rim, radians, 0 a
    vertical wall, ½ π flat. smooth: weight of ½ ∮ |dN₀|², which keeps the boundary normals from rattling. initial: an
    earlier fit of this plan to go on from.

    Around holes the surface shall close, too; as the plan has a conformal type of its own, its rims then come near to
    the curves but may not lie on them. A wish that no surface fulfils ends with the nearest one: `Fit.is_met` is false
    and the message says what to change. Raises `ConditionError` on wishes that contradict each other or make no sense.
    """
    points = in_space(domain, positions)
    check_number(smooth, "weight of calm boundary normals")
    check_number(max_evaluations, "largest number of evaluations", 1)
    height_parameters = {"rise": rise, "height": height, "volume": volume, "mean_curvature": mean_curvature}
    wishes = Goals.of(
        domain, points, curve, height_parameters,
        on_curve=on_curve, free_heights=free_heights, anchors=anchors, tilt=tilt,
    )
    objective = _Outline(solver or CmcSolver(domain), points, smooth, sheet, progress)
    if initial is None:
        found = objective.straight(wishes, min(max_evaluations, _STRAIGHT))
    else:
        found = objective.leg(wishes, _ON, _continued(initial, wishes.base), min(max_evaluations, _STRAIGHT))
    left = max_evaluations - len(found.history)
    if wishes.is_off(found) and found.status is not FitStatus.CANCELLED and left >= _STRAIGHT:
        found = objective.around(wishes, found, left)
    found = replace(found, shift=found.shift + [0.0, 0.0, wishes.base])
    return replace(found, unmet=wishes.unmet(found))


@dataclass(frozen=True, eq=False)
class _Outline:
    """Ways to a shell that is wished for, over the plan with these points (V, 3)."""

    solver: CmcSolver
    points: Array
    smooth: float
    sheet: str
    progress: Progress | None

    def straight(self, wishes: Goals, evaluations: int) -> Fit:
        """From the film."""
        return self.leg(wishes, _PHASES, _start(self.solver, self.points, wishes), evaluations)

    def around(self, wishes: Goals, found: Fit, evaluations: int) -> Fit:
        """By way of a flatter shell, where `found` is off the curve: steep ones with narrow corners are found so."""
        flat = self.straight(wishes.scaled(_FLATTER), min(_STRAIGHT, evaluations // 2))
        if flat.status is FitStatus.CANCELLED:
            return replace(found, status=flat.status, history=found.history + flat.history)
        other = self.leg(wishes, _ON, _continued(flat, 0.0), evaluations - len(flat.history))
        better = other if other.value < found.value else found
        return replace(better, status=other.status, history=found.history + flat.history + other.history)

    def leg(self, wishes: Goals, phases: Sequence[_Phase], start: Start, evaluations: int) -> Fit:
        total = sum(phase.share for phase in phases)
        history: list[float] = []
        for phase in phases:
            found = fit(
                self.solver.domain,
                wishes.targets(phase.smoother * self.smooth, phase.strictness),
                start,
                size=wishes.size,
                sheet=self.sheet,
                free_scale=wishes.height_parameter != "mean_curvature",
                max_evaluations=max(1, round(phase.share * evaluations / total)),
                gain=phase.gain,
                solver=self.solver,
                progress=self.progress,
            )
            history += found.history
            if found.status is FitStatus.CANCELLED:
                break
            start = _continued(found, 0.0)
        return replace(found, history=history)


def _start(solver: CmcSolver, points: Array, wishes: Goals) -> Start:
    """The soap film under even pressure, linearised: Δu = -2H over the plan, zero on the rim, scaled to the
    height_parameter.

    Where u has the slope 2 tan ½θ the shell's tangent plane leans by θ: exact over a circle.
    """
    domain = solver.domain
    dirichlet = solver.harmonic.dirichlet(domain.boundary_vertices.astype(np.int64))
    film = dirichlet.solve(domain.vertex_areas[:, None], np.zeros((len(domain.boundary_vertices), 1)))[:, 0]
    stretch = _stretch(domain, wishes)
    height = min(wishes.height_of(film * stretch**2, domain.vertex_areas * stretch**2), _STEEPEST * wishes.radius)
    slopes = _rim_slopes(domain, film) * height / (film.max() * stretch)
    conditions = binormal(domain, points, domain.boundary_edges, 0.5 * np.pi - 2.0 * np.arctan(0.5 * slopes))
    radius = 2.0 * film.max() * stretch**2 / height + 0.5 * height
    if wishes.height_parameter == "mean_curvature":
        radius = 1.0 / wishes.number
    centre = np.average(wishes.outer.points, axis=0, weights=wishes.outer.shares)
    # the rim of f+ = g + N lies above the mean of g's boundary by the mean of N
    up = np.cos(2.0 * np.arctan(0.5 * slopes)).mean()
    return Start(conditions, 0.5 * radius, centre - [0.0, 0.0, 0.5 * radius * up])


def _stretch(domain: Domain, wishes: Goals) -> float:
    """How much longer the outer curve is than the domain's own boundary there."""
    outer = next(k for k, (_, curve) in enumerate(wishes.loops) if curve is wishes.outer)
    return wishes.outer.length / float(domain.edge_lengths[domain.boundary_loop_edges[outer]].sum())


def _rim_slopes(domain: Domain, film: Array) -> Array:
    """(B,) |∇u| in the faces behind the boundary edges: u is zero along them, so it is u at the tip over its height."""
    behind = domain.half_edges[domain.boundary_edges, 0]
    height = 2.0 * domain.face_areas[behind // 3] / domain.edge_lengths[domain.boundary_edges]
    return film[domain.faces.ravel()[behind]] / height


def _continued(earlier: Fit, base: float) -> Start:
    shift = earlier.shift - [0.0, 0.0, base]
    N = earlier.surface.harmonic.normals
    return Start(earlier.conditions, earlier.surface.scale, shift, N, earlier.response)
