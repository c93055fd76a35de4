"""A surface with a symmetry of its own continues by translations where its mirrors meet at obtuse angles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, Side, complete, ring
from solver.catalogue import modules
from solver.symmetry.own_symmetry import translation_seams
from tests.solver.fundamental_pieces import between_mirrors


@pytest.fixture(scope="module")
def whole_ring():
    found = ring(max_edge=0.6)
    surface = CmcSolver(found.domain).solve(found.conditions, found.normals, method="critical")
    sides = []
    for k, loop in enumerate(found.domain.boundary_loop_edges):
        across = np.linalg.svd(found.normals[np.unique(found.domain.edges[loop])])[2][-1]
        sides.append(Side(f"tube {k}", loop, "mirror", across))
    return found, surface, sides


def test_a_ring_is_its_own_unit_cell(whole_ring):
    found, surface, sides = whole_ring
    unit = complete(surface, sides)
    assert len(unit.copies) == 1
    lengths = np.linalg.norm(unit.lattice, axis=1)
    assert_allclose(lengths, np.linalg.norm(found.lattice, axis=1), rtol=1e-6, atol=0)


def test_rings_are_welded_to_a_honeycomb(whole_ring):
    _, surface, sides = whole_ring
    tiled = complete(surface, sides, repeat=3)
    faces = tiled.mesh.faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    kinds, count = np.unique(edges, axis=0, return_counts=True)
    assert len(tiled.copies) == 9 and count.max() == 2
    # genus 1 and six boundary loops each; gluing along circles adds their Euler characteristics
    assert len(tiled.mesh.vertices) - len(kinds) + len(faces) == -6 * 9
    assert max(gap.relative for gap in tiled.gaps) < 1e-8
    middles = np.array([copy.points(surface.f_plus).mean(axis=0) for copy in tiled.copies])
    apart = np.linalg.norm(middles[:, None] - middles, axis=2) + 1e3 * np.eye(9)
    assert apart.min() > 0.9 * np.linalg.norm(tiled.lattice, axis=1).min()


def test_pieces_go_on_by_reflection_as_before(whole_ring):
    """At right and sharp angles, and where a ring is not symmetric."""
    piece = between_mirrors(modules.node(3, 2.4, max_edge=0.4))
    assert translation_seams(piece.surface, complete(piece.surface, piece.sides).planes, 1e-2) is None
    _, surface, sides = whole_ring
    planes = complete(surface, sides).planes
    assert translation_seams(surface, planes, 1e-2) is not None
    assert translation_seams(surface, planes[:1], 1e-2) is None
