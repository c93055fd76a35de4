"""The placed sheet of a fit, and its targets: functions to minimise, with their derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Shape:
    """A sheet in the world: points and unit normals N (V, 3) of the harmonic map; `size`, a length to divide by.

    rim: sorted boundary vertices with free normals; domain: of the plan. periods: (k, 3) the gaps of the sheet
    around the holes of the domain.
    """

    domain: Domain
    rim: Int
    points: Array
    normals: Array
    size: float
    periods: Array = field(default_factory=lambda: np.zeros((0, 3)))


@dataclass(frozen=True, eq=False)
class Partials:
    """A value, and its derivatives by the points, by the normals (V, 3) and by the periods (k, 3) of a shape."""

    value: float
    by_points: Array
    by_normals: Array
    by_periods: Array

    @classmethod
    def of(
        cls,
        shape: Shape,
        value: float = 0.0,
        by_points: Array | None = None,
        by_normals: Array | None = None,
        by_periods: Array | None = None,
    ) -> Partials:
        """Missing derivatives are zero."""
        return cls(
            value,
            np.zeros_like(shape.points) if by_points is None else by_points,
            np.zeros_like(shape.normals) if by_normals is None else by_normals,
            np.zeros_like(shape.periods) if by_periods is None else by_periods,
        )

    def __add__(self, other: Partials) -> Partials:
        return Partials(
            self.value + other.value,
            self.by_points + other.by_points,
            self.by_normals + other.by_normals,
            self.by_periods + other.by_periods,
        )

    def times(self, factor: float) -> Partials:
        return Partials(
            factor * self.value, factor * self.by_points, factor * self.by_normals, factor * self.by_periods
        )


@dataclass(frozen=True, eq=False)
class Curvature:
    """The Gauss–Newton second derivative of a target, never negative: a sum of three kinds of squares.

    vertices (k,), metrics (k, 3, 3): <d_i, M_i d_i> of moving points. stiffness: (V, V), of turning normals, each
    component alone. rows: residuals whose derivatives count squared.
    """

    vertices: Int = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    metrics: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    stiffness: sp.csr_array | None = None
    rows: tuple[Partials, ...] = ()


@dataclass(frozen=True, eq=False)
class Target:
    """A value ½ |residual|², without units, of a shape.

    weight: a factor in the sum. `partials(shape)`: value and derivatives; `curvature(shape)`: the model of its second
    derivative, which only speeds a search up; `distance(shape)`: how far from it, a length where it is one,
    else a pure number.
    """

    weight: float = field(default=1.0, kw_only=True)

    label = "target"

    def partials(self, shape: Shape) -> Partials:
        raise NotImplementedError

    def curvature(self, shape: Shape) -> Curvature:
        raise NotImplementedError

    def distance(self, shape: Shape) -> float:
        raise NotImplementedError
