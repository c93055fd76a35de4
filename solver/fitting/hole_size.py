"""The size of a hole with which a ring-shaped plan fits its curves.

A ring has one conformal modulus, and a shell is conformal to its plan. So of all sizes of the hole one fits the curves,
and with the others the rim stays off them. Near it the root of the fit's value falls and rises linearly with the
logarithm of the size, so a few fits over a coarse mesh of the plan find it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import CmcError
from ..meshing.mesher import mesh_plan
from ..spanning.curves import enclosed
from .fit import Fit, FitStatus
from .targets import RimOnCurve

Array = NDArray[np.float64]

# Vertices of the coarse mesh; part of the plan's size up to which it counts as level.
_COUNT = 250
_LEVEL = 1e-3
# Changes of the logarithm of the size tried first, until one divides the root by `_LESS`: far from the best size the
# root hardly changes. Then a finer one around it.
_FIRST = (-0.15, 0.15, -0.3, 0.3, -0.6, 0.6)
_LESS = 1.5
_STEP = 0.1
# The range of the logarithm, and the most secants.
_RANGE = 1.6
_SECANTS = 4
# Part of the size within which the rim must come to its curve, which a coarse mesh reaches.
_NEAR = 7.5e-3

FitOver = Callable[[Domain, Array, list[Array]], Fit]
"""A fit over another plan, positions (V, 2), with a curve (m, 3) for each of its loops."""


@dataclass(frozen=True)
class HoleSize:
    """Mean distances of the hole's rim from its middle: as it is, and as it would fit."""

    drawn: float
    fitting: float

    @property
    def sentence(self) -> str:
        word = "large" if self.fitting < self.drawn else "small"
        radii = f"about {self.fitting:.3g} in place of {self.drawn:.3g}"
        return f"the hole is too {word} for this shell: make its radius {radii}"


@dataclass(frozen=True)
class _Trial:
    log: float
    root: float
    is_near: bool


def fitting_hole(lines: list[Array], curves: list[Array], size: float, fit_over: FitOver) -> HoleSize | None:
    """The size of the hole with which a ring-shaped plan fits its curves; None where it is not found.

    lines: (n, 3) the outline of the plan and its hole, curves: (m, 3) those to fit, in the same order; size: of the
    outer one.
    """
    outline, hole = lines
    heights = np.concatenate(lines)[:, 2]
    if np.ptp(heights) > _LEVEL * size:
        return None
    search = _Search(outline[:, :2], hole[:, :2], curves, size, fit_over)
    try:
        best = search.run()
    except CmcError:  # such as a hole that grew through the outline
        return None
    drawn = float(np.linalg.norm(hole[:, :2] - hole[:, :2].mean(axis=0), axis=1).mean())
    return HoleSize(drawn, drawn * float(np.exp(best.log))) if best.is_near else None


@dataclass(frozen=True)
class _Search:
    outline: Array
    hole: Array
    curves: list[Array]
    size: float
    fit_over: FitOver

    def run(self) -> _Trial:
        """Secants of the root of the value, which has the same sign on one side of the best size."""
        drawn = self.at(0.0)
        best = drawn
        for log in _FIRST:
            best = min(best, self.at(log), key=_by_root)
            if _LESS * best.root < drawn.root:
                break
        trials = [best, self.at(best.log + np.copysign(_STEP, best.log))]
        if trials[1].root > best.root:
            trials.append(self.at(best.log - np.copysign(_STEP, best.log)))
        for k in range(_SECANTS):
            first, second = sorted(trials, key=_by_root)[:2]
            if first.is_near and trials[-1] is not first:
                return first
            # beyond the best size the root has the other sign: try the zero between the two, then the one outside
            signs = (1.0, -1.0) if k % 2 == 0 else (-1.0, 1.0)
            logs = [_zero(first, second, sign) for sign in signs]
            new = [log for log in logs if abs(log) < _RANGE and all(abs(log - t.log) > 5e-3 for t in trials)]
            if not new:
                break
            trials.append(self.at(new[0]))
        return min(trials, key=_by_root)

    def at(self, log: float) -> _Trial:
        middle = self.hole.mean(axis=0)
        hole = middle + np.exp(log) * (self.hole - middle)
        left = abs(enclosed(self.outline)) - abs(enclosed(hole))
        if not left > 0.0:
            raise CmcError("The hole has grown through the outline.")
        edge = float(np.sqrt(left / np.sqrt(0.75) / _COUNT))
        mesh = mesh_plan(self.outline, [hole], max_edge=edge)
        domain = Domain.from_positions(mesh.positions, mesh.triangles)
        areas = [abs(enclosed(mesh.positions[loop])) for loop in domain.boundary_loops]
        order = [0, 1] if areas[0] > areas[1] else [1, 0]
        fit = self.fit_over(domain, mesh.positions, [self.curves[k] for k in order])
        if fit.status is FitStatus.CANCELLED:
            raise CmcError("The search for the size of the hole was cancelled.")
        near = fit.distances.get(RimOnCurve.label, np.inf) <= _NEAR * self.size
        return _Trial(log, float(np.sqrt(fit.value)), near)


def _by_root(trial: _Trial) -> float:
    return trial.root


def _zero(first: _Trial, second: _Trial, sign: float) -> float:
    """Where the line through two roots is zero; sign -1 if they lie on different sides of it."""
    rise = first.root - sign * second.root
    return first.log - first.root * (first.log - second.log) / rise if rise else np.inf
