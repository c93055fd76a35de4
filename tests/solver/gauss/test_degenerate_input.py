"""Conditions from degenerate numbers: refused by a sentence that names the offender, or taken as they are meant."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, conditions, shapes

STRIP = shapes.strip(2, 1, 8)
TOP = STRIP.sides["top"]
FLAT = np.column_stack([STRIP.positions, np.zeros(len(STRIP.positions))])
EVERY = STRIP.domain.boundary_edges
FIRST = f"edge {TOP[0]}"


@pytest.mark.parametrize(("make", "message"), [
    (lambda: conditions.binormal(STRIP, "top", tilt=np.nan), "The tilt is nan; it must be a finite angle"),
    (lambda: conditions.binormal(STRIP, "top", tilt=[np.inf] + 7 * [0.1]), f"The tilt of {FIRST} is inf"),
    (lambda: conditions.binormal(STRIP, "top", tilt=[0.1, 0.2]), "one angle, or 8 of them, .* not an array (2,)"),
    (lambda: conditions.binormal(STRIP, "top", tilt=-1e9), "more than half a turn"),
    (lambda: conditions.twisted(STRIP, "top", m=13), "13 turns are too many for a loop of 24 edges, which shows 12"),
    (lambda: conditions.mirror(STRIP, "top", (0, np.inf, 0)), f"{FIRST} has a normal that is zero or not finite"),
    (lambda: conditions.mirror(STRIP, "top", (0, 0, 0)), f"{FIRST} has a normal that is zero or not finite"),
    (lambda: conditions.fixed(STRIP, "top", [[0, 0, 1]] * 7 + [[0, 0, 0]]), f"edge {TOP[7]} has a normal that is zero"),
    (lambda: conditions.fixed(STRIP, "top", np.ones((7, 3))), "shape (3,) or (8, 3), one for each edge, not (7, 3)"),
    (lambda: conditions.fixed_at(STRIP, [0], (np.nan, 0, 0)), "Vertex 0 has a normal that is zero or not finite"),
    (lambda: conditions.fixed_at(STRIP, np.array([2**63 + 5], dtype=np.uint64), (1, 0, 0)), f"no vertex {2**63 + 5}"),
    (lambda: conditions.binormal(STRIP, FLAT, [[0, 1], [2]]), "Edges must be"),
    (lambda: conditions.twisted(STRIP.domain, 0 * FLAT, EVERY, 1), "has no length in these positions"),
])  # fmt: skip
def test_degenerate_numbers_are_refused(make, message):
    with pytest.raises(ConditionError, match="(?i)" + re.escape(message).replace(r"\.\*", ".*")):
        make()


@pytest.mark.parametrize("length", [1e-25, 1.0, 1e25])
def test_the_upward_direction_may_have_any_length(length):
    given, exact = (conditions.binormal(STRIP, "top", tilt=0.3, up=(0.0, k, k)) for k in (length, 1.0))
    assert_allclose(given.vertex_normals, exact.vertex_normals, rtol=0, atol=1e-15)


def test_far_and_tiny_plans_have_the_normals_of_the_plan():
    exact = conditions.binormal(STRIP.domain, FLAT, EVERY, 0.3).vertex_normals
    for scale, shift in ((1e-20, 0.0), (1e20, 0.0), (1.0, 1e6)):
        made = conditions.binormal(STRIP.domain, scale * FLAT + shift, EVERY, 0.3).vertex_normals
        assert_allclose(made, exact, rtol=0, atol=1e-8)


def test_the_most_turns_that_a_loop_shows():
    assert len(conditions.twisted(STRIP, "outer", m=12).edges) == 24
