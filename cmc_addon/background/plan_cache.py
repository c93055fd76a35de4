"""Plans prepared for solving, kept between solves.

A plan that has not moved keeps its triangles, its domain and the solver's factorisation. The key is a fingerprint of
its positions and polygons, with the choice of solver (sites, energy, triangulation); so changing a boundary condition
costs no new factorisation.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ...solver.io.polygons import triangulate_polygons
from ...solver.shells.plan import Settings, plan_domain
from ...solver.surface.solve import CmcSolver
from ..bridges.mesh_bridge import PlanMesh
from ..bridges.numbering import in_plan_numbers

_KEPT = 4


@dataclass(frozen=True, eq=False)
class Prepared:
    """A plan prepared for solving: triangles (T, 3), the polygon (T,) of each, and the solver of its domain."""

    triangles: NDArray[np.int32]
    owners: NDArray[np.int32]
    solver: CmcSolver

    @contextmanager
    def plan_numbers(self, mesh: PlanMesh) -> Iterator[None]:
        """A block whose errors number faces and edges as the plan does."""
        try:
            yield
        except CmcError as error:
            raise in_plan_numbers(error, mesh, self.triangles, self.owners) from error


Choice = tuple[str, str, bool]


USUAL: Choice = Settings().solver_choice


_prepared: OrderedDict[tuple[bytes, Choice], Prepared] = OrderedDict()


def fingerprint(plan: PlanMesh) -> bytes:
    """A hash of the positions, the polygons, the edge lengths and the start of a plan, and of nothing else."""
    digest = hashlib.blake2b(digest_size=16)
    for array in (plan.positions, plan.corners, plan.starts, plan.lengths, plan.initial):
        digest.update(b"" if array is None else np.ascontiguousarray(array).data)
        digest.update(bytes([array is None]))
    digest.update(bytes([plan.mirrored]))
    return digest.digest()


def prepare(plan: PlanMesh, choice: Choice = USUAL) -> Prepared:
    """Triangles and solver of a plan, from the cache if they are there.

    choice: `Settings.solver_choice`. Raises `MeshError` in the plan's own numbering.
    """
    key = fingerprint(plan), choice
    prepared = _prepared.pop(key, None) or _prepare(plan, *key)
    _prepared[key] = prepared
    while len(_prepared) > _KEPT:
        _prepared.popitem(last=False)
    return prepared


def _prepare(plan: PlanMesh, drawn: bytes, choice: Choice) -> Prepared:
    sites, energy, delaunay = choice
    options = {"sites": sites, "energy": energy, "delaunay": delaunay}
    for (known, _), other in _prepared.items():
        if known == drawn:
            return Prepared(other.triangles, other.owners, CmcSolver(other.solver.domain, **options))
    triangles, owners = triangulate_polygons(plan.positions, plan.polygons())
    try:
        solver = CmcSolver(plan_domain(plan.as_plan(triangles)), **options)
    except CmcError as error:
        raise in_plan_numbers(error, plan, triangles, owners) from error
    return Prepared(triangles, owners, solver)


def forget() -> None:
    """Drop the prepared plans."""
    _prepared.clear()


def prepare_near(plan: PlanMesh, choice: Choice, other: PlanMesh, prepared: Prepared) -> Prepared:
    """A plan whose vertices are being dragged, prepared from `other`, the same plan before the last move.

    Where only positions have changed and the triangles are equal, their topology serves again, and the old factors as
    a preconditioner. The cache keeps none of this. Raises `MeshError` in the plan's own numbering.
    """
    if not same_polygons(plan, other) or plan.lengths is not None or plan.initial is not None:
        return prepare(plan, choice)
    if np.array_equal(plan.positions, other.positions):
        return prepared
    if not _same_triangles(plan, other, prepared):
        return prepare(plan, choice)
    a, b = prepared.solver.domain.edges.T
    lengths = np.linalg.norm(plan.positions[b] - plan.positions[a], axis=1)
    with prepared.plan_numbers(plan):
        return Prepared(prepared.triangles, prepared.owners, prepared.solver.moved(lengths))


def same_polygons(plan: PlanMesh, other: PlanMesh) -> bool:
    """Whether two plans have the same polygons of the same vertices."""
    return (
        len(plan.positions) == len(other.positions)
        and plan.mirrored == other.mirrored
        and np.array_equal(plan.corners, other.corners)
        and np.array_equal(plan.starts, other.starts)
    )


def _same_triangles(plan: PlanMesh, other: PlanMesh, prepared: Prepared) -> bool:
    """Whether the polygons with more than three corners and a moved vertex have the same triangles as before."""
    sizes = np.diff(plan.starts)
    has_moved = (plan.positions != other.positions).any(axis=1)
    touched = (sizes > 3) & np.logical_or.reduceat(has_moved[plan.corners], plan.starts[:-1])
    if not touched.any():
        return True
    polygons = [plan.corners[plan.starts[k] : plan.starts[k + 1]] for k in np.flatnonzero(touched)]
    if plan.mirrored:
        polygons = [polygon[::-1] for polygon in polygons]
    try:
        triangles = triangulate_polygons(plan.positions, polygons)[0]
    except CmcError:  # raised again where the whole plan is prepared
        return False
    return np.array_equal(triangles, prepared.triangles[touched[prepared.owners]])
