"""The CMC surface whose rim lies on a given curve: the plan's outline, another closed curve, or some anchors; or whose
rim lies on lines along some sides, and whose normals are given along others.

Where the curve bounds a surface of constant mean curvature at all, it bounds one for every rise from flat to about a
half sphere; one number chooses among them. Lines alone are spanned. Where more is asked for, the boundary normals, the
size and the place are searched from there.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError
from ..gauss.frames import in_space
from ..gauss.options import with_options
from ..spanning.lines import boundary_lines
from ..spanning.outline import span_on_plan, span_outline
from ..spanning.span import Span
from ..spanning.verdict import SpanStatus
from ..surface.solve import CmcSolver
from .fit import Fit, Start, fit
from .goals import Goals, OutlineOptions
from .sides import LEAN, MIRROR
from .spanned import spanned_fit, start_from

Array = NDArray[np.float64]

# Factor of the height parameter's weight, and the gain of a step that is worth another: beside given normals the way
# to the lines is longer.
_STRICTNESS = 1e4
_GAIN, _GAIN_BESIDE = 1e-3, 2e-4
# Mean curvature times size of the flattest start.
_FLATTEST = 1e-2
# Steps of a span that is only a start.
_NEAR_ENOUGH = 20


@with_options(OutlineOptions)
def fit_outline(domain: DomainLike, positions: ArrayLike, options: OutlineOptions) -> Fit:
    """The CMC surface over a plan whose rim lies on a closed curve (paper, Sec. 7: boundary control), heights upwards.

    positions: (V, 2|3) of the plan. curve: (m, 3) closed polyline, by default the plan's own boundary; on a plan with
    holes the outer one, or a list with one for each of `domain.boundary_loops`. At most one of rise, height, volume and
    mean_curvature is given (`HEIGHT_PARAMETERS`); by default the rise is ½. initial: an earlier fit of this plan to
    continue. progress(evaluation, value) is called at every step; False cancels.

    Where that is all, `span_outline` finds the surface, with its rim on the lines: at most sixty steps, holes and sharp
    corners by moduli of the plan, mean_curvature of either sign or 0; see `Fit.span`. free_heights: only the outline
    seen from above counts, and the rim is level. Other goals that this surface does not meet start a search from there,
    over the plan that was found. anchors: vertices (k,), places (k, 3) and weights (k,) of supports; with
    on_curve=False only they count. tilt: least and greatest tilt of the tangent planes along the rim, radians, 0 a
    vertical wall, ½ π flat. smooth: weight of ½ ∮ |dN₀|², for quieter boundary normals. max_evaluations: of the search.

    Sides may be other than lines. held: `conditions` with normals of the sheet along some sides, mirrors, sides that
    lean over their line, and lines or curves; edges in none of them are on their lines, but for those in `free`, which
    have nothing. Lines, leans and mirrors alone are spanned. Given normals are no unknowns of the search (the gradient
    by the others is that of the paper, App. F), so they are kept to rounding, and the rim there is where they lead it:
    not over its line. Next to a line they end at a blend zone of length `blend` by the outline's size, at most a third
    of their side, whose normals are free: near a junction of both the surface would go as the fourth root of the
    distance. `Fit.sides` has what each side misses.

    Goals that no surface meets end with the nearest one: `Fit.is_met` is false and the message names the way out.
    Raises `ConditionError` on goals that contradict each other or have no meaning, as a crown below its own rim.
    """
    points = in_space(as_domain(domain), positions)
    goals = Goals.of(domain, points, options)
    domain = as_domain(domain)
    earlier = options.initial
    if earlier is not None and earlier.surface.domain.vertex_count != domain.vertex_count:
        raise ConditionError("The earlier fit is one of another plan; leave out `initial`.")
    if earlier is not None and earlier.span is None and not options.has_lines_only:
        return _searched(goals, earlier.surface.domain, _continued(earlier, goals), earlier.points(), options)
    span = _spanned(goals, domain, points, options)
    ends = options.has_lines_only or span.status is SpanStatus.CANCELLED
    if ends or options.may_be_spanned:
        targets = goals.targets(_STRICTNESS, span.points - [0.0, 0.0, goals.base])
        found = spanned_fit(span, targets, size=goals.size, sheet=options.sheet, base=goals.base)
        found = replace(found, sides=goals.residuals(found))
        if ends or (span.ok and not goals.unmet(found)):
            return found
    start = start_from(span, goals.sides, sheet=options.sheet, least=_FLATTEST / goals.size, base=goals.base)
    return _searched(goals, span.domain, start, span.points, options)


def _spanned(goals: Goals, domain: Domain, points: Array, options: OutlineOptions) -> Span:
    """The span of the curves, level ones where their heights do not count.

    Sides with given normals are on their lines, too, or lean over them, which comes nearer to normals that lean evenly.
    """
    curve: Any = options.curves(domain)
    wish: dict[str, Any] = {goals.height_parameter: goals.number}
    if goals.has_given_normals:
        wish["max_iterations"] = _NEAR_ENOUGH
    if options.free_heights or not options.on_curve:
        base = [0.0, 0.0, goals.base]
        points = points * [1.0, 1.0, 0.0] + base
        if curve is not None:
            curve = [line * [1.0, 1.0, 0.0] + base for line in boundary_lines(domain, points, curve)[0]]
    call = partial(
        span_on_plan if goals.has_given_normals else span_outline,
        domain,
        points,
        curve,
        **wish,
        mirrors=[(goals.sides.edges(side), side.normals[0]) for side in goals.sides.of_kind(MIRROR)],
        initial=None if options.initial is None else options.initial.span,
        solver=options.solver,
        progress=options.progress,
    )
    leans = [(goals.sides.edges(side), side.angle) for side in goals.sides.of_kind(LEAN)]
    also = goals.sides.start_leans(-1.0 if options.sheet == "f-" else 1.0)
    if also:
        with suppress(ConditionError):  # walls that cannot be met, or curves elsewhere
            span = call(leans=[*leans, *also])
            if span.ok or span.status is SpanStatus.CANCELLED:
                return span
    return call(leans=leans, anchors=goals.sides.junctions if goals.has_given_normals else None)


def _searched(goals: Goals, domain: Domain, start: Start, near: Array, options: OutlineOptions) -> Fit:
    """The search over boundary normals; the start is over the base, near the points (V, 3)."""
    result = fit(
        domain,
        goals.targets(_STRICTNESS, near - [0.0, 0.0, goals.base]),
        start,
        size=goals.size,
        sheet=options.sheet,
        free_scale=goals.height_parameter != "mean_curvature",
        max_evaluations=options.max_evaluations,
        gain=_GAIN_BESIDE if goals.has_given_normals else _GAIN,
        solver=_solver(domain, options),
        progress=options.progress,
    )
    result = replace(result, shift=result.shift + [0.0, 0.0, goals.base])
    result = replace(result, sides=goals.residuals(result))
    return replace(result, unmet=goals.unmet(result))


def _solver(domain: Domain, options: OutlineOptions) -> CmcSolver:
    """A solver for the domain: the given one, or that of the earlier fit, if it is of this domain."""
    earlier = options.initial.solver if options.initial is not None else None
    known = [each for each in (options.solver, earlier) if each is not None and each.domain is domain]
    return known[0] if known else CmcSolver(domain)


def _continued(earlier: Fit, goals: Goals) -> Start:
    """The start that continues an earlier search."""
    shift, N = earlier.shift - [0.0, 0.0, goals.base], earlier.surface.harmonic.normals
    conditions = goals.sides.conditions(N, continued=True)
    return Start(
        conditions, earlier.surface.scale, shift, N, earlier.response, earlier.model, goals.sides.held
    )
