"""The isometries by which a surface continues across its sides, and the groups they generate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..surface.placement import Similarity
from .sides import SidePlane, SymmetryError

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Directions nearer than this are the same (an entry of a rotation matrix).
_SAME_TURN = 1e-2
_AROUND = list(np.ndindex(2, 2, 2))
# A lattice vector shorter than this many tolerances means that the translations have no common measure.
_COARSE = 4.0


@dataclass(frozen=True, eq=False)
class Isometry:
    """x ↦ linear x + translation, applied to the sheet f+ (sheet = 1) or f- (-1), whose normal is sheet × linear N.

    linear: (3, 3) orthogonal; faces are reversed if its determinant is negative. translation: (3,).
    """

    linear: Array
    translation: Array
    sheet: int

    @property
    def flipped(self) -> bool:
        return bool(np.linalg.det(self.linear) < 0)

    @property
    def matrix(self) -> Array:
        """(4, 4), for points as columns (x, y, z, 1)."""
        return np.block([[self.linear, self.translation[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])

    def then(self, inner: Isometry) -> Isometry:
        """This isometry after `inner`; the sheet switches if either does."""
        return Isometry(
            self.linear @ inner.linear,
            self.linear @ inner.translation + self.translation,
            self.sheet * inner.sheet,
        )

    def points(self, points: ArrayLike) -> Array:
        """Images (n, 3) of points (n, 3)."""
        return np.asarray(points, dtype=np.float64) @ self.linear.T + self.translation

    def placed(self, similarity: Similarity) -> Isometry:
        """The same copy of a surface that was placed: S C S⁻¹ for the similarity S."""
        linear = similarity.linear @ self.linear @ similarity.linear.T
        moved = similarity.scale * similarity.linear @ self.translation + similarity.translation
        return Isometry(linear, moved - linear @ similarity.translation, self.sheet)


def identity() -> Isometry:
    return Isometry(np.eye(3), np.zeros(3), 1)


def translation(vector: ArrayLike) -> Isometry:
    return Isometry(np.eye(3), np.asarray(vector, dtype=np.float64), 1)


def across(plane: SidePlane) -> Isometry:
    """The isometry by which a surface continues across a side: reflection in its plane, or inversion in its point."""
    sheet = -1 if plane.switches else 1
    if plane.normal is None:
        return Isometry(-np.eye(3), 2.0 * plane.point, sheet)
    n = plane.normal
    return Isometry(np.eye(3) - 2.0 * np.outer(n, n), 2.0 * plane.offset * n, sheet)


class CopySet:
    """Distinct copies: two are the same if turn and sheet are equal, and translations up to `tolerance`."""

    def __init__(self, tolerance: float) -> None:
        self.copies: list[Isometry] = []
        self._tolerance = tolerance
        self._turns = np.zeros((0, 3, 3))
        self._cells: dict[tuple[int, ...], list[int]] = {}

    def turn(self, copy: Isometry) -> int:
        """The number of its linear part; a new number if that part is new."""
        if len(self._turns):
            differences = np.abs(self._turns - copy.linear).max(axis=(1, 2))
            nearest = int(np.argmin(differences))
            if differences[nearest] < _SAME_TURN:
                return nearest
        self._turns = np.concatenate([self._turns, copy.linear[None]])
        return len(self._turns) - 1

    def index(self, copy: Isometry) -> int:
        """The index of the same copy, -1 if it is new."""
        turn = self.turn(copy)
        x, y, z = np.floor(copy.translation / (2.0 * self._tolerance) - 0.5).astype(np.int64).tolist()
        for i, j, k in _AROUND:
            for known in self._cells.get((turn, copy.sheet, x + i, y + j, z + k), ()):
                if np.linalg.norm(self.copies[known].translation - copy.translation) <= self._tolerance:
                    return known
        return -1

    def add(self, copy: Isometry) -> int:
        cell = np.floor(copy.translation / (2.0 * self._tolerance)).astype(np.int64)
        key = (self.turn(copy), copy.sheet, *cell.tolist())
        self._cells.setdefault(key, []).append(len(self.copies))
        self.copies.append(copy)
        return len(self.copies) - 1


def generate(
    generators: Sequence[Isometry], tolerance: float, wanted: Callable[[Isometry], bool], limit: int
) -> tuple[list[Isometry], bool]:
    """Copies reached from the identity breadth-first, across one generator after the other, while `wanted`.

    Returns them, at most `limit`, and whether those are all of them.
    """
    reached = CopySet(tolerance)
    reached.add(identity())
    at = 0
    while at < len(reached.copies):
        for generator in generators:
            copy = reached.copies[at].then(generator)
            if not wanted(copy) or reached.index(copy) >= 0:
                continue
            if len(reached.copies) == limit:
                return reached.copies, False
            reached.add(copy)
        at += 1
    return reached.copies, True


def cell(generators: Sequence[Isometry], tolerance: float, limit: int) -> tuple[list[Isometry], Array]:
    """One copy of each turn and sheet, reached breadth-first, and a basis (k, 3) of the translations of the group.

    The copies are a unit cell: translated by all integer combinations of the basis they are the whole group (the
    translations are generated by Schreier's elements, copy · generator · the copy of the same turn and sheet⁻¹).
    Raises `SymmetryError` where there are more than `limit`.
    """
    reached = CopySet(tolerance)
    reached.add(identity())
    of_class = {(reached.turn(reached.copies[0]), 1): 0}
    shifts = []
    at = 0
    while at < len(reached.copies):
        for generator in generators:
            copy = reached.copies[at].then(generator)
            key = (reached.turn(copy), copy.sheet)
            if key in of_class:
                shifts.append(copy.translation - reached.copies[of_class[key]].translation)
                continue
            if len(reached.copies) == limit:
                raise SymmetryError(
                    f"The sides generate more than {limit} directions, so the copies never repeat by translation; "
                    "give the number of copies, or a box."
                )
            of_class[key] = reached.add(copy)
        at += 1
    return reached.copies, lattice(np.array(shifts).reshape(-1, 3), tolerance)


def lattice(vectors: Array, tolerance: float) -> Array:
    """A basis (k, 3), shortest first, of the integer combinations of `vectors` (n, 3); below `tolerance` they are zero.

    Pairwise reduction; what is no integer combination of the shortest independent vectors then joins the pool.
    Raises `SymmetryError` where the vectors have no common measure.
    """
    pool = [v for v in vectors if np.linalg.norm(v) > tolerance]
    basis = np.zeros((0, 3))
    for _ in range(100):
        pool = _reduced(pool, tolerance)
        basis = _independent(pool)
        rest = [v - np.round(np.linalg.lstsq(basis.T, v, rcond=None)[0]) @ basis for v in pool]
        rest = [v for v in rest if np.linalg.norm(v) > tolerance]
        if not rest:
            break
        pool = [*basis, *rest]
    if len(basis) and np.linalg.norm(basis[0]) < _COARSE * tolerance:
        raise SymmetryError(
            "The distances of the parallel sides have no common measure, so the copies never repeat by translation; "
            "give the number of copies, or a box."
        )
    return basis


def _reduced(pool: list[Array], tolerance: float) -> list[Array]:
    """Each shortened by multiples of the shorter ones until nothing changes; sorted by length."""
    changed = True
    while changed:
        changed = False
        pool = sorted((_signed(v, tolerance) for v in pool), key=lambda v: _order(v, tolerance))
        for i, short in enumerate(pool):
            if np.linalg.norm(short) <= tolerance:
                continue
            for j in range(i + 1, len(pool)):
                times = np.round(pool[j] @ short / (short @ short) * (1.0 - 1e-6))
                if times:
                    pool[j] = pool[j] - times * short
                    changed = True
        pool = [v for v in pool if np.linalg.norm(v) > tolerance]
    return pool


def _independent(pool: list[Array]) -> Array:
    basis = np.zeros((0, 3))
    for v in pool:
        more = np.vstack([basis, v])
        if np.linalg.svd(more / np.linalg.norm(more, axis=1)[:, None], compute_uv=False)[-1] > 1e-2 and len(more) <= 3:
            basis = more
    return basis


def _signed(v: Array, tolerance: float) -> Array:
    """v or -v: the one whose first nonzero coordinate is positive."""
    first = v[np.abs(v) > tolerance]
    return -v if first.size and first[0] < 0 else v


def _order(v: Array, tolerance: float) -> tuple[float, ...]:
    """Sort key: length, then direction, both no finer than the tolerance, so that ties do not depend on rounding."""
    return (round(float(np.linalg.norm(v)) / tolerance), *(-np.round(v / tolerance)))
