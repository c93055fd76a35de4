"""The measures of one sheet, f+ or f-: curvature, distortion, size, overhang, intersections, distance to an outline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError
from ..linalg import as_numbers
from ..surface.placement import span
from .arrays import Array, Indices, face_areas_in_space, weighted_l2, weighted_mean
from .curvature import gauss_curvature_of, mean_curvature_of
from .distortion import conformal_distortion, distortion_energy
from .extent import boundary_sides, leans, overhanging_faces
from .intersections import self_intersections
from .outline import distance_to_segments, outline_segments
from .volume import sheet_volume

if TYPE_CHECKING:
    from ..domain.domain import Domain

Vector = tuple[float, float, float]
_LISTED_PAIRS = 100
# A mean curvature that misses its target by more than these parts of it, in L²: is off; is not constant at all.
_OFF, _LOST = 0.1, 0.5
# A target below this part of 1 / sqrt(area) is small.
_SMALL = 0.1


@dataclass(frozen=True)
class CurvatureReport:
    """Mean curvature H of the faces and its target, in 1/length; means are weighted by area.

    l2 is sqrt(∫ (H - target)² dA / area), linf the largest |H - target|. `relative_l2` is l2 over the
    `reference`: the target's size, or, where that is less than a tenth of 1 / sqrt(area), as at H = 0, 1 / sqrt(area).
    The `inside` figures leave out faces that have a vertex on the boundary. `gauss_mean` is the mean of K, in
    1/length². left_out: the number of faces next to corners of the rim that all figures leave out; see `report`.
    """

    target: float
    mean: float
    std: float
    l2: float
    linf: float
    reference: float
    relative_l2: float
    inside_l2: float
    inside_linf: float
    gauss_mean: float
    left_out: int = 0

    @property
    def is_off(self) -> bool:
        """Whether H misses its target by more than a tenth (`relative_l2`): worth a warning."""
        return self.relative_l2 > _OFF

    @property
    def is_lost(self) -> bool:
        """Whether it misses it by more than half of it: no surface of constant mean curvature any more."""
        return self.relative_l2 > _LOST


@dataclass(frozen=True)
class DistortionReport:
    """Quasi-conformal distortion Q >= 1 of the faces; means are weighted by area.

    l2 is sqrt(∫ (Q - 1)² dA / area), `energy_mean` the mean of ½ (Q + 1/Q) - 1, which is quadratic in Q - 1.
    """

    mean: float
    l2: float
    max: float
    energy_mean: float
    inside_l2: float


@dataclass(frozen=True)
class OverhangReport:
    """Faces that lean out past the vertical, their share of the area, 0 to 1, and the largest lean in degrees.

    Next to a vertical rim faces lean by an angle that falls with the edge length, although the surface does not.
    """

    count: int
    area_share: float
    largest_lean: float


@dataclass(frozen=True)
class IntersectionReport:
    """Pairs of faces that intersect: their number, the number of faces, and the first hundred pairs.

    They are counted up to about 200,000.
    """

    count: int
    face_count: int
    pairs: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class OutlineReport:
    """Distance of the boundary vertices from the drawn outline, the closed curve, in lengths.

    mean and rms are weighted by boundary length. `reverse_max` is the largest distance of a drawn point from
    the boundary: the two together bound the Hausdorff distance. The `plan` figures ignore
    heights.
    """

    max: float
    mean: float
    rms: float
    reverse_max: float
    plan_max: float
    plan_mean: float


@dataclass(frozen=True)
class SheetReport:
    """The measures of one sheet. Lengths are those of the measured points.

    A degenerate sheet (a point: f- of a sphere) has no curvature, distortion or outline distance: they are
    None. `span` is the largest horizontal distance between two boundary points, `rise` the height from lowest
    to highest. A closed sheet has the span of all its points, and no overhang, since half of it overhangs. `volume`
    lies between the sheet and the mean height of its outer rim, what is below counts as negative; in a closed sheet it
    is the volume inside.
    """

    name: str
    degenerate: bool
    area: float
    boundary_length: float
    bounding_box: tuple[Vector, Vector]
    span: float
    rise: float
    volume: float
    degenerate_faces: int
    mean_curvature: CurvatureReport | None
    distortion: DistortionReport | None
    overhang: OverhangReport | None
    intersections: IntersectionReport | None
    outline: OutlineReport | None

    def __repr__(self) -> str:
        point = ", a point" if self.degenerate else ""
        return f"SheetReport({self.name}{point}: area {self.area:.4g}, span {self.span:.4g}, rise {self.rise:.4g})"


def _vertical(up: ArrayLike) -> Array:
    given = as_numbers(up, "The vertical", MeshError)
    length = np.linalg.norm(given)
    if given.shape != (3,) or not 0.0 < length < np.inf:
        raise MeshError(f"The vertical must be a vector (3,) with a length, not {given.tolist()}.")
    return given / length


def measure_sheet(
    name: str,
    domain: Domain,
    points: Array,
    faces: Indices,
    normals: Array,
    target: float,
    *,
    degenerate: bool = False,
    corners: ArrayLike = (),
    outline: ArrayLike | Sequence[ArrayLike] | None = None,
    intersections: bool | Callable[[], bool] = True,
    up: ArrayLike = (0.0, 0.0, 1.0),
) -> SheetReport:
    """Measure `points` (n, 3), `faces` (F, 3) as the domain's, unit `normals` (n, 3), against H = `target`.

    `outline` as in `outline_segments`; `corners` and `intersections` as in `report`. Raises
    `MeshError` on arrays that do not match.
    """
    areas = face_areas_in_space(points, faces)
    sides = boundary_sides(domain, faces)
    measurable = not degenerate and bool(areas.any())
    inside = np.logical_not(np.isin(faces, sides).any(axis=1))
    vertical = _vertical(up)
    return SheetReport(
        name=name,
        degenerate=not measurable,
        area=float(areas.sum()),
        boundary_length=float(np.linalg.norm(points[sides[:, 1]] - points[sides[:, 0]], axis=1).sum()),
        bounding_box=(_vector(points.min(axis=0)), _vector(points.max(axis=0))),
        span=span(points[np.unique(sides)] if len(sides) else points, vertical),
        rise=float(np.ptp(points @ vertical)),
        volume=sheet_volume(domain, points, faces, vertical),
        degenerate_faces=int(np.count_nonzero(areas == 0)),
        mean_curvature=_curvature(points, faces, normals, target, areas, inside, corners) if measurable else None,
        distortion=_distortion(domain, points, faces, areas, inside) if measurable else None,
        overhang=_overhang(points, faces, areas, vertical) if measurable and len(sides) else None,
        intersections=_intersections(points, faces, intersections) if measurable and intersections else None,
        outline=_outline(domain, points, sides, outline, vertical) if measurable and outline is not None else None,
    )


def _vector(values: Array) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])


def _max(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if len(known) else float("nan")


def faces_near(faces: Indices, vertices: ArrayLike) -> NDArray[np.bool_]:
    """(F,) whether a face has one of these vertices, or a vertex in common with such a face."""
    near = np.isin(faces, vertices).any(axis=1)
    return np.isin(faces, faces[near]).any(axis=1)


def _curvature(
    points: Array,
    faces: Indices,
    normals: Array,
    target: float,
    areas: Array,
    inside: NDArray[np.bool_],
    corners: ArrayLike,
) -> CurvatureReport:
    left_out = faces_near(faces, corners)
    if left_out.any() and not left_out.all():
        faces, areas, inside = faces[~left_out], areas[~left_out], inside[~left_out]
    H = mean_curvature_of(points, faces, normals)
    error, mean = H - target, weighted_mean(H, areas)
    l2, usual = weighted_l2(error, areas), 1.0 / float(np.sqrt(areas.sum()))
    reference = abs(target) if abs(target) >= _SMALL * usual else usual
    return CurvatureReport(
        target=target,
        mean=mean,
        std=weighted_l2(H - mean, areas),
        l2=l2,
        linf=_max(np.abs(error)),
        reference=reference,
        relative_l2=l2 / reference,
        inside_l2=weighted_l2(error[inside], areas[inside]),
        inside_linf=_max(np.abs(error[inside])),
        gauss_mean=weighted_mean(gauss_curvature_of(points, faces, normals), areas),
        left_out=int(left_out.sum()),
    )


def _distortion(
    domain: Domain, points: Array, faces: Indices, areas: Array, inside: NDArray[np.bool_]
) -> DistortionReport:
    Q = conformal_distortion(domain, points, faces)
    return DistortionReport(
        mean=weighted_mean(Q, areas),
        l2=weighted_l2(Q - 1.0, areas),
        max=_max(Q),
        energy_mean=weighted_mean(distortion_energy(Q), areas),
        inside_l2=weighted_l2(Q[inside] - 1.0, areas[inside]),
    )


def _overhang(points: Array, faces: Indices, areas: Array, up: Array) -> OverhangReport:
    leaning = overhanging_faces(points, faces, up)
    return OverhangReport(
        count=len(leaning),
        area_share=float(areas[leaning].sum() / areas.sum()),
        largest_lean=float(np.degrees(leans(points, faces, up)[leaning].max(initial=0.0))),
    )


def _intersections(points: Array, faces: Indices, wanted: bool | Callable[[], bool]) -> IntersectionReport:
    pairs = self_intersections(points, faces, wanted if callable(wanted) else None)
    first = tuple((int(i), int(j)) for i, j in pairs[:_LISTED_PAIRS])
    return IntersectionReport(count=len(pairs), face_count=len(np.unique(pairs)), pairs=first)


def _outline(
    domain: Domain,
    points: Array,
    sides: NDArray[np.int32],
    outline: ArrayLike | Sequence[ArrayLike],
    up: Array,
) -> OutlineReport:
    starts, ends = outline_segments(domain, outline)
    lengths = np.linalg.norm(points[sides[:, 1]] - points[sides[:, 0]], axis=1)
    rim, place = np.unique(sides, return_inverse=True)
    weights = np.bincount(place.ravel(), np.repeat(0.5 * lengths, 2)).astype(np.float64)
    distances = distance_to_segments(points[rim], starts, ends)
    back = distance_to_segments(starts, *(points[sides[:, k], : starts.shape[1]] for k in (0, 1)))
    in_plan = distances
    if starts.shape[1] == 3:
        level = np.eye(3) - np.outer(up, up)
        in_plan = distance_to_segments(points[rim] @ level, starts @ level, ends @ level)
    return OutlineReport(
        max=_max(distances),
        mean=weighted_mean(distances, weights),
        rms=weighted_l2(distances, weights),
        reverse_max=_max(back),
        plan_max=_max(in_plan),
        plan_mean=weighted_mean(in_plan, weights),
    )
