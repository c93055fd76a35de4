"""The CMC surface whose rim lies on a given curve: the plan's outline, another closed curve, or some anchors.

The boundary normals, the size and the place are free. Where the curve bounds a surface of constant mean curvature at
all, it bounds one for every rise from flat to about a half sphere; one number chooses among them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..gauss.conditions import binormal
from ..gauss.frames import in_space
from ..gauss.options import with_options
from ..surface.solve import CmcSolver
from .fit import Fit, FitStatus, Start, fit
from .goals import Goals, OutlineOptions
from .hole_size import fitting_hole

Array = NDArray[np.float64]

# Evaluations for the straight way, and the part of the wanted rise, height, volume or H of the flatter shell on the way
# around.
_STRAIGHT = 120
_FLATTER = 0.6
# Evaluations of each fit over a coarse mesh that finds the way out for a message.
_ADVICE = 40
# Part of the radius of a circle with the plan's area beyond which the film that a fit starts from is not stretched.
_STEEPEST = 0.95


@dataclass(frozen=True)
class _Phase:
    """share: of the evaluations. smoother: a factor of the weight of smooth boundary normals; rough ones early on lead
    to folded rims. strictness: of the height parameter. gain: of a step that is worth another."""

    share: float
    smoother: float
    strictness: float
    gain: float


_PHASES = (_Phase(0.4, 3.0, 100.0, 1e-2), _Phase(0.6, 1.0, 1e4, 5e-4))
# A fit that continues another is smooth already. With a weak height parameter first it takes a quarter of the
# evaluations that it takes with a strong one at once.
_CONTINUED = (_Phase(0.7, 1.0, 10.0, 5e-3), _Phase(0.3, 1.0, 1e4, 1e-3))


@with_options(OutlineOptions)
def fit_outline(domain: DomainLike, positions: ArrayLike, options: OutlineOptions) -> Fit:
    """The CMC surface over a plan whose rim lies on a closed curve (paper, Sec. 7: boundary control), heights upwards.

    positions: (V, 2|3) of the plan. curve: (m, 3) closed polyline, by default the plan's own boundary; on a plan with
    holes the outer one, or a list with one for each of `domain.boundary_loops`. At most one of rise, height, volume and
    mean_curvature is given (`HEIGHT_PARAMETERS`); by default the rise is ½. free_heights: only the outline seen from
    above counts. anchors: vertices (k,), places (k, 3) and weights (k,) of supports; with on_curve=False only they
    count. tilt: least and greatest tilt of the tangent planes along the rim, radians, 0 a vertical wall, ½ π flat.
    smooth: weight of ½ ∮ |dN₀|², which keeps the boundary normals smooth. initial: an earlier fit of this plan to
    continue. progress(evaluation, value) is called at every step; False cancels.

    Around holes the surface must close, too; since the plan fixes the conformal type, its rims then come near the
    curves but may not lie on them. Goals that no surface meets end with the nearest one: `Fit.is_met` is false and the
    message names the way out. Raises `ConditionError` on goals that contradict each other or have no meaning.
    """
    domain = as_domain(domain)
    points = in_space(domain, positions)
    goals = Goals.of(domain, points, options)
    search = _Search(options.solver or CmcSolver(domain), points, options)
    evaluations = min(options.max_evaluations, _STRAIGHT)
    if options.initial is None:
        result = search.straight(goals, evaluations)
    else:
        result = search.leg(goals, _CONTINUED, _continued(options.initial, goals.base), evaluations)
    left = options.max_evaluations - len(result.history)
    if goals.is_off(result) and result.status is not FitStatus.CANCELLED and left >= _STRAIGHT:
        result = search.around(goals, result, left)
    # the advice takes several fits, and a fit that has hardly begun may still reach its curves
    is_last = result.status is FitStatus.CONVERGED or options.max_evaluations > _STRAIGHT
    is_off = is_last and goals.is_off(result) and result.status is not FitStatus.CANCELLED
    advice = _hole_advice(goals, points, options) if is_off else None
    result = replace(result, shift=result.shift + [0.0, 0.0, goals.base])
    return replace(result, unmet=goals.unmet(result, advice))


def _hole_advice(goals: Goals, points: Array, options: OutlineOptions) -> str | None:
    """The size of the hole that would do, where the plan is a ring."""
    if len(goals.loops) != 2 or goals.supports is not None:
        return None
    order = sorted(goals.loops, key=lambda pair: pair[1] is not goals.outer)

    def fit_over(domain: Domain, positions: Array, curves: list[Array]) -> Fit:
        solver = CmcSolver(domain)
        coarse = replace(options, curve=curves, initial=None, solver=solver)
        flat = in_space(domain, positions)
        return _Search(solver, flat, coarse).straight(Goals.of(domain, flat, coarse), _ADVICE)

    found = fitting_hole([points[loop] for loop, _ in order], [c.points for _, c in order], goals.size, fit_over)
    return None if found is None else found.sentence


@dataclass(frozen=True, eq=False)
class _Search:
    """Ways to the fitted shell over the plan with these points (V, 3)."""

    solver: CmcSolver
    points: Array
    options: OutlineOptions

    def straight(self, goals: Goals, evaluations: int) -> Fit:
        """From the film."""
        return self.leg(goals, _PHASES, _start(self.solver, self.points, goals), evaluations)

    def around(self, goals: Goals, off: Fit, evaluations: int) -> Fit:
        """By way of a flatter shell, where a fit is off the curve: it reaches steep shells with narrow corners."""
        flat = self.straight(goals.scaled(_FLATTER), min(_STRAIGHT, evaluations // 2))
        if flat.status is FitStatus.CANCELLED:
            return replace(off, status=flat.status, history=off.history + flat.history)
        other = self.leg(goals, _CONTINUED, _continued(flat, 0.0), evaluations - len(flat.history))
        better = other if other.value < off.value else off
        return replace(better, status=other.status, history=off.history + flat.history + other.history)

    def leg(self, goals: Goals, phases: Sequence[_Phase], start: Start, evaluations: int) -> Fit:
        total = sum(phase.share for phase in phases)
        history: list[float] = []
        for phase in phases:
            result = fit(
                self.solver.domain,
                goals.targets(phase.smoother * self.options.smooth, phase.strictness),
                start,
                size=goals.size,
                sheet=self.options.sheet,
                free_scale=goals.height_parameter != "mean_curvature",
                max_evaluations=max(1, round(phase.share * evaluations / total)),
                gain=phase.gain,
                solver=self.solver,
                progress=self.options.progress,
            )
            history += result.history
            if result.status is FitStatus.CANCELLED:
                break
            start = _continued(result, 0.0)
        return replace(result, history=history)


def _start(solver: CmcSolver, points: Array, goals: Goals) -> Start:
    """The linearised soap film under even pressure, Δu = -2H, u = 0 on the rim, scaled to the height parameter.

    Where u has the slope 2 tan ½θ the shell's tangent plane leans by θ: exact over a circle.
    """
    domain = solver.domain
    dirichlet = solver.harmonic.dirichlet(domain.boundary_vertices.astype(np.int64))
    film = dirichlet.solve(domain.vertex_areas[:, None], np.zeros((len(domain.boundary_vertices), 1)))[:, 0]
    stretch = _stretch(domain, goals)
    height = min(goals.height_of(film * stretch**2, domain.vertex_areas * stretch**2), _STEEPEST * goals.radius)
    slopes = _rim_slopes(domain, film) * height / (film.max() * stretch)
    conditions = binormal(domain, points, domain.boundary_edges, 0.5 * np.pi - 2.0 * np.arctan(0.5 * slopes))
    radius = 2.0 * film.max() * stretch**2 / height + 0.5 * height
    if goals.height_parameter == "mean_curvature":
        radius = 1.0 / goals.number
    centre = np.average(goals.outer.points, axis=0, weights=goals.outer.shares)
    # the rim of f+ = g + N lies above the mean of g's boundary by the mean of N
    up = np.cos(2.0 * np.arctan(0.5 * slopes)).mean()
    return Start(conditions, 0.5 * radius, centre - [0.0, 0.0, 0.5 * radius * up])


def _stretch(domain: Domain, goals: Goals) -> float:
    """How much longer the outer curve is than the domain's own boundary there."""
    outer = next(k for k, (_, curve) in enumerate(goals.loops) if curve is goals.outer)
    return goals.outer.length / float(domain.edge_lengths[domain.boundary_loop_edges[outer]].sum())


def _rim_slopes(domain: Domain, film: Array) -> Array:
    """(B,) |∇u| in the faces behind the boundary edges: u is zero along them, so it is u at the tip over its height."""
    behind = domain.half_edges[domain.boundary_edges, 0]
    height = 2.0 * domain.face_areas[behind // 3] / domain.edge_lengths[domain.boundary_edges]
    return film[domain.faces.ravel()[behind]] / height


def _continued(earlier: Fit, base: float) -> Start:
    shift = earlier.shift - [0.0, 0.0, base]
    N = earlier.surface.harmonic.normals
    return Start(earlier.conditions, earlier.surface.scale, shift, N, earlier.response)
