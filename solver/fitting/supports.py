"""Supports of a shell over an outline: vertices that should be at given places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..linalg import as_numbers
from .target import Target
from .targets import Anchors

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Distance of an anchor from the plan at most, by the size.
_FARTHEST = 100.0


@dataclass(frozen=True, eq=False)
class Supports:
    """Vertices (k,) of the plan, their places (k, 3) in the shell, and weights (k,)."""

    vertices: Int
    places: Array
    weights: Array

    @classmethod
    def of(
        cls,
        domain: Domain,
        anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None,
        base: float,
        line: Array,
        size: float,
    ) -> Supports | None:
        """From vertices, places and weights, with heights over `base`; None of None.

        line: the outer curve (m, 3). Raises `ConditionError` on anchors that do not fit the domain.
        """
        if anchors is None:
            return None
        numbers = [as_numbers(part, "Vertices, places and weights of anchors", ConditionError) for part in anchors]
        if len(numbers) != 3:
            raise ConditionError("Anchors are vertices (k,), places (k, 3) and weights (k,).")
        vertices, places, weights = numbers
        if vertices.ndim != 1 or places.shape != (len(vertices), 3) or weights.shape != vertices.shape:
            raise ConditionError("Anchors are vertices (k,), places (k, 3) and weights (k,).")
        bad = vertices[~np.isin(vertices, np.arange(domain.vertex_count))]
        if bad.size:
            raise ConditionError(f"There is no vertex {bad[0]:g} to anchor.", vertices=bad)
        if not (np.isfinite(places).all() and np.isfinite(weights).all() and (weights > 0.0).all()):
            raise ConditionError("Places of anchors must be finite, and their weights positive.")
        if np.linalg.norm(places - line.mean(axis=0), axis=1).max(initial=0.0) > _FARTHEST * size:
            raise ConditionError(f"An anchor lies {_FARTHEST:g} times the plan's size away from it; move it nearer.")
        return cls(vertices.astype(np.int64), places.astype(np.float64) - [0.0, 0.0, base], weights.astype(np.float64))

    def targets(self) -> list[Target]:
        """One for each weight."""
        groups = [(weight, self.weights == weight) for weight in np.unique(self.weights)]
        return [Anchors(self.vertices[of], self.places[of], weight=float(weight)) for weight, of in groups]
