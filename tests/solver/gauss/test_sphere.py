"""The unit sphere: orthonormal tangent vectors."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from solver.gauss.sphere import normalize, tangent_axes


def test_tangent_axes_and_the_normal_are_a_right_handed_frame():
    N = normalize(np.concatenate([np.random.default_rng(0).normal(size=(50, 3)), np.eye(3), -np.eye(3)]))
    frames = np.concatenate([tangent_axes(N), N[:, None]], axis=1)
    assert_allclose(frames @ frames.swapaxes(1, 2), np.broadcast_to(np.eye(3), (len(N), 3, 3)), rtol=0, atol=1e-15)
    assert_allclose(np.linalg.det(frames), 1.0, rtol=1e-14, atol=0)
