"""A shell while its plan changes: solved from the last map, placed, not measured."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import Progress, Status
from ..spanning.span import Span
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import Similarity
from ..surface.solve import CmcSolver
from .form import place_over, solve_plan
from .measured import check_shown, placed_sheets
from .plan import Plan, Settings
from .plan_conditions import plan_conditions
from .span import line_plane, spanned

Array = NDArray[np.float64]

ROUGHLY = 1e-4
"""Residual that is good enough for the eye."""

# Maps that need a new start.
_LOST = (Status.COLLAPSED, Status.UNDER_RESOLVED, Status.STALLED)
# Methods that do not run downhill continue to the nearest critical map.
_UPHILL = ("saddle", "critical")


@dataclass(frozen=True, eq=False, repr=False)
class Update:
    """A surface, its similarity, points and normals (n, 3) of the placed sheets, and its span: as in `Shell`."""

    surface: CmcSurface
    similarity: Similarity
    placed: dict[str, Array]
    normals: dict[str, Array]
    span: Span | None = None

    @property
    def ok(self) -> bool:
        """Whether the map is harmonic to `ROUGHLY` zero, or the settings' tolerance, and the surface has no gap."""
        return self.surface.status is Status.CONVERGED

    @property
    def message(self) -> str:
        return self.surface.message if self.span is None else self.span.message

    @property
    def last(self) -> Array | Span:
        """What the next `update` starts from."""
        return self.surface.harmonic.normals if self.span is None else self.span

    def __repr__(self) -> str:
        return f"Update({self.surface!r})"


def update(
    plan: Plan,
    settings: Settings,
    solver: CmcSolver,
    last: ArrayLike | Span,
    *,
    steps: int | None = None,
    progress: Progress | None = None,
) -> Update:
    """The next shell, from the normals `last` (S, 3) or the span of the one before, on the plan's own `solver`.

    steps: of Newton's method, at most; None: until the residual is `ROUGHLY` zero. The shell stays on its branch; where
    the branch ends, a new solve starts. Raises `CmcError` as `form` does.
    """
    rough = replace(settings, tolerance=max(settings.tolerance, ROUGHLY))
    conditions = plan_conditions(plan, rough, solver.domain)
    if conditions.is_spanned:
        initial = last if isinstance(last, Span) else None
        return _of_span(spanned(plan, rough, conditions, solver, initial=initial, progress=progress))
    last = last.normals if isinstance(last, Span) else last
    method = "critical" if rough.method in _UPHILL else "newton"
    surface = solver.solve(
        conditions,
        last,
        **rough.solve_options(method=method, degree=None, max_iterations=steps, progress=progress),
    )
    if surface.harmonic.status in _LOST:
        surface = solve_plan(plan, rough, solver, progress=progress)
    sheets = check_shown(surface, rough.sheet)
    plane, similarity = place_over(plan, rough, surface)
    return Update(surface, similarity, *placed_sheets(surface, similarity, plane, sheets))


def _of_span(span: Span) -> Update:
    surface, similarity = span.as_surface, Similarity()
    sheets = check_shown(surface, "f+")
    return Update(surface, similarity, *placed_sheets(surface, similarity, line_plane(span), sheets), span)
