"""Shapes: sizes, sides and numbering are as their docstrings say, and their triangles are good."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import MeshError, shapes
from solver.catalogue.shapes import Shape

OUTLINE = [(0, 0), (4, 0), (4, 3), (0, 3)]
HOLE = [(1, 1), (1, 2), (2, 2), (2, 1)]

SHAPES = {
    "disc": (lambda: shapes.disc(2000), 44, 1, np.pi, 3e-3),
    "smallest disc": (lambda: shapes.disc(7), 59.9, 1, 1.5 * np.sqrt(3), 1e-12),
    "annulus": (lambda: shapes.annulus(0.3, 1.0, 3000), 36, 0, np.pi * 0.91, 3e-3),
    "wide annulus": (lambda: shapes.annulus(0.05, 1.0, 3000), 36, 0, np.pi * 0.9975, 3e-3),
    "narrow annulus": (lambda: shapes.annulus(0.9, 1.0, 3000), 34, 0, np.pi * 0.19, 3e-3),
    "strip": (lambda: shapes.strip(3.0, 1.0, 20), 29.9, 1, 3.0, 1e-12),
    "rectangle": (lambda: shapes.rectangle(1.0, 2.0, 30), 29.9, 1, 2.0, 1e-12),
    "cylinder": (lambda: shapes.cylinder(2 * np.pi, 3.3, 32), 58, 0, 6.6 * np.pi, 1e-12),
    "torus": (lambda: shapes.torus(2.0, 1.0, 32), 58, 0, 2.0, 1e-12),
    "sphere": (lambda: shapes.sphere(2000), 53, 2, 4 * np.pi, 3e-3),
    "polygon": (lambda: shapes.polygon(OUTLINE, [HOLE], max_edge=0.2), 34, 0, 11.0, 1e-12),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_what_they_say(name):
    make, angle, euler, area, tolerance = SHAPES[name]
    shape = make()
    domain = shape.domain
    assert np.degrees(domain.corner_angles.min()) > angle
    assert domain.euler_characteristic == euler
    assert_allclose(domain.area, area, rtol=tolerance)
    assert len(shape.positions) == domain.vertex_count
    named = np.unique(np.concatenate([*shape.sides.values(), np.zeros(0, dtype=int)]))
    assert_array_equal(named, domain.boundary_edges)


@pytest.mark.parametrize("name", SHAPES)
def test_sides_run_along_their_loops(name):
    shape = SHAPES[name][0]()
    for side in shape.sides.values():
        edges = shape.domain.edges[side]
        if len(np.unique(edges)) == len(edges):  # a whole loop
            assert_array_equal(edges[:, 1], np.roll(edges[:, 0], -1))
        else:
            assert_array_equal(edges[:-1, 1], edges[1:, 0])


@pytest.mark.parametrize("n", [7, 100, 2000, 8000])
def test_discs_have_about_the_vertices_asked_for(n):
    shape = shapes.disc(n)
    assert abs(shape.domain.vertex_count - n) < 2 * np.sqrt(3 * n)
    assert_array_equal(shape.positions[0], [1.0, 0.0])
    loop = shape.domain.boundary_loops[0]
    assert_array_equal(loop, np.arange(len(loop)))
    angle = 2 * np.pi * np.arange(len(loop)) / len(loop)
    assert_allclose(shape.positions[loop], np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-14)
    assert_array_equal(shape.positions[-1], [0.0, 0.0])


def test_the_edges_of_a_disc_are_about_equal():
    lengths = shapes.disc(8000).domain.edge_lengths
    assert lengths.max() / lengths.min() < 1.45


def test_annulus_loops_start_at_angle_zero():
    shape = shapes.annulus(0.5, 2.0, 1500)
    assert abs(shape.domain.vertex_count - 1500) < 15
    outer, inner = (shape.domain.edges[shape.sides[name]][:, 0] for name in ("outer", "inner"))
    assert_allclose(shape.positions[[outer[0], inner[0]]], [[2.0, 0.0], [0.5, 0.0]], atol=1e-12)
    assert_allclose(np.linalg.norm(shape.positions[inner], axis=1), 0.5, rtol=1e-12)


def test_cylinder_is_unrolled_and_glued():
    shape = shapes.cylinder(2 * np.pi, 3.3, 32)
    x, y = shape.positions.T
    assert x.min() == 0 and x.max() < 2 * np.pi
    for name, height in (("bottom", 0.0), ("top", 3.3)):
        side = shape.domain.edges[shape.sides[name]]
        assert_allclose(y[side], height, rtol=1e-12)
        assert_allclose(x[side[0, 0]], 0, atol=1e-12)
        assert_allclose(shape.domain.edge_lengths[shape.sides[name]], 2 * np.pi / 32, rtol=1e-12)
    assert_allclose(shape.domain.edge_lengths.max(), shape.domain.edge_lengths.min(), rtol=0.03)


def test_strip_has_its_four_sides():
    shape = shapes.strip(3.0, 1.0, 12)
    places = {"bottom": (1, 0.0), "right": (0, 3.0), "top": (1, 1.0), "left": (0, 0.0)}
    for name, (axis, value) in places.items():
        assert_allclose(shape.positions[shape.domain.edges[shape.sides[name]]][:, :, axis], value, atol=1e-12)
    assert_array_equal(np.sort(np.concatenate([shape.sides[k] for k in places])), np.sort(shape.sides["outer"]))
    assert_array_equal(shape.positions[0], [0.0, 0.0])


def test_sphere_is_round_and_outward():
    shape = shapes.sphere(600)
    assert_allclose(np.linalg.norm(shape.positions, axis=1), 1.0, rtol=1e-12)
    a, b, c = shape.positions[shape.domain.faces].transpose(1, 0, 2)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > 0).all()


def test_polygon_names_segments_as_drawn():
    shape = shapes.polygon(OUTLINE, [HOLE], max_edge=0.25)
    assert set(shape.sides) == {
        "outer",
        "hole0",
        *(f"side{k}" for k in range(4)),
        *(f"hole0.side{k}" for k in range(4)),
    }

    def middle(name: str) -> np.ndarray:
        return shape.positions[shape.domain.edges[shape.sides[name]]].mean(axis=(0, 1))

    for k in range(4):
        assert_allclose(middle(f"side{k}"), (np.array(OUTLINE[k]) + OUTLINE[(k + 1) % 4]) / 2, atol=1e-12)
        assert_allclose(middle(f"hole0.side{k}"), (np.array(HOLE[k]) + HOLE[(k + 1) % 4]) / 2, atol=1e-12)


def test_polygon_has_a_thousand_vertices_by_default():
    assert 800 < shapes.polygon(OUTLINE).domain.vertex_count < 1300
    assert 800 < shapes.polygon(np.array(OUTLINE) * 1e4).domain.vertex_count < 1300


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: shapes.disc(3), "A disc needs from 7 to 1,000,000 vertices, not 3"),
        (lambda: shapes.annulus(2.0, 1.0, 100), "0 < inner < outer; its radii are 2.0 and 1.0"),
        (lambda: shapes.annulus(1.0, 2.0, 5), "An annulus needs from 18 to 1,000,000 vertices"),
        (lambda: shapes.cylinder(1.0, -1.0, 8), "A cylinder needs two positive lengths"),
        (lambda: shapes.cylinder(1.0, 1.0, 2), "A cylinder needs from 3 to 1,000,000 columns"),
        (lambda: shapes.strip(np.nan, 1.0, 2), "A strip needs two positive lengths"),
        (lambda: shapes.torus(1.0, 0.0, 8), "A torus needs two positive lengths"),
        (lambda: shapes.sphere(4), "A sphere needs from 12 to 1,000,000 vertices"),
        (lambda: shapes.polygon([(0, 0), (1, 1)]), "has 2 points"),
        (lambda: shapes.polygon([(0, 0), (1, 1), (0, 1), (1, 0)]), "crosses or touches itself"),
        (lambda: shapes.polygon("plan"), "not numbers"),
    ],
)
def test_bad_shapes_are_refused(make, message):
    with pytest.raises(MeshError, match=message):
        make()


def test_a_shape_is_plain_data():
    shape = shapes.disc(50)
    assert isinstance(shape, Shape)
    with pytest.raises(AttributeError):
        shape.positions = np.zeros((1, 2))  # pyright: ignore[reportAttributeAccessIssue]
