"""Checks of meshes of polygons: their edges, manifoldness and areas."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_array_equal
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def directed_edges(polygons):
    """(m, 2) rows of each step of each polygon, and the polygon of each (m,)."""
    steps = np.concatenate([np.stack([p, np.roll(p, -1)], axis=1) for p in polygons])
    return steps, np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])


def assert_manifold(polygons, count):
    """Every edge in one polygon or, walked both ways, in two; one fan of polygons at each row. χ, boundary edges."""
    steps, owner = directed_edges(polygons)
    assert all(len(np.unique(p)) == len(p) >= 3 for p in polygons)
    assert_array_equal(np.unique(steps), np.arange(count))
    place = {(a, b): n for n, (a, b) in enumerate(steps.tolist())}
    assert len(place) == len(steps), "two polygons walk an edge in the same direction"
    twin = np.array([place.get((b, a), -1) for a, b in steps.tolist()])
    joined = np.flatnonzero(twin >= 0)
    # a step starts a corner of its polygon; the corner at its end is that of the step that follows
    follower = {(int(p), int(a)): n for n, (p, (a, _)) in enumerate(zip(owner, steps, strict=True))}
    after = np.array([follower[int(owner[n]), int(steps[n, 1])] for n in range(len(steps))])
    graph = coo_array((np.ones(len(joined)), (joined, after[twin[joined]])), shape=(len(steps), len(steps)))
    assert connected_components(graph, directed=False)[0] == count, "a row joins several fans of polygons"
    edges = len(steps) - len(joined) // 2
    return count - edges + len(polygons), int((twin < 0).sum())


def area_vectors(points, polygons):
    centred = [points[p] - points[p].mean(axis=0) for p in polygons]
    return np.array([0.5 * np.cross(q, np.roll(q, -1, axis=0)).sum(axis=0) for q in centred])
