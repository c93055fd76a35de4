"""Closed curves for the rim of a fitted shell: read from an OBJ, and assigned to the loops of the plan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ..domain.domain import Domain
from ..errors import ConditionError, JobError, MeshError
from ..io.mesh_files import oriented
from ..io.obj import read_obj

Array = NDArray[np.float64]


def curves_of_loops(domain: Domain, positions: Array, curves: Sequence[Array]) -> list[Array]:
    """A closed polyline (m, 3) for each of `domain.boundary_loops`, in their order.

    The largest of the curves, one or more, goes to the outer loop, the others to the holes nearest to them; a hole
    without a curve keeps its own line. All as seen from above, and relative to the middle of the outer line, so that
    the curves may lie elsewhere. positions: (V, 3). Raises as `check_count`.
    """
    check_count(domain, curves)
    lines = [positions[loop] for loop in domain.boundary_loops]
    outer = max(range(len(lines)), key=lambda k: _area(lines[k]))
    holes = [k for k in range(len(lines)) if k != outer]
    first, *others = sorted(curves, key=_area, reverse=True)
    if others:
        wanted = np.array([_middle(line) - _middle(first) for line in others])
        drawn = np.array([_middle(lines[hole]) - _middle(lines[outer]) for hole in holes])
        far = np.linalg.norm(wanted[:, None] - drawn[None], axis=2)
        for curve, hole in zip(*linear_sum_assignment(far**2), strict=True):
            lines[holes[hole]] = others[curve]
    lines[outer] = first
    return lines


def check_count(domain: Domain, curves: Sequence[Array]) -> None:
    """Raise `ConditionError` on more curves than the plan has loops."""
    count = len(domain.boundary_loops)
    if len(curves) > count:
        loops = "one loop" if count == 1 else f"{count} loops"
        raise ConditionError(f"There are {len(curves)} curves, but the plan's boundary has {loops}; remove some.")


def _area(line: Array) -> float:
    x, y = line[:, 0], line[:, 1]
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def _middle(line: Array) -> Array:
    """The mean (2,) along a closed line, seen from above."""
    ends = np.roll(line, -1, axis=0)
    return np.average(0.5 * (line + ends)[:, :2], axis=0, weights=np.linalg.norm(ends - line, axis=1))


def read_curves(file: Path, up: str | None = None) -> list[Array]:
    """The closed polylines (`l`) of an OBJ: points (m, 3) of each, in order, the first one not repeated.

    Raises `JobError` where the file cannot be read, or a polyline in it is not closed.
    """
    if file.suffix.lower() != ".obj":
        raise JobError(f"{file} is no OBJ file; curves are read from OBJ.")
    try:
        mesh = read_obj(file)
    except OSError as error:
        raise JobError(f"{file} cannot be read: {error.strerror or error}.") from error
    except MeshError as error:
        raise JobError(f"{file} has no readable curve: {error}") from error
    pairs = np.concatenate([np.empty((0, 2), dtype=np.int64), *mesh.edge_groups.values()])
    loops = _walk(_merged(mesh.positions, pairs), file)
    return [oriented(mesh.positions[loop], up or "z") for loop in loops]


def _merged(positions: Array, pairs: NDArray[np.integer]) -> NDArray[np.integer]:
    """Vertex pairs with coincident vertices merged, as in a polyline whose last point repeats the first."""
    if not len(pairs):
        return pairs
    _, first, index = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    pairs = first[index.ravel()][pairs]
    return np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)


def _walk(pairs: NDArray[np.integer], file: Path) -> list[list[int]]:
    """The vertices of each closed polyline in order, from its first one on."""
    ends: dict[int, list[int]] = {}
    for a, b in pairs.tolist():
        ends.setdefault(a, []).append(b)
        ends.setdefault(b, []).append(a)
    odd = [vertex for vertex, others in ends.items() if len(others) != 2]
    if len(ends) < 3 or odd:
        where = f" Its vertex {odd[0]} has {len(ends[odd[0]])} segments." if odd else ""
        raise JobError(f"{file} has no closed polyline (l 1 2 3 1); one is needed.{where}")
    loops = []
    while ends:
        start = min(ends)
        loop, at = [], start
        while at in ends:
            loop.append(at)
            one, other = ends.pop(at)
            at = one if one in ends else other
        loops.append(loop)
    return loops
