"""What is kept between two solves, and how a solve runs beside Blender.

A plan that has not moved keeps its triangles, its domain and the solver's factorisation, found by a
fingerprint of positions and polygons and by what the solver is made for (sites, energy, triangulation), so that
changing a boundary condition costs no new factorisation. The work itself runs in a thread that never touches
Blender's data; `steps` is the one way to run it, for a script that waits and for a window that goes on drawing.
"""

from __future__ import annotations

import hashlib
import math
import queue
import threading
from collections import OrderedDict
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeVar

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ...solver.linalg import Patience
from ...solver.plans.plan import Settings, plan_domain
from ...solver.polygons import triangulate_polygons
from ...solver.surface.solve import CmcSolver
from ..bridges.mesh_bridge import PlanMesh
from .messages import in_plan_numbers

T = TypeVar("T")
Progress = Callable[[int, float], bool]

_KEPT = 4


@dataclass(frozen=True, eq=False)
class Prepared:
    """A plan made ready: triangles (T, 3), the polygon (T,) each is part of, and the solver of its domain."""

    triangles: NDArray[np.int32]
    owners: NDArray[np.int32]
    solver: CmcSolver


Choice = tuple[str, str, bool]
USUAL: Choice = Settings().solver_choice
_prepared: OrderedDict[tuple[bytes, Choice], Prepared] = OrderedDict()


def fingerprint(plan: PlanMesh) -> bytes:
    """Changes with the positions, the polygons, the own lengths or the start of a plan, and with nothing else."""
    digest = hashlib.blake2b(digest_size=16)
    for array in (plan.positions, plan.corners, plan.starts, plan.lengths, plan.initial):
        digest.update(b"" if array is None else np.ascontiguousarray(array))
        digest.update(bytes([array is None]))
    digest.update(bytes([plan.mirrored]))
    return digest.digest()


def prepare(plan: PlanMesh, choice: Choice = USUAL) -> Prepared:
    """Triangles and solver of a plan, from the last few if it is one of them.

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


# Unknowns whose factorisation by cholespy would hold up a window for about a tenth of a second.
_PATIENT = 20_000


def register() -> None:
    """Beside a window large matrices are factored in a way that lets it go on drawing."""
    Patience.largest = math.inf if bpy.app.background else _PATIENT


def unregister() -> None:
    """Stop what runs, drop what is kept."""
    cancel()
    forget()
    Patience.largest = math.inf


def forget() -> None:
    """Drop the prepared plans."""
    _prepared.clear()


def prepare_near(plan: PlanMesh, choice: Choice, other: PlanMesh, prepared: Prepared) -> Prepared:
    """A plan made ready for an answer while its vertices are dragged, from `other`, prepared, before the last move.

    Where only positions have changed, and the triangles are the same, what was worked out of them serves again, and
    the factors do nearly. Nothing of this is kept here. Raises `MeshError` in the plan's own numbering.
    """
    if not same_polygons(plan, other) or plan.lengths is not None or plan.initial is not None:
        return prepare(plan, choice)
    if np.array_equal(plan.positions, other.positions):
        return prepared
    if not _same_triangles(plan, other, prepared):
        return prepare(plan, choice)
    a, b = prepared.solver.domain.edges.T
    lengths = np.linalg.norm(plan.positions[b] - plan.positions[a], axis=1)
    try:
        return Prepared(prepared.triangles, prepared.owners, prepared.solver.moved(lengths))
    except CmcError as error:
        raise in_plan_numbers(error, plan, prepared.triangles, prepared.owners) from error


def same_polygons(plan: PlanMesh, other: PlanMesh) -> bool:
    """Whether two plans have the same polygons of the same vertices."""
    return (
        len(plan.positions) == len(other.positions)
        and plan.mirrored == other.mirrored
        and np.array_equal(plan.corners, other.corners)
        and np.array_equal(plan.starts, other.starts)
    )


def _same_triangles(plan: PlanMesh, other: PlanMesh, prepared: Prepared) -> bool:
    """Whether the polygons with more than three corners of which a vertex has moved are cut as before."""
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
    except CmcError:  # told where the whole plan is made ready
        return False
    return np.array_equal(triangles, prepared.triangles[touched[prepared.owners]])


@dataclass(frozen=True)
class Update:
    """How far a solve is: `part` goes from 0 to 1 as the residual falls to the tolerance."""

    iteration: int
    residual: float
    part: float


class Running:
    """The solve that runs now, if any: `cmc.cancel` stops it, and so does the next one where it gives way. `thread` is
    the last one that was started; it may still be at work after it was cancelled."""

    stop: threading.Event | None = None
    gives_way: bool = False
    thread: threading.Thread | None = None


def cancel() -> bool:
    """Stop waiting for the running solve, which ends after its present step; False where none runs."""
    if Running.stop is None:
        return False
    Running.stop.set()
    return True


def steps(
    work: Callable[[Progress], T], tolerance: float, wait: float, gives_way: bool = False
) -> Generator[Update | None, None, T | None]:
    """Run `work(progress)` in a thread; yield each update, or None after `wait` seconds without one.

    Returns what the work returns, or None as soon as it is cancelled; raises what it raises, and `CmcError`
    while another solve runs which does not give way. Closing the generator cancels. A cancelled thread is not waited
    for: it may be measuring, which has no steps to stop after. The next one starts when it is through.
    """
    if Running.stop is not None:
        if not Running.gives_way:
            raise CmcError("A solve is running; wait for it, or cancel it (Esc) first.")
        Running.stop.set()
    stop = threading.Event()
    news: queue.SimpleQueue = queue.SimpleQueue()
    arguments = (work, stop, news, Running.thread)
    Running.stop, Running.gives_way = stop, gives_way
    Running.thread = threading.Thread(target=_run, args=arguments, name="cmc-solve", daemon=True)
    Running.thread.start()
    first = 0.0
    try:
        while not stop.is_set():
            try:
                kind, value = news.get(timeout=wait)
            except queue.Empty:
                yield None
                continue
            if kind == "done":
                return value
            if kind == "error":
                raise value
            iteration, residual = value
            first = first or residual
            yield Update(iteration, residual, _part(first, residual, tolerance))
        return None
    finally:
        if Running.stop is stop:
            Running.stop = None
        stop.set()


def _run(
    work: Callable[[Progress], object],
    stop: threading.Event,
    news: queue.SimpleQueue,
    before: threading.Thread | None,
) -> None:
    def progress(iteration: int, residual: float) -> bool:
        if iteration >= 0:
            news.put(("update", (iteration, residual)))
        return not stop.is_set()

    try:
        if before is not None:
            before.join()  # what is kept between solves is for one at a time
        if not stop.is_set():
            news.put(("done", work(progress)))
    except BaseException as error:  # handed over whole: `steps` raises it in the thread that asked
        news.put(("error", error))


def _part(first: float, residual: float, tolerance: float) -> float:
    if not (first > tolerance and residual > 0 and math.isfinite(residual)):
        return 0.0
    return min(max(math.log(first / residual) / math.log(first / tolerance), 0.0), 1.0)
