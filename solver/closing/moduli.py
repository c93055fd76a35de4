"""Conformal moduli: numbers that change the edge lengths of a domain, but neither its faces nor its conditions.

Around holes and handles a surface closes only for certain conformal types of the domain (paper, Sec. 5.3.3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError, plural
from ..linalg import as_array, as_numbers
from ..signatures import checked

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Step of the central differences of edge weights, which are smooth functions of the moduli.
_STEP = 1e-5
# Cosine up to which a line counts as orthogonal.
_ORTHOGONAL = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Moduli:
    """m numbers q and the domain they make. names: of each. first: the domain at q = 0, where a search begins.

    lengths(q): the edge lengths (E,) at q (m,). ranges: the least and the largest value of each number. Lengths are
    parts of the domain's size, angles are radians, so that equal numbers mean changes of equal size.
    """

    names: tuple[str, ...]
    first: Domain
    lengths: Callable[[Array], Array]
    ranges: tuple[tuple[float, float], ...]

    def __repr__(self) -> str:
        numbers = [f"{name} {low:g} to {high:g}" for name, (low, high) in zip(self.names, self.ranges, strict=True)]
        return f"Moduli({', '.join(numbers)})"

    @classmethod
    def none(cls, domain: Domain) -> Moduli:
        return cls((), domain, lambda q: domain.edge_lengths, ())

    def domain(self, q: Array) -> Domain:
        """Raises `MeshError` where a face is turned over or flat."""
        return self.first.with_lengths(self.lengths(q)) if q.any() else self.first

    def weights(self, q: Array) -> Array:
        """(E, m) the derivatives of the cotangent weights at q."""
        columns = []
        for step in _STEP * np.eye(len(q)):
            ahead, back = self.domain(q + step).cotan_weights, self.domain(q - step).cotan_weights
            columns.append((ahead - back) / (2.0 * _STEP))
        return np.stack(columns, axis=1)

    def clipped(self, q: Array) -> Array:
        """q, or the nearest numbers in range."""
        low, high = np.array(self.ranges).reshape(-1, 2).T
        return np.clip(q, low, high)


@checked
def tube(
    domain: DomainLike,
    corners: ArrayLike,
    faces: ArrayLike,
    axis: ArrayLike,
    name: str = "length",
    stretch: tuple[float, float] = (0.05, 20.0),
    *,
    beyond: float = -np.inf,
) -> Moduli:
    """A part of a flat domain that stretches along an axis; the number is the logarithm of the stretch.

    corners: (F, 3, 2|3) of each triangle, unrolled, as of a cylinder or of glued strips. faces: (n,) of the part; its
    borders to the others must be orthogonal to the axis (2|3,), since they keep their lengths. beyond: the place along
    the axis beyond which the part stretches; up to there its border may have any shape. stretch: the least and the
    greatest. Raises `ConditionError` on corners of another shape and on slanted borders.
    """
    return tubes(domain, corners, {name: (faces, axis, beyond)}, stretch)


def _faces(given: ArrayLike, name: str, count: int) -> Int:
    faces = as_array(given, f"Faces of tube {name!r}", ConditionError)
    if faces.ndim != 1 or faces.dtype.kind not in "iu" or faces.min(initial=0) < 0 or faces.max(initial=0) >= count:
        raise ConditionError(f"Faces of tube {name!r} must be indices from 0 to {count - 1}.")
    return faces.astype(np.int64)


def tubes(
    domain: DomainLike,
    corners: ArrayLike,
    parts: Mapping[str, Sequence],
    stretch: tuple[float, float] = (0.05, 20.0),
) -> Moduli:
    """Several parts that stretch, each along its axis: name → (faces, axis) or (faces, axis, beyond); see `tube`."""
    domain = as_domain(domain)
    flat = as_numbers(corners, "Corners", ConditionError)
    if flat.shape not in ((len(domain.faces), 3, 2), (len(domain.faces), 3, 3)):
        raise ConditionError(f"Corners must have shape ({len(domain.faces)}, 3, 2 or 3), not {flat.shape}.")
    taken = np.zeros(len(domain.faces), dtype=bool)
    chosen = []
    for name, (faces, axis, *beyond) in parts.items():
        part = _faces(faces, name, len(domain.faces))
        along = as_numbers(axis, f"The axis of tube {name!r}", ConditionError)
        if along.shape != flat.shape[2:] or not np.linalg.norm(along) > 0.0:
            raise ConditionError(f"The axis of tube {name!r} must be a vector {flat.shape[2:]}, not {along.tolist()}.")
        if taken[part].any():
            raise ConditionError(f"Tube {name!r} has faces of another tube; give each face to one tube.")
        taken[part] = True
        along = along / np.linalg.norm(along)
        moving = np.maximum(flat[part] @ along, *(beyond or [-np.inf]))
        moving -= moving.min()
        _check_border(domain, moving, part)
        chosen.append((part, moving[..., None] * along))
    place = domain.half_edges[:, 0]  # of each edge as its left face has it

    def stretched(q: Array) -> Array:
        moved = flat.copy()
        for number, (part, moving) in zip(q, chosen, strict=True):
            moved[part] += np.expm1(number) * moving
        lengths = np.linalg.norm(np.roll(moved, 1, axis=1) - np.roll(moved, -1, axis=1), axis=2)
        return lengths.ravel()[place]

    low, high = np.log(stretch)
    return Moduli(tuple(parts), domain, stretched, ((float(low), float(high)),) * len(chosen))


def _check_border(domain: Domain, moving: Array, part: Int) -> None:
    """Refuse a part whose border would stretch. moving: (n, 3) how far its corners move at a stretch of two."""
    far = np.zeros((len(domain.faces), 3))
    far[part] = moving
    inside = np.zeros(len(domain.faces), dtype=bool)
    inside[part] = True
    left, right = domain.edge_faces.T
    border = np.flatnonzero((right >= 0) & (inside[left] != inside[right]))
    half = domain.half_edges[border]
    own = np.where(inside[left[border]], half[:, 0], half[:, 1])
    strain = far[own // 3, (own + 2) % 3] - far[own // 3, (own + 1) % 3]
    leaning = border[np.abs(strain) > _ORTHOGONAL * domain.edge_lengths[border]]
    if leaning.size:
        raise ConditionError(
            f"The border of the stretched part is not orthogonal to its axis at {plural('edge', leaning)}; it keeps "
            "its length, so end the part on a line across, or stretch it only from beyond there.",
            edges=leaning,
        )
