"""Tilts blended along the boundary by a moving average."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import JobError, conditions, mean_curvature_of, shapes
from solver.gauss.frames import moving_average
from solver.shells.form import form
from solver.shells.plan import Group, Plan, Settings
from solver.shells.plan_conditions import plan_conditions


@pytest.fixture
def strip():
    return shapes.strip(4.0, 1.0, 40)


def middles(shape, edges):
    return shape.positions[shape.domain.edges[edges]].mean(axis=1)


def test_a_jump_becomes_a_ramp_of_the_given_width(strip):
    edges = strip.sides["bottom"]
    x = middles(strip, edges)[:, 0]
    averaged = moving_average(strip.domain, edges, np.where(x < 2.0, 0.0, 1.0), 1.0)
    assert_allclose(averaged, np.clip(x - 1.5, 0.0, 1.0), rtol=0, atol=1e-12)


def test_the_window_wraps_around_a_loop(strip):
    domain = shapes.disc(2000).domain
    edges = domain.boundary_loop_edges[0]
    values = np.where(np.arange(len(edges)) < len(edges) // 2, 0.0, 1.0)
    length = domain.edge_lengths[edges].sum()
    averaged = moving_average(domain, edges, values, length / 10)
    turned = moving_average(domain, edges, np.roll(values, 17), length / 10)
    assert_allclose(turned, np.roll(averaged, 17), rtol=0, atol=1e-12)
    assert_allclose(averaged.mean(), values.mean(), rtol=1e-12, atol=0)
    assert_allclose(moving_average(domain, edges, values, 3 * length), 0.5, rtol=0, atol=1e-12)


def test_constants_stay_and_zero_width_changes_nothing(strip):
    edges = strip.domain.boundary_edges
    values = np.random.default_rng(0).normal(size=len(edges))
    assert_array_equal(moving_average(strip.domain, edges, values, 0.0), values)
    assert_allclose(moving_average(strip.domain, edges, 0 * values + 0.3, 0.7), 0.3, rtol=0, atol=1e-12)
    assert_allclose(moving_average(strip.domain, edges, values, 1e-4), values, rtol=0, atol=1e-9)


def test_separate_runs_do_not_mix(strip):
    edges = np.concatenate([strip.sides["bottom"], strip.sides["top"]])
    values = np.where(middles(strip, edges)[:, 1] < 0.5, -1.0, 1.0)
    assert_allclose(moving_average(strip.domain, edges, values, 50.0), values, rtol=0, atol=1e-12)


def test_one_tilt_an_edge_is_the_tilt_at_its_vertices(strip):
    domain, edges = strip.domain, strip.sides["bottom"]
    tilts = 0.1 * middles(strip, edges)[:, 0]
    sites, normals = conditions.binormal(domain, strip.positions, edges, tilt=tilts).resolve()
    inner = (strip.positions[sites, 0] > 0.01) & (strip.positions[sites, 0] < 3.99)
    angle = np.arctan2(normals[:, 2], -normals[:, 1])
    assert_allclose(angle[inner], 0.1 * strip.positions[sites[inner], 0], rtol=0, atol=1e-12)


def test_blended_groups_make_a_smoother_shell():
    """Two halves of a disc, 0° and 40°: the jump is a spike of curvature, the ramp is not."""
    shape = shapes.disc(3000)
    domain = shape.domain
    points = np.column_stack([shape.positions, np.zeros(domain.vertex_count)])
    upper = domain.boundary_edges[middles(shape, domain.boundary_edges)[:, 1] > 0]
    group = Group("upper", domain.edges[upper], "binormal", {"tilt": np.radians(40)})
    plan = Plan(points, domain.faces, groups=[group])
    worst = []
    for blend in (0.0, 0.6):
        surface = form(plan, Settings(blend=blend)).surface
        H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
        worst.append(np.nanmax(np.abs(H - 0.5)))
    assert worst[1] < 0.25 * worst[0]


def test_blending_leaves_other_kinds_alone(strip):
    domain = strip.domain
    points = np.column_stack([strip.positions, np.zeros(domain.vertex_count)])
    plane = Group("top", domain.edges[strip.sides["top"]], "plane", {"normal": (0.0, 0.0, 1.0)})
    plan = Plan(points, domain.faces, groups=[plane])
    sites, normals = plan_conditions(plan, Settings(blend=1.0), domain).resolve()
    top = (strip.positions[sites, 1] > 0.99) & (np.abs(strip.positions[sites, 0] - 2) < 1.9)
    assert_allclose(normals[top], np.tile([0.0, 0.0, 1.0], (top.sum(), 1)), rtol=0, atol=1e-15)


def test_a_blend_below_zero_is_refused():
    with pytest.raises(JobError, match="blend"):
        Settings(blend=-1.0)
