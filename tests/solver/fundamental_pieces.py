"""Fundamental pieces of exact surfaces, solved between their mirrors and planes, with named sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ellipe, ellipj, ellipk

from solver import CmcSurface, Domain, Side, conditions, solve_cmc
from solver.catalogue import modules
from solver.meshing.mesher import mesh_plan
from tests.solver import exact_surfaces


@dataclass(frozen=True, eq=False)
class Piece:
    """A solved surface, its sides, and the plan or unrolled positions (V, 2) of its vertices."""

    surface: CmcSurface
    sides: list[Side]
    points: np.ndarray


def edges_where(domain: Domain, points: np.ndarray, test) -> np.ndarray:
    """Boundary edges whose two ends both pass the test of positions (n, 2)."""
    edges = domain.boundary_edges
    return edges[test(points[domain.edges[edges]].reshape(-1, 2)).reshape(-1, 2).all(axis=1)]


def cylinder(height: float, columns: int):
    """A jittered cylinder, its unrolled points, and the edges of its two ends."""
    domain, points = exact_surfaces.cylinder(height, columns)
    ends = [edges_where(domain, points, lambda p, y=y: np.abs(p[:, 1] - y) < 1e-9) for y in (0.0, height)]
    return domain, points, *ends


def nodoid(c: float, columns: int) -> Piece:
    """A nodoid between the planes it touches, normals e₁ and -e₁ (paper, Fig. 14)."""
    domain, points, bottom, top = cylinder(nodoid_height(c), columns)
    ends = conditions.fixed(domain, bottom, (1, 0, 0)) + conditions.fixed(domain, top, (-1, 0, 0))
    surface = solve_cmc(domain, ends, degree=-1)
    return Piece(surface, [Side("bottom", bottom, "tangent"), Side("top", top, "tangent")], points)


def nodoid_height(c: float) -> float:
    return 2.0 / np.sqrt(c) * ellipk(-1.0 / c)


def nodoid_length(c: float) -> float:
    """∫ sin²ψ ds between the planes of g: half a period."""
    return 2.0 * np.sqrt(c) * (ellipe(-1.0 / c) - ellipk(-1.0 / c))


def unduloid_normals(c: float, points: np.ndarray) -> np.ndarray:
    """N (n, 3) at (t, s): horizontal at s = 0, steepest at s = K(1 + c), where ψ' vanishes."""
    t, s = points.T
    k2 = 1.0 + c
    sn, _, dn, _ = ellipj(s, k2)
    return np.column_stack([dn * np.cos(t), dn * np.sin(t), -np.sqrt(k2) * sn])


def unduloid(c: float, columns: int, free: bool = False) -> Piece:
    """An unduloid from neck to belly, both mirrors; or half of that, to a free circle in between."""
    height = ellipk(1.0 + c) * (1 if free else 2)
    domain, points, bottom, top = cylinder(height, columns)
    N = unduloid_normals(c, points)
    fixed = np.unique(domain.edges[bottom if free else np.concatenate([bottom, top])])
    surface = solve_cmc(domain, conditions.fixed_at(domain, fixed, N[fixed]), initial=N)
    last = Side("top", top, "free") if free else Side("top", top, "mirror", (0, 0, 1))
    return Piece(surface, [Side("bottom", bottom, "mirror", (0, 0, -1)), last], points)


def unduloid_period(c: float) -> float:
    return 4.0 * ellipe(1.0 + c)


def sphere_eighth(n: int) -> Piece:
    """An eighth of a sphere of radius 2, over a quarter of a disc with n edges along the arc."""
    angle = np.linspace(0.0, np.pi / 2, n + 1)
    plan = mesh_plan(np.vstack([[0.0, 0.0], np.column_stack([np.cos(angle), np.sin(angle)])]), max_edge=1.6 / n)
    domain, points = Domain.from_positions(plan.positions, plan.triangles), plan.positions
    rim = domain.boundary_vertices
    surface = solve_cmc(domain, conditions.fixed_at(domain, rim, exact_surfaces.hemisphere(points)[rim]))
    left, front = (edges_where(domain, points, lambda p, k=k: np.abs(p[:, k]) < 1e-9) for k in (0, 1))
    floor = np.setdiff1d(domain.boundary_edges, np.concatenate([left, front]))
    sides = [Side("left", left, normal=(1, 0, 0)), Side("front", front, normal=(0, 1, 0))]
    return Piece(surface, [*sides, Side("floor", floor, normal=(0, 0, 1))], points)


HELD = {
    "mirror": conditions.mirror,
    "tangent": conditions.fixed,
    "free": lambda domain, edges, normal: conditions.free(domain, edges),
}


def between_mirrors(module: modules.Module, kinds: dict[str, str] | None = None, **options) -> Piece:
    """A module solved with a mirror on every side, except sides with another kind in `kinds`."""
    domain, sides = module.shape.domain, []
    held = conditions.Conditions()
    for name, edges in module.shape.sides.items():
        kind, normal = (kinds or {}).get(name, "mirror"), module.normals[name]
        held += HELD[kind](domain, edges, normal)
        sides.append(Side(name, edges, kind, None if kind == "free" else normal))
    return Piece(solve_cmc(domain, held, **options), sides, module.shape.positions)
