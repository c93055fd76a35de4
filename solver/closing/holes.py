"""Holes of a plan that move: the moduli of a plan with courtyards.

The surface closes around a hole only for certain places of it (paper, Sec. 5.3.3). A hole shifts, turns or grows as a
whole, and the plan around it follows, less so near the other loops,

    x' = x + Σ_h u_h (M_h(x) - x),   Δu_h = 0,   u_h = 1 on hole h,   u_h = 0 on the other loops.

The conditions on the boundary stay; a twist therefore turns the hole against its normals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..domain.sites import SiteGraph
from ..errors import ConditionError, MeshError, check_choice, plural
from ..gauss.dirichlet import Dirichlet
from ..gauss.frames import area_vectors, in_space
from ..gauss.sphere import dot
from ..signatures import checked
from .moduli import Moduli

Array = NDArray[np.float64]

MOTIONS = ("x", "y", "twist", "size")


@checked
def hole(domain: DomainLike, positions: ArrayLike, loop: int, motions: tuple[str, ...] = ("x", "y", "twist")) -> Moduli:
    """A hole of a plan that moves: `motions` of x, y (parts of the plan's size), twist (radians), size (logarithm).

    positions: (V, 2|3) of the plan, loop: the index of the hole in `domain.boundary_loops`. It moves by at most half
    the plan's size and turns by at most half a turn. `close_periods` takes a list of several holes, too. Raises
    `ConditionError` on an unknown loop or motion.
    """
    return MovingHoles(as_domain(domain), positions, [loop], [motions]).moduli()


def together(given: Moduli | Sequence[Moduli]) -> Moduli:
    """Several moving holes of one plan as one `Moduli`. Raises `ConditionError` on others than holes."""
    if isinstance(given, Moduli):
        return given
    several = list(given)
    holes = [one.moving for one in several if isinstance(one, HoleModuli)]
    if not holes or len(holes) < len(several):
        raise ConditionError(
            "Several moduli must be a list of holes, each made by `hole`; parts that stretch are one, made by `tubes`."
        )
    first = holes[0]
    if any(one.domain is not first.domain or not np.array_equal(one.points, first.points) for one in holes):
        raise ConditionError("The holes are of different plans; make them with the same domain and positions.")
    loops = [loop for one in holes for loop in one.loops]
    return MovingHoles(first.domain, first.points, loops, [names for one in holes for names in one.motions]).moduli()


class MovingHoles:
    """Holes of a plan that move, each by its own `motions`; q (m,) lists them hole by hole.

    motions: names for each hole, or one list for all. size: of the plan, the unit of x and y. names: of the numbers,
    "x", or "hole 1 x" where several holes move; numbers: those of the holes in these names.
    """

    def __init__(
        self,
        domain: Domain,
        positions: ArrayLike,
        loops: Sequence[int],
        motions: Sequence[str] | Sequence[Sequence[str]] = ("x", "y", "twist"),
        numbers: Sequence[int] | None = None,
    ) -> None:
        each = [[str(one) for one in motions]] * len(loops) if _is_one(motions) else [list(names) for names in motions]
        for name in [name for names in each for name in names]:
            check_choice(name, MOTIONS, "motion of a hole")
        twice = [loop for loop in loops if list(loops).count(loop) > 1]
        if twice:
            raise ConditionError(f"The hole at loop {twice[0]} is given twice; give each once, with all its motions.")
        wrong = [loop for loop in loops if loop not in range(len(domain.boundary_loops))]
        if wrong:
            raise ConditionError(f"There is no boundary loop {wrong[0]}; the plan has {len(domain.boundary_loops)}.")
        self.domain = domain
        self.points = in_space(domain, positions)
        self.size = float(np.linalg.norm(np.ptp(self.points, axis=0)))
        self.loops = tuple(int(loop) for loop in loops)
        self.motions = tuple(tuple(names) for names in each)
        numbers = numbers or range(1, len(loops) + 1)
        self.names = tuple(f"hole {k} {name}" for k, names in zip(numbers, each, strict=True) for name in names)
        if len(loops) == 1:
            self.names = self.motions[0]
        self._centres = [self.points[domain.boundary_loops[loop]].mean(axis=0) for loop in loops]
        self._shares = _shares(domain, loops)
        self._ahead = area_vectors(self.points, domain.faces)

    def positions(self, q: ArrayLike) -> Array:
        """(V, 3) of the plan whose holes have moved. Raises `MeshError` where faces turn over."""
        now = self.points.copy()
        numbers = iter(np.asarray(q, dtype=np.float64).tolist())
        for share, centre, names in zip(self._shares.T, self._centres, self.motions, strict=True):
            goal, wanted = self.points, {name: next(numbers) for name in names}
            for name in sorted(wanted, key=list(_MOTIONS).index):
                goal = _MOTIONS[name][0](goal, centre, self.size, wanted[name])
            now += share[:, None] * (goal - self.points)
        turned = np.flatnonzero(dot(area_vectors(now, self.domain.faces), self._ahead)[:, 0] <= 0.0)
        if turned.size:
            raise MeshError(f"The hole moved so far that {plural('face', turned)} turned over.", faces=turned)
        return now

    def moduli(self) -> Moduli:
        """The motions as moduli of the domain."""
        i, j = self.domain.edges.T

        def lengths(q: Array) -> Array:
            now = self.positions(q)
            return np.linalg.norm(now[j] - now[i], axis=1)

        ranges = tuple(_MOTIONS[name][1] for names in self.motions for name in names)
        return HoleModuli(self.names, self.domain, lengths, ranges, self)


@dataclass(frozen=True, eq=False, repr=False)
class HoleModuli(Moduli):
    """Moduli of moving holes."""

    moving: MovingHoles


def _is_one(motions: Sequence[str] | Sequence[Sequence[str]]) -> bool:
    """Whether these are the motions of one hole, not one list for each."""
    return all(isinstance(one, str) for one in motions)


def _shares(domain: Domain, loops: Sequence[int]) -> Array:
    """u (V, len(loops)): how far each vertex follows each hole."""
    rim = domain.boundary_vertices.astype(np.int64)
    graph = SiteGraph.of(domain, "vertices")
    on_hole = [np.isin(rim, domain.boundary_loops[loop]) for loop in loops]
    return Dirichlet(graph, graph.weights, rim).extend(np.stack(on_hole, axis=1).astype(np.float64))


def _shifted(axis: int) -> Callable[[Array, Array, float, float], Array]:
    return lambda points, centre, size, number: points + number * size * np.eye(3)[axis]


def _twisted(points: Array, centre: Array, size: float, number: float) -> Array:
    turn = np.array([[np.cos(number), -np.sin(number), 0], [np.sin(number), np.cos(number), 0], [0, 0, 1]])
    return centre + (points - centre) @ turn.T


def _grown(points: Array, centre: Array, size: float, number: float) -> Array:
    return centre + np.exp(number) * (points - centre)


# Each with the range of its number, in this order: a hole turns and grows about its first centre.
_MOTIONS = {
    "twist": (_twisted, (-np.pi, np.pi)),
    "size": (_grown, (-2.0, 2.0)),
    "x": (_shifted(0), (-0.5, 0.5)),
    "y": (_shifted(1), (-0.5, 0.5)),
}
