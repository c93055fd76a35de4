"""The Hopf differential on exact surfaces, its zeros, and where there are no curvature lines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Domain, MeshError, shapes, solve_cmc, span_outline
from solver.gauss import conditions
from solver.nets.cut import cut_domain
from solver.nets.hopf import (
    HopfDifferential,
    _vertex_orders,
    corner_turns,
    hopf_differential,
)
from solver.nets.isothermic import Isothermic
from solver.nets.sheets import Sheet, layout, sheet_of
from tests.solver.exact_surfaces import disc, hemisphere, rates
from tests.solver.nets import exact_sheets as exact

# Q dz² of each surface in its parameters; the largest error of Q, relative and L², and of directions in degrees, at 64.
SURFACES = {
    "nodoid": (lambda n: exact.nodoid(n), -0.5, 3e-3, 0.03),
    "unduloid": (lambda n: exact.unduloid(n), 0.6, 3e-3, 0.03),
    "catenoid": (lambda n: exact.catenoid(n), 2.0, 1e-3, 0.003),
    "Enneper": (lambda n: exact.enneper(n * n // 2), 4.0, 1e-3, 0.003),
}


def errors(sheet: Sheet, corners: np.ndarray, Q: float) -> tuple[float, float, float]:
    """Relative L² errors of measured and denoised Q, and the angle between directions, root mean square in degrees."""
    hopf = hopf_differential(sheet)
    areas = sheet.domain.face_areas / sheet.domain.area
    measured, q = (exact.in_parameters(one, corners) for one in (hopf.measured, hopf.at_faces))
    off = [float(np.sqrt(areas @ np.abs(one - Q) ** 2)) / abs(Q) for one in (measured, q)]
    return *off, float(np.degrees(np.sqrt(areas @ (0.5 * np.angle(q / Q)) ** 2)))


@pytest.mark.parametrize("name", SURFACES)
def test_q_of_exact_surfaces(name):
    make, Q, most, angle = SURFACES[name]
    coarse, fine = (errors(*make(n), Q) for n in (32, 64))
    assert fine[1] < most
    assert fine[2] < angle
    assert rates([coarse[1], fine[1]])[0] > 1.3
    assert fine[1] < 0.95 * fine[0]


def test_denoising_of_a_jittered_surface():
    raw, denoised, _ = errors(*exact.nodoid(64), -0.5)
    assert denoised < 0.15 * raw


def test_the_twin_has_the_same_differential_and_the_less_noisy_one_is_taken():
    (plus, corners), (minus, _) = exact.nodoid(48), exact.nodoid(48, -1)
    alone = [errors(sheet, corners, -0.5) for sheet in (plus, minus)]
    assert alone[1][1] < 0.02 and alone[1][0] > 3.0 * alone[0][0]
    pair = tuple((one.points, one.normals) for one in (minus, plus))
    assert errors(replace(minus, pair=pair), corners, -0.5) == alone[0]


def test_q_is_the_difference_of_the_curvatures():
    sheet, _ = exact.catenoid(64)
    s = sheet.points[sheet.domain.faces, 2].mean(axis=1)
    difference = np.abs(hopf_differential(sheet).at_faces) / sheet.metric
    assert_allclose(difference, 2.0 / np.cosh(s) ** 2, rtol=0.04)
    assert np.average(difference * np.cosh(s) ** 2, weights=sheet.domain.face_areas) == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize("columns", [48, 96])
def test_the_period_of_w_around_a_nodoid(columns):
    sheet, _ = exact.nodoid(columns)
    w = Isothermic.of(cut_domain(hopf_differential(sheet)))
    jump = w.unknowns[sheet.domain.vertex_count :]
    assert np.abs(jump).max() == pytest.approx(2.0 * np.pi * np.sqrt(0.5), rel=4.0 / columns**2)
    assert np.abs(jump).min() < 1e-4


PLANS = {
    "square": (shapes.polygon([[0, 0], [1, 0], [1, 1], [0, 1]], max_edge=0.07, corner_radius=0.2), 2),
    "L": (shapes.polygon([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], max_edge=0.1, corner_radius=0.2), 3),
    "courtyard": (
        shapes.polygon(
            [[0, 0], [4, 0], [4, 4], [0, 4]], [[[1, 1], [2, 1], [2, 2], [1, 2]]], max_edge=0.25, corner_radius=0.3
        ),
        4,
    ),
}


def of_span(name: str) -> HopfDifferential:
    plan, _ = PLANS[name]
    return hopf_differential(sheet_of(span_outline(plan, plan.positions, mean_curvature=0.25), "f+"))


@pytest.mark.parametrize("name", PLANS)
def test_zeros_are_counted_by_the_boundary(name):
    hopf = of_span(name)
    assert (hopf.orders > 0).all()
    assert hopf.orders.sum() == hopf.boundary_winding - 2 * hopf.domain.euler_characteristic
    assert hopf.orders.sum() == PLANS[name][1]


def test_zeros_do_not_depend_on_the_layout_of_faces():
    hopf = of_span("square")
    domain = hopf.domain
    turned = np.roll(domain.faces, 1, axis=1)
    again = Domain.from_edge_lengths(turned, np.roll(domain.side_lengths, 1, axis=1))
    span = span_outline(PLANS["square"][0], PLANS["square"][0].positions, mean_curvature=0.25)
    other = hopf_differential(Sheet(again, span.points, span.normals, 0.25))
    assert_allclose(other.zeros, hopf.zeros)
    assert_allclose(np.abs(other.at_faces), np.abs(hopf.at_faces), rtol=1e-6)


@pytest.mark.parametrize("n", [200, 1500])
def test_spheres_have_no_curvature_lines(n):
    domain, points = disc(n)
    N = hemisphere(points)
    with pytest.raises(ConditionError, match="a part of a sphere"):
        hopf_differential(Sheet(domain, N, N, 1.0))
    plan = shapes.disc(n)
    cap = span_outline(plan, plan.positions, mean_curvature=0.5)
    with pytest.raises(ConditionError, match="a part of a sphere"):
        hopf_differential(sheet_of(cap, "f+"))


def test_planes_have_none_either():
    plan = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.5)
    with pytest.raises(ConditionError, match="a part of a plane"):
        hopf_differential(sheet_of(span_outline(plan, plan.positions), "f+"))


def test_a_degenerate_sheet_is_refused():
    plan = shapes.disc(300)
    dome = solve_cmc(plan, conditions.binormal(plan, "outer", tilt=0.4))
    with pytest.raises(ConditionError, match="f- of this surface is a point"):
        sheet_of(dome, "f-")


def test_handles_and_closed_surfaces_are_refused():
    torus = shapes.torus(1.0, 1.0, 12)
    flat = np.zeros((torus.domain.vertex_count, 3))
    with pytest.raises(MeshError, match="a handle"):
        hopf_differential(Sheet(torus.domain, flat, flat + [0, 0, 1], 0.5))
    ball = shapes.sphere(100)
    with pytest.raises(MeshError, match="closed"):
        hopf_differential(Sheet(ball.domain, ball.positions, ball.positions, 1.0))


def test_zeros_on_a_curved_domain():
    """Edge lengths in space give angle defects, which orders and the boundary's turn must take into account."""
    plan, count = PLANS["L"]
    span = span_outline(plan, plan.positions, mean_curvature=0.25)
    curved = Domain.from_positions(span.points, span.faces)
    hopf = hopf_differential(Sheet(curved, span.points, span.normals, 0.25))
    assert hopf.orders.sum() == count == hopf.boundary_winding - 2


def test_a_zero_of_order_four_on_the_sphere():
    """z⁴ dz² in the stereographic parameter, on the sphere without its south pole."""
    ball = shapes.sphere(2000)
    upper = ball.positions[:, 2] > -0.9
    used, faces = np.unique(ball.domain.faces[upper[ball.domain.faces].all(axis=1)], return_inverse=True)
    points = ball.positions[used]
    cap = Domain.from_positions(points, faces.reshape(-1, 3))
    z = (points[:, 0] + 1j * points[:, 1]) / (1.0 + points[:, 2])
    corner = z[cap.faces]
    sides = layout(cap)
    slope = (corner[:, 1] - corner[:, 0]) / (sides[:, 1] - sides[:, 0])
    q = corner.mean(axis=1) ** 4 * slope**2
    orders = _vertex_orders(cap, q)
    assert orders.sum() == 4
    assert np.abs(z[orders != 0]).max() < 0.1


def test_orders_at_a_cone():
    """The top of an octahedron has the angle defect 2π/3; a field that is constant in its frame has no zero there."""
    corners = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]]
    top = Domain.from_positions(corners, [[i, (i + 1) % 4, 4] for i in range(4)])
    q = np.exp(2j * corner_turns(top)[:, 2])
    assert not _vertex_orders(top, q).any()
    around = np.exp(1j * np.arctan2(*top_directions(top)[::-1]))
    assert _vertex_orders(top, q * around)[4] == 1


def top_directions(top: Domain) -> np.ndarray:
    """x and y (2, F) of the middles of the faces around the top, seen from above."""
    square = np.array([[1, 0], [0, 1], [-1, 0], [0, -1], [0, 0]], dtype=float)
    return square[top.faces].mean(axis=1).T
