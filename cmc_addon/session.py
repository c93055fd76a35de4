"""What is kept between two solves, and how a solve runs beside Blender.

A plan that has not moved keeps its triangles, its domain and the solver's factorisation, found by a
fingerprint of positions and polygons and by what the solver is made for (sites, energy, triangulation), so that
changing a boundary condition costs no new factorisation. The
work itself runs in a thread that never touches Blender's data; `steps` is the one way to run it, for a script
that waits and for a window that goes on drawing.
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

import numpy as np
from numpy.typing import NDArray

from ..solver.errors import CmcError
from ..solver.plan import Settings, plan_domain
from ..solver.polygons import triangulate_polygons
from ..solver.surface.solve import CmcSolver
from .mesh_bridge import PlanMesh
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


def register() -> None:
    """Nothing to do: what is kept comes with use."""


def unregister() -> None:
    """Stop what runs, drop what is kept."""
    cancel()
    forget()


def forget() -> None:
    """Drop the prepared plans."""
    _prepared.clear()


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
