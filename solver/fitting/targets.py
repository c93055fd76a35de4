"""The targets of a fit: functions to minimise, each with its partial derivatives.

`fit` adds them up with weights. A target that is met exactly has the value zero, so that several can be met at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.sphere import dot, inner
from ..linalg import graph_laplacian
from ..measure.volume import volume_over
from ..surface.adjoint import boundary_shares
from .curves import Curve
from .target import Curvature, Partials, Shape, Target

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Sample vertices for the curvature model of a whole surface.
_SAMPLES = 200


@dataclass(frozen=True, eq=False)
class GaussMap(Target):
    """½ ∫ |N - N_φ|² over the domain of area one; N_φ: `normals` (V, 3) (paper, Sec. 5.2)."""

    normals: Array
    label = "Gauss map"

    def partials(self, shape: Shape) -> Partials:
        shares = shape.domain.vertex_areas / shape.domain.area
        miss = shape.normals - self.normals
        value = 0.5 * float(np.sum(shares * dot(miss, miss)[:, 0]))
        return Partials.of(shape, value, by_normals=shares[:, None] * miss)

    def curvature(self, shape: Shape) -> Curvature:
        return Curvature(stiffness=diagonal(shape.domain.vertex_areas / shape.domain.area))

    def distance(self, shape: Shape) -> float:
        """Root mean square of |N - N_φ|."""
        return _root_of_twice(self.partials(shape).value)


@dataclass(frozen=True, eq=False)
class SmoothRim(Target):
    """½ ∮ |dN₀|² along the boundary edges, times their length (no unit): the variation of the normals there."""

    label = "smooth rim"

    def partials(self, shape: Shape) -> Partials:
        by_normals = self._laplacian(shape.domain) @ shape.normals
        return Partials.of(shape, 0.5 * inner(shape.normals, by_normals), by_normals=by_normals)

    def curvature(self, shape: Shape) -> Curvature:
        return Curvature(stiffness=self._laplacian(shape.domain))

    def _laplacian(self, domain: Domain) -> sp.csr_array:
        lengths = domain.edge_lengths[domain.boundary_edges]
        return graph_laplacian(domain.edges[domain.boundary_edges], lengths.sum() / lengths, domain.vertex_count)

    def distance(self, shape: Shape) -> float:
        return _root_of_twice(self.partials(shape).value)


@dataclass(frozen=True, eq=False)
class MinimalChange(Target):
    """½ mean |N₀ - M|² over the boundary, M: `normals` (n, 3) at `shape.rim`."""

    normals: Array
    label = "change of the rim's normals"

    def partials(self, shape: Shape) -> Partials:
        miss = shape.normals[shape.rim] - self.normals
        by_normals = np.zeros_like(shape.normals)
        by_normals[shape.rim] = miss / len(miss)
        return Partials.of(shape, 0.5 * float(np.mean(dot(miss, miss))), by_normals=by_normals)

    def curvature(self, shape: Shape) -> Curvature:
        at_rim = np.zeros(len(shape.normals))
        at_rim[shape.rim] = 1.0 / len(shape.rim)
        return Curvature(stiffness=diagonal(at_rim))

    def distance(self, shape: Shape) -> float:
        return _root_of_twice(self.partials(shape).value)


@dataclass(frozen=True, eq=False)
class RimOnCurve(Target):
    """½ mean squared distance of the rim from a curve, and of the curve from the rim, over the size squared.

    From every rim vertex, weighted by the plan's rim, to its closest point on the curve, so that the rim may slide
    along it. The way back keeps the rim from gathering on a part of the curve. With `free_heights` distances are
    horizontal.
    vertices: (n,) along the rim, in order, closed as the curve is; of a piece of the rim the first and the last lie at
    the ends of an open curve, and its way back counts by its part of the rim.
    """

    curve: Curve
    vertices: Int
    free_heights: bool = False
    label = "rim on curve"

    def partials(self, shape: Shape) -> Partials:
        by_points = np.zeros_like(shape.points)
        points = self._seen(shape.points[self.vertices])
        there = points - self._nearest(points)
        weights = boundary_shares(shape.domain)[self.vertices]
        value = float(np.sum(weights * dot(there, there)[:, 0]))
        np.add.at(by_points, self.vertices, weights[:, None] * there)
        back = Curve(points, self._curve.closed).closest(self._curve.samples)
        miss = self._curve.samples - back.points
        part = 1.0 if self._curve.closed else float(weights.sum())
        value += part * float(np.mean(dot(miss, miss)))
        pull = part * miss / len(miss)
        np.subtract.at(by_points, self.vertices[back.start], (1.0 - back.along)[:, None] * pull)
        np.subtract.at(by_points, self.vertices[back.end], back.along[:, None] * pull)
        scale = 1.0 / shape.size**2
        return Partials.of(shape, 0.5 * scale * value, scale * by_points)

    def curvature(self, shape: Shape) -> Curvature:
        """Along the curve a point moves freely, but for the ends; the way back counts as much as the way there."""
        closest = self._curve.closest(self._seen(shape.points[self.vertices]))
        along = self._curve.points[closest.end] - self._curve.points[closest.start]
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
        if not self._curve.closed:
            along[[0, -1]] = 0.0
        across = self._seen(np.eye(3)) - along[:, :, None] * along[:, None, :]
        shares = 2.0 * boundary_shares(shape.domain)[self.vertices] / shape.size**2
        return Curvature(self.vertices, shares[:, None, None] * across)

    @cached_property
    def _curve(self) -> Curve:
        return Curve(self._seen(self.curve.points), closed=self.curve.closed)

    def _seen(self, points: Array) -> Array:
        return points * [1.0, 1.0, 0.0] if self.free_heights else points

    def _nearest(self, points: Array) -> Array:
        """(n, 3) the places on the curve for the rim's points."""
        nearest = self._curve.closest(points).points
        if not self._curve.closed:
            nearest[[0, -1]] = self._curve.points[[0, -1]]
        return nearest

    def distances(self, shape: Shape) -> Array:
        """(n,) of the rim's vertices from their places on the curve."""
        points = self._seen(shape.points[self.vertices])
        return np.linalg.norm(points - self._nearest(points), axis=1)

    def distance(self, shape: Shape) -> float:
        """The largest distance of a rim vertex from the curve, and of the curve from the rim."""
        points = self._seen(shape.points[self.vertices])
        back = self._curve.samples - Curve(points, self._curve.closed).closest(self._curve.samples).points
        return max(float(self.distances(shape).max()), float(np.linalg.norm(back, axis=1).max()))


@dataclass(frozen=True, eq=False)
class Anchors(Target):
    """½ Σ |x_i - a_i|² / size² at vertices (n,), a: `places` (n, 3), in the coordinates of `axes` only."""

    vertices: Int
    places: Array
    axes: tuple[float, float, float] = (1.0, 1.0, 1.0)
    label = "anchors"

    def partials(self, shape: Shape) -> Partials:
        miss = (shape.points[self.vertices] - self.places) * self.axes
        by_points = np.zeros_like(shape.points)
        np.add.at(by_points, self.vertices, miss / shape.size**2)
        value = 0.5 * float(np.sum(dot(miss, miss))) / shape.size**2
        return Partials.of(shape, value, by_points)

    def curvature(self, shape: Shape) -> Curvature:
        metric = np.diag(np.square(self.axes)) / shape.size**2
        return Curvature(self.vertices, np.broadcast_to(metric, (len(self.vertices), 3, 3)))

    def distance(self, shape: Shape) -> float:
        miss = (shape.points[self.vertices] - self.places) * self.axes
        return float(np.sqrt(dot(miss, miss).max()))


@dataclass(frozen=True, eq=False)
class _Quantity(Target):
    """½ (q / wanted - 1)² of one number q of the shape; `wanted` is not zero."""

    wanted: float

    def quantity(self, shape: Shape) -> tuple[float, Array]:
        """q and its derivative by the points (V, 3)."""
        raise NotImplementedError

    def partials(self, shape: Shape) -> Partials:
        q, derivative = self.quantity(shape)
        miss = q / self.wanted - 1.0
        return Partials.of(shape, 0.5 * miss**2, (miss / self.wanted) * derivative)

    def curvature(self, shape: Shape) -> Curvature:
        return Curvature(rows=(Partials.of(shape, by_points=self.quantity(shape)[1] / self.wanted),))

    def distance(self, shape: Shape) -> float:
        return abs(self.quantity(shape)[0] - self.wanted)


@dataclass(frozen=True, eq=False)
class Crown(_Quantity):
    """The height of the highest point above the plan's plane z = 0."""

    label = "crown height"

    def quantity(self, shape: Shape) -> tuple[float, Array]:
        top = int(np.argmax(shape.points[:, 2]))
        derivative = np.zeros_like(shape.points)
        derivative[top, 2] = 1.0
        return float(shape.points[top, 2]), derivative


@dataclass(frozen=True, eq=False)
class Volume(_Quantity):
    """The volume between the surface and the plane z = 0: Σ_f (area seen from above) × (mean height)."""

    label = "volume"

    def quantity(self, shape: Shape) -> tuple[float, Array]:
        faces = shape.domain.faces
        a, b, c = (shape.points[faces[:, k]] for k in range(3))
        area = 0.5 * _turn(b - a, c - a)
        height = (a[:, 2] + b[:, 2] + c[:, 2]) / 3.0
        derivative = np.zeros_like(shape.points)
        for k, (p, q) in enumerate(((b, c), (c, a), (a, b))):
            # the area changes by ½ (q - p)^⊥ as its corner opposite p → q moves
            part = np.column_stack([p[:, 1] - q[:, 1], q[:, 0] - p[:, 0]]) * (0.5 * height)[:, None]
            np.add.at(derivative, faces[:, k], np.column_stack([part, area / 3.0]))
        return volume_over(shape.points, faces, np.array([0.0, 0.0, 1.0])), derivative


@dataclass(frozen=True, eq=False)
class Area(_Quantity):
    """The area of the surface."""

    label = "area"

    def quantity(self, shape: Shape) -> tuple[float, Array]:
        faces = shape.domain.faces
        a, b, c = (shape.points[faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        double = np.linalg.norm(normal, axis=1)
        unit = normal / np.maximum(double, 1e-300)[:, None]
        derivative = np.zeros_like(shape.points)
        for k, (p, q) in enumerate(((b, c), (c, a), (a, b))):
            np.add.at(derivative, faces[:, k], 0.5 * np.cross(unit, q - p))
        return 0.5 * float(double.sum()), derivative


@dataclass(frozen=True, eq=False)
class NearSurface(Target):
    """½ mean squared distance of the vertices, weighted by area, from a surface, over the size squared.

    closest: points (n, 3) to the closest points of the surface.
    """

    closest: Callable[[Array], Array]
    label = "near surface"

    def partials(self, shape: Shape) -> Partials:
        shares = shape.domain.vertex_areas / shape.domain.area
        miss = shape.points - self.closest(shape.points)
        value = 0.5 * float(np.sum(shares * dot(miss, miss)[:, 0])) / shape.size**2
        return Partials.of(shape, value, shares[:, None] * miss / shape.size**2)

    def curvature(self, shape: Shape) -> Curvature:
        """At sample vertices, across the surface; along it they slide."""
        domain = shape.domain
        some = np.arange(0, domain.vertex_count, max(1, domain.vertex_count // _SAMPLES))
        shares = domain.vertex_areas[some] / domain.vertex_areas[some].sum() / shape.size**2
        N = shape.normals[some]
        return Curvature(some, shares[:, None, None] * N[:, :, None] * N[:, None, :])

    def distance(self, shape: Shape) -> float:
        miss = shape.points - self.closest(shape.points)
        return float(np.sqrt(dot(miss, miss).max()))


@dataclass(frozen=True, eq=False)
class Closed(Target):
    """½ Σ |period|² / size²: the surface closes around the holes of the domain."""

    label = "period"

    def partials(self, shape: Shape) -> Partials:
        value = 0.5 * float(np.sum(np.square(shape.periods))) / shape.size**2
        return Partials.of(shape, value, by_periods=shape.periods / shape.size**2)

    def curvature(self, shape: Shape) -> Curvature:
        units = np.eye(shape.periods.size).reshape(-1, *shape.periods.shape) / shape.size
        return Curvature(rows=tuple(Partials.of(shape, by_periods=unit) for unit in units))

    def distance(self, shape: Shape) -> float:
        """The longest period."""
        return float(np.sqrt(dot(shape.periods, shape.periods).max(initial=0.0)))


@dataclass(frozen=True, eq=False)
class TiltBounds(Target):
    """½ ∮ (distance of <N₀, up> from [sin least, sin most])² along the boundary of length one.

    least, most: radians, of the tilt of the tangent planes along the rim: 0 a vertical wall, ½ π flat (the angle of
    `conditions.binormal` on a level plan). up: (3,).
    """

    least: float
    most: float
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    label = "tilt bounds"

    def partials(self, shape: Shape) -> Partials:
        shares = boundary_shares(shape.domain)[shape.rim]
        excess = self._excess(shape)
        by_normals = np.zeros_like(shape.normals)
        by_normals[shape.rim] = (shares * excess)[:, None] * np.array(self.up)
        return Partials.of(shape, 0.5 * float(np.sum(shares * excess**2)), by_normals=by_normals)

    def curvature(self, shape: Shape) -> Curvature:
        shares = np.zeros(len(shape.normals))
        shares[shape.rim] = boundary_shares(shape.domain)[shape.rim] * (self._excess(shape) != 0.0)
        return Curvature(stiffness=diagonal(shares))

    def distance(self, shape: Shape) -> float:
        """The largest angle of a tilt outside the bounds, radians."""
        tilt = np.arcsin(np.clip(self._rise(shape), -1.0, 1.0))
        return float(np.abs(tilt - np.clip(tilt, self.least, self.most)).max())

    def _rise(self, shape: Shape) -> Array:
        return shape.normals[shape.rim] @ np.array(self.up)

    def _excess(self, shape: Shape) -> Array:
        rise = self._rise(shape)
        return rise - np.clip(rise, np.sin(self.least), np.sin(self.most))


def _root_of_twice(value: float) -> float:
    """sqrt(2 value) of a sum of squares, which rounding may leave negative."""
    return float(np.sqrt(max(2.0 * value, 0.0)))


def diagonal(values: Array) -> sp.csr_array:
    """The stiffness of values (V,), one for each vertex."""
    return sp.csr_array(sp.diags_array(values))


def _turn(u: Array, v: Array) -> Array:
    """u × v seen from above."""
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
