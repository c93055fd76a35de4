"""A shell while its plan changes: solved from the last map, placed, not measured."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import Progress, Status
from ..fitting.fit import Fit
from ..spanning.span import Span
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import Similarity
from ..surface.solve import CmcSolver
from .close import Closing, closed
from .form import place_over, solve_plan
from .measured import check_shown, placed_sheets
from .mixed import fit_plane, fit_similarity, fitted
from .plan import Plan, Settings
from .plan_conditions import plan_conditions
from .span import is_mixed, line_plane, spanned

Array = NDArray[np.float64]

ROUGHLY = 1e-4
"""Residual that is good enough for the eye."""

# Maps that need a new start.
_LOST = (Status.COLLAPSED, Status.UNDER_RESOLVED, Status.STALLED)
# Methods that do not run downhill continue to the nearest critical map.
_UPHILL = ("saddle", "critical")


@dataclass(frozen=True, eq=False, repr=False)
class Update:
    """A surface, its similarity, points and normals (n, 3) of the placed sheets, and its span, fit or closing: as in
    `Shell`."""

    surface: CmcSurface
    similarity: Similarity
    placed: dict[str, Array]
    normals: dict[str, Array]
    span: Span | None = None
    fit: Fit | None = None
    closing: Closing | None = None

    @property
    def ok(self) -> bool:
        """Whether the map is harmonic to `ROUGHLY` zero, or the settings' tolerance, the surface has no gap, and a fit
        meets its goals."""
        return self.surface.status is Status.CONVERGED and (self.fit is None or self.fit.is_met)

    @property
    def message(self) -> str:
        found = self.span or self.fit or self.closing or self.surface
        return found.message

    @property
    def last(self) -> Array | Span | Fit:
        """What the next `update` starts from."""
        return self.span or self.fit or self.surface.harmonic.normals

    def __repr__(self) -> str:
        return f"Update({self.surface!r})"


def update(
    plan: Plan,
    settings: Settings,
    solver: CmcSolver,
    last: ArrayLike | Span | Fit,
    *,
    steps: int | None = None,
    progress: Progress | None = None,
) -> Update:
    """The next shell, from `last`, the normals (S, 3), span or fit of the one before, on the plan's own `solver`.

    steps: of Newton's method, at most; None: until the residual is `ROUGHLY` zero. The shell stays on its branch; where
    the branch ends, a new solve starts. Raises `CmcError` as `form` does.
    """
    rough = replace(settings, tolerance=max(settings.tolerance, ROUGHLY))
    conditions = plan_conditions(plan, rough, solver.domain)
    if conditions.is_spanned:
        if is_mixed(conditions, solver.domain):
            initial = last if isinstance(last, Fit) else None
            return _of_fit(fitted(plan, rough, solver, initial=initial, progress=progress), solver, rough)
        earlier = last.span if isinstance(last, Fit) else last if isinstance(last, Span) else None
        return _of_span(spanned(plan, rough, conditions, solver, initial=earlier, progress=progress))
    if isinstance(last, (Span, Fit)):
        last = last.normals if isinstance(last, Span) else last.surface.harmonic.normals
    method = "critical" if rough.method in _UPHILL else "newton"
    surface = solver.solve(
        conditions,
        last,
        **rough.solve_options(method=method, degree=None, max_iterations=steps, progress=progress),
    )
    if surface.harmonic.status in _LOST:
        surface = solve_plan(plan, rough, solver, progress=progress)
    closing = None if rough.close is None else closed(plan, rough, surface, rough.close, progress)
    if closing is not None:
        plan, surface = closing.plan, closing.result.surface
    sheets = check_shown(surface, rough.sheet)
    plane, similarity = place_over(plan, rough, surface)
    return Update(surface, similarity, *placed_sheets(surface, similarity, plane, sheets), closing=closing)


def _of_fit(fit: Fit, solver: CmcSolver, settings: Settings) -> Update:
    surface, similarity = fit.surface, fit_similarity(fit, settings)
    plane = fit_plane(fit, solver, similarity)
    return Update(surface, similarity, *placed_sheets(surface, similarity, plane, check_shown(surface, "f+")), fit=fit)


def _of_span(span: Span) -> Update:
    surface, similarity = span.as_surface, Similarity()
    sheets = check_shown(surface, "f+")
    return Update(surface, similarity, *placed_sheets(surface, similarity, line_plane(span), sheets), span)
