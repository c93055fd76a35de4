"""The planes of several sides, made consistent, and the corners where two sides meet.

Copies close up around a corner only if the planes satisfy the relations of a reflection group. These are imposed: sides
of one plane get one offset, the centre of a free side moves into the planes of its neighbours, and the angle at a
corner must be a whole part of 180°.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.frames import boundary_edges
from ..surface.cmc_surface import CmcSurface
from .sides import RULES, Side, SidePlane, SymmetryError, side_plane, surface_size

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Parallel planes nearer to each other than this part of the surface's size count as one.
COPLANAR = 0.005
# A side farther than this part of the size from a plane does not lie in one.
_PLANAR = 0.1
# Directions that differ by less than this sine count as the same: half a degree.
_PARALLEL = 0.01
# Largest number of mirrors through one corner.
_LARGEST_ORDER = 12


@dataclass(frozen=True)
class Corner:
    """A vertex where two sides meet.

    plane_angle: between their planes, in (0, π/2], 0 for one and the same plane. domain_angle: of the domain there.
    order: k, if the planes generate 2 k copies around the corner. turns: how often those copies go around it,
    k × domain_angle / π: 1 if the angle of the domain is that of the surface; another whole number is a branch point,
    and any other value an angle that slows convergence down.
    """

    sides: tuple[str, str]
    vertex: int
    plane_angle: float
    domain_angle: float
    order: int

    @property
    def turns(self) -> float:
        return self.order * self.domain_angle / np.pi


@dataclass(frozen=True)
class Offset:
    """Two sides in one plane, and the distance at which they were measured (a length in the units of the surface)."""

    sides: tuple[str, str]
    distance: float


@dataclass(frozen=True, eq=False)
class Arrangement:
    """planes: of the sides, in their order, after the relations were imposed. measured: before that.

    offsets: of sides that lie in one plane. corners: where two sides meet.
    """

    planes: list[SidePlane]
    measured: list[SidePlane]
    offsets: list[Offset]
    corners: list[Corner]

    @property
    def narrowest(self) -> float:
        """The least distance of two parallel planes that are not one; infinite without such a pair."""
        apart = [_distance(a, b) for j, b in enumerate(self.planes) for a in self.planes[:j]]
        together = {offset.sides for offset in self.offsets}
        names = [(a.name, b.name) for j, b in enumerate(self.planes) for a in self.planes[:j]]
        return min((d for d, pair in zip(apart, names, strict=True) if pair not in together), default=np.inf)


def arrange(surface: CmcSurface, sides: Sequence[Side], coplanar: Sequence[Sequence[str]] = ()) -> Arrangement:
    """The planes of `sides`, related as they must be for copies to close up.

    coplanar: groups of names of sides that lie in one plane, at whatever distance they were measured.
    Raises `SymmetryError` naming the sides that contradict each other.
    """
    _check_names(sides, coplanar)
    owner = _owners(surface.domain, sides)
    measured = [side_plane(surface, side) for side in sides]
    for plane in measured:
        _check_one_piece(surface, plane)
        if plane.relative > _PLANAR:
            raise SymmetryError(
                f"Side {plane.name!r} does not lie in a plane{' or at a point' if plane.normal is None else ''}: it is "
                f"up to {plane.relative:.0%} of the size away; refine the mesh, or give the side another kind."
            )
    corners = [_corner(surface.domain, measured[i], measured[j], vertex) for i, j, vertex in _meetings(surface, owner)]
    together = [*coplanar, *(corner.sides for corner in corners if corner.order == 1)]
    planes, offsets = _one_plane(measured, together, COPLANAR * surface_size(surface))
    return Arrangement(_centred(planes, corners), measured, offsets, corners)


def _check_one_piece(surface: CmcSurface, plane: SidePlane) -> None:
    """Refuse a side where a cut ends, if the surface jumps out of the side's plane across the cut."""
    _, first, vertex = np.unique(surface.source[plane.cut_vertices], return_index=True, return_inverse=True)
    jumps = surface.g[plane.cut_vertices] - surface.g[plane.cut_vertices[first]][vertex.ravel()]
    out = np.linalg.norm(jumps, axis=1) if plane.normal is None else np.abs(jumps @ plane.normal)
    if out.max() > COPLANAR * surface_size(surface):
        raise SymmetryError(
            f"Side {plane.name!r} lies in two planes, {out.max():.3g} apart, since the surface is cut open and the cut "
            "ends there; close the period first, or leave out this side."
        )


def _check_names(sides: Sequence[Side], coplanar: Sequence[Sequence[str]]) -> None:
    if any(isinstance(group, str) for group in coplanar):
        raise SymmetryError("Give sides of one plane as lists of names, one list for each plane.")
    names = [side.name for side in sides]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise SymmetryError(f"Two sides are called {', '.join(map(repr, twice))}; give every side a name of its own.")
    unknown = sorted({name for group in coplanar for name in group} - set(names))
    if unknown:
        raise SymmetryError(f"There is no side {', '.join(map(repr, unknown))}; known are {', '.join(names)}.")


def _owners(domain: Domain, sides: Sequence[Side]) -> Int:
    """(E,) the side each edge is on, -1 for none."""
    owner = np.full(len(domain.edge_lengths), -1, dtype=np.int64)
    for k, side in enumerate(sides):
        edges = boundary_edges(domain, side.edges)
        taken = edges[owner[edges] >= 0]
        if taken.size:
            other = sides[int(owner[taken[0]])].name
            raise SymmetryError(
                f"Sides {other!r} and {side.name!r} both have {len(taken)} of their edges; give each edge to one side.",
                edges=taken,
            )
        owner[edges] = k
    return owner


def _meetings(surface: CmcSurface, owner: Int) -> list[tuple[int, int, int]]:
    """(side, side, vertex) at every vertex where one side ends and another one begins along the boundary."""
    meetings = []
    domain = surface.domain
    for vertices, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        here = owner[np.asarray(edges)]
        before = np.roll(here, 1)
        for at in np.flatnonzero((here != before) & (here >= 0) & (before >= 0)):
            meetings.append((int(before[at]), int(here[at]), int(vertices[at])))
    return meetings


def _corner(domain: Domain, a: SidePlane, b: SidePlane, vertex: int) -> Corner:
    angle = float(domain.corner_angles[domain.faces == vertex].sum())
    if a.normal is None or b.normal is None:  # a free side is a point of the other's plane
        order = 1 if a.normal is None and b.normal is None else 2
        return Corner((a.name, b.name), vertex, 0.0 if order == 1 else np.pi / 2, angle, order)
    sine = float(np.linalg.norm(np.cross(a.normal, b.normal)))
    cosine = float(a.normal @ b.normal)
    between = float(np.arctan2(sine, abs(cosine)))
    what = f"Sides {a.name!r} and {b.name!r} meet at vertex {vertex}"
    if RULES[a.kind].switches and RULES[b.kind].switches and not (sine < _PARALLEL and cosine > 0):
        raise SymmetryError(
            f"{what}, but the surface cannot touch two planes there; make one a mirror.", vertices=[vertex]
        )
    if a.kind != b.kind and abs(cosine) > _PARALLEL:
        raise SymmetryError(
            f"{what}, where the surface touches one plane and is orthogonal to the other, so the planes must be at "
            f"90° and are at {np.degrees(between):.1f}°; turn one of the normals.",
            vertices=[vertex],
        )
    if sine < _PARALLEL:
        return Corner((a.name, b.name), vertex, 0.0, angle, 1)
    part = Fraction(between / np.pi).limit_denominator(_LARGEST_ORDER)
    if abs(between - np.pi * float(part)) > _PARALLEL:
        raise SymmetryError(
            f"{what}, where their planes are at {np.degrees(between):.2f}°, so copies never close up around it; the "
            f"angle must be 180°/k or a multiple of it, such as {180 * float(part):.4g}°.",
            vertices=[vertex],
        )
    return Corner((a.name, b.name), vertex, between, angle, part.denominator)


def _one_plane(
    planes: Sequence[SidePlane], together: Sequence[Sequence[str]], tolerance: float
) -> tuple[list[SidePlane], list[Offset]]:
    """Planes that are (meant to be) the same get their mean offset; also how far apart they were."""
    related = list(planes)
    group = list(range(len(planes)))
    offsets = []
    for j, b in enumerate(planes):
        for i, a in enumerate(planes[:j]):
            distance = _distance(a, b)
            meant = any(a.name in names and b.name in names for names in together)
            if meant and not np.isfinite(distance):
                raise SymmetryError(f"Sides {a.name!r} and {b.name!r} cannot lie in one plane: they are not parallel.")
            if not (meant or distance <= tolerance):
                continue
            offsets.append(Offset((a.name, b.name), distance))
            group = [group[i] if k == group[j] else k for k in group]
    for members in ([k for k in range(len(group)) if group[k] == first] for first in sorted(set(group))):
        normal = planes[members[0]].normal
        if normal is None:
            for k in members:
                related[k] = replace(planes[k], point=np.mean([planes[m].point for m in members], axis=0))
            continue
        signs = np.array([_sign(planes[k], normal) for k in members])
        mean = float(np.mean(signs * [planes[k].offset for k in members]))
        for k, sign in zip(members, signs, strict=True):
            related[k] = replace(planes[k], normal=sign * normal, offset=float(sign * mean))
    return related, offsets


def _distance(a: SidePlane, b: SidePlane) -> float:
    """Distance of two parallel planes, or of two centres; infinite for anything else."""
    if a.normal is None or b.normal is None:
        both = a.normal is None and b.normal is None
        return float(np.linalg.norm(a.point - b.point)) if both else np.inf
    if np.linalg.norm(np.cross(a.normal, b.normal)) > _PARALLEL:
        return np.inf
    return abs(a.offset - _sign(b, a.normal) * b.offset)


def _sign(plane: SidePlane, normal: Array) -> float:
    return 1.0 if plane.normal is not None and plane.normal @ normal > 0 else -1.0


def _centred(planes: list[SidePlane], corners: Sequence[Corner]) -> list[SidePlane]:
    """The planes, with the centre of each free side moved into the planes of the sides it meets."""
    by_name = {plane.name: plane for plane in planes}
    result = []
    for plane in planes:
        names = {name for corner in corners if plane.name in corner.sides for name in corner.sides}
        walls = [by_name[name] for name in names if by_name[name].normal is not None]
        if plane.normal is None and walls:
            A = np.array([wall.normal for wall in walls])
            miss = np.array([wall.offset for wall in walls]) - A @ plane.point
            plane = replace(plane, point=plane.point + np.linalg.lstsq(A, miss, rcond=None)[0])
        result.append(plane)
    return result
