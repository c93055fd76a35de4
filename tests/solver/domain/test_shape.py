"""Shapes: a domain, positions and named sides, which serve wherever a domain is wanted."""

from __future__ import annotations

import numpy as np
import pytest

from solver import Domain, MeshError, conditions, shapes
from solver.domain.shape import Shape, as_domain
from tests.solver.domain.test_domain import TETRAHEDRON


def test_a_shape_serves_as_its_domain():
    shape = shapes.disc(100)
    assert isinstance(shape, shapes.Shape) and shapes.Shape is Shape
    assert as_domain(shape) is shape.domain
    assert as_domain(shape.domain) is shape.domain


def test_other_things_are_refused_by_name():
    with pytest.raises(MeshError, match=r"not ndarray; make one with Domain.from_positions"):
        as_domain(shapes.disc(100).positions)  # pyright: ignore[reportArgumentType]


def test_short_representations():
    assert repr(shapes.disc(271).domain) == "Domain(271 vertices, 486 triangles, 1 boundary loop)"
    assert repr(shapes.disc(271)) == "Shape(271 vertices, 486 triangles, 1 boundary loop; sides: outer)"
    closed = Domain.from_edge_lengths(TETRAHEDRON, [[1.0] * 3] * 4)
    assert repr(closed) == "Domain(4 vertices, 4 triangles, closed)"
    assert repr(shapes.torus(1.0, 1.0, 8)) == "Shape(80 vertices, 160 triangles, closed, genus 1; sides: none)"


def test_names_of_sides_come_as_any_array_of_strings():
    shape = shapes.disc(50)
    for names in (np.str_("outer"), np.array("outer"), np.array(["outer"]), np.array(["outer"], dtype=object)):
        assert len(conditions.fixed(shape, names, (0, 0, 1)).edges) == len(shape.sides["outer"])
