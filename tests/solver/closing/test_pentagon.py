"""Figure 16 from the pentagon: no mirrors between its tubes, a saddle, closed over the length of the outer one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, HarmonicSolver, MeshError, modes_of, side_plane
from solver.catalogue import modules
from solver.closing.close import ClosingStatus
from tests.solver.closing_plans import LENGTH, neck, necks, pentagon, spoke_of
from tests.solver.fundamental_pieces import between_mirrors


def test_the_pentagon_closes_over_the_length_of_its_spoke():
    """From a spoke an eighth too long to that of the honeycomb, with its necks; the map is a saddle on the way."""
    plan = pentagon(1.125 * LENGTH, max_edge=0.14)
    closing = plan.close()
    assert closing.closed and closing.gaps[0] > 0.01 and closing.gaps[-1] < 1e-10 and len(closing.gaps) <= 9
    assert_allclose(spoke_of(closing, plan), LENGTH, rtol=2e-3)
    assert modes_of(HarmonicSolver(closing.domain), closing.conditions, closing.surface.normals).index == 1
    inner, outer = (side_plane(closing.surface, side) for side in plan.floors)
    assert abs(inner.offset - outer.offset) < 1e-8
    quadrilateral = modules.node(3, LENGTH, max_edge=0.13)
    piece = between_mirrors(quadrilateral)
    radius = neck(piece.surface, quadrilateral.shape.sides["end"], np.array([1.0, 0.0, 0.0]))
    assert_allclose(necks(closing, plan), radius, rtol=0, atol=3e-3)
    assert_allclose(closing.surface.harmonic.energy, 3 * piece.surface.harmonic.energy, rtol=3e-3, atol=0)


def test_minimising_slides_away_from_it():
    """Newton's method with conjugate gradients leaves the saddle for something with less energy, or none."""
    plan = pentagon(1.125 * LENGTH, max_edge=0.2)
    assert plan.close(method="critical").surface.harmonic.energy > plan.close(method="newton").surface.harmonic.energy


def test_without_a_map_to_begin_with_closing_says_so():
    """Spokes shorter than a fold of the family have none."""
    closing = pentagon(0.9 * LENGTH, max_edge=0.25).close()
    assert closing.status is ClosingStatus.LOST and not closing.closed
    assert "No harmonic map was found to begin with" in closing.message


def test_moduli_do_not_pass_the_fold():
    """From far off Newton's steps are cut short where there is no map."""
    closing = pentagon(1.2 * LENGTH, max_edge=0.2).close()
    assert closing.closed and closing.surface.harmonic.residual < 1e-10


def test_an_unknown_method_is_refused():
    plan = pentagon(LENGTH, max_edge=0.3)
    with pytest.raises(ConditionError, match='There is no method "steepest"'):
        plan.close(method="steepest")


@pytest.mark.parametrize("spoke", [1.0, -1.0, np.nan])
def test_spokes_that_do_not_fit_are_refused(spoke):
    with pytest.raises(MeshError, match="must be"):
        modules.pentagon(LENGTH, spoke, max_edge=0.2)
