"""Saddle maps and the modes of critical maps: Morse index, nullity, null directions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ConditionError, Progress, Status
from ..linalg import as_numbers
from ..signatures import checked
from .admissible import resolved
from .boundary_data import Conditions
from .harmonic import HarmonicMap, HarmonicSolver
from .methods import Method
from .null_directions import Fields, drifts, free_rotations
from .problem import EnergyProblem, Point
from .saddles import climb
from .tangent import TangentSystem

Array = NDArray[np.float64]

# Largest cosine with an axis below which normals lie in the plane across it.
_FLAT = 1e-6
# |λ| in the H¹ product up to which a mode counts as null.
_NULL = 5e-3
# Residual up to which a map counts as critical.
_CRITICAL = 1e-3


@dataclass(frozen=True, eq=False)
class Modes:
    """The lowest modes of the energy at a critical map: its Morse index, nullity and eigenvectors.

    index: negative modes that are not null. nullity: modes with |λ| at most the tolerance, or mostly along free
    rotations and the given null fields. negative: modes with λ < 0, null or not. values: (k,) the lowest λ, sorted, of
    H v = λ K v in the H¹ product K; fields: (k, S, 3) their v. residual: of the map; modes count at critical maps only.
    """

    index: int
    nullity: int
    negative: int
    values: Array
    fields: Array
    residual: float

    @property
    def ok(self) -> bool:
        """Whether the map is critical, so that its index means something."""
        return self.residual <= _CRITICAL

    @property
    def message(self) -> str:
        """Index and nullity, or why they do not count."""
        if not self.ok:
            return f"The map is not critical (residual {self.residual:.2g}), so its index means nothing; solve first."
        return f"Index {self.index}, nullity {self.nullity}."

    def __repr__(self) -> str:
        lowest = ", ".join(f"{value:.4g}" for value in self.values[:4])
        more = ", …" if len(self.values) > 4 else ""
        return f"Modes(index {self.index}, nullity {self.nullity}, lowest λ: {lowest}{more})"


@checked
def saddle(
    solver: HarmonicSolver,
    conditions: Conditions,
    initial: ArrayLike,
    *,
    index: int | None = 1,
    null: Fields | None = None,
    tolerance: float = 1e-6,
    max_iterations: int = 100,
    progress: Progress | None = None,
) -> HarmonicMap:
    """A harmonic map that is no minimiser, near `initial` (S, 3): up along the `index` lowest unstable modes and down
    along all others, then Newton's method with a direct factorisation (paper, Sec. 5.3.3 and 5.3.4).

    index: the largest number of negative modes that the map may have; with None, Newton's method alone, to the nearest
    critical map of any index. null: fields along which the energy hardly changes; `null_directions.drifts` unless
    given, and free rotations of the sphere in any case. The status is COLLAPSED where the map fell into a plane that
    the initial one was not in. Raises `ConditionError` on an index that is not a whole number.
    """
    if index is not None and not (isinstance(index, (int, np.integer)) and index >= 0):
        raise ConditionError(f"The index of a saddle must be a whole number, 0 or more, not {index!r}.")
    method = Method("Saddle", "", partial(climb, index=index, null=null), False)
    reached = solver.solve(
        conditions,
        initial,
        method=method,
        tolerance=tolerance,
        max_iterations=max_iterations,
        progress=progress,
    )
    if flat_axis(reached.normals) is not None and flat_axis(np.asarray(initial, dtype=np.float64)) is None:
        return replace(reached, status=Status.COLLAPSED)
    return reached


def flat_axis(normals: Array) -> Array | None:
    """The axis a (3,) with N · a = 0 everywhere, for normals (S, 3) that lie in one plane; else None.

    The image of such a map lies on a great circle: f± are cylinders, or degenerate.
    """
    axis = np.linalg.eigh(normals.T @ normals)[1][:, 0]
    return axis if np.abs(normals @ axis).max() <= _FLAT else None


@checked
def modes_of(
    solver: HarmonicSolver,
    conditions: Conditions,
    normals: ArrayLike,
    *,
    count: int = 4,
    null: Fields | None = None,
    tolerance: float = _NULL,
) -> Modes:
    """Index and null modes of a map (S, 3), which should be critical, under its boundary conditions.

    The signs of the pivots of H - tolerance · K count the modes (Sylvester's law of inertia), Lanczos' method finds
    them. null: fields along which the energy hardly changes; `null_directions.drifts` unless given. Modes mostly along
    these, or along free rotations, are null whatever the sign of their λ.
    """
    problem = problem_of(solver, conditions)
    point = problem.at(_map(solver, normals))
    system, gauge = _second_order(problem, point, null)
    values, vectors = system.lowest(max(count, system.below(tolerance)), np.zeros((len(system.gradient), 0)))
    known = np.sum((gauge.T @ (system.K @ vectors)) ** 2, axis=0) > 0.5
    is_null = known | (np.abs(values) <= tolerance)
    return Modes(
        index=int((~is_null & (values < 0.0)).sum()),
        nullity=int(is_null.sum()),
        negative=int((values < 0.0).sum()),
        values=values,
        fields=np.stack([system.in_space(v) for v in vectors.T]),
        residual=point.residual,
    )


def index_of(
    solver: HarmonicSolver,
    conditions: Conditions,
    normals: ArrayLike,
    *,
    null: Fields | None = None,
    tolerance: float = _NULL,
) -> tuple[int, int]:
    """Index and nullity of a map (S, 3), as in `modes_of`, at the cost of two factorisations.

    Raises `ArithmeticError` where a mode has |λ| equal to the tolerance to all digits.
    """
    problem = problem_of(solver, conditions)
    system, gauge = _second_order(problem, problem.at(_map(solver, normals)), null)
    if np.abs(np.linalg.eigvalsh(gauge.T @ (system.H @ gauge))).max(initial=0.0) < tolerance:
        gauge = gauge[:, :0]  # null by themselves; a border would be filled by the factorisation
    index, above = (system.below(shift, gauge) for shift in (-tolerance, tolerance))
    return index, above - index + gauge.shape[1]


def _second_order(problem: EnergyProblem, point: Point, null: Fields | None) -> tuple[TangentSystem, Array]:
    """Hessian and H¹ product at a map, and the null directions (n, k), orthonormal."""
    system, N = TangentSystem.of(problem, point), point.N
    turns = np.cross(free_rotations(problem, N)[:, None, :], N)
    null = null or drifts(problem, N)
    fields = turns if null is None else np.concatenate([turns, null(N)])
    return system, system.orthonormal(system.coordinates(fields))


def _map(solver: HarmonicSolver, normals: ArrayLike) -> Array:
    given = as_numbers(normals, "The normals of a map", ConditionError)
    if given.shape != (solver.graph.count, 3):
        raise ConditionError(f"A map has {solver.graph.count} normals (S, 3) here, not shape {given.shape}.")
    return given


def problem_of(solver: HarmonicSolver, conditions: Conditions) -> EnergyProblem:
    """The energy of a solver under conditions."""
    admissible = resolved(conditions, solver.graph)
    dirichlet = solver.dirichlet(admissible.fixed)
    return EnergyProblem(solver.graph, solver.energy, dirichlet, mirrors=admissible.mirrors)
