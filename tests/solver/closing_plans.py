"""Plans whose surfaces have a gap to close: courtyards, three holes, half a tube between mirrors, a pentagon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver import CmcSurface, Conditions, Domain, Side, close_periods, conditions, shapes
from solver.catalogue import modules
from solver.closing.close import ClosingResult
from solver.closing.moduli import tube
from tests.solver.fundamental_pieces import unduloid_normals

COURTYARDS = {
    "one hole": (1.2, [(0.4, (0.25, 0.1))], (50, 35)),
    "three holes": (1.1, [(0.22, (0.45, 0.3)), (0.22, (-0.45, 0.25)), (0.22, (0.0, -0.5))], (35, 17, 29, 40)),
}


def ring(radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, 480, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + centre


def courtyard(edge: float, name: str = "one hole") -> tuple[shapes.Shape, Conditions]:
    """A round plan with holes off its centre; the tilts of its rims differ and vary by 10° a unit."""
    radius, holes, degrees = COURTYARDS[name]
    shape = shapes.polygon(ring(radius), holes=[ring(*hole) for hole in holes], max_edge=edge)
    held = Conditions()
    for k, tilt in enumerate(degrees):
        edges = shape.sides["outer" if k == 0 else f"hole{k - 1}"]
        middles = shape.positions[shape.domain.edges[edges]].mean(axis=1)
        tilts = np.radians(tilt + 10 * middles[:, min(k, 1)])
        held += conditions.binormal(shape.domain, shape.positions, edges, tilts)
    return shape, held


@dataclass(frozen=True, eq=False)
class HalfTube:
    """Half of an unduloid, cut along a plane through its axis, with part of its domain stretched (see `half_tube`).

    corners: (F, 3, 2) of the faces. tube: those of the half that is `stretch` times too long, along x. held: normals of
    the unduloid along the lower and the upper side, mirrors along the left and the right one.
    """

    domain: Domain
    corners: np.ndarray
    tube: np.ndarray
    held: Conditions
    left: Side
    right: Side


def half_tube(columns: int = 16, stretch: float = 1.35, c: float = -0.4, height: float = 2.0) -> HalfTube:
    """A rectangle of angles t from 0 to π, those in the first half stretched, by lengths s along an unduloid.

    With the stretch undone the mesh is symmetric, so that its left and right side lie exactly in the plane through the
    axis. The number of columns is even.
    """
    rows = max(2, round(height * columns / np.pi))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    lower, right, both, upper = ((i + k) * (rows + 1) + j + m for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    rising, falling = [lower, right, both, lower, both, upper], [lower, right, upper, right, both, upper]
    even = ((i + j) % 2 == 0)[:, None]
    faces = np.where(even, np.column_stack(rising), np.column_stack(falling)).reshape(-1, 3)
    axes = np.linspace(0, np.pi, columns + 1), np.linspace(0, height, rows + 1)
    t, s = (a.ravel() for a in np.meshgrid(*axes, indexing="ij"))
    points = np.column_stack([t + (stretch - 1) * np.minimum(t, np.pi / 2), s])
    domain = Domain.from_positions(points, faces)
    rim = domain.boundary_edges
    middle = t[domain.edges[rim]].mean(axis=1)
    sides = {"left": rim[middle < 1e-9], "right": rim[middle > np.pi - 1e-9]}
    along = np.unique(domain.edges[np.setdiff1d(rim, np.concatenate(list(sides.values())))])
    held = conditions.fixed_at(domain, along, unduloid_normals(c, np.column_stack([t, s]))[along])
    for edges in sides.values():
        held += conditions.mirror(domain, edges, (0, 1, 0))
    tube = np.flatnonzero(t[faces].mean(axis=1) < np.pi / 2)
    mirrors = [Side(name, edges, normal=(0, 1, 0)) for name, edges in sides.items()]
    return HalfTube(domain, points[faces], tube, held, *mirrors)


LENGTH = 2.4
_BEGIN = 1.3  # of the tube, beyond the arc of its floor


@dataclass(frozen=True, eq=False)
class Pentagon:
    """Half a tube of a honeycomb ring and a quarter of its spoke; the right length puts their floors at one height."""

    module: modules.Module
    spoke: float
    held: Conditions
    floors: list[Side]

    def close(self, method: str = "critical") -> ClosingResult:
        shape, axis = self.module.shape, self.module.normals["spoke"][:2]
        across = np.array([-np.sqrt(0.75), 0.5])
        outside = np.flatnonzero(shape.positions[shape.domain.faces].mean(axis=1) @ across > 0.0)
        length = tube(shape.domain, shape.positions[shape.domain.faces], outside, axis, "spoke", beyond=_BEGIN)
        options = {"by": "moduli", "moduli": length, "coplanar": [self.floors], "tolerance": 1e-10}
        return close_periods(shape.domain, self.held, method=method, **options)


def pentagon(spoke: float, max_edge: float) -> Pentagon:
    module = modules.pentagon(LENGTH, spoke, max_edge=max_edge)
    domain, sides, normals = module.shape.domain, module.shape.sides, module.normals
    held = sum((conditions.mirror(domain, edges, normals[name]) for name, edges in sides.items()), Conditions())
    return Pentagon(module, spoke, held, [Side(name, sides[name], "mirror", (0, 0, -1)) for name in ("inner", "outer")])


def spoke_of(closing: ClosingResult, plan: Pentagon) -> float:
    """The length of the spoke after closing."""
    return _BEGIN + (plan.spoke - _BEGIN) * float(np.exp(closing.moduli[0]))


def necks(closing: ClosingResult, plan: Pentagon) -> tuple[float, float]:
    """The radii of the ring's tube and of the spoke at their ends."""
    sides, normals = plan.module.shape.sides, plan.module.normals
    ring, spoke = (neck(closing.surface, sides[name], normals[name]) for name in ("ring", "spoke"))
    return 0.5 * ring, spoke


def neck(surface: CmcSurface, edges: np.ndarray, normal: np.ndarray) -> float:
    """Width of the end of a tube in the plane with that normal, measured level; the radius for a quarter of a tube."""
    rim = surface.f_plus[np.unique(surface.domain.edges[edges])]
    return float(np.ptp(rim @ np.cross(normal, [0.0, 0.0, 1.0])))
