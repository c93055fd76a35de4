"""Boundary conditions: the normals they prescribe, and the input they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, Domain, conditions, shapes
from solver.domain.sites import SiteGraph
from solver.gauss.admissible import resolved
from solver.gauss.conditions import KINDS, build

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


@pytest.fixture
def strip():
    return shapes.strip(2.0, 1.0, 12)


@pytest.fixture
def disc():
    return shapes.disc(400)


def normals_of(condition, count):
    sites, normals = condition.resolve()
    full = np.full((count, 3), np.nan)
    full[sites] = normals
    return full


def test_outward_conormals_of_a_disc_are_its_radii(disc):
    condition = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)
    sites, normals = condition.resolve()
    assert_array_equal(sites, disc.domain.boundary_vertices)
    assert_allclose(normals[:, :2], disc.positions[sites], rtol=0, atol=1e-12)
    assert_allclose(normals[:, 2], 0, rtol=0, atol=1e-15)


def test_conormals_are_exact_on_a_circle_cut_into_unequal_edges():
    """Edges weigh as the inverse of their lengths; a plain mean would be first order only."""
    n = 32
    angle = 2 * np.pi * (np.arange(n) + 0.2 * (-1.0) ** np.arange(n)) / n
    points = np.vstack([np.column_stack([np.cos(angle), np.sin(angle)]), [[0, 0]]])
    domain = Domain.from_positions(points, [[k, (k + 1) % n, n] for k in range(n)])
    sites, normals = conditions.binormal(domain, points, domain.boundary_edges).resolve()
    assert_allclose(normals[:, :2], points[sites], rtol=0, atol=1e-12)


@pytest.mark.parametrize("tilt", [0.0, 0.3, -0.7, np.pi / 2])
def test_tilt_turns_from_the_conormal_to_the_surface_normal(disc, tilt):
    condition = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges, tilt=tilt)
    sites, normals = condition.resolve()
    assert_allclose(normals[:, :2], np.cos(tilt) * disc.positions[sites], rtol=0, atol=1e-12)
    assert_allclose(normals[:, 2], np.sin(tilt), rtol=0, atol=1e-12)


def test_binormals_turn_with_the_surface(disc):
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    flat = np.column_stack([disc.positions, np.zeros(len(disc.positions))])
    edges = disc.domain.boundary_edges
    one = conditions.binormal(disc.domain, flat, edges, tilt=0.4, against="surface")
    other = conditions.binormal(disc.domain, flat @ turn.T, edges, tilt=0.4, against="surface")
    assert_allclose(other.vertex_normals, one.vertex_normals @ turn.T, rtol=0, atol=1e-12)
    assert_allclose(other.up, turn @ one.up, rtol=0, atol=1e-12)


@pytest.mark.parametrize("m", [1, 2, 3])
def test_twisted_normals_are_those_of_figure_3(disc, m):
    """N = cos mθ (cos θ, sin θ, 0) + sin mθ e_z from the loop's first vertex, at θ = 0."""
    sites, normals = conditions.twisted(disc.domain, disc.positions, disc.domain.boundary_edges, m).resolve()
    x, y = disc.positions[sites].T
    theta = np.arctan2(y, x)
    expected = np.column_stack([np.cos(m * theta) * x, np.cos(m * theta) * y, np.sin(m * theta)])
    assert_allclose(normals, expected, rtol=0, atol=1e-12)


def test_gauss_map_of_a_sphere(disc):
    r2 = np.sum(disc.positions**2, axis=1, keepdims=True)
    cap = np.hstack([2 * disc.positions, 1 - r2]) / (1 + r2)
    sites, normals = conditions.gauss_map(disc.domain, cap, disc.domain.boundary_edges).resolve()
    assert np.abs(normals - cap[sites]).max() < 1.5 * disc.domain.edge_lengths.max()
    assert (normals[:, :2] * cap[sites, :2]).sum(axis=1).min() > 0.9


def test_one_normal_an_edge_is_blended_at_vertices(strip):
    edges = strip.sides["bottom"]
    normals = np.tile([0.0, -1.0, 0.0], (len(edges), 1))
    normals[1] = [0.0, 0.0, 2.0]
    full = normals_of(conditions.fixed(strip.domain, edges, normals), strip.domain.vertex_count)
    shared = np.intersect1d(strip.domain.edges[edges[0]], strip.domain.edges[edges[1]])[0]
    assert_allclose(full[shared], np.array([0, -1, 1]) / np.sqrt(2), rtol=0, atol=1e-15)


def test_edges_are_indices_or_vertex_pairs(strip):
    edges = strip.sides["top"]
    pairs = strip.domain.edges[edges][:, ::-1]
    one = conditions.fixed(strip.domain, edges, [0, 0, 1])
    other = conditions.fixed(strip.domain, pairs, [0, 0, 1])
    assert_array_equal(one.vertices, other.vertices)


def test_where_kinds_meet_fixed_normals_blend_and_win_over_free(strip):
    domain = strip.domain
    bottom, right = strip.sides["bottom"], strip.sides["right"]
    both = (
        conditions.fixed(domain, bottom, [0, -1, 0])
        + conditions.fixed(domain, right, [1, 0, 0])
        + conditions.free(domain, strip.sides["top"])
    )
    full = normals_of(both, domain.vertex_count)
    corner = np.intersect1d(domain.edges[bottom], domain.edges[right])[0]
    assert_allclose(full[corner], np.array([1, -1, 0]) / np.sqrt(2), rtol=0, atol=1e-15)
    top_corner = np.intersect1d(domain.edges[strip.sides["top"]], domain.edges[right])[0]
    assert_allclose(full[top_corner], [1, 0, 0], rtol=0, atol=1e-15)
    inside_top = np.setdiff1d(domain.edges[strip.sides["top"]], domain.edges[right])
    assert np.isnan(full[inside_top]).all()


def test_two_conditions_count_the_same_however_many_edges_they_have(strip):
    """A blend is the sum of the two vertex normals, not of all edge normals."""
    domain = strip.domain
    vertex = int(domain.edges[strip.sides["bottom"][3], 0])
    a = conditions.binormal(domain, strip.positions, strip.sides["bottom"])
    b = conditions.fixed_at(domain, [vertex], [0, 0, 5.0])
    full = normals_of(a + b, domain.vertex_count)
    assert_allclose(full[vertex], np.array([0, -1, 1]) / np.sqrt(2), rtol=0, atol=1e-12)


def test_opposite_normals_are_refused_by_vertex(strip):
    domain = strip.domain
    bottom = strip.sides["bottom"]
    condition = conditions.fixed(domain, bottom[:3], [0, 0, 1]) + conditions.fixed(domain, bottom[3:], [0, 0, -1])
    vertex = np.intersect1d(domain.edges[bottom[2]], domain.edges[bottom[3]])[0]
    with pytest.raises(ConditionError, match=f"vertex {vertex} ") as caught:
        condition.resolve()
    assert caught.value.vertices == (vertex,)


def test_opposite_edge_normals_within_a_condition_are_refused(strip):
    edges = strip.sides["bottom"][:2]
    vertex = np.intersect1d(*strip.domain.edges[edges])[0]
    with pytest.raises(ConditionError, match="opposite") as caught:
        conditions.fixed(strip.domain, edges, [[0, 0, 1], [0, 0, -1]])
    assert caught.value.vertices == (vertex,)


def test_edges_inside_are_refused(strip):
    inside = strip.domain.interior_edges[4]
    with pytest.raises(ConditionError, match=f"Edge {inside} is not on the boundary") as caught:
        conditions.fixed(strip.domain, [inside], [0, 0, 1])
    assert caught.value.edges == (inside,)
    pair = strip.domain.edges[inside]
    with pytest.raises(ConditionError, match=f"No boundary edge joins vertices {pair[0]}, {pair[1]}"):
        conditions.fixed(strip.domain, [pair], [0, 0, 1])


@pytest.mark.parametrize(
    "make",
    [
        lambda s: conditions.fixed(s.domain, [10**6], [0, 0, 1]),
        lambda s: conditions.fixed(s.domain, [0.5], [0, 0, 1]),
        lambda s: conditions.fixed(s.domain, s.sides["top"], [0, 0]),
        lambda s: conditions.fixed(s.domain, s.sides["top"], [0, 0, 0]),
        lambda s: conditions.fixed(s.domain, s.sides["top"], [0, np.nan, 0]),
        lambda s: conditions.fixed_at(s.domain, [-1], [0, 0, 1]),
        lambda s: conditions.binormal(s.domain, s.positions[1:], s.sides["top"]),
        lambda s: conditions.binormal(s.domain, s.positions, s.sides["top"], tilt=np.nan),
        lambda s: conditions.binormal(s.domain, 0 * s.positions, s.sides["top"]),
        lambda s: conditions.twisted(s.domain, s.positions, s.sides["top"], np.inf),
        lambda s: build("nosuch", s.domain, s.positions, s.sides["top"]),
        lambda s: build("binormal", s.domain, s.positions, s.sides["top"], m=1),
    ],
)
def test_bad_arguments_are_condition_errors(strip, make):
    with pytest.raises(ConditionError):
        make(strip)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_can_be_built_with_its_defaults(kind, disc):
    parameters = {p.name: p.default for p in KINDS[kind].parameters}
    condition = build(kind, disc.domain, disc.positions, disc.domain.boundary_edges, **parameters)
    if condition.is_spanned:
        assert len(condition.lines) + len(condition.leans) == len(disc.domain.boundary_edges)
        with pytest.raises(ConditionError, match=r"is spanned, not solved for normals; use form or span_outline"):
            resolved(condition, SiteGraph.of(disc.domain, "vertices"))
        return
    held = resolved(condition, SiteGraph.of(disc.domain, "vertices"))
    expected = 0 if kind == "free" else len(disc.domain.boundary_vertices)
    assert len(held.fixed) + len(held.mirrors.sites) == expected
    assert condition.is_empty == (kind == "free")


def test_no_edges_are_no_condition(strip):
    assert len(conditions.fixed(strip.domain, [], [0, 0, 1]).vertices) == 0


@pytest.mark.parametrize(
    "make",
    [
        lambda s: conditions.fixed(s.domain, s.sides["top"], "up"),
        lambda s: conditions.fixed_at(s.domain, [1.5], [0, 0, 1]),
        lambda s: conditions.binormal(s.domain, [[0, 1], [2]], s.sides["top"]),
        lambda s: conditions.binormal(s.domain, s.positions, s.sides["top"], tilt="steep"),
        lambda s: conditions.binormal(s.domain, s.positions * np.nan, s.sides["top"]),
    ],
)
def test_arrays_that_are_not_numbers_are_condition_errors(strip, make):
    with pytest.raises(ConditionError, match=r"must be|not finite"):
        make(strip)


@pytest.mark.parametrize("kind", KINDS)
def test_parameters_left_out_have_their_declared_defaults(kind, disc):
    parameters = {p.name: p.default for p in KINDS[kind].parameters}
    edges = disc.domain.boundary_edges
    graph = SiteGraph.of(disc.domain, "vertices")
    made = [build(kind, disc.domain, disc.positions, edges, **given) for given in ({}, parameters)]
    if made[0].is_spanned:
        for name in ("lines", "leans", "lean_angles"):
            assert_array_equal(getattr(made[0], name), getattr(made[1], name))
        return
    bare, full = (resolved(condition, graph) for condition in made)
    for name in ("fixed", "data"):
        assert_array_equal(getattr(bare, name), getattr(full, name))
    assert_array_equal(bare.mirrors.normals, full.mirrors.normals)
    if kind == "plane":
        assert_array_equal(full.data, np.tile([0.0, 0.0, 1.0], (len(full.fixed), 1)))
