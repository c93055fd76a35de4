"""Periods closed by the boundary normals, by moduli of the domain, and by both."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, ConditionError, Domain, HarmonicSolver, conditions, shapes
from solver.design import close_periods, hole, tube
from solver.design.adjoint import Extension
from solver.design.closing import ClosingStatus
from solver.domain.topology import Homology
from solver.surface.periods import harmonic_forms


def ring(radius, centre=(0.0, 0.0)):
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + centre


def courtyard(edge):
    """A courtyard off the centre, whose tilts are unequal and slope."""
    shape = shapes.polygon(ring(1.2), holes=[ring(0.4, (0.25, 0.1))], max_edge=edge)
    sloped = []
    for side, tilt, axis in (("outer", 50, 0), ("hole0", 35, 1)):
        middles = shape.positions[shape.domain.edges[shape.sides[side]]].mean(axis=1)
        tilts = np.radians(tilt + 10 * middles[:, axis])
        sloped.append(conditions.binormal(shape.domain, shape.positions, shape.sides[side], tilts))
    return shape, sloped[0] + sloped[1]


WAYS = {
    "normals": lambda shape: {},
    "tilts": lambda shape: {"positions": shape.positions},
    "moduli": lambda shape: {"by": "moduli", "moduli": hole(shape.domain, shape.positions, 1)},
    "both": lambda shape: {"by": "both", "moduli": hole(shape.domain, shape.positions, 1)},
}


@pytest.mark.parametrize("way", WAYS)
def test_a_courtyard_closes_in_a_few_steps_on_every_mesh(way):
    found = []
    for edge in (0.16, 0.11):
        shape, rim = courtyard(edge)
        closing = close_periods(shape.domain, rim, **WAYS[way](shape))
        assert closing.closed and closing.gaps[0] > 0.1 and closing.gaps[-1] < 1e-8
        assert len(closing.gaps) <= 7 and closing.area_ratio > 0.9
        assert not closing.surface.is_open
        again = CmcSolver(closing.domain).solve(closing.conditions, tolerance=1e-11)
        assert np.abs(again.periods).max() < 1e-8
        found.append(closing)
    turned = [c.turned.max() for c in found]
    assert_allclose(turned[0], turned[1], rtol=0.1, atol=1e-9)
    assert_allclose(found[0].moduli, found[1].moduli, rtol=0.1, atol=2e-3)


def test_tilts_turn_about_the_tangent_of_the_boundary():
    shape, rim = courtyard(0.16)
    closing = close_periods(shape.domain, rim, positions=shape.positions)
    fixed, before = rim.resolve()
    _, after = closing.conditions.resolve()
    radial = shape.positions[fixed].copy()
    inner = np.isin(fixed, shape.domain.boundary_loops[1])
    radial[inner] -= [0.25, 0.1]
    along = np.column_stack([-radial[:, 1], radial[:, 0]]) / np.linalg.norm(radial, axis=1)[:, None]
    drift = np.abs(np.einsum("ij,ij->i", (after - before)[:, :2], along))
    assert closing.turned.max() > np.radians(5) and drift.max() < 0.01


def test_three_holes_close():
    holes = [ring(0.22, (0.45, 0.3)), ring(0.22, (-0.45, 0.25)), ring(0.22, (0.0, -0.5))]
    shape = shapes.polygon(ring(1.1), holes=holes, max_edge=0.11)
    edges = shape.sides
    rim = conditions.binormal(shape.domain, shape.positions, edges["outer"], 0.6)
    for k, tilt in enumerate((0.3, 0.5, 0.7)):
        rim = rim + conditions.binormal(shape.domain, shape.positions, edges[f"hole{k}"], tilt)
    closing = close_periods(shape.domain, rim)
    assert closing.closed and closing.surface.conjugate.periods.shape == (3, 3) and len(closing.gaps) <= 12
    assert closing.area_ratio > 0.5


def test_the_derivative_by_moduli_against_differences():
    shape, rim = courtyard(0.16)
    moduli = hole(shape.domain, shape.positions, 1, ("x", "y", "twist", "size"))
    q = np.array([0.01, -0.02, 0.05, 0.03])

    def state(q):
        extension = Extension(HarmonicSolver(moduli.domain(q)), rim)
        return extension, extension(extension.prescribed, tolerance=1e-12)

    extension, here = state(q)
    eta = harmonic_forms(Homology.of(extension.domain), extension.solver.dirichlet)

    def periods_by(extension, here, changed):
        return eta.T @ extension.tau_by_weights(here, changed)

    exact = [periods_by(extension, here, w) for w in moduli.weights(q).T]
    for k, change in enumerate(exact):
        step = 1e-4 * np.eye(4)[k]
        difference = (state(q + step)[1].periods - state(q - step)[1].periods) / 2e-4
        assert_allclose(change, difference, rtol=0, atol=1e-5 * np.abs(difference).max())


def unrolled(shape, circumference):
    corners = shape.positions[shape.domain.faces].copy()
    wrapped = np.ptp(corners[:, :, 0], axis=1) > 0.5 * circumference
    corners[wrapped, :, 0] += np.where(corners[wrapped, :, 0] < 0.5 * circumference, circumference, 0.0)
    return corners


def test_a_tube_that_is_stretched():
    shape = shapes.cylinder(2 * np.pi, 2.0, 16)
    corners = unrolled(shape, 2 * np.pi)
    every = np.arange(len(shape.domain.faces))
    longer = tube(shape.domain, corners, every, (0, 1)).domain(np.array([np.log(1.5)]))
    assert_allclose(longer.area, 1.5 * shape.domain.area, rtol=1e-12)
    lower = np.flatnonzero(corners[:, :, 1].mean(axis=1) < 1.0)
    half = tube(shape.domain, corners, lower, (0, 1)).domain(np.array([np.log(2.0)]))
    assert_allclose(half.area, 1.5 * shape.domain.area, rtol=1e-12)
    with pytest.raises(ConditionError, match="not orthogonal"):
        tube(shape.domain, corners, lower, (1, 1))


def test_what_cannot_close_ends_with_what_is_left():
    """One modulus does not close three components; a size that does not help ends the search."""
    shape, rim = courtyard(0.16)
    closing = close_periods(
        shape.domain, rim, by="moduli", moduli=hole(shape.domain, shape.positions, 1, ("size",)), max_steps=6
    )
    assert not closing.closed and closing.status in (ClosingStatus.RANK_DEFICIENT, ClosingStatus.STEP_LIMIT)
    assert closing.gaps[-1] > 1e-3 and closing.surface.is_open and "The gap was" in closing.message


def test_wrong_wishes_are_refused():
    shape, rim = courtyard(0.2)
    disc = shapes.disc(60)
    flat = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)
    for arguments, message in (
        ((disc.domain, flat), "neither holes nor handles"),
        ((shape.domain, rim, "moduli"), "needs moduli"),
        ((shape.domain, rim, "force"), "force"),
    ):
        with pytest.raises(ConditionError, match=message):
            close_periods(*arguments[:2], **({"by": arguments[2]} if len(arguments) > 2 else {}))
    with pytest.raises(ConditionError, match="motion 'up'"):
        hole(shape.domain, shape.positions, 1, ("up",))
    with pytest.raises(ConditionError, match="boundary loop 5"):
        hole(shape.domain, shape.positions, 5)


def test_progress_and_cancelling():
    shape, rim = courtyard(0.2)
    seen = []

    def progress(step, gap):
        seen.append(gap)
        return step < 1

    closing = close_periods(shape.domain, rim, progress=progress)
    assert closing.status is ClosingStatus.CANCELLED and seen == closing.gaps
    assert isinstance(closing.domain, Domain)
