"""Newton's method for spanning surfaces: projected conjugate gradients and a line search.

Three ways to choose among the surfaces of one rim (see `knobs`): H is given, and D - 2H V is minimised freely; V is
given, H is the multiplier and each step keeps V; or another number is given, and each step changes V by an amount dV
that brings it nearer. With m = M V' the step of the last two is (dV / <V', m>) m and a part that keeps V.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import Progress
from .coordinates import Step
from .linearised import Linearised
from .problem import SpanProblem, State

Array = NDArray[np.float64]

# Steps of the inner iteration; its relative accuracy at most, and at the end in units of what is still needed.
_CG_LIMIT = 30
_FORCING = 0.1
_SPARED = 0.1
# Armijo's constant; the shortest step; rounding of the energy, as a part of it.
_DECREASE = 1e-4
_SHORTEST = 1e-4
_ROUNDING = 1e-12
# A free minimisation has no end where it has met this many directions of negative curvature, and the energy is this
# multiple of that of the flat start.
_NEGATIVE = 3
_RUNAWAY = 1.5
# Gaps that shrink below this part of themselves will not grow again.
_CROWDED = 1e-2


class Iterate(NamedTuple):
    """One step: energy D, residual, volume V, multiplier H, back-solves so far, length of the step."""

    energy: float
    residual: float
    volume: float
    mean_curvature: float
    solves: int
    step: float


@dataclass(frozen=True, eq=False)
class Descent:
    """The state reached, how it ended (converged, iteration limit, stalled, crowded, neck, runaway, cancelled), and
    the way there.

    problem: the one that was solved, on the plan that the state has reached or nearly.
    """

    problem: SpanProblem
    state: State
    mean_curvature: float
    volume: float
    end: str
    history: list[Iterate]

    @property
    def residual(self) -> float:
        return self.history[-1].residual


class Knob:
    """The number that chooses: by default none, so that H is given.

    mean_curvature: the given H, or None where it is the multiplier.
    """

    mean_curvature: float | None = 0.0

    def volume_change(self, here: Linearised, residual: float, volume: float) -> float:
        """dV of the next step."""
        return 0.0

    def reached(self, here: Linearised, volume: float) -> bool:
        """Whether the number has its wanted value."""
        return True


def descend(
    problem: SpanProblem,
    state: State,
    knob: Knob,
    *,
    tolerance: float = 1e-6,
    limit: int = 60,
    progress: Progress | None = None,
) -> Descent:
    """The critical surface that the knob chooses, from `state`.

    residual: sqrt(<r, M r> / 2 D) of the gradient r, without unit. limit: of steps.
    """
    history: list[Iterate] = []
    negative, length, first = 0, 1.0, state.D
    while True:
        here = Linearised(problem, state, knob.mean_curvature)
        volume = state.V
        keep = _keeper(here, knob)
        z = keep(here.precondition(here.gradient))
        residual = float(np.sqrt(max(here.gradient(z), 0.0) / (2.0 * state.D)))
        history.append(Iterate(state.D, residual, volume, here.H, problem.coordinates.solves, length))
        end = ""
        if residual < tolerance and knob.reached(here, volume):
            end = "converged"
        elif progress is not None and progress(len(history) - 1, residual) is False:
            end = "cancelled"
        elif negative >= _NEGATIVE and _RUNAWAY * first < state.D and knob.mean_curvature is not None:
            end = "runaway"
        elif problem.has_closed_neck(state):
            end = "neck"
        elif problem.rim.stretches(state.x)[0] < _CROWDED:
            end = "crowded"
        elif len(history) > limit:
            end = "iteration limit"
        if end:
            return Descent(problem, state, here.H, volume, end, history)
        change = knob.volume_change(here, residual, volume)
        forcing = max(min(_FORCING, np.sqrt(residual)), _SPARED * tolerance / max(residual, 1e-300))
        step, bent = _newton_step(here, keep, change, forcing)
        negative += bent
        moved, length = _line_search(here, state, volume, step, change, knob.mean_curvature is None)
        if moved is None:
            return Descent(problem, state, here.H, volume, "stalled", history)
        state = moved
        if problem.is_far(state):
            problem, state = problem.rebased(state)


def _keeper(here: Linearised, knob: Knob) -> Callable[[Step], Step]:
    """Removes the part of a step that changes V, if V is to be kept."""
    if knob.mean_curvature is not None:
        return lambda step: step
    return lambda step: step.plus(here.along, -here.volume(step) / here.gain)


def _newton_step(
    here: Linearised, keep: Callable[[Step], Step], change: float, forcing: float
) -> tuple[Step, bool]:
    """A step that solves Newton's equation in the space that keeps V, beside the change of V; and whether it met
    negative curvature, where it ends. forcing: the accuracy, as a part of the gradient."""
    rest = here.gradient
    total = here.along.times(change / here.gain)
    if change:
        rest = rest.plus(here.hessian(total, here.push(total)))
    z = keep(here.precondition(rest))
    size = rest(z)
    goal = forcing**2 * size
    step = z.times(0.0)
    p, dp = z, here.push(z)
    for count in range(_CG_LIMIT):
        if size <= goal or size <= 0.0:
            break
        curved = here.hessian(p, dp)
        curvature = curved(p)
        if curvature <= 0.0:
            return total.plus(step if count else z, 1.0 if count else -1.0), True
        step = step.plus(p, -size / curvature)
        rest = rest.plus(curved, -size / curvature)
        z = keep(here.precondition(rest))
        size, last = rest(z), size
        if size <= goal:
            break
        p, dp = z.plus(p, size / last), here.push(z) + (size / last) * dp
    return total.plus(step), False


def _line_search(
    here: Linearised, state: State, volume: float, step: Step, change: float, keeps: bool
) -> tuple[State | None, float]:
    """The next state, and the part of the step taken; None if no part lowers the energy."""
    problem = here.problem
    length = problem.limit(state, step)
    slope = here.gradient(step)
    before = state.energy - 2.0 * here.H * volume
    allowed = abs(here.H * change) + _ROUNDING * abs(state.D)
    while length > _SHORTEST:
        q = state.q + length * step.q
        if not problem.motions.turned(q):
            moved = problem.state(state.u + length * step.u, state.x + length * step.x, q)
            if keeps:
                moved = with_volume(problem, moved, here.volume.lifted, volume + length * change)
            if moved is not None:
                value = moved.energy - 2.0 * here.H * moved.V
                if value <= before + _DECREASE * length * min(slope, 0.0) + length * allowed:
                    return moved, length
        length *= 0.5
    return None, 0.0


def with_volume(problem: SpanProblem, state: State, d: Array, wanted: float) -> State | None:
    """The state moved along d (I, 3) inside until it has the wanted volume: the nearest root of a cubic."""
    full = np.zeros_like(state.f)
    full[problem.coordinates.inside] = d
    cubic = problem.volume.along(state.f, full)
    cubic[0] -= wanted
    roots = np.roots(cubic[::-1])
    real = roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots).max(initial=1e-300)].real
    if not len(real):
        return None
    t = float(real[np.argmin(np.abs(real))])
    for _ in range(2):  # polish
        value, slope = np.polyval(cubic[::-1], t), np.polyval(np.polyder(cubic[::-1]), t)
        t -= value / slope if slope else 0.0
    return problem.lifted(state, t * d)
