"""Columns that flare into a ceiling: modules with a mirror in the floor, and a side that touches ceiling or ball."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import complete
from solver.catalogue import modules
from solver.measure import self_intersections
from tests.solver import fundamental_pieces as pieces

UPRIGHT = ("front", "right", "back", "left", "diagonal")


def hall(piece, repeat: int = 2):
    """Bays side by side: copies across the upright planes only."""
    return complete(piece.surface, [side for side in piece.sides if side.name in UPRIGHT], repeat=repeat)


def embedded(whole) -> bool:
    mesh = whole.mesh
    assert mesh.is_oriented and len(mesh.flipped_faces) == 0 and mesh.largest_gap < 1e-6
    return len(self_intersections(mesh.vertices, mesh.faces)) == 0


def ring(bays, piece, name: str) -> tuple[float, float]:
    """Length and enclosed area (seen from above) of the closed curve that a side's copies make around its axis."""
    edges = piece.surface.domain.edges[next(side.edges for side in piece.sides if side.name == name)]
    points = bays.piece("f+")[:, :2]
    walls = [(np.append(plane.normal[:2], plane.offset)) for plane in bays.planes]
    on = np.unique(edges)
    near = sorted(walls, key=lambda wall: np.abs(points[on] @ wall[:2] - wall[2]).min())[:2]
    axis = np.linalg.solve([wall[:2] for wall in near], [wall[2] for wall in near])
    a, b = (points[edges[:, k]] - axis for k in (0, 1))
    full = 2.0 * np.pi / np.arccos(abs(near[0][:2] @ near[1][:2]))
    area = 0.5 * np.abs(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    return full * float(np.linalg.norm(b - a, axis=1).sum()), full * float(area)


def bay_area(bays) -> float:
    return float(np.linalg.norm(np.cross(*bays.lattice)))


def test_columns_under_a_ceiling():
    """A quarter of a bay, four mirrors, the column's side a fifth in the floor; 3 × 3 columns, embedded."""
    spans, balance = [], []
    for h in (0.04, 0.02):
        piece = pieces.between_mirrors(modules.capital(0.4, max_edge=h))
        bays = hall(piece, repeat=3)
        assert len(bays.copies) == 36 and embedded(bays)
        assert_allclose(bays.lattice[0] @ bays.lattice[1], 0.0, atol=1e-9)
        spans.append(np.linalg.norm(bays.lattice, axis=1))
        length, area = ring(bays, piece, "column")
        balance.append(length / (bay_area(bays) - area))
    assert embedded(complete(piece.surface, piece.sides))  # above and below the floor
    assert_allclose(spans[1], spans[0], rtol=5e-3)
    assert_allclose(spans[1][0], spans[1][1], rtol=1e-4)  # the mesh is not symmetric about the diagonal, the surface is
    # pressure 2 H on the ceiling hangs on the column: the tension along its ring
    assert abs(balance[1] - 1.0) < 0.02 and abs(balance[1] - 1.0) < 0.7 * abs(balance[0] - 1.0)


@pytest.mark.parametrize(("kind", "radius", "oculus"), [
    ("tangent", 0.4, 0.4), ("tangent", 0.2, 0.7), ("tangent", 0.6, 0.6), ("free", 0.4, 0.2), ("free", 0.4, 0.4),
])  # fmt: skip
def test_four_mirrors_and_a_side_that_touches_the_ceiling_or_a_ball(kind, radius, oculus):
    """An eighth of a bay; and the quarter, which has the diagonal plane by itself."""
    module = modules.capital(radius, oculus=oculus, eighth=True, max_edge=0.025)
    piece = pieces.between_mirrors(module, {"oculus": kind})
    assert sorted(side.kind for side in piece.sides) == sorted(["mirror"] * 4 + [kind])
    bays = hall(piece)
    assert len(bays.copies) == 32 and set(bays.sheets) == {"f+"} and embedded(bays)
    whole = complete(piece.surface, piece.sides)
    assert whole.sheets.count("f+") == whole.sheets.count("f-") == 16 and len(whole.lattice) == 3
    rim = next(plane for plane in whole.planes if plane.name == "oculus")
    points = piece.surface.f_plus[rim.cut_vertices]
    if kind == "tangent":
        assert_allclose(points[:, 2], rim.offset + 1.0, atol=1e-9)
        assert points[:, 2].max() > piece.surface.f_plus[:, 2].max() - 2e-3  # the ceiling
        length, column = ring(bays, piece, "column")
        _, opening = ring(bays, piece, "oculus")
        assert_allclose(length, bay_area(bays) - column - opening, rtol=0.08)
    else:
        assert_allclose(np.linalg.norm(points - rim.point, axis=1), 1.0, atol=3e-3)
    other = pieces.between_mirrors(modules.capital(radius, oculus=oculus, max_edge=0.03), {"oculus": kind})
    assert_allclose(np.linalg.norm(hall(other).lattice, axis=1), np.linalg.norm(bays.lattice, axis=1), rtol=1e-2)


def test_a_ring_that_touches_the_floor_encloses_a_whole_bay():
    """No vertical force at such a foot, so nothing is left for the pressure: as much of the surface, seen from above,
    looks down as up. In a grid these rings cross; f- continues below the floor."""
    for radius in (0.05, 0.1, 0.2):
        piece = pieces.between_mirrors(modules.capital(radius, max_edge=0.03), {"column": "tangent"})
        bays = hall(piece, repeat=1)
        assert_allclose(ring(bays, piece, "column")[1], bay_area(bays), rtol=0.03)
    assert not embedded(hall(piece))
    both = complete(piece.surface, piece.sides)
    assert sorted(both.sheets) == ["f+"] * 4 + ["f-"] * 4
    down = next(plane for plane in both.planes if plane.name == "column")
    assert_allclose(piece.surface.f_plus[down.cut_vertices] @ down.normal, down.offset + 1.0, atol=1e-9)


def test_with_a_free_foot_nothing_holds_the_column():
    """Constant normals fulfil every condition, have no energy, and are the solution: a status says so."""
    piece = pieces.between_mirrors(modules.capital(0.4, max_edge=0.05), {"column": "free"})
    assert piece.surface.status.value == "collapsed" and piece.surface.harmonic.energy < 1e-12
