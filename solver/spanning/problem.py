"""The energy D(f, q) - 2H V(f) of surfaces that span a rim, with its derivatives in the coordinates (u, x, q).

D = ½ <f, L(q) f> is the Dirichlet energy over the plan, V the volume. Critical f have -Δf = 2H f_x × f_y, the equation
of surfaces of mean curvature H in conformal parameters; being critical for slides of the rim and for moduli of the plan
they are conformal (Plateau, Douglas; Rellich for H ≠ 0). A dome over a counter-clockwise plan has H > 0 and V > 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.harmonic import HarmonicSolver
from .coordinates import Coordinates, Step
from .douglas import angles
from .moduli import Motions
from .plan_fields import plan_fields
from .refine import refined
from .rim import Rim, RimPoint
from .volume import Volume
from .walls import RimVolume, Walls

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# No modulus changes by more in one step; beyond this the plan that it leads to takes the place of the first one.
_MODULUS_STEP = 0.2
_REBASED = 0.15
# The part of its first size to which a hole may shrink: catenoids at their limit are above a tenth.
_CLOSED = 0.05


@dataclass(frozen=True, eq=False)
class State:
    """A surface f (V, 3) = u + E p(x) over the plan at q.

    weights (E,): the plan's cotangent weights. D: the Dirichlet energy, walls: Σ cos t · W (see `walls`), V: the
    volume. rim: at x.
    """

    u: Array
    x: Array
    q: Array
    f: Array
    weights: Array
    D: float
    walls: float
    V: float
    rim: RimPoint

    @property
    def energy(self) -> float:
        """D and the walls."""
        return self.D + self.walls


@dataclass(frozen=True, eq=False)
class SpanProblem:
    """Surfaces over one domain with one rim. solver: has the factor of its coordinates.

    loops: places of the boundary loops' vertices in `coordinates.rim`, the outer one first; omegas: their angles, see
    `douglas`; marks: places of the marked points along each, see `plan_fields`. has_gauge: whether the outer loop is
    taken up to Möbius transformations. moving_holes: whether the holes of the plan move. walls: under leaning sides.
    drawn (B, 2): the rim of the first plan. kernel (B, B): Douglas'.
    """

    domain: Domain
    solver: HarmonicSolver
    coordinates: Coordinates
    rim: Rim
    motions: Motions
    volume: Volume
    loops: Sequence[Int]
    omegas: Sequence[Array]
    marks: Sequence[Int]
    has_gauge: bool
    moving_holes: bool
    walls: Walls
    drawn: Array
    kernel: Array

    def start(self) -> State:
        """The harmonic surface over the rim at the start of its numbers."""
        return self.state(None, self.rim.start, np.zeros(self.motions.count))

    def state(self, u: Array | None, x: Array, q: Array) -> State:
        """The surface of these numbers; u = None stands for zero."""
        rim = self.rim.at(x)
        f = self.coordinates.extend(rim.points)
        if u is None:
            u = np.zeros((len(self.coordinates.inside), 3))
        else:
            f[self.coordinates.inside] += u
        weights = self.motions.weights(q) if self.motions.count else self.domain.cotan_weights
        energy = 0.5 * float(weights @ self.squares(f))
        return State(u, x, q, f, weights, energy, self.walls.value(x), self.volume.of(f), rim)

    def is_far(self, state: State) -> bool:
        """Whether the plan has moved so far that coordinates of the new one are better."""
        return float(np.abs(state.q).max(initial=0.0)) > _REBASED

    def has_closed_neck(self, state: State) -> bool:
        """Whether a hole has shrunk so far that its neck must be closing."""
        rim = self.motions.at(state.q)[self.coordinates.rim]
        sizes = [np.linalg.norm(np.ptp(p[loop], axis=0)) for loop in self.loops[1:] for p in (rim, self.drawn)]
        return any(now < _CLOSED * before for now, before in zip(sizes[::2], sizes[1::2], strict=True))

    def rebased(self, state: State) -> tuple[SpanProblem, State]:
        """The same surface over the plan that it has reached, with coordinates of that plan; refined around holes."""
        domain, positions, f = self.motions.moved(state.q), self.motions.at(state.q), state.f
        if len(self.loops) > 1:
            domain, positions, f = refined(domain, positions, f) or (domain, positions, f)
        solver = HarmonicSolver(domain)
        dirichlet = solver.dirichlet(self.coordinates.rim)
        coordinates = Coordinates(dirichlet)
        coordinates.solves = self.coordinates.solves
        loops = [self.coordinates.rim[loop] for loop in self.loops]
        fields = plan_fields(dirichlet, positions, loops, angles(self.omegas[0]), self.marks, self.moving_holes)
        problem = replace(
            self,
            domain=domain,
            solver=solver,
            coordinates=coordinates,
            motions=Motions(domain, positions, fields),
            volume=self.volume if domain.faces is self.domain.faces else Volume(domain, self.volume.rim),
        )
        u = (f - coordinates.extend(state.rim.points))[coordinates.inside]
        return problem, problem.state(u, state.x, np.zeros(problem.motions.count))

    def on(self, rim: Rim, parts: Sequence[RimVolume]) -> SpanProblem:
        """The same plan, as far as it has moved, with another rim of like tracks and its parts of the volume."""
        same = rim.is_same(self.rim)
        kept = {} if same else {"rim": rim, "walls": Walls.under(rim)}
        problem = replace(self, volume=self.volume.with_rim(parts), **kept)
        problem.coordinates.solves = 0
        return problem

    def continued(self, earlier: SpanProblem, state: State) -> State | None:
        """An earlier state of the same plan, its rim's vertices carried over to this rim; None if rims are unlike."""
        if self.rim is earlier.rim:
            V = self.volume.of(state.f)
            return state if V == state.V else replace(state, V=V)
        x = self.rim.adopted(earlier.rim, state.x)
        return None if x is None else self.state(state.u, x, state.q)

    def laid_over(self, earlier: SpanProblem, state: State) -> State | None:
        """The surface of a state over another plan with the same vertices and rim; None if they are not the same."""
        return self._with_surface(state, self.rim.adopted(earlier.rim, state.x))

    def upright(self, earlier: SpanProblem, state: State) -> State | None:
        """The surface of a state whose rim had other vertices upright at the ends of its sides, over the first plan."""
        if self.coordinates is not earlier.coordinates:
            self.coordinates.solves += earlier.coordinates.solves
        return self._with_surface(state, self.rim.renumbered(earlier.rim, state.x))

    def _with_surface(self, state: State, x: Array | None) -> State | None:
        if x is None or len(state.f) != self.domain.vertex_count:
            return None
        u = state.f - self.coordinates.extend(self.rim.at(x).points)
        return self.state(u[self.coordinates.inside], x, np.zeros(self.motions.count))

    def lifted(self, state: State, d: Array) -> State:
        """The state with u changed by d (I, 3)."""
        f = state.f.copy()
        f[self.coordinates.inside] += d
        energy = 0.5 * float(state.weights @ self.squares(f))
        return replace(state, u=state.u + d, f=f, D=energy, V=self.volume.of(f))

    def squares(self, f: Array) -> Array:
        """(E,) squared edge lengths."""
        d = self.differences @ f
        return np.einsum("ij,ij->i", d, d)

    @cached_property
    def differences(self) -> sp.csr_array:
        """(E, V) f_j - f_i along each edge."""
        edges, (count, size) = self.domain.edges, (len(self.domain.edges), self.domain.vertex_count)
        starts = np.arange(0, 2 * count + 1, 2)
        return sp.csr_array((np.tile([-1.0, 1.0], count), edges.ravel(), starts), shape=(count, size))

    def limit(self, state: State, step: Step) -> float:
        """The largest multiple of the step that keeps the rim in order and the plan near; at most 1."""
        furthest = float(np.abs(step.q).max(initial=0.0))
        return min(1.0, self.rim.limit(state.x, step.x), _MODULUS_STEP / max(furthest, 1e-300))
