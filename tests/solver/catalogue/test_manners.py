"""Ready-made surfaces and plans in a notebook: one line each, and whether they worked."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from solver import modules, ring, shapes, wente
from solver.catalogue import holed_plans


@pytest.fixture(scope="module")
def torus():
    return wente(2.0 * np.pi / 3.0, 8)


def test_a_bubble_is_one_line_and_says_whether_it_closed(torus):
    assert torus.ok and torus.closed
    assert repr(torus) == f"Bubble(120° between the ends, height {torus.height:.6g}, closed)"
    given = wente(2.0 * np.pi / 3.0, 8, height=0.9 * torus.height, closed=False)
    assert given.ok and repr(given).endswith("open)")
    coarse = wente(np.pi / 6.0, 4)
    assert not coarse.ok and "columns or more" in coarse.message


def test_a_ring_is_one_line():
    honeycomb = ring(2.4, max_edge=0.6)
    assert honeycomb.ok and "72 copies" in honeycomb.message
    assert repr(honeycomb).startswith("Ring(Domain(") and repr(honeycomb).endswith("converged)")
    assert len(repr(honeycomb)) < 160


def test_modules_and_plans_are_one_line():
    module = modules.capital(0.4, max_edge=0.1)
    assert repr(module) == f"Module({module.shape!r})" and "column" in repr(module)
    plan = holed_plans.annulus(10.0, 0.4, 0.0, 40)
    assert repr(plan).startswith("StartPlan('Annulus', Domain(") and repr(plan).endswith("sides: Outer, Inner)")


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_shapes_and_bubbles_can_be_copied(duplicate, torus):
    shape = shapes.disc(100)
    assert (duplicate(shape).positions == shape.positions).all()
    assert (duplicate(torus).surface.f_plus == torus.surface.f_plus).all()
