"""Periods in their two forms: sums of tau along loops, and integrals of tau against harmonic one-forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ellipk

from solver import CmcSolver, Domain, HarmonicSolver, Status, conditions, periods, shapes
from solver.domain.topology import Homology
from solver.surface.periods import harmonic_forms, integrals, path_across
from tests.solver.exact_surfaces import rates
from tests.solver.fundamental_pieces import unduloid_normals, unduloid_period

C = -0.4  # of the unduloid


def ring(radius, centre=(0.0, 0.0)):
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + centre


HOLES = {
    "one hole": [ring(0.4, (0.25, 0.1))],
    "three holes": [ring(0.22, (0.45, 0.3)), ring(0.22, (-0.45, 0.25)), ring(0.22, (0.0, -0.5))],
}


def plan(holes, edge):
    """A round plan with holes whose tilts are unequal and slope: domain and harmonic normals."""
    shape = shapes.polygon(ring(1.2), holes=HOLES[holes], max_edge=edge)
    held = conditions.Conditions()
    for k, side in enumerate(["outer", *(f"hole{i}" for i in range(len(HOLES[holes])))]):
        edges = shape.sides[side]
        middles = shape.positions[shape.domain.edges[edges]].mean(axis=1)
        held += conditions.binormal(shape.domain, shape.positions, edges, 0.5 + 0.2 * k + 0.3 * middles[:, 0])
    return shape.domain, HarmonicSolver(shape.domain).solve(held, tolerance=1e-12).normals


def half_unduloid(columns):
    """Harmonic normals from the neck to the belly, on a cylinder."""
    shape = shapes.cylinder(2 * np.pi, 2 * ellipk(1 + C), columns)
    N = unduloid_normals(C, shape.positions)
    rim = shape.domain.boundary_vertices
    held = conditions.fixed_at(shape.domain, rim, N[rim])
    return HarmonicSolver(shape.domain).solve(held, initial=N, tolerance=1e-13).normals


def torus(columns):
    """A flat torus with the normals of one period of an unduloid: those of half of it, and their reflections.

    14 columns, or twice that and so on, have an even number of rows in each half.
    """
    half = half_unduloid(columns)
    shape = shapes.torus(2 * np.pi, 4 * ellipk(1 + C), columns)
    rows = len(half) // columns - 1
    assert shape.domain.vertex_count == 2 * rows * columns
    back = half.reshape(-1, columns, 3)[rows - 1 : 0 : -1] * [1, 1, -1]
    return shape.domain, np.concatenate([half, back.reshape(-1, 3)])


def torus_with_a_hole(columns):
    """The same, without some of the faces; around the hole the normals are held as they are."""
    domain, N = torus(columns)
    positions = shapes.torus(2 * np.pi, 4 * ellipk(1 + C), columns).positions
    far = np.linalg.norm(positions - [np.pi, 2 * ellipk(1 + C)], axis=1) > 0.9
    faces = domain.faces[far[domain.faces].all(axis=1)]
    kept, numbers = np.unique(faces, return_inverse=True)
    lengths = domain.side_lengths[far[domain.faces].all(axis=1)]
    part = Domain.from_edge_lengths(numbers.reshape(-1, 3), lengths)
    held = conditions.fixed_at(part, part.boundary_vertices, N[kept][part.boundary_vertices])
    return part, HarmonicSolver(part).solve(held, initial=N[kept], tolerance=1e-12).normals


CASES = {
    "one hole": (lambda n: plan("one hole", 2.4 / n), 1),
    "three holes": (lambda n: plan("three holes", 2.4 / n), 3),
    "torus": (torus, 2),
    "torus with a hole": (torus_with_a_hole, 2),
}


def forms_of(domain):
    homology = Homology.of(domain)
    return homology, harmonic_forms(homology, HarmonicSolver(domain).dirichlet)


def tau_of(domain, N):
    i, j = domain.edges.T
    return domain.cotan_weights[:, None] * np.cross(N[i], N[j])


@pytest.mark.parametrize("case", CASES)
def test_loop_sums_are_integrals_against_harmonic_forms(case):
    """Exactly in the edge form; to second order where the normals are taken as piecewise linear."""
    make, count = CASES[case]
    coarse, fine = ((14,), (42,)) if "torus" in case else ((14, 16, 18), (42, 48, 54))
    assert max(miss(*make(n), count) for n in fine) < max(miss(*make(n), count) for n in coarse) / 5


def miss(domain, N, count):
    """How far integrals are from loop sums, at most, as a part of those."""
    homology, eta = forms_of(domain)
    tau = tau_of(domain, N)
    loops = homology.loops.T @ tau
    assert loops.shape == (count, 3) and np.linalg.norm(loops, axis=1).max() > 0.3
    assert_allclose(eta.T @ tau, loops, rtol=0, atol=1e-10)
    return np.abs(integrals(domain, N, eta) - loops).max() / np.abs(loops).max()


@pytest.mark.parametrize("case", ["torus", "torus with a hole"])
def test_the_periods_of_an_unduloid(case):
    """Along the axis that of the exact surface, around it none: up to whole combinations of the loops."""
    errors = []
    for n in (14, 28):
        domain, N = CASES[case][0](n)
        homology, _ = forms_of(domain)
        loops = homology.loops.T @ tau_of(domain, N)
        turns = np.round(loops[:, 2] / unduloid_period(C))
        assert np.gcd.reduce(np.abs(turns).astype(int)) == 1
        errors.append(np.abs(loops - turns[:, None] * [0, 0, unduloid_period(C)]).max())
    assert errors[1] < 0.06 and rates(errors)[0] > 1.9


def test_harmonic_forms_are_closed_and_coclosed():
    domain, _ = torus_with_a_hole(14)
    homology, eta = forms_of(domain)
    sign = np.where(domain.half_edges[domain.face_edges, 0] == np.arange(domain.faces.size).reshape(-1, 3), 1, -1)
    assert_allclose((sign[:, :, None] * eta[domain.face_edges]).sum(axis=1), 0, rtol=0, atol=1e-12)
    assert_allclose(eta[domain.boundary_edges], 0, rtol=0, atol=1e-12)
    flow = domain.cotan_weights[:, None] * eta
    out = np.zeros((domain.vertex_count, eta.shape[1]))
    np.add.at(out, domain.edges[:, 0], flow)
    np.subtract.at(out, domain.edges[:, 1], flow)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    assert_allclose(out[inside], 0, rtol=0, atol=1e-11)
    assert_allclose(homology.crossings.T @ homology.loops, np.eye(2), rtol=0, atol=0)


def test_a_path_joins_the_boundary_points_of_the_conjugate():
    """On a disc, where every path gives the same."""
    shape = shapes.disc(200)
    held = conditions.twisted(shape.domain, shape.positions, shape.sides["outer"], 1)
    surface = CmcSolver(shape.domain).solve(held, tolerance=1e-12)
    homology = Homology.of(shape.domain)
    for start, end in ((0, 7), (3, 20), (5, 5)):
        edges = shape.domain.boundary_edges[[start, end]]
        path = path_across(homology, *edges.tolist())
        points = surface.conjugate.boundary_points[[start, end]]
        assert_allclose(path @ surface.conjugate.tau, points[1] - points[0], rtol=0, atol=1e-10)


def leaning(share):
    """A round courtyard whose shell closes by symmetry, but for a `share` of a slope of the outer tilts."""
    shape = shapes.annulus(0.4, 1.2, 500)
    middles = shape.positions[shape.domain.edges[shape.sides["outer"]]].mean(axis=1)
    outer = conditions.binormal(shape.domain, shape.positions, shape.sides["outer"], 1.0 + share * middles[:, 0])
    return shape.domain, outer + conditions.binormal(shape.domain, shape.positions, shape.sides["inner"], 0.6)


def test_small_periods_are_projected_out_and_reported_larger_ones_cut_the_surface():
    """Smaller or larger than a thousandth of the diameter; either way `periods` has their lengths."""
    open_at = {}
    for share in (1e-4, 1e-3, 3e-3, 3e-2):
        domain, held = leaning(share)
        surface = CmcSolver(domain).solve(held, tolerance=1e-10)
        size = max(np.linalg.norm(np.ptp(surface.sheet(name), axis=0)) for name in ("f+", "f-"))
        assert_allclose(surface.gap / share, 3.3, rtol=0.03)
        assert surface.is_open == (surface.gap > 1e-3 * size)
        assert_allclose(periods(surface), surface.periods)
        open_at[share] = surface.is_open
        if surface.is_open:
            assert len(surface.g) > domain.vertex_count and surface.status is Status.GAP
            sheets = Homology.of(domain).sheets
            jumps = surface.g[domain.vertex_count :] - surface.g[surface.source[domain.vertex_count :]]
            assert_allclose(jumps, sheets.offsets[domain.vertex_count :] @ surface.periods, rtol=0, atol=1e-12)
        else:
            assert len(surface.g) == domain.vertex_count and surface.status is Status.CONVERGED
            assert surface.gap > 1e-6
    assert set(open_at.values()) == {True, False}


def test_what_is_projected_out_moves_the_surface_no_more_than_the_period():
    """Next to the exact part of tau, the conjugate without its period is the nearest one; to first order in it."""
    moves = []
    for share in (1e-3, 2e-3):
        domain, held = leaning(share)
        whole = CmcSolver(domain).solve(held, tolerance=1e-10, period_tolerance=1.0)
        cut = CmcSolver(domain).solve(held, tolerance=1e-10, period_tolerance=0.0)
        moved = whole.f_plus - cut.f_plus[: domain.vertex_count]
        moves.append(np.linalg.norm(moved - moved.mean(axis=0), axis=1).max() / cut.gap)
    assert 0.1 < moves[0] < 1.5
    assert_allclose(moves[0], moves[1], rtol=0.01)
