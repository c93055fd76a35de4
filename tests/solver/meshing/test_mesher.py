"""The mesher: well-shaped triangles over plans of every kind, the same at each scale and place."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import MeshError
from solver.meshing.mesher import PlanMesh, mesh_plan
from solver.meshing.outline import check_loops, inside
from solver.meshing.quality import smallest_angles
from solver.meshing.triangulate import triangulate
from tests.solver.drawn_outlines import L_SHAPE, SQUARE, check, ellipse


def star(points: int) -> np.ndarray:
    k = np.arange(2 * points)
    r = np.where(k % 2, 2.0, 6.0)
    return np.column_stack([r * np.cos(k * np.pi / points), r * np.sin(k * np.pi / points)])


def spiral() -> np.ndarray:
    a = np.linspace(0, 4 * np.pi, 300)
    ray = np.column_stack([np.cos(a), np.sin(a)])
    return np.concatenate([(5 + 0.9 * a)[:, None] * ray, ((2 + 0.9 * a)[:, None] * ray)[::-1]])


def blob() -> np.ndarray:
    t = 2 * np.pi * np.arange(200) / 200
    r = 8 + 1.2 * np.cos(2 * t + 0.3) + np.cos(3 * t + 1) + 0.6 * np.cos(5 * t + 2)
    return np.column_stack([r * np.cos(t), r * np.sin(t)])


def comb() -> np.ndarray:
    teeth = [(3 * k + dx, y) for k in range(6) for dx, y in [(0, 0), (0, 8), (1.5, 8), (1.5, 0)]]
    return np.array([(0, -2), *teeth[1:-1], (16.5, -2)], dtype=float)[::-1]


def corridor() -> np.ndarray:
    t = np.linspace(0, 1, 60)
    centre = np.column_stack([4 * t, 0.5 * np.sin(9 * t)])
    along = np.gradient(centre, axis=0)
    left = 0.19 * np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return np.concatenate([centre - left, (centre + left)[::-1]])


def skyline() -> np.ndarray:
    """Towers with a step of 0.013 in one of them, far from which large triangles have their circumcentres."""
    roof = [
        (3.089, 1.475),
        (2.094, 1.475),
        (2.094, 0.497),
        (1.504, 0.497),
        (1.504, 1.323),
        (1.145, 1.323),
        (1.145, 1.307),
        (0.817, 1.307),
        (0.817, 1.796),
        (0.486, 1.796),
        (0.486, 0.219),
        (0.414, 0.219),
    ]
    return np.array([(0.414, 0.0), (3.089, 0.0), *roof])


COLUMNS = [ellipse(25, 0.35, 0.35, (x, y)) for x in range(2, 19, 4) for y in range(2, 11, 4)]
HALL = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 12.0], [0.0, 12.0]])
SLIT = np.array([[0, 0], [10, 0], [10, 6], [5.02, 6], [5.02, 1.5], [5, 1.5], [5, 6], [0, 6]], dtype=float)

ZOO = {
    "square": dict(outline=SQUARE, max_edge=0.7),
    "L": dict(outline=L_SHAPE, max_edge=0.6),
    "rounded L": dict(outline=L_SHAPE, max_edge=0.6, corner_radius=1.0),
    "thin": dict(outline=SQUARE * [2, 0.05], max_edge=1.0),
    "rounded star": dict(outline=star(7), max_edge=0.4, corner_radius=0.5),
    "courtyard": dict(outline=HALL, holes=[[(8, 4), (13, 4), (13, 8), (8, 8)]], max_edge=0.6, corner_radius=0.8),
    "columns": dict(outline=HALL, holes=COLUMNS, max_edge=0.6),
    "pavilion": dict(outline=SQUARE * [1, 0.6], max_edge=0.5, corner_radius=2.0),
    "spiral": dict(outline=spiral(), max_edge=0.8),
    "blob": dict(outline=blob(), max_edge=0.7),
    "comb": dict(outline=comb(), max_edge=0.6),
    "slit": dict(outline=SLIT, max_edge=0.5),
    "circle": dict(outline=ellipse(100, 1, 1), max_edge=0.12),
    "huge radius": dict(outline=L_SHAPE, max_edge=0.6, corner_radius=100.0),
    "flat": dict(outline=SQUARE * [1, 0.35], max_edge=0.9),
    "corridor": dict(outline=corridor(), max_edge=0.2),
    "skyline": dict(outline=skyline(), max_edge=0.0535, corner_radius=0.27),
    "coarse": dict(outline=L_SHAPE, max_edge=9.0),
}


def smallest(mesh: PlanMesh) -> float:
    return np.degrees(smallest_angles(mesh.positions, mesh.triangles).min())


def bridges(mesh: PlanMesh) -> int:
    """Inner edges between two boundary vertices."""
    ends = np.sort(np.concatenate([np.roll(mesh.triangles, k, axis=1)[:, :2] for k in range(3)]), axis=1)
    edges, faces = np.unique(ends, axis=0, return_counts=True)
    return int(np.sum((edges < len(mesh.edges)).all(axis=1) & (faces == 2)))


@pytest.mark.parametrize("name", ZOO)
def test_every_plan_is_meshed_well(name):
    mesh = mesh_plan(**ZOO[name])
    domain = check(mesh)
    assert smallest(mesh) > 30
    assert bridges(mesh) == 0, "N would be given all around a triangle"
    assert domain.edge_lengths.max() < 1.45 * ZOO[name]["max_edge"]
    assert domain.edge_lengths[domain.boundary_edges].max() <= ZOO[name]["max_edge"] * (1 + 1e-9)


@pytest.mark.parametrize("name", ["square", "blob", "L", "pavilion"])
def test_wide_plans_have_the_wanted_edge_length(name):
    mesh = mesh_plan(**ZOO[name])
    lengths = check(mesh).edge_lengths / ZOO[name]["max_edge"]
    assert 0.95 < np.median(lengths) < 1.05
    assert lengths.min() > 0.5
    angles = np.degrees(smallest_angles(mesh.positions, mesh.triangles))
    assert angles.mean() > 53


def test_finer_meshes_are_equilateral_away_from_the_rim():
    mesh = mesh_plan(SQUARE, max_edge=0.12)
    check(mesh)
    angles = np.degrees(smallest_angles(mesh.positions, mesh.triangles))
    assert np.mean(angles > 59.9) > 0.6


@pytest.mark.parametrize("seed", range(24))
def test_random_plans(seed):
    mesh, sharpest = random_plan(np.random.default_rng(seed))
    check(mesh)
    # A sharp corner cannot be better than it is, and is divided only where that leaves more than about 22°.
    assert smallest(mesh) > min(28.0, 0.45 * sharpest)


def random_plan(random: np.random.Generator) -> tuple[PlanMesh, float]:
    """A jagged, a smooth or a stepped outline with a few random holes, and the sharpest inner angle of its mesh."""
    kind = random.integers(3)
    if kind == 0:
        angle = np.cumsum(random.uniform(0.3, 1.0, random.integers(5, 40)))
        angle *= 2 * np.pi / (angle[-1] + 0.5)
        outline = random.uniform(0.4, 1, (len(angle), 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    elif kind == 1:
        outline = ellipse(300, 1, random.uniform(0.1, 1))
        t = 2 * np.pi * np.arange(300) / 300
        wave = sum(random.normal() * 0.3 / k * np.cos(k * t + random.uniform(0, 6)) for k in range(1, 8))
        outline *= np.maximum(1 + wave, 0.15)[:, None]
    else:
        x, y = np.cumsum(random.uniform(0.05, 1, 9)), random.uniform(0.1, 2, 8)
        steps = [p for k in range(7, -1, -1) for p in [(x[k + 1], y[k]), (x[k], y[k])]]
        outline = np.array([(x[0], 0), (x[-1], 0), *steps])
    size = np.ptp(outline, axis=0).max()
    holes = []
    for _ in range(random.integers(0, 5)):
        hole = ellipse(random.integers(3, 9), 0.04 * size, 0.03 * size, random.uniform(-0.4, 0.4, 2) * size)
        try:
            check_loops(outline, [*holes, hole])
        except MeshError:
            continue  # outside, or across another one
        holes.append(hole)
    mesh = mesh_plan(
        outline, holes, max_edge=size * random.choice([0.04, 0.1, 0.3]), corner_radius=size * random.choice([0, 0.03])
    )
    before = np.empty(len(mesh.edges), dtype=int)
    before[mesh.edges[:, 1]] = mesh.edges[:, 0]
    ahead = mesh.positions[mesh.edges[:, 1]] - mesh.positions[mesh.edges[:, 0]]
    back = mesh.positions[before] - mesh.positions[mesh.edges[:, 0]]
    cross = ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0]
    return mesh, float(np.min(np.degrees(np.arctan2(cross, np.sum(ahead * back, axis=1))) % 360))


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**20])
def test_scale_does_not_matter(scale):
    plan = mesh_plan(HALL, COLUMNS[:4], max_edge=0.75, corner_radius=0.5)
    other = mesh_plan(HALL * scale, [c * scale for c in COLUMNS[:4]], max_edge=0.75 * scale, corner_radius=0.5 * scale)
    assert_array_equal(plan.triangles, other.triangles)
    assert_allclose(other.positions, plan.positions * scale, rtol=1e-12)


def test_place_does_not_matter():
    offset = np.array([4.5e6, -3.2e5])  # metres in a national grid
    plan = mesh_plan(L_SHAPE, max_edge=0.5, corner_radius=1.0)
    far = mesh_plan(L_SHAPE + offset, max_edge=0.5, corner_radius=1.0)
    check(far)
    assert len(far.edges) == len(plan.edges)
    assert_allclose(far.positions[: len(far.edges)] - offset, plan.positions[: len(plan.edges)], atol=1e-8)
    assert smallest(far) > 30


def test_repeated_last_point_and_direction_do_not_matter():
    closed = np.concatenate([L_SHAPE, L_SHAPE[:1]])
    assert_array_equal(mesh_plan(closed, max_edge=0.9).positions, mesh_plan(L_SHAPE, max_edge=0.9).positions)
    turned = np.concatenate([L_SHAPE[:1], L_SHAPE[:0:-1]])
    assert_array_equal(mesh_plan(turned, max_edge=0.9).positions, mesh_plan(L_SHAPE, max_edge=0.9).positions)


def test_the_same_plan_gives_the_same_mesh():
    one, two = (mesh_plan(**ZOO["courtyard"]) for _ in range(2))
    assert_array_equal(one.positions, two.positions)
    assert_array_equal(one.triangles, two.triangles)


def test_a_boundary_edge_that_delaunay_misses_is_recovered():
    # Two long edges a hair apart with points in between on the far side of each.
    points = np.array([[1, 0], [9, 0], [9, 0.1], [5, 0.05], [1, 0.1], [0, -3], [10, -3], [10, 3], [0, 3]], dtype=float)
    edges = np.array([[5, 6], [6, 7], [7, 8], [8, 5], [0, 4], [4, 3], [3, 2], [2, 1], [1, 0]])
    triangles = triangulate(points, edges)
    used = np.sort(np.concatenate([np.roll(triangles, k, axis=1)[:, :2] for k in range(3)]), axis=1)
    assert set(map(tuple, np.sort(edges, axis=1).tolist())) <= set(map(tuple, used.tolist()))
    corners = points[triangles]
    area = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2
    assert (area > 0).all()
    assert_allclose(area.sum(), 60 - 0.6, rtol=1e-12)


def test_inside_follows_the_even_odd_rule():
    hole = np.array([[4.0, 4.0], [6.0, 4.0], [6.0, 6.0], [4.0, 6.0]])
    starts = np.concatenate([SQUARE, hole])
    ends = np.concatenate([np.roll(SQUARE, -1, axis=0), np.roll(hole, -1, axis=0)])
    points = np.random.default_rng(5).uniform(-2, 12, (500, 2))
    expected = np.all((points > 0) & (points < 10), axis=1) & ~np.all((points > 4) & (points < 6), axis=1)
    assert_array_equal(inside(points, starts, ends), expected)
