"""Shells with other sites, energies and triangulations, and with dual or corner faces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import KDTree

from solver.errors import ConditionError
from solver.shells.form import form
from solver.shells.plan import Plan, Settings
from solver.shells.polygon_sheets import polygon_sheet
from tests.solver.drawn_plans import disc, grid


def test_a_solver_is_used_again_only_for_its_own_choice():
    """Another site, energy or triangulation makes another one, on the same domain, and another shell."""
    plan = disc(5)
    start = Settings(default_tilt=0.4)
    first = form(plan, start)
    for other in (
        replace(start, sites="faces"),
        replace(start, sites="faces", energy="mobius"),
        replace(start, delaunay=True),
    ):
        again = form(plan, other, solver=first.solver)
        assert again.solver is not first.solver
        assert again.solver.domain is first.solver.domain
        assert_allclose(again.placed["f+"], form(plan, other).placed["f+"], rtol=0, atol=0)
        assert form(plan, replace(other, default_tilt=0.3), solver=again.solver).solver is again.solver
        assert form(plan, start, solver=again.solver).solver is not again.solver
    faces = form(plan, replace(start, sites="faces"))
    assert form(plan, replace(start, sites="faces", energy="dual_cotan"), solver=faces.solver).solver is faces.solver
    mobius = form(plan, replace(start, sites="faces", energy="mobius"), solver=faces.solver)
    assert mobius.solver is not faces.solver


def test_a_start_is_on_the_sites_that_are_solved():
    plan, settings = disc(5), Settings(default_tilt=0.4, sites="faces")
    first = form(plan, settings)
    normals = first.surface.harmonic.normals
    assert len(normals) == len(plan.triangles)
    again = form(plan, settings, initial=normals)
    assert again.report.iterations <= 1
    assert_allclose(again.placed["f+"], first.placed["f+"], atol=1e-6)
    with pytest.raises(ConditionError, match=r"shape \(91, 3\), .*vertices, not \(150, 3\)"):
        form(plan, replace(settings, sites="vertices"), initial=normals)
    with pytest.raises(ConditionError, match=r"shape \(150, 3\), .*faces, not \(91, 3\)"):
        form(plan, settings, initial=form(plan).surface.harmonic.normals)


@pytest.mark.parametrize("sites", ["vertices", "faces"])
@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("faces", ["dual", "corner"])
def test_other_faces_lie_over_the_plan(faces, sites, flip):
    """Between plan and hemisphere, like the triangles: points, normals and sides; g lies half-way between f±."""
    plan = disc(10, centre=(1, 2, 3))
    shell = form(plan, Settings(default_tilt=0.2, ground="rim", flip=flip, sites=sites))
    assert shell.ok
    sheets = {name: polygon_sheet(shell, name, faces) for name in shell.placed}
    f, g, gauss = sheets["f+"], sheets["g"], sheets["gauss"]
    tree = KDTree(shell.placed["f+"])
    distance, nearest = tree.query(f.points)
    assert distance.max() < 0.75
    assert np.einsum("ni,ni->n", f.normals, shell.normals["f+"][nearest]).min() > 0.9
    radius = 0.5 / shell.report.mean_curvature
    assert_allclose(np.linalg.norm(f.points - g.points, axis=1).max(), radius, rtol=0.02)
    # g + N is f+, and the Gauss image is N, beside the plan as the triangles' is
    centre = (shell.placed["gauss"] - shell.placed["f+"] + shell.placed["g"])[0]
    assert_allclose(gauss.points, centre + f.points - g.points, rtol=0, atol=1e-9)
    flat = f.from_vertices(plan.positions)
    assert np.linalg.norm(flat[:, :2] - [1, 2], axis=1).max() < 5.01
    assert_allclose(f.from_corners(plan.positions[plan.triangles], plan.triangles), flat, rtol=0, atol=1e-12)
    for sheet in (f, g):
        vectors = np.array([area_vector(sheet.points[p]) for p in sheet.polygons])
        outside = np.array([sheet.normals[p].mean(axis=0) for p in sheet.polygons])
        areas = np.linalg.norm(vectors, axis=1)
        wrong = np.einsum("ni,ni->n", vectors, outside) < 0
        assert areas[wrong].sum() < 0.02 * areas.sum()


def area_vector(points: np.ndarray) -> np.ndarray:
    return 0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)


def test_a_polygon_belongs_to_the_drawn_one_below():
    """On the dual of a grid, that of a vertex lies on the quads around it, most of it on its owner."""
    plan = grid(5, 4)
    sheet = polygon_sheet(form(plan, Settings(default_tilt=0.3)), "f+", "dual")
    owners = sheet.owners(plan.triangles, plan.triangle_polygons)
    assert len(owners) == len(sheet.polygons) == 30
    for vertex, owner in enumerate(owners.tolist()):
        shares = np.bincount(plan.triangle_polygons[sheet.triangles[sheet.polygons[vertex]]])
        assert vertex in plan.polygons[owner]
        assert shares[owner] == shares.max()


def sheared_grid() -> Plan:
    """Parallelograms, each cut along its long diagonal."""
    plan = grid(6, 5)
    x, y, z = plan.positions.T
    triangles = np.concatenate([[quad[[0, 1, 2]], quad[[0, 2, 3]]] for quad in plan.polygons])
    owner = np.repeat(np.arange(len(plan.polygons)), 2)
    return Plan(np.column_stack([x + 0.3 * y, y, z]), triangles, plan.polygons, triangle_polygons=owner)


@pytest.mark.parametrize("faces", ["dual", "corner"])
def test_what_the_plan_carries_comes_through_other_triangles(faces):
    """Where the triangles are not the plan's, corner values without seams are those of the vertices."""
    plan = sheared_grid()
    shell = form(plan, Settings(default_tilt=0.3, delaunay=True))
    assert shell.surface.graph.domain is not shell.surface.domain
    sheet = polygon_sheet(shell, "f+", faces)
    drawn = plan.positions[:, :2]
    flat = sheet.from_vertices(drawn)
    assert_allclose(sheet.from_corners(drawn[plan.triangles], plan.triangles), flat, rtol=0, atol=1e-12)
    assert (flat.min(axis=0) > drawn.min(axis=0) - 0.5).all() and (flat.max(axis=0) < drawn.max(axis=0) + 0.5).all()
    owners = sheet.owners(plan.triangles, plan.triangle_polygons)
    centres = np.array([drawn[polygon].mean(axis=0) for polygon in plan.polygons])[owners]
    middles = np.array([flat[polygon].mean(axis=0) for polygon in sheet.polygons])
    distance = np.linalg.norm(centres - middles, axis=1)
    assert np.median(distance) < 0.9 and distance.max() < 2.0
