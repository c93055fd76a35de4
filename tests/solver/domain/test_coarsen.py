"""Coarse copies of domains: the same topology, about the given size, and near the same shape."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.domain.coarsen import coarsened

DOMAINS = {
    "disc": lambda: shapes.disc(5000).domain,
    "annulus": lambda: shapes.annulus(0.4, 1.0, 6000).domain,
    "L": lambda: shapes.polygon([(0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3)], max_edge=0.04).domain,
    "strip": lambda: shapes.strip(10.0, 1.0, 200).domain,
}


@pytest.mark.parametrize("name", DOMAINS)
@pytest.mark.parametrize("count", [300, 1000])
def test_a_coarse_copy_is_like_its_domain(name, count):
    domain = DOMAINS[name]()
    coarse = coarsened(domain, count)
    assert coarse is not None
    assert 0.3 * count < coarse.domain.vertex_count < 3.0 * count
    assert (coarse.domain.genus, len(coarse.domain.boundary_loops)) == (domain.genus, len(domain.boundary_loops))
    assert_allclose(coarse.domain.face_areas.sum(), domain.face_areas.sum(), rtol=0.35)
    assert (coarse.region[coarse.vertices] == np.arange(len(coarse.vertices))).all()
    assert np.bincount(coarse.region, minlength=len(coarse.vertices)).min() >= 1


def test_kept_rim_is_rim():
    domain = DOMAINS["annulus"]()
    coarse = coarsened(domain, 400)
    kept = coarse.vertices[coarse.domain.boundary_vertices]
    assert np.isin(kept, domain.boundary_vertices).all()
