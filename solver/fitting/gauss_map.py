"""The CMC surface whose tangent planes are nearest to those of a given surface (paper, Sec. 5.2, Figures 10, 11)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, Progress
from ..gauss.boundary_data import Conditions
from ..gauss.conditions import gauss_map
from ..gauss.frames import area_vectors, in_space, unit_rows
from ..gauss.sphere import inner
from ..linalg import check_number, sum_rows
from ..surface.placement import procrustes
from ..surface.solve import CmcSolver
from .closest_point import Triangles
from .curves import Curve
from .fit import Fit, FitStatus, Start, fit
from .shape_similarity import LEAST, ShapeSimilarity, bending, cosine, dirichlet_matrix
from .target import Target
from .targets import GaussMap, NearSurface, RimOnCurve, SmoothRim

Array = NDArray[np.float64]

# Mean curvature, as a part of the root mean square of the principal curvatures, from which on the surface is taken to
# bulge to that side; below, both sides are tried, each with this share of the evaluations.
_BULGES = 0.2
_LOOK = 0.25
# Weight of nearness from which on the other weights grow with it, but for that of the tangent planes: where only
# the places counted, the rim would rattle.
_NEAR = 100.0
# Share of the evaluations that the first stage of two may take.
_FIRST = 0.6
# Part of the value that a step has to bring to be followed by another: what is nearly CMC comes back at second order.
_GAIN = 1e-5
# Square of the Gauss map's variation, as an angle, below which a surface counts as flat.
_FLAT = 1e-12


def fit_gauss_map(
    domain: Domain,
    positions: ArrayLike,
    regularisation: float = 1e-3,
    *,
    likeness: float = 0.1,
    near: float = 0.0,
    initial: Fit | None = None,
    max_evaluations: int = 200,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Minimise ½ ∫ |N - N_φ|² + λ ½ ∮ |dN₀|² over the boundary normals N₀, λ = `regularisation` >= 0.

    Both terms are without unit: the domain has area one, the boundary length one. positions: (V, 3) of the surface φ
    on the vertices of the domain, by which it is also sized and placed: least squares over its area, scale and shift
    only, since the tangent planes are what was fitted. The result is f+ times `Fit.sign`, which is -1 where φ bulges
    against its normals.

    likeness: weight of 1 - cos(df, dφ), see `ShapeSimilarity`; it makes little difference to the tangent planes, and
    all the difference to the shape where the mean curvature of φ changes sign. 0 is the paper's functional. near:
    positive, it is the weight of a second stage that brings the places near, too: ½ mean squared distance of the sheet
    from φ and of its rim from the rim of φ, over the square of the diagonal; points may slide along φ. With 100, a
    distance of 1 % of the diagonal counts as much as a turn of 0.1 radians everywhere. initial: an earlier fit of this
    surface to go on from, in the stage that it had reached.

    Distances: "Gauss map" and "likeness" are root mean squares, "near surface" is the largest distance from φ. Raises
    `ConditionError` on weights that are no numbers from 0 on, on flat surfaces and on closed ones.
    """
    for name, weight in (("regularisation", regularisation), ("likeness", likeness), ("weight of nearness", near)):
        check_number(weight, name)
    if not len(domain.boundary_edges):
        raise ConditionError("A closed surface has no rim whose normals could be fitted; delete a part of it.")
    wanted = _Wanted.of(domain, in_space(domain, positions), regularisation, likeness, near)
    objective = _Objective(wanted, solver or CmcSolver(domain), progress)
    if initial is not None and near and RimOnCurve.label in initial.distances:
        return objective.brought_near(initial, max_evaluations)
    share = _FIRST if near else 1.0
    found = objective.turned(initial, max(1, round(share * max_evaluations)))
    if not near or found.status is FitStatus.CANCELLED:
        return found
    near_too = objective.brought_near(found, max(1, max_evaluations - len(found.history)))
    return replace(near_too, history=found.history + near_too.history)


def vertex_normals(domain: Domain, points: Array) -> Array:
    """Unit normals (V, 3) of a surface, its faces weighted by their angles at each vertex."""
    faces = domain.faces
    of_faces = unit_rows(area_vectors(points, faces), "face", "has no area in these positions")
    weighted = of_faces[:, None, :] * domain.corner_angles[:, :, None]
    sums = sum_rows(faces.ravel(), weighted.reshape(-1, 3), domain.vertex_count)
    return unit_rows(sums, "vertex", "has faces whose normals cancel")


@dataclass(frozen=True, eq=False)
class _Wanted:
    """The surface φ, its normals, and the weights of the targets. A sign of -1 stands for -φ: same normals."""

    domain: Domain
    points: Array
    normals: Array
    L: sp.csr_array
    regularisation: float
    likeness: float
    near: float

    @classmethod
    def of(cls, domain: Domain, points: Array, regularisation: float, likeness: float, near: float) -> _Wanted:
        normals, L = vertex_normals(domain, points), dirichlet_matrix(domain)
        if inner(L @ normals, normals) < _FLAT:
            raise ConditionError(
                "The surface is flat or a point: no CMC surface of finite size has its tangent planes."
            )
        return cls(domain, points, normals, L, regularisation, likeness, near)

    @property
    def size(self) -> float:
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def signs(self) -> tuple[float, ...]:
        """That of the mean curvature; both where it is next to nothing."""
        cos = cosine(self.L, self.normals, self.points)
        return (float(np.sign(cos)),) if abs(cos) > _BULGES else (1.0, -1.0)

    def start(self) -> Start:
        rim = gauss_map(self.domain, self.points, self.domain.boundary_edges)
        conditions = Conditions(rim.vertices, rim.vertex_normals, up=rim.up)
        return Start(conditions, 1.0, np.zeros(3), self.normals)

    def planes(self, sign: float, near: float = 0.0) -> list[Target]:
        more = 1.0 + near / _NEAR
        targets: list[Target] = [GaussMap(self.normals), SmoothRim(weight=more * self.regularisation)]
        if self.likeness:
            targets.append(ShapeSimilarity(sign * self.points, self.L, weight=more * self.likeness))
        return targets

    def places(self, sign: float) -> list[Target]:
        surface = Triangles(sign * self.points, self.domain.faces)
        near: list[Target] = [NearSurface(lambda points: surface.closest(points).points, weight=self.near)]
        for loop in self.domain.boundary_loops:
            rim = Curve(sign * self.points[loop], closed=True)
            near.append(RimOnCurve(rim, loop.astype(np.int64), weight=self.near))
        return near


@dataclass(frozen=True, eq=False)
class _Objective:
    wanted: _Wanted
    solver: CmcSolver
    progress: Progress | None

    def turned(self, initial: Fit | None, evaluations: int) -> Fit:
        """The first stage: the tangent planes, at any size."""
        if initial is not None:
            return self._placed(self._turned(_continued(initial), initial.sign, evaluations))
        start, signs = self.wanted.start(), self.wanted.signs()
        share = 1.0 if len(signs) == 1 else _LOOK
        looks = []
        for sign in signs:
            start = replace(start, response=looks[-1].response) if looks else start
            looks.append(self._turned(start, sign, max(1, round(share * evaluations))))
            if looks[-1].status is FitStatus.CANCELLED:
                break
        best = min(looks, key=lambda found: found.value)
        spent = [value for found in looks for value in found.history]
        if len(looks) > 1 and best.status is FitStatus.EVALUATION_LIMIT and evaluations > len(spent):
            best = self._turned(_continued(best), best.sign, evaluations - len(spent))
            spent = spent + best.history
        return self._placed(replace(best, history=spent))

    def brought_near(self, found: Fit, evaluations: int) -> Fit:
        """The second stage: the places too, with the size and the shift free."""
        wanted, sign = self.wanted, found.sign
        start = replace(_continued(found), scale=found.surface.scale, shift=sign * found.shift)
        targets = wanted.planes(sign, wanted.near) + wanted.places(sign)
        found = self._fit(targets, start, wanted.size, True, evaluations)
        return self._reported(replace(found, sign=sign, shift=sign * found.shift))

    def _turned(self, start: Start, sign: float, evaluations: int) -> Fit:
        return replace(self._fit(self.wanted.planes(sign), start, 1.0, False, evaluations), sign=sign)

    def _fit(self, targets: list[Target], start: Start, size: float, moves: bool, evaluations: int) -> Fit:
        return fit(
            self.wanted.domain,
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

    def _placed(self, found: Fit) -> Fit:
        """The fit over the surface it was fitted to."""
        surface = found.surface
        weights, goals = surface.domain.vertex_areas[surface.source], self.wanted.points[surface.source]
        scale, _, shift = procrustes(surface.f_plus, goals, weights)
        if not (np.isfinite(scale) and scale):
            raise ConditionError("The fit has shrunk to a point; give it some weight of likeness.")
        size = abs(scale)
        surface = replace(
            surface,
            g=size * surface.g,
            f_plus=size * surface.f_plus,
            f_minus=size * surface.f_minus,
            scale=size * surface.scale,
            periods=size * surface.periods,
        )
        found = replace(found, surface=surface, shift=shift, sign=float(np.sign(scale)))
        away = Triangles(self.wanted.points, self.wanted.domain.faces).closest(found.points()).distances
        return self._reported(replace(found, distances={**found.distances, NearSurface.label: float(away.max())}))

    def _reported(self, found: Fit) -> Fit:
        """With a sentence where the surface would rather be minimal."""
        wanted, H = self.wanted, found.surface.mean_curvature
        bent, _ = bending(wanted.domain, wanted.L, found.surface.harmonic.normals)
        if not wanted.likeness or bent > 1.1 * LEAST**2:
            return found
        sentence = (
            f"The surface bends as much one way as the other, and those of constant mean curvature near it are almost "
            f"minimal: this one has H = {H:.3g}, the least that is looked for; a minimal surface may come nearer."
        )
        return replace(found, unmet=[*found.unmet, sentence])


def _continued(earlier: Fit) -> Start:
    """On from an earlier fit, at scale one."""
    return Start(earlier.conditions, 1.0, np.zeros(3), earlier.surface.harmonic.normals, earlier.response)
