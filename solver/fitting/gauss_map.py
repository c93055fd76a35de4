"""The CMC surface whose tangent planes are nearest to those of a given surface (paper, Sec. 5.2, Figures 10, 11)."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..errors import CmcError, ConditionError, Progress
from ..gauss.boundary_data import Conditions
from ..gauss.conditions import gauss_map
from ..gauss.drawn_normals import drawn_normals
from ..gauss.frames import in_space
from ..gauss.options import with_options
from ..gauss.sphere import inner
from ..limits import COUNT, check_number
from ..measure.volume import volume_over
from ..signatures import check_fields
from ..spanning.lines import boundary_lines
from ..spanning.outline import span_outline
from ..spanning.span import Span
from ..spanning.verdict import SpanStatus
from ..surface.placement import procrustes
from ..surface.solve import CmcSolver
from .closest_point import Triangles
from .curves import Curve
from .fit import Fit, FitStatus, Start, fit
from .shape_similarity import ShapeSimilarity, cosine, dirichlet_matrix
from .spanned import spanned_fit
from .target import Target
from .targets import GaussMap, NearSurface, RimOnCurve, SmoothRim

Array = NDArray[np.float64]

# Mean curvature, as a part of the root mean square of the principal curvatures, above which the surface bulges to that
# side; below, its Gauss map alone hardly says what it looks like, and the surface on its rim is nearer.
_BULGES = 0.2
# Mean curvature times size below which a surface is minimal, up to the mesh.
_MINIMAL = 5e-3
# Weight of nearness above which the other weights grow with it, except that of the tangent planes: the places alone
# leave the rim rough.
_NEAR = 100.0
# Share of the evaluations that the first stage of two may take.
_FIRST = 0.6
# Part of the value that a step must gain to be followed by another: surfaces that are nearly CMC come back at second
# order.
_GAIN = 1e-5
# Square of the Gauss map's variation, as an angle, below which a surface counts as flat.
_FLAT = 1e-12


@dataclass(frozen=True, eq=False)
class GaussMapOptions:
    """The options of `fit_gauss_map`, see there. Raises `ConditionError` on weights that are not numbers from 0 on."""

    regularisation: float = 1e-3
    _: KW_ONLY
    likeness: float = 0.1
    near: float = 0.0
    max_evaluations: int = 200
    initial: Fit | None = None
    solver: CmcSolver | None = None
    progress: Progress | None = None

    def __post_init__(self) -> None:
        check_number(self.regularisation, "regularisation")
        check_number(self.likeness, "likeness")
        check_number(self.near, "weight of nearness")
        check_number(self.max_evaluations, "largest number of evaluations", COUNT)
        check_fields(self)


@with_options(GaussMapOptions)
def fit_gauss_map(domain: DomainLike, positions: ArrayLike, options: GaussMapOptions) -> Fit:
    """Minimise ½ ∫ |N - N_φ|² + λ ½ ∮ |dN₀|² over the boundary normals N₀, λ = regularisation >= 0.

    Both terms are without unit: the domain has area one, the boundary length one. positions: (V, 3) of the surface φ
    on the vertices of the domain. They also size and place the result: least squares over the area, scale and shift
    only, since the tangent planes are fitted. The result is f+ times `Fit.sign`, which is -1 where φ bulges against its
    normals.

    likeness: weight of 1 - cos(df, dφ), see `ShapeSimilarity`; it makes little difference to the tangent planes, and
    all the difference to the shape where the mean curvature of φ changes sign. 0 is the paper's functional. near: where
    positive, the weight of a second stage that fits the places, too: ½ mean squared distance of the sheet from φ and of
    its rim from the rim of φ, over the square of the diagonal; points may slide along φ. With 100, a distance of 1 % of
    the diagonal counts as much as a turn of 0.1 radians everywhere. initial: an earlier fit of this surface to
    continue, in the stage that it reached. progress(evaluation, value) is called at every step; False cancels.

    Where φ bends about as much one way as the other (mean curvature under a fifth of the root mean square of the
    principal curvatures) and likeness counts, the result is the surface on the rim of φ with the volume of φ, of H of
    either sign or 0: see `span_outline` and `Fit.span`. Its points may slide along φ; with holes or sharp corners it is
    conformal to `Fit.surface.domain` in place of φ.

    Distances: "Gauss map" and "likeness" are root mean squares, "near surface" is the largest distance from φ. Raises
    `ConditionError` on weights that are not numbers from 0 on, on flat surfaces and on closed ones.
    """
    domain = as_domain(domain)
    if not len(domain.boundary_edges):
        raise ConditionError("A closed surface has no rim whose normals could be fitted; delete a part of it.")
    given = _Given.of(domain, in_space(domain, positions), options)
    search = _Search(given, options.solver or CmcSolver(domain), options.progress)
    span = given.span() if given.is_saddle and options.likeness else None
    if span is not None and (span.ok or span.status is SpanStatus.CANCELLED):
        targets = given.plane_targets(1.0, options.near) + given.place_targets(1.0)
        return spanned_fit(span, targets, size=given.size)
    found = search()
    return found if span is None else replace(found, unmet=[*found.unmet, span.message])


@dataclass(frozen=True, eq=False)
class _Given:
    """The surface φ, its normals, and the weights of the targets. A sign of -1 stands for -φ: same normals."""

    domain: Domain
    points: Array
    normals: Array
    L: sp.csr_array
    options: GaussMapOptions

    @classmethod
    def of(cls, domain: Domain, points: Array, options: GaussMapOptions) -> _Given:
        normals, L = drawn_normals(domain, points), dirichlet_matrix(domain)
        if inner(L @ normals, normals) < _FLAT:
            raise ConditionError(
                "The surface is flat or a point: no CMC surface of finite size has its tangent planes."
            )
        return cls(domain, points, normals, L, options)

    @property
    def size(self) -> float:
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @property
    def _cosine(self) -> float:
        return cosine(self.L, self.normals, self.points)

    @property
    def sign(self) -> float:
        """Of the mean curvature."""
        return 1.0 if self._cosine >= 0.0 else -1.0

    @property
    def is_saddle(self) -> bool:
        """Whether it bends about as much one way as the other."""
        return abs(self._cosine) < _BULGES

    def span(self) -> Span | None:
        """The surface on the rim with the same volume, or the minimal one if that is almost minimal; None where the rim
        is none that can be spanned."""
        options, earlier = self.options, self.options.initial
        more: dict[str, Any] = {"solver": options.solver, "progress": options.progress}
        try:
            lines, outer, _ = boundary_lines(self.domain, self.points, None)
            base = float(Curve(lines[outer], closed=True).shares @ lines[outer][:, 2])
            volume = volume_over(self.points - [0.0, 0.0, base], self.domain.faces, np.array([0.0, 0.0, 1.0]))
            initial = None if earlier is None else earlier.span
            found = span_outline(self.domain, self.points, volume=volume, initial=initial, **more)
            if found.ok and abs(found.mean_curvature) * self.size < _MINIMAL:
                return span_outline(self.domain, self.points, mean_curvature=0.0, initial=found, **more)
        except CmcError:
            return None
        return found

    def start(self) -> Start:
        rim = gauss_map(self.domain, self.points, self.domain.boundary_edges)
        conditions = Conditions(rim.vertices, rim.vertex_normals, up=rim.up)
        return Start(conditions, 1.0, np.zeros(3), self.normals)

    def plane_targets(self, sign: float, near: float = 0.0) -> list[Target]:
        more = 1.0 + near / _NEAR
        targets: list[Target] = [GaussMap(self.normals), SmoothRim(weight=more * self.options.regularisation)]
        if self.options.likeness:
            targets.append(ShapeSimilarity(sign * self.points, self.L, weight=more * self.options.likeness))
        return targets

    def place_targets(self, sign: float) -> list[Target]:
        surface = Triangles(sign * self.points, self.domain.faces)
        near: list[Target] = [NearSurface(lambda points: surface.closest(points).points, weight=self.options.near)]
        for loop in self.domain.boundary_loops:
            rim = Curve(sign * self.points[loop], closed=True)
            near.append(RimOnCurve(rim, loop.astype(np.int64), weight=self.options.near))
        return near


@dataclass(frozen=True, eq=False)
class _Search:
    """The two stages of the fit."""

    given: _Given
    solver: CmcSolver
    progress: Progress | None

    def __call__(self) -> Fit:
        """Both, or the second one alone where an earlier fit has come so far."""
        options = self.given.options
        initial, evaluations = options.initial, options.max_evaluations
        if initial is not None and options.near and RimOnCurve.label in initial.distances:
            return self.places(initial, evaluations)
        share = _FIRST if options.near else 1.0
        planes = self.planes(initial, max(1, round(share * evaluations)))
        if not options.near or planes.status is FitStatus.CANCELLED:
            return planes
        places = self.places(planes, max(1, evaluations - len(planes.history)))
        return replace(places, history=planes.history + places.history)

    def planes(self, initial: Fit | None, evaluations: int) -> Fit:
        """The first stage: the tangent planes, at any size."""
        start = self.given.start() if initial is None else _continued(initial)
        sign = self.given.sign if initial is None else initial.sign
        targets = self.given.plane_targets(sign)
        return self._placed(replace(self._fit(targets, start, 1.0, False, evaluations), sign=sign))

    def places(self, planes: Fit, evaluations: int) -> Fit:
        """The second stage: the places, too, with the size and the shift free."""
        given, sign = self.given, planes.sign
        start = replace(_continued(planes), scale=planes.surface.scale, shift=sign * planes.shift)
        targets = given.plane_targets(sign, given.options.near) + given.place_targets(sign)
        result = self._fit(targets, start, given.size, True, evaluations)
        return replace(result, sign=sign, shift=sign * result.shift)

    def _fit(self, targets: list[Target], start: Start, size: float, moves: bool, evaluations: int) -> Fit:
        return fit(
            self.given.domain,
            targets,
            start,
            size=size,
            free_scale=moves,
            free_shift=moves,
            max_evaluations=evaluations,
            gain=_GAIN,
            solver=self.solver,
            progress=self.progress,
        )

    def _placed(self, result: Fit) -> Fit:
        """The result, sized and placed over φ."""
        surface = result.surface
        weights, goals = surface.domain.vertex_areas[surface.source], self.given.points[surface.source]
        scale, _, shift = procrustes(surface.f_plus, goals, weights)
        if not (np.isfinite(scale) and scale):
            raise ConditionError("The fit shrank to a point; give likeness some weight.")
        size = abs(scale)
        surface = replace(
            surface,
            g=size * surface.g,
            f_plus=size * surface.f_plus,
            f_minus=size * surface.f_minus,
            scale=size * surface.scale,
            periods=size * surface.periods,
        )
        result = replace(result, surface=surface, shift=shift, sign=float(np.sign(scale)))
        away = Triangles(self.given.points, self.given.domain.faces).closest(result.points()).distances
        return replace(result, distances={**result.distances, NearSurface.label: float(away.max())})


def _continued(earlier: Fit) -> Start:
    """The start that continues an earlier fit, at scale one."""
    return Start(earlier.conditions, 1.0, np.zeros(3), earlier.surface.harmonic.normals, earlier.response)
