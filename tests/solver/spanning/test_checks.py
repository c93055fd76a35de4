"""What is measured on a finished span: numbers that agree only on the surface that was asked for."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Domain, mean_curvature_of, shapes, span_outline
from solver.notes import CODES
from solver.spanning.branch import Branch, branch
from solver.spanning.checks import area_gradient, balanced_curvature
from solver.spanning.linearised import Linearised
from solver.spanning.setting import setting
from tests.solver.exact_surfaces import disc, rates
from tests.solver.spanned_plans import distortion, enneper, hemispheres, raised, ring
from tests.solver.spanning.test_leans import hall

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def codes(span) -> list[str]:
    return [note.code for note in span.warnings]


def test_a_cap_passes_all_checks():
    off = []
    for n in (480, 1920):
        domain, points = disc(n)
        span = span_outline(domain, points, mean_curvature=0.8)
        checks = span.checks
        assert span.ok and not span.warnings and checks.crossings == 0 and checks.branch is Branch.FLATTER
        assert_allclose(checks.multiplier, 0.8, rtol=1e-6)
        assert_allclose(checks.curvature_unit, 0.8, rtol=5e-3)
        assert_allclose(checks.distortion, distortion(span), rtol=1e-6)
        assert checks.drawn_distortion == checks.distortion < 1e-3
        off.append(abs(checks.mean_curvature / 0.8 - 1.0))
    assert off[-1] < 5e-4 and rates(off)[0] > 1.5
    assert "0.799" in checks.lines[0] and "the flatter one" in checks.lines[2]
    assert pickle.loads(pickle.dumps(span)).checks == checks


def test_the_gradient_of_the_area():
    domain, points = disc(60)
    random = np.random.default_rng(1)
    f, d = (random.normal(size=(len(points), 3)) for _ in range(2))
    slope = float(np.sum(area_gradient(f, domain.faces) * d))

    def area(t: float) -> float:
        a, b, c = (f + t * d)[domain.faces].transpose(1, 0, 2)
        return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    assert_allclose(slope, (area(1e-5) - area(-1e-5)) / 2e-5, rtol=1e-7)


def test_the_balance_of_the_area_does_not_depend_on_the_plan():
    """The same cap over a plan stretched by 1.3: its H is still that of the sphere."""
    domain, points = disc(1000)
    span = span_outline(domain, points, mean_curvature=0.8)
    descent = span.kept.descent
    here = Linearised(descent.problem, descent.state, None)
    assert_allclose(balanced_curvature(here), 0.8, rtol=1e-3)
    stretched = Domain.from_positions(points * [1.3, 1.0], domain.faces)
    problem, _ = setting(stretched, np.column_stack([points, 0 * points[:, 0]]))
    state = problem.start()
    moved = problem.lifted(state, (descent.state.f - state.f)[problem.coordinates.inside])
    assert_allclose(balanced_curvature(Linearised(problem, moved, None)), 0.8, rtol=2e-3)


@pytest.mark.parametrize("H", [0.75, 0.9])
def test_two_caps_of_one_curvature(H):
    """The flatter one by its curvature; the fuller one by its volume, and from there by its curvature."""
    domain, points = disc(1200)
    flat = span_outline(domain, points, mean_curvature=H)
    full = span_outline(domain, points, volume=hemispheres(H))
    assert flat.checks.branch is Branch.FLATTER and full.checks.branch is Branch.FULLER
    assert_allclose(full.mean_curvature, H, rtol=0.03)
    assert not codes(flat) and not codes(full)
    again = span_outline(domain, points, mean_curvature=full.mean_curvature, initial=full)
    assert again.checks.branch is Branch.FULLER and codes(again) == ["several"]
    assert span_outline(domain, points, volume=-hemispheres(H)).checks.branch is Branch.FULLER


def test_an_unstable_minimal_surface_is_a_saddle():
    """Enneper's is stable up to r = 1 only (its Gauss map covers half of the sphere there)."""
    domain, points = disc(900)
    found = []
    for r in (0.9, 1.2):
        f = enneper(r * (points[:, 0] + 1j * points[:, 1]))
        problem, lines = setting(domain, f)
        start = problem.start()
        state = problem.lifted(start, (f - lines.centre - start.f)[problem.coordinates.inside])
        found.append(branch(Linearised(problem, state, None)))
    assert found == [Branch.FLATTER, Branch.SADDLE]


def test_holes_that_are_kept_cost_evenness():
    domain, points = ring(900, 0.6)
    line = raised(domain, points, 0.5)
    moved = span_outline(domain, line, mean_curvature=0.93165455511)
    kept = span_outline(domain, line, mean_curvature=0.93165455511, holes="keep")
    assert moved.ok and not codes(moved) and kept.ok and codes(kept) == ["distorted"]
    assert "stretches by 5" in kept.warnings[0] and "instead of 0.9317; let the holes move" in kept.warnings[0]
    assert moved.checks.distortion < 1e-3 < 0.05 < moved.checks.drawn_distortion
    assert kept.checks.distortion == pytest.approx(kept.checks.drawn_distortion) and kept.checks.distortion > 0.05
    assert_allclose(kept.checks.mean_curvature, 0.876, rtol=0.01)  # as measured with the normals
    measured = np.median(mean_curvature_of(kept.points, kept.faces, kept.normals))
    assert_allclose(kept.checks.mean_curvature, measured, rtol=0.02)


def test_corners_that_slide_unbalance_a_surface():
    """Vertices that slide across sharp corners stay there, and the map is not conformal."""
    plan = shapes.polygon(SQUARE * [3, 1], max_edge=0.3)
    sharp = span_outline(plan, plan.positions, mean_curvature=0.55)
    slides = span_outline(plan, plan.positions, mean_curvature=0.55, corners="round")
    assert_allclose(sharp.checks.mean_curvature, 0.55, rtol=5e-3)
    assert abs(slides.checks.mean_curvature / 0.55 - 1.0) > 0.04 and not slides.ok
    assert [note.code for note in slides.checks.notes] == ["unbalanced"] and not sharp.warnings
    assert "instead of 0.55" in slides.checks.notes[0] and codes(slides) == ["not-converged"]


def test_a_surface_in_a_knot_crosses_itself():
    domain, points = disc(700)
    t = 2 * np.pi * np.arange(200) / 200
    knot = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    span = span_outline(domain, points, knot)
    assert span.checks.crossings > 5
    note = next(note for note in span.checks.notes if note.code == "crossing")
    assert f"at {span.checks.crossings} pairs of faces" in note


def test_leans_are_measured():
    coarse, fine = (
        span_outline(plan, plan.positions, rise=0.35, leans=[("street", np.radians(35))])
        for plan in (hall(0.75), hall(0.375))
    )
    (found,) = fine.checks.leans
    assert_allclose(np.degrees([found.asked, found.measured]), 35.0, rtol=0, atol=0.5)
    assert found.off < np.radians(0.6) and found.highest == pytest.approx(0.0, abs=1e-9)
    assert_allclose(found.lowest, fine.points[:, 2].min(), rtol=1e-9)
    assert codes(fine) == [] and "for 35.0°" in fine.checks.lines[-1]
    assert codes(coarse) == ["lean-missed"] and "Refine the mesh" in coarse.warnings[0]
    mirrored = span_outline(hall(0.75), hall(0.75).positions, rise=0.35, leans=[("left", 0.5 * np.pi)])
    assert mirrored.checks.leans[0].off < np.radians(0.2)


def test_square_holes_keep_their_corners():
    plan = shapes.polygon(SQUARE, holes=[0.4 * SQUARE[::-1] + 0.1], max_edge=0.11)
    up = np.column_stack([plan.positions, np.zeros(len(plan.positions))])
    hole = min(plan.domain.boundary_loops, key=len)
    up[hole, 2] = 0.3
    for H in (0.0, 0.3):
        span = span_outline(plan, up, mean_curvature=H)
        assert span.ok and not codes(span), span.warnings
        corners = plan.positions[hole][(np.abs(np.abs(plan.positions[hole] - 0.1) - 0.4) < 1e-9).all(axis=1)]
        assert len(corners) == 4
        gaps = np.linalg.norm(span.points[hole, None, :2] - corners, axis=2).min(axis=0)
        assert gaps.max() < 1e-12
        assert_allclose(span.checks.mean_curvature, H, rtol=0, atol=0.01)
        assert span.checks.distortion < 1e-3


def test_a_span_that_failed_says_so():
    domain, points = disc(300)
    span = span_outline(domain, points, mean_curvature=1.2)
    assert codes(span)[0] == "not-converged" and span.warnings[0] == span.message
    assert {"unbalanced", "distorted", "several", "lean-missed", "steep-corner"} <= set(CODES)
