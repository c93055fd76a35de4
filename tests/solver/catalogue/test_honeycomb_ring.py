"""Rings of tubes from copies of a quadrilateral between mirrors (paper, Figure 16)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, Domain, HarmonicSolver, MeshError, complete, modes_of, ring
from solver.catalogue.honeycomb_ring import AROUND
from solver.gauss.modes import problem_of


def test_the_ring_of_the_honeycomb():
    """72 copies around one hexagon: genus one with six boundaries, seven periods, a saddle of index twelve."""
    found = ring(2.4, max_edge=0.3)
    domain, N = found.domain, found.normals
    assert len(found.completion.copies) == 72
    assert (domain.euler_characteristic, domain.genus, len(domain.boundary_loops)) == (-6, 1, 6)
    assert found.periods.shape == (7, 3)
    assert_allclose(found.periods, 0, rtol=0, atol=1e-10)
    solver = HarmonicSolver(domain)
    point = problem_of(solver, found.conditions).at(N)
    assert_allclose(point.residual, 0, rtol=0, atol=1e-9)
    assert_allclose(found.energy, 72 * found.piece.harmonic.energy, rtol=1e-12, atol=0)
    assert_allclose(point.energy, found.energy, rtol=1e-12, atol=0)
    assert (modes_of(solver, found.conditions, N).values < -0.05).sum() == 12
    surface = CmcSolver(domain).solve(found.conditions, N)
    assert surface.periods.shape == (7, 3) and not surface.is_open
    assert_allclose(np.ptp(surface.f_plus, axis=0), np.ptp(found.positions, axis=0), rtol=1e-4, atol=0)


@pytest.mark.parametrize(("tubes", "length", "copies", "loops"), [(3, 2.4, 72, 6), (4, 2.4, 64, 8), (6, 4.0, 72, 12)])
def test_rings_tile_the_plane(tubes, length, copies, loops):
    """Each has its own tubes to its neighbours, half of each; 3 × 3 of them are one surface, with loops all around."""
    found = ring(length, tubes=tubes, mean_curvature=1.0)
    assert len(found.completion.copies) == copies and len(found.domain.boundary_loops) == loops
    assert (found.domain.genus, found.domain.euler_characteristic) == (1, -loops)
    around = complete(found.piece, found.sides, around=AROUND, translations=found.lattice, repeat=3)
    mesh = around.mesh
    assert len(around.copies) == 9 * copies and max(gap.relative for gap in around.gaps) < 1e-9
    tiled = Domain.from_positions(mesh.vertices, mesh.faces)  # raises where it is not connected
    assert tiled.euler_characteristic == -9 * loops
    side, cells = np.linalg.norm(found.lattice[0]), {3: 3.0, 4: 2.0, 6: np.sqrt(3.0)}[tubes]
    assert_allclose(side, cells * found.spacing, rtol=1e-12, atol=0)
    assert 0.0 < found.neck < 0.5 * found.spacing


def test_longer_plans_have_thinner_necks():
    assert ring(3.1).neck < 0.5 * ring(2.4).neck


def test_senseless_rings_are_refused():
    with pytest.raises(MeshError, match="3, 4 or 6"):
        ring(2.4, tubes=5)
    with pytest.raises(MeshError, match="longer than"):
        ring(0.5)
