"""What a span gives to other rooms: its twin, the paper's surface beside it, reports, meshes and copies."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, ConditionError, Domain, Side, complete, mean_curvature_of, report, shapes, span_outline
from tests.solver.exact_surfaces import disc
from tests.solver.spanned_plans import enneper, quarter_disc


@pytest.fixture(scope="module")
def square():
    plan = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.09, corner_radius=0.6)
    return plan, span_outline(plan, plan.positions, mean_curvature=0.5)


def test_parallel_surfaces(square):
    _, span = square
    assert_allclose(span.points - span.f_minus, 2 * (span.points - span.g), rtol=0, atol=1e-12)
    assert_allclose(np.linalg.norm(span.points - span.g, axis=1), 1.0, rtol=1e-12)
    H = mean_curvature_of(span.f_minus, span.faces, -span.normals)
    assert_allclose(np.median(H), 0.5, rtol=0.06)  # a small sheet with cusps


@pytest.mark.parametrize("H", [0.5, -0.5])
def test_the_harmonic_surface_beside_it(H):
    plan = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.09, corner_radius=0.6)
    span = span_outline(plan, plan.positions, mean_curvature=H)
    paper = span.harmonic()
    assert paper.ok and paper.mean_curvature == pytest.approx(H)
    assert span.distance() < 0.02
    assert_allclose(np.median(mean_curvature_of(paper.f_plus, paper.faces, paper.normals)), H, rtol=0.01)
    assert np.abs(paper.harmonic.normals - span.normals).max() < 1e-6


def test_a_solver_lends_its_factors(square):
    plan, span = square
    solver = CmcSolver(plan)
    again = span_outline(plan, plan.positions, mean_curvature=0.5, solver=solver)
    assert_allclose(again.points, span.points, rtol=0, atol=1e-12)
    assert again.kept.descent.problem.solver is solver.harmonic
    sharp = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.2)
    by_name, by_edges = (
        span_outline(sharp, sharp.positions, mirrors=[(side, [0, 1, 0])], mean_curvature=0.1)
        for side in ("side0", sharp.sides["side0"])
    )
    assert_allclose(by_name.points, by_edges.points, rtol=0, atol=1e-12)


def test_what_nobody_asks_for_is_not_made(square):
    plan, _ = square
    solver = CmcSolver(plan)
    span = span_outline(plan, plan.positions, mean_curvature=0.5, solver=solver)
    assert not span.has_normals and span.ok
    assert span.normals is span.normals and span.has_normals
    for name in ("g", "f_plus", "f_minus"):
        own, afresh = (
            getattr(each, name)
            for each in (span.as_surface, span_outline(plan, plan.positions, mean_curvature=0.5).as_surface)
        )
        assert_allclose(own, afresh, rtol=0, atol=1e-9)


def test_a_film_has_no_twin(square):
    plan, _ = square
    film = span_outline(plan, plan.positions)
    assert film.ok and film.g is None and film.f_minus is None
    with pytest.raises(ConditionError, match="mean curvature 0"):
        film.harmonic()


def test_reports(square):
    plan, span = square
    measured = report(span, plan.positions)
    assert measured.ok and set(measured.sheets) == {"f+", "f-"}
    assert measured.shown.outline.max < 2e-3 and measured.shown.intersections.count == 0
    assert measured.shown.mean_curvature.relative_l2 < 0.05
    domain, points = disc(400)
    t = 2 * np.pi * np.arange(200) / 200
    for line in (enneper(0.7 * np.exp(1j * t)), None):
        film = report(span_outline(domain, points, line))
        assert film.ok and set(film.sheets) == {"f+"}
        assert "nan" not in film.summary("m") and "wanted 0, off by" in film.summary("m")
        film.to_json()


def test_meshes_pictures_and_pickles(square, tmp_path):
    plan, span = square
    dual = span.as_mesh("f+", "dual")
    inside = plan.domain.vertex_count - len(plan.domain.boundary_vertices)
    assert len(dual.polygons) >= inside
    far = np.linalg.norm(dual.vertices[:, None] - span.points[None], axis=2).min(axis=1)
    assert far.max() < 0.14
    span.save(tmp_path / "shell.obj")
    assert span.to_trimesh().vertices.shape == span.points.shape
    assert "Span(" in repr(span) and "H = 0.5" in repr(span) and "mean curvature" in span._repr_html_()
    again = pickle.loads(pickle.dumps(span))
    warm = span_outline(plan, plan.positions, mean_curvature=0.52, initial=again)
    assert warm.ok and warm.history[-1].solves < 30


def test_a_quarter_is_completed():
    plan = quarter_disc(200)
    last = list(plan.sides)[-1]
    mirrors = [(plan.sides["side0"], [0, 1, 0]), (plan.sides[last], [1, 0, 0])]
    sides = [Side("south", plan.sides["side0"]), Side("west", plan.sides[last])]
    for H in (0.0, 0.3):
        line = enneper(0.6 * (plan.positions[:, 0] + 1j * plan.positions[:, 1]))
        span = span_outline(plan.domain, line, mirrors=mirrors, mean_curvature=H)
        assert span.ok, span.message
        whole = complete(span, sides)
        assert len(whole.copies) == 4


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"rise": 0.3, "volume": 1.0}, "Give one of rise and volume"),
        ({"rise": np.nan}, "rise must be a number"),
        ({"corners": "square"}, "known are sharp, round"),
        ({"holes": "drop"}, "known are adapt, keep"),
        ({"curve": [[0, 0], [1, 1]]}, "three or more points"),
        ({"curve": [[[0, 0], [1, 0], [0, 1]]] * 2}, "1 boundary loops"),
        ({"curve": [[0, 0, 0], [1, 1, 0], [2, 2, 0]]}, "The curve is straight"),
        ({"curve": np.eye(3) + 1j}, "must be numbers"),
    ],
)
def test_input_that_contradicts_itself(keywords, message):
    domain, points = disc(100)
    with pytest.raises(ConditionError, match=message):
        span_outline(domain, points, **keywords)


def test_a_crown_below_the_line_is_refused():
    domain, points = disc(200)
    wave = np.column_stack([points, 0.3 * points[:, 0] ** 2])
    with pytest.raises(ConditionError, match=r"The lines themselves reach 0\.15"):
        span_outline(domain, wave, height=0.1)
    assert span_outline(domain, wave, height=0.3).ok


def test_a_film_has_no_gauss_image_of_its_size():
    domain, points = disc(100)
    with pytest.raises(ConditionError, match="no sphere of its size"):
        span_outline(domain, points).sheet("gauss")


def test_a_boundary_without_extent_is_refused():
    domain, points = disc(200)
    rim = domain.boundary_loops[0]
    points[rim[1]] = points[rim[0]]
    with pytest.raises(ConditionError, match=f"Vertices {rim[0]} and {rim[1]} of the boundary are in one place"):
        span_outline(domain, points)
    with pytest.raises(ConditionError, match="The boundary of the plan is straight"):
        span_outline(domain, disc(200)[1] * [1.0, 0.0])


@pytest.mark.parametrize("height", [1e3, -1e9, 1e30])
def test_a_height_out_of_reach_is_a_status(height):
    plan = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.5)
    span = span_outline(plan, plan.positions, height=height)
    assert not span.ok and "Choose a flatter shell" in span.message


def test_heights_from_a_flat_film_and_back():
    plan = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.5)
    flat = span_outline(plan, plan.positions)
    for height in (0.5, -0.5, 1.0):
        shell = span_outline(plan, plan.positions, height=height, initial=flat)
        assert shell.ok and shell.points[np.argmax(np.abs(shell.points[:, 2])), 2] == pytest.approx(height, rel=1e-5)
    assert span_outline(plan, plan.positions, height=0.0, initial=shell).ok


def test_a_curve_far_away():
    plan = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.5)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0.2, 1, 0]])
    near = span_outline(plan, plan.positions, corners)
    with np.errstate(invalid="raise"):
        far = span_outline(plan, plan.positions, 1e25 * (corners + 3.0))
    assert near.ok and far.ok
    assert_allclose(far.points, 1e25 * (near.points + 3.0), rtol=1e-9)


def test_domains_without_a_plan():
    with pytest.raises(ConditionError, match="needs a plan"):
        span_outline(shapes.sphere(50), shapes.sphere(50).positions)
    two = Domain.from_positions([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(ConditionError, match="none is free"):
        span_outline(two, [[0, 0], [1, 0], [1, 1], [0, 1]])
