"""Surfaces over rings and courtyards: they close, or are cut open and report their gap."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Status, mean_curvature_of, periods, shapes, solve_cmc
from solver.surface.averaging import AVERAGINGS
from tests.solver.rim_conditions import rim
from tests.solver.surface_errors import curvature_errors

COURTYARD = ([(0, 0), (4, 0), (4, 3), (0, 3)], [[(0.7, 0.7), (1.7, 0.7), (1.7, 1.7), (0.7, 1.7)]])


def test_a_ring_with_symmetric_data_closes():
    shape = shapes.annulus(0.5, 1.0, 1500)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions))
    assert surface.status is Status.CONVERGED and not surface.is_open
    assert surface.gap < 1e-3 * np.ptp(surface.f_plus, axis=0).max()
    assert len(surface.f_plus) == shape.domain.vertex_count


@pytest.mark.parametrize("averaging", AVERAGINGS)
def test_a_courtyard_off_centre_is_cut_and_its_gap_named(averaging):
    shape = shapes.polygon(*COURTYARD, max_edge=0.08, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions), averaging=averaging)
    domain, n = shape.domain, len(surface.source)
    assert surface.status is Status.GAP and surface.is_open and n > domain.vertex_count
    assert f"{surface.gap:.4g}" in surface.message
    assert_array_equal(surface.source[surface.faces], domain.faces)
    extra = np.arange(domain.vertex_count, n)
    jumps = surface.f_plus[extra] - surface.f_plus[surface.source[extra]]
    assert_allclose(np.linalg.norm(jumps, axis=1), surface.gap, rtol=1e-9, atol=0)
    if averaging != "area":
        assert curvature_errors(surface)[0] < 0.05


def test_the_seam_is_not_seen_in_the_curvature():
    """Faces at the cut are as good as the others: where the domain is cut is an accident."""
    shape = shapes.polygon(*COURTYARD, max_edge=0.1, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions))
    H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
    at_seam = (np.bincount(surface.source) > 1)[shape.domain.faces].any(axis=1)
    at_rim = np.isin(shape.domain.faces, shape.domain.boundary_vertices).any(axis=1)
    assert np.abs(H - 0.5)[at_seam & ~at_rim].max() < 3 * np.abs(H - 0.5)[~at_seam & ~at_rim].max()


def test_small_periods_are_projected_out_and_reported():
    shape = shapes.polygon(*COURTYARD, max_edge=0.15, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions), period_tolerance=10.0)
    assert not surface.is_open and surface.status is Status.CONVERGED
    assert len(surface.f_plus) == shape.domain.vertex_count
    assert surface.gap > 0.1 and periods(surface).shape == (1, 3)


def test_the_period_does_not_depend_on_the_mesh():
    gaps = []
    for edge in (0.08, 0.04):
        shape = shapes.polygon(*COURTYARD, max_edge=edge, corner_radius=0.3)
        gaps.append(solve_cmc(shape.domain, rim(shape.domain, shape.positions)).gap)
    assert_allclose(gaps[0], gaps[1], rtol=0.02, atol=0)
