"""The surface of constant mean curvature that spans given lines (Plateau's problem, and Rellich's for H ≠ 0)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError, Progress, check_choice
from ..gauss.frames import boundary_edges, in_space
from ..gauss.options import with_options
from ..limits import COUNT, NUMBERS, TOLERANCE, check_number
from ..signatures import check_fields
from ..surface.solve import CmcSolver
from .layout import flat_layout
from .problem import SpanProblem
from .relay import rolled_out, under_lines
from .search import Found, Search, Wish
from .setting import Lines, setting
from .side_ends import upright_vertices
from .span import Asked, Span, finished
from .verdict import SpanStatus, distortion, judged

Array = NDArray[np.float64]

# Ends of a search that another plan may do away with.
_UNLIKE = (SpanStatus.UNLIKE, SpanStatus.STALLED, SpanStatus.NOT_CONFORMAL, SpanStatus.ITERATION_LIMIT)

# Times that vertices at the ends of leaning sides are chosen anew, at most.
_ROUNDS = 12
# Times that a surface is rolled out to be the plan of a better one, at most.
_ROLLED = 5

HOLES = {
    "adapt": ("Adapt", "Holes of the plan move until the map to the surface is conformal"),
    "keep": ("Keep", "The plan keeps its conformal type; the surface is not quite of constant mean curvature"),
}
CORNERS = {
    "sharp": ("Sharp", "Corners of the lines stay sharp, and the sides of the plan shift for that"),
    "round": ("Round", "All vertices slide past corners, so that the drawn plan stays; lines are best rounded before"),
}
"""Treatments of holes and of corners: name → label and description."""

KNOBS = ("mean_curvature", "rise", "height", "volume")


@dataclass(frozen=True, eq=False)
class SpanOptions:
    """The options of `span_outline`, see there. Raises `ConditionError` on values without meaning."""

    curve: ArrayLike | Sequence[ArrayLike | None] | None = None
    _: KW_ONLY
    mean_curvature: float | None = None
    rise: float | None = None
    height: float | None = None
    volume: float | None = None
    leans: Sequence[tuple[ArrayLike, float]] = ()
    mirrors: Sequence[tuple[ArrayLike, ArrayLike]] = ()
    anchors: ArrayLike | None = None
    holes: str = "adapt"
    corners: str = "sharp"
    initial: Span | None = None
    solver: CmcSolver | None = None
    tolerance: float = 1e-6
    max_iterations: int = 60
    progress: Progress | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        check_choice(self.holes, HOLES, "treatment of holes")
        check_choice(self.corners, CORNERS, "treatment of corners")
        check_number(self.tolerance, "tolerance", TOLERANCE)
        check_number(self.max_iterations, "largest number of iterations", COUNT)
        name, number = self.wish
        check_number(number, name.replace("_", " "), NUMBERS)

    @property
    def wish(self) -> tuple[str, float]:
        """The one number that is given, and its value; without any, mean curvature 0."""
        given = {name: getattr(self, name) for name in KNOBS if getattr(self, name) is not None}
        if len(given) > 1:
            raise ConditionError(f"Give one of {' and '.join(given)}, not both: one number chooses the surface.")
        return next(iter(given.items()), ("mean_curvature", 0.0))


@with_options(SpanOptions)
def span_outline(domain: DomainLike, positions: ArrayLike, options: SpanOptions) -> Span:
    """The surface of constant mean curvature, 0 and negative too, whose rim lies on given closed lines.

    f is critical for D(f) - 2H V(f), D the Dirichlet energy over the plan and V the volume, while rim vertices slide
    along the lines (Plateau, Douglas; for H ≠ 0 Rellich). Such f are conformal and have -Δf = 2H f_x × f_y. Points
    converge with the square of the edge length.

    positions: (V, 2|3) of the plan. curve: (m, 3) closed polyline, starting anywhere, either way round; by default the
    plan's own boundary with its heights; on a plan with holes the outer line, or a list with one for each of
    `domain.boundary_loops`, None for one that spans its own points. It is smoothed by a C² spline between its
    corners, turns of more than 35°.

    At most one number chooses the surface: mean_curvature (default 0; positive domes up over a plan that faces up,
    negative hangs), height of the crown over the outer line's mean height (negative: of the lowest point under it),
    rise (height as a part of half the outline's smaller extent), or volume over that mean height.

    leans: (edges, angle) pairs, edges as in `conditions`: indices, or names of a shape's sides. These sides stay over
    their drawn line, at free heights, and meet the upright wall over it at this angle in radians, 0 upright, ½ π at
    right angles like a mirror: N · ν = cos(angle), ν the wall's outward normal. mirrors: (edges, plane normal) pairs;
    these sides slide in the plane of their drawn points and meet it at right angles. anchors: (k,) vertices of drawn
    lines that stay where they were drawn; the plan adapts to them, the surface is the same.

    holes: "adapt" moves the plan's holes until the map is conformal, "keep" keeps the plan's conformal type, and the
    surface is then not quite of constant mean curvature. corners: "sharp" holds corners in place and shifts the plan's
    sides for that, "round" lets all vertices slide; round the line first. A plan too unlike the lines has its vertices
    moved under them. initial: an earlier span of this plan, to continue from. tolerance: of the residual, which has no
    unit. progress(step, residual) is called at each step; False cancels.

    Raises `ConditionError` on input that contradicts itself or fits no plan. That no surface was found is a status.
    """
    domain, points, options = _checked(domain, positions, options)
    tried = _searched(domain, points, options)
    if options.initial is None and tried.status in _UNLIKE:
        tried = _on_other_plans(domain, points, options, tried)
    return _ended(tried, domain, options)


@with_options(SpanOptions)
def span_on_plan(domain: DomainLike, positions: ArrayLike, options: SpanOptions) -> Span:
    """The same over the plan as it is: where that is too unlike the lines no other is tried."""
    domain, points, options = _checked(domain, positions, options)
    return _ended(_searched(domain, points, options), domain, options)


def _checked(
    domain: DomainLike, positions: ArrayLike, options: SpanOptions
) -> tuple[Domain, Array, SpanOptions]:
    """The domain, its points (V, 3), and the options with edges as indices."""
    options = replace(
        options,
        leans=[(boundary_edges(domain, edges), angle) for edges, angle in options.leans],
        mirrors=[(boundary_edges(domain, edges), normal) for edges, normal in options.mirrors],
    )
    domain = as_domain(domain)
    return domain, in_space(domain, positions), options


def _ended(tried: _Tried, domain: Domain, options: SpanOptions) -> Span:
    name, number = options.wish
    asked = Asked(
        plan=domain,
        lines=tried.lines,
        mirrors=options.mirrors,
        leans=options.leans,
        mean_curvature=number if name == "mean_curvature" else None,
        solver=options.solver,
    )
    return finished(tried.found, asked, options.initial)


@dataclass(frozen=True, eq=False)
class _Tried:
    """The end of a search over one plan."""

    plan: Domain
    found: Found
    lines: Lines

    @property
    def status(self) -> SpanStatus:
        """How it ended, as far as the points say."""
        if self.found.largest is not None:
            return SpanStatus.NO_SURFACE
        return judged(self.found.descent, self.lines.is_drawn)[0]

    @property
    def points(self) -> Array:
        """(V, 3), about the centre of the lines."""
        return self.found.descent.state.f[: self.plan.vertex_count]

    @property
    def layout(self) -> tuple[Domain, Array]:
        """The plan as its moduli have moved it, and its positions (V, 2)."""
        motions, q = self.found.descent.problem.motions, self.found.descent.state.q
        return motions.moved(q), motions.at(q)


def _on_other_plans(domain: Domain, points: Array, options: SpanOptions, tried: _Tried) -> _Tried:
    """The search over the plan laid under the lines, or over the surface rolled out; the given one if none is better.

    Over a surface rolled out it starts from this surface, if that is one.
    """
    if not tried.lines.is_drawn:
        laid = under_lines(domain, _flattest(domain, points, options))
        if laid is not None and (again := _searched(laid, points, options)).status is SpanStatus.CONVERGED:
            return again
    layout = flat_layout(domain, points)
    surfaces: list[Array | None] = [tried.points, None]  # at last the flattest
    near = tried if tried.status is SpanStatus.NOT_CONFORMAL else None
    for _ in range(_ROLLED):
        if layout is None or not surfaces:
            break
        (surface, start), near = (surfaces.pop(0), near), None
        surface = _flattest(domain, points, options) if surface is None else surface
        laid = rolled_out(layout[0], layout[1], surface)
        if laid is None:
            continue
        again = _searched(laid, points, options, start)
        if again.status is SpanStatus.CONVERGED:
            return again
        if again.status is SpanStatus.NOT_CONFORMAL and _distortion(again) < _distortion(tried):
            tried = near = again
            layout = again.layout
            surfaces.insert(0, again.points)
    return tried


def _flattest(domain: Domain, points: Array, options: SpanOptions) -> Array:
    """The harmonic surface (V, 3) that the search over a plan starts from."""
    return _setting(domain, points, options)[0].start().f


def _distortion(tried: _Tried) -> float:
    descent = tried.found.descent
    return distortion(descent.state.D, descent.state.f, descent.problem.domain.faces)


def _setting(
    domain: Domain,
    points: Array,
    options: SpanOptions,
    earlier: Found | None = None,
    upright: Sequence[int] | None = None,
) -> tuple[SpanProblem, Lines]:
    """earlier: a search on the same plan; upright: rim vertices that stand at ends of sides, by default as there."""
    solver = options.solver.harmonic if options.solver is not None and options.solver.domain is domain else None
    problem = earlier.descent.problem if earlier is not None else None
    if problem is not None and problem.solver.domain is domain:
        solver = problem.solver
    if upright is None:
        upright = earlier.upright if earlier is not None else ()
    return setting(
        domain,
        points,
        options.curve,
        options.mirrors,
        options.leans,
        options.anchors,
        sharp=options.corners == "sharp",
        moving_holes=options.holes == "adapt",
        solver=solver,
        mean_curvature=options.wish[1] if options.wish[0] == "mean_curvature" else None,
        earlier=problem,
        upright=upright,
    )


def _searched(domain: Domain, points: Array, options: SpanOptions, near: _Tried | None = None) -> _Tried:
    """near: a search over another plan with the same vertices, to start from its surface."""
    initial = options.initial.kept if options.initial is not None else None
    problem, lines = _setting(domain, points, options, initial)
    start, earlier = None, None
    if initial is not None and problem.coordinates is initial.descent.problem.coordinates:
        start = problem.continued(initial.descent.problem, initial.descent.state)
        earlier = None if start is None else initial.descent
    if near is not None:
        descent = near.found.descent
        start = problem.laid_over(descent.problem, descent.state)
    search = Search(
        problem,
        lines,
        tolerance=options.tolerance,
        limit=options.max_iterations,
        progress=options.progress,
        earlier=earlier,
    )
    name, number = options.wish
    if name == "rise":
        name, number = "height", number * 0.5 * lines.extent
    wish = Wish(name, number)
    found = search(wish, start)
    if initial is not None:
        found = replace(found, upright=initial.upright)
    return _Tried(domain, _over_sides(domain, points, options, search, wish, found), lines)


def _over_sides(
    domain: Domain, points: Array, options: SpanOptions, search: Search, wish: Wish, found: Found
) -> Found:
    """The search again, with vertices that passed the end of a leaning side upright there; the first if that fails."""
    for _ in range(_ROUNDS):
        descent = found.descent
        upright = upright_vertices(descent) if descent.end == "converged" and found.largest is None else found.upright
        if upright == found.upright:
            break
        problem, _ = _setting(domain, points, options, found, upright)
        start = problem.upright(descent.problem, descent.state)
        again = replace(search, problem=problem, earlier=None)(wish, start)
        if again.descent.end != "converged" or again.largest is not None:
            break
        found = replace(again, upright=upright)
    return found
