"""Saddles as maps: found by name, counted, and told when they have collapsed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ConditionError, Progress, Status
from .admissible import resolved
from .boundary_data import Conditions
from .harmonic import HarmonicMap, HarmonicSolver
from .methods import Method
from .null_directions import Fields, drifts, free_rotations
from .problem import EnergyProblem
from .saddles import climb
from .tangent import TangentSystem

Array = NDArray[np.float64]

# Largest cosine with an axis below which normals lie in the plane across it.
_FLAT = 1e-6
# |λ| in the H¹ product up to which a mode counts as null.
_NULL = 5e-3


@dataclass(frozen=True, eq=False)
class Modes:
    """The second order of the energy at a critical map.

    index: negative modes that are not null. nullity: modes with |λ| at most the tolerance, or mostly along free
    rotations and the null fields asked about. negative: modes with λ < 0, null or not. values: (k,) the lowest λ,
    sorted, of H v = λ K v in the H¹ product K; fields: (k, S, 3) their v.
    """

    index: int
    nullity: int
    negative: int
    values: Array
    fields: Array


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

    index: the most negative modes that the map may have; with None, Newton's method alone, to the nearest critical
    map of any index. null: fields along which nothing should change; free rotations of the sphere and translations of a
    flat domain are found. The status is COLLAPSED where the map fell into a plane that the
    initial one was not in.
    """
    if index is not None and not (isinstance(index, (int, np.integer)) and index >= 0):
        raise ConditionError(f"The index of a saddle must be a whole number, 0 or more, not {index!r}.")
    method = Method("Saddle", "", partial(climb, index=index, null=null))
    found = solver.solve(
        conditions,
        initial,
        method=method,
        tolerance=tolerance,
        max_iterations=max_iterations,
        progress=progress,
    )
    if flat_axis(found.normals) is not None and flat_axis(np.asarray(initial, dtype=np.float64)) is None:
        return replace(found, status=Status.COLLAPSED)
    return found


def flat_axis(normals: Array) -> Array | None:
    """The axis a (3,) with N · a = 0 everywhere, for normals (S, 3) that lie in one plane; else None.

    Such a map is one of lines, a geodesic: f± are cylinders, or nothing.
    """
    axis = np.linalg.eigh(normals.T @ normals)[1][:, 0]
    return axis if np.abs(normals @ axis).max() <= _FLAT else None


def modes_of(
    solver: HarmonicSolver,
    conditions: Conditions,
    normals: Array,
    *,
    count: int = 4,
    null: Fields | None = None,
    tolerance: float = _NULL,
) -> Modes:
    """Index and null modes of a map (S, 3), which should be critical, under its boundary conditions.

    How many modes there are to look at say the signs of the pivots of H - tolerance · K (Sylvester's law of inertia);
    Lanczos' method finds them. null: fields along which the energy hardly changes; `symmetries.drifts` unless given.
    Modes that are mostly along these, or along free rotations, are null whatever the sign of their λ.
    """
    system, gauge = _at(solver, conditions, normals, null)
    values, vectors = system.lowest(max(count, system.below(tolerance)), np.zeros((len(system.gradient), 0)))
    known = np.sum((gauge.T @ (system.K @ vectors)) ** 2, axis=0) > 0.5
    is_null = known | (np.abs(values) <= tolerance)
    return Modes(
        index=int((~is_null & (values < 0.0)).sum()),
        nullity=int(is_null.sum()),
        negative=int((values < 0.0).sum()),
        values=values,
        fields=np.stack([system.in_space(v) for v in vectors.T]),
    )


def index_of(
    solver: HarmonicSolver,
    conditions: Conditions,
    normals: Array,
    *,
    null: Fields | None = None,
    tolerance: float = _NULL,
) -> tuple[int, int]:
    """Index and nullity of a map (S, 3) alone, as `modes_of` has them, at the price of two factorisations.

    Raises `ArithmeticError` where a mode has |λ| equal to the tolerance to all digits.
    """
    system, gauge = _at(solver, conditions, normals, null)
    if np.abs(np.linalg.eigvalsh(gauge.T @ (system.H @ gauge))).max(initial=0.0) < tolerance:
        gauge = gauge[:, :0]  # null by themselves; a border would be filled by the factorisation
    index, above = (system.below(shift, gauge) for shift in (-tolerance, tolerance))
    return index, above - index + gauge.shape[1]


def _at(
    solver: HarmonicSolver, conditions: Conditions, normals: Array, null: Fields | None
) -> tuple[TangentSystem, Array]:
    """The second order at a map, and the directions (n, k) along which nothing should change."""
    problem = problem_of(solver, conditions)
    system = TangentSystem.of(problem, problem.at(normals))
    turns = np.cross(free_rotations(problem, normals)[:, None, :], normals)
    null = null or drifts(problem, normals)
    fields = turns if null is None else np.concatenate([turns, null(normals)])
    return system, system.orthonormal(system.coordinates(fields))


def problem_of(solver: HarmonicSolver, conditions: Conditions) -> EnergyProblem:
    """The energy of a solver under conditions."""
    admissible = resolved(conditions, solver.graph)
    dirichlet = solver.dirichlet(admissible.fixed)
    return EnergyProblem(solver.graph, solver.energy, dirichlet, mirrors=admissible.mirrors)
