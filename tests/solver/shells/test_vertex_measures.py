"""Measures at the vertices of a shell: against the report, against exact shells, on cuts and on dual meshes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.measure.arrays import face_areas_in_space
from solver.shells.form import form
from solver.shells.plan import Group, Plan, Settings
from solver.shells.polygon_sheets import polygon_sheet
from solver.shells.vertex_measures import (
    DIRECTION,
    MEASURES,
    lines_on_polygons,
    on_polygons,
    rim_distances,
    vertex_measures,
)

RECTANGLE = np.array([[0, 0], [6, 0], [6, 3], [0, 3]], dtype=float)


def formed_on(shape, tilt: float, **settings):
    positions = np.column_stack([shape.positions, np.zeros(len(shape.positions))])
    edges = shape.domain.edges[shape.domain.boundary_edges]
    groups = [Group("rim", edges, "binormal", {"tilt": tilt})]
    plan = Plan(positions, shape.domain.faces, groups=groups)
    return plan, form(plan, Settings(**settings), intersections=False)


@pytest.fixture(scope="module")
def hall():
    return formed_on(shapes.polygon(RECTANGLE, max_edge=0.2, corner_radius=0.6), 0.4)


def measures(shell, sheet="f+", names=(*MEASURES, DIRECTION)):
    return vertex_measures(shell.surface, shell.similarity, shell.placed[sheet], sheet, names)


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("sheet", ["f+", "f-"])
def test_both_sheets_standing_and_hanging(sheet, flip):
    _, shell = formed_on(shapes.polygon(RECTANGLE, max_edge=0.3, corner_radius=0.6), 0.4, flip=flip, sheet=sheet)
    found = measures(shell, sheet)
    assert_allclose(found["mean_curvature"], shell.mean_curvature, rtol=1e-9)
    assert np.median(found["mean_curvature"]) == pytest.approx(shell.report.mean_curvature, rel=0.05)
    assert (found["gauss_curvature"] <= 1.2 * found["mean_curvature"].clip(0.0) ** 2 + 1e-9).mean() > 0.8
    assert (found["distortion"] >= 1.0).all()


def test_means_at_vertices_are_those_of_the_report(hall):
    _, shell = hall
    found, shown = measures(shell), shell.report.shown
    areas = face_areas_in_space(shell.placed["f+"], shell.faces)
    weights = np.bincount(shell.faces.ravel(), np.repeat(areas, 3))
    assert np.average(found["mean_curvature"], weights=weights) == pytest.approx(shown.mean_curvature.mean, rel=2e-3)
    assert np.average(found["distortion"], weights=weights) == pytest.approx(shown.distortion.mean, rel=2e-3)


def test_a_hemisphere():
    plan, shell = formed_on(shapes.disc(500), 0.0)
    found, H = measures(shell), shell.report.mean_curvature
    assert_allclose(found["mean_curvature"], H, rtol=2e-2)
    assert_allclose(found["gauss_curvature"], H * H, rtol=4e-2)
    assert not found[DIRECTION].any()
    assert np.nanmax(rim_distances(shell.surface, shell.placed["f+"], plan.positions)) < 0.01


def test_the_rim_is_as_far_off_as_the_report_says(hall):
    plan, shell = hall
    off = rim_distances(shell.surface, shell.placed["f+"], plan.positions)
    rim = np.flatnonzero(np.isfinite(off))
    assert np.nanmax(off) == pytest.approx(shell.report.shown.outline.max)
    drawn = shell.surface.domain.edges[shell.surface.domain.boundary_edges]
    assert set(shell.source[rim].tolist()) == set(np.unique(drawn).tolist())


def test_a_longer_hall_bends_across_it(hall):
    """In its middle a hall is steeper across than along."""
    _, shell = hall
    found, points = measures(shell), shell.placed["f+"]
    middle = np.argmin(np.linalg.norm(points[:, :2] - [3.0, 1.5], axis=1))
    assert abs(found[DIRECTION][middle, 1]) > 0.95


def test_only_what_is_asked_for(hall):
    assert set(measures(hall[1], names=("gauss_curvature",))) == {"gauss_curvature"}


@pytest.mark.parametrize("combinatorics", ["dual", "corner"])
def test_on_other_meshes(hall, combinatorics):
    plan, shell = hall
    sheet = polygon_sheet(shell, "f+", combinatorics)
    found, count = measures(shell), len(plan.positions)
    height = on_polygons(sheet, shell.placed["f+"][:, 2], shell.source, count)
    assert_allclose(height, sheet.points[:, 2], atol=0.1)
    H = on_polygons(sheet, found["mean_curvature"], shell.source, count)
    assert np.median(H) == pytest.approx(shell.report.mean_curvature, rel=0.02)
    off = rim_distances(shell.surface, shell.placed["f+"], plan.positions)
    rim = np.isfinite(on_polygons(sheet, off, shell.source, count))
    assert 0 < rim.sum() < 0.5 * len(rim)
    lines = lines_on_polygons(sheet, found[DIRECTION], shell.source, count)
    has_line = lines.any(axis=1)
    assert has_line.mean() > 0.9
    assert_allclose(np.linalg.norm(lines[has_line], axis=1), 1.0)
    across = np.einsum("ni,ni->n", lines[has_line], sheet.normals[has_line])
    assert np.abs(across).mean() < 0.1


def test_a_cut_open_surface():
    """Rows on either side of a cut have values of their own; the cut is no rim."""
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    court = shapes.polygon(4.0 * circle, holes=[1.2 * circle + [0.8, 0.0]], max_edge=0.5)
    plan, shell = formed_on(court, 0.7)
    assert shell.surface.is_open
    found = measures(shell)
    assert all(len(values) == len(shell.source) > len(plan.positions) for values in found.values())
    off = rim_distances(shell.surface, shell.placed["f+"], plan.positions)
    assert np.isfinite(off).sum() < len(angle) * 3


def test_a_row_without_a_proper_face(hall):
    _, shell = hall
    points = shell.placed["f+"].copy()
    face = shell.faces[np.argmax((shell.faces == 100).any(axis=1))]
    around = np.unique(shell.faces[(shell.faces == face[0]).any(axis=1)])
    points[around] = points[face[0]]
    found = vertex_measures(shell.surface, shell.similarity, points, "f+", (*MEASURES, DIRECTION))
    H = shell.report.mean_curvature
    assert found["mean_curvature"][face[0]] == pytest.approx(H)
    assert found["gauss_curvature"][face[0]] == pytest.approx(H * H)
    assert found["distortion"][face[0]] == 1.0
    assert not found[DIRECTION][face[0]].any()
