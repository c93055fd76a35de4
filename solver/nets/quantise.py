"""Whole numbers of panels: the coordinates nearest to w on which the lines close.

In units of the spacing, odd zeros lie in the middle of a cell, at (ℤ + ½)², the jumps across loop paths are whole, and
sides that are curvature lines lie on a line of the net. Each is a row of conditions B x = b on the unknowns of one
coordinate. What it costs, the energy of the least change of x with B x = b, is a quadratic form of b - B x; Babai's
rounding, one condition after the other, and small steps from there find a b of nearly the least cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .isothermic import Isothermic
from .sides import LineSide

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Spacings that are tried, as parts of the wanted one, and the cost of a departure by 100 % beside the rounding's.
_SPACINGS = np.linspace(0.85, 1.18, 67)
_DEPARTURE = 2e-3
# The most numbers for which pairs of them are changed, too.
_MOST_PAIRED = 24
# Lines on sides lie this part of the spacing outside, and no vertex is nearer to a line than the second number.
_OUTSIDE = 1e-7
_APART = 1e-9


@dataclass(frozen=True, eq=False)
class Quantised:
    """w in units of the spacing; lines are at whole numbers.

    unknowns: (V + k, 2) as in `Isothermic`. spacings: (2,) of the two coordinates, in units of w. rounding: the root
    mean square of the change of direction, in radians.
    """

    isothermic: Isothermic
    unknowns: Array
    spacings: Array
    rounding: float

    @property
    def values(self) -> Array:
        """(n, 2) at the cut vertices."""
        return self.isothermic.cut.transfer @ self.unknowns


@dataclass(frozen=True, eq=False)
class Conditions:
    """Conditions on one coordinate: rows B (m, V + k), the part (m,) of b that is not whole, 0 or ½.

    places: (m,) B t, how each value changes when w grows by 1 everywhere.
    """

    rows: Array
    offsets: Array
    places: Array

    @classmethod
    def of(cls, isothermic: Isothermic, sides: list[LineSide], axis: int) -> Conditions:
        """Those of the zeros, of the loop paths and of the sides along which coordinate `axis` is constant."""
        cut = isothermic.cut
        n, k = cut.domain.vertex_count, len(cut.signs)
        zeros = np.zeros((len(cut.zeros), n + k))
        zeros[np.arange(len(zeros)), cut.zeros] = 1.0
        jumps = np.zeros((k, n + k))
        jumps[np.arange(k), n + np.arange(k)] = 1.0
        means = [side.mean(cut.transfer) for side in sides if side.axis == axis]
        rows = np.vstack([zeros, jumps, *means])
        offsets = np.zeros(len(rows))
        offsets[: len(zeros)] = 0.5
        return cls(rows, offsets, rows @ cut.translation)


class _Rounding:
    """Whole numbers for conditions on the coordinate x, at any spacing; nothing is factored again."""

    def __init__(self, isothermic: Isothermic, conditions: Conditions, x: Array) -> None:
        self.conditions, self.x = conditions, x
        self.translation = isothermic.cut.translation
        self.responses = isothermic.responses(conditions.rows)
        gram = conditions.rows @ self.responses
        gram += 1e-12 * np.trace(gram) * np.eye(len(gram))
        self.inverse = np.linalg.inv(gram)
        self.form = self.inverse
        places = conditions.places
        self.anchor = -1
        if np.abs(places).max() > 0.5:
            along = self.inverse @ places
            self.form = self.inverse - np.outer(along, along) / (places @ along)
            self.anchor = int(np.flatnonzero(np.abs(places) > 0.5)[np.argmin(np.abs(places)[np.abs(places) > 0.5])])
        self.others = np.flatnonzero(np.arange(len(places)) != self.anchor)
        part = self.form[np.ix_(self.others, self.others)]
        part += 1e-12 * np.trace(part) * np.eye(len(part))
        self.lattice = _Lattice(np.linalg.cholesky(part).T)

    def at(self, spacing: float) -> tuple[float, Array]:
        """The cost, and the whole numbers (m,) in the place where the anchor's is 0."""
        v = self._wanted(spacing)
        numbers = np.zeros(len(v))
        numbers[self.others] = self.lattice.nearest(v[self.others])
        off = spacing * (numbers - v)
        return float(off @ self.form @ off), numbers

    def moved(self, numbers: Array, spacing: float) -> Array:
        """x with the conditions met, in units of w."""
        off = spacing * (numbers - self._wanted(spacing))
        moved = self.x - spacing * self._shift(spacing) * self.translation + self.responses @ (self.form @ off)
        places = self.conditions.places
        if self.anchor >= 0:
            along = self.inverse @ places
            moved = moved + (along @ off) / (places @ along) * self.translation
        return moved

    def _shift(self, spacing: float) -> float:
        """The translation, in units of the spacing, that brings the anchor to its place."""
        if self.anchor < 0:
            return 0.0
        now = self.conditions.rows[self.anchor] @ self.x / spacing - self.conditions.offsets[self.anchor]
        return float(now / self.conditions.places[self.anchor])

    def _wanted(self, spacing: float) -> Array:
        """The numbers (m,) that would cost nothing, the anchor's 0."""
        values = self.conditions.rows @ self.x / spacing - self.conditions.offsets
        return values - self._shift(spacing) * self.conditions.places


class _Lattice:
    """Whole numbers (m,) nearest to given ones in the norm of an upper triangular matrix (m, m)."""

    def __init__(self, upper: Array) -> None:
        self.upper = upper
        m = len(upper)
        unit = np.eye(m)
        i, j = np.triu_indices(m, 1)
        pairs = [unit[i] + unit[j], unit[i] - unit[j]] if m <= _MOST_PAIRED else []
        steps = np.concatenate([unit, *pairs])
        self.steps = np.concatenate([steps, -steps])
        self.changes = self.steps @ upper.T

    def nearest(self, v: Array) -> Array:
        """Babai's nearest plane, then steps of one number or two by ±1 for as long as one of them comes nearer."""
        upper, numbers = self.upper, np.rint(v)
        for i in range(len(v) - 1, -1, -1):
            pull = upper[i, i + 1 :] @ (numbers[i + 1 :] - v[i + 1 :])
            numbers[i] = np.rint(v[i] - pull / upper[i, i])
        off = upper @ (numbers - v)
        while len(v):
            squares = ((off + self.changes) ** 2).sum(axis=1)
            best = int(np.argmin(squares))
            if squares[best] >= (1.0 - 1e-9) * (off @ off):
                break
            numbers = numbers + self.steps[best]
            off = upper @ (numbers - v)
        return numbers


def quantised(isothermic: Isothermic, spacing: float, sides: list[LineSide], *, exact: bool = False) -> Quantised:
    """The coordinates of whole numbers near a spacing in units of w. exact: as they are, in units of the spacing.

    The spacing of each coordinate may be up to 18 % off, wherever that keeps the directions better.
    """
    unknowns, spacings, cost = np.empty_like(isothermic.unknowns), np.full(2, spacing), 0.0
    cotans = isothermic.cut.domain.corner_cotans
    total = float((0.5 * cotans * np.abs(isothermic.omega) ** 2).sum())
    for axis in (0, 1):
        x = isothermic.unknowns[:, axis]
        conditions = Conditions.of(isothermic, sides, axis)
        has_place = bool((np.abs(conditions.places) > 0.5).any())
        if len(conditions.rows) and not exact:
            rounding = _Rounding(isothermic, conditions, x)
            found = [rounding.at(spacing * part) for part in _SPACINGS]
            costs = np.array([one for one, _ in found]) / total + _DEPARTURE * np.log(_SPACINGS) ** 2
            best = int(np.argmin(costs))
            spacings[axis] = spacing * _SPACINGS[best]
            x = rounding.moved(found[best][1], spacings[axis])
            cost += found[best][0]
        x = x / spacings[axis]
        unknowns[:, axis] = x if has_place and not exact else _centred(isothermic, x)
    if not exact:
        unknowns = _settled(isothermic, unknowns, sides)
    return Quantised(isothermic, unknowns, spacings, float(np.sqrt(cost / total)))


def _centred(isothermic: Isothermic, x: Array) -> Array:
    """x moved so that the outermost lines are as far from the extremes as possible."""
    values = isothermic.cut.transfer @ x
    low, high = float(values.min()), float(values.max())
    half = 0.5 * (high - low)
    middle = 0.0 if half % 1.0 >= (half + 0.5) % 1.0 else 0.5
    return x + (middle - 0.5 * (low + high)) * isothermic.cut.translation


def _settled(isothermic: Isothermic, unknowns: Array, sides: list[LineSide]) -> Array:
    """Jumps and zeros at their numbers exactly, sides on their lines, and no other vertex on a line."""
    cut = isothermic.cut
    n = cut.domain.vertex_count
    x = unknowns.copy()
    x[n:] = np.rint(x[n:])
    x[cut.zeros] = np.rint(x[cut.zeros] - 0.5) + 0.5
    for side in sides:
        values = (cut.transfer @ x)[:, side.axis]
        number = np.rint(values[side.cut_vertices].mean())
        touching = np.isin(cut.faces, side.cut_vertices).any(axis=1)
        inwards = np.sign(values[cut.faces[touching]].mean() - number)
        target = number + inwards * _OUTSIDE
        vertices, signs = cut.source[side.cut_vertices], cut.same[side.cut_vertices]
        x[vertices, side.axis] += signs * (target - values[side.cut_vertices])
    near = np.abs(x[:n] - np.rint(x[:n])) < _APART
    x[:n] += np.where(near, 2.0 * _APART, 0.0)
    return x
