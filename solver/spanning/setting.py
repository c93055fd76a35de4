"""The setting of a span: from a plan, its lines, mirrors and leans to the problem that is solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, plural, shown
from ..gauss.frames import boundary_edges, unit
from ..gauss.harmonic import HarmonicSolver
from ..gauss.lines import checked_lean
from ..linalg import as_array, sum_rows
from ..notes import Note
from .boundary import LINE, Lean, Plane, Side, mixed_loop, other_line, own_line
from .coordinates import Coordinates
from .curves import enclosed
from .douglas import angles, douglas_kernel, rim_angles
from .feasible import check_balance, check_corners
from .layout import flat_layout
from .lines import boundary_lines
from .moduli import Motions
from .plan_fields import plan_fields
from .problem import SpanProblem
from .rim import Rim
from .volume import Volume
from .walls import OverPlanes, OverWalls, RimVolume, Walls

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Lines within this part of their size from a plane lie in it.
_IN_PLANE = 1e-6
# Ends of a line may lie beside the plane of a mirror by this part of the size: walls are not drawn to the millimetre.
_ENDS_OFF = 5e-3


@dataclass(frozen=True, eq=False)
class Lines:
    """What the surface spans, in the frame of the caller.

    loops: the closed line of each boundary loop, the outer one first. centre: the origin of the search. base: the mean
    height of the outer line, area: that it encloses seen from above, extent: its smaller horizontal extent. size: the
    diagonal of all lines. is_drawn: whether they are the boundary of the plan itself. notes: on what may not be meant.
    """

    loops: list[Array]
    centre: Array
    base: float
    area: float
    extent: float
    size: float
    is_drawn: bool
    notes: Sequence[Note] = ()


@dataclass(frozen=True, eq=False)
class Conditions:
    """Which boundary edges are not on lines: `labels` (E,) of each edge, `LINE` or an index of `kinds`."""

    labels: Int
    kinds: list[Plane | Lean]

    @property
    def planes(self) -> list[Plane]:
        return [kind for kind in self.kinds if isinstance(kind, Plane)]

    def centred(self, centre: Array) -> Conditions:
        """The same with the origin at `centre` (3,)."""
        return Conditions(
            self.labels,
            [
                replace(kind, offset=kind.offset - float(kind.normal @ centre)) if isinstance(kind, Plane) else kind
                for kind in self.kinds
            ],
        )

    def edges_of(self, kind: type[Plane] | type[Lean]) -> Int:
        """Edges with conditions of one kind."""
        chosen = [k for k, each in enumerate(self.kinds) if isinstance(each, kind)]
        return np.flatnonzero(np.isin(self.labels, chosen))


def setting(
    domain: Domain,
    points: Array,
    curve: ArrayLike | Sequence[ArrayLike | None] | None = None,
    mirrors: Sequence[tuple[ArrayLike, ArrayLike]] = (),
    leans: Sequence[tuple[ArrayLike, float]] = (),
    anchors: ArrayLike | None = None,
    *,
    sharp: bool = True,
    moving_holes: bool = True,
    solver: HarmonicSolver | None = None,
    mean_curvature: float | None = None,
    earlier: SpanProblem | None = None,
    upright: Sequence[int] = (),
) -> tuple[SpanProblem, Lines]:
    """The problem of a plan with these points (V, 3), and its lines. mean_curvature: the wanted one, if any.

    earlier: a problem of the same plan, whose factors are used again if its rim has like tracks. upright: rim vertices
    that stand at the end of their leaning side.

    Raises `ConditionError` where they do not fit.
    """
    if len(domain.boundary_loops) == 0 or domain.genus:
        raise ConditionError("Spanning lines needs a plan: a mesh with a boundary and without handles.")
    if len(domain.boundary_vertices) == domain.vertex_count:
        raise ConditionError("All vertices of the plan lie on its boundary, so none is free; subdivide it.")
    given, outer, own = boundary_lines(domain, points, curve)
    order = [outer, *(k for k in range(len(given)) if k != outer)]
    conditions = _conditions(domain, points, mirrors, leans)
    lines = _measured([given[k] for k in order], conditions.planes, all(own))
    _check_mirrors(domain, conditions, lines)
    loops = [domain.boundary_loops[k].astype(np.int64) for k in order]
    places = [np.searchsorted(domain.boundary_vertices, loop) for loop in loops]
    conditions = conditions.centred(lines.centre)
    anchored = _anchored(domain, anchors)
    sides: list[Side] = []
    notes: list[Note] = []
    for k, place, loop in zip(order, places, loops, strict=True):
        labels = conditions.labels[domain.boundary_loop_edges[k]]
        mine, its = points[loop] - lines.centre, given[k] - lines.centre
        if (labels == LINE).all():
            stays = np.flatnonzero(np.isin(loop, anchored))
            sides.append(own_line(place, mine, sharp, stays) if own[k] else other_line(place, points[loop], its, sharp))
        elif own[k]:
            notes += check_corners(loop, mine, labels, conditions.kinds, lines.extent)
            sides.append(mixed_loop(place, mine, labels, conditions.kinds, sharp, upright))
        else:
            raise ConditionError("A loop with mirrors or leans spans its own points; leave out its curve.")
    _check_mirror_ends(domain, points - lines.centre, conditions, lines.size)
    rim = Rim([track for side in sides for track in side.tracks], len(domain.boundary_vertices))
    parts = _rim_volumes(domain, conditions)
    if earlier is not None and np.array_equal(earlier.domain.faces, domain.faces) and rim.is_like(earlier.rim):
        problem = earlier.on(rim, parts)
    else:
        marks = [side.marks for side in sides]
        problem = _problem(domain, points, loops, rim, marks, parts, moving_holes, solver or HarmonicSolver(domain))
    if len(conditions.edges_of(Lean)):
        if not problem.rim.on_line.any():
            raise ConditionError("Nothing holds the height: all sides lean. Keep a side or an edge on its line.")
        if mean_curvature is not None:
            edges = [domain.boundary_loop_edges[k] for k in order]
            _check_balance(conditions, mean_curvature, [points[loop] for loop in loops], edges)
    return problem, replace(lines, notes=notes)


def _check_mirrors(domain: Domain, conditions: Conditions, lines: Lines) -> None:
    """A surface at right angles to the plane of all lines would shrink to them: nothing holds it up."""
    points = np.concatenate(lines.loops)
    for number, kind in enumerate(conditions.kinds):
        if isinstance(kind, Plane) and np.abs(points @ kind.normal - kind.offset).max() <= _IN_PLANE * lines.size:
            normal = ", ".join(f"{x:.3g}" for x in kind.normal)
            raise ConditionError(
                f"The plane of a mirror, with the normal ({normal}), holds all lines of the plan. A mirror stands "
                "upright over its side, like a wall: give it the direction across that side.",
                edges=np.flatnonzero(conditions.labels == number),
            )


def _check_mirror_ends(domain: Domain, points: Array, conditions: Conditions, size: float) -> None:
    """Ends of lines stay, so where a mirror meets them they must lie in its plane."""
    rim = domain.boundary_edges
    on_line = np.unique(domain.edges[rim[conditions.labels[rim] == LINE]])
    for number, kind in enumerate(conditions.kinds):
        if not isinstance(kind, Plane):
            continue
        ends = np.intersect1d(domain.edges[conditions.labels == number], on_line)
        off = np.abs(points[ends] @ kind.normal - kind.offset)
        if off.max(initial=0.0) > _ENDS_OFF * size:
            normal = ", ".join(f"{x:.3g}" for x in kind.normal)
            raise ConditionError(
                f"The plane of a mirror, with the normal ({normal}), passes up to {off.max():.3g} beside the ends of "
                f"its side, at {plural('vertex', ends)}, which stay on their lines. Turn the plane along the side, or "
                "give sides in several planes a mirror each.",
                vertices=ends.tolist(),
            )


def _check_balance(conditions: Conditions, H: float, loops: Sequence[Array], edges: Sequence[Int]) -> None:
    cosines = np.array([np.cos(kind.angle) if isinstance(kind, Lean) else 0.0 for kind in conditions.kinds] + [0.0])
    labels = [conditions.labels[each] for each in edges]  # `LINE` is the last
    check_balance(H, loops, [cosines[each] for each in labels], [(each == LINE).astype(float) for each in labels])


def _anchored(domain: Domain, anchors: ArrayLike | None) -> Int:
    """Vertices (k,) that stay; raises `ConditionError` on others than those of the boundary."""
    given = as_array([] if anchors is None else anchors, "Anchors", ConditionError)
    if given.size and not np.issubdtype(given.dtype, np.integer):
        raise ConditionError(f"Anchors must be indices of vertices (k,), not {shown(anchors)}.")
    vertices = np.unique(given.astype(np.int64))
    inside = np.setdiff1d(vertices, domain.boundary_vertices)
    if inside.size:
        raise ConditionError(
            f"Anchors are vertices of the boundary; inside it are {plural('vertex', inside)}. Leave them out.",
            vertices=inside.tolist(),
        )
    return vertices


def _conditions(
    domain: Domain,
    points: Array,
    mirrors: Sequence[tuple[ArrayLike, ArrayLike]],
    leans: Sequence[tuple[ArrayLike, float]],
) -> Conditions:
    """Mirrors in the planes through the middle of their drawn sides, and leans."""
    labels = np.full(len(domain.edge_lengths), LINE, dtype=np.int64)
    kinds: list[Plane | Lean] = []
    for edges, normal in mirrors:
        chosen = boundary_edges(domain, edges)
        labels[chosen] = len(kinds)
        n = unit(normal, np.zeros(1, dtype=np.int64), "edge")[0]
        kinds.append(Plane(n, float(np.mean(points[domain.edges[chosen]] @ n))))
    for edges, angle in leans:
        labels[boundary_edges(domain, edges)] = len(kinds)
        kinds.append(Lean(checked_lean(angle)))
    return Conditions(labels, kinds)


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
    rim: Rim,
    marks: list[Int],
    parts: Sequence[RimVolume],
    moving_holes: bool,
    solver: HarmonicSolver,
) -> SpanProblem:
    layout = flat_layout(domain, points) if _has_moduli(marks, moving_holes) else None
    if layout is not None and layout[0] is not domain:
        domain, solver = layout[0], HarmonicSolver(layout[0])
    dirichlet = solver.dirichlet(domain.boundary_vertices.astype(np.int64))
    places = [np.searchsorted(dirichlet.fixed, loop) for loop in loops]
    positions = points[:, :2] if layout is None else layout[1]
    omegas = rim_angles(dirichlet, domain.vertex_areas, places, [_lengths(domain, loop) for loop in loops])
    fields = np.zeros((0, *positions.shape))
    if layout is not None:
        fields = plan_fields(dirichlet, positions, loops, angles(omegas[0]), marks, moving_holes)
    return SpanProblem(
        domain=domain,
        solver=solver,
        coordinates=Coordinates(dirichlet),
        rim=rim,
        motions=Motions(domain, positions, fields),
        volume=Volume(domain, parts),
        loops=places,
        omegas=omegas,
        marks=marks,
        has_gauge=len(loops) == 1 or (moving_holes and layout is not None),
        moving_holes=moving_holes,
        walls=Walls.under(rim),
        drawn=positions[dirichlet.fixed],
        kernel=douglas_kernel(omegas, places, rim.count),
    )


def _rim_volumes(domain: Domain, conditions: Conditions) -> list[RimVolume]:
    """The volumes over walls, and over mirrors that do not go through the origin."""
    parts: list[RimVolume] = []
    if len(over := conditions.edges_of(Lean)):
        parts.append(OverWalls(domain.edges[over].astype(np.int64)))
    for k, kind in enumerate(conditions.kinds):
        if isinstance(kind, Plane) and kind.offset:
            pairs = domain.edges[conditions.labels == k].astype(np.int64)
            parts.append(OverPlanes(pairs, np.tile(-kind.offset / 6.0 * kind.normal, (len(pairs), 1))))
    return parts


def _has_moduli(marks: Sequence[Int], moving_holes: bool) -> bool:
    """Whether the conformal type of the plan may have to change: around holes, and between four marked points."""
    return (len(marks) > 1 and moving_holes) or len(marks[0]) > 3


def _lengths(domain: Domain, loop: Int) -> Array:
    """(n,) the domain's boundary length at each vertex of a loop: half of its two edges."""
    edges = domain.boundary_edges
    halves = np.repeat(0.5 * domain.edge_lengths[edges], 2)
    return sum_rows(domain.edges[edges].ravel(), halves, domain.vertex_count)[loop]
