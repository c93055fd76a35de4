"""The setting of a span: from a plan, its lines and its mirrors to the problem that is solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..gauss.frames import boundary_edges, unit
from ..gauss.harmonic import HarmonicSolver
from ..linalg import sum_rows
from .boundary import LINE, Plane, Side, mixed_loop, other_line, own_line
from .coordinates import Coordinates
from .curves import enclosed
from .douglas import rim_angles
from .layout import flat_layout
from .lines import boundary_lines
from .moduli import Motions
from .plan_fields import plan_fields
from .problem import SpanProblem
from .rim import Rim
from .volume import Volume

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Lines:
    """What the surface spans, in the frame of the caller.

    loops: the closed line of each boundary loop, the outer one first. centre: the origin of the search. base: the mean
    height of the outer line, area: that it encloses seen from above, extent: its smaller horizontal extent. size: the
    diagonal of all lines. is_drawn: whether they are the boundary of the plan itself.
    """

    loops: list[Array]
    centre: Array
    base: float
    area: float
    extent: float
    size: float
    is_drawn: bool


def setting(
    domain: Domain,
    points: Array,
    curve: ArrayLike | Sequence[ArrayLike] | None = None,
    mirrors: Sequence[tuple[ArrayLike, ArrayLike]] = (),
    *,
    sharp: bool = True,
    moving_holes: bool = True,
    solver: HarmonicSolver | None = None,
) -> tuple[SpanProblem, Lines]:
    """The problem of a plan with these points (V, 3), and its lines. Raises `ConditionError` where they do not fit."""
    if len(domain.boundary_loops) == 0 or domain.genus:
        raise ConditionError("Spanning lines needs a plan: a mesh with a boundary and without handles.")
    if len(domain.boundary_vertices) == domain.vertex_count:
        raise ConditionError("All vertices of the plan lie on its boundary, so none is free; subdivide it.")
    given, outer, own = boundary_lines(domain, points, curve)
    order = [outer, *(k for k in range(len(given)) if k != outer)]
    labels, planes = _mirrors(domain, points, mirrors)
    lines = _measured([given[k] for k in order], planes, all(own))
    loops = [domain.boundary_loops[k].astype(np.int64) for k in order]
    rim = domain.boundary_vertices.astype(np.int64)
    places = [np.searchsorted(rim, loop) for loop in loops]
    moved = [replace(plane, offset=plane.offset - float(plane.normal @ lines.centre)) for plane in planes]
    sides = []
    for k, place, loop in zip(order, places, loops, strict=True):
        label = labels[domain.boundary_loop_edges[k]]
        if not own[k] and (label != LINE).any():
            raise ConditionError("A loop with mirrors spans its own points; leave out the curve, or move the plan.")
        sides.append(_side(place, points[loop] - lines.centre, given[k] - lines.centre, own[k], label, moved, sharp))
    problem = _problem(domain, points, loops, sides, moving_holes, solver or HarmonicSolver(domain))
    return problem, lines


def _side(
    places: Int, points: Array, line: Array, is_own: bool, labels: Int, planes: Sequence[Plane], sharp: bool
) -> Side:
    if (labels != LINE).any():
        return mixed_loop(places, points, labels, planes, sharp)
    return own_line(places, points, sharp) if is_own else other_line(places, points, line, sharp)


def _mirrors(
    domain: Domain, points: Array, mirrors: Sequence[tuple[ArrayLike, ArrayLike]]
) -> tuple[Int, list[Plane]]:
    """The plane of each edge (E,), `LINE` without, and the planes, through the middle of their drawn sides."""
    labels = np.full(len(domain.edge_lengths), LINE, dtype=np.int64)
    planes = []
    for k, (edges, normal) in enumerate(mirrors):
        chosen = boundary_edges(domain, edges)
        n = unit(normal, np.zeros(1, dtype=np.int64), "edge")[0]
        labels[chosen] = k
        planes.append(Plane(n, float(np.mean(points[domain.edges[chosen]] @ n))))
    return labels, planes


def _measured(loops: list[Array], planes: Sequence[Plane], is_drawn: bool) -> Lines:
    weights = [_shares(line) for line in loops]
    total = sum(float(each.sum()) for each in weights)
    centre = sum((each @ line for each, line in zip(weights, loops, strict=True)), np.zeros(3)) / total
    if planes:
        normals = np.stack([plane.normal for plane in planes])
        off = np.array([plane.offset for plane in planes]) - normals @ centre
        centre = centre + np.linalg.lstsq(normals, off, rcond=1e-9)[0]
    extent = np.ptp(loops[0][:, :2], axis=0)
    return Lines(
        loops=loops,
        centre=centre,
        base=float(weights[0] @ loops[0][:, 2] / weights[0].sum()),
        area=abs(enclosed(loops[0])),
        extent=float(extent.min()),
        size=float(np.linalg.norm(np.ptp(np.concatenate(loops), axis=0))),
        is_drawn=is_drawn,
    )


def _shares(line: Array) -> Array:
    """(m,) half of the segments at each point of a closed line."""
    ahead = np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1)
    return 0.5 * (ahead + np.roll(ahead, 1))


def _problem(
    domain: Domain,
    points: Array,
    loops: Sequence[Int],
    sides: Sequence[Side],
    moving_holes: bool,
    solver: HarmonicSolver,
) -> SpanProblem:
    marks = [side.marks for side in sides]
    layout = flat_layout(domain, points) if _has_moduli(marks, moving_holes) else None
    if layout is not None and layout[0] is not domain:
        domain, solver = layout[0], HarmonicSolver(layout[0])
    dirichlet = solver.dirichlet(domain.boundary_vertices.astype(np.int64))
    places = [np.searchsorted(dirichlet.fixed, loop) for loop in loops]
    positions = points[:, :2] if layout is None else layout[1]
    fields = np.zeros((0, *positions.shape))
    if layout is not None:
        fields = plan_fields(dirichlet, positions, loops, marks, moving_holes)
    return SpanProblem(
        domain=domain,
        coordinates=Coordinates(dirichlet),
        rim=Rim([track for side in sides for track in side.tracks], len(dirichlet.fixed)),
        motions=Motions(domain, positions, fields),
        volume=Volume(domain),
        loops=places,
        omegas=rim_angles(dirichlet, domain.vertex_areas, places, [_lengths(domain, loop) for loop in loops]),
        marks=marks,
        has_gauge=len(loops) == 1 or (moving_holes and layout is not None),
        moving_holes=moving_holes,
    )


def _has_moduli(marks: Sequence[Int], moving_holes: bool) -> bool:
    """Whether the conformal type of the plan may have to change: around holes, and between four marked points."""
    return (len(marks) > 1 and moving_holes) or len(marks[0]) > 3


def _lengths(domain: Domain, loop: Int) -> Array:
    """(n,) the domain's boundary length at each vertex of a loop: half of its two edges."""
    edges = domain.boundary_edges
    halves = np.repeat(0.5 * domain.edge_lengths[edges], 2)
    return sum_rows(domain.edges[edges].ravel(), halves, domain.vertex_count)[loop]
