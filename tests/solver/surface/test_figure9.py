"""Shells that touch walls and stand on a floor at right angles: the paper's Figure 9."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Domain, complete, mean_curvature_of
from solver.catalogue import modules
from solver.measure import self_intersections
from tests.solver import fundamental_pieces as pieces
from tests.solver.exact_surfaces import rates

MESHES = (0.2, 0.1, 0.05)


def vault(openings: int, foot, h: float, **options) -> pieces.Piece:
    """Constant normals along the walls, mirrors in the floor along the feet."""
    module = modules.vault(openings, foot, max_edge=h, **options)
    walls = {name: "tangent" for name in module.normals if name.startswith("wall")}
    return pieces.between_mirrors(module, walls, tolerance=1e-9)


def curvature_errors(surface) -> tuple[float, float, float]:
    """L² of H - ½ over ½: everywhere, on faces that touch the boundary, and on those that do not."""
    points, faces = surface.f_plus, surface.faces
    a, b, c = (points[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    H = mean_curvature_of(points, faces, surface.normals)
    rim = np.isin(faces, surface.domain.boundary_vertices).any(axis=1)
    return tuple(
        2.0 * float(np.sqrt(np.average((H - 0.5)[on] ** 2, weights=areas[on])))
        for on in (np.ones(len(H), bool), rim, ~rim)
    )


@pytest.mark.parametrize(("openings", "foot", "length"), [(3, 0.6, 1.0), (4, 0.5, 1.0), (4, 0.4, 1.6), (5, 0.3, 1.0)])
def test_walls_are_touched_and_feet_are_orthogonal_to_the_floor(openings, foot, length):
    curvature, sizes, levels = [], [], []
    for h in MESHES:
        piece = vault(openings, foot, h, length=length)
        surface = piece.surface
        assert surface.status.value == "converged" and not surface.is_open
        planes = [complete(surface, [side]).planes[0] for side in piece.sides]
        assert max(plane.relative for plane in planes) < 1e-10  # planar to rounding, on every mesh
        for plane in planes:
            N = surface.normals[plane.cut_vertices]
            if plane.kind == "tangent":
                assert_allclose(N, np.tile(plane.normal, (len(N), 1)), atol=1e-12)
                wall = surface.f_plus[plane.cut_vertices] @ plane.normal
                assert_allclose(wall, plane.offset + 1.0, atol=1e-9)  # f+ is 1/(2H) outside g
                assert wall.max() > (surface.f_plus @ plane.normal).max() - 1e-9  # the shell is on one side of it
            else:
                assert_allclose(N @ [0, 0, 1], 0.0, atol=1e-12)
        curvature.append(curvature_errors(surface))
        feet = [-plane.offset for plane in planes if plane.kind == "mirror"]
        levels.append(np.ptp(feet))
        sizes.append(np.mean([plane.offset for plane in planes if plane.kind == "tangent"]))
    assert rates([everywhere for everywhere, _, _ in curvature]).mean() > 0.8
    assert curvature[-1][0] < 0.02 and curvature[-1][1] < 4.0 * curvature[-1][2]
    assert rates(np.abs(np.diff(sizes)))[0] > 1.6  # where the walls are, by differences
    assert levels[-1] < 1e-4 and rates([levels[0], levels[-1]])[0] / 2 > 1.4  # symmetric feet are level, of their own
    assert surface.f_plus[:, 2].min() > min(feet) - 1e-9  # nothing below the floor
    assert len(self_intersections(surface.f_plus, surface.faces)) == 0


@pytest.mark.parametrize("openings", [3, 4, 6])
def test_where_the_feet_meet_it_is_a_hemisphere(openings):
    """Radius 1/H = 2, the openings shrunk to points."""
    piece = vault(openings, 0.97, 0.06)
    points = piece.surface.f_plus
    floor = np.mean([complete(piece.surface, [side]).planes[0].offset for side in piece.sides if "foot" in side.name])
    centre = np.append(points[:, :2].mean(axis=0), -floor)
    assert_allclose(np.linalg.norm(points - centre, axis=1), 2.0, atol=0.06)
    openings = [np.ptp(points[np.unique(piece.surface.domain.edges[s.edges])], axis=0) for s in piece.sides[:openings]]
    assert np.max(openings) < 0.02


def test_the_shell_and_its_reflection_in_the_floor():
    piece = vault(4, 0.5, 0.1)
    feet = [side for side in piece.sides if side.kind == "mirror"]
    both = complete(piece.surface, feet)
    assert len(both.copies) == 2 and both.is_whole
    assert len(both.offsets) == 6 and max(offset.distance for offset in both.offsets) < 1e-3
    mesh = both.mesh
    assert mesh.is_oriented and len(mesh.flipped_faces) == 0 and mesh.largest_gap < 1e-3
    lantern = Domain.from_positions(mesh.vertices, mesh.faces)
    assert lantern.euler_characteristic == -2 and len(lantern.boundary_loops) == 4  # a sphere with four windows
    assert len(self_intersections(mesh.vertices, mesh.faces)) == 0


def test_feet_of_different_radii_stand_at_different_heights_and_that_is_told():
    piece = vault(4, (0.3, 0.4, 0.5, 0.6), 0.1, length=1.3)
    feet = [side for side in piece.sides if side.kind == "mirror"]
    names = [side.name for side in feet]
    heights = -np.array([plane.offset for plane in complete(piece.surface, feet, copies=1).planes])
    assert (np.diff(heights) > 0.05).all()  # wider feet stand higher
    level = complete(piece.surface, feet, coplanar=[names])
    assert_allclose(max(offset.distance for offset in level.offsets), np.ptp(heights), rtol=1e-9)
    assert level.mesh.is_oriented and len(level.copies) == 2
    assert_allclose(np.ptp(level.mesh.vertices[level.members[0]][level.planes[0].cut_vertices][:, 2]), 0.0, atol=1e-9)
