"""Newton's method for spanning surfaces: projected conjugate gradients and a line search.

Three ways to choose among the surfaces of one rim (see `knobs`): H is given, and D - 2H V is minimised freely; V is
given, H is the multiplier and each step keeps V; or another number is given, and each step is that of Newton at one V
and dV times the tangent t, the change of the critical surface with V, dV such that the number is met to first order:
K t = 2 H' V', <V', t> = 1, found from M V' or the last tangent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import Progress
from .coordinates import Form, Step
from .linearised import Linearised
from .problem import SpanProblem, State

Array = NDArray[np.float64]
Keeper = Callable[[Step], Step]

# Steps of the inner iteration; its relative accuracy at most, as a power of the residual, as a multiple of a power of
# its last fall, and at the end in units of what is still needed.
_CG_LIMIT = 30
_FORCING = 0.1
_ORDER = 0.8
_SHORT, _FALLS = 0.5, 1.5
_SPARED = 0.1
# Residuals that fall to this part of themselves in one step fall quickly.
_QUICK = 0.1
# A number that is off by more of its unit than this is not blurred by the residual.
_CLEAR = 1e-3
# The first steps, which take a surface nearby to its end, change V whatever the residual.
_EAGER = 2
# The relative accuracy of tangents.
_AHEAD = 0.03
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

    problem: the one that was solved, on the plan that the state has reached or nearly. here: its derivatives there.
    tangent: how the surface changes with V, if that was needed.
    """

    problem: SpanProblem
    state: State
    mean_curvature: float
    volume: float
    end: str
    history: list[Iterate]
    here: Linearised
    tangent: Step | None = None

    @property
    def residual(self) -> float:
        return self.history[-1].residual


@dataclass(frozen=True, eq=False)
class Direction:
    """A change of the surface, how far it moves its points, df (V, 3), and what it leaves of the gradient, to first
    order: rest = r + K step."""

    step: Step
    df: Array
    rest: Form


class Knob:
    """The number that chooses: by default none, so that H is given.

    mean_curvature: the given H, or None where it is the multiplier. measures: whether V is chosen by the number.
    """

    mean_curvature: float | None = 0.0
    measures = False

    def volume_change(self, here: Linearised, newton: Direction, ahead: Direction) -> float:
        """dV of the next step, beside Newton's step at this V; ahead: the change of the critical surface with V."""
        return 0.0

    def off(self, here: Linearised) -> float:
        """By how much the number is off, in its unit."""
        return 0.0

    def reached(self, here: Linearised) -> bool:
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
    earlier: Descent | None = None,
) -> Descent:
    """The critical surface that the knob chooses, from `state`.

    residual: sqrt(<r, M r> / 2 D) of the gradient r, without unit. limit: of steps. earlier: a descent in the same
    coordinates, to a surface nearby. M is made anew where residuals do not fall quickly with the last one.
    """
    history: list[Iterate] = []
    negative, length, first = 0, 1.0, state.D
    tangent, here = (None, None) if earlier is None else (earlier.tangent, earlier.here)
    while True:
        here = _linearised(problem, state, knob.mean_curvature, here)
        volume = state.V
        keep, residual = _measured(here, knob)
        if history and residual > max(_QUICK * history[-1].residual, tolerance):
            here = here.chosen(knob.mean_curvature, None)
            keep, residual = _measured(here, knob)
        history.append(Iterate(state.D, residual, volume, here.H, problem.coordinates.solves, length))
        end = _end(here, knob, history, tolerance, limit)
        if not end and progress is not None and progress(len(history) - 1, residual) is False:
            end = "cancelled"
        if not end and negative >= _NEGATIVE and _RUNAWAY * first < state.D and knob.mean_curvature is not None:
            end = "runaway"
        if end:
            return Descent(problem, state, here.H, volume, end, history, here, tangent)
        forcing = max(_forcing(history), _SPARED * tolerance / max(residual, 1e-300))
        goal = 2.0 * state.D * (forcing * residual) ** 2
        newton, bent = _solved(here, keep, here.gradient, goal, shortened=True)
        step, change = newton.step, 0.0
        if knob.measures and _tells(knob, here, history, tolerance):
            ahead, _ = tangent_at(here, keep, tangent)
            tangent, change = ahead.step, knob.volume_change(here, newton, ahead)
            step = step.plus(tangent, change)
        negative += bent
        moved, length = _line_search(here, state, volume, step, change, knob.mean_curvature is None)
        if moved is None:
            return Descent(problem, state, here.H, volume, "stalled", history, here, tangent)
        state = moved
        if problem.is_far(state):
            problem, state = problem.rebased(state)
            tangent = here = None


def _linearised(problem: SpanProblem, state: State, H: float | None, near: Linearised | None) -> Linearised:
    """The derivatives at a state, with the preconditioner of one nearby; those are known where it is the same."""
    if near is None:
        return Linearised(problem, state, H)
    if near.problem is problem and near.state is state:
        return near.chosen(H, near.precondition)
    return Linearised(problem, state, H, near.precondition)


def _measured(here: Linearised, knob: Knob) -> tuple[Keeper, float]:
    """What a step keeps, and the residual."""
    keep = keeper(here, knob)
    z = keep(here.precondition(here.gradient))
    return keep, float(np.sqrt(max(here.gradient(z), 0.0) / (2.0 * here.state.D)))


def _end(here: Linearised, knob: Knob, history: Sequence[Iterate], tolerance: float, limit: int) -> str:
    """How a descent ends here, as far as the surface says; empty if it goes on."""
    problem, state = here.problem, here.state
    if history[-1].residual < tolerance and knob.reached(here):
        return "converged"
    if problem.has_closed_neck(state):
        return "neck"
    if problem.rim.stretches(state.x)[0] < _CROWDED:
        return "crowded"
    return "iteration limit" if len(history) > limit else ""


def _forcing(history: Sequence[Iterate]) -> float:
    """The relative accuracy of the next step: less where the last one fell short of what Newton's method promises
    (Eisenstat and Walker), as where vertices slide over the ends of arcs."""
    now, last = history[-1].residual, history[max(len(history) - 2, 0)].residual
    fallen = _SHORT * (now / last) ** _FALLS if now < last else 0.0
    return min(_FORCING, max(now**_ORDER, fallen))


def _tells(knob: Knob, here: Linearised, history: Sequence[Iterate], tolerance: float) -> bool:
    """Whether the number tells how V should change: not where the last step led away from critical surfaces, nor, after
    the first steps, where the number is off by no more than the residual blurs it."""
    now = history[-1].residual
    if len(history) > 1 and tolerance <= history[-2].residual < now:
        return False
    return len(history) <= _EAGER or now < tolerance or knob.off(here) > min(now, _CLEAR)


def keeper(here: Linearised, knob: Knob) -> Keeper:
    """Removes the part of a step that changes V, if V is to be kept."""
    if knob.mean_curvature is not None:
        return lambda step: step
    return lambda step: step.plus(here.along, -here.volume(step) / here.gain)


def _solved(
    here: Linearised, keep: Keeper, rest: Form, goal: float, *, shortened: bool = False
) -> tuple[Direction, bool]:
    """A step d with <rest + K d, M (rest + K d)> <= goal in the space that keeps V, K the Hessian; and whether it met
    negative curvature, where it ends.

    shortened: it ends, too, once the rim can take it in part only, since what follows is for a surface too far away
    (Steihaug). Not where a side leans: over walls such steps lead astray.
    """
    z = keep(here.precondition(rest))
    size = rest(z)
    step, df = z.times(0.0), np.zeros_like(here.state.f)
    if size <= goal:
        return Direction(step, df, rest), False
    p, dp = z, here.push(z)
    rim, x = here.problem.rim, here.state.x
    shortened = shortened and not rim.leaning.any()
    for count in range(_CG_LIMIT):
        curved = here.hessian(p, dp)
        curvature = curved(p)
        if curvature <= 0.0:
            return (Direction(step, df, rest) if count else Direction(z.times(-1.0), -dp, rest)), True
        step, df = step.plus(p, -size / curvature), df - size / curvature * dp
        rest = rest.plus(curved, -size / curvature)
        z = keep(here.precondition(rest))
        size, last = rest(z), size
        if size <= goal or (shortened and rim.limit(x, step.x) < 1.0):
            break
        p, dp = z.plus(p, size / last), here.push(z) + (size / last) * dp
    return Direction(step, df, rest), False


def tangent_at(here: Linearised, keep: Keeper, near: Step | None) -> tuple[Direction, bool]:
    """How the surface changes with V while it stays critical, <V', step> = 1; and whether its energy falls in a
    direction that keeps V. near: the same at a surface nearby."""
    step = here.along if near is None or not here.volume(near) > 0.0 else near
    step = step.times(1.0 / here.volume(step))
    df = here.push(step)
    bent, negative = _solved(here, keep, here.hessian(step, df), _AHEAD**2 / here.gain)
    return Direction(step.plus(bent.step), df + bent.df, bent.rest), negative


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
