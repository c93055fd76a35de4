"""The identity of the sphere, recovered or lost (paper, Appendix A.1 and Figure 20)."""

from __future__ import annotations

import numpy as np
import pytest

from solver import Domain, HarmonicSolver, Status
from solver.gauss.boundary_data import Conditions
from tests.solver import meshes
from tests.solver.figure20 import ASPECTS, recover, sphere


@pytest.mark.parametrize("aspect", ASPECTS)
def test_mobius_recovers_the_identity(aspect):
    """To 5° where the aspect ratio is at most 10, and without getting lost beyond."""
    result = recover(*sphere(800, aspect), "mobius")
    assert result.harmonic.status is Status.CONVERGED and np.isclose(result.harmonic.degree, 1.0, rtol=0, atol=1e-9)
    assert result.error < (5.0 if aspect <= 10 else 20.0)


@pytest.mark.parametrize("aspect", ASPECTS[1:])
def test_dual_cotangents_lose_it(aspect):
    """As soon as some edges are not Delaunay, the energy falls far below that of any map."""
    result = recover(*sphere(800, aspect), "dual_cotan")
    assert result.not_delaunay > 0 and result.harmonic.energy < 0 and result.is_lost


def test_newtons_method_for_critical_points_finds_it_with_dual_cotangents():
    """It is a critical point there too, but no minimum."""
    result = recover(*sphere(800, 10), "dual_cotan", method="lagrange")
    assert result.harmonic.status is Status.CONVERGED and result.error < 1.0


def test_dual_cotangents_do_on_a_delaunay_sphere():
    result = recover(*sphere(800, 1), "dual_cotan")
    assert result.not_delaunay == 0 and result.harmonic.status is Status.CONVERGED and result.error < 0.1


def test_unconstrained_minimisers_slide_to_a_constant_but_exact_identities_stay():
    """On the convex hull of points of a sphere its normals are critical: a saddle, which nearby maps leave."""
    points, faces = meshes.sphere(200, jitter=0.3)
    domain = Domain.from_positions(points, faces)
    solver = HarmonicSolver(domain, sites="faces", energy="mobius")
    normals = meshes.face_normals(points, domain.faces)
    there = solver.solve(Conditions(), initial=normals)
    assert there.status is Status.CONVERGED and there.iterations == 0
    np.testing.assert_allclose(there.energy, 4 * np.pi, rtol=1e-9, atol=0)
    middles = points[domain.faces].mean(axis=1)
    slid = solver.solve(Conditions(), initial=middles)
    assert slid.energy < 2 * np.pi
