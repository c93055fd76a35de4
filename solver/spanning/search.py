"""From a wish, one number, to the surface that has it: which start, which knob, and what to do where there is none."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError, Progress
from .descent import Descent, Knob, descend, with_volume
from .knobs import Crown, HeldVolume, MeanCurvature, PastTheLargest
from .problem import SpanProblem, State
from .setting import Lines

Array = NDArray[np.float64]

# Volumes up to this multiple of a half sphere's are tried for the largest H.
_FULLEST = 1.6
# A surface is blown up by this part of a half sphere's volume at once, in this number of stages at most.
_STAGE = 0.4
_STAGES = 4
# The part of the way that the volumes tried for the largest H may be wrong by, and how many are tried.
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_TRIES = 14
# Tolerance of those.
_ROUGH = 1e-4
# A mean curvature within this part of the largest counts as the largest.
_AT_LARGEST = 1e-3


@dataclass(frozen=True, eq=False)
class Wish:
    """name: "mean_curvature", "height", "volume"; heights over the mean height of the outer line."""

    name: str
    number: float


@dataclass(frozen=True, eq=False)
class Found:
    """The end of a search. largest: of H, where a larger one was asked for. upright: rim vertices that stand at the end
    of their leaning side."""

    descent: Descent
    largest: float | None = None
    upright: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Search:
    """Searches on one problem. earlier: see `descend`."""

    problem: SpanProblem
    lines: Lines
    _: KW_ONLY
    tolerance: float
    limit: int
    progress: Progress | None = None
    earlier: Descent | None = None

    def __call__(self, wish: Wish, start: State | None) -> Found:
        """The surface with the wanted number, from `start`, and from the flattest without it or if that fails."""
        name = {"mean_curvature": "_by_curvature", "height": "_by_height", "volume": "_by_volume"}[wish.name]
        found = getattr(self, name)(wish.number, start)
        if start is None or found.descent.end in ("converged", "cancelled") or found.largest is not None:
            return found
        return getattr(replace(self, earlier=None), name)(wish.number, None)

    def _descend(self, state: State, knob: Knob, tolerance: float | None = None) -> Descent:
        return descend(
            self.problem,
            state,
            knob,
            tolerance=tolerance or self.tolerance,
            limit=self.limit,
            progress=self.progress,
            earlier=self.earlier,
        )

    # --- mean curvature ------------------------------------------------------------------------

    def _by_curvature(self, H: float, start: State | None) -> Found:
        direct = self._descend(start or self.problem.start(), MeanCurvature(H))
        if direct.end in ("converged", "cancelled") or H == 0.0:
            return Found(direct)
        return self._near_largest(H)

    def _near_largest(self, H: float) -> Found:
        """Where plain minimisation runs away: by way of the largest H that the lines allow."""
        up = float(np.sign(H))
        best = self._largest(up)
        if best.end == "cancelled":
            return Found(best)
        largest = up * best.mean_curvature
        if up * H > largest * (1.0 + _AT_LARGEST) or not largest > 0.0:
            return Found(self._restarted(best, HeldVolume()), largest=best.mean_curvature)
        flatter = self._held(best, best.volume * (1.0 - np.sqrt(max(1.0 - up * H / largest, 1e-6))))
        return Found(self._restarted(flatter, PastTheLargest(H, size=self.lines.size)))

    def _largest(self, up: float) -> Descent:
        """The surface of the largest H, up = 1, or the smallest: golden section over V, each solve from the last."""
        low, high = 0.0, up * _FULLEST * self._half_sphere
        inner = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)]
        found = [self._volume_from_film(inner[0])]
        found.append(self._held(found[0], inner[1]))
        for _ in range(_TRIES):
            left, right = (_value(each, up) for each in found)
            if "cancelled" in (found[0].end, found[1].end):
                return found[-1]
            if left >= right:
                high, inner[1], found[1] = inner[1], inner[0], found[0]
                inner[0] = high - _GOLDEN * (high - low)
                found[0] = self._held(found[1], inner[0])
            else:
                low, inner[0], found[0] = inner[0], inner[1], found[1]
                inner[1] = low + _GOLDEN * (high - low)
                found[1] = self._held(found[0], inner[1])
        return max(found, key=lambda each: (_value(each, up), up * each.mean_curvature))

    def _held(self, near: Descent, volume: float) -> Descent:
        """The surface of another volume, from one nearby, if that was found."""
        if near.end != "converged":
            return self._volume_from_film(volume)
        search = replace(self, problem=near.problem)
        state = search._with_volume(near.state, volume)
        return search._descend(state, HeldVolume(), _ROUGH)

    def _restarted(self, near: Descent, knob: Knob) -> Descent:
        return replace(self, problem=near.problem)._descend(near.state, knob)

    def _volume_from_film(self, volume: float) -> Descent:
        return self._descend(self._with_volume(self.problem.start(), volume), HeldVolume(), _ROUGH)

    # --- volume --------------------------------------------------------------------------------

    def _by_volume(self, volume: float, start: State | None) -> Found:
        state = start or self.problem.start()
        cone = volume - self._cone_offset(state)
        return Found(self._descend(self._with_volume(state, cone), HeldVolume()))

    def _cone_offset(self, state: State) -> float:
        """By how much the volume over the base differs from that of the cone; it depends on the lines alone."""
        f, faces = state.f, self.problem.domain.faces
        a, b, c = (f[faces[:, k]] for k in range(3))
        area = 0.5 * np.cross(b - a, c - a)[:, 2]
        height = (a + b + c)[:, 2] / 3.0 - self._base
        return float(area @ height) - state.V

    def _with_volume(self, state: State, volume: float) -> State:
        """The state, blown up from inside to a volume: in stages, since the pressure turns with the surface."""
        first = state.V
        stages = 1 + int(min(abs(volume - first) / max(_STAGE * self._half_sphere, 1e-300), _STAGES - 1))
        for part in np.linspace(0.0, 1.0, stages + 1)[1:].tolist():
            direction = self.problem.coordinates.lift(self.problem.volume.first(state.f))
            blown = with_volume(self.problem, state, direction, first + part * (volume - first))
            if blown is None:
                raise ConditionError(f"The lines enclose no surface of volume {volume:.4g}; choose a smaller one.")
            state = blown
        return state

    @property
    def _half_sphere(self) -> float:
        """The volume of half a sphere over a circle of the lines' area."""
        return float(2.0 / 3.0 * self.lines.area**1.5 / np.sqrt(np.pi))

    # --- height --------------------------------------------------------------------------------

    @property
    def _base(self) -> float:
        """The mean height of the outer line, in the frame of the search."""
        return self.lines.base - float(self.lines.centre[2])

    def _by_height(self, height: float, start: State | None) -> Found:
        up = -1.0 if height < 0.0 else 1.0
        wanted = self._base + height
        rim = np.concatenate([line[:, 2] - self.lines.centre[2] for line in self.lines.loops])
        highest = up * float((up * rim).max())
        if up * (wanted - highest) <= 0.0 and not np.isclose(wanted, highest, rtol=0.0, atol=1e-9 * self.lines.size):
            raise ConditionError(
                f"The lines themselves reach {abs(highest - self._base):.4g} {'above' if up > 0 else 'below'} their "
                f"mean height, so no surface on them ends at {abs(height):.4g}; choose more, or mean curvature 0."
            )
        state = start or self._film(wanted, up)
        size = self.lines.size
        return Found(self._descend(state, Crown(wanted, unit=max(abs(height), 1e-6 * size), size=size, up=up)))

    def _film(self, wanted: float, up: float) -> State:
        """The harmonic surface under even pressure, Δu = -const, that just reaches the wanted height."""
        state = self.problem.start()
        pressed = np.zeros_like(state.f)
        pressed[:, 2] = up * self.problem.domain.vertex_areas
        film = self.problem.coordinates.lift(pressed)
        room = up * (wanted - state.f[self.problem.coordinates.inside, 2])
        reach = up * film[:, 2]
        stretch = float(np.min(np.maximum(room, 0.0)[reach > 0.0] / reach[reach > 0.0]))
        return self.problem.lifted(state, stretch * film)


def _value(tried: Descent, up: float) -> float:
    """up · H; minus infinity where there is no surface."""
    return up * tried.mean_curvature if tried.end == "converged" else -np.inf
