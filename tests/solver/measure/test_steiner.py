"""The corner complex: flat panels whose mean curvature by Steiner's formula tends to H."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import conditions, report, shapes, solve_cmc
from solver.measure.steiner import steiner_mean_curvature
from solver.nets.panel_measures import least_width, longest_diagonal
from tests.solver.exact_surfaces import rates


def pavilion(edge: float, **how):
    plan = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=edge, corner_radius=0.8)
    return solve_cmc(plan, conditions.binormal(plan, "outer", tilt=np.radians(40)), tolerance=1e-12, **how)


def by_offsets(surface, sheet: str) -> float:
    """½ A'(0) / A(0) from the areas of the mesh and of its offsets, areas seen from the normals."""
    mesh = surface.as_mesh(sheet, "corner")
    sign = 1.0 if sheet == "f+" else -1.0
    N = sign * mesh.normals

    def area(t: float) -> float:
        total = 0.0
        for polygon in mesh.polygons:
            about = mesh.vertices[polygon] - mesh.vertices[polygon[0]]
            moved = about + t * (N[polygon] - N[polygon[0]])
            still = 0.5 * np.cross(about, np.roll(about, -1, axis=0)).sum(axis=0)
            size = np.linalg.norm(still)
            if size > 1e-14:
                side = still / size * np.sign(still @ N[polygon].sum(axis=0))
                total += 0.5 * float(np.cross(moved, np.roll(moved, -1, axis=0)).sum(axis=0) @ side)
        return total

    h = 1e-4
    return (area(h) - area(-h)) / (4.0 * h) / area(0.0)


def test_it_is_half_the_growth_of_the_area():
    surface = pavilion(0.5, mean_curvature=0.2)
    for sheet in ("f+", "f-"):
        assert steiner_mean_curvature(surface, sheet) == pytest.approx(by_offsets(surface, sheet), rel=1e-6)


def test_it_tends_to_h():
    errors = []
    for edge in (0.2, 0.1, 0.05):
        errors.append(abs(steiner_mean_curvature(pavilion(edge)) - 0.5))
    assert errors[-1] < 1e-4
    assert (rates(errors) > 1.6).all()


def test_all_its_panels_are_flat():
    mesh = pavilion(0.4).as_mesh("f+", "corner")
    for polygon in mesh.polygons:
        corners = mesh.vertices[polygon][None]
        if len(polygon) <= 8:
            assert least_width(corners)[0] < 1e-11 * max(longest_diagonal(corners)[0], 1e-3)


def test_the_report_has_it():
    surface = pavilion(0.3, mean_curvature=0.25)
    assert report(surface).steiner_mean_curvature == pytest.approx(0.25, rel=2e-3)
    twice = report(surface, positions=2.0 * surface.f_plus, intersections=False)
    assert_allclose(2.0 * twice.steiner_mean_curvature, report(surface).steiner_mean_curvature)
    faces = solve_cmc(shapes.disc(200), conditions.binormal(shapes.disc(200), "outer", tilt=0.4), sites="faces")
    assert report(faces).steiner_mean_curvature is None
