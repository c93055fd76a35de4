"""Unit cells with clean ends: what is missing at the rim of a patch are whole ends of tubes, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import complete
from solver.catalogue import modules
from tests.solver import fundamental_pieces as pieces


def open_sides(whole) -> set[str]:
    """Names of the sides across which some copy has no neighbour."""
    return {whole.seams[j].name for j in np.flatnonzero((whole.neighbours < 0).any(axis=0))}


@pytest.mark.parametrize("tubes", [3, 4, 6])
def test_a_unit_of_a_lattice_of_tubes_is_cut_through_their_necks(tubes):
    length = {3: 2.2, 4: 2.6, 6: 3.8}[tubes]
    piece = pieces.between_mirrors(modules.node(tubes, length, max_edge=0.3))
    one = complete(piece.surface, piece.sides)
    assert open_sides(one) == {"end"}
    assert open_sides(complete(piece.surface, piece.sides, repeat=2)) == {"end"}


def test_the_first_copy_is_the_piece_itself_and_no_class_is_lost():
    piece = pieces.between_mirrors(modules.node(3, 2.2, max_edge=0.3))
    one = complete(piece.surface, piece.sides)
    assert_array_equal(one.copies[0].matrix, np.eye(4))
    turns = {tuple(np.round(copy.linear, 6).ravel() + 0.0) for copy in one.copies}
    assert len(turns) == len(one.copies) == 24
    patch = complete(piece.surface, piece.sides, repeat=3)
    assert len(patch.copies) == 9 * len(one.copies)
    everywhere = complete(piece.surface, piece.sides, copies=600)
    known = np.array([copy.translation for copy in everywhere.copies])
    for copy in one.copies:
        same = np.array([np.allclose(copy.linear, other.linear, atol=1e-6) for other in everywhere.copies])
        assert_allclose(np.linalg.norm(known[same] - copy.translation, axis=1).min(), 0.0, atol=1e-6)
