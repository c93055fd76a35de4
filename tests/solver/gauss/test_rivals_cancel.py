"""A coarse map whose normals cancel at a face is no start; the solve then begins as usual."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from solver import shapes
from solver.domain.coarsen import Coarse
from solver.domain.sites import SiteGraph
from solver.gauss.rivals import _smoothed


def test_normals_that_cancel_at_a_face_are_no_start():
    domain = shapes.disc(100).domain
    turns = 2.0 * np.pi / 3.0 * np.arange(3)
    N = np.tile([0.0, 0.0, 1.0], (domain.vertex_count, 1))
    N[domain.faces[0]] = np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
    every = np.arange(domain.vertex_count)
    itself = Coarse(domain, every, every)
    assert _smoothed(SiteGraph.of(domain, "faces"), N, itself, every, N) is None
    assert_allclose(_smoothed(SiteGraph.of(domain, "vertices"), N, itself, every, N), N, rtol=0, atol=1e-15)
